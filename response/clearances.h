// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/contact_point.h>

#include <span>
#include <vector>

namespace selvedge {

/// What a fail-safe may ask of the detection: how pairs stand at t = 0. In each answer `weight` are
/// those of the closest points there, and `normal` and `gap` are a separating slab: normal·(x - y)
/// >= gap for every point x of the first primitive and y of the second. The gap is rounded down, so
/// that it never exceeds the distance; 0 means that no slab was found.
class Clearances {
 public:
  virtual ~Clearances() = default;

  /// The same pairs as `hits`, in their order. The slab across a hit's own normal is preferred.
  virtual void at_start(std::span<const ContactPoint> hits, std::vector<ContactPoint>& out) = 0;
  /// At least every pair that can meet while each particle ends anywhere on the line from x_t0 +
  /// shift to its present x_t1.
  virtual void all(const Vec3& shift, std::vector<ContactPoint>& out) = 0;
};

}  // namespace selvedge
