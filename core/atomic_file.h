// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

namespace selvedge {

/// A file that appears under its name only when it is complete: bytes go to a file beside it whose
/// name ends in .partial and the number of the process, so that two processes that write one file
/// do not mix; commit() renames. Without commit() the destructor removes what was written. A target
/// that exists and is no regular file (a pipe, a device) is written directly. Every failure throws
/// std::system_error whose message names the file and whose code is the cause.
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
