// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/broadphase/detail/surface_check.h>
#include <selvedge/broadphase/detail/swept_box.h>
#include <selvedge/core/base/internal/stopwatch.h>

#include <array>
#include <chrono>
#include <concepts>
#include <string>
#include <utility>
#include <vector>

namespace selvedge::detail {

/// The common frame of the detectors whose engines work on lists of boxes. It checks the surfaces,
/// computes the swept and inflated boxes of their points, edges and triangles, lets the engine find
///   points of a × triangles of b, points of b × triangles of a, edges of a × edges of b, or
///   points × triangles and edges × edges of one surface, without those that share a vertex,
/// and returns the sorted result. An engine that reports each pair of boxes that overlap in double
/// once thus makes a detector that equals brute force.

/// Maximum number of parts of an engine's work, which threads fill at the same time.
inline constexpr std::size_t kBoxPairParts = 128;
/// Number of items per part if n items are divided into at most kBoxPairParts parts. > 0
constexpr std::size_t part_grain(std::size_t n) {
  return std::max<std::size_t>(1, (n + kBoxPairParts - 1) / kBoxPairParts);
}

/// The boxes of all primitives of one surface.
struct SurfaceBoxes {
  std::vector<DoubleBox> points, edges, triangles;

  void fit(const SurfaceView& surface);
  std::size_t bytes() const {
    return (points.capacity() + edges.capacity() + triangles.capacity()) * sizeof(DoubleBox);
  }
};

/// Receives the pairs that an engine finds, in any order, each once.
class PairParts {
 public:
  /// `self`: the surface whose pairs with a common vertex are omitted, or null.
  PairParts(std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list, const SurfaceView* self)
      : parts_(parts), list_(list), self_(self), edges_(list == &FoundPairs::edge_edge) {}

  /// Adds the pair of the first list's box i and the second list's box j (for a list with itself,
  /// in either order) to part `part`, which no other thread may use at that time.
  void add(std::size_t part, std::int32_t i, std::int32_t j) {
    if (self_ && has_common_vertex(i, j)) return;
    if (self_ && edges_ && j < i) std::swap(i, j);
    PairBuffer& buffer = parts_[part].*list_;
    std::uint64_t* place = buffer.room(1);
    *place = static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) << 32 |
             static_cast<std::uint32_t>(j);
    buffer.advance_to(place + 1);
  }

 private:
  bool has_common_vertex(std::int32_t i, std::int32_t j) const {
    return edges_ ? share_vertex(self_->edges[i], self_->edges[j])
                  : contains(self_->triangles[j], i);
  }

  std::vector<FoundPairs>& parts_;
  PairBuffer FoundPairs::*list_;
  const SurfaceView* self_;
  bool edges_;
};

/// An engine finds the pairs of boxes that overlap. A Structure is built from one list of boxes and
/// kept as long as the list, which outlives it.
///   prepare(a, b): called first with the boxes of both surfaces (b null for one with itself), to
///     choose a cell size or an axis; returns false if earlier structures no longer fit;
///   build(boxes, structure): builds the structure, replacing its previous contents;
///   find_pairs(a, b, out): every pair of a box of a and one of b that overlap;
///   find_self_pairs(a, out): every pair of two different boxes of a that overlap, once;
///   bytes(): memory of the structure, and of the engine itself.
template <class E>
concept BoxPairEngine = requires(E& engine, typename E::Structure& structure,
                                 const SurfaceBoxes& surface, const std::vector<DoubleBox>& boxes,
                                 PairParts& out) {
  { engine.prepare(surface, &surface) } -> std::same_as<bool>;
  engine.build(boxes, structure);
  engine.find_pairs(structure, structure, out);
  engine.find_self_pairs(structure, out);
  { structure.bytes() } -> std::convertible_to<std::size_t>;
  { engine.bytes() } -> std::convertible_to<std::size_t>;
};

/// The boxes of a surface, kept while it is static.
class KeptBoxes {
 public:
  SurfaceBoxes boxes;

  /// Checks the surface and computes its boxes; returns false if those of the last call are still
  /// valid. Call `keep` when all that follows from them is complete, too.
  bool fit(const SurfaceView& surface, const char* name);
  void keep(const SurfaceView& surface);
  void forget() { static_id_ = 0; }

 private:
  bool is_same_static(const SurfaceView& surface) const;

  std::uint64_t static_id_ = 0;
  double thickness_ = 0.0;
  std::array<std::size_t, 3> counts_{};
};

template <BoxPairEngine Engine>
class BoxPairDetector final : public BroadPhase {
 public:
  BoxPairDetector(BroadPhaseTraits traits, Engine engine)
      : traits_(std::move(traits)), engine_(std::move(engine)), parts_(kBoxPairParts) {}

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    out.clear();
    const auto begin = Clock::now();
    const bool new_a = kept_[0].fit(a, "first surface");
    const bool new_b = kept_[1].fit(b, "second surface");
    const bool still_fit = engine_.prepare(kept_[0].boxes, &kept_[1].boxes);
    if (new_a || !still_fit) build(kept_[0], a);
    if (new_b || !still_fit) build(kept_[1], b);
    const auto built = Clock::now();
    find([&] {
      PairParts point_triangle(parts_, &FoundPairs::point_triangle, nullptr);
      engine_.find_pairs(kept_[0].points, kept_[1].triangles, point_triangle);
      PairParts triangle_point(parts_, &FoundPairs::triangle_point, nullptr);
      engine_.find_pairs(kept_[1].points, kept_[0].triangles, triangle_point);
      PairParts edge_edge(parts_, &FoundPairs::edge_edge, nullptr);
      engine_.find_pairs(kept_[0].edges, kept_[1].edges, edge_edge);
    });
    collector_.collect(parts_, a, &b, out);
    note_cost(begin, built);
  }

  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    out.clear();
    const auto begin = Clock::now();
    const bool is_new = kept_[0].fit(a, "surface");
    if (!engine_.prepare(kept_[0].boxes, nullptr)) {
      kept_[1].forget();
      build(kept_[0], a);
    } else if (is_new) {
      build(kept_[0], a);
    }
    const auto built = Clock::now();
    find([&] {
      PairParts point_triangle(parts_, &FoundPairs::point_triangle, &a);
      engine_.find_pairs(kept_[0].points, kept_[0].triangles, point_triangle);
      PairParts edge_edge(parts_, &FoundPairs::edge_edge, &a);
      engine_.find_self_pairs(kept_[0].edges, edge_edge);
    });
    collector_.collect(parts_, a, nullptr, out);
    note_cost(begin, built);
  }

  BroadPhaseTraits traits() const override { return traits_; }
  BroadPhaseCost last_cost() const override { return cost_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Structure = typename Engine::Structure;

  /// Data kept for one surface.
  struct Kept : KeptBoxes {
    Structure points, edges, triangles;

    std::size_t bytes() const {
      return boxes.bytes() + points.bytes() + edges.bytes() + triangles.bytes();
    }
  };

  void build(Kept& kept, const SurfaceView& surface) {
    kept.forget();
    engine_.build(kept.boxes.points, kept.points);
    engine_.build(kept.boxes.edges, kept.edges);
    engine_.build(kept.boxes.triangles, kept.triangles);
    kept.keep(surface);
  }

  /// Clears the parts and fills them within the budget.
  template <class Fill>
  void find(Fill fill) {
    PairTally tally(budget(), PairBuffer::kBytesPerPair);
    for (FoundPairs& part : parts_) part.start(&tally);
    fill();
    for (FoundPairs& part : parts_) part.finish();
  }

  void note_cost(Clock::time_point begin, Clock::time_point built) {
    cost_.build_s = std::chrono::duration<double>(built - begin).count();
    cost_.query_s = seconds_since(built);
    cost_.bytes = engine_.bytes() + collector_.bytes();
    for (const Kept& kept : kept_) cost_.bytes += kept.bytes();
    for (const FoundPairs& part : parts_) cost_.bytes += part.bytes();
  }

  BroadPhaseTraits traits_;
  Engine engine_;
  std::array<Kept, 2> kept_;
  std::vector<FoundPairs> parts_;
  PairCollector collector_;
  BroadPhaseCost cost_;
};

}  // namespace selvedge::detail
