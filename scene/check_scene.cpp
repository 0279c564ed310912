// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/check_scene.h>

#include <cmath>
#include <stdexcept>

namespace selvedge {

namespace {

void require(bool good, const std::string& field, double value, const char* rule) {
  if (!good)
    throw std::invalid_argument(fmt::format("{} must be {}, not {:g}", field, rule, value));
}

void require_positive(double value, const std::string& field) {
  require(std::isfinite(value) && value > 0.0, field, value, "positive and finite");
}

void require_not_negative(double value, const std::string& field) {
  require(std::isfinite(value) && value >= 0.0, field, value, "at least 0 and finite");
}

void require_finite(const Vec3& value, const std::string& field) {
  for (int axis = 0; axis < 3; ++axis)
    require(std::isfinite(value[axis]), field, value[axis], "finite");
}

void check_placement(const Placement& placement, const std::string& name) {
  require_finite(placement.translation, name + ": translation");
  require_positive(placement.scale, name + ": scale");
  const double norm = placement.rotation.norm();
  require(std::abs(norm - 1.0) < 1e-6, name + ": the length of its rotation", norm, "1");
}

void check_keyframes(const std::vector<Keyframe>& keys, const std::string& name) {
  for (const Keyframe& key : keys) {
    require(std::isfinite(key.time), name + ": time of a keyframe", key.time, "finite");
    require_finite(key.translation, name + ": translation of a keyframe");
    const double norm = key.rotation.norm();
    require(std::abs(norm - 1.0) < 1e-6, name + ": the length of a keyframe's rotation", norm, "1");
  }
}

void check_time(const TimeSpec& time) {
  require(time.frames >= 1, "time.frames", time.frames, "at least 1");
  require_positive(time.fps, "time.fps");
  require(time.steps_per_frame >= 1, "time.steps_per_frame", time.steps_per_frame, "at least 1");
  require_not_negative(time.step_error, "time.step_error");
  require_not_negative(time.sleep_speed, "time.sleep_speed");
  require(time.max_halvings >= 0, "time.max_halvings", time.max_halvings, "at least 0");
}

}  // namespace

void check_numbers(const Scene& scene) {
  require_finite(scene.gravity, "gravity");
  require_finite(scene.air.wind, "air.wind");
  require_not_negative(scene.air.gusts.speed, "air.gusts.speed");
  require_positive(scene.air.gusts.length, "air.gusts.length");
  for (std::size_t i = 0; i < scene.air.jets.size(); ++i) {
    const AirJet& jet = scene.air.jets[i];
    const std::string name = fmt::format("air.jets[{}]", i);
    require_finite(jet.position, name + ".position");
    require_finite(jet.direction, name + ".direction");
    require_positive(jet.direction.norm(), "the length of " + name + ".direction");
    require_not_negative(jet.speed, name + ".speed");
    require_positive(jet.diameter, name + ".diameter");
  }
  require_not_negative(scene.air.normal_drag, "air.normal_drag");
  require_not_negative(scene.air.viscous_drag, "air.viscous_drag");
  check_time(scene.time);
  require_positive(scene.contact.rest_gap, "contact.rest_gap");
  for (std::size_t i = 0; i < scene.contact.pairs.size(); ++i) {
    const PairSpec& pair = scene.contact.pairs[i];
    const std::string name = fmt::format("contact.pairs[{}]", i);
    if (pair.friction) require_not_negative(*pair.friction, name + ".friction");
    if (pair.rest_gap) require_positive(*pair.rest_gap, name + ".rest_gap");
  }
  require_positive(scene.solver.tolerance, "solver.tolerance");
  require(scene.solver.max_iterations >= 1, "solver.max_iterations", scene.solver.max_iterations,
          "at least 1");
  for (const auto& [name, material] : scene.materials)
    require_not_negative(material.friction, "material \"" + name + "\": friction");
  for (const ClothSpec& cloth : scene.cloths) {
    const std::string name = "cloth \"" + cloth.name + "\"";
    check_placement(cloth.placement, name);
    require_finite(cloth.velocity, name + ": velocity");
  }
  for (const HandleSpec& handle : scene.handles)
    check_keyframes(handle.motion, "handle \"" + handle.name + "\"");
  for (const WeightSpec& weight : scene.weights)
    require_not_negative(weight.mass, "weight \"" + weight.name + "\": mass");
  for (const BodySpec& body : scene.bodies) {
    const std::string name = "body \"" + body.name + "\"";
    check_placement(body.placement, name);
    check_keyframes(body.motion, name);
    require_not_negative(body.friction, name + ": friction");
  }
}

}  // namespace selvedge
