// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/continuum.h>

#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Where the instrument reads the loop of bending it has its full width: at a few per cent of the
/// largest curvature, 250 1/m.
inline constexpr double yield_curvature = 10.0;  // 1/m

/// Throws std::invalid_argument "<name> must be <rule>, not <value>" unless `good`.
void require(bool good, const std::string& name, double value, const char* rule);
void validate_material(const Material& material);
void validate_grid(const GridConfig& grid);

/// An edge with exactly two triangles: the edge, its triangles and the vertices opposite to it.
/// v[0] belongs to the triangle that runs along v[2] -> v[3].
struct InteriorEdge {
  std::array<std::int32_t, 4> v;
  std::array<std::int32_t, 2> triangle;
};
std::vector<InteriorEdge> interior_edges(std::span<const Triangle> triangles);

/// Hinge stiffness in N·m for plate rigidity B: bent to a cylinder of curvature κ about an axis of
/// any direction, the hinge stores on average its third of both triangles' area times ½ B κ².
double hinge_stiffness(const std::array<std::int32_t, 4>& v, std::span<const Vec3> rest,
                       double bending_stiffness);

/// Springs on the sides 01, 12, 20 of a triangle.
struct SpringFit {
  Vec3 stiffness;         ///< N/m, >= 0
  double area, residual;  ///< m²; |C_springs - C|/|C|
};
/// Those nearest to `c`, by least squares over the tensor of the plane. `rest` lies in a plane of
/// constant z.
SpringFit fit_springs(std::span<const Vec3> rest, const Triangle& t, const ContinuumConstants& c);

/// Whether all points have the same z, so that x is the warp and y the weft.
bool in_a_level(std::span<const Vec3> rest);

/// Springs on all edges and the bending of all interior ones, for the rest shape `rest`.
void add_edge_springs(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material);
void add_hinges(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material);

/// Gives all springs of `cloth` the stretch law of the material.
void set_stretch_law(ClothMesh& cloth, const Material& material);
/// Throws std::invalid_argument where the material asks for a law that only a grid of cells can
/// serve; `mesh` names the mesh in the sentence.
void require_hinges(const Material& material, const char* mesh);

}  // namespace selvedge::detail
