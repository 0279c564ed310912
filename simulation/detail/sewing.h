// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Whether the seams of a scene are being sewn: their pairs are, on average, farther apart than
/// contacts keep cloth. A pair that something holds open alone does not count.
class Sewing {
 public:
  Sewing(const Scene& scene, const BuiltScene& built);

  bool goes_on(std::span<const Vec3> x) const;

 private:
  std::vector<Edge> pairs_;
  double closed_;  // m
};

}  // namespace selvedge::detail
