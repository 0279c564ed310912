// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/material.h>

namespace selvedge {

/// What a KES-F laboratory reports, in its own units, the mean of warp and weft.
struct KesSheet {
  double weight = 20.0;              ///< W, mg/cm²
  double lt = 0.7;                   ///< LT, linearity of tension, in (0.5, 1]
  double emt = 5.0;                  ///< EMT, % at 500 gf/cm
  double rt = 100.0;                 ///< RT, %, of the work of tension what comes back; in (0, 100]
  double shear = 0.7;                ///< G, gf/(cm·deg)
  double shear_hysteresis = 1.0;     ///< 2HG, gf/cm
  double bending = 0.1;              ///< B, gf·cm²/cm
  double bending_hysteresis = 0.04;  ///< 2HB, gf·cm/cm
};

/// Newtons in a gram-force, divided by the metres in a centimetre: gf/cm in N/m.
inline constexpr double newton_per_metre_of_gf_per_cm = 0.980665;
/// gf·cm²/cm in N·m (rigidity per width).
inline constexpr double newton_metre_of_gf_cm2_per_cm = 9.80665e-5;
/// gf·cm/cm in N (moment per width).
inline constexpr double newton_of_gf_cm_per_cm = 9.80665e-3;
/// mg/cm² in kg/m².
inline constexpr double kg_per_m2_of_mg_per_cm2 = 0.01;
/// Load at which KES-F1 ends, gf/cm.
inline constexpr double kes_end_of_tension = 500.0;

/// The sheet in SI units: tension by its curves, shear by twisting springs, bending by hinges, both
/// with hysteresis. Throws std::invalid_argument naming the bad field, value and unit.
Material material_of(const KesSheet& sheet);

}  // namespace selvedge
