// SPDX-License-Identifier: MIT
// [Shewchuk1997] J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust
// geometric predicates", 1997: the filter.
#include <selvedge/core/base/internal/big_int.h>
#include <selvedge/core/base/internal/orientation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace selvedge {
namespace {

constexpr double kRoundoff = std::numeric_limits<double>::epsilon() / 2.0;
// [Shewchuk1997] error bounds A of ORIENT3D and ORIENT2D, relative to the sum of absolute products.
constexpr double kOrient3dBound = (7.0 + 56.0 * kRoundoff) * kRoundoff;
constexpr double kOrient2dBound = (3.0 + 16.0 * kRoundoff) * kRoundoff;
// He excludes underflow, which adds at most 2^-1075 to a product. In space, two such products are
// multiplied by a factor of at most kLargestFactor, and one more is formed, in each of three terms.
constexpr double kLargestFactor = 0x1p300;
constexpr double kOrient3dUnderflow = 0x1p-770;
constexpr double kOrient2dUnderflow = 0x1p-1070;

int sign_of(double value) { return (value > 0.0) - (value < 0.0); }

using IntegerPoint = std::array<BigInt, 3>;

/// Differences from the last point, times a common power of two.
template <std::size_t kCount>
std::array<IntegerPoint, kCount - 1> differences(const std::array<Vec3, kCount>& points) {
  int exponent = std::numeric_limits<int>::max();
  for (const Vec3& x : points)
    for (const double value : x)
      if (value != 0.0) exponent = std::min(exponent, lowest_bit(value));
  std::array<IntegerPoint, kCount - 1> result;
  for (std::size_t i = 0; i + 1 < kCount; ++i)
    for (int k = 0; k < 3; ++k) {
      const double value = points[i][k], origin = points[kCount - 1][k];
      if (value != 0.0) result[i][k] = BigInt::from_double(value, exponent);
      if (origin != 0.0) result[i][k] = result[i][k] - BigInt::from_double(origin, exponent);
    }
  return result;
}

BigInt minor(const IntegerPoint& a, const IntegerPoint& b, int i, int j) {
  return a[i] * b[j] - a[j] * b[i];
}

int exact_orientation(const std::array<Vec3, 4>& points) {
  const auto [u, v, w] = differences(points);
  return (u[0] * minor(v, w, 1, 2) + u[1] * minor(v, w, 2, 0) + u[2] * minor(v, w, 0, 1)).sign();
}

int exact_orientation(const std::array<Vec3, 3>& points, int i, int j) {
  const auto [u, v] = differences(points);
  return minor(u, v, i, j).sign();
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = a - d, v = b - d, w = c - d;
  const double vw_yz = v.y() * w.z(), vw_zy = v.z() * w.y();
  const double vw_zx = v.z() * w.x(), vw_xz = v.x() * w.z();
  const double vw_xy = v.x() * w.y(), vw_yx = v.y() * w.x();
  const double determinant =
      u.x() * (vw_yz - vw_zy) + u.y() * (vw_zx - vw_xz) + u.z() * (vw_xy - vw_yx);
  const double permanent = (std::abs(vw_yz) + std::abs(vw_zy)) * std::abs(u.x()) +
                           (std::abs(vw_zx) + std::abs(vw_xz)) * std::abs(u.y()) +
                           (std::abs(vw_xy) + std::abs(vw_yx)) * std::abs(u.z());
  const double bound = kOrient3dBound * permanent + kOrient3dUnderflow;
  if (u.lpNorm<Eigen::Infinity>() <= kLargestFactor && std::abs(determinant) > bound)
    return sign_of(determinant);
  // A difference is 0 only if the numbers are equal.
  if (u.isZero(0.0) || v.isZero(0.0) || w.isZero(0.0)) return 0;
  for (int k = 0; k < 3; ++k)
    if (u[k] == 0.0 && v[k] == 0.0 && w[k] == 0.0) return 0;
  return exact_orientation({a, b, c, d});
}

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, int axis) {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const double ui = a[i] - c[i], uj = a[j] - c[j], vi = b[i] - c[i], vj = b[j] - c[j];
  const double left = ui * vj, right = uj * vi;
  const double determinant = left - right;
  if (std::abs(determinant) >
      kOrient2dBound * (std::abs(left) + std::abs(right)) + kOrient2dUnderflow)
    return sign_of(determinant);
  if ((ui == 0.0 || vj == 0.0) && (uj == 0.0 || vi == 0.0)) return 0;
  return exact_orientation({a, b, c}, i, j);
}

}  // namespace selvedge
