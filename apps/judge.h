// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace selvedge {

/// What `check` finds. Exact: decided by orientation predicates in integers of any length behind a
/// proven floating-point filter, for every finite coordinate; degenerate triangles are the points
/// and segments that their corners span. Shares no code with broadphase, narrowphase or response.
struct Verdict {
  std::size_t vertices = 0, triangles = 0;
  /// Pairs of triangles of the mesh that share no vertex (by index) and have a common point:
  /// touching counts, overlap in a plane counts. Neighbours that share a vertex are not looked at.
  std::size_t self_intersections = 0;
  std::size_t body_intersections = 0;  ///< triangle of the mesh with triangle of the body
  /// Mesh vertices strictly inside the closed parts of the body: where the winding numbers of its
  /// consistently oriented parts do not sum to 0, or inside a closed part without orientation.
  std::size_t inside_vertices = 0;
  /// Largest distance of those to the closed parts' surface; rounded, the only inexact number
  /// beside the strains.
  double max_penetration_m = 0.0;
  double max_stretch = 0.0, max_compression = 0.0;  ///< of edges against the rest mesh
  std::vector<std::pair<std::int32_t, std::int32_t>> first_self,
      first_body;  ///< up to 10 pairs each
  /// Parts of the body joined by edges, vertices at equal positions taken as one. Open parts (with
  /// a border) have no inside.
  std::size_t closed_parts = 0, open_parts = 0;
};

/// `body` and `rest` may be empty. Throws std::invalid_argument for a coordinate that is not
/// finite, an index out of range, a rest mesh of other topology or with an edge of length 0.
Verdict judge(const TriangleMesh& mesh, const TriangleMesh& body, const TriangleMesh& rest);

/// What lies between two states: pairs of primitives that collide while every vertex moves on a
/// straight line from one state to the other, decided exactly in integers. Primitives are the
/// triangles, their edges and the vertices they use; pairs of the mesh that share a vertex (by
/// index) are not looked at. A path without collision between states without intersection is free.
struct PathVerdict {
  std::size_t pairs = 0;  ///< primitive pairs with overlapping swept boxes
  std::size_t self_collisions = 0, body_collisions = 0;
};

/// The body may be empty. Throws std::invalid_argument as judge does, or if the two states of a
/// surface have different numbers of vertices.
PathVerdict judge_path(const TriangleMesh& mesh_t0, std::span<const Vec3> mesh_t1,
                       const TriangleMesh& body_t0, std::span<const Vec3> body_t1);

}  // namespace selvedge
