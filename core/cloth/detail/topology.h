// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/cloth/measure.h>

#include <span>
#include <string>
#include <vector>

namespace selvedge {
struct SplitSide;
}  // namespace selvedge

namespace selvedge::detail {

/// Curvature at which bending friction reaches its full moment: a few per cent of the largest
/// curvature of the instrument, 250 1/m, so that the loop has its full width where the instrument
/// reads it.
inline constexpr double kYieldCurvature = 10.0;  // 1/m

/// Shear angle at which the shear loop reaches its full width: half a degree.
inline constexpr double kYieldShear = 0.0087;  // rad

void validate_material(const Material& material);
void validate_grid(const GridConfig& grid);

/// An edge with exactly two triangles: the edge, its triangles and the opposite vertices. v[0]
/// belongs to the triangle that traverses the edge from v[2] to v[3].
struct InteriorEdge {
  std::array<std::int32_t, 4> v;
  std::array<std::int32_t, 2> triangle;
};
std::vector<InteriorEdge> interior_edges(std::span<const Triangle> triangles);

/// Hinge stiffness in N·m for plate rigidity B. If the cloth is bent to a cylinder of curvature κ,
/// the hinge stores ½ B κ² times a third of the area of both triangles, averaged over all
/// directions of the axis.
double hinge_stiffness(const std::array<std::int32_t, 4>& v, std::span<const Vec3> rest,
                       double bending_stiffness);

/// Springs on the sides 01, 12, 20 of a triangle.
struct SpringFit {
  Vec3 stiffness;         ///< N/m, >= 0
  double area, residual;  ///< m²; |C_springs - C|/|C|
};
/// The spring stiffnesses nearest to `c`, by least squares over the in-plane tensor. `rest` lies in
/// a plane of constant z.
SpringFit fit_springs(std::span<const Vec3> rest, const Triangle& t, const ContinuumConstants& c);

/// True if all points have the same z, so that x is the warp and y the weft.
bool in_a_level(std::span<const Vec3> rest);

/// Adds springs on all edges, and the elements of the bending law, for the rest shape `rest`.
void add_edge_springs(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material);
void add_hinges(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material);

/// Hinges between the triangles, and at a side of cells that are split.
void add_edge_hinges(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material);
void add_side_hinge(ClothMesh& cloth, const SplitSide& side, const Material& material);
/// Adds finite elements of this strain on all triangles.
void add_membrane(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material,
                  MembraneStrain strain);

/// Applies the stretch law of the material: to all springs of `cloth` or, if it is a membrane law,
/// to its triangles with the rest shape `rest`.
void set_stretch_law(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material);
/// Adds a measured curve of shear or bending to the curves of `cloth` and returns its index.
std::int32_t add_idle_curve(ClothMesh& cloth, const MonotoneCurve& curve);
/// The same for the bending curves of warp and weft.
std::array<std::int32_t, 2> add_bending_shapes(ClothMesh& cloth, const Material& material);
/// Throws std::invalid_argument if the material selects a law that only a grid of cells supports.
/// `mesh` names the mesh in the message. `split_cells`: it is a grid whose cells are split.
void require_hinges(const Material& material, const char* mesh, bool split_cells = false);
/// Throws std::invalid_argument if the material has bending friction and its bending law none.
void require_reader_of_bending_friction(const Material& material);
/// 1 for each hinge of `cloth` that a couple names, 0 for the others.
std::vector<char> coupled_hinges(const ClothMesh& cloth);

}  // namespace selvedge::detail
