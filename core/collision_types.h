// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge {

/// Where a rigid body is: x = rotation · X + translation.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();  ///< metres
};

/// Promise that allows a broad phase to keep the tree of a rigid body that moves: as long as two
/// views carry the same nonzero id, edges and triangles are the same numbers, and x_t0 and x_t1 are
/// the poses t0 and t1 of the same X, computed in double precision.
struct RigidMotion {
  std::uint64_t id = 0;
  Pose t0, t1;
};

/// One surface over one time step. Vertex i moves on the straight line x_t0[i] -> x_t1[i], t in
/// [0,1]. A view: whoever makes it keeps the arrays alive.
struct SurfaceView {
  std::span<const Vec3> x_t0, x_t1;     ///< metres, n each
  std::span<const Edge> edges;          ///< unique, every edge of a triangle once
  std::span<const Triangle> triangles;  ///< indices below n
  double thickness = 0.0;               ///< metres, the half-gap kept on each side
  /// Promise that allows a broad phase to keep its tree: as long as two views carry the same
  /// nonzero id, x_t0, x_t1, edges and triangles are the same numbers. 0 promises nothing.
  std::uint64_t static_id = 0;
  /// Null promises nothing. Without use for a surface that has a static_id.
  const RigidMotion* rigid = nullptr;
};

/// A point of one surface against a triangle of another (or the same) surface.
struct PointTrianglePair {
  std::int32_t point, triangle;
  auto operator<=>(const PointTrianglePair&) const = default;
};

/// An edge of one surface against an edge of another (or the same) surface.
struct EdgeEdgePair {
  std::int32_t edge_a, edge_b;
  auto operator<=>(const EdgeEdgePair&) const = default;
};

/// What a broad phase hands to a narrow phase: indices into the edges, triangles and vertices of
/// the two views it was given. Lists are sorted and free of duplicates. With one surface against
/// itself, pairs whose primitives share a vertex are left out, edge_a < edge_b, and
/// triangle_point is empty.
struct CandidatePairs {
  std::vector<PointTrianglePair> point_triangle;  ///< point of a, triangle of b
  std::vector<PointTrianglePair> triangle_point;  ///< triangle of a, point of b
  std::vector<EdgeEdgePair> edge_edge;            ///< edge of a, edge of b

  void clear() {
    point_triangle.clear();
    triangle_point.clear();
    edge_edge.clear();
  }
  std::size_t size() const {
    return point_triangle.size() + triangle_point.size() + edge_edge.size();
  }
};

enum class ContactKind : std::uint8_t {
  point_triangle,  ///< vertices: point of a, then the three corners of b's triangle
  triangle_point,  ///< vertices: point of b, then the three corners of a's triangle
  edge_edge,       ///< vertices: two of a's edge, then two of b's edge
};

/// Two primitives that touch (a collision during the step) or come near (a proximity).
/// The signed sum of weight[k] * x[vertex[k]] is the vector from the second primitive's contact
/// point to the first one's: weights are (1, -u, -v, -w) for a point and a triangle and
/// (1-s, s, -(1-t), -t) for two edges. Its product with `normal` is the gap, positive at t = 0.
struct Contact {
  ContactKind kind;
  std::array<std::int32_t, 4> vertex;  ///< of a or of b, as `kind` says
  std::array<double, 4> weight;        ///< barycentric, signed, sum 0
  Vec3 normal;                         ///< unit, from the second primitive towards the first
  double toi = 0.0;                    ///< time of impact in [0,1]; never later than the true one
  double gap = 0.0;                    ///< metres between the primitives at t = 0
};

/// What a detector promises.
enum class Guarantee : std::uint8_t {
  conservative,  ///< misses nothing
  approximate,   ///< may miss; its header says what
};

}  // namespace selvedge
