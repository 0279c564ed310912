// SPDX-License-Identifier: MIT
#include <selvedge/detection/detail/common_vertices.h>
#include <selvedge/detection/detail/passages.h>
#include <selvedge/detection/find.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/internal/triangles_cross.h>

#include <algorithm>
#include <array>
#include <iterator>

// Triangles with at most one common vertex meet beyond it if and only if an edge of one meets the
// other without having a vertex in common with it: what two convex sets share beyond a common
// corner goes on from there up to the edge opposite the corner, in the one that ends first.
//
// Triangles with a common edge that have area meet beyond it if and only if they lie in one plane
// on the same side of the edge.

namespace selvedge {
namespace {

using Corners = std::array<Vec3, 3>;

Corners corners(std::span<const Vec3> x, const Triangle& t) { return {x[t[0]], x[t[1]], x[t[2]]}; }

void sort_unique(std::vector<TrianglePair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

/// Sorts pairs that meet into those that cross and those that touch.
void add_meetings(std::span<const TrianglePair> pairs, const SurfaceView& a, const SurfaceView& b,
                  TriangleMeetings& out) {
  for (const TrianglePair& pair : pairs) {
    const bool cross = triangles_cross(corners(a.x_t0, a.triangles[pair.triangle_a]),
                                       corners(b.x_t0, b.triangles[pair.triangle_b]));
    (cross ? out.crossings : out.touches).push_back(pair);
  }
}

/// Whether the vertex `edge[0]`, or the edge, takes part in a test against a triangle or an edge.
bool touch_at_rest(const NarrowPhase& narrow, ContactKind kind, const std::array<Vec3, 4>& x) {
  double toi = 0.0;
  return narrow.collides({kind, x, x}, toi);
}

bool a_corner_touches(const NarrowPhase& narrow, std::span<const Vec3> x, const Triangle& s,
                      const Triangle& t) {
  return std::any_of(s.begin(), s.end(), [&](std::int32_t v) {
    return !detail::names(t, v) &&
           touch_at_rest(narrow, ContactKind::point_triangle, {x[v], x[t[0]], x[t[1]], x[t[2]]});
  });
}

bool edges_touch(const NarrowPhase& narrow, std::span<const Vec3> x, const Triangle& s,
                 const Triangle& t) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Edge e{s[i], s[(i + 1) % 3]}, f{t[j], t[(j + 1) % 3]};
      if (e[0] == f[0] || e[0] == f[1] || e[1] == f[0] || e[1] == f[1]) continue;
      if (touch_at_rest(narrow, ContactKind::edge_edge, {x[e[0]], x[e[1]], x[f[0]], x[f[1]]}))
        return true;
    }
  return false;
}

/// For triangles with a common edge, or of which one names a vertex twice.
void add_neighbours(const NarrowPhase& narrow, const SurfaceView& a, const TrianglePair& pair,
                    TriangleMeetings& out) {
  const std::span<const Vec3> x = a.x_t0;
  const Triangle &s = a.triangles[pair.triangle_a], &t = a.triangles[pair.triangle_b];
  const Corners of_s = corners(x, s), of_t = corners(x, t);
  if (triangles_cross(of_s, of_t)) {
    out.crossings.push_back(pair);
    return;
  }
  if (has_area(of_s) && has_area(of_t)) return;
  if (a_corner_touches(narrow, x, s, t) || a_corner_touches(narrow, x, t, s) ||
      edges_touch(narrow, x, s, t))
    out.touches.push_back(pair);
}

bool evidently_open(std::span<const Vec3> x, const Triangle& s, const Triangle& t) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const std::int32_t v = s[i], w = s[(i + 1) % 3];
      if ((v == t[j] && w == t[(j + 1) % 3]) || (w == t[j] && v == t[(j + 1) % 3]))
        return evidently_open_at_edge(x[v], x[w], x[s[(i + 2) % 3]], x[t[(j + 2) % 3]]);
    }
  return false;
}

void add_triangles_of(const std::vector<EdgeTrianglePair>& met, const SurfaceView& edges_of,
                      std::vector<TrianglePair>& pairs) {
  if (met.empty()) return;
  const TrianglesOfEdges at_edge(edges_of.edges, edges_of.triangles);
  for (const auto& [edge, triangle] : met)
    for (const std::int32_t own : at_edge.at(edge)) pairs.push_back({own, triangle});
}

}  // namespace

std::vector<TrianglePair> TriangleMeetings::all() const {
  std::vector<TrianglePair> pairs;
  std::merge(crossings.begin(), crossings.end(), touches.begin(), touches.end(),
             std::back_inserter(pairs));
  return pairs;
}

TriangleTest::TriangleTest() : narrow_(make_ccd_exact()) {}

void TriangleTest::find(const SurfaceView& a, const SurfaceView& b, TriangleMeetings& out) {
  out = {};
  std::vector<TrianglePair> pairs, swapped;
  edges_.find(a, b, met_);
  add_triangles_of(met_, a, pairs);
  edges_.find(b, a, met_);
  add_triangles_of(met_, b, swapped);
  for (const auto& [of_b, of_a] : swapped) pairs.push_back({of_a, of_b});
  sort_unique(pairs);
  add_meetings(pairs, a, b, out);
  detail::move_passages(a, b, out);
}

void TriangleTest::find_self(const SurfaceView& a, TriangleMeetings& out) {
  out = {};
  std::vector<TrianglePair> pairs;
  edges_.find_self(a, met_);
  add_triangles_of(met_, a, pairs);
  for (TrianglePair& pair : pairs)
    if (pair.triangle_b < pair.triangle_a) std::swap(pair.triangle_a, pair.triangle_b);
  sort_unique(pairs);
  add_meetings(pairs, a, a, out);
  add_folded(a, out);
  detail::move_passages(a, a, out);
}

void TriangleTest::find_folded(const SurfaceView& a, TriangleMeetings& out) {
  out = {};
  add_folded(a, out);
}

void TriangleTest::add_folded(const SurfaceView& a, TriangleMeetings& out) {
  for (const TrianglePair& pair : detail::pairs_with_common_edge(a.triangles, a.x_t0.size()))
    if (!evidently_open(a.x_t0, a.triangles[pair.triangle_a], a.triangles[pair.triangle_b]))
      add_neighbours(*narrow_, a, pair, out);
  sort_unique(out.crossings);
  sort_unique(out.touches);
}

}  // namespace selvedge
