// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/box_library.h>
#include <selvedge/broadphase/detail/bytes.h>
#include <selvedge/broadphase/detail/surface_check.h>
#include <selvedge/broadphase/detail/swept_box.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <chrono>
#include <cstring>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace selvedge::detail {
namespace {

// A million kilometres; its cube is far below the largest float.
constexpr double kFar = 1e12;
/// As in bvh_aabb: at a distance of sixteen times the size of the first surface, float still
/// resolves 2^-20 of it.
constexpr double kFarFromOrigin = 16.0;
/// A first surface much smaller than the second may move by this fraction of the second's size
/// before the origin follows.
constexpr double kSmallPart = 1e-3;

using Clock = std::chrono::steady_clock;

std::uint64_t next_run() {
  static std::atomic<std::uint64_t> runs{0};
  return ++runs;
}

/// The primitives that each unit owns, unit by unit.
struct Owned {
  std::vector<std::uint32_t> begin;  ///< per unit, and the end
  std::vector<std::int32_t> id;

  std::span<const std::int32_t> of(std::size_t unit) const {
    return {id.data() + begin[unit], begin[unit + 1] - begin[unit]};
  }
  /// Sorts the primitives 0..owner.size()-1 by their owner.
  void assign(const std::vector<std::int32_t>& owner, std::size_t units) {
    begin.assign(units + 1, 0);
    for (const std::int32_t o : owner) ++begin[o + 1];
    for (std::size_t u = 0; u < units; ++u) begin[u + 1] += begin[u];
    id.resize(owner.size());
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t i = 0; i < owner.size(); ++i)
      id[next[owner[i]]++] = static_cast<std::int32_t>(i);
  }
};

/// A box in float, by the map of UnitBox, with a tag.
struct alignas(16) TaggedBox {
  std::array<float, 3> lo;
  std::int32_t tag;
  std::array<float, 3> hi;
  std::int32_t tag2;
};

enum class Overlap { none, perhaps, certain };

#ifdef __SSE2__
Overlap overlap(const TaggedBox& a, const TaggedBox& b) {
  constexpr int xyz = 7;  // ignores the lane of the tags
  const __m128 a_lo = _mm_load_ps(a.lo.data()), a_hi = _mm_load_ps(a.hi.data());
  const __m128 b_lo = _mm_load_ps(b.lo.data()), b_hi = _mm_load_ps(b.hi.data());
  const __m128 strict = _mm_and_ps(_mm_cmplt_ps(a_lo, b_hi), _mm_cmplt_ps(b_lo, a_hi));
  if ((_mm_movemask_ps(strict) & xyz) == xyz) return Overlap::certain;
  const __m128 closed = _mm_and_ps(_mm_cmple_ps(a_lo, b_hi), _mm_cmple_ps(b_lo, a_hi));
  return (_mm_movemask_ps(closed) & xyz) == xyz ? Overlap::perhaps : Overlap::none;
}
#else
Overlap overlap(const TaggedBox& a, const TaggedBox& b) {
  bool strict = true, closed = true;
  for (int k = 0; k < 3; ++k) {
    strict &= (a.lo[k] < b.hi[k]) & (b.lo[k] < a.hi[k]);
    closed &= (a.lo[k] <= b.hi[k]) & (b.lo[k] <= a.hi[k]);
  }
  return strict ? Overlap::certain : closed ? Overlap::perhaps : Overlap::none;
}
#endif

/// A unit in memory: its own box, tagged with the numbers of points and edges that it owns, then
/// their boxes, tagged with their indices.
class Unit {
 public:
  explicit Unit(const TaggedBox* first) : first_(first) {}
  const TaggedBox& box() const { return *first_; }
  std::span<const TaggedBox> points() const {
    return {first_ + 1, static_cast<std::size_t>(first_->tag)};
  }
  std::span<const TaggedBox> edges() const {
    return {first_ + 1 + first_->tag, static_cast<std::size_t>(first_->tag2)};
  }

 private:
  const TaggedBox* first_;
};

/// One surface divided into units: its triangles with the edges and vertices they own, then the
/// edges and vertices that no triangle contains, each a unit of its own.
class UnitSurface {
 public:
  bool has_topology_of(const SurfaceView& s) const {
    return s.x_t0.size() == vertex_count_ && same_bytes(s.triangles, triangles_) &&
           same_bytes(s.edges, edges_);
  }

  void set_topology(const SurfaceView& s) {
    vertex_count_ = s.x_t0.size();
    triangles_.assign(s.triangles.begin(), s.triangles.end());
    edges_.assign(s.edges.begin(), s.edges.end());
    std::vector<std::int32_t> edge_owner(edges_.size()), point_owner(vertex_count_, -1);
    units_ = triangles_.size();
    own_edges(edge_owner);
    for (std::size_t t = triangles_.size(); t-- > 0;)
      for (const std::int32_t v : triangles_[t]) point_owner[v] = static_cast<std::int32_t>(t);
    for (std::int32_t& owner : point_owner)
      if (owner < 0) owner = static_cast<std::int32_t>(units_++);
    owned_edges_.assign(edge_owner, units_);
    owned_points_.assign(point_owner, units_);
    record_begin_.resize(units_);
    for (std::size_t u = 0; u < units_; ++u)
      record_begin_[u] = u + owned_points_.begin[u] + owned_edges_.begin[u];
  }

  void set_positions(const SurfaceView& s, const Vec3& origin) {
    vertex_boxes_.resize(vertex_count_);
    records_.resize(units_ + vertex_count_ + edges_.size());
    boxes_.resize(units_);
    parallel_for(vertex_count_, kBoxGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v)
        vertex_boxes_[v] = to_float(swept_box(s, static_cast<std::int32_t>(v)), origin);
    });
    parallel_for(units_, kBoxGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t u = begin; u < end; ++u) box_unit(u);
    });
  }

  std::size_t units() const { return units_; }
  std::size_t vertex_count() const { return vertex_count_; }
  std::size_t edge_count() const { return edges_.size(); }
  std::size_t triangle_count() const { return triangles_.size(); }
  std::span<const UnitBox> boxes() const { return boxes_; }
  bool is_triangle(std::size_t unit) const { return unit < triangles_.size(); }
  Unit unit(std::size_t u) const { return Unit(records_.data() + record_begin_[u]); }
  std::size_t bytes() const {
    return bytes_of(triangles_) + bytes_of(edges_) + bytes_of(vertex_boxes_) + bytes_of(records_) +
           bytes_of(boxes_) + bytes_of(record_begin_) + bytes_of(owned_edges_.begin) +
           bytes_of(owned_edges_.id) + bytes_of(owned_points_.begin) + bytes_of(owned_points_.id);
  }

 private:
  /// An edge belongs to the first triangle that contains both its ends. An edge from a vertex to
  /// itself is a unit of its own: inside a triangle it would have to be paired with the opposite
  /// edge, and a unit is not paired with itself.
  void own_edges(std::vector<std::int32_t>& owner) {
    Owned around;  // the triangles' corners, by vertex
    std::vector<std::int32_t> corners;
    for (const Triangle& t : triangles_) corners.insert(corners.end(), t.begin(), t.end());
    around.assign(corners, vertex_count_);
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      owner[e] = -1;
      const auto [from, to] = edges_[e];
      if (from != to)
        for (const std::int32_t corner : around.of(from))
          if (contains(triangles_[corner / 3], to)) {
            owner[e] = corner / 3;
            break;
          }
      if (owner[e] < 0) owner[e] = static_cast<std::int32_t>(units_++);
    }
  }

  static TaggedBox to_float(const DoubleBox& box, const Vec3& origin) {
    TaggedBox out{};
    for (int k = 0; k < 3; ++k) {
      out.lo[k] = static_cast<float>(std::clamp(box.lo[k] - origin[k], -kFar, kFar));
      out.hi[k] = static_cast<float>(std::clamp(box.hi[k] - origin[k], -kFar, kFar));
    }
    return out;
  }

  template <std::size_t n>
  TaggedBox around(const std::array<std::int32_t, n>& vertices) const {
    TaggedBox box = vertex_boxes_[vertices[0]];
    for (std::size_t i = 1; i < n; ++i)
      for (int k = 0; k < 3; ++k) {
        box.lo[k] = std::min(box.lo[k], vertex_boxes_[vertices[i]].lo[k]);
        box.hi[k] = std::max(box.hi[k], vertex_boxes_[vertices[i]].hi[k]);
      }
    return box;
  }

  void box_unit(std::size_t u) {
    TaggedBox* const first = records_.data() + record_begin_[u];
    TaggedBox* next = first + 1;
    for (const std::int32_t v : owned_points_.of(u)) {
      *next = vertex_boxes_[v];
      next++->tag = v;
    }
    for (const std::int32_t e : owned_edges_.of(u)) {
      *next = around(edges_[e]);
      next++->tag = e;
    }
    *first = is_triangle(u) ? around(triangles_[u]) : first[1];
    first->tag = static_cast<std::int32_t>(owned_points_.of(u).size());
    first->tag2 = static_cast<std::int32_t>(owned_edges_.of(u).size());
    boxes_[u] = {first->lo, first->hi};
  }

  std::size_t vertex_count_ = 0, units_ = 0;
  std::vector<Triangle> triangles_;
  std::vector<Edge> edges_;
  Owned owned_edges_, owned_points_;
  std::vector<std::size_t> record_begin_;
  std::vector<TaggedBox> vertex_boxes_, records_;
  std::vector<UnitBox> boxes_;
};

void put(PairBuffer& buffer, std::int32_t first, std::int32_t second) {
  std::uint64_t* room = buffer.room(1);
  *room =
      std::uint64_t{static_cast<std::uint32_t>(first)} << 32 | static_cast<std::uint32_t>(second);
  buffer.advance_to(room + 1);
}

/// One surface of a search.
struct UnitSide {
  const UnitSurface& units;
  const SurfaceView& view;
};

/// Expands pairs of units to pairs of primitives. If boxes only touch in float, those in double
/// decide (see UnitBox).
class Expansion {
 public:
  Expansion(const UnitSide& a, const UnitSide& b, bool self) : a_(a), b_(b), self_(self) {}

  void expand(std::span<const std::uint64_t> pairs, FoundPairs& out) const {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (k + kAhead < pairs.size()) {
        prefetch(a_.units.unit(pairs[k + kAhead] >> 32));
        prefetch(b_.units.unit(pairs[k + kAhead] & 0xffffffffu));
      }
      expand(pairs[k], out);
    }
  }

 private:
  /// Number of pairs by which units are prefetched: neighbours in space lie far apart in memory.
  static constexpr std::size_t kAhead = 8;

  static void prefetch([[maybe_unused]] const Unit& unit) {
#ifdef __SSE2__
    // A unit usually fills at most two cache lines.
    _mm_prefetch(reinterpret_cast<const char*>(&unit.box()), _MM_HINT_T0);
    _mm_prefetch(reinterpret_cast<const char*>(&unit.box() + 2), _MM_HINT_T0);
#endif
  }

  void expand(std::uint64_t pair, FoundPairs& out) const {
    const std::size_t i = pair >> 32, j = pair & 0xffffffffu;
    const Unit unit_a = a_.units.unit(i), unit_b = b_.units.unit(j);
    if (b_.units.is_triangle(j)) points_triangle(a_, unit_a, b_, unit_b, j, out.point_triangle);
    if (a_.units.is_triangle(i))
      points_triangle(b_, unit_b, a_, unit_a, i, self_ ? out.point_triangle : out.triangle_point);
    edges_edges(unit_a, unit_b, out.edge_edge);
  }

  template <class Primitive, class Other>
  static bool touch(Overlap overlap, const SurfaceView& p, const Primitive& primitive,
                    const SurfaceView& q, const Other& other) {
    return overlap == Overlap::certain ||
           (overlap == Overlap::perhaps &&
            detail::overlap(swept_box(p, primitive), swept_box(q, other)));
  }

  void points_triangle(const UnitSide& p, const Unit& unit, const UnitSide& t, const Unit& triangle,
                       std::size_t index, PairBuffer& out) const {
    for (const TaggedBox& point : unit.points()) {
      const Overlap found = overlap(point, triangle.box());
      if (found == Overlap::none) continue;
      const Triangle& corners = t.view.triangles[index];
      if (touch(found, p.view, point.tag, t.view, corners) &&
          !(self_ && contains(corners, point.tag)))
        put(out, point.tag, static_cast<std::int32_t>(index));
    }
  }

  void edges_edges(const Unit& unit_a, const Unit& unit_b, PairBuffer& out) const {
    for (const TaggedBox& edge_a : unit_a.edges()) {
      if (overlap(edge_a, unit_b.box()) == Overlap::none) continue;
      for (const TaggedBox& edge_b : unit_b.edges()) {
        const Overlap found = overlap(edge_a, edge_b);
        if (found == Overlap::none) continue;
        const Edge &e = a_.view.edges[edge_a.tag], &f = b_.view.edges[edge_b.tag];
        if (!touch(found, a_.view, e, b_.view, f)) continue;
        if (!self_)
          put(out, edge_a.tag, edge_b.tag);
        else if (!share_vertex(e, f))
          put(out, std::min(edge_a.tag, edge_b.tag), std::max(edge_a.tag, edge_b.tag));
      }
    }
  }

  UnitSide a_, b_;
  bool self_;
};

/// A surface and the input of the last fit of its slot in the library.
struct KeptSurface {
  UnitSurface units;
  std::uint64_t static_id = 0, last_use = 0;  ///< last_use 0: never
  double thickness = -1.0;
  Vec3 origin = Vec3::Zero();
  Bounds bounds;       ///< of x_t0
  bool built = false;  ///< the slot has a structure for this number of boxes

  bool is_static_copy_of(const SurfaceView& s) const {
    return built && s.static_id != 0 && s.static_id == static_id &&
           s.x_t0.size() == units.vertex_count() && s.edges.size() == units.edge_count() &&
           s.triangles.size() == units.triangle_count();
  }
};

double size_of(const Bounds& b) { return std::max(0.0, (b.hi - b.lo).maxCoeff()); }

class BoxBroadPhase final : public BroadPhase {
 public:
  explicit BoxBroadPhase(std::unique_ptr<BoxLibrary> library) : library_(std::move(library)) {}

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    cost_ = {};
    out.clear();
    check_shape(a, "first surface");
    check_shape(b, "second surface");
    const int slot_a = choose(a, -1, "first surface");
    const int slot_b = choose(b, slot_a, "second surface");
    place_origin(kept_[slot_a].bounds, size_of(kept_[slot_b].bounds));
    fit(slot_a, a);
    fit(slot_b, b);
    const auto begin = Clock::now();
    const UnitSurface &units_a = kept_[slot_a].units, &units_b = kept_[slot_b].units;
    find({{units_a, a}, {units_b, b}, false}, out, [&](UnitPairs& pairs) {
      if (units_a.units() > 0 && units_b.units() > 0) library_->find(slot_a, slot_b, pairs);
    });
    collector_.collect(parts_, a, &b, out);
    cost_.query_s = seconds_since(begin);
  }

  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    cost_ = {};
    out.clear();
    check_shape(a, "surface");
    const int slot = choose(a, -1, "surface");
    place_origin(kept_[slot].bounds, 0.0);
    fit(slot, a);
    const auto begin = Clock::now();
    const UnitSurface& units = kept_[slot].units;
    find({{units, a}, {units, a}, true}, out, [&](UnitPairs& pairs) {
      if (units.units() > 1) library_->find_self(slot, pairs);
    });
    collector_.collect(parts_, a, nullptr, out);
    cost_.query_s = seconds_since(begin);
  }

  BroadPhaseTraits traits() const override { return library_->traits(); }

  BroadPhaseCost last_cost() const override {
    BroadPhaseCost cost = cost_;
    cost.bytes = collector_.bytes() + library_->bytes();
    for (const KeptSurface& kept : kept_) cost.bytes += kept.units.bytes();
    for (const FoundPairs& part : parts_) cost.bytes += part.bytes();
    return cost;
  }

 private:
  /// Chooses the slot that serves the surface with the least work, sets its topology and checks its
  /// positions. `taken` serves the other surface of this call.
  int choose(const SurfaceView& surface, int taken, const char* name) {
    const auto begin = Clock::now();
    int slot = find_kept(surface, taken);
    if (slot < 0 || !kept_[slot].is_static_copy_of(surface)) {
      const Bounds bounds = check_finite(surface, name);
      if (slot < 0) {
        check_indices(surface, name);
        slot = oldest(taken);
        kept_[slot].built = false;
        kept_[slot].static_id = 0;
        kept_[slot].units.set_topology(surface);
      }
      kept_[slot].static_id = surface.static_id;
      kept_[slot].thickness = -1.0;  // Its boxes are out of date.
      kept_[slot].bounds = bounds;
    }
    kept_[slot].last_use = ++uses_;
    (kept_[slot].built ? cost_.refit_s : cost_.build_s) += seconds_since(begin);
    return slot;
  }

  int find_kept(const SurfaceView& surface, int taken) const {
    for (int slot = 0; slot < kBoxSlots; ++slot)
      if (slot != taken && kept_[slot].is_static_copy_of(surface)) return slot;
    for (int slot = 0; slot < kBoxSlots; ++slot)
      if (slot != taken && kept_[slot].last_use > 0 && kept_[slot].units.has_topology_of(surface))
        return slot;
    return -1;
  }

  int oldest(int taken) const {
    int best = -1;
    for (int slot = 0; slot < kBoxSlots; ++slot)
      if (slot != taken && (best < 0 || kept_[slot].last_use < kept_[best].last_use)) best = slot;
    return best;
  }

  void place_origin(const Bounds& bounds, double other_size) {
    if ((bounds.lo.array() > bounds.hi.array()).any()) return;
    const Vec3 center = 0.5 * bounds.lo + 0.5 * bounds.hi;
    const double size = std::max(size_of(bounds), kSmallPart * other_size);
    // The comparison is written so that an infinite difference moves the origin too.
    if (!((center - origin_).cwiseAbs().maxCoeff() <= kFarFromOrigin * size)) origin_ = center;
  }

  void fit(int slot, const SurfaceView& surface) {
    KeptSurface& kept = kept_[slot];
    if (kept.built && kept.thickness == surface.thickness && kept.origin == origin_) return;
    const auto begin = Clock::now();
    kept.units.set_positions(surface, origin_);
    const bool stays = surface.static_id != 0;
    // A static surface gets a structure built for it.
    const bool fitted =
        kept.built && !stays && kept.units.units() > 0 && library_->refit(slot, kept.units.boxes());
    if (!fitted && kept.units.units() > 0) library_->build(slot, kept.units.boxes(), stays);
    (fitted ? cost_.refit_s : cost_.build_s) += seconds_since(begin);
    kept.built = true;
    kept.thickness = surface.thickness;
    kept.origin = origin_;
  }

  /// Fills parts_ with the results of `search(UnitPairs&)`; clears `out` if they exceed the budget.
  template <class Search>
  void find(const Expansion& expansion, CandidatePairs& out, Search search) {
    PairTally tally(budget(), PairBuffer::kBytesPerPair);
    const auto expand = [&](std::span<const std::uint64_t> pairs, FoundPairs& found) {
      expansion.expand(pairs, found);
    };
    for (FoundPairs& part : parts_) part.start(nullptr);
    UnitPairs pairs(expand, tally, parts_);
    try {
      search(pairs);
      pairs.finish();
    } catch (const BudgetExceeded&) {
      out.clear();
      throw;
    }
  }

  std::unique_ptr<BoxLibrary> library_;
  std::array<KeptSurface, kBoxSlots> kept_;
  std::uint64_t uses_ = 0;
  Vec3 origin_ = Vec3::Zero();
  std::vector<FoundPairs> parts_;
  PairCollector collector_;
  BroadPhaseCost cost_;
};

}  // namespace

UnitPairs::UnitPairs(Expand expand, PairTally& tally, std::vector<FoundPairs>& parts)
    : expand_(expand), tally_(tally), parts_(parts), run_(next_run()) {}

UnitPairs::List& UnitPairs::new_list() {
  const std::lock_guard lock(mutex_);
  List& list = lists_.emplace_back();
  if (lists_.size() <= parts_.size()) std::swap(list.found, parts_[lists_.size() - 1]);
  list.found.start(&tally_);
  return list;
}

void UnitPairs::flush(List& list) {
  const std::span<const std::uint64_t> pairs(list.pairs.data(), list.count);
  list.count = 0;
  if (stopped()) return;
  try {
    expand_(pairs, list.found);
  } catch (const BudgetExceeded& failure) {
    const std::lock_guard lock(mutex_);
    failure_ = failure;
    stopped_ = true;
  }
}

void UnitPairs::finish() {
  for (List& list : lists_) flush(list);
  if (failure_) throw *failure_;
  if (parts_.size() < lists_.size()) parts_.resize(lists_.size());
  for (std::size_t i = 0; i < lists_.size(); ++i) {
    lists_[i].found.finish();
    std::swap(lists_[i].found, parts_[i]);
  }
}

std::unique_ptr<BroadPhase> make_box_broad_phase(std::unique_ptr<BoxLibrary> library) {
  return std::make_unique<BoxBroadPhase>(std::move(library));
}

}  // namespace selvedge::detail
