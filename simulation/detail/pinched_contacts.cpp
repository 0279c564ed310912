// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/distance.h>
#include <selvedge/simulation/detail/pinched_contacts.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace selvedge {
namespace {

// Closest points that differ by less than this share of the rest gap are one.
constexpr double kSamePoint = 1e-3;

// A point of a body lies beside a sheet, and not beyond its border, if the line to the sheet is
// steeper than this (sine of the angle to the sheet).
constexpr double kBeside = 0.3;

// A contact that acts across the cloth by less than this share would act within its plane alone.
constexpr double kAcross = 0.05;

Vec3 area_normal(const Triangle& t, std::span<const Vec3> x) {
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

bool presses(const NearPair& pair) { return pair.kept && pair.contact.gap < pair.contact.rest_gap; }

void act_along(const Vec3& normal, double share, ContactPoint& c) {
  c.normal = normal;
  c.gap *= share;
  c.rest_gap *= share;
}

/// The point of the body, m.
Vec3 body_point(const ContactPoint& c, std::span<const Vec3> x) {
  return x[c.vertex[0]] - relative(c, x);
}

}  // namespace

void PinchedContacts::list_triangles() {
  begin_.assign(particles_ + 1, 0);
  for (const Triangle& t : cloth_)
    for (const std::int32_t i : t) ++begin_[i + 1];
  for (std::size_t i = 0; i < particles_; ++i) begin_[i + 1] += begin_[i];
  around_.resize(begin_.back());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t t = 0; t < cloth_.size(); ++t)
    for (const std::int32_t i : cloth_[t]) around_[next[i]++] = static_cast<std::int32_t>(t);
  normal_.assign(particles_, Vec3::Zero());
}

std::span<const std::int32_t> PinchedContacts::triangles_of(std::int32_t v) const {
  return std::span(around_).subspan(begin_[v], begin_[v + 1] - begin_[v]);
}

// Zero where the triangles around the vertex have no mean direction.
Vec3 PinchedContacts::normal_at(std::int32_t v, std::span<const Vec3> x) const {
  Vec3 sum = Vec3::Zero();
  double area = 0.0;
  for (const std::int32_t t : triangles_of(v)) {
    const Vec3 normal = area_normal(cloth_[t], x);
    sum += normal;
    area += normal.norm();
  }
  const double length = sum.norm();
  return length > 0.5 * area ? Vec3(sum / length) : Vec3(Vec3::Zero());
}

// On which side of the cloth around its vertex the point of the body lies: 1 where normals point
// to, -1, or 0: beyond the border of the cloth.
int PinchedContacts::side_of(const ContactPoint& c, std::span<const Vec3> x) const {
  const Vec3 p = body_point(c, x);
  double least = std::numeric_limits<double>::infinity();
  double sine = 0.0;
  for (const std::int32_t t : triangles_of(c.vertex[0])) {
    const Triangle& v = cloth_[t];
    const ClosestPoints closest = point_triangle_closest(p, x[v[0]], x[v[1]], x[v[2]]);
    if (!(closest.distance < least) || !(closest.distance > 0.0)) continue;
    least = closest.distance;
    sine = closest.separation.dot(area_normal(v, x).stableNormalized()) / closest.distance;
  }
  return sine > kBeside ? 1 : sine < -kBeside ? -1 : 0;
}

// All pairs of one point of the cloth.
void PinchedContacts::straighten_point(std::span<NearPair> group, std::span<const Vec3> x) {
  const auto first = std::find_if(group.begin(), group.end(), presses);
  if (first == group.end()) return;
  const Vec3 p = body_point(first->contact, x);
  const auto elsewhere = [&](const NearPair& pair) {
    return presses(pair) &&
           (body_point(pair.contact, x) - p).norm() > kSamePoint * pair.contact.rest_gap;
  };
  if (std::none_of(first, group.end(), elsewhere)) return;
  if (begin_.empty()) list_triangles();
  const std::int32_t v = first->contact.vertex[0];
  const Vec3 normal = normal_at(v, x);
  if (normal.isZero(0.0)) return;
  std::vector<int> sides;
  bool both[2] = {false, false};
  for (const NearPair& pair : group) {
    sides.push_back(pair.kept ? side_of(pair.contact, x) : 0);
    if (sides.back() != 0 && presses(pair)) both[sides.back() > 0 ? 1 : 0] = true;
  }
  if (!both[0] || !both[1]) return;
  normal_[v] = normal;
  pinched_.push_back(v);
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (sides[i] == 0) continue;
    const Vec3 away = -sides[i] * normal;
    const double across = away.dot(group[i].contact.normal);
    if (across < kAcross)
      group[i].kept = false;
    else
      act_along(away, across, group[i].contact);
  }
}

// A pair of an edge or a triangle of the cloth with pinched vertices.
void PinchedContacts::straighten_other(NearPair& pair, std::span<const Vec3> x) const {
  ContactPoint& c = pair.contact;
  Vec3 sum = Vec3::Zero();
  bool pinched = false;
  for (int k = 0; k < 4; ++k) {
    const auto v = static_cast<std::size_t>(c.vertex[k]);
    if (v >= particles_ || c.weight[k] == 0.0) continue;
    pinched = pinched || !normal_[v].isZero(0.0);
    sum += std::abs(c.weight[k]) * normal_at(c.vertex[k], x);
  }
  if (!pinched || sum.isZero(0.0)) return;
  const Vec3 normal = sum.normalized();
  const double across = normal.dot(c.normal);
  if (std::abs(across) < kAcross) return;
  act_along(across > 0.0 ? normal : Vec3(-normal), std::abs(across), c);
}

void PinchedContacts::straighten(std::span<NearPair> pairs, std::span<const Vec3> x) {
  const auto is_point = [](const NearPair& p) {
    return p.contact.kind == ContactKind::point_triangle;
  };
  std::size_t i = 0;
  while (i < pairs.size()) {
    if (!pairs[i].kept || !is_point(pairs[i])) {
      ++i;
      continue;
    }
    std::size_t last = i + 1;
    while (last < pairs.size() &&
           (!pairs[last].kept ||
            (is_point(pairs[last]) && pairs[last].contact.vertex[0] == pairs[i].contact.vertex[0])))
      ++last;
    straighten_point(pairs.subspan(i, last - i), x);
    i = last;
  }
  if (pinched_.empty()) return;
  for (NearPair& pair : pairs)
    if (pair.kept && !is_point(pair)) straighten_other(pair, x);
  for (const std::int32_t v : pinched_) normal_[v].setZero();
  pinched_.clear();
}

}  // namespace selvedge
