// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/obb.h>

namespace selvedge::detail {
namespace {

/// Covers, with a large reserve, that axes rounded to float are orthonormal only to 2⁻²¹:
/// coordinates computed by products with the axes are those of c + Σ aᵢ·uᵢ up to 3·2⁻²¹·Σ|aᵢ|.
constexpr double kAxisRounding = 0x1p-18;
/// Covers the rounding of differences and products in double: fewer than 32 roundings.
constexpr double kDoubleRounding = 0x1p-47;

/// The smallest float that is not less than `value`.
float rounded_up(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) >= value
             ? nearest
             : std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

Mat3 principal_axes(const Moments& moments, const Vec3& mean) {
  const Mat3 covariance = moments.products / moments.count - mean * mean.transpose();
  if (!covariance.allFinite()) return Mat3::Identity();
  const Mat3 axes = symmetric_eigen(covariance).vectors.transpose();
  const bool orthonormal = (axes * axes.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() <
                           0x1p-30;  // otherwise the solver has failed; any axes are valid
  return orthonormal ? axes : Mat3::Identity();
}

}  // namespace

ObbFit::ObbFit(const Moments& moments, const Vec3& origin) : origin_(origin) {
  const Vec3 mean = moments.sum / std::max(moments.count, 1.0);
  middle_ = mean.allFinite() ? Vec3(origin + mean) : origin;
  to_axes_ = principal_axes(moments, mean).cast<float>().cast<double>();
}

FloatObb ObbFit::result() const {
  const Vec3 center = middle_ - origin_ + to_axes_.transpose() * (0.5 * (lo_ + hi_));
  const Eigen::Vector3f rounded = center.cast<float>();
  // The half extents are measured from the rounded centre.
  const Vec3 shift = to_axes_ * (rounded.cast<double>() + origin_ - middle_);
  const Vec3 half = (hi_ - shift).cwiseMax(shift - lo_).cwiseMax(0.0) + Vec3::Constant(reach_);
  const double margin = kAxisRounding * half.sum() +
                        kDoubleRounding * (origin_.cwiseAbs().sum() + middle_.cwiseAbs().sum() +
                                           lo_.cwiseAbs().sum() + hi_.cwiseAbs().sum());
  FloatObb obb;
  const bool finite = rounded.allFinite() && half.allFinite();
  for (int k = 0; k < 3; ++k) {
    obb.center[k] = rounded[k];
    obb.half[k] = finite ? rounded_up(half[k] + margin) : std::numeric_limits<float>::infinity();
    for (int i = 0; i < 3; ++i) obb.axis[k][i] = static_cast<float>(to_axes_(k, i));
  }
  return obb;
}

}  // namespace selvedge::detail
