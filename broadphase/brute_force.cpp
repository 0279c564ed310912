// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/pair_tally.h>
#include <selvedge/broadphase/detail/surface_check.h>
#include <selvedge/broadphase/detail/swept_box.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>

#include <chrono>

namespace selvedge {
namespace {

using detail::DoubleBox;

/// The boxes of all primitives of one surface.
struct PrimitiveBoxes {
  std::vector<DoubleBox> points, edges, triangles;

  explicit PrimitiveBoxes(const SurfaceView& s)
      : points(s.x_t0.size()), edges(s.edges.size()), triangles(s.triangles.size()) {
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] = detail::swept_box(s, static_cast<std::int32_t>(i));
    for (std::size_t i = 0; i < edges.size(); ++i) edges[i] = detail::swept_box(s, s.edges[i]);
    for (std::size_t i = 0; i < triangles.size(); ++i)
      triangles[i] = detail::swept_box(s, s.triangles[i]);
  }
  std::size_t bytes() const {
    return (points.size() + edges.size() + triangles.size()) * sizeof(DoubleBox);
  }
};

/// A pair takes 8 bytes in the result and, in a part that grows by doubling, 16 bytes, plus 8 while
/// it is copied.
constexpr std::size_t kBytesPerPair = 32;

/// Appends Pair{i, j}, in order, for all i, j whose boxes overlap, with `first_of(i)` <= j, and for
/// which `keep` returns true.
template <class Pair, class FirstOf, class Keep>
void all_against_all(const std::vector<DoubleBox>& a, const std::vector<DoubleBox>& b,
                     FirstOf first_of, Keep keep, std::vector<Pair>& out,
                     detail::PairTally& tally) {
  constexpr std::size_t grain = 256;
  std::vector<std::vector<Pair>> found(a.size() / grain + 1);
  parallel_for(a.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<Pair>& mine = found[begin / grain];
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t before = mine.size();
      for (std::size_t j = first_of(i); j < b.size(); ++j)
        if (detail::overlap(a[i], b[j])) {
          const Pair pair{static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)};
          if (keep(pair)) mine.push_back(pair);
        }
      tally.add(mine.size() - before);
    }
  });
  for (const std::vector<Pair>& part : found) out.insert(out.end(), part.begin(), part.end());
}

constexpr auto kFromZero = [](std::size_t) { return std::size_t{0}; };
constexpr auto kKeepAll = [](const auto&) { return true; };

class BruteForce final : public BroadPhase {
 public:
  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    check(a, "first surface");
    check(b, "second surface");
    out.clear();
    const auto begin = std::chrono::steady_clock::now();
    const PrimitiveBoxes boxes_a(a), boxes_b(b);
    within_budget(out, [&](detail::PairTally& tally) {
      all_against_all(boxes_a.points, boxes_b.triangles, kFromZero, kKeepAll, out.point_triangle,
                      tally);
      all_against_all(boxes_b.points, boxes_a.triangles, kFromZero, kKeepAll, out.triangle_point,
                      tally);
      all_against_all(boxes_a.edges, boxes_b.edges, kFromZero, kKeepAll, out.edge_edge, tally);
    });
    note_cost(begin, boxes_a.bytes() + boxes_b.bytes());
  }

  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    check(a, "surface");
    out.clear();
    const auto begin = std::chrono::steady_clock::now();
    const PrimitiveBoxes boxes(a);
    const auto apart = [&](const PointTrianglePair& p) {
      return !detail::contains(a.triangles[p.triangle], p.point);
    };
    const auto edges_apart = [&](const EdgeEdgePair& p) {
      return !detail::share_vertex(a.edges[p.edge_a], a.edges[p.edge_b]);
    };
    const auto after = [](std::size_t i) { return i + 1; };
    within_budget(out, [&](detail::PairTally& tally) {
      all_against_all(boxes.points, boxes.triangles, kFromZero, apart, out.point_triangle, tally);
      all_against_all(boxes.edges, boxes.edges, after, edges_apart, out.edge_edge, tally);
    });
    note_cost(begin, boxes.bytes());
  }

  BroadPhaseTraits traits() const override {
    return {.all_pairs = true, .source = "every swept box against every other; the reference"};
  }
  BroadPhaseCost last_cost() const override { return cost_; }

 private:
  static void check(const SurfaceView& surface, const char* name) {
    detail::check_shape(surface, name);
    detail::check_indices(surface, name);
    detail::check_finite(surface, name);
  }
  template <class Find>
  void within_budget(CandidatePairs& out, Find find) const {
    detail::PairTally tally(budget(), kBytesPerPair);
    try {
      find(tally);
    } catch (const BudgetExceeded&) {
      out.clear();
      throw;
    }
  }
  void note_cost(std::chrono::steady_clock::time_point begin, std::size_t bytes) {
    cost_ = {.query_s = seconds_since(begin), .bytes = bytes};
  }

  BroadPhaseCost cost_;
};

}  // namespace

std::unique_ptr<BroadPhase> make_brute_force() { return std::make_unique<BruteForce>(); }

void register_brute_force(BroadPhaseRegistry& registry) {
  registry.add("brute_force", {}, [](const MethodOptions&) { return make_brute_force(); });
}

}  // namespace selvedge
