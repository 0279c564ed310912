// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/distance.h>
#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge::detail {

/// Closest points of the two primitives; the vertices are in the order of Contact::vertex.
ClosestPoints closest_points(ContactKind kind, const std::array<Vec3, 4>& x);

/// Unit vector perpendicular to both primitives: the triangle's normal or the cross product of the
/// edges; for degenerate or parallel primitives, any unit vector perpendicular to the longest edge.
Vec3 common_normal(ContactKind kind, const std::array<Vec3, 4>& x);

/// Largest difference of a coordinate between two of the vertices.
double extent(const std::array<Vec3, 4>& x);

/// Sum of weight[k] x[k]. The weights have the sum 0, so the result is computed from differences,
/// which keep their digits.
Vec3 weighted_difference(const std::array<double, 4>& weight, const std::array<Vec3, 4>& x);

/// The query moved to its first vertex and scaled by 2^-exponent to size about 1, so that products
/// of its coordinates neither over- nor underflow.
Query scaled_query(const Query& query, int& exponent);

/// Fills weight, normal, gap and toi of a contact found at `toi`; leaves vertex and kind unchanged.
///
/// The normal is common_normal at toi. If that is across the approach (in-plane contact, parallel
/// edges: the vector between the contact points at t = 0 has almost no component along it), it is
/// the direction between the closest points at t = 0, and if those coincide, the common normal
/// again. It points away from the second primitive at t = 0 or, if the contact points coincide
/// there, against the relative motion.
void fill_contact(const Query& query, double toi, Contact& contact);

/// The vertices of a candidate pair.
struct PairVertices {
  ContactKind kind;
  std::array<std::int32_t, 4> vertex;
  /// Which view holds the vertices of the first and the second primitive: 0 for a, 1 for b.
  int first, second;
};

/// The i-th pair in the order of the lists: point_triangle, triangle_point, edge_edge.
inline PairVertices pair_at(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                            std::size_t i) {
  if (i < pairs.point_triangle.size()) {
    const PointTrianglePair& p = pairs.point_triangle[i];
    const Triangle& t = b.triangles[p.triangle];
    return {ContactKind::point_triangle, {p.point, t[0], t[1], t[2]}, 0, 1};
  }
  i -= pairs.point_triangle.size();
  if (i < pairs.triangle_point.size()) {
    const PointTrianglePair& p = pairs.triangle_point[i];
    const Triangle& t = a.triangles[p.triangle];
    return {ContactKind::triangle_point, {p.point, t[0], t[1], t[2]}, 1, 0};
  }
  i -= pairs.triangle_point.size();
  const Edge& ea = a.edges[pairs.edge_edge[i].edge_a];
  const Edge& eb = b.edges[pairs.edge_edge[i].edge_b];
  return {ContactKind::edge_edge, {ea[0], ea[1], eb[0], eb[1]}, 0, 1};
}

/// Number of vertices that belong to the first primitive.
inline int first_count(ContactKind kind) { return kind == ContactKind::edge_edge ? 2 : 1; }

inline Query query_of(const SurfaceView& a, const SurfaceView& b, const PairVertices& pair) {
  const std::array<const SurfaceView*, 2> views{&a, &b};
  Query q;
  q.kind = pair.kind == ContactKind::edge_edge ? pair.kind : ContactKind::point_triangle;
  for (int k = 0; k < 4; ++k) {
    const SurfaceView& view = *views[k < first_count(pair.kind) ? pair.first : pair.second];
    q.x_t0[k] = view.x_t0[pair.vertex[k]];
    q.x_t1[k] = view.x_t1[pair.vertex[k]];
  }
  return q;
}

/// Throws std::invalid_argument that names the first vertex with a coordinate that is not finite.
void require_finite(const SurfaceView& view, const char* name);
void require_finite(const Query& query);

}  // namespace selvedge::detail
