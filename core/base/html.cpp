// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/html.h>

#include <cstdint>

namespace selvedge {

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three =
          three << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : digits[three >> (18 - 6 * k) & 63u];
  }
  return text;
}

std::string html_escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      case '\t':
      case '\n':
      case '\r':
        escaped += c;
        break;
      default:
        escaped += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
    }
  return escaped;
}

std::string safe_in_script(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json)
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  return text;
}

std::string filled_page(std::string_view page, std::span<const PagePart> parts) {
  std::string filled;
  for (std::size_t from = 0;;) {
    std::size_t next = std::string_view::npos;
    const PagePart* found = nullptr;
    for (const PagePart& part : parts)
      if (const std::size_t at = page.find(part.mark, from); at < next) {
        next = at;
        found = &part;
      }
    filled += page.substr(from, next == std::string_view::npos ? next : next - from);
    if (found == nullptr) return filled;
    filled += found->text;
    from = next + found->mark.size();
  }
}

}  // namespace selvedge
