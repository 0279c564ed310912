// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace selvedge::detail {

/// A JSON value that is no whole number of the wanted type. Json::get would convert 1e100 to an
/// int, which is undefined.
struct NotWhole : nlohmann::json::exception {
  explicit NotWhole(const nlohmann::json& j)
      : exception(0, (j.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) +
                      " is no whole number or out of range")
                         .c_str()) {}
};

/// Throws NotWhole, or Json::exception for another type.
template <std::integral T>
T whole(const nlohmann::json& j) {
  if (j.is_number_unsigned() && std::in_range<T>(j.get<std::uint64_t>()))
    return static_cast<T>(j.get<std::uint64_t>());
  if (j.is_number_integer() && !j.is_number_unsigned() && std::in_range<T>(j.get<std::int64_t>()))
    return static_cast<T>(j.get<std::int64_t>());
  throw NotWhole(j);
}

template <std::integral T>
std::vector<T> whole_list(const nlohmann::json& j) {
  std::vector<T> list;
  for (const nlohmann::json& value : j.get_ref<const nlohmann::json::array_t&>())
    list.push_back(whole<T>(value));
  return list;
}

}  // namespace selvedge::detail
