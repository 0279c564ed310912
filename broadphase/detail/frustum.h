// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/swept_box.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace selvedge::detail {

/// A box relative to an origin: its middle and half extents.
struct CenteredBox {
  Vec3 middle, half;

  /// Subtracts the origin from the corners first: rounding is then relative to the distance from
  /// the origin, however far from zero the box is.
  CenteredBox(const DoubleBox& box, const Vec3& origin) {
    for (int k = 0; k < 3; ++k) {
      const double lo = box.lo[k] - origin[k], hi = box.hi[k] - origin[k];
      middle[k] = 0.5 * lo + 0.5 * hi;
      half[k] = 0.5 * hi - 0.5 * lo;
    }
  }
  /// Σ |component|, an upper bound of the distance of its points from the origin.
  double far() const { return middle.lpNorm<1>() + half.lpNorm<1>(); }
  /// Extent on either side of the middle along d.
  double reach(const Vec3& d) const { return half.dot(d.cwiseAbs()); }
};

/// The extent of a box along the axis of the frusta.
struct AlongAxis {
  double middle, reach, far;

  AlongAxis(const CenteredBox& box, const Vec3& axis)
      : middle(axis.dot(box.middle)), reach(box.reach(axis)), far(box.far()) {}
};

/// A column or a truncated cone of a body. With y = x - origin and s = axis·y it is
///   lo <= s <= hi,  f(y) = |y - center - s·lean| - (radius + s·growth) <= 0.
/// For a column, lean = axis and growth = 0. f is a norm of an affine function minus an affine
/// function, hence convex. Therefore:
/// - a box is inside if its eight corners are;
/// - for any |n| <= 1, g(y) = n·(y - center - s·lean) - radius - s·growth <= f(y), and g is affine:
///   a box on which the minimum of g is above 0 has no point in common with any set inside.
/// Both hold for the numbers as stored. Whether `axis` is exactly a unit vector and `center`
/// exactly perpendicular to it affects the shape but not the proof.
struct Frustum {
  /// Relative size of the margins. The longest of the sums below has about thirty roundings of
  /// 2^-53 of its largest term; this is 2^8 times that, and far too small to affect the result.
  static constexpr double kRounding = 0x1p-40;
  /// A box that reaches farther is never apart, and a body that does has unbounded columns. Squares
  /// of smaller numbers cannot overflow.
  static constexpr double kMostFar = 1e100;

  Vec3 center = Vec3::Zero(), axis = Vec3::UnitX(), lean = Vec3::UnitX();
  double radius = 0.0, growth = 0.0;
  double lo = 0.0, hi = 0.0;

  /// Bound of the change of f per unit of distance.
  double steepness() const {
    return 1.0 + axis.lpNorm<1>() * (lean.lpNorm<1>() + std::abs(growth));
  }
  double radius_at(double s) const { return std::max(0.0, radius + s * growth); }
  double volume() const {
    const double a = radius_at(lo), b = radius_at(hi);
    return std::max(0.0, hi - lo) * (a * a + a * b + b * b) * (std::numbers::pi / 3.0);
  }

  /// f + radius: the radius required to contain y.
  double needed_radius(const Vec3& y) const {
    const double s = axis.dot(y);
    return (y - center - s * lean).norm() - s * growth;
  }
  /// Maximum change of needed_radius per unit of distance, for a unit axis: at most 1 perpendicular
  /// to the axis, and the lean and the growth along it.
  double slope() const { return 1.0 + (lean - axis).norm() + std::abs(growth); }
  /// The radius required to contain the whole box, if that exceeds `least`; otherwise `least` or
  /// less. `steepest`: slope().
  double needed_radius(const CenteredBox& box, double steepest, double least) const {
    if (needed_radius(box.middle) + steepest * box.half.norm() <= least) return least;
    double most = least;
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 y = box.middle;
      for (int k = 0; k < 3; ++k) y[k] += corner >> k & 1 ? box.half[k] : -box.half[k];
      most = std::max(most, needed_radius(y));
    }
    return most;
  }
  /// Enlarges the frustum by the possible rounding of coordinates up to `far` from the origin.
  void widen(double far) {
    const double size = far + center.lpNorm<1>() + std::abs(radius);
    radius += kRounding * steepness() * size;
    lo -= kRounding * size;
    hi += kRounding * size;
  }

  /// True only if the box has no point in common with the contents. NaN gives false. `along` is of
  /// this frustum's axis, unless the frustum contains everything.
  bool is_apart(const CenteredBox& box, const AlongAxis& along) const {
    const double s = along.middle, margin = kRounding * along.far;
    if (!(along.far <= kMostFar)) return false;
    if (s - along.reach > hi + margin || s + along.reach < lo - margin) return true;
    const Vec3 across = box.middle - center - s * lean;
    const double distance = across.norm();
    // Any n is valid; this one, from the middle line to the box, gives the best bound.
    const Vec3 n = across / std::max(distance, std::numeric_limits<double>::min());
    const Vec3 gradient = n - axis * (n.dot(lean) + growth);
    const double least = distance - radius - s * growth - box.reach(gradient);
    return least > steepness() * margin + kRounding * (center.lpNorm<1>() + std::abs(radius));
  }
};

}  // namespace selvedge::detail
