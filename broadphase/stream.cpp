// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/swept_box.h>

#include <algorithm>

namespace selvedge {
namespace {

/// The primitives [begin, end) of one kind.
struct Range {
  std::size_t begin, end;

  std::size_t size() const { return end - begin; }
  std::size_t middle() const { return begin + size() / 2; }
};

/// Some edges or triangles of a surface, with only the vertices that they use.
class Piece {
 public:
  /// A range of points needs no copies.
  static SurfaceView of_points(const SurfaceView& s, Range range) {
    return {.x_t0 = s.x_t0.subspan(range.begin, range.size()),
            .x_t1 = s.x_t1.subspan(range.begin, range.size()),
            .edges = {},
            .triangles = {},
            .thickness = s.thickness};
  }
  SurfaceView of_edges(const SurfaceView& s, Range range) {
    take(s, s.edges.subspan(range.begin, range.size()), edges_);
    return view(s.thickness);
  }
  SurfaceView of_triangles(const SurfaceView& s, Range range) {
    take(s, s.triangles.subspan(range.begin, range.size()), triangles_);
    return view(s.thickness);
  }

 private:
  template <class Primitive>
  void take(const SurfaceView& s, std::span<const Primitive> from, std::vector<Primitive>& to) {
    std::vector<std::int32_t> used;
    for (const Primitive& p : from) used.insert(used.end(), p.begin(), p.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const std::int32_t v : used) {
      x_t0_.push_back(s.x_t0[v]);
      x_t1_.push_back(s.x_t1[v]);
    }
    to.assign(from.begin(), from.end());
    for (Primitive& p : to)
      for (std::int32_t& v : p)
        v = static_cast<std::int32_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin());
  }
  SurfaceView view(double thickness) const { return {x_t0_, x_t1_, edges_, triangles_, thickness}; }

  std::vector<Vec3> x_t0_, x_t1_;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
};

/// Sets the detector's budget for the lifetime of the object.
class BudgetOfPieces {
 public:
  BudgetOfPieces(BroadPhase& detector, const PairBudget& piece)
      : detector_(detector), before_(detector.budget()) {
    detector.set_budget(piece);
  }
  ~BudgetOfPieces() { detector_.set_budget(before_); }
  BudgetOfPieces(const BudgetOfPieces&) = delete;
  BudgetOfPieces& operator=(const BudgetOfPieces&) = delete;

 private:
  BroadPhase& detector_;
  PairBudget before_;
};

constexpr auto kDeliverAll = [](const auto&) { return true; };

class Streamer {
 public:
  Streamer(BroadPhase& detector, PairSink sink) : detector_(detector), sink_(sink) {}

  void pairs(const SurfaceView& a, const SurfaceView& b) {
    if (fits([&] { detector_.find_pairs(a, b, found_); }, may_be_cut())) return deliver(found_);
    points_triangles(a, {0, a.x_t0.size()}, b, {0, b.triangles.size()},
                     &CandidatePairs::point_triangle, kDeliverAll);
    points_triangles(b, {0, b.x_t0.size()}, a, {0, a.triangles.size()},
                     &CandidatePairs::triangle_point, kDeliverAll);
    edges_edges(a, {0, a.edges.size()}, b, {0, b.edges.size()}, kDeliverAll);
  }

  void self_pairs(const SurfaceView& a) {
    if (fits([&] { detector_.find_self_pairs(a, found_); }, may_be_cut())) return deliver(found_);
    const auto apart = [&](const PointTrianglePair& p) {
      return !detail::contains(a.triangles[p.triangle], p.point);
    };
    points_triangles(a, {0, a.x_t0.size()}, a, {0, a.triangles.size()},
                     &CandidatePairs::point_triangle, apart);
    own_edges(a, {0, a.edges.size()});
  }

  const StreamedPairs& done() const { return done_; }

 private:
  /// Whether the search stays within the budget. A search that cannot be divided further throws
  /// instead.
  template <class Find>
  bool fits(Find find, bool can_be_cut) {
    ++done_.calls;
    try {
      find();
    } catch (const BudgetExceeded&) {
      if (!can_be_cut) throw;
      return false;
    }
    return true;
  }

  bool may_be_cut() const { return !detector_.traits().closed_body_only; }

  void deliver(const CandidatePairs& piece) {
    if (piece.size() == 0) return;
    done_.pairs += piece.size();
    ++done_.pieces;
    sink_(piece);
  }

  /// Calls `halves(lower, upper)` with the halves of a range.
  template <class Halves>
  static void halve(Range range, Halves halves) {
    halves(Range{range.begin, range.middle()});
    halves(Range{range.middle(), range.end});
  }

  template <class Keep>
  void points_triangles(const SurfaceView& a, Range points, const SurfaceView& b, Range triangles,
                        std::vector<PointTrianglePair> CandidatePairs::*list, Keep keep) {
    if (points.size() == 0 || triangles.size() == 0) return;
    const auto find = [&] {
      Piece piece;
      detector_.find_pairs(Piece::of_points(a, points), piece.of_triangles(b, triangles), found_);
    };
    if (fits(find, points.size() > 1 || triangles.size() > 1)) {
      piece_.clear();
      for (const PointTrianglePair& p : found_.point_triangle)
        if (const PointTrianglePair pair{from(points, p.point), from(triangles, p.triangle)};
            keep(pair))
          (piece_.*list).push_back(pair);
      deliver(piece_);
    } else if (points.size() >= triangles.size()) {
      halve(points, [&](Range half) { points_triangles(a, half, b, triangles, list, keep); });
    } else {
      halve(triangles, [&](Range half) { points_triangles(a, points, b, half, list, keep); });
    }
  }

  template <class Keep>
  void edges_edges(const SurfaceView& a, Range of_a, const SurfaceView& b, Range of_b, Keep keep) {
    if (of_a.size() == 0 || of_b.size() == 0) return;
    const auto find = [&] {
      Piece piece_a, piece_b;
      detector_.find_pairs(piece_a.of_edges(a, of_a), piece_b.of_edges(b, of_b), found_);
    };
    if (fits(find, of_a.size() > 1 || of_b.size() > 1))
      deliver_edges(of_a, of_b, keep);
    else if (of_a.size() >= of_b.size())
      halve(of_a, [&](Range half) { edges_edges(a, half, b, of_b, keep); });
    else
      halve(of_b, [&](Range half) { edges_edges(a, of_a, b, half, keep); });
  }

  /// The edges of a range with one another: each half with itself, and one half with the other.
  void own_edges(const SurfaceView& a, Range edges) {
    if (edges.size() < 2) return;
    const auto find = [&] {
      Piece piece;
      detector_.find_self_pairs(piece.of_edges(a, edges), found_);
    };
    if (fits(find, edges.size() > 2)) return deliver_edges(edges, edges, kDeliverAll);
    halve(edges, [&](Range half) { own_edges(a, half); });
    edges_edges(a, {edges.begin, edges.middle()}, a, {edges.middle(), edges.end},
                [&](const EdgeEdgePair& p) {
                  return !detail::share_vertex(a.edges[p.edge_a], a.edges[p.edge_b]);
                });
  }

  template <class Keep>
  void deliver_edges(Range of_a, Range of_b, Keep keep) {
    piece_.clear();
    for (const EdgeEdgePair& p : found_.edge_edge)
      if (const EdgeEdgePair pair{from(of_a, p.edge_a), from(of_b, p.edge_b)}; keep(pair))
        piece_.edge_edge.push_back(pair);
    deliver(piece_);
  }

  static std::int32_t from(Range range, std::int32_t i) {
    return static_cast<std::int32_t>(range.begin) + i;
  }

  BroadPhase& detector_;
  PairSink sink_;
  CandidatePairs found_, piece_;
  StreamedPairs done_;
};

}  // namespace

StreamedPairs stream_pairs(BroadPhase& detector, const SurfaceView& a, const SurfaceView& b,
                           const PairBudget& piece, PairSink sink) {
  const BudgetOfPieces budget(detector, piece);
  Streamer streamer(detector, sink);
  streamer.pairs(a, b);
  return streamer.done();
}

StreamedPairs stream_self_pairs(BroadPhase& detector, const SurfaceView& a, const PairBudget& piece,
                                PairSink sink) {
  const BudgetOfPieces budget(detector, piece);
  Streamer streamer(detector, sink);
  streamer.self_pairs(a);
  return streamer.done();
}

}  // namespace selvedge
