// SPDX-License-Identifier: MIT
//
// Text for self-contained HTML pages.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace selvedge {

/// Bytes as base64 [RFC 4648], with padding.
std::string base64(std::span<const std::byte> bytes);
/// `text` as it may stand in an element or in a quoted attribute of HTML or XML. Control characters
/// but tabs and line ends, which have no place there, become '?'.
std::string html_escaped(std::string_view text);
/// JSON text as it may stand in a script element: no '<', which could begin "</script>".
std::string safe_in_script(std::string_view json);
/// A page with the place for a text, and the text.
struct PagePart {
  std::string_view mark;  ///< such as "%TITLE%"
  std::string_view text;
};
/// The page with every mark replaced by its text. Marks within these texts stay as they are.
std::string filled_page(std::string_view page, std::span<const PagePart> parts);

}  // namespace selvedge
