// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/detection/internal/joint_surface.h>
#include <selvedge/scene/build.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// The cloth and the bodies of a scene as two surfaces that move during one step. Positions are in
/// the joint index space of ContactPoint: cloth particles first, then the vertices of all bodies.
class SceneMotion {
 public:
  explicit SceneMotion(const BuiltScene& built);

  /// The motion, m. The spans must stay alive; their values may change afterwards. `bodies_move`:
  /// some body is not at rest during the step.
  void set(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, bool bodies_move);

  /// The surfaces with this thickness, m; indices of each count from 0.
  SurfaceView cloth(double thickness) const;
  SurfaceView bodies(double thickness) const;

  std::span<const Vec3> x_t0() const { return x_t0_; }
  std::span<const Vec3> x_t1() const { return x_t1_; }
  std::span<const Vec3> cloth_t0() const { return x_t0_.first(particles_); }
  std::span<const Vec3> cloth_t1() const { return x_t1_.first(particles_); }
  std::span<const Vec3> bodies_t0() const { return x_t0_.subspan(particles_); }
  std::span<const Vec3> bodies_t1() const { return x_t1_.subspan(particles_); }
  bool bodies_move() const { return bodies_move_; }

  std::size_t particles() const { return particles_; }
  std::size_t body_vertices() const { return static_cast<std::size_t>(body_begin_.back()); }
  const std::vector<Edge>& cloth_edges() const { return cloth_edges_; }
  const std::vector<Edge>& body_edges() const { return body_edges_; }
  const std::vector<Triangle>& cloth_triangles() const { return cloth_triangles_; }
  const std::vector<Triangle>& body_triangles() const { return body_triangles_; }
  /// First vertex of each body, plus the total; counts from 0.
  std::span<const std::int32_t> body_begin() const { return body_begin_; }
  JointSurface joint_surface() const;

 private:
  std::size_t particles_;
  std::vector<Edge> cloth_edges_, body_edges_;
  std::vector<Triangle> cloth_triangles_, body_triangles_;
  std::vector<std::int32_t> body_begin_;
  std::span<const Vec3> x_t0_, x_t1_;
  std::uint64_t body_id_ = 1;  // of the place where the bodies rest
  bool bodies_move_ = true;
};

}  // namespace selvedge::detail
