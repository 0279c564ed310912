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
// Deviations. The paper's loops are horizontal rings of a specially prepared body. Here any mesh,
// closed or not, is cut into limbs, and each limb across its own longest extent into 2l - 1 equal
// slabs, alternating columns and cones. Their radii are not those of the loops but those that the
// boxes of the slab need. A cone that would be larger than a column around the same slab becomes a
// column. The survey's "2l - 1 body triangles" are primitives, and boxes inside them are tested
// against the mesh itself, because a column is not the body. The paper's fabric-fabric cases
// (neighbours, parts that cannot meet) are not implemented.
#include <selvedge/broadphase/detail/body_enclosure.h>
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/broadphase/detail/surface_check.h>
#include <selvedge/broadphase/minimal_enclosure.h>
#include <selvedge/core/base/elementary.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/stopwatch.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

using detail::BodyEnclosure;
using detail::CenteredBox;
using detail::DoubleBox;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// The queries are divided into this many parts, whatever the number of threads.
constexpr std::size_t kEnclosureParts = 128;
/// Number of bodies whose enclosures are kept.
constexpr std::size_t kKeptBodies = 4;
constexpr int kMostLoops = 4096;

MinimalEnclosureConfig checked(MinimalEnclosureConfig config) {
  if (config.loops < 1 || config.loops > kMostLoops)
    throw std::invalid_argument("minimal_enclosure: loops must be 1 to " +
                                std::to_string(kMostLoops) + ", not " +
                                std::to_string(config.loops));
  if (!(config.recut_volume > 1.0))
    throw std::invalid_argument("minimal_enclosure: recut_volume must be greater than 1, not " +
                                std::to_string(config.recut_volume));
  if (!config.axis.allFinite())
    throw std::invalid_argument("minimal_enclosure: the axis must be finite");
  if (!config.axis.isZero(0.0))
    config.axis = (config.axis / config.axis.cwiseAbs().maxCoeff()).normalized();
  return config;
}

void check(const SurfaceView& surface, const char* name) {
  detail::check_indices(surface, name);
  detail::check_finite(surface, name);
}

/// Counts of one part of the queries.
struct Looked {
  std::size_t dropped = 0, enclosure_tests = 0, box_tests = 0;
};

/// A body's boxes and the enclosure around them.
struct KeptBody {
  detail::BoxesKey key;
  detail::SurfaceBoxes boxes;
  BodyEnclosure enclosure;
  const Triangle* triangles = nullptr;  ///< address at the last call, to find the likely body first
  std::uint64_t static_id = 0, last_use = 0;
  bool cut = false;

  bool has_topology_of(const SurfaceView& s) const { return cut && enclosure.has_topology_of(s); }
};

/// Boxes of the fabric against one kind of boxes of the body.
class Question {
 public:
  Question(const std::vector<DoubleBox>& asked, const BodyEnclosure& body,
           const detail::SlabBoxes& kind, const std::vector<DoubleBox>& boxes)
      : asked_(asked), body_(body), kind_(kind), boxes_(boxes), scan_(detail::scan_boxes()) {
    for (std::size_t s = 0; s + 1 < kind.slab_group_begin.size(); ++s)
      most_groups_ =
          std::max(most_groups_, kind.slab_group_begin[s + 1] - kind.slab_group_begin[s]);
  }

  /// Calls found(i, j) for every box i of [begin, end) that overlaps box j of the body.
  template <class Found>
  void ask(std::size_t begin, std::size_t end, Looked& looked, Found found) const {
    std::vector<std::uint32_t> hits(most_groups_);
    for (std::size_t i = begin; i < end; ++i) {
      bool inside = false;
      each_slab_met(asked_[i], looked, [&](std::uint32_t slab) {
        inside = true;
        look_through(i, slab, hits.data(), looked, found);
      });
      looked.dropped += !inside;
    }
  }

 private:
  template <class Visit>
  void each_slab_met(const DoubleBox& box, Looked& looked, Visit visit) const {
    if (!overlap(box, body_.box())) return;
    for (const detail::Limb& limb : body_.limbs()) {
      if (!overlap(box, limb.box)) continue;
      const CenteredBox centered(box, limb.origin);
      const detail::IndexRange near = limb.slabs_near(centered);
      for (std::uint32_t i = near.begin; i < near.end; ++i) {
        const std::uint32_t slab = limb.first_slab + i;
        ++looked.enclosure_tests;
        if (!body_.frusta()[slab].is_apart(centered)) visit(slab);
      }
    }
  }

  template <class Found>
  void look_through(std::size_t i, std::uint32_t slab, std::uint32_t* groups, Looked& looked,
                    const Found& found) const {
    const detail::PackedQuery query = query_of(body_.map().pack(asked_[i], 0));
    const std::uint32_t first = kind_.slab_group_begin[slab];
    const std::uint32_t count = kind_.slab_group_begin[slab + 1] - first;
    const std::uint32_t* end = scan_(kind_.groups.data() + first, count, query, groups);
    looked.box_tests += count;
    std::array<std::uint32_t, detail::SlabBoxes::kGroup> hits;
    for (; groups != end; ++groups) {
      const std::uint32_t group = first + *groups / 2;
      const auto from = static_cast<std::uint32_t>(kind_.groups[group].id);
      const std::uint32_t n = kind_.group_end(group, slab) - from;
      const std::uint32_t* last = scan_(kind_.packed.data() + from, n, query, hits.data());
      looked.box_tests += n;
      for (const std::uint32_t* hit = hits.data(); hit != last; ++hit) {
        const std::int32_t j = kind_.packed[from + *hit / 2].id;
        if (*hit % 2 != 0 || overlap(asked_[i], boxes_[j])) found(static_cast<std::int32_t>(i), j);
      }
    }
  }

  const std::vector<DoubleBox>& asked_;
  const BodyEnclosure& body_;
  const detail::SlabBoxes& kind_;
  const std::vector<DoubleBox>& boxes_;
  detail::ScanBoxes scan_;
  std::uint32_t most_groups_ = 0;
};

std::uint64_t key_of(std::int32_t first, std::int32_t second) {
  return static_cast<std::uint64_t>(static_cast<std::uint32_t>(first)) << 32 |
         static_cast<std::uint32_t>(second);
}

class Detector final : public MinimalEnclosure {
 public:
  explicit Detector(const MinimalEnclosureConfig& config) : config_(checked(config)) {}

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    out.clear();
    cost_ = {};
    detail::check_shape(a, "first surface");
    detail::check_shape(b, "second surface");
    fit_fabric(a);
    last_ = nullptr;
    const KeptBody& body = fit_body(b);
    const auto begin = Clock::now();
    find(body);
    collector_.collect(parts_, &detail::FoundPairs::point_triangle, a.x_t0.size(),
                       b.triangles.size(), out.point_triangle);
    collector_.collect(parts_, &detail::FoundPairs::triangle_point, b.x_t0.size(),
                       a.triangles.size(), out.triangle_point);
    collector_.collect(parts_, &detail::FoundPairs::edge_edge, a.edges.size(), b.edges.size(),
                       out.edge_edge);
    last_ = &body;
    cost_.query_s = seconds_since(begin);
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
                "columns and truncated cones around the limbs of a body; F. Ji, R. Li, Y. "
                "Qiu, Three-dimensional garment simulation based on a mass-spring system, "
                "2006"};
  }

  BroadPhaseCost last_cost() const override {
    BroadPhaseCost cost = cost_;
    cost.bytes = fabric_.bytes() + collector_.bytes();
    for (const KeptBody& body : bodies_) cost.bytes += body.boxes.bytes() + body.enclosure.bytes();
    for (const detail::FoundPairs& part : parts_) cost.bytes += part.bytes();
    return cost;
  }

  MinimalEnclosureCounts last_counts() const override { return counts_; }
  Enclosure last_enclosure() const override {
    return last_ ? last_->enclosure.enclosure() : Enclosure{};
  }

 private:
  using Clock = std::chrono::steady_clock;

  void fit_fabric(const SurfaceView& a) {
    const auto begin = Clock::now();
    if (!fabric_key_.is_same_static(a)) {
      fabric_key_.forget();
      check(a, "first surface");
      fabric_.fit(a);
      fabric_key_.set(a);
    }
    cost_.refit_s += seconds_since(begin);
  }

  const KeptBody& fit_body(const SurfaceView& b) {
    KeptBody& body = choose_body(b);
    body.last_use = ++uses_;
    if (body.cut && body.key.is_same_static(b)) return body;
    const auto begin = Clock::now();
    body.key.forget();
    check(b, "second surface");
    // Another static body gets a cut of its own.
    const bool keeps =
        body.has_topology_of(b) && (b.static_id == 0 || b.static_id == body.static_id);
    body.cut = false;  // Until the cut is complete.
    body.boxes.fit(b);
    if (keeps) body.enclosure.refit(body.boxes);
    if (keeps) cost_.refit_s += seconds_since(begin);
    if (!keeps || body.enclosure.volume_ratio() > config_.recut_volume) {
      const auto cut_begin = keeps ? Clock::now() : begin;
      body.enclosure.cut(b, body.boxes, config_);
      cost_.build_s += seconds_since(cut_begin);
    }
    body.triangles = b.triangles.data();
    body.static_id = b.static_id;
    body.key.set(b);
    body.cut = true;
    return body;
  }

  /// The kept body that serves with the least work.
  KeptBody& choose_body(const SurfaceView& b) {
    for (KeptBody& kept : bodies_)
      if (kept.cut && kept.key.is_same_static(b)) return kept;
    for (KeptBody& kept : bodies_)
      if (kept.cut && kept.triangles == b.triangles.data() && kept.static_id == b.static_id)
        return kept;
    return *std::min_element(
        bodies_.begin(), bodies_.end(),
        [](const KeptBody& x, const KeptBody& y) { return x.last_use < y.last_use; });
  }

  void find(const KeptBody& body) {
    detail::PairTally tally(budget(), detail::PairBuffer::kBytesPerPair);
    parts_.resize(kEnclosureParts);
    looked_.assign(kEnclosureParts, {});
    for (detail::FoundPairs& part : parts_) part.start(&tally);
    const BodyEnclosure& enclosure = body.enclosure;
    ask({fabric_.points, enclosure, enclosure.triangles(), body.boxes.triangles},
        fabric_.points.size(), &detail::FoundPairs::point_triangle, false);
    ask({fabric_.triangles, enclosure, enclosure.points(), body.boxes.points},
        fabric_.triangles.size(), &detail::FoundPairs::triangle_point, true);
    ask({fabric_.edges, enclosure, enclosure.edges(), body.boxes.edges}, fabric_.edges.size(),
        &detail::FoundPairs::edge_edge, false);
    for (detail::FoundPairs& part : parts_) part.finish();
    note_counts(enclosure);
  }

  /// `turned`: the body's index comes first.
  void ask(const Question& question, std::size_t n, detail::PairBuffer detail::FoundPairs::*list,
           bool turned) {
    const std::size_t grain = std::max<std::size_t>(1, (n + kEnclosureParts - 1) / kEnclosureParts);
    parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
      const std::size_t part = begin / grain;
      detail::PairBuffer& buffer = parts_[part].*list;
      question.ask(begin, end, looked_[part], [&](std::int32_t i, std::int32_t j) {
        std::uint64_t* place = buffer.room(1);
        *place = turned ? key_of(j, i) : key_of(i, j);
        buffer.advance_to(place + 1);
      });
    });
  }

  void note_counts(const BodyEnclosure& enclosure) {
    counts_ = {.limbs = enclosure.limbs().size(),
               .primitives = enclosure.frusta().size(),
               .asked = fabric_.points.size() + fabric_.edges.size() + fabric_.triangles.size()};
    for (const Looked& looked : looked_) {
      counts_.dropped += looked.dropped;
      counts_.enclosure_tests += looked.enclosure_tests;
      counts_.box_tests += looked.box_tests;
    }
  }

  MinimalEnclosureConfig config_;
  detail::BoxesKey fabric_key_;
  detail::SurfaceBoxes fabric_;
  std::array<KeptBody, kKeptBodies> bodies_;
  const KeptBody* last_ = nullptr;
  std::uint64_t uses_ = 0;
  std::vector<detail::FoundPairs> parts_;
  std::vector<Looked> looked_;
  detail::PairCollector collector_;
  MinimalEnclosureCounts counts_;
  BroadPhaseCost cost_;
};

/// Position of x relative to a cone: along its axis, and its distance outside the wall,
/// perpendicular to the axis.
struct AboutCone {
  double along, height, outside, slope;

  AboutCone(const TruncatedCone& cone, const Vec3& x)
      : along(cone.axis.dot(x - cone.base)), height(cone.axis.dot(cone.top - cone.base)) {
    const double per_metre = height > 0.0 ? 1.0 / height : 0.0;
    const Vec3 drift = (cone.top - cone.base - height * cone.axis) * per_metre;
    const double growth = (cone.top_radius - cone.base_radius) * per_metre;
    const Vec3 across = x - cone.base - along * (cone.axis + drift);
    const double distance = across.norm();
    outside = distance - (cone.base_radius + along * growth);
    slope = (distance > 0.0 ? across.dot(drift) / distance : 0.0) + growth;
  }
};

}  // namespace

bool Column::contains(const Vec3& x) const {
  const double along = axis.dot(x - base);
  return along >= 0.0 && along <= height && (x - base - along * axis).norm() <= radius;
}

double Column::distance(const Vec3& x) const {
  const double along = axis.dot(x - base);
  const double beyond = std::max({0.0, -along, along - height});
  return elementary::hypot(beyond, std::max(0.0, (x - base - along * axis).norm() - radius));
}

double Column::volume() const { return std::numbers::pi * radius * radius * height; }

bool TruncatedCone::contains(const Vec3& x) const {
  const AboutCone about(*this, x);
  return about.along >= 0.0 && about.along <= about.height && about.outside <= 0.0;
}

double TruncatedCone::distance(const Vec3& x) const {
  const AboutCone about(*this, x);
  // The gradient of `outside` has the length √(1 + slope²); this gives the distance to the plane
  // along the wall.
  const double wall = about.outside / std::sqrt(1.0 + about.slope * about.slope);
  return std::max({0.0, -about.along, about.along - about.height, wall});
}

double TruncatedCone::volume() const {
  const double a = base_radius, b = top_radius;
  return axis.dot(top - base) * (a * a + a * b + b * b) * (std::numbers::pi / 3.0);
}

std::size_t Enclosure::primitive_count() const {
  std::size_t count = 0;
  for (const EnclosedLimb& limb : limbs) count += limb.columns.size() + limb.cones.size();
  return count;
}

bool Enclosure::contains(const Vec3& x) const {
  const auto holds = [&](const auto& primitive) { return primitive.contains(x); };
  return std::any_of(limbs.begin(), limbs.end(), [&](const EnclosedLimb& limb) {
    return std::any_of(limb.columns.begin(), limb.columns.end(), holds) ||
           std::any_of(limb.cones.begin(), limb.cones.end(), holds);
  });
}

double Enclosure::distance(const Vec3& x) const {
  double least = kInfinity;
  for (const EnclosedLimb& limb : limbs) {
    for (const Column& column : limb.columns) least = std::min(least, column.distance(x));
    for (const TruncatedCone& cone : limb.cones) least = std::min(least, cone.distance(x));
  }
  return least;
}

double Enclosure::volume() const {
  double sum = 0.0;
  for (const EnclosedLimb& limb : limbs) {
    for (const Column& column : limb.columns) sum += column.volume();
    for (const TruncatedCone& cone : limb.cones) sum += cone.volume();
  }
  return sum;
}

double Enclosure::mean_gap(const SurfaceView& surface) const {
  double sum = 0.0;
  std::size_t held = 0;
  for (const Vec3& x : surface.x_t0) {
    double least = kInfinity;
    for (const EnclosedLimb& limb : limbs) {
      for (const Column& c : limb.columns)
        if (c.contains(x))
          least = std::min(least, c.radius - (x - c.base - c.axis.dot(x - c.base) * c.axis).norm());
      for (const TruncatedCone& c : limb.cones)
        if (c.contains(x)) least = std::min(least, -AboutCone(c, x).outside);
    }
    if (least == kInfinity) continue;
    sum += least;
    ++held;
  }
  return held == 0 ? 0.0 : sum / static_cast<double>(held);
}

Enclosure make_enclosure(const SurfaceView& surface, const MinimalEnclosureConfig& config) {
  detail::check_shape(surface, "surface");
  check(surface, "surface");
  detail::SurfaceBoxes boxes;
  boxes.fit(surface);
  BodyEnclosure enclosure;
  enclosure.cut(surface, boxes, checked(config));
  return enclosure.enclosure();
}

std::unique_ptr<MinimalEnclosure> make_minimal_enclosure(const MinimalEnclosureConfig& config) {
  return std::make_unique<Detector>(config);
}

void register_minimal_enclosure(BroadPhaseRegistry& registry) {
  const MinimalEnclosureConfig initial;
  registry.add("minimal_enclosure",
               {{.name = "loops",
                 .initial = static_cast<double>(initial.loops),
                 .unit = "1",
                 .least = 1.0,
                 .most = kMostLoops,
                 .kind = OptionKind::whole,
                 .meaning = "loops per limb; more: a tighter enclosure, more primitives to test"},
                {.name = "find_limbs",
                 .initial = initial.find_limbs ? 1.0 : 0.0,
                 .kind = OptionKind::boolean,
                 .meaning = "cuts the body into limbs first; false: the body is one limb"},
                {.name = "recut_volume",
                 .initial = initial.recut_volume,
                 .unit = "1",
                 .least = 1.0,
                 .most = 1e9,
                 .above_least = true,
                 .meaning = "a moving body is cut again when the volume exceeds this multiple of "
                            "that after the last cut"}},
               [](const MethodOptions& o) {
                 return make_minimal_enclosure({.loops = o.whole("loops"),
                                                .find_limbs = o.flag("find_limbs"),
                                                .recut_volume = o["recut_volume"]});
               });
}

}  // namespace selvedge
