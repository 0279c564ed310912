// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

namespace selvedge::detail {

/// How a mesh that stands in the scene itself is named.
constexpr const char* inline_mesh = "mesh";

/// One piece of cloth as it starts, and at rest.
struct Piece {
  ClothMesh cloth;
  TriangleMesh rest;  ///< scaled, neither rotated nor translated
};
/// Made or loaded, scaled (rest shape too), rotated, translated. Throws std::invalid_argument for
/// what cannot be made.
Piece make_piece(const ClothSpec& cloth, const Material& material);

/// The grid of a piece that is to be refined, unsplit and unplaced. Throws std::invalid_argument
/// for patterns that cannot be.
AdaptiveGrid make_adaptive_grid(const ClothSpec& cloth, const Material& material);

/// Sentences on what springs cannot fit of the piece.
std::vector<std::string> misfits(const ClothSpec& cloth, const Material& material);

/// Places of a body or piece: keep the file's bits where there is nothing to do.
void scale(TriangleMesh& mesh, double factor);
void rotate(std::vector<Vec3>& points, const Eigen::Quaterniond& rotation);
void translate(std::vector<Vec3>& points, const Vec3& translation);

}  // namespace selvedge::detail
