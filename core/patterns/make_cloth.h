// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge {

/// Rectangular mesh [Provot1995] with structural springs, both diagonals of each cell as shear
/// springs, and hinges for bending. Throws std::invalid_argument naming the bad field and its
/// value.
ClothMesh make_rectangular(const GridConfig& grid, const Material& material);
/// Mesh of nearly equilateral triangles whose edges are springs [VanGelder1998]; hinges resist
/// bending.
ClothMesh make_triangular(const GridConfig& grid, const Material& material);
/// Rectangular mesh with one diagonal spring per cell [Huang2014; survey 2.7]. The diagonals run in
/// the same direction or, if `alternating`, alternate like the fields of a chessboard.
ClothMesh make_simplified(const GridConfig& grid, const Material& material, bool alternating);
/// Structural and shear springs that resist tension only, and links that buckle [ChoiKo2002].
ClothMesh make_responsive(const GridConfig& grid, const Material& material);

/// A disc in the xy-plane, centred at the origin: a central particle and `rings` concentric rings
/// of `spokes` particles. Particle k of ring j has index 1 + (j-1)·spokes + k, j from 1.
struct DiscConfig {
  double radius = 0.15;      ///< m, > 0
  std::int32_t rings = 15;   ///< >= 1
  std::int32_t spokes = 48;  ///< >= 3
};
/// Arc mesh [RusinkoSwan2012; survey 2.10]: ring, radial and diagonal springs.
ClothMesh make_arc(const DiscConfig& disc, const Material& material);
/// An arc mesh with rings of these radii in m, ascending, numbered as in make_arc.
ClothMesh make_rings(const std::vector<double>& radii, std::int32_t spokes,
                     const Material& material);

/// The grid meshes of the survey as their authors define them, each spring with its own constant.
enum class SpringNet { rectangular, simplified, alternating, responsive };
/// Spring constants of a net, N/m, >= 0. Springs with constant 0 are omitted.
struct NetConstants {
  double structural = 0.0, shear = 0.0;
  double flexion = 0.0;     ///< springs across two cells, along rows and columns
  bool half_border = true;  ///< springs on the border represent half a cell
};
/// A net of Hooke springs without hinges. Only density, damping and strain limit are taken from
/// `material`.
ClothMesh make_spring_net(SpringNet net, const GridConfig& grid, const NetConstants& constants,
                          const Material& material);

/// The two layers of a bilayered cloth.
struct LayerConfig {
  std::int32_t ratio = 4;  ///< cells of the dense layer per cell side of the sparse layer, >= 2
  double share = 0.2;      ///< fraction of mass and stiffness of the dense layer, in (0, 1)
  /// N/m³, force per area and distance with which the dense layer returns to the sparse one, > 0. A
  /// smaller value gives longer wrinkles, 2π (share·B/hold)^¼.
  double hold = 2000.0;
};
/// Bilayered mesh [KangCho2002; survey 2.4]: a sparse rectangular net carries; a dense net is
/// visible, collides and wrinkles, and follows the bilinear surface of the sparse one. `grid`
/// describes the dense layer, whose vertices come first; the vertices of the sparse layer follow
/// and belong to no triangle. The sparse layer has the continuum constants of the fabric, and both
/// together have its mass.
ClothMesh make_bilayered(const GridConfig& grid, const LayerConfig& layers,
                         const Material& material);

/// Cloth from any triangle mesh. `rest` (same topology) gives the rest lengths and angles,
/// `surface` the initial positions. Non-manifold edges get no hinge.
ClothMesh make_from_mesh(const TriangleMesh& surface, const TriangleMesh& rest,
                         const Material& material);

/// The constants K and C of [survey eq. 3].
struct SupportConstants {
  double stiffness = 50.0;  ///< N/m, > 0; also the stiffness of make_volume_force
  double share = 0.5;       ///< fraction of `stiffness` that the support springs take, in (0, 1)
};
/// A closed surface with a support spring from every vertex to a central particle [survey 2.9]. The
/// central particle is the last one and belongs to no triangle.
ClothMesh make_supported(const TriangleMesh& closed, const SupportConstants& support,
                         const Material& material);

/// Cloth of a garment: `surface` is the sewn shape and `pattern` the flat pieces, in m. Triangle i
/// of the pattern is triangle i of the surface. Springs and hinges are those of the flat pieces.
/// Along a seam each side has its own springs, and the seam folds without resistance. Throws
/// std::invalid_argument if surface and pattern do not match.
ClothMesh make_from_pattern(const TriangleMesh& surface, const TriangleMesh& pattern,
                            const Material& material);
/// The same of several fabrics: triangle i has the material with the number fabric[i].
ClothMesh make_from_pattern(const TriangleMesh& surface, const TriangleMesh& pattern,
                            std::span<const Material> materials,
                            std::span<const std::int32_t> fabric);

/// A disc of woven cloth with its yarns along x and y, `cells` cells across: the cells of a
/// rectangular mesh whose triangles lie in the disc, with the rim vertices moved onto the circle.
/// `radius` in m. Throws std::invalid_argument under the conditions of make_rectangular and for
/// fewer than 8 cells.
ClothMesh make_woven_disc(double radius, std::int32_t cells, const Material& material);

}  // namespace selvedge
