// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/box_pairs.h>
#include <selvedge/broadphase/detail/bvh.h>
#include <selvedge/broadphase/detail/pair_tally.h>
#include <selvedge/broadphase/detail/surface_check.h>
#include <selvedge/broadphase/detail/swept_box.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace selvedge {
namespace {

using detail::DoubleBox;

constexpr std::size_t kVertexGrain = 8192;
constexpr std::size_t kPairGrain = 16384;  // about 50 µs of work
/// Number of lists that are kept, each for one surface or one pair of surfaces.
constexpr std::size_t kKeptLists = 4;
/// Number of calls without a list before the list is reconsidered.
constexpr int kPlainCalls = 16;
/// 48 bytes in the inner search, 8 in the list, 8 in the result.
constexpr std::size_t kBytesPerKeptPair = 64;

template <class T>
bool same_bytes(std::span<const T> a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// Largest value of body(begin, end) over fixed ranges of vertices.
template <class Body>
double parallel_max(std::size_t n, Body body) {
  std::vector<double> parts(n / kVertexGrain + 1, -std::numeric_limits<double>::infinity());
  parallel_for(n, kVertexGrain, [&](std::size_t begin, std::size_t end) {
    parts[begin / kVertexGrain] = body(begin, end);
  });
  return *std::max_element(parts.begin(), parts.end());
}

/// One surface of a kept list.
class ListedSurface {
 public:
  bool has_topology_of(const SurfaceView& s) const {
    return s.x_t0.size() == searched_.size() && same_bytes(s.edges, edges_) &&
           same_bytes(s.triangles, triangles_);
  }

  /// Records the boxes of a search for pairs: those of `s`, whose thickness includes the margin.
  void note_search(const SurfaceView& s, double margin) {
    edges_.assign(s.edges.begin(), s.edges.end());
    triangles_.assign(s.triangles.begin(), s.triangles.end());
    margin_ = margin;
    searched_id_ = s.static_id;
    fitted_id_ = 0;
    searched_.resize(s.x_t0.size());
    parallel_for(searched_.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v)
        searched_[v] = detail::swept_box(s, static_cast<std::int32_t>(v));
    });
    searched_thickness_ = s.thickness;
  }

  /// How far a vertex box extends beyond its box of the search, at most; <= 0 if none does. The
  /// sign is exact, because a difference of doubles is negative if and only if the first is less.
  double overshoot(const SurfaceView& s) const {
    if (s.static_id != 0 && s.static_id == searched_id_) return s.thickness - searched_thickness_;
    return parallel_max(searched_.size(), [&](std::size_t begin, std::size_t end) {
      double most = -std::numeric_limits<double>::infinity();
      for (std::size_t v = begin; v < end; ++v) {
        const DoubleBox box = detail::swept_box(s, static_cast<std::int32_t>(v));
        for (int k = 0; k < 3; ++k)
          most = std::max({most, searched_[v].lo[k] - box.lo[k], box.hi[k] - searched_[v].hi[k]});
      }
      return most;
    });
  }

  /// Distance that the fastest vertex has moved since the search, in one coordinate and on one
  /// side, metres.
  double drift(double overshoot) const { return std::max(0.0, overshoot + margin_); }

  const detail::SurfaceBoxes& fit_boxes(const SurfaceView& s) {
    const bool unchanged =
        s.static_id != 0 && s.static_id == fitted_id_ && s.thickness == fitted_thickness_;
    if (!unchanged) boxes_.fit(s);
    fitted_id_ = s.static_id;
    fitted_thickness_ = s.thickness;
    return boxes_;
  }

  bool is_static(const SurfaceView& s) const {
    return s.static_id != 0 && s.static_id == searched_id_;
  }
  std::size_t bytes() const {
    return searched_.capacity() * sizeof(DoubleBox) + edges_.capacity() * sizeof(Edge) +
           triangles_.capacity() * sizeof(Triangle) + boxes_.bytes();
  }

 private:
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
  std::vector<DoubleBox> searched_;  ///< per vertex, inflated by thickness and margin
  double margin_ = 0.0, searched_thickness_ = 0.0, fitted_thickness_ = 0.0;
  std::uint64_t searched_id_ = 0, fitted_id_ = 0;
  detail::SurfaceBoxes boxes_;
};

/// Chooses how many steps of the fastest vertex the margin should cover, by the mean time of a
/// call.
class MarginChoice {
 public:
  /// 0: every call searches without a list.
  double steps() const { return kSteps[level_]; }

  /// Records the time of a call with the current list.
  void note_call(double seconds) {
    sum_ += seconds;
    ++calls_;
  }

  /// Chooses the margin of a new list.
  void choose() {
    if (calls_ > 0) {
      const double mean = sum_ / calls_;
      cost_[level_] = known(level_) ? 0.5 * (cost_[level_] + mean) : mean;
      sum_ = calls_ = 0;
      if (++lives_ % kLivesRemembered == 0) forget_others();
    }
    level_ = next();
  }

 private:
  static constexpr int kLevels = 7;
  static constexpr std::array<double, kLevels> kSteps = {0.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0};
  static constexpr int kLivesRemembered = 48;  // after that the scene may have changed
  // A larger margin is attempted only if the previous one was at most this much worse: the number
  // of pairs found grows with its cube.
  static constexpr double kWorthTrying = 1.1;
  static constexpr double kUnknown = -1.0;

  bool known(int level) const { return cost_[level] >= 0.0; }

  /// The best level so far, or the next larger one if it is untested and may be better.
  int next() const {
    if (!known(0)) return 0;
    if (!known(1)) return 1;
    int best = 1;
    for (int l = 2; l < kLevels; ++l)
      if (known(l) && cost_[l] < cost_[best]) best = l;
    if (best + 1 < kLevels && !known(best + 1) && cost_[best] < kWorthTrying * cost_[0])
      return best + 1;
    return cost_[best] < cost_[0] ? best : 0;
  }

  void forget_others() {
    for (int l = 0; l < kLevels; ++l)
      if (l != level_) cost_[l] = kUnknown;
  }

  std::array<double, kLevels> cost_ = {kUnknown, kUnknown, kUnknown, kUnknown,
                                       kUnknown, kUnknown, kUnknown};
  int level_ = 0, lives_ = 0;
  double sum_ = 0.0, calls_ = 0.0;
};

struct KeptList {
  ListedSurface a, b;  ///< b unused with a surface against itself
  bool self = false;
  bool has_pairs = false;  ///< false: only the boxes are kept, to measure the motion
  CandidatePairs pairs;
  MarginChoice choice;
  double speed = 0.0;  ///< metres per call, of the fastest vertex during the previous list
  int age = 0;         ///< calls since the search
  std::uint64_t last_use = 0;

  bool serves(const SurfaceView& sa, const SurfaceView& sb, bool is_self) const {
    return last_use > 0 && self == is_self && a.has_topology_of(sa) &&
           (is_self || b.has_topology_of(sb));
  }
  std::size_t bytes() const {
    return a.bytes() + b.bytes() +
           (pairs.point_triangle.capacity() + pairs.triangle_point.capacity()) *
               sizeof(PointTrianglePair) +
           pairs.edge_edge.capacity() * sizeof(EdgeEdgePair);
  }
};

/// Writes the `pairs` for which `overlaps` is true to `out`, in order. Threads work on ranges,
/// which are then joined.
template <class Pair, class Overlaps>
void filter(const std::vector<Pair>& pairs, Overlaps overlaps, std::vector<Pair>& out) {
  out.resize(pairs.size());
  std::vector<std::size_t> kept(pairs.size() / kPairGrain + 1, 0);
  parallel_for(pairs.size(), kPairGrain, [&](std::size_t begin, std::size_t end) {
    Pair* next = out.data() + begin;
    for (std::size_t i = begin; i < end; ++i) {
      *next = pairs[i];
      next += overlaps(pairs[i]);
    }
    kept[begin / kPairGrain] = static_cast<std::size_t>(next - (out.data() + begin));
  });
  std::size_t size = 0;
  for (std::size_t part = 0; part < kept.size(); ++part) {
    const auto begin = out.begin() + static_cast<std::ptrdiff_t>(part * kPairGrain);
    if (part * kPairGrain != size && kept[part] > 0)
      std::copy(begin, begin + static_cast<std::ptrdiff_t>(kept[part]),
                out.begin() + static_cast<std::ptrdiff_t>(size));
    size += kept[part];
  }
  out.resize(size);
}

class VerletList final : public BroadPhase {
 public:
  VerletList(std::unique_ptr<BroadPhase> inner, const VerletListConfig& config)
      : inner_(std::move(inner)), config_(config) {
    const BroadPhaseTraits traits = inner_->traits();
    if (traits.guarantee != Guarantee::conservative || traits.pairs == PairSet::culled)
      throw std::invalid_argument(
          "verlet list: the inner detector must report every pair whose boxes overlap");
    if (std::isnan(config.margin) || std::isinf(config.margin))
      throw std::invalid_argument(
          "verlet list: the margin must be finite; a negative one is chosen automatically");
  }

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    find(in_the_world(a), in_the_world(b), false, out);
  }
  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    find(in_the_world(a), in_the_world(a), true, out);
  }

  BroadPhaseTraits traits() const override {
    BroadPhaseTraits traits = inner_->traits();
    traits.pairs = PairSet::boxes;
    traits.rigid = false;
    traits.source =
        "lists kept for several steps, by L. Verlet, Computer \"experiments\" on classical fluids "
        "I, 1967; around: " +
        traits.source;
    return traits;
  }
  BroadPhaseCost last_cost() const override {
    BroadPhaseCost cost = cost_;
    cost.bytes = inner_->last_cost().bytes;
    for (const KeptList& list : lists_) cost.bytes += list.bytes();
    return cost;
  }

 private:
  using Clock = std::chrono::steady_clock;

  /// Removes the rigid motion. In the frame of a body other boxes overlap, and the pairs of a list
  /// would depend on when it was made.
  static SurfaceView in_the_world(SurfaceView s) {
    s.rigid = nullptr;
    return s;
  }

  void find(const SurfaceView& a, const SurfaceView& b, bool self, CandidatePairs& out) {
    const auto begin = Clock::now();
    cost_ = {};
    detail::check_shape(a, self ? "surface" : "first surface");
    if (!self) detail::check_shape(b, "second surface");
    KeptList* list = choose_list(a, b, self);
    const bool lives = list && is_alive(*list, a, b);
    cost_.refit_s = seconds_since(begin);
    if (!lives) list = &renew(list, a, b, self);
    if (list->has_pairs)
      report(*list, a, b, out);
    else
      search(a, b, self, out);
    list->last_use = ++uses_;
    list->choice.note_call(seconds_since(begin));
  }

  KeptList* choose_list(const SurfaceView& a, const SurfaceView& b, bool self) {
    for (KeptList& list : lists_)
      if (list.serves(a, b, self)) return &list;
    return nullptr;
  }

  /// Whether every vertex lies in its box of the search. Also checks the positions.
  bool is_alive(KeptList& list, const SurfaceView& a, const SurfaceView& b) {
    if (!list.a.is_static(a)) detail::check_finite(a, list.self ? "surface" : "first surface");
    if (!list.self && !list.b.is_static(b)) detail::check_finite(b, "second surface");
    const double of_a = list.a.overshoot(a);
    const double of_b = list.self ? of_a : list.b.overshoot(b);
    ++list.age;
    list.speed = std::max(list.a.drift(of_a), list.self ? 0.0 : list.b.drift(of_b)) / list.age;
    if (list.has_pairs) return of_a <= 0.0 && of_b <= 0.0;
    return list.age < kPlainCalls;
  }

  /// Searches the pairs with a margin, or only records the positions of the surfaces.
  KeptList& renew(KeptList* known, const SurfaceView& a, const SurfaceView& b, bool self) {
    KeptList& list = known ? *known : *oldest();
    if (!known) {
      list.choice = {};
      list.speed = 0.0;
      list.self = self;
    }
    list.choice.choose();
    const double margin = config_.margin >= 0.0 ? config_.margin : list.choice.steps() * list.speed;
    list.has_pairs = config_.margin >= 0.0 || list.choice.steps() > 0.0;
    list.last_use = 0;  // If the search throws, there is no list.
    list.age = 0;
    SurfaceView wide_a = a, wide_b = b;
    const double margin_a = a.static_id == 0 ? margin : 0.0;
    const double margin_b = b.static_id == 0 ? margin : 0.0;
    wide_a.thickness += list.has_pairs ? margin_a : 0.0;
    wide_b.thickness += list.has_pairs ? margin_b : 0.0;
    if (list.has_pairs) list.has_pairs = search_wide(wide_a, wide_b, self, list.pairs);
    list.a.note_search(wide_a, wide_a.thickness - a.thickness);
    if (!self) list.b.note_search(wide_b, wide_b.thickness - b.thickness);
    return list;
  }

  KeptList* oldest() {
    return &*std::min_element(
        lists_.begin(), lists_.end(),
        [](const KeptList& a, const KeptList& b) { return a.last_use < b.last_use; });
  }

  std::size_t limit() const { return detail::PairTally(budget(), kBytesPerKeptPair).limit(); }

  /// Returns false if the margin gives more pairs than the budget allows: then no margin is used.
  bool search_wide(const SurfaceView& a, const SurfaceView& b, bool self, CandidatePairs& out) {
    try {
      search(a, b, self, out);
    } catch (const BudgetExceeded&) {
      return false;
    }
    return true;
  }

  void search(const SurfaceView& a, const SurfaceView& b, bool self, CandidatePairs& out) {
    // The same limit with and without a list, so that the margin does not determine whether a call
    // throws.
    inner_->set_budget({.pairs = limit(), .bytes = std::numeric_limits<std::size_t>::max()});
    const auto begin = Clock::now();
    if (self)
      inner_->find_self_pairs(a, out);
    else
      inner_->find_pairs(a, b, out);
    const BroadPhaseCost inner_cost = inner_->last_cost();
    cost_.build_s += inner_cost.build_s + inner_cost.refit_s;
    cost_.query_s += seconds_since(begin) - inner_cost.build_s - inner_cost.refit_s;
  }

  void report(KeptList& list, const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) {
    const auto begin = Clock::now();
    const detail::SurfaceBoxes& boxes_a = list.a.fit_boxes(a);
    const detail::SurfaceBoxes& boxes_b = list.self ? boxes_a : list.b.fit_boxes(b);
    filter(
        list.pairs.point_triangle,
        [&](const PointTrianglePair& p) {
          return detail::overlap(boxes_a.points[p.point], boxes_b.triangles[p.triangle]);
        },
        out.point_triangle);
    filter(
        list.pairs.triangle_point,
        [&](const PointTrianglePair& p) {
          return detail::overlap(boxes_b.points[p.point], boxes_a.triangles[p.triangle]);
        },
        out.triangle_point);
    filter(
        list.pairs.edge_edge,
        [&](const EdgeEdgePair& p) {
          return detail::overlap(boxes_a.edges[p.edge_a], boxes_b.edges[p.edge_b]);
        },
        out.edge_edge);
    cost_.query_s += seconds_since(begin);
    if (const std::size_t found = out.size(); found > limit()) {
      out.clear();
      throw BudgetExceeded(found, limit(), budget());
    }
  }

  std::unique_ptr<BroadPhase> inner_;
  VerletListConfig config_;
  std::array<KeptList, kKeptLists> lists_;
  std::uint64_t uses_ = 0;
  BroadPhaseCost cost_;
};

}  // namespace

std::unique_ptr<BroadPhase> make_verlet_list(std::unique_ptr<BroadPhase> inner,
                                             const VerletListConfig& config) {
  return std::make_unique<VerletList>(std::move(inner), config);
}

void register_verlet_list(BroadPhaseRegistry& registry) {
  registry.add("verlet_bvh", {},
               [](const MethodOptions&) { return make_verlet_list(make_bvh_aabb(), {}); });
}

}  // namespace selvedge
