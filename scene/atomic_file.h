// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

namespace selvedge {

/// A file that appears under its name only when it is complete: bytes go to NAME.partial beside it,
/// commit() renames. Without commit() the destructor removes what was written. A target that exists
/// and is no regular file (a pipe, a device) is written directly. Every failure throws
/// std::runtime_error with file and cause.
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
  [[noreturn]] void fail(const char* what);

  std::filesystem::path file_, partial_;
  std::vector<std::byte> buffer_;
  int descriptor_ = -1;
  bool committed_ = false;
};

}  // namespace selvedge
