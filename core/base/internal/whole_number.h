// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

namespace selvedge {

/// The whole number in a value of a JSON file, from `low` to `high`; nullopt for anything else: a
/// fraction, an exponent, another type, a number out of range. The value is one of
/// nlohmann::basic_json, whose get<T>() would cut fractions and wrap negative numbers; its
/// conversion of 1e100 to an int is undefined.
template <std::integral T, class Json>
std::optional<T> whole_number(const Json& value, T low = std::numeric_limits<T>::min(),
                              T high = std::numeric_limits<T>::max()) {
  const auto within = [&](auto number) -> std::optional<T> {
    if (!std::in_range<T>(number)) return std::nullopt;
    const T wanted = static_cast<T>(number);
    return wanted >= low && wanted <= high ? std::optional(wanted) : std::nullopt;
  };
  if (value.is_number_unsigned()) return within(value.template get<std::uint64_t>());
  if (value.is_number_integer()) return within(value.template get<std::int64_t>());
  return std::nullopt;
}

}  // namespace selvedge
