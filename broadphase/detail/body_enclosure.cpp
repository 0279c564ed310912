// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/body_enclosure.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace selvedge::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A cone that leans or widens more than this becomes a column: its wall would be long and enclose
/// little.
constexpr double kMostSlope = 4.0;

/// A frustum that contains everything.
Frustum boundless() {
  Frustum f;
  f.axis = f.lean = Vec3::Zero();
  f.radius = f.hi = kInfinity;
  f.lo = -kInfinity;
  return f;
}

/// A frustum that contains nothing.
Frustum nothing(const Vec3& axis) {
  Frustum f;
  f.axis = f.lean = axis;
  f.lo = kInfinity;
  f.hi = -kInfinity;
  return f;
}

/// Unit direction of the largest spread of the middles of the boxes, x if there is none. `size`, a
/// bound of their distances from the origin, keeps the squares within the range of doubles.
Vec3 longest_axis(const std::vector<DoubleBox>& boxes, const Vec3& origin, double size) {
  if (!(size > 0.0 && size <= Frustum::kMostFar)) return Vec3::UnitX();
  const auto n = static_cast<double>(boxes.size());
  Vec3 mean = Vec3::Zero();
  for (const DoubleBox& box : boxes) mean += CenteredBox(box, origin).middle / size / n;
  Mat3 spread = Mat3::Zero();
  for (const DoubleBox& box : boxes) {
    const Vec3 y = CenteredBox(box, origin).middle / size - mean;
    spread += y * y.transpose();
  }
  const SymmetricEigen eigen = symmetric_eigen(spread);
  const Vec3 axis = eigen.vectors.col(2);
  return eigen.converged && axis.allFinite() ? axis : Vec3::UnitX();
}

}  // namespace

void BodyEnclosure::fit(const SurfaceBoxes& boxes, int loops) {
  const std::array lists{&boxes.points, &boxes.edges, &boxes.triangles};
  const std::size_t slabs = boxes.points.empty() ? 0 : 2 * static_cast<std::size_t>(loops) - 1;
  place(boxes.points);
  map_ = FloatMap(middle_of(std::span(lists.data(), 1)));
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    kinds_[k].boxes = lists[k];
    sort(kinds_[k], slabs);
  }
  frusta_.assign(slabs, {});
  parallel_for(slabs, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) frusta_[s] = column_around(s);
  });
  // Cones depend on the neighbouring columns, which do not change here.
  parallel_for(slabs, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s)
      if (s % 2 == 1) tilt_cone(s);
  });
}

void BodyEnclosure::place(const std::vector<DoubleBox>& points) {
  box_.lo.fill(kInfinity);  // overlaps nothing
  box_.hi.fill(-kInfinity);
  for (const DoubleBox& box : points) box_ = united(box_, box);
  if (points.empty()) return;
  for (int k = 0; k < 3; ++k) origin_[k] = 0.5 * box_.lo[k] + 0.5 * box_.hi[k];
  far_ = CenteredBox(box_, origin_).far();
  axis_ = longest_axis(points, origin_, far_);
  lo_ = kInfinity;
  hi_ = -kInfinity;
  for (const DoubleBox& box : points) {
    const double s = axis_.dot(CenteredBox(box, origin_).middle);
    lo_ = std::min(lo_, s);
    hi_ = std::max(hi_, s);
  }
}

/// Index of the slab that contains the middle of the box; any index if that is NaN.
std::size_t BodyEnclosure::slab_of(const DoubleBox& box, std::size_t slabs) const {
  const double s = axis_.dot(CenteredBox(box, origin_).middle);
  const double at = (s - lo_) / (hi_ - lo_) * static_cast<double>(slabs);
  if (!(at > 0.0)) return 0;
  return at < static_cast<double>(slabs) ? static_cast<std::size_t>(at) : slabs - 1;
}

void BodyEnclosure::sort(SlabBoxes& kind, std::size_t slabs) const {
  const std::vector<DoubleBox>& boxes = *kind.boxes;
  const auto each = [&](auto visit) {
    for (std::size_t i = 0; i < boxes.size(); ++i)
      visit(slab_of(boxes[i], slabs), map_.pack(boxes[i], static_cast<std::int32_t>(i)), 0u);
  };
  sort_into_slots(slabs, each, each, kind.begin, kind.packed);
  kind.groups.clear();
  for (std::size_t i = 0; i < boxes.size(); i += SlabBoxes::kGroup) {
    DoubleBox box = boxes[kind.packed[i].id];
    for (std::size_t j = i + 1; j < std::min(i + SlabBoxes::kGroup, boxes.size()); ++j)
      box = united(box, boxes[kind.packed[j].id]);
    kind.groups.push_back(map_.pack(box, static_cast<std::int32_t>(kind.groups.size())));
  }
}

template <class Visit>
void BodyEnclosure::each_box(std::size_t slab, Visit visit) const {
  for (const SlabBoxes& kind : kinds_)
    for (std::uint32_t i = kind.begin[slab]; i < kind.begin[slab + 1]; ++i)
      visit(CenteredBox((*kind.boxes)[kind.packed[i].id], origin_));
}

bool BodyEnclosure::is_empty(std::size_t slab) const {
  bool empty = true;
  for (const SlabBoxes& kind : kinds_) empty &= kind.begin[slab] == kind.begin[slab + 1];
  return empty;
}

/// The column around the boxes of a slab, centred on their extents perpendicular to the axis.
Frustum BodyEnclosure::column_around(std::size_t slab) const {
  if (is_empty(slab)) return nothing(axis_);
  if (!(far_ <= Frustum::kMostFar)) return boundless();
  const Vec3 across = axis_.unitOrthogonal();
  const std::array<Vec3, 3> directions{axis_, across, axis_.cross(across)};
  Vec3 lo = Vec3::Constant(kInfinity), hi = -lo;
  each_box(slab, [&](const CenteredBox& box) {
    for (int k = 0; k < 3; ++k) {
      const double at = directions[k].dot(box.middle), reach = box.reach(directions[k]);
      lo[k] = std::min(lo[k], at - reach);
      hi[k] = std::max(hi[k], at + reach);
    }
  });
  Frustum f;
  f.axis = f.lean = axis_;
  f.center = 0.5 * (lo[1] + hi[1]) * directions[1] + 0.5 * (lo[2] + hi[2]) * directions[2];
  f.lo = lo[0];
  f.hi = hi[0];
  fit_radius(slab, f);
  return f;
}

/// Replaces the column of a slab by the cone that continues the neighbouring columns, if that is
/// smaller.
void BodyEnclosure::tilt_cone(std::size_t slab) {
  if (is_empty(slab) || is_empty(slab - 1) || is_empty(slab + 1)) return;
  const Frustum &below = frusta_[slab - 1], &above = frusta_[slab + 1];
  const double from = 0.5 * (below.lo + below.hi), run = 0.5 * (above.lo + above.hi) - from;
  const Vec3 drift = (above.center - below.center) / run;
  Frustum& f = frusta_[slab];
  Frustum cone = f;
  cone.growth = (above.radius - below.radius) / run;
  // The comparison is written so that a NaN keeps the column.
  if (!(drift.norm() <= kMostSlope && std::abs(cone.growth) <= kMostSlope)) return;
  cone.lean = f.axis + drift;
  cone.center = below.center - from * drift;
  fit_radius(slab, cone);
  if (cone.volume() < f.volume()) f = cone;
}

void BodyEnclosure::fit_radius(std::size_t slab, Frustum& f) const {
  const double slope = f.slope();
  f.radius = -kInfinity;
  each_box(slab, [&](const CenteredBox& box) { f.radius = f.needed_radius(box, slope, f.radius); });
  f.widen(far_);
}

std::size_t BodyEnclosure::bytes() const {
  std::size_t sum = frusta_.capacity() * sizeof(Frustum);
  for (const SlabBoxes& kind : kinds_) sum += kind.bytes();
  return sum;
}

Enclosure BodyEnclosure::enclosure() const {
  Enclosure made;
  if (!frusta_.empty() && !(far_ <= Frustum::kMostFar))
    throw std::invalid_argument(
        "minimal enclosure: the surface reaches beyond 1e100 m, where columns have no bounds");
  for (std::size_t s = 0; s < frusta_.size(); ++s) {
    Frustum f = frusta_[s];
    if (f.lo > f.hi) f.lo = f.hi = f.radius = 0.0;
    // Coordinates far from zero have larger rounding errors than those near the origin.
    f.widen(far_ + origin_.lpNorm<1>());
    const Vec3 base = origin_ + f.center + f.lo * f.lean;
    const Vec3 top = origin_ + f.center + f.hi * f.lean;
    if (s % 2 == 0)
      made.columns.push_back({base, f.axis, f.hi - f.lo, f.radius});
    else
      made.cones.push_back({base, top, f.axis, f.radius_at(f.lo), f.radius_at(f.hi)});
  }
  return made;
}

}  // namespace selvedge::detail
