// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/system/internal/files.h>

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace selvedge::detail {

/// Bytes on disk for a file whose beginning depends on its end. The file has no name, so it
/// vanishes with this object or with the process. Every function throws std::system_error that
/// names the folder if the bytes cannot be written or read.
class SpoolFile {
 public:
  explicit SpoolFile(const std::filesystem::path& folder);

  void append(const void* bytes, std::size_t count);
  void append(std::string_view text) { append(text.data(), text.size()); }
  std::size_t size() const { return size_; }
  /// Writes all bytes so far to `out`.
  void copy_to(AtomicFile& out) const;

 private:
  OpenFile file_;
  std::size_t size_ = 0;
};

}  // namespace selvedge::detail
