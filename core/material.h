// SPDX-License-Identifier: MIT
#pragma once

namespace selvedge {

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
};

}  // namespace selvedge
