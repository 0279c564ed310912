// SPDX-License-Identifier: MIT
//
// A cantilever in its plane with an exact solution, and its displacements on a mesh of cloth. Used
// by membrane_test and by bench/rivals.
#pragma once

#include <selvedge/core/cloth/force.h>

#include <vector>

namespace selvedge::testing {

/// The plane stress of a cantilever with a load at its end x = 0, which varies as a parabola over
/// the height [TimoshenkoGoodier1951, article 21].
struct Cantilever {
  double length = 4.0, half = 0.5;         ///< m, length and half the height
  double load = 1.0;                       ///< N
  double stretch = 1000.0, poisson = 0.3;  ///< N/m and 1

  /// The isotropic sheet.
  Material material(const std::string& law) const;
  /// m, at a distance x from the loaded end and y from the middle.
  Vec3 displacement(double x, double y) const;
  /// Displacements of the vertices of a rectangular mesh of `rows` rows along the length, to first
  /// order in the load, with the vertices at the other end at their exact places. `stretch` is the
  /// force that carries them; it must have no damping.
  std::vector<Vec3> solve(const ClothMesh& cloth, Force& stretch, std::int32_t rows) const;
  /// Their largest error, relative to the deflection.
  double error(const ClothMesh& cloth, Force& stretch, std::int32_t rows) const;

 private:
  double inertia() const { return 2.0 * half * half * half / 3.0; }
  double load_below(double y) const;
  double moment_below(double y) const;
};

}  // namespace selvedge::testing
