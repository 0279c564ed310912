// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

#include <span>
#include <vector>

namespace selvedge {

struct StrainReport {
  double max_strain = 0.0;  ///< largest (L-L0)/L0 left
  double residual =
      0.0;  ///< largest excess over its limit left: at most the tolerance when it converged
  int sweeps = 0;
};

/// Position correction [Provot1995], survey section 4.1, as mass-weighted Gauss-Seidel over a fixed
/// colouring until no spring exceeds its limit by more than `tolerance` (in strain), at most
/// `max_sweeps` sweeps. Particles with inv_mass 0 do not move. Momentum of the free ones is kept.
class StrainLimiter {
 public:
  StrainLimiter(std::span<const Spring> springs, std::span<const double> limits,
                std::size_t particles);

  StrainReport measure(std::span<const Vec3> x) const;
  StrainReport apply(std::span<const double> inv_mass, double tolerance, int max_sweeps,
                     std::span<Vec3> x) const;

 private:
  std::vector<Spring> springs_;  // sorted by colour
  std::vector<double> limits_;
  std::vector<std::size_t> color_begin_;
};

}  // namespace selvedge
