// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/libraries.h>

#include <dlfcn.h>

#include <stdexcept>
#include <string>
#include <system_error>

namespace selvedge {
namespace {

[[noreturn]] void fail(const char* name) {
  const char* why = dlerror();
  throw std::runtime_error(why ? why : name);
}

}  // namespace

LoadedLibrary::LoadedLibrary(const char* name) : library_(dlopen(name, RTLD_NOW | RTLD_LOCAL)) {
  if (!library_) fail(name);
}

void* LoadedLibrary::address_of(const char* name) const {
  void* address = dlsym(library_, name);
  if (!address) fail(name);
  return address;
}

std::filesystem::path file_of_code(const void* code) {
  Dl_info found{};
  return dladdr(code, &found) != 0 && found.dli_fname ? found.dli_fname : "";
}

std::filesystem::path running_program() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error);
}

}  // namespace selvedge
