// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace selvedge {

/// What a reader expects of a file, for its messages and limits.
struct FileRules {
  const char* what = "file";                             ///< such as "scene file"
  std::uintmax_t most_bytes = std::uintmax_t{64} << 20;  ///< a larger file is refused
  /// Also read from an open descriptor that is a pipe: /dev/stdin, /dev/fd/N (process
  /// substitution).
  bool pipes = false;
};

/// Accepts only a file with an end: refuses a missing file, a folder, a device, a socket, a named
/// pipe.
/// Every reader calls this before it opens a file that a user or another file names: reading
/// /dev/zero never ends, and opening a named pipe waits for a writer. Throws std::invalid_argument
/// with one sentence: file, fault, remedy.
void require_file(const std::filesystem::path& file, const FileRules& rules);

/// The bytes of a file. Throws std::invalid_argument like require_file, and if the file cannot be
/// opened or read or is larger than the limit.
std::string read_whole_file(const std::filesystem::path& file, const FileRules& rules);

/// The bytes of a file that may be missing or damaged: "" where read_whole_file would throw.
std::string read_if_there(const std::filesystem::path& file, const FileRules& rules = {});

}  // namespace selvedge
