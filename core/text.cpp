// SPDX-License-Identifier: MIT
#include <selvedge/core/text.h>

#include <charconv>
#include <cmath>
#include <system_error>

namespace selvedge {
namespace {

/// Number of bytes of the control character at the start of the text; 0 if there is none.
std::size_t control_bytes(std::string_view text) {
  const auto c = static_cast<unsigned char>(text[0]);
  constexpr unsigned char space = 0x20, del = 0x7F, c1_lead = 0xC2, c1_first = 0x80, c1_last = 0x9F;
  if (c < space || c == del) return 1;
  if (c != c1_lead || text.size() < 2) return 0;
  const auto next = static_cast<unsigned char>(text[1]);
  return next >= c1_first && next <= c1_last ? 2 : 0;
}

}  // namespace

bool has_control_character(std::string_view text) {
  for (; !text.empty(); text.remove_prefix(1))
    if (control_bytes(text) > 0) return true;
  return false;
}

namespace {

/// The text with each control character except those in `kept` as `escape` gives it.
template <class Escape>
std::string with_escapes(std::string_view text, std::string_view kept, Escape escape) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const std::size_t n = kept.find(text[0]) == std::string_view::npos ? control_bytes(text) : 0;
    if (n == 0)
      shown += text[0];
    else
      shown += escape(text.substr(0, n));
    text.remove_prefix(n == 0 ? 1 : n);
  }
  return shown;
}

std::string hexadecimal(char c) {
  static const char* digits = "0123456789abcdef";
  const auto byte = static_cast<unsigned char>(c);
  return {digits[byte >> 4], digits[byte & 15]};
}

std::string each_byte(std::string_view control) {
  std::string shown;
  for (const char c : control) shown += "\\x" + hexadecimal(c);
  return shown;
}

}  // namespace

std::string printable(std::string_view text) { return with_escapes(text, "", each_byte); }

std::string printable_lines(std::string_view text) { return with_escapes(text, "\n\t", each_byte); }

std::string printable_json(std::string_view json) {
  // The last byte of each of these characters in UTF-8 is its number.
  return with_escapes(
      json, "\n\t", [](std::string_view control) { return "\\u00" + hexadecimal(control.back()); });
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

std::optional<double> finite_number(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace selvedge
