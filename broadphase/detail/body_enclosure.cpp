// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/body_enclosure.h>
#include <selvedge/broadphase/detail/limb_search.h>
#include <selvedge/core/base/elementary.h>
#include <selvedge/core/base/parallel.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace selvedge::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A cone that leans or widens more than this becomes a column: its wall would be long and enclose
/// little.
constexpr double kMostSlope = 4.0;
constexpr std::size_t kEnclosedGrain = 1024;  // boxes per range: tens of µs of work

/// The first vertex of each primitive decides its limb.
std::int32_t first_vertex(const SurfaceView& surface, int kind, std::size_t i) {
  return kind == 0   ? static_cast<std::int32_t>(i)
         : kind == 1 ? surface.edges[i][0]
                     : surface.triangles[i][0];
}

/// The triangles around each vertex: those of v are [begin[v], begin[v + 1]).
struct TrianglesOfVertices {
  std::vector<std::uint32_t> begin;
  std::vector<std::int32_t> triangles;

  explicit TrianglesOfVertices(const SurfaceView& surface)
      : begin(surface.x_t0.size() + 2, 0), triangles(3 * surface.triangles.size()) {
    // begin[v + 2] first counts; then begin[v + 1] is the next free position; finally begin[v] is
    // the start.
    for (const Triangle& t : surface.triangles)
      for (const std::int32_t v : t) ++begin[v + 2];
    for (std::size_t v = 2; v < begin.size(); ++v) begin[v] += begin[v - 1];
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
      for (const std::int32_t v : surface.triangles[t])
        triangles[begin[v + 1]++] = static_cast<std::int32_t>(t);
  }
  std::span<const std::int32_t> of(std::int32_t v) const {
    return {triangles.data() + begin[v], triangles.data() + begin[v + 1]};
  }
};

/// For each point a triangle that contains it, -1 if there is none.
std::vector<std::int32_t> point_owners(const SurfaceView& surface, const TrianglesOfVertices& of) {
  std::vector<std::int32_t> owner(surface.x_t0.size(), -1);
  for (std::size_t v = 0; v < owner.size(); ++v) {
    const std::span<const std::int32_t> triangles = of.of(static_cast<std::int32_t>(v));
    if (!triangles.empty()) owner[v] = triangles.front();
  }
  return owner;
}

/// For each edge a triangle that contains both ends, -1 if there is none.
std::vector<std::int32_t> edge_owners(const SurfaceView& surface, const TrianglesOfVertices& of) {
  std::vector<std::int32_t> owner(surface.edges.size(), -1);
  for (std::size_t i = 0; i < owner.size(); ++i) {
    auto [v, other] = surface.edges[i];
    // The hub of a fan has many triangles, so search around the other vertex.
    if (of.of(other).size() < of.of(v).size()) std::swap(v, other);
    for (const std::int32_t t : of.of(v))
      if (contains(surface.triangles[t], other)) {
        owner[i] = t;
        break;
      }
  }
  return owner;
}

/// Index of the part of [lo, hi], divided into `slabs` equal parts, that contains s; any index if s
/// is NaN.
std::uint32_t slab_at(double s, double lo, double hi, std::uint32_t slabs) {
  const double at = (s - lo) / (hi - lo) * slabs;
  if (!(at > 0.0)) return 0;
  return at < slabs ? static_cast<std::uint32_t>(at) : slabs - 1;
}

/// Increases with the angle of (x, y) over one turn, from 0 to 4, without trigonometry.
double turn_of(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (!(sum > 0.0) || !std::isfinite(sum)) return 0.0;
  const double part = y / sum;
  return x < 0.0 ? 2.0 - part : y < 0.0 ? 4.0 + part : part;
}

Vec3 middle_of_box(const DoubleBox& box, const Vec3& origin) {
  return CenteredBox(box, origin).middle;
}

/// Two directions perpendicular to an axis.
struct Across {
  Vec3 x, y;
  explicit Across(const Vec3& axis) : x(axis.unitOrthogonal()), y(axis.cross(x)) {}
};

/// A frustum that contains everything.
Frustum boundless() {
  Frustum f;
  f.axis = f.lean = Vec3::Zero();
  f.radius = f.hi = kInfinity;
  f.lo = -kInfinity;
  return f;
}

/// A box that overlaps no other.
DoubleBox nothing_box() {
  DoubleBox box;
  box.lo.fill(kInfinity);
  box.hi.fill(-kInfinity);
  return box;
}

/// A frustum that contains nothing.
Frustum nothing(const Vec3& axis) {
  Frustum f;
  f.axis = f.lean = axis;
  f.lo = kInfinity;
  f.hi = -kInfinity;
  return f;
}

}  // namespace

IndexRange Limb::slabs_near(const CenteredBox& around) const {
  const double s = axis.dot(around.middle);
  const double reach = around.reach(axis) + Frustum::kRounding * around.far();
  const auto first = std::partition_point(highest.begin(), highest.end(),
                                          [&](double most) { return most < s - reach; });
  const auto last = std::partition_point(lowest.begin(), lowest.end(),
                                         [&](double least) { return !(least > s + reach); });
  return {static_cast<std::uint32_t>(first - highest.begin()),
          static_cast<std::uint32_t>(last - lowest.begin())};
}

std::size_t SlabBoxes::bytes() const {
  return order.capacity() * sizeof(std::int32_t) +
         (slab_begin.capacity() + slab_group_begin.capacity()) * sizeof(std::uint32_t) +
         (packed.capacity() + groups.capacity()) * sizeof(PackedBox);
}

template <class Visit>
void BodyEnclosure::each_box(const Lists& lists, std::uint32_t begin, std::uint32_t end,
                             Visit visit) const {
  for (std::uint32_t i = kinds_[2].slab_begin[begin]; i < kinds_[2].slab_begin[end]; ++i)
    visit((*lists[2])[kinds_[2].order[i]]);
  for (std::size_t k = 0; k < loose_.size(); ++k)
    for (std::uint32_t i = loose_[k].slab_begin[begin]; i < loose_[k].slab_begin[end]; ++i)
      visit((*lists[k])[loose_[k].order[i]]);
}

bool BodyEnclosure::is_empty(std::uint32_t slab) const {
  bool empty = true;
  for (const SlabBoxes& kind : kinds_) empty &= kind.slab_begin[slab] == kind.slab_begin[slab + 1];
  return empty;
}

bool BodyEnclosure::has_topology_of(const SurfaceView& s) const {
  return s.x_t0.size() == vertex_count_ &&
         std::equal(s.edges.begin(), s.edges.end(), edges_.begin(), edges_.end()) &&
         std::equal(s.triangles.begin(), s.triangles.end(), triangles_.begin(), triangles_.end());
}

void BodyEnclosure::cut(const SurfaceView& surface, const SurfaceBoxes& boxes,
                        const MinimalEnclosureConfig& config) {
  config_ = config;
  vertex_count_ = surface.x_t0.size();
  edges_.assign(surface.edges.begin(), surface.edges.end());
  triangles_.assign(surface.triangles.begin(), surface.triangles.end());
  const Lists lists{&boxes.points, &boxes.edges, &boxes.triangles};
  lay_out_limbs(surface);
  sort_boxes(surface, lists);
  fit(lists);
  cut_volume_ = volume();
}

void BodyEnclosure::refit(const SurfaceBoxes& boxes) {
  fit({&boxes.points, &boxes.edges, &boxes.triangles});
}

/// Finds the limbs, their origins and axes, and assigns slabs to each.
void BodyEnclosure::lay_out_limbs(const SurfaceView& surface) {
  Limbs found = config_.find_limbs ? find_limbs(surface, config_.axis) : one_limb(surface);
  limb_of_vertex_ = std::move(found.of_vertex);
  limbs_.assign(found.count, {});
  std::vector<std::vector<std::int32_t>> vertices(found.count);
  for (std::size_t v = 0; v < limb_of_vertex_.size(); ++v)
    vertices[limb_of_vertex_[v]].push_back(static_cast<std::int32_t>(v));
  const auto slabs = static_cast<std::uint32_t>(2 * config_.loops - 1);
  limb_of_slab_.clear();
  for (std::uint32_t i = 0; i < limbs_.size(); ++i) {
    Limb& limb = limbs_[i];
    limb.origin = surface.x_t0[vertices[i][0]];
    limb.axis = config_.axis.isZero() ? longest_axis(surface, vertices[i]) : config_.axis;
    limb.slabs = slabs;
    limb.first_slab = static_cast<std::uint32_t>(limb_of_slab_.size());
    limb_of_slab_.insert(limb_of_slab_.end(), slabs, i);
  }
  frusta_.assign(limb_of_slab_.size(), {});
}

/// Puts every triangle into the slab of its box's middle, every edge and point into the slab of a
/// triangle that contains it, and the boxes of a slab into groups.
void BodyEnclosure::sort_boxes(const SurfaceView& surface, const Lists& lists) {
  range_.assign(limbs_.size(), {kInfinity, -kInfinity});
  for (std::size_t v = 0; v < lists[0]->size(); ++v) {
    const Limb& limb = limbs_[limb_of_vertex_[v]];
    auto& [lo, hi] = range_[limb_of_vertex_[v]];
    const double s = limb.axis.dot(middle_of_box((*lists[0])[v], limb.origin));
    lo = std::min(lo, s);
    hi = std::max(hi, s);
  }
  const std::vector<std::uint32_t> slab_of_triangle = slabs_of(surface, *lists[2], 2);
  sort_kind(*lists[2], slab_of_triangle, kinds_[2]);
  const TrianglesOfVertices triangles(surface);
  for (const int k : {0, 1}) {
    const std::vector<std::int32_t> owner =
        k == 0 ? point_owners(surface, triangles) : edge_owners(surface, triangles);
    std::vector<std::uint32_t> slab_of = slabs_of(surface, *lists[k], k);
    for (std::size_t i = 0; i < owner.size(); ++i)
      if (owner[i] >= 0) slab_of[i] = slab_of_triangle[owner[i]];
    sort_kind(*lists[k], slab_of, kinds_[k]);
    note_loose(owner, k);
  }
}

/// The slab that contains the middle of each box.
std::vector<std::uint32_t> BodyEnclosure::slabs_of(const SurfaceView& surface,
                                                   const std::vector<DoubleBox>& boxes,
                                                   int kind) const {
  std::vector<std::uint32_t> slab_of(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const std::int32_t at = limb_of_vertex_[first_vertex(surface, kind, i)];
    const Limb& limb = limbs_[at];
    const double s = limb.axis.dot(middle_of_box(boxes[i], limb.origin));
    slab_of[i] = limb.first_slab + slab_at(s, range_[at].first, range_[at].second, limb.slabs);
  }
  return slab_of;
}

void BodyEnclosure::sort_kind(const std::vector<DoubleBox>& boxes,
                              const std::vector<std::uint32_t>& slab_of, SlabBoxes& out) const {
  out.slab_begin.assign(limb_of_slab_.size() + 1, 0);
  for (const std::uint32_t slab : slab_of) ++out.slab_begin[slab + 1];
  for (std::size_t s = 1; s < out.slab_begin.size(); ++s)
    out.slab_begin[s] += out.slab_begin[s - 1];
  std::vector<std::uint32_t> next = out.slab_begin;
  out.order.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    out.order[next[slab_of[i]]++] = static_cast<std::int32_t>(i);
  parallel_for(limb_of_slab_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) group_slab(boxes, static_cast<std::uint32_t>(s), out);
  });
  lay_out_groups(out);
}

void BodyEnclosure::note_loose(const std::vector<std::int32_t>& owner, int kind) {
  SlabIndices& loose = loose_[kind];
  loose.order.clear();
  loose.slab_begin.assign(1, 0);
  for (std::size_t s = 0; s + 1 < kinds_[kind].slab_begin.size(); ++s) {
    for (std::uint32_t i = kinds_[kind].slab_begin[s]; i < kinds_[kind].slab_begin[s + 1]; ++i)
      if (owner[kinds_[kind].order[i]] < 0) loose.order.push_back(kinds_[kind].order[i]);
    loose.slab_begin.push_back(static_cast<std::uint32_t>(loose.order.size()));
  }
}

/// Orders the boxes of a slab by bands along the axis and by angle within each band, so that kGroup
/// consecutive boxes form a patch about as high as it is wide.
void BodyEnclosure::group_slab(const std::vector<DoubleBox>& boxes, std::uint32_t slab,
                               SlabBoxes& out) const {
  const Limb& limb = limb_of(slab);
  const Across across(limb.axis);
  const std::span<std::int32_t> ids(out.order.data() + out.slab_begin[slab],
                                    out.order.data() + out.slab_begin[slab + 1]);
  if (ids.size() <= SlabBoxes::kGroup) return;
  Vec3 middle = Vec3::Zero();
  double lo = kInfinity, hi = -kInfinity, radius = 0.0;
  const auto n = static_cast<double>(ids.size());
  for (const std::int32_t id : ids) {
    const Vec3 y = middle_of_box(boxes[id], limb.origin);
    middle += y / n;
    lo = std::min(lo, limb.axis.dot(y));
    hi = std::max(hi, limb.axis.dot(y));
  }
  for (const std::int32_t id : ids) {
    const Vec3 y = middle_of_box(boxes[id], limb.origin) - middle;
    radius += elementary::hypot(across.x.dot(y), across.y.dot(y)) / n;
  }
  const double most_bands = n / SlabBoxes::kGroup;
  const double bands = std::sqrt(most_bands * (hi - lo) / (2.0 * std::numbers::pi * radius));
  const std::uint32_t band_count = bands < most_bands ? static_cast<std::uint32_t>(bands) + 1
                                                      : static_cast<std::uint32_t>(most_bands) + 1;
  std::vector<std::tuple<std::uint32_t, double, std::int32_t>> keys;
  for (const std::int32_t id : ids) {
    const Vec3 y = middle_of_box(boxes[id], limb.origin);
    keys.emplace_back(slab_at(limb.axis.dot(y), lo, hi, band_count),
                      turn_of(across.x.dot(y - middle), across.y.dot(y - middle)), id);
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = std::get<2>(keys[i]);
}

void BodyEnclosure::lay_out_groups(SlabBoxes& kind) const {
  kind.groups.clear();
  kind.slab_group_begin.assign(1, 0);
  for (std::size_t s = 0; s + 1 < kind.slab_begin.size(); ++s) {
    for (std::uint32_t i = kind.slab_begin[s]; i < kind.slab_begin[s + 1]; i += SlabBoxes::kGroup) {
      kind.groups.emplace_back();
      kind.groups.back().id = static_cast<std::int32_t>(i);
    }
    kind.slab_group_begin.push_back(static_cast<std::uint32_t>(kind.groups.size()));
  }
}

void BodyEnclosure::fit(const Lists& lists) {
  parallel_for(limbs_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) place_limb(lists, limbs_[i]);
  });
  box_ = nothing_box();
  for (const Limb& limb : limbs_) box_ = united(box_, limb.box);
  const auto slabs = static_cast<std::uint32_t>(frusta_.size());
  parallel_for(slabs, 1, [&](std::size_t begin, std::size_t end) {
    for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s)
      frusta_[s] = column_around(lists, s);
  });
  // Cones depend on the neighbouring columns, which do not change here.
  parallel_for(slabs, 1, [&](std::size_t begin, std::size_t end) {
    for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s)
      if ((s - limb_of(s).first_slab) % 2 == 1) tilt_cone(lists, s, frusta_[s]);
  });
  for (Limb& limb : limbs_) note_slabs(limb);
  pack(lists);
}

/// Updates the limb's box, origin and axis to the current positions.
void BodyEnclosure::place_limb(const Lists& lists, Limb& limb) const {
  bool first = true;
  each_box(lists, limb.first_slab, limb.first_slab + limb.slabs, [&](const DoubleBox& box) {
    limb.box = first ? box : united(limb.box, box);
    first = false;
  });
  if (first) {  // All of it belongs to triangles of other limbs.
    limb.box = nothing_box();
    return;
  }
  for (int k = 0; k < 3; ++k) limb.origin[k] = 0.5 * limb.box.lo[k] + 0.5 * limb.box.hi[k];
  limb.far = CenteredBox(limb.box, limb.origin).far();
  if (config_.axis.isZero()) turn_axis(*lists[0], limb);
}

/// The axis points from the middle of the points of the lower half to that of the upper half, so it
/// turns with the limb.
void BodyEnclosure::turn_axis(const std::vector<DoubleBox>& points, Limb& limb) const {
  const SlabBoxes& kind = kinds_[0];
  const auto mean = [&](std::uint32_t begin, std::uint32_t end) {
    Vec3 sum = Vec3::Zero();
    const std::uint32_t from = kind.slab_begin[begin], to = kind.slab_begin[end];
    for (std::uint32_t i = from; i < to; ++i)
      sum += middle_of_box(points[kind.order[i]], limb.origin) / static_cast<double>(to - from);
    return sum;
  };
  const std::uint32_t half = limb.slabs / 2, begin = limb.first_slab, end = begin + limb.slabs;
  if (kind.slab_begin[begin] == kind.slab_begin[begin + half] ||
      kind.slab_begin[end - half] == kind.slab_begin[end])
    return;
  const Vec3 along = mean(end - half, end) - mean(begin, begin + half);
  const Vec3 axis = (along / along.cwiseAbs().maxCoeff()).normalized();
  if (axis.allFinite()) limb.axis = axis;
}

/// The column around the boxes of a slab, centred on their extents perpendicular to the axis.
Frustum BodyEnclosure::column_around(const Lists& lists, std::uint32_t slab) const {
  const Limb& limb = limb_of(slab);
  if (is_empty(slab)) return nothing(limb.axis);
  if (!(limb.far <= Frustum::kMostFar)) return boundless();
  const Across across(limb.axis);
  const std::array<Vec3, 3> directions{limb.axis, across.x, across.y};
  Vec3 lo = Vec3::Constant(kInfinity), hi = -lo;
  each_box(lists, slab, slab + 1, [&](const DoubleBox& box) {
    const CenteredBox centered(box, limb.origin);
    for (int k = 0; k < 3; ++k) {
      const double at = directions[k].dot(centered.middle), reach = centered.reach(directions[k]);
      lo[k] = std::min(lo[k], at - reach);
      hi[k] = std::max(hi[k], at + reach);
    }
  });
  Frustum f;
  f.axis = f.lean = limb.axis;
  f.center = 0.5 * (lo[1] + hi[1]) * across.x + 0.5 * (lo[2] + hi[2]) * across.y;
  f.lo = lo[0];
  f.hi = hi[0];
  fit_radius(lists, slab, f);
  return f;
}

/// Replaces the column of a slab by the cone that continues the neighbouring columns, if that is
/// smaller.
void BodyEnclosure::tilt_cone(const Lists& lists, std::uint32_t slab, Frustum& f) const {
  if (is_empty(slab) || is_empty(slab - 1) || is_empty(slab + 1)) return;
  const Frustum &below = frusta_[slab - 1], &above = frusta_[slab + 1];
  const double from = 0.5 * (below.lo + below.hi), run = 0.5 * (above.lo + above.hi) - from;
  const Vec3 drift = (above.center - below.center) / run;
  Frustum cone = f;
  cone.growth = (above.radius - below.radius) / run;
  // The comparison is written so that a NaN keeps the column.
  if (!(drift.norm() <= kMostSlope && std::abs(cone.growth) <= kMostSlope)) return;
  cone.lean = f.axis + drift;
  cone.center = below.center - from * drift;
  fit_radius(lists, slab, cone);
  if (cone.volume() < f.volume()) f = cone;
}

void BodyEnclosure::fit_radius(const Lists& lists, std::uint32_t slab, Frustum& f) const {
  const Limb& limb = limb_of(slab);
  const double slope = f.slope();
  f.radius = -kInfinity;
  each_box(lists, slab, slab + 1, [&](const DoubleBox& box) {
    f.radius = f.needed_radius(CenteredBox(box, limb.origin), slope, f.radius);
  });
  f.widen(limb.far);
}

void BodyEnclosure::note_slabs(Limb& limb) const {
  limb.highest.resize(limb.slabs);
  limb.lowest.resize(limb.slabs);
  double most = -kInfinity, least = kInfinity;
  for (std::uint32_t i = 0; i < limb.slabs; ++i)
    limb.highest[i] = most = std::max(most, frusta_[limb.first_slab + i].hi);
  for (std::uint32_t i = limb.slabs; i-- > 0;)
    limb.lowest[i] = least = std::min(least, frusta_[limb.first_slab + i].lo);
}

void BodyEnclosure::pack(const Lists& lists) {
  map_ = FloatMap(middle_of(std::span(lists.data(), 1)));
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    SlabBoxes& kind = kinds_[k];
    const std::vector<DoubleBox>& boxes = *lists[k];
    kind.packed.resize(kind.order.size());
    parallel_for(kind.order.size(), kEnclosedGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        kind.packed[i] = map_.pack(boxes[kind.order[i]], kind.order[i]);
    });
    parallel_for(limb_of_slab_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s)
        for (std::uint32_t g = kind.slab_group_begin[s]; g < kind.slab_group_begin[s + 1]; ++g) {
          const std::int32_t from = kind.groups[g].id;
          DoubleBox box = boxes[kind.order[from]];
          for (std::uint32_t i = from + 1; i < kind.group_end(g, s); ++i)
            box = united(box, boxes[kind.order[i]]);
          kind.groups[g] = map_.pack(box, from);
        }
    });
  }
}

double BodyEnclosure::volume() const {
  double sum = 0.0;
  for (const Frustum& f : frusta_)
    if (f.lo <= f.hi) sum += f.volume();
  return sum;
}

double BodyEnclosure::volume_ratio() const {
  const double now = volume();
  if (!std::isfinite(now) || !std::isfinite(cut_volume_)) return kInfinity;
  return cut_volume_ > 0.0 ? now / cut_volume_ : now > 0.0 ? kInfinity : 1.0;
}

std::size_t BodyEnclosure::bytes() const {
  std::size_t sum = limb_of_vertex_.capacity() * sizeof(std::int32_t) +
                    limb_of_slab_.capacity() * sizeof(std::uint32_t) +
                    limbs_.capacity() * sizeof(Limb) + frusta_.capacity() * sizeof(Frustum) +
                    edges_.capacity() * sizeof(Edge) + triangles_.capacity() * sizeof(Triangle);
  for (const SlabBoxes& kind : kinds_) sum += kind.bytes();
  for (const Limb& limb : limbs_)
    sum += (limb.highest.capacity() + limb.lowest.capacity()) * sizeof(double);
  return sum;
}

Enclosure BodyEnclosure::enclosure() const {
  Enclosure out;
  for (const Limb& limb : limbs_) {
    if (!(limb.far <= Frustum::kMostFar))
      throw std::invalid_argument(
          "minimal enclosure: the surface reaches beyond 1e100 m, where columns have no bounds");
    EnclosedLimb& made = out.limbs.emplace_back();
    for (std::uint32_t i = 0; i < limb.slabs; ++i) {
      Frustum f = frusta_[limb.first_slab + i];
      if (f.lo > f.hi) f.lo = f.hi = f.radius = 0.0;
      // Coordinates far from zero have larger rounding errors than those near the limb's origin.
      f.widen(limb.far + limb.origin.lpNorm<1>());
      const Vec3 base = limb.origin + f.center + f.lo * f.lean;
      const Vec3 top = limb.origin + f.center + f.hi * f.lean;
      if (i % 2 == 0)
        made.columns.push_back({base, f.axis, f.hi - f.lo, f.radius});
      else
        made.cones.push_back({base, top, f.axis, f.radius_at(f.lo), f.radius_at(f.hi)});
    }
  }
  return out;
}

}  // namespace selvedge::detail
