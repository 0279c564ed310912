// SPDX-License-Identifier: MIT
#include <selvedge/simulation/contacts/detail/contact_filter.h>

namespace selvedge::detail {

const double kBorder = 1e-9;

// Rounding for points; for edges an angle of 6 degrees, because cloth that lies along a rim needs
// all of its edges held, not the nearest one.
const double kPointSlope = 1e-6;
const double kEdgeSlope = 0.1;

ContactFilter::ContactFilter(std::size_t n, std::span<const Triangle> triangles)
    : begin_(n + 1, 0), around_(6 * triangles.size()) {
  for (const Triangle& t : triangles)
    for (const std::int32_t i : t) begin_[i + 1] += 2;
  for (std::size_t i = 0; i < n; ++i) begin_[i + 1] += begin_[i];
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t i = t[k], j = t[(k + 1) % 3], l = t[(k + 2) % 3];
      around_[next[i]++] = {j, l};
      around_[next[i]++] = {l, j};
    }
}

// True if a neighbour of the feature (one vertex, or the two of an edge) lies towards the other
// side.
bool ContactFilter::rises(std::span<const std::int32_t> feature, const Vec3& q, const Vec3& towards,
                          double slope, std::span<const Vec3> x) const {
  const double length = towards.norm();
  for (std::size_t k = begin_[feature[0]]; k < begin_[feature[0] + 1]; ++k) {
    if (feature.size() == 2 && around_[k][0] != feature[1]) continue;
    const Vec3 u = x[feature.size() == 2 ? around_[k][1] : around_[k][0]] - q;
    if (towards.dot(u) > slope * length * u.norm()) return true;
  }
  return false;
}

bool ContactFilter::is_true_point_contact(const ContactPoint& c, std::span<const Vec3> x) const {
  return is_nearest(c, relative(c, x), x);
}

bool ContactFilter::is_nearest(const ContactPoint& c, const Vec3& d,
                               std::span<const Vec3> x) const {
  std::array<std::int32_t, 3> feature;
  std::size_t size = 0;
  for (int k = 1; k < 4; ++k)
    if (-c.weight[k] > kBorder) feature[size++] = c.vertex[k];
  if (size == 3) return true;  // inside the triangle
  Vec3 q = Vec3::Zero();
  for (int k = 1; k < 4; ++k) q -= c.weight[k] * x[c.vertex[k]];
  return !rises(std::span(feature).first(size), q, d, kPointSlope, x);
}

bool ContactFilter::is_true_edge_contact(const ContactPoint& c, std::span<const Vec3> x) const {
  const Vec3 d = relative(c, x);
  const Vec3 q_a = c.weight[0] * x[c.vertex[0]] + c.weight[1] * x[c.vertex[1]];
  const Vec3 q_b = q_a - d;
  return !rises(std::span(c.vertex).first(2), q_a, -d, kEdgeSlope, x) &&
         !rises(std::span(c.vertex).last(2), q_b, d, kEdgeSlope, x);
}

}  // namespace selvedge::detail
