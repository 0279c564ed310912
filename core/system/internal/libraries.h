// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace selvedge {

/// A library that is loaded while the program runs, and stays loaded.
class LoadedLibrary {
 public:
  /// `name` is that of a file in the search path of the system, such as libOSMesa.so.8. Throws
  /// std::runtime_error with the system's message.
  explicit LoadedLibrary(const char* name);

  /// Sets `function` to the function of this name. Throws std::runtime_error if there is none.
  template <class Function>
  void find(const char* name, Function*& function) const {
    function = reinterpret_cast<Function*>(address_of(name));
  }

 private:
  void* address_of(const char* name) const;

  void* library_;
};

/// The file of the library or program that contains this code; empty where the system does not
/// tell.
std::filesystem::path file_of_code(const void* code);

/// The file of the running program; empty where the system does not tell.
std::filesystem::path running_program();

}  // namespace selvedge
