// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/detail/output_file.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

namespace selvedge {

void refuse_other_kind(const std::filesystem::path& file, const FileKind& kind,
                       std::string_view option) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return;
  std::ifstream in(file, std::ios::binary);
  std::string begin(kind.begin.size(), '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(in.gcount()));
  std::transform(begin.begin(), begin.end(), begin.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (begin.empty() || begin == kind.begin) return;
  throw std::invalid_argument(
      fmt::format("{}: holds something else than {}, which {} would replace; give another name, or "
                  "remove the file",
                  file.string(), kind.what, option));
}

}  // namespace selvedge
