// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Steps that damp all motion, whatever the integrator would keep: while the seams of a scene are
/// sewn, as their pull is no force of the material, and where cloth in contact is all but still.
/// There, what contacts stir up would otherwise keep it from rest.
class DampedSteps {
 public:
  DampedSteps(const Scene& scene, const BuiltScene& built);

  /// Whether the pairs of the seams are, on average, farther apart than contacts keep cloth. A pair
  /// that something holds open alone does not count. x in m.
  bool sews(std::span<const Vec3> x) const;
  /// Whether no particle moves visibly in a step of h s, seen from their mean; v in m/s.
  bool is_still(std::span<const Vec3> v, double h) const;

 private:
  std::vector<Edge> pairs_;
  double rest_gap_;  // m, the largest
};

}  // namespace selvedge::detail
