// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/measure.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

/// Edges of a triangle in its own plane, as columns (x1 - x0), (x2 - x0).
Eigen::Matrix2d flat_edges(const Vec3& u, const Vec3& v) {
  const double length = u.norm();
  Eigen::Matrix2d m;
  m << length, u.dot(v) / length, 0.0, u.cross(v).norm() / length;
  return m;
}

TriangleStrain strain_of(const Triangle& t, std::span<const Vec3> x, const Triangle& r,
                         std::span<const Vec3> rest) {
  const Vec3 u = rest[r[1]] - rest[r[0]], v = rest[r[2]] - rest[r[0]];
  TriangleStrain strain;
  strain.area = 0.5 * u.cross(v).norm();
  if (!(strain.area > 0.0)) return {};
  Eigen::Matrix<double, 3, 2> edges;
  edges << x[t[1]] - x[t[0]], x[t[2]] - x[t[0]];
  const Eigen::Matrix<double, 3, 2> gradient = edges * flat_edges(u, v).inverse();
  const Eigen::Matrix2d c = gradient.transpose() * gradient;
  const double mean = 0.5 * (c(0, 0) + c(1, 1));
  const double radius = elementary::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1));
  strain.larger = std::sqrt(mean + radius) - 1.0;
  strain.smaller = std::sqrt(std::max(0.0, mean - radius)) - 1.0;
  return strain;
}

/// Accumulates statistics of weighted values.
class Summary {
 public:
  void add(double value, double weight) {
    total_.max = weight_ == 0.0 ? value : std::max(total_.max, value);
    total_.min = weight_ == 0.0 ? value : std::min(total_.min, value);
    total_.mean += weight * value;
    total_.rms += weight * value * value;
    weight_ += weight;
  }
  StrainSummary result() const {
    if (weight_ == 0.0) return {};
    return {total_.max, total_.min, std::sqrt(total_.rms / weight_), total_.mean / weight_};
  }

 private:
  StrainSummary total_;
  double weight_ = 0.0;
};

}  // namespace

std::vector<TriangleStrain> triangle_strains(std::span<const Vec3> x,
                                             std::span<const Triangle> triangles,
                                             const TriangleMesh& rest) {
  if (triangles.size() != rest.triangles.size())
    throw std::invalid_argument("measure: " + std::to_string(triangles.size()) + " triangles for " +
                                std::to_string(rest.triangles.size()) + " at rest");
  std::vector<TriangleStrain> strains;
  strains.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    strains.push_back(strain_of(triangles[i], x, rest.triangles[i], rest.vertices));
  return strains;
}

StrainSummary summary_of(std::span<const TriangleStrain> strains) {
  Summary sum;
  for (const TriangleStrain& s : strains) {
    if (!(s.area > 0.0)) continue;
    sum.add(s.larger, s.area);
    sum.add(s.smaller, s.area);
  }
  return sum.result();
}

StrainSummary spring_strains(std::span<const Spring> springs, std::span<const Vec3> x) {
  Summary sum;
  for (const Spring& s : springs) sum.add((x[s.b] - x[s.a]).norm() / s.rest_length - 1.0, 1.0);
  return sum.result();
}

}  // namespace selvedge
