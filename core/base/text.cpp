// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/text.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <system_error>

namespace selvedge {
namespace {

/// A character of UTF-8, or a byte that is no part of one.
struct Character {
  std::size_t bytes = 1;
  char32_t code = 0;
};

Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char lead = byte(0);
  const std::size_t bytes = lead < 0xC2   ? 1
                            : lead < 0xE0 ? 2
                            : lead < 0xF0 ? 3
                            : lead < 0xF5 ? 4
                                          : 1;
  if (bytes == 1 || text.size() < bytes) return {1, lead};
  char32_t code = lead & (0x7FU >> bytes);
  for (std::size_t k = 1; k < bytes; ++k) {
    if ((byte(k) & 0xC0U) != 0x80U) return {1, lead};
    code = code << 6U | (byte(k) & 0x3FU);
  }
  return {bytes, code};
}

/// Of ASCII, DEL and U+0080 to U+009F; the bytes 0x80 to 0x9F alone are those in 8-bit terminals.
bool is_control(char32_t code) { return code < 0x20 || (code >= 0x7F && code <= 0x9F); }

/// Changes the order in which the characters after it are shown.
bool reorders(char32_t code) {
  return (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

}  // namespace

bool has_control_character(std::string_view text) {
  while (!text.empty()) {
    const Character c = first_character(text);
    if (is_control(c.code)) return true;
    text.remove_prefix(c.bytes);
  }
  return false;
}

namespace {

/// The text with each character that acts on the display, except those in `kept`, as `escape` gives
/// it.
template <class Escape>
std::string with_escapes(std::string_view text, std::string_view kept, Escape escape) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Character c = first_character(text);
    const bool acts = is_control(c.code) || reorders(c.code);
    if (acts && kept.find(text[0]) == std::string_view::npos)
      shown += escape(text.substr(0, c.bytes), c.code);
    else
      shown += text.substr(0, c.bytes);
    text.remove_prefix(c.bytes);
  }
  return shown;
}

std::string hexadecimal(char c) {
  static const char* digits = "0123456789abcdef";
  const auto byte = static_cast<unsigned char>(c);
  return {digits[byte >> 4], digits[byte & 15]};
}

std::string each_byte(std::string_view control, char32_t) {
  std::string shown;
  for (const char c : control) shown += "\\x" + hexadecimal(c);
  return shown;
}

}  // namespace

std::string printable(std::string_view text) { return with_escapes(text, "", each_byte); }

std::string printable_lines(std::string_view text) { return with_escapes(text, "\n\t", each_byte); }

std::string printable_json(std::string_view json) {
  return with_escapes(json, "\n\t", [](std::string_view, char32_t code) {
    return "\\u" + hexadecimal(static_cast<char>(code >> 8U)) +
           hexadecimal(static_cast<char>(code));
  });
}

std::string shell_quoted(std::string_view word) {
  constexpr const char* plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string_view::npos)
    return std::string(word);
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

namespace {

/// The number that the whole word gives; nullopt if it gives none or is beyond the range.
std::optional<double> whole_number_of(const std::string& word) {
  double value = 0.0;
#ifdef __cpp_lib_to_chars
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
#else
  // libc++ before version 20 reads integers only. Emscripten has it, with a C library that reads a
  // point in every locale.
  const std::size_t mantissa = std::min(word.find_first_of("eE"), word.size());
  if (word.empty() || word[0] == '+' || word.find_first_not_of("+-.0123456789eE") < word.size())
    return std::nullopt;
  char* end = nullptr;
  value = std::strtod(word.c_str(), &end);
  const bool vanished = value == 0.0 && word.find_first_of("123456789") < mantissa;
  if (end != word.c_str() + word.size() || vanished) return std::nullopt;
#endif
  return value;
}

}  // namespace

std::optional<double> finite_number(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  const std::optional<double> value = whole_number_of(std::string(word));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace selvedge
