// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/read_file.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <system_error>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_file(const fs::path& file, const std::string& fault) {
  throw std::invalid_argument(file.string() + ": " + fault);
}

/// A name of a descriptor that this process has open already. To open it again does not wait for a
/// writer, as it would for a named pipe.
bool is_open_descriptor(const fs::path& file) {
  const fs::path folder = file.parent_path();
  return file == "/dev/stdin" || folder == "/dev/fd" || folder == "/proc/self/fd";
}

std::string size_text(std::uintmax_t bytes) {
  return bytes >> 30 > 0 ? std::to_string(bytes >> 30) + " GiB"
                         : std::to_string(bytes >> 20) + " MiB";
}

}  // namespace

void require_file(const fs::path& file, const FileRules& rules) {
  const std::string what = rules.what;
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  switch (status.type()) {
    case fs::file_type::regular:
      return;
    case fs::file_type::not_found:
      refuse_file(file, "no such file; check the name of the " + what);
    case fs::file_type::directory:
      refuse_file(file, "is a folder, not a " + what);
    case fs::file_type::none:
      refuse_file(file, "cannot be opened: " + error.message());
    case fs::file_type::fifo:
      if (rules.pipes && is_open_descriptor(file)) return;
      break;
    default:
      break;
  }
  refuse_file(file, "is not a regular file; save the " + what + " to a file first");
}

std::string read_whole_file(const fs::path& file, const FileRules& rules) {
  require_file(file, rules);
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse_file(file, "cannot be opened; check its permissions");
  constexpr std::size_t chunk = std::size_t{1} << 16;
  std::error_code no_size;  // of a pipe, or of a file of /proc
  const std::uintmax_t size = fs::file_size(file, no_size);
  std::string bytes;
  if (!no_size) bytes.reserve(static_cast<std::size_t>(std::min(size, rules.most_bytes)) + chunk);
  while (in && bytes.size() <= rules.most_bytes) {
    const std::size_t before = bytes.size();
    bytes.resize(before + chunk);
    in.read(bytes.data() + before, static_cast<std::streamsize>(chunk));
    bytes.resize(before + static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) refuse_file(file, "cannot be read to its end");
  if (bytes.size() > rules.most_bytes)
    refuse_file(file,
                "is larger than " + size_text(rules.most_bytes) + " and cannot be a " + rules.what);
  return bytes;
}

std::string read_if_there(const fs::path& file, const FileRules& rules) {
  try {
    return read_whole_file(file, rules);
  } catch (const std::invalid_argument&) {
    return "";
  }
}

}  // namespace selvedge
