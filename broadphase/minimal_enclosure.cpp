// SPDX-License-Identifier: MIT
// Minimal enclosure, after F. Ji, R. Li, Y. Qiu, Three-dimensional garment simulation based on a
// mass-spring system, 2006 [Ji2006], as described in [MozafaryPayvandy2016]: a body part is a group
// of l closed loops; a column encloses each loop, a truncated cone joins neighbouring columns, and
// fabric is tested against these 2l - 1 primitives.
//
// Conservative: reports exactly the pairs whose swept and inflated boxes overlap, as brute force
// does. Each box of the body lies completely inside the column or cone of its slab, because its
// corners do and columns and cones are convex (see Frustum). A box of the fabric that overlaps it
// therefore meets that column or cone. A box that meets none is dropped; any other is tested
// against the boxes of the slabs that it meets.
//
// Deviations. The paper's loops are horizontal rings of a specially prepared body part. Here any
// mesh, closed or not, is one part and is cut across its longest extent into 2l - 1 equal slabs, in
// turn for a column and a cone; limbs are tighter enclosed as bodies of their own. The radii are
// those that the boxes of the slab need, not those of the loops. A cone that would be larger than a
// column around the same slab becomes a column. The survey's "2l - 1 body triangles" are
// primitives, and boxes inside them are tested against the mesh itself, because a column is not the
// body. A scene states the paper's fabric-fabric cases (neighbours, parts that cannot meet) in
// contact.pairs.
#include <selvedge/broadphase/detail/body_enclosure.h>
#include <selvedge/broadphase/internal/minimal_enclosure.h>
#include <selvedge/core/base/internal/stopwatch.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

using detail::BodyEnclosure;
using detail::CenteredBox;
using detail::DoubleBox;
using detail::PackedBox;
using detail::PairParts;

constexpr int kMostLoops = 4096;

int checked_loops(int loops) {
  if (loops < 1 || loops > kMostLoops)
    throw std::invalid_argument("minimal_enclosure: loops must be 1 to " +
                                std::to_string(kMostLoops) + ", not " + std::to_string(loops));
  return loops;
}

class Detector final : public MinimalEnclosure {
 public:
  explicit Detector(const MinimalEnclosureConfig& config) : loops_(checked_loops(config.loops)) {}

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    out.clear();
    const Stopwatch building;
    if (fabric_.fit(a, "first surface")) fabric_.keep(a);
    if (body_.fit(b, "second surface")) {
      enclosure_.fit(body_.boxes, loops_);
      body_.keep(b);
    }
    cost_.build_s = building.seconds();
    const Stopwatch asking;
    find();
    collector_.collect(parts_, a, &b, out);
    cost_.query_s = asking.seconds();
    note_counts();
  }

  void find_self_pairs(const SurfaceView&, CandidatePairs& out) override {
    out.clear();
    throw std::invalid_argument(
        "minimal_enclosure: supports only pairs between two surfaces; use another broad phase for "
        "a surface with itself");
  }

  BroadPhaseTraits traits() const override {
    return {.self = false,
            .source =
                "columns and truncated cones around a body; F. Ji, R. Li, Y. Qiu, "
                "Three-dimensional garment simulation based on a mass-spring system, 2006"};
  }

  BroadPhaseCost last_cost() const override {
    BroadPhaseCost cost = cost_;
    cost.bytes = fabric_.boxes.bytes() + body_.boxes.bytes() + enclosure_.bytes() +
                 collector_.bytes() + groups_scan_.bytes() + boxes_scan_.bytes();
    for (const detail::FoundPairs& part : parts_) cost.bytes += part.bytes();
    return cost;
  }

  MinimalEnclosureCounts last_counts() const override { return counts_; }
  Enclosure last_enclosure() const override { return enclosure_.enclosure(); }

 private:
  /// Counts of one part of the queries.
  struct Looked {
    std::size_t dropped = 0, enclosure_tests = 0, box_tests = 0;
  };

  void find() {
    detail::PairTally tally(budget(), detail::PairBuffer::kBytesPerPair);
    looked_.assign(detail::kBoxPairParts, {});
    for (detail::FoundPairs& part : parts_) part.start(&tally);
    PairParts points(parts_, &detail::FoundPairs::point_triangle, nullptr);
    ask(fabric_.boxes.points, enclosure_.triangles(),
        [&](std::size_t part, std::int32_t i, std::int32_t j) { points.add(part, i, j); });
    PairParts triangles(parts_, &detail::FoundPairs::triangle_point, nullptr);
    ask(fabric_.boxes.triangles, enclosure_.points(),
        [&](std::size_t part, std::int32_t i, std::int32_t j) { triangles.add(part, j, i); });
    PairParts edges(parts_, &detail::FoundPairs::edge_edge, nullptr);
    ask(fabric_.boxes.edges, enclosure_.edges(),
        [&](std::size_t part, std::int32_t i, std::int32_t j) { edges.add(part, i, j); });
    for (detail::FoundPairs& part : parts_) part.finish();
  }

  /// Calls add(part, i, j) for every box i of the fabric that overlaps box j of the body.
  template <class Add>
  void ask(const std::vector<DoubleBox>& asked, const detail::SlabBoxes& kind, Add add) {
    const std::size_t grain = detail::part_grain(asked.size());
    parallel_for(asked.size(), grain, [&](std::size_t begin, std::size_t end) {
      const std::size_t part = begin / grain;
      for (std::size_t i = begin; i < end; ++i) {
        const DoubleBox& box = asked[i];
        bool inside = false;
        each_slab_met(box, looked_[part], [&](std::size_t slab) {
          inside = true;
          look_through(box, kind, slab, part,
                       [&](std::int32_t j) { add(part, static_cast<std::int32_t>(i), j); });
        });
        looked_[part].dropped += !inside;
      }
    });
  }

  template <class Visit>
  void each_slab_met(const DoubleBox& box, Looked& looked, Visit visit) const {
    if (!overlap(box, enclosure_.box())) return;
    const CenteredBox centered(box, enclosure_.origin());
    const detail::AlongAxis along(centered, enclosure_.axis());
    for (std::size_t slab = 0; slab < enclosure_.frusta().size(); ++slab)
      if (!enclosure_.frusta()[slab].is_apart(centered, along)) visit(slab);
    looked.enclosure_tests += enclosure_.frusta().size();
  }

  /// Calls found(j) for the boxes j of a slab that overlap the box.
  template <class Found>
  void look_through(const DoubleBox& box, const detail::SlabBoxes& kind, std::size_t slab,
                    std::size_t part, const Found& found) {
    const PackedBox packed = enclosure_.map().pack(box, 0);
    const detail::ScannedBox query{query_of(packed), box};
    constexpr std::size_t kGroup = detail::SlabBoxes::kGroup;
    const std::size_t begin = kind.begin[slab], end = kind.begin[slab + 1];
    const std::size_t first = begin / kGroup, last = (end + kGroup - 1) / kGroup;
    if (begin == end) return;
    looked_[part].box_tests += last - first;
    groups_scan_.each_near(
        query.packed, {kind.groups.data() + first, last - first}, part,
        [&](const PackedBox& group, bool) {
          const std::size_t from = std::max(begin, kGroup * static_cast<std::size_t>(group.id));
          const std::size_t to = std::min(end, kGroup * static_cast<std::size_t>(group.id + 1));
          looked_[part].box_tests += to - from;
          boxes_scan_.each_overlap(query, {kind.packed.data() + from, to - from}, *kind.boxes, part,
                                   [&](const PackedBox& other) { found(other.id); });
        });
  }

  void note_counts() {
    counts_ = {.primitives = enclosure_.frusta().size(),
               .asked = fabric_.boxes.points.size() + fabric_.boxes.edges.size() +
                        fabric_.boxes.triangles.size()};
    for (const Looked& looked : looked_) {
      counts_.dropped += looked.dropped;
      counts_.enclosure_tests += looked.enclosure_tests;
      counts_.box_tests += looked.box_tests;
    }
  }

  int loops_;
  detail::KeptBoxes fabric_, body_;
  BodyEnclosure enclosure_;
  std::vector<detail::FoundPairs> parts_{detail::kBoxPairParts};
  std::vector<Looked> looked_;
  detail::BoxScan groups_scan_, boxes_scan_;
  detail::PairCollector collector_;
  MinimalEnclosureCounts counts_;
  BroadPhaseCost cost_;
};

}  // namespace

bool Column::contains(const Vec3& x) const {
  const double along = axis.dot(x - base);
  return along >= 0.0 && along <= height && (x - base - along * axis).norm() <= radius;
}

double Column::volume() const { return std::numbers::pi * radius * radius * height; }

bool TruncatedCone::contains(const Vec3& x) const {
  const double along = axis.dot(x - base), height = axis.dot(top - base);
  if (!(along >= 0.0 && along <= height)) return false;
  const double part = height > 0.0 ? along / height : 0.0;
  return (x - base - part * (top - base)).norm() <= base_radius + part * (top_radius - base_radius);
}

double TruncatedCone::volume() const {
  const double a = base_radius, b = top_radius;
  return axis.dot(top - base) * (a * a + a * b + b * b) * (std::numbers::pi / 3.0);
}

bool Enclosure::contains(const Vec3& x) const {
  const auto holds = [&](const auto& primitive) { return primitive.contains(x); };
  return std::any_of(columns.begin(), columns.end(), holds) ||
         std::any_of(cones.begin(), cones.end(), holds);
}

double Enclosure::volume() const {
  double sum = 0.0;
  for (const Column& column : columns) sum += column.volume();
  for (const TruncatedCone& cone : cones) sum += cone.volume();
  return sum;
}

Enclosure make_enclosure(const SurfaceView& surface, const MinimalEnclosureConfig& config) {
  detail::KeptBoxes kept;
  kept.fit(surface, "surface");
  BodyEnclosure enclosure;
  enclosure.fit(kept.boxes, checked_loops(config.loops));
  return enclosure.enclosure();
}

std::unique_ptr<MinimalEnclosure> make_minimal_enclosure(const MinimalEnclosureConfig& config) {
  return std::make_unique<Detector>(config);
}

void register_minimal_enclosure(BroadPhaseRegistry& registry) {
  registry.add("minimal_enclosure", {},
               [](const MethodOptions&) { return make_minimal_enclosure(); });
}

}  // namespace selvedge
