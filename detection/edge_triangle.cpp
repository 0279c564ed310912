// SPDX-License-Identifier: MIT
#include <selvedge/detection/find.h>
#include <selvedge/narrowphase/ccd_methods.h>

#include <algorithm>
#include <array>

// Crossings by the continuous test. A closed edge p q meets a closed triangle if and only if the
// point p + t (q - p) lies on it for some t in [0,1]: the question that the narrow phase answers
// for a point that moves from p to q past a triangle at rest. Its exact answer, degenerate edges
// and triangles included, is therefore an exact answer here, with no second set of predicates.
//
// Two triangles have a common point if and only if an edge of one meets the other.

namespace selvedge {
namespace {

bool share_a_vertex(const Edge& edge, const Triangle& triangle) {
  return std::any_of(triangle.begin(), triangle.end(),
                     [&](std::int32_t v) { return v == edge[0] || v == edge[1]; });
}

SurfaceView at_rest(const SurfaceView& surface) {
  return {surface.x_t0, surface.x_t0, surface.edges, surface.triangles, 0.0, surface.static_id};
}

}  // namespace

EdgeTriangleTest::EdgeTriangleTest() : broad_(make_bvh_aabb()), narrow_(make_ccd_exact()) {}

void EdgeTriangleTest::find(const SurfaceView& a, const SurfaceView& b,
                            std::vector<EdgeTrianglePair>& out) {
  find_candidates(a, b);
  decide(b, out);
}

void EdgeTriangleTest::find_self(const SurfaceView& a, std::vector<EdgeTrianglePair>& out) {
  find_candidates(a, a);
  std::erase_if(pairs_.point_triangle, [&](const PointTrianglePair& pair) {
    return share_a_vertex(a.edges[pair.point], a.triangles[pair.triangle]);
  });
  decide(a, out);
}

void EdgeTriangleTest::find_candidates(const SurfaceView& a, const SurfaceView& b) {
  from_.clear();
  to_.clear();
  from_.reserve(a.edges.size());
  to_.reserve(a.edges.size());
  for (const Edge& edge : a.edges) {
    from_.push_back(a.x_t0[edge[0]]);
    to_.push_back(a.x_t0[edge[1]]);
  }
  broad_->find_pairs({from_, to_, {}, {}}, at_rest(b), pairs_);
  pairs_.triangle_point.clear();
  pairs_.edge_edge.clear();
}

// An edge that ends at the place of a corner meets the triangle. In surfaces whose triangles each
// have vertices of their own, most pairs are of this kind.
void EdgeTriangleTest::take_equal_corners(const SurfaceView& b,
                                          std::vector<EdgeTrianglePair>& out) {
  out.clear();
  std::erase_if(pairs_.point_triangle, [&](const PointTrianglePair& pair) {
    const Vec3 &p = from_[pair.point], &q = to_[pair.point];
    const Triangle& t = b.triangles[pair.triangle];
    const bool equal = std::any_of(
        t.begin(), t.end(), [&](std::int32_t v) { return b.x_t0[v] == p || b.x_t0[v] == q; });
    if (equal) out.push_back({pair.point, pair.triangle});
    return equal;
  });
}

void EdgeTriangleTest::decide(const SurfaceView& b, std::vector<EdgeTrianglePair>& out) {
  take_equal_corners(b, out);
  const auto sure = static_cast<std::ptrdiff_t>(out.size());
  narrow_->find_contacts({from_, to_, {}, {}}, at_rest(b), pairs_, found_);
  // A contact names the corners of the triangle, not the triangle; contacts are in pair order.
  auto found = found_.begin();
  for (const PointTrianglePair& pair : pairs_.point_triangle) {
    if (found == found_.end()) break;
    const Triangle& t = b.triangles[pair.triangle];
    if (found->vertex != std::array<std::int32_t, 4>{pair.point, t[0], t[1], t[2]}) continue;
    out.push_back({pair.point, pair.triangle});
    ++found;
  }
  std::inplace_merge(out.begin(), out.begin() + sure, out.end());
  for (auto* ends : {&from_, &to_}) *ends = std::vector<Vec3>();
}

TrianglesOfEdges::TrianglesOfEdges(std::span<const Edge> edges,
                                   std::span<const Triangle> triangles) {
  std::vector<EdgeTrianglePair> pairs;
  pairs.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
      const auto at = std::lower_bound(edges.begin(), edges.end(), Edge{low, high});
      pairs.push_back(
          {static_cast<std::int32_t>(at - edges.begin()), static_cast<std::int32_t>(t)});
    }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  begin_.assign(edges.size() + 1, 0);
  for (const EdgeTrianglePair& pair : pairs) {
    ++begin_[static_cast<std::size_t>(pair.edge) + 1];
    triangles_.push_back(pair.triangle);
  }
  for (std::size_t e = 0; e < edges.size(); ++e) begin_[e + 1] += begin_[e];
}

std::span<const std::int32_t> TrianglesOfEdges::at(std::int32_t edge) const {
  const auto e = static_cast<std::size_t>(edge);
  return std::span(triangles_).subspan(begin_[e], begin_[e + 1] - begin_[e]);
}

}  // namespace selvedge
