// SPDX-License-Identifier: MIT
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/handles.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <string>

namespace selvedge::detail {
namespace {

std::size_t piece_of(const Scene& scene, const HandleSpec& handle) {
  const auto piece = std::find_if(scene.cloths.begin(), scene.cloths.end(),
                                  [&](const auto& c) { return c.name == handle.geometry; });
  return static_cast<std::size_t>(piece - scene.cloths.begin());
}

}  // namespace

void refuse_bad_handles(const Scene& scene, const BuiltScene& built) {
  for (const HandleSpec& handle : scene.handles) {
    const std::size_t piece = piece_of(scene, handle);
    const std::string name = "handle \"" + handle.name + "\"";
    if (piece == scene.cloths.size())
      throw std::invalid_argument(name + ": no piece of cloth is called \"" + handle.geometry +
                                  "\"");
    const std::int32_t size = built.piece_begin[piece + 1] - built.piece_begin[piece];
    for (const std::int32_t v : handle.vertices)
      if (v < 0 || v >= size)
        throw std::invalid_argument(name + ": vertex " + std::to_string(v) + " is not among the " +
                                    std::to_string(size) + " of \"" + handle.geometry + "\"");
  }
}

void visit_held(
    const Scene& scene, const BuiltScene& built, double t0, double t1,
    FunctionRef<void(std::int32_t particle, const Vec3& end, std::int32_t handle)> visit) {
  for (std::int32_t h = 0; const HandleSpec& handle : scene.handles) {
    const std::int32_t number = h++;
    if (handle.release && t0 >= *handle.release) continue;
    const std::int32_t first = built.piece_begin[piece_of(scene, handle)];
    const std::vector<Vec3>& start = built.cloth.surface.vertices;
    Vec3 pivot = Vec3::Zero();
    const std::size_t pivots = handle.pivots > 0 ? handle.pivots : handle.vertices.size();
    for (std::size_t k = 0; k < pivots; ++k) pivot += start[first + handle.vertices[k]];
    pivot /= static_cast<double>(pivots);
    const Keyframe pose = pose_at(handle.motion, t1);
    for (const std::int32_t v : handle.vertices) {
      const std::int32_t i = first + v;
      const Vec3 end = handle.motion.empty()
                           ? start[i]
                           : Vec3(pivot + pose.translation + pose.rotation * (start[i] - pivot));
      visit(i, end, number);
    }
  }
}

}  // namespace selvedge::detail
