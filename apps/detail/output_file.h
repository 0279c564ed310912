// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string_view>

namespace selvedge {

/// A kind of file that a command writes.
struct FileKind {
  const char* what;        ///< such as "a page (HTML)"
  std::string_view begin;  ///< of each file of this kind, in lower case
};

inline constexpr FileKind kHtmlPage = {"an HTML page", "<!doctype html"};
inline constexpr FileKind kSvgPicture = {"an SVG picture", "<svg"};
inline constexpr FileKind kJsonFile = {"a JSON file", "{"};
inline constexpr FileKind kObjMesh = {"an OBJ mesh", "v "};

/// Refuses to replace a file of another kind: a scene by a page, where the user has mistaken one
/// option for another. A missing file, a device and an empty file may be written. Throws
/// std::invalid_argument with the file, `option` and the remedy.
void refuse_other_kind(const std::filesystem::path& file, const FileKind& kind,
                       std::string_view option);

}  // namespace selvedge
