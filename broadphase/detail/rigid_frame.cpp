// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/rigid_frame.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace selvedge::detail {
namespace {

/// Rotations must be orthonormal to this tolerance.
constexpr double kOrthonormal = 0x1p-40;
/// Bounds, with a reserve of more than a factor of a thousand, how far rounding, and rotations that
/// are orthonormal only to kOrthonormal, can shift a point, relative to the numbers from which it
/// is computed: each of the body's world and rest positions goes through one pose, its inverse and
/// fewer than 16 roundings.
constexpr double kRounding = 0x1p-30;

void check_rotation(const Mat3& r) {
  const double defect = (r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(defect <= kOrthonormal) || !(r.determinant() > 0.0))
    throw std::invalid_argument(
        "broad phase: the pose of a rigid surface has a matrix that is not a rotation (R'R differs "
        "from the identity by " +
        std::to_string(defect) + "); give an orthonormal one, or no rigid motion");
}

double half_cosine(const Mat3& turn) {
  const double cosine = std::clamp(0.5 * (turn.trace() - 1.0), -1.0, 1.0);
  return std::sqrt(0.5 * (1.0 + cosine));
}

}  // namespace

RigidFrame::RigidFrame(const RigidMotion& motion, double size, double thickness)
    : to_body_t0_(motion.t0.rotation.transpose()),
      to_body_t1_(motion.t1.rotation.transpose()),
      p_t0_(motion.t0.translation),
      p_t1_(motion.t1.translation) {
  check_rotation(motion.t0.rotation);
  check_rotation(motion.t1.rotation);
  if (!p_t0_.allFinite() || !p_t1_.allFinite())
    throw std::invalid_argument(
        "broad phase: the pose of a rigid surface has a translation that is not finite");
  const Mat3 turn = to_body_t0_ * motion.t1.rotation;
  half_cosine_ = half_cosine(turn) * (1.0 - kRounding);
  half_sine_ = std::sqrt(std::max(0.0, 1.0 - half_cosine_ * half_cosine_)) * (1.0 + kRounding);
  body_reach_ = thickness + kRounding * (size + p_t0_.cwiseAbs().sum() + p_t1_.cwiseAbs().sum());
}

VertexPath RigidFrame::path_of_other(const SurfaceView& surface, std::int32_t v) const {
  const Vec3 &x0 = surface.x_t0[v], &x1 = surface.x_t1[v];
  VertexPath path{to_body_t0(x0), to_body_t1(x1), 0.0};
  const double bend = 0.5 * half_sine_ * (path.y_t1 - path.y_t0).norm();
  const double rounding = kRounding * (x0.cwiseAbs().sum() + x1.cwiseAbs().sum());
  path.reach = (bend + surface.thickness + body_reach_ + rounding) / half_cosine_;
  return path;
}

}  // namespace selvedge::detail
