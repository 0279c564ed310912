// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/check_scene.h>
#include <selvedge/scene/detail/scene_fields.h>

#include <cmath>
#include <stdexcept>

namespace selvedge::detail {

namespace {

void check_rotation(const Eigen::Quaterniond& rotation, const std::string& place) {
  const double norm = rotation.norm();
  if (!(std::abs(norm - 1.0) < 1e-6))
    throw std::invalid_argument(fmt::format("{}: the length must be 1, is {:g}", place, norm));
}

template <class Posed>
void check_posed(const Posed& posed, const std::string& place) {
  check_fields(posed, place);
  check_rotation(posed.rotation, place + ".rotation");
}

void check_motion(const std::vector<Keyframe>& motion, const std::string& place) {
  for (std::size_t i = 0; i < motion.size(); ++i)
    check_posed(motion[i], fmt::format("{}[{}]", place, i));
}

}  // namespace

void check_numbers(const Scene& scene) {
  check_fields(scene, "");
  for (const AirJet& jet : scene.air.jets)
    if (!(jet.direction.norm() > 0.0))
      throw std::invalid_argument("air.jets: a direction has no length");
  for (const auto& [name, material] : scene.materials)
    check_fields(material, fmt::format("materials.{}", name));
  for (const ClothSpec& cloth : scene.cloths) {
    const std::string place = fmt::format("geometry.{}", cloth.name);
    check_fields(cloth, place);
    check_posed(cloth.placement, place + ".transformation");
  }
  for (const HandleSpec& handle : scene.handles)
    check_motion(handle.motion, fmt::format("handles.{}.motion", handle.name));
  for (const BodySpec& body : scene.bodies) {
    const std::string place = fmt::format("obstacles.{}", body.name);
    check_posed(body.placement, place + ".transformation");
    check_motion(body.motion, place + ".motion");
    detail::check_value(body.friction, Key{.range = kFriction}, place + ".friction");
  }
}

}  // namespace selvedge::detail
