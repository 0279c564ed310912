// SPDX-License-Identifier: MIT
// Two meshes that move, through every conservative detector of the library: those that report the
// pairs of overlapping boxes report brute force's, others at least what collides by the judge. Each
// detector is kept over two steps, so that refits are tried, too.
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/judge/judge.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "fuzz.h"

namespace {

using namespace selvedge;

struct Mesh {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Triangle> triangles;
  std::vector<Edge> edges;
  double thickness = 0.0;

  Mesh(fuzz::Bytes& in) : x_t0(3 + in.below(10)), thickness(in.below(4) * 0.25) {
    const int n = static_cast<int>(x_t0.size());
    const int count = 1 + in.below(16);
    for (int k = 0; k < count; ++k) {
      const int a = in.below(n), b = in.below(n), c = in.below(n);
      if (a != b && b != c && c != a) triangles.push_back({a, b, c});
    }
    edges = unique_edges(triangles);
    for (Vec3& x : x_t0) x = point(in);
    x_t1 = x_t0;
    move(in);
  }
  void move(fuzz::Bytes& in) {
    x_t0 = x_t1;
    if (in.below(4) == 0) return;  // rests
    for (Vec3& x : x_t1) x = point(in);
  }
  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, thickness}; }

  static Vec3 point(fuzz::Bytes& in) {
    // detectors compute swept boxes, which must not overflow
    const auto bounded = [&] { return std::clamp(in.coordinate(), -1e150, 1e150); };
    const double x = bounded(), y = bounded(), z = bounded();
    return {x, y, z};
  }
};

bool collides(const SurfaceView& a, const SurfaceView& b, bool edges, const auto& first,
              const auto& second) {
  std::array<Vec3, 8> points;
  std::size_t k = 0;
  for (const std::int32_t v : first) points[k] = a.x_t0[v], points[4 + k++] = a.x_t1[v];
  for (const std::int32_t v : second) points[k] = b.x_t0[v], points[4 + k++] = b.x_t1[v];
  return paths_touch(edges ? PathKind::edge_edge : PathKind::point_triangle, points);
}

/// The pairs of `all` that collide.
CandidatePairs colliding(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& all) {
  CandidatePairs out;
  for (const PointTrianglePair& p : all.point_triangle)
    if (collides(a, b, false, std::array{p.point}, b.triangles[p.triangle]))
      out.point_triangle.push_back(p);
  for (const PointTrianglePair& p : all.triangle_point)
    if (collides(b, a, false, std::array{p.point}, a.triangles[p.triangle]))
      out.triangle_point.push_back(p);
  for (const EdgeEdgePair& p : all.edge_edge)
    if (collides(a, b, true, a.edges[p.edge_a], b.edges[p.edge_b])) out.edge_edge.push_back(p);
  return out;
}

template <class T>
bool includes(const std::vector<T>& all, const std::vector<T>& part) {
  return std::includes(all.begin(), all.end(), part.begin(), part.end());
}

void check(PairSet promise, const CandidatePairs& found, const CandidatePairs& boxes,
           const CandidatePairs& hits) {
  const CandidatePairs& least = promise == PairSet::culled ? hits : boxes;
  const bool all = includes(found.point_triangle, least.point_triangle) &&
                   includes(found.triangle_point, least.triangle_point) &&
                   includes(found.edge_edge, least.edge_edge);
  if (!all || (promise == PairSet::boxes && found.size() != boxes.size())) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  static const BroadPhaseRegistry registry = broad_phases();
  fuzz::Bytes in(bytes, n);
  Mesh a(in), b(in);
  const auto reference = make_brute_force();
  std::vector<std::unique_ptr<BroadPhase>> detectors;
  for (const auto& [name, entry] : registry) detectors.push_back(entry());
  for (int step = 0; step < 2; ++step) {
    CandidatePairs boxes, self_boxes, found;
    reference->find_pairs(a.view(), b.view(), boxes);
    reference->find_self_pairs(a.view(), self_boxes);
    const CandidatePairs hits = colliding(a.view(), b.view(), boxes);
    const CandidatePairs self_hits = colliding(a.view(), a.view(), self_boxes);
    for (const auto& detector : detectors) {
      const BroadPhaseTraits traits = detector->traits();
      if (traits.guarantee != Guarantee::conservative || traits.closed_body_only) continue;
      detector->find_pairs(a.view(), b.view(), found);
      check(traits.pairs, found, boxes, hits);
      if (!traits.self) continue;
      detector->find_self_pairs(a.view(), found);
      check(traits.pairs, found, self_boxes, self_hits);
    }
    a.move(in);
    b.move(in);
  }
  return 0;
}
