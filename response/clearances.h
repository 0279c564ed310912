// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/contact_point.h>

#include <span>
#include <vector>

namespace selvedge {

/// Answers a fail-safe's questions about the distance of pairs at t = 0. In each answer, `weight`
/// holds the weights of the closest points at t = 0, and `normal` and `gap` describe a separating
/// slab: normal·(x - y) >= gap for every point x of the first primitive and y of the second. `gap`
/// (metres) is rounded down, so it never exceeds the distance; 0 means that no slab was found.
class Clearances {
 public:
  virtual ~Clearances() = default;

  /// Writes the same pairs as `hits`, in the same order, to `out`. Prefers the slab across a hit's
  /// own normal.
  virtual void at_start(std::span<const ContactPoint> hits, std::vector<ContactPoint>& out) = 0;
  /// Writes to `out` at least every pair that can meet while each particle ends anywhere on the
  /// line from x_t0 + shift to its current x_t1. `shift`: metres.
  virtual void all(const Vec3& shift, std::vector<ContactPoint>& out) = 0;
};

}  // namespace selvedge
