// SPDX-License-Identifier: MIT
#include <selvedge/core/base/types.h>
#include <selvedge/simulation/contacts/detail/scene_motion.h>

namespace selvedge::detail {

SceneMotion::SceneMotion(const BuiltScene& built)
    : particles_(built.cloth.surface.vertices.size()),
      cloth_edges_(built.cloth.edges),
      cloth_triangles_(built.cloth.surface.triangles),
      body_begin_{0} {
  for (const auto& body : built.bodies) {
    const std::int32_t first = body_begin_.back();
    for (const Triangle& t : body->triangles())
      body_triangles_.push_back({t[0] + first, t[1] + first, t[2] + first});
    body_begin_.push_back(first + static_cast<std::int32_t>(body->vertex_count()));
  }
  body_edges_ = unique_edges(body_triangles_);
}

void SceneMotion::set(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, bool bodies_move) {
  x_t0_ = x_t0;
  x_t1_ = x_t1;
  if (bodies_move || bodies_move_) ++body_id_;  // the step after a motion starts elsewhere
  bodies_move_ = bodies_move;
}

SurfaceView SceneMotion::cloth(double thickness) const {
  return {cloth_t0(), cloth_t1(), cloth_edges_, cloth_triangles_, thickness, 0};
}

SurfaceView SceneMotion::bodies(double thickness) const {
  return {bodies_t0(),     bodies_t1(), body_edges_,
          body_triangles_, thickness,   bodies_move_ ? 0 : body_id_};
}

JointSurface SceneMotion::joint_surface() const {
  return {particles_,       body_vertices(), cloth_edges_,
          cloth_triangles_, body_edges_,     body_triangles_};
}

}  // namespace selvedge::detail
