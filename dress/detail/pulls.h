// SPDX-License-Identifier: MIT
//
// Forces with which hands pull a garment.
#pragma once

#include <selvedge/dress/detail/dressing.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// The pull on one vertex.
struct Pull {
  std::int32_t vertex = 0;   ///< of the surface
  Vec3 axis = Vec3::Zero();  ///< unit
  double target = 0.0;       ///< m, along the axis
  double area = 0.0;         ///< m², times the strength of the pull
};

/// These methods with a force law that makes the pulls, which must outlive them.
Methods with_pulls(const Methods& methods, const std::vector<Pull>& pulls);

/// Pulls that keep a garment straight that is its own mirror image, on a person: each vertex goes
/// half-way to where its image is on the other side.
class Straightening {
 public:
  Straightening(const Garment& garment, const Dressing& dressing);
  bool any() const { return !straightened_.empty(); }
  /// Of each vertex of the flat pattern the mirror image, or -1.
  const std::vector<std::int32_t>& image() const { return image_; }
  Vec3 mirrored(const Vec3& x) const { return {2.0 * middle_ - x.x(), x.y(), x.z()}; }
  /// Appends its pulls, for the garment as it is.
  void add_pulls(const Garment& garment, std::vector<Pull>& pulls);
  /// Sets their targets for these positions.
  void aim(std::span<const Vec3> x, std::vector<Pull>& pulls) const;

 private:
  /// By three pulls along x, y and z, from `pull` on.
  struct Straightened {
    std::size_t pull = 0;
    std::int32_t vertex = 0, image = 0;  // of the surface
  };
  double middle_ = 0.0;       // m
  std::vector<double> area_;  // m², of the vertices of the flat pattern
  std::vector<std::int32_t> image_;
  std::vector<Straightened> straightened_;
};

}  // namespace selvedge::detail
