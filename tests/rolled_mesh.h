// SPDX-License-Identifier: MIT
#pragma once

// A flat mesh bent to constant curvature.

#include <selvedge/core/base/types.h>

#include <cmath>
#include <vector>

namespace selvedge {

/// The mesh rolled on a cylinder of radius r whose curved direction is at `angle` to the x-axis.
inline std::vector<Vec3> rolled(const std::vector<Vec3>& flat, double r, double angle) {
  const Vec3 n(std::cos(angle), std::sin(angle), 0.0), t(-n.y(), n.x(), 0.0);
  std::vector<Vec3> x;
  for (const Vec3& p : flat) {
    const double s = n.dot(p) / r;
    x.push_back(r * std::sin(s) * n + t.dot(p) * t + Vec3(0, 0, r * (1.0 - std::cos(s))));
  }
  return x;
}

}  // namespace selvedge
