// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

namespace selvedge::testing {

/// Every value of a document, the document itself first.
inline void collect_places(const nlohmann::json& value, const nlohmann::json::json_pointer& at,
                           std::vector<nlohmann::json::json_pointer>& places) {
  places.push_back(at);
  if (value.is_object())
    for (const auto& [key, member] : value.items()) collect_places(member, at / key, places);
  if (value.is_array())
    for (std::size_t i = 0; i < value.size(); ++i) collect_places(value[i], at / i, places);
}

/// The document with one value by chance of another type, or without one of its members.
inline nlohmann::json type_mutant(const nlohmann::json& document, std::mt19937_64& chance) {
  static const nlohmann::json values[] = {nullptr,
                                          true,
                                          "x",
                                          3.5,
                                          -1,
                                          1e100,
                                          std::uint64_t{1} << 63,
                                          nlohmann::json::array(),
                                          nlohmann::json::object(),
                                          nlohmann::json::array({nlohmann::json::array()}),
                                          {{"a", 1}}};
  std::vector<nlohmann::json::json_pointer> places;
  collect_places(document, nlohmann::json::json_pointer(), places);
  nlohmann::json mutant = document;
  const auto& place = places[chance() % places.size()];
  if (chance() % 8 == 0 && !place.empty() && mutant[place.parent_pointer()].is_object())
    mutant[place.parent_pointer()].erase(place.back());
  else
    mutant[place] = values[chance() % std::size(values)];
  return mutant;
}

}  // namespace selvedge::testing
