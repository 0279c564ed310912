// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/whole_number.h>

#include <concepts>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace selvedge::detail {

/// A JSON value that is no whole number of the wanted type.
struct NotWhole : nlohmann::json::exception {
  explicit NotWhole(const nlohmann::json& j)
      : exception(0, (j.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) +
                      " is no whole number or out of range")
                         .c_str()) {}
};

/// Throws NotWhole.
template <std::integral T>
T whole(const nlohmann::json& j) {
  if (const auto number = whole_number<T>(j)) return *number;
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
