// SPDX-License-Identifier: MIT
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/internal/state_text.h>

#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

using detail::Json;
using detail::Value;

std::string text_of(const std::vector<Vec3>& vectors) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  return detail::memory_text({vectors.empty() ? nullptr : vectors[0].data(), 3 * vectors.size()});
}

std::vector<Vec3> vectors_from(const Value& value) {
  const std::vector<double> numbers = detail::memory_from(value.text());
  if (numbers.size() % 3 != 0) value.refuse("three numbers for each vertex");
  std::vector<Vec3> vectors;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    vectors.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  return vectors;
}

std::pair<SimulationState, BodyPlaces> state_from(const Value& json) {
  SimulationState state;
  BodyPlaces bodies;
  state.x = vectors_from(json["x"]);
  state.v = vectors_from(json["v"]);
  state.water = detail::memory_from(json["water"].text());
  detail::read_state_fields(json, state);
  for (const Value& body : json["bodies"].list())
    bodies[body["number"].whole<std::size_t>()] = vectors_from(body["x"]);
  return {std::move(state), std::move(bodies)};
}

}  // namespace

std::string state_text(const SimulationState& state, const BodyPlaces& bodies) {
  Json json = {{"x", text_of(state.x)},
               {"v", text_of(state.v)},
               {"water", detail::memory_text(state.water)}};
  detail::write_state_fields(state, json);
  json["bodies"] = Json::array();
  for (const auto& [number, x] : bodies)
    json["bodies"].push_back({{"number", number}, {"x", text_of(x)}});
  return json.dump();
}

std::pair<SimulationState, BodyPlaces> state_from_text(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_object()) {
    try {
      return state_from(Value(json));
    } catch (const std::invalid_argument&) {  // says so of a checkpoint
    }
  }
  throw std::invalid_argument("the saved state is damaged; save it again");
}

}  // namespace selvedge
