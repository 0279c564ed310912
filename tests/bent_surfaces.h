// SPDX-License-Identifier: MIT
//
// Smooth surfaces with the closed form of their bending, triangle meshes on them, and the discrete
// bending energies of these meshes. Used by bending_energy_test and by bench/bending.
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace selvedge::testing {

/// A surface over the parameters (u, v) in [0, size_u] × [0, size_v].
struct BentSurface {
  std::string name;
  double size_u, size_v;
  double cells_u = 1.0;   ///< cells along u for each cell along v
  bool closed = false;    ///< v = size_v is v = 0
  double integral = 0.0;  ///< ∫ (κ1² + κ2²) dA, 1
  std::function<Vec3(double u, double v)> at;
  std::function<double(double u, double v)> squares;  ///< κ1² + κ2², 1/m²
};
/// Half a cylinder, half a torus, a helicoid, a sixth of a sphere, and a sheet whose crease is an
/// arc of a quarter turn.
std::vector<BentSurface> bent_surfaces();

/// How the rectangle of parameters is divided into triangles.
enum class Pattern {
  one_way,      ///< cells with parallel diagonals
  alternating,  ///< cells whose diagonals alternate
  irregular,    ///< vertices moved by up to a quarter cell, diagonals at random
};
struct BentMesh {
  TriangleMesh mesh;
  std::vector<std::array<double, 2>> place;  ///< u and v of each vertex
  /// Of each triangle: u and v of its middle, and cells between it and the border.
  std::vector<std::array<double, 2>> middle;
  std::vector<std::int32_t> depth;
};
/// `cells` along v. Vertices lie on the surface.
BentMesh divide(const BentSurface& surface, Pattern pattern, std::int32_t cells);

/// A discrete bending energy of a mesh whose rest shape is flat.
enum class BendingModel {
  hinge,           ///< "hinge"
  bridson,         ///< "bridson"
  shape_operator,  ///< "shape_operator"
  /// Finite elements for comparison, which are no law of the cloth: the triangle of [Morley1968],
  /// with the rotations of the edges where the energy is least.
  morley,
};
const char* name_of(BendingModel model);

/// 2 E/B over ∫ (κ1² + κ2²) dA.
struct EnergyRatio {
  double whole = 0.0;  ///< of the whole mesh
  double inner = 0.0;  ///< of the elements that are at least three cells from the border
};
EnergyRatio energy_ratio(const BentSurface& surface, const BentMesh& bent, BendingModel model);

/// The cloth with the rest lengths of `bent` and flat hinges; B = 1 N·m.
ClothMesh flat_hinged(const BentMesh& bent, BendingModel model);
/// Its energy over B.
double energy_of(const BentMesh& bent, BendingModel model);

}  // namespace selvedge::testing
