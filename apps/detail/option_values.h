// SPDX-License-Identifier: MIT
//
// Values of options that are more than one word or number.
#pragma once

#include <selvedge/bodies/mesh_file.h>

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace selvedge {

/// Throws std::invalid_argument with the option, its value and what it must be.
[[noreturn]] void refuse_value(const std::string& option, const std::string& value,
                               const std::string& wanted);

/// The pieces of a text between separators.
std::vector<std::string_view> split(std::string_view text, char separator);

/// The number that a text is as a whole.
template <class Number>
std::optional<Number> number_from(std::string_view text) {
  Number value{};
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Those of `all` (ascending, not empty) that the value of --frames names: FIRST:LAST:STEP, of
/// which each may be left out, or one number. LAST is included. Throws std::invalid_argument if it
/// names none.
std::vector<int> chosen_frames(const std::string& value, const std::vector<int>& all);

/// The value of --up: x, y or z; empty for "", where the file states the axis.
std::optional<UpAxis> up_axis(const std::string& word);

}  // namespace selvedge
