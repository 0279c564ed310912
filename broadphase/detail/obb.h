// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/dop.h>

namespace selvedge::detail {

/// An oriented box [Gottschalk1996] in float, relative to the origin of the tree: all c + Σ aᵢ·uᵢ
/// with |aᵢ| <= halfᵢ, for the axes uᵢ as stored, which are orthonormal to 2⁻²¹. A box that is not
/// finite overlaps everything.
struct FloatObb {
  float center[3], half[3], axis[3][3];
};

/// Eight oriented boxes. Unused lanes must not be read.
struct alignas(32) ObbBlock {
  float center[3][kLanes], half[3][kLanes], axis[3][3][kLanes];
};

inline void set_lane(ObbBlock& block, int lane, const FloatObb& obb) {
  for (int k = 0; k < 3; ++k) {
    block.center[k][lane] = obb.center[k];
    block.half[k][lane] = obb.half[k];
    for (int i = 0; i < 3; ++i) block.axis[k][i][lane] = obb.axis[k][i];
  }
}

/// Sums over points that determine the principal axes. Points are taken relative to `about` to
/// limit cancellation.
struct Moments {
  double count = 0.0;
  Vec3 sum = Vec3::Zero();
  Mat3 products = Mat3::Zero();

  void add(const Vec3& y) {
    count += 1.0;
    sum += y;
    products += y * y.transpose();
  }
  void add(const Moments& other) {
    count += other.count;
    sum += other.sum;
    products += other.products;
  }
};

/// Enlarges an oriented box with given axes to contain the points that are added.
class ObbFit {
 public:
  /// Takes the eigenvectors of the covariance as axes [Gottschalk1996]: of the vertices instead of
  /// the convex hull's faces, which would have to be recomputed in each step. `origin` is the
  /// tree's.
  ObbFit(const Moments& moments, const Vec3& origin);

  /// Adds all points within path.reach of the segment.
  void add(const VertexPath& path) {
    reach_ = std::max(reach_, path.reach);
    for (const Vec3* y : {&path.y_t0, &path.y_t1}) {
      const Vec3 a = to_axes_ * (*y - middle_);
      lo_ = lo_.cwiseMin(a);
      hi_ = hi_.cwiseMax(a);
    }
  }
  /// The box, rounded outwards.
  FloatObb result() const;

 private:
  Vec3 origin_, middle_;
  Mat3 to_axes_;  ///< rows are the axes, rounded to float
  double reach_ = 0.0;
  Vec3 lo_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 hi_ = Vec3::Constant(-std::numeric_limits<double>::infinity());
};

}  // namespace selvedge::detail
