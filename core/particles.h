// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <span>
#include <vector>

namespace selvedge {

/// State of the cloth, structure of arrays, n particles each.
struct Particles {
  std::vector<Vec3> x;           ///< positions, m
  std::vector<Vec3> v;           ///< velocities, m/s
  std::vector<double> mass;      ///< kg, > 0
  std::vector<double> inv_mass;  ///< 1/kg; 0: held, moves only as a handle prescribes

  std::size_t size() const { return x.size(); }
};

}  // namespace selvedge
