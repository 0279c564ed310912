// SPDX-License-Identifier: MIT
//
// Parts that the patterns at the level of yarns share.
#pragma once

#include <selvedge/core/base/registry.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/patterns/make_yarn_cloth.h>

#include <string>

namespace selvedge::detail {

/// Throws std::invalid_argument if a constant of the yarn is out of range; `which` names the yarn.
void validate_yarn(const std::string& which, const YarnConfig& yarn);
/// Throws std::invalid_argument if a constant of the places where yarns meet is out of range;
/// `links`: of a yarn between two of them.
void validate_meeting(double contact, double rotation, std::int32_t links);
/// Throws std::invalid_argument for laws that a mesh of yarns cannot have; `pattern`: its name.
void refuse_laws_of_a_sheet(const std::string& pattern, const Material& material);

/// Place of vertex (i,j) of the grid, m, or between vertices.
Vec3 place_on(const GridConfig& grid, double i, double j);
/// The surface of a swatch of yarns: the vertices of `grid`, row by row, without mass.
ClothMesh surface_of_yarns(const GridConfig& grid);

/// A yarn through the particles `first` to `first` + count - 1 of `cloth`: springs, and mass from
/// its tex.
void add_yarn_springs(ClothMesh& cloth, std::int32_t first, std::int32_t count,
                      const YarnConfig& yarn, const Material& material);
/// Resistance of the yarn against bending at particle k, from `angle` (rad).
void add_yarn_bend(ClothMesh& cloth, std::int32_t k, double angle, const YarnConfig& yarn,
                   const Material& material);

/// Resistance, N·m per rad, against turning v[0]v[1] against v[2]v[3] from their angle now; none
/// if it is 0.
void add_yarn_angle(ClothMesh& cloth, const std::array<std::int32_t, 4>& v, double stiffness,
                    const Material& material);

/// Stiffnesses where two yarns cross.
struct CrossingStiffness {
  double contact, sliding;  ///< N/m, along the link of the axes and across it
  double rotation;          ///< N·m per rad
};
/// Bonds particles a and b of two yarns, neither of which is at the end of its yarn.
void add_yarn_crossing(ClothMesh& cloth, std::int32_t a, std::int32_t b,
                       const CrossingStiffness& stiffness, const Material& material);
/// Ties vertex `middle` of the surface to particles a and b by these shares of both.
void add_yarn_tie(ClothMesh& cloth, std::int32_t middle, std::int32_t a, std::int32_t b,
                  double share_of_a, double stiffness, const Material& material);

/// The options of a yarn, without its tex, and the yarn that they give with the option `tex`.
std::vector<MethodOption> yarn_options(const YarnConfig& initial);
YarnConfig yarn_of(const MethodOptions& options, const char* tex);
MethodOption rotation_option(double initial);
MethodOption whole_option(const char* name, double initial, double least, const char* meaning);
MethodOption positive_option(const char* name, double initial, const char* unit, double most,
                             const char* meaning);

}  // namespace selvedge::detail
