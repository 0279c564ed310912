// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace selvedge {

/// What `check` finds. Exact: decided by orientation predicates in rational arithmetic behind a
/// proven floating-point filter; shares no code with broadphase, narrowphase or response.
struct Verdict {
  std::size_t vertices = 0, triangles = 0;
  /// Pairs of triangles of the mesh that share no vertex and have a common point.
  std::size_t self_intersections = 0;
  std::size_t body_intersections = 0;         ///< triangle of the mesh with triangle of the body
  std::size_t inside_vertices = 0;            ///< mesh vertices inside the closed parts of the body
  double max_penetration_m = 0.0;             ///< largest depth of those below the body's surface
  double max_stretch = 0.0, max_compression = 0.0;   ///< of edges against the rest mesh
  std::vector<std::pair<std::int32_t, std::int32_t>> first_self, first_body;   ///< up to 10 pairs each
};

/// `body` and `rest` may be empty.
Verdict judge(const TriangleMesh& mesh, const TriangleMesh& body, const TriangleMesh& rest);

/// What lies between two states: pairs of primitives that collide while every vertex moves on a
/// straight line from one state to the other, decided exactly in rational arithmetic.
struct PathVerdict {
  std::size_t pairs = 0;                      ///< primitive pairs with overlapping swept boxes
  std::size_t self_collisions = 0, body_collisions = 0;
};
PathVerdict judge_path(const TriangleMesh& mesh_t0, std::span<const Vec3> mesh_t1,
                       const TriangleMesh& body_t0, std::span<const Vec3> body_t1);

}  // namespace selvedge
