// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

namespace selvedge {

/// Force law of a spring under stretch.
enum class StretchLaw {
  hooke,         ///< k (L-L0)
  tension_only,  ///< k (L-L0) under tension, 0 under compression [ChoiKo2002, type 1]
  biphasic,      ///< stiffer above a given strain [survey 4, Chen 1998]
  kawabata,      ///< tension curve with LT and WT (KES-F1)
};

/// How the cloth resists shear between warp and weft.
enum class ShearLaw {
  springs,  ///< diagonal springs of the cells
  /// Torsional springs between the links at a particle [survey 3.1, Dai 2003]; grids only.
  twisting,
};

/// How the cloth resists bending. All laws use the same plate rigidity B.
enum class BendingLaw {
  /// ½ k θ² for each pair of neighbouring triangles; any mesh, exact on grids of cells.
  hinge,
  /// sin(θ/2) of neighbouring triangles, rate damping [Bridson2003 as printed]; any mesh.
  bridson,
  /// Links across two cells that buckle [ChoiKo2002; survey eq. 5]; grids only.
  buckling,
  /// Torsional springs between collinear links [survey 3.1, Dai 2003; eq. 4 corrected]; grids only.
  twisting,
  /// Curvature of each triangle from the rotation of its edges [OnateZarate2000]; exact on any
  /// mesh, equal to `hinge` on grids of cells.
  shape_operator,
};

/// Fabric constants of a cloth, independent of the mesh.
struct Material {
  double density = 0.2;              ///< kg/m², > 0
  double stretch_stiffness = 500.0;  ///< N/m (force per width per strain along warp and weft), > 0
  double shear_stiffness = 100.0;    ///< N/m (force per width per shear angle), >= 0
  double bending_stiffness = 1e-5;   ///< N·m (plate rigidity B), >= 0
  /// s: damping force of a spring per stiffness and rate of length change, >= 0.
  double spring_damping = 0.01;
  /// s: damping moment of a hinge per stiffness and rate of angle, >= 0.
  double bending_damping = 0.01;
  double strain_limit = 0.1;  ///< largest stretch (L-L0)/L0 of a spring, > 0
  double friction = 0.3;      ///< Coulomb coefficient, cloth on cloth, >= 0
  StretchLaw stretch_law = StretchLaw::hooke;
  ShearLaw shear_law = ShearLaw::springs;
  BendingLaw bending_law = BendingLaw::shape_operator;
  double biphasic_strain = 0.02;  ///< strain above which a biphasic spring is stiffer, >= 0
  double biphasic_growth = 10.0;  ///< growth of the stiffness per strain beyond that, >= 0
  double kawabata_lt = 0.7;       ///< linearity of the tension curve, in (0.5, 1]
  double kawabata_strain = 0.05;  ///< EMT/100, strain at the end of the tension test, > 0
  double kawabata_rt = 1.0;       ///< RT/100, recovered fraction of the work of tension, in (0, 1]
  double shear_friction = 0.0;  ///< N/m, HG: half the width of the shear loop; only with `twisting`
  /// N, HB: moment per width, half the width of the bending loop; grids and shape_operator only.
  double bending_friction = 0.0;
  /// N/m (> 0) and N·m (>= 0) along the weft, if it differs from the warp; stretch_stiffness and
  /// bending_stiffness then apply to the warp. Meshes without warp and weft use the mean.
  std::optional<double> stretch_weft{}, bending_weft{};
};

inline double stretch_along_weft(const Material& m) {
  return m.stretch_weft.value_or(m.stretch_stiffness);
}
inline double bending_along_weft(const Material& m) {
  return m.bending_weft.value_or(m.bending_stiffness);
}

}  // namespace selvedge
