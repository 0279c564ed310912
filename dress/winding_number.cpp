// SPDX-License-Identifier: MIT
//
// [Barill2018] G. Barill, N. G. Dickson, R. Schmidt, D. I. W. Levin, A. Jacobson, "Fast winding
// numbers for soups and clouds", 2018. A far cluster of triangles is a dipole at its middle, the
// first term of (11); near triangles are exact [A. Van Oosterom, J. Strackee, "The solid angle of a
// plane triangle", 1983]. Clusters are halves of boxes along their longest axis.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/dress/detail/winding_number.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <numeric>

namespace selvedge::detail {
namespace {

/// A cluster is far from here on, in radii; the error is then below 0.02.
constexpr double kFarAway = 3.0;
constexpr std::int32_t kLeaf = 8;  // triangles

/// Half the solid angle of a triangle, seen from the origin.
double half_solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return elementary::atan2(a.dot(b.cross(c)), below);
}

}  // namespace

WindingNumber::WindingNumber(const TriangleMesh& body)
    : body_(body), order_(body.triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  if (!order_.empty()) build(0, static_cast<std::int32_t>(order_.size()));
}

std::int32_t WindingNumber::build(std::int32_t first, std::int32_t end) {
  const auto middle_of = [&](std::int32_t t) -> Vec3 {
    const Triangle& v = body_.triangles[t];
    return (body_.vertices[v[0]] + body_.vertices[v[1]] + body_.vertices[v[2]]) / 3.0;
  };
  Cluster cluster{.first = first, .end = end};
  Vec3 low = middle_of(order_[first]), high = low, sum = Vec3::Zero();
  double total = 0.0;
  for (std::int32_t i = first; i < end; ++i) {
    const Triangle& v = body_.triangles[order_[i]];
    const Vec3 &a = body_.vertices[v[0]], &b = body_.vertices[v[1]], &c = body_.vertices[v[2]];
    const Vec3 area = 0.5 * (b - a).cross(c - a), middle = middle_of(order_[i]);
    cluster.area += area;
    sum += area.norm() * middle;
    total += area.norm();
    low = low.cwiseMin(middle);
    high = high.cwiseMax(middle);
  }
  cluster.middle = total > 0.0 ? Vec3(sum / total) : low;
  for (std::int32_t i = first; i < end; ++i)
    for (const std::int32_t v : body_.triangles[order_[i]])
      cluster.radius = std::max(cluster.radius, (body_.vertices[v] - cluster.middle).norm());
  const auto here = static_cast<std::int32_t>(clusters_.size());
  clusters_.push_back(cluster);
  if (end - first <= kLeaf) return here;
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::int32_t half = first + (end - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + half, order_.begin() + end,
                   [&](std::int32_t s, std::int32_t t) {
                     return std::pair(middle_of(s)[axis], s) < std::pair(middle_of(t)[axis], t);
                   });
  build(first, half);
  const std::int32_t second = build(half, end);
  clusters_[here].second = second;
  return here;
}

double WindingNumber::at(const Vec3& point) const {
  double sum = 0.0;  // half of the solid angle
  std::vector<std::int32_t> open;
  if (!clusters_.empty()) open.push_back(0);
  while (!open.empty()) {
    const std::int32_t at = open.back();
    const Cluster& cluster = clusters_[at];
    open.pop_back();
    const Vec3 way = cluster.middle - point;
    const double distance = way.norm();
    if (distance > kFarAway * cluster.radius) {
      sum += 0.5 * cluster.area.dot(way) / (distance * distance * distance);
    } else if (cluster.second > 0) {
      open.push_back(cluster.second);
      open.push_back(at + 1);
    } else {
      for (std::int32_t i = cluster.first; i < cluster.end; ++i) {
        const Triangle& v = body_.triangles[order_[i]];
        sum += half_solid_angle(body_.vertices[v[0]] - point, body_.vertices[v[1]] - point,
                                body_.vertices[v[2]] - point);
      }
    }
  }
  return sum / (2.0 * std::numbers::pi);
}

}  // namespace selvedge::detail
