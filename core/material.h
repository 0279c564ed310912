// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

namespace selvedge {

/// How a spring answers its stretch.
enum class StretchLaw {
  hooke,         ///< k (L-L0)
  tension_only,  ///< k (L-L0), nothing under compression [ChoiKo2002, type 1]
  biphasic,      ///< stiffer above a strain [survey 4, Chen 1998]
  kawabata,      ///< curve of a tension test, LT, WT (KES-F1)
};

/// How the right angle between warp and weft is kept.
enum class ShearLaw {
  springs,   ///< diagonals of the cells
  twisting,  ///< moments between the links at a particle [survey 3.1, Dai 2003]; grids only
};

/// How the sheet resists bending. All from the same plate rigidity B.
enum class BendingLaw {
  hinge,    ///< ½ k θ² between two triangles, each by itself; any mesh, exact on grids of cells
  bridson,  ///< sin(θ/2) between two triangles, damping by rate [Bridson2003 as printed]; any mesh
  buckling,  ///< links over two cells that buckle [ChoiKo2002; survey eq. 5]; grids only
  twisting,  ///< moments between collinear links [survey 3.1, Dai 2003; eq. 4 mended]; grids only
  /// The curvature of triangles by the turning of their edges [OnateZarate2000], exact on any mesh;
  /// on grids of cells that is what `hinge` has.
  shape_operator,
};

/// What the cloth is made of, as fabric constants, independent of the mesh.
struct Material {
  double density = 0.2;              ///< kg/m², > 0
  double stretch_stiffness = 500.0;  ///< N/m (force per width per strain along warp and weft), > 0
  double shear_stiffness = 100.0;    ///< N/m (force per width per shear angle), >= 0
  double bending_stiffness = 1e-5;   ///< N·m (plate rigidity B), >= 0
  double spring_damping =
      0.01;  ///< s: damping force of a spring per its stiffness and rate of length, >= 0
  double bending_damping = 0.01;  ///< s: the same for hinges, >= 0
  double strain_limit = 0.1;      ///< largest stretch (L-L0)/L0 of a spring, > 0
  double friction = 0.3;          ///< Coulomb coefficient, cloth on cloth, >= 0
  StretchLaw stretch_law = StretchLaw::hooke;
  ShearLaw shear_law = ShearLaw::springs;
  BendingLaw bending_law = BendingLaw::shape_operator;
  double biphasic_strain = 0.02;  ///< strain at which a biphasic spring becomes stiffer, >= 0
  double biphasic_growth = 10.0;  ///< growth of its stiffness per strain beyond that, >= 0
  double kawabata_lt = 0.7;       ///< linearity of the tension curve, in (0.5, 1]
  double kawabata_strain = 0.05;  ///< EMT/100, strain at the end of the tension test, > 0
  double kawabata_rt = 1.0;     ///< RT/100, share of the work of tension that comes back, in (0, 1]
  double shear_friction = 0.0;  ///< N/m, HG: half the width of the shear loop; twisting only
  double bending_friction =
      0.0;  ///< N, HB: moment per width, half the bending loop; grids and shape_operator
  /// N/m and N·m along weft where that is another constant than along warp, which stretch_stiffness
  /// and bending_stiffness then are. Meshes without warp and weft have the mean. > 0, >= 0.
  std::optional<double> stretch_weft{}, bending_weft{};
};

inline double stretch_along_weft(const Material& m) {
  return m.stretch_weft.value_or(m.stretch_stiffness);
}
inline double bending_along_weft(const Material& m) {
  return m.bending_weft.value_or(m.bending_stiffness);
}

}  // namespace selvedge
