// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace selvedge {

/// Whether the text contains a control character, such as an escape sequence of terminals or a line
/// end: ASCII below 32, DEL, or U+0080 to U+009F in UTF-8.
bool has_control_character(std::string_view text);

/// The text with each control character as \xNN, for messages about names from files.
std::string printable(std::string_view text);

/// The word as one argument of a POSIX shell: unchanged if no character in it has a meaning there,
/// else in single quotes.
std::string shell_quoted(std::string_view word);

/// The finite number that the whole word gives in decimal notation, with a point in every locale;
/// nullopt for anything else.
std::optional<double> finite_number(std::string_view word);

}  // namespace selvedge
