// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace selvedge {

/// Whether the text contains a control character, such as an escape sequence of terminals or a line
/// end: ASCII below 32, DEL, U+0080 to U+009F in UTF-8, or one of the bytes 0x80 to 0x9F alone.
bool has_control_character(std::string_view text);

/// The text with each control character, and each character that changes the order of others on the
/// display (U+202A to U+202E, U+2066 to U+2069), as \xNN, for messages about names from files.
std::string printable(std::string_view text);

/// The same for a text of several lines: line ends and tabs stay.
std::string printable_lines(std::string_view text);

/// A JSON text with those of them that the JSON library does not escape as \uNNNN.
std::string printable_json(std::string_view json);

/// "1 step" or "6 steps". `plural` is for nouns with another plural: "vertices".
template <class Count>
std::string counted(Count count, const std::string& noun, const std::string& plural = "") {
  return std::to_string(count) + " " +
         (count == Count{1} ? noun
          : plural.empty()  ? noun + "s"
                            : plural);
}

/// The word as one argument of a POSIX shell: unchanged if no character in it has a meaning there,
/// else in single quotes.
std::string shell_quoted(std::string_view word);

/// The finite number that the whole word gives in decimal notation, with a point in every locale;
/// nullopt for anything else.
std::optional<double> finite_number(std::string_view word);

}  // namespace selvedge
