// SPDX-License-Identifier: MIT
//
// The largest eigenvalue of a level, which sets the step of its smoother.
#include <selvedge/core/solver/detail/lane_ranges.h>
#include <selvedge/core/solver/detail/multilevel.h>

#include <Eigen/Geometry>
#include <utility>

namespace selvedge::detail {
namespace {

constexpr std::size_t kLanczosSteps = 4;
// Halvings of the interval of λ, to a part in a million; a bound for matrices that are not finite.
constexpr int kBisections = 20;
constexpr double kMostEigenvalue = 1024.0;

/// A linear congruential generator.
class Numbers {
 public:
  /// In [-1/2, 1/2).
  double next() { return step() / 4294967296.0 - 0.5; }
  /// In [0, n). The low bits repeat soon.
  std::size_t below(std::size_t n) { return (step() >> 16) % n; }

 private:
  std::uint32_t step() { return state_ = state_ * 1664525u + 1013904223u; }
  std::uint32_t state_ = 12345;
};

/// The largest eigenvalue of a symmetric tridiagonal matrix T, but at least 1. x lies above all
/// eigenvalues if all pivots of x - T are positive. `above`: squares of the entries above the
/// diagonal.
double largest_eigenvalue_of(std::span<const double> diagonal, std::span<const double> above) {
  const auto is_above = [&](double x) {
    double pivot = 1.0;
    for (std::size_t k = 0; k < diagonal.size(); ++k) {
      pivot = x - diagonal[k] - (k == 0 ? 0.0 : above[k - 1] / pivot);
      if (!(pivot > 0.0)) return false;
    }
    return true;
  };
  double low = 1.0, high = 1.0;
  while (high < kMostEigenvalue && !is_above(high)) {
    low = high;
    high *= 2.0;
  }
  for (int k = 0; k < kBisections; ++k) {
    const double middle = 0.5 * (low + high);
    (is_above(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

/// A start without symmetries. Its entries are sums of directions to neighbours and of normals, so
/// that it turns with the cloth. With random entries along the axes, the estimate and all that
/// follows from it within the tolerance of a solve would depend on how the scene lies in them.
void Multilevel::set_start(const Level& level, LaneVector& out) const {
  Numbers numbers;
  const Level& cloth = levels_.front();
  const auto direction = [&](std::int32_t i) {
    const auto row = cloth.column.subspan(cloth.begin[i], cloth.begin[i + 1] - cloth.begin[i]);
    const Vec3 way = x_[row[numbers.below(row.size())]] - x_[i];
    const double length = way.norm();
    return length > 0.0 ? Vec3(way / length) : Vec3(Vec3::Zero());
  };
  for (std::size_t i = 0; i < out.size(); ++i) {
    Mat3 along = Mat3::Identity();
    if (!x_.empty()) {
      along.col(0) = direction(level.particle[i]);
      along.col(1) = direction(level.particle[i]);
      along.col(2) = along.col(0).cross(along.col(1));
    }
    Vec3 v = Vec3::Zero();
    for (int k = 0; k < 3; ++k) v += numbers.next() * along.col(k);
    out.set(i, v);
  }
}

/// Lower estimate of the largest eigenvalue of D⁻¹A: that of the tridiagonal matrix of a few steps
/// of the Lanczos method, which conjugate gradients with D⁻¹ give [Saad2003, section 6.7.3].
double Multilevel::largest_eigenvalue(Level& level) const {
  const LaneMatrixKernel& kernel = lane_matrix_kernel();
  const LaneRows rows = level.matrix.rows(level.base_step);
  LaneVector &r = level.b, &p = level.x, &y = level.y;
  const auto divide = [&](LaneVector& z) {  // z = D⁻¹ r; returns r·z
    by_groups(r, [&](std::size_t first, std::size_t last) {
      kernel.start(rows, r.data(), z.data(), first, last);
    });
    return dot(r, z);
  };
  set_start(level, r);
  std::array<double, kLanczosSteps> diagonal, above;
  double rz = divide(p), from_before = 0.0;  // r·z; β/α of the last step
  std::size_t steps = 0;
  for (; steps < kLanczosSteps; ++steps) {
    const double energy = sum_by_groups(p, [&](std::size_t first, std::size_t last) {
      return kernel.multiply(rows, p.data(), nullptr, y.data(), first, last);
    });
    const double alpha = rz / energy;
    if (!(alpha > 0.0)) break;  // also NaN
    scale_and_add(static_cast<float>(-alpha), r, y);
    std::swap(r, y);
    const double beta = divide(y) / rz;
    rz *= beta;
    diagonal[steps] = 1.0 / alpha + from_before;
    above[steps] = beta / (alpha * alpha);
    from_before = beta / alpha;
    scale_and_add(static_cast<float>(beta), y, p);
  }
  return largest_eigenvalue_of(std::span(diagonal).first(steps), above);
}

}  // namespace selvedge::detail
