// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/collision_types.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

// Detection on plain arrays: each function is one call, arrays in, a list out. A program that
// detects in every step of a simulation is faster with a BroadPhase and a NarrowPhase of its own,
// which keep their trees between calls.
//
// Every function throws std::invalid_argument that names the index and the value if the arrays of a
// surface have different lengths, a coordinate is not finite, or a triangle has an index outside
// [0, n). The surface is called `a` or `b` there, or `surface` if there is only one. Degenerate
// triangles are allowed. A vertex of no triangle is ignored. Pairs of points, edges and triangles
// of one surface that share a vertex are omitted; pairs of triangles that meet in a state are not.
// Results are the same for any number of threads.

namespace selvedge {

/// One surface in one state. This is a view: its creator keeps the arrays alive.
struct SurfaceState {
  std::span<const Vec3> x;              ///< (n,3), metres
  std::span<const Triangle> triangles;  ///< (k,3), vertex indices
};

/// One surface during one step, t in [0,1]. Vertex i moves on the straight line x_t0[i] -> x_t1[i].
/// This is a view: its creator keeps the arrays alive.
struct MovingSurface {
  std::span<const Vec3> x_t0, x_t1;     ///< (n,3) each, metres
  std::span<const Triangle> triangles;  ///< (k,3), vertex indices
};

/// Options of find_collisions.
struct DetectionConfig {
  /// A detector of broad_phases(). Every conservative one leads to the same collisions; they differ
  /// in time.
  std::string broad_phase = "bvh_aabb";
  /// A method of narrow_phases(). ccd_exact neither misses a collision nor reports a false one.
  std::string narrow_phase = "ccd_exact";
  /// Metres, >= 0. Primitives that are at most this far apart count as colliding; ccd_exact may
  /// then report distances up to 1/64 larger. Other methods refuse a value that they do not
  /// support.
  double min_separation = 0.0;
};

/// One primitive of each side, and the points on them that are in contact. For one surface, both
/// sides are that surface.
struct PrimitivePair {
  ContactKind kind;
  std::int32_t primitive_a;  ///< vertex, triangle or edge of the first side, as `kind` says
  std::int32_t primitive_b;  ///< the same of the second side; edges: index in unique_edges
  /// Vertex indices in the order that ContactKind gives. The first primitive is the point, or the
  /// edge of side a.
  std::array<std::int32_t, 4> vertex;
  /// Signed barycentric weights of `vertex`, sum 0, as in Contact: (1, -u, -v, -w) or
  /// (1-s, s, -(1-t), -t).
  std::array<double, 4> weight;
  Vec3 normal;  ///< unit, from the second primitive towards the first
};

/// Two primitives that share a point during the step.
struct Collision : PrimitivePair {
  double toi;  ///< time of impact in [0,1]; with ccd_exact the largest double not later than it
};

/// Two primitives that are near each other in a state.
struct Proximity : PrimitivePair {
  double gap;  ///< distance, metres
};

/// The methods of a search, which the caller makes and may keep from call to call: from any
/// registry, with any options.
struct DetectionMethods {
  BroadPhase& broad_phase;
  const NarrowPhase& narrow_phase;
  double min_separation = 0.0;  ///< m, >= 0; the one that `narrow_phase` has
};

/// A triangle of each side.
struct TrianglePair {
  std::int32_t triangle_a, triangle_b;
  auto operator<=>(const TrianglePair&) const = default;
};

/// Pairs of triangles that meet in a state, each list sorted.
///
/// Two triangles *cross* if their insides have a common point: an edge of one passes through the
/// inside of the other, or both lie in one plane and overlap in area. A triangle also crosses the
/// triangles at an edge that lies in its plane and passes along its inside, if they are on both
/// sides of it: the surface passes through it exactly along the edge. They *touch* if they do not
/// cross, but primitives of them without a common vertex have a common point: a corner or an edge
/// of one and the other triangle, or two edges. Vertices are common by index; equal positions of
/// different indices touch. A degenerate triangle is the segment or point that its corners span: it
/// crosses a triangle only if the segment passes through its inside.
struct TriangleMeetings {
  std::vector<TrianglePair> crossings, touches;

  bool empty() const { return crossings.empty() && touches.empty(); }
  std::vector<TrianglePair> all() const;  ///< sorted
};

/// Finds the collisions of one surface with itself during a step: x_t0 and x_t1 (n,3) in metres,
/// triangles (k,3). Sorted by time of impact, then by kind and indices; primitive_a < primitive_b
/// for edges. Also throws std::invalid_argument for an unknown method, for a broad phase that
/// cannot search one surface, and for a min_separation that is negative or not supported.
std::vector<Collision> find_collisions(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1,
                                       std::span<const Triangle> triangles,
                                       const DetectionConfig& config = {});

/// Finds the collisions between two surfaces during a step, not those within one of them. Sorted
/// and errors as above.
std::vector<Collision> find_collisions(const MovingSurface& a, const MovingSurface& b,
                                       const DetectionConfig& config = {});

/// The same for one surface or between two, with methods of the caller.
std::vector<Collision> find_collisions(const DetectionMethods& methods,
                                       const MovingSurface& surface);
std::vector<Collision> find_collisions(const DetectionMethods& methods, const MovingSurface& a,
                                       const MovingSurface& b);

/// The pairs of primitives whose paths may come within `distance` (m, >= 0) of each other, as the
/// detector finds them: the candidates of a narrow phase. Edges are indices in unique_edges. Lists
/// are sorted. Vertices of no triangle are left out.
CandidatePairs find_candidates(BroadPhase& broad_phase, const MovingSurface& surface,
                               double distance = 0.0);
CandidatePairs find_candidates(BroadPhase& broad_phase, const MovingSurface& a,
                               const MovingSurface& b, double distance = 0.0);

/// Finds the pairs of triangles of one surface that cross or touch: x (n,3) in metres, triangles
/// (k,3); triangle_a < triangle_b. Decided exactly.
TriangleMeetings find_meetings(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// The same for a triangle of `a` and a triangle of `b`.
TriangleMeetings find_meetings(const SurfaceState& a, const SurfaceState& b);

/// Finds the pairs of triangles of one surface that cross. See find_meetings.
std::vector<TrianglePair> find_crossings(std::span<const Vec3> x,
                                         std::span<const Triangle> triangles);

/// Finds the pairs of a triangle of `a` and a triangle of `b` that cross.
std::vector<TrianglePair> find_crossings(const SurfaceState& a, const SurfaceState& b);

/// Finds the pairs of a point and a triangle, or of two edges, of one surface that are nearer than
/// `distance` metres in one state, with their closest points: x (n,3) in metres, triangles (k,3).
/// Sorted by gap, then by kind and indices. Gaps are rounded. Also throws std::invalid_argument
/// unless `distance` is positive and finite.
std::vector<Proximity> find_contacts(std::span<const Vec3> x, std::span<const Triangle> triangles,
                                     double distance);

/// The same between two surfaces.
std::vector<Proximity> find_contacts(const SurfaceState& a, const SurfaceState& b, double distance);

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
  void take_equal_corners(const SurfaceView& b, std::vector<EdgeTrianglePair>& out);
  void decide(const SurfaceView& b, std::vector<EdgeTrianglePair>& out);

  std::unique_ptr<BroadPhase> broad_;
  std::unique_ptr<NarrowPhase> narrow_;
  std::vector<Vec3> from_, to_;  // the ends of the edges
  CandidatePairs pairs_;
  std::vector<Contact> found_;
};

/// Finds the triangles that meet in one state, x_t0 of the views. The detectors keep their trees
/// between calls.
class TriangleTest {
 public:
  TriangleTest();

  /// Writes the pairs of a triangle of `a` and a triangle of `b` that meet to `out`. Throws
  /// std::invalid_argument that names the vertex if a coordinate is not finite.
  void find(const SurfaceView& a, const SurfaceView& b, TriangleMeetings& out);

  /// The same for the triangles of one surface; triangle_a < triangle_b.
  void find_self(const SurfaceView& a, TriangleMeetings& out);

  /// Those of find_self that have two or three vertices in common, and those of which one names a
  /// vertex twice: time proportional to the number of triangles.
  void find_folded(const SurfaceView& a, TriangleMeetings& out);

 private:
  void add_folded(const SurfaceView& a, TriangleMeetings& out);

  EdgeTriangleTest edges_;
  std::unique_ptr<NarrowPhase> narrow_;
  std::vector<EdgeTrianglePair> met_;
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
