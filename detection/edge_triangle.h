// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace selvedge {

/// An edge and a triangle that have a common point.
struct EdgeTrianglePair {
  std::int32_t edge, triangle;
  auto operator<=>(const EdgeTrianglePair&) const = default;
};

/// Finds the edges that meet triangles in one state, x_t0 of the views; x_t1 and the thickness are
/// ignored. Exact: edges and triangles are closed sets, so touching counts, and both may be
/// degenerate.
///
/// A point that moves along the edge from one end to the other during a step collides with the
/// resting triangle if and only if the edge meets the triangle, so the exact narrow phase decides
/// this question too. The detector keeps its trees between calls.
class EdgeTriangleTest {
 public:
  EdgeTriangleTest();

  /// Clears `out` and writes to it, sorted, the edges of `a` that meet triangles of `b`. Throws
  /// std::invalid_argument that names the vertex if a coordinate is not finite.
  void find(const SurfaceView& a, const SurfaceView& b, std::vector<EdgeTrianglePair>& out);

  /// The same for the edges and triangles of one surface, without the pairs that share a vertex.
  void find_self(const SurfaceView& a, std::vector<EdgeTrianglePair>& out);

 private:
  void find_candidates(const SurfaceView& a, const SurfaceView& b);
  void decide(const SurfaceView& b, std::vector<EdgeTrianglePair>& out);

  std::unique_ptr<BroadPhase> broad_;
  std::unique_ptr<NarrowPhase> narrow_;
  std::vector<Vec3> from_, to_;  // the ends of the edges
  CandidatePairs pairs_;
  std::vector<Contact> found_;
};

/// The triangles at each edge of a mesh.
class TrianglesOfEdges {
 public:
  /// `edges`: unique_edges(triangles), m of them.
  TrianglesOfEdges(std::span<const Edge> edges, std::span<const Triangle> triangles);

  /// Indices of the triangles with that edge, ascending; 0 <= edge < m.
  std::span<const std::int32_t> at(std::int32_t edge) const;

 private:
  std::vector<std::size_t> begin_;  // m + 1 offsets into triangles_
  std::vector<std::int32_t> triangles_;
};

}  // namespace selvedge
