// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

namespace selvedge {

/// Writes a file that appears under its final name only once it is complete. Bytes go to a
/// temporary file in the same folder, whose name ends in `.partial` and the process id, so two
/// processes that write the same file do not interfere. commit() renames it; without commit() the
/// destructor deletes it. An existing target that is not a regular file (a pipe, a device) is
/// written directly. Every failure throws std::system_error, whose message names the file and whose
/// code is the cause.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path file);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* bytes, std::size_t count);
  void write(std::string_view text) { write(text.data(), text.size()); }
  void commit();

 private:
  void flush();
  void write_through(const std::byte* begin, std::size_t count);
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path file_, partial_;
  std::vector<std::byte> buffer_;
  int descriptor_ = -1;
  bool committed_ = false;
};

}  // namespace selvedge
