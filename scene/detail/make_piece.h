// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>

namespace selvedge::detail {

/// Name in messages of a mesh that is part of the scene file.
constexpr const char* inline_mesh = "mesh";

/// One sentence for each property of the plate that springs cannot reproduce.
std::vector<std::string> plate_warnings(const ClothSpec& cloth, const Material& material);
/// A sentence if the springs of this cloth cannot serve the shear stiffness of the material.
std::vector<std::string> shear_warnings(const ClothSpec& cloth, const Material& material);
/// A sentence with the stretch and shear stiffness of an arc mesh, if its springs do not serve
/// those of the material. `piece`: what was made of `cloth`.
std::vector<std::string> arc_warnings(const ClothSpec& cloth, const Material& material,
                                      const Piece& piece);

/// Placement of bodies and pieces. The identity leaves every bit of the coordinates unchanged.
void scale(TriangleMesh& mesh, double factor);
void rotate(std::vector<Vec3>& points, const Eigen::Quaterniond& rotation);
void translate(std::vector<Vec3>& points, const Vec3& translation);

}  // namespace selvedge::detail
