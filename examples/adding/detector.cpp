// SPDX-License-Identifier: MIT
// Reports all pairs of primitives whose swept extents along one axis overlap.
#include "additions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace adding {
namespace {

using namespace selvedge;

struct Interval {
  double low, high;
};

class OneAxis final : public BroadPhase {
 public:
  explicit OneAxis(int axis) : axis_(axis) {}

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    out.clear();
    for (std::int32_t p = 0; p < count(a.x_t0); ++p)
      for (std::int32_t t = 0; t < count(b.triangles); ++t)
        if (overlap(extent(a, std::array{p}), extent(b, b.triangles[t])))
          out.point_triangle.push_back({p, t});
    for (std::int32_t p = 0; p < count(b.x_t0); ++p)
      for (std::int32_t t = 0; t < count(a.triangles); ++t)
        if (overlap(extent(b, std::array{p}), extent(a, a.triangles[t])))
          out.triangle_point.push_back({p, t});
    for (std::int32_t i = 0; i < count(a.edges); ++i)
      for (std::int32_t j = 0; j < count(b.edges); ++j)
        if (overlap(extent(a, a.edges[i]), extent(b, b.edges[j]))) out.edge_edge.push_back({i, j});
  }

  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    find_pairs(a, a, out);
    out.triangle_point.clear();
    std::erase_if(out.point_triangle, [&](const PointTrianglePair& pair) {
      return shared(std::array{pair.point}, a.triangles[pair.triangle]);
    });
    std::erase_if(out.edge_edge, [&](const EdgeEdgePair& pair) {
      return pair.edge_a >= pair.edge_b || shared(a.edges[pair.edge_a], a.edges[pair.edge_b]);
    });
  }

  BroadPhaseTraits traits() const override {
    return {.pairs = PairSet::contains_boxes, .all_pairs = true, .source = "docs/adding.md"};
  }

 private:
  static std::int32_t count(const auto& list) { return static_cast<std::int32_t>(list.size()); }
  static bool overlap(const Interval& a, const Interval& b) {
    return a.low <= b.high && b.low <= a.high;
  }
  static bool shared(const auto& one, const auto& other) {
    return std::find_first_of(one.begin(), one.end(), other.begin(), other.end()) != one.end();
  }

  // Inflated by the thickness; rounding must not shrink it.
  Interval extent(const SurfaceView& s, const auto& vertices) const {
    Interval e{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (const std::int32_t v : vertices)
      for (const double x : {s.x_t0[v][axis_], s.x_t1[v][axis_]}) {
        e.low = std::min(e.low, std::nextafter(x - s.thickness, -HUGE_VAL));
        e.high = std::max(e.high, std::nextafter(x + s.thickness, HUGE_VAL));
      }
    return e;
  }

  int axis_;
};

}  // namespace

void register_one_axis(BroadPhaseRegistry& registry) {
  registry.add("one_axis",
               {{.name = "axis",
                 .initial = 2.0,
                 .unit = "1",
                 .least = 0.0,
                 .most = 2.0,
                 .kind = OptionKind::whole,
                 .meaning = "axis of the extents, 0 to 2; best the thin direction of the scene"}},
               [](const MethodOptions& o) { return std::make_unique<OneAxis>(o.whole("axis")); });
}

}  // namespace adding
