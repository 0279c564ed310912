// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/fields.h>
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/force.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

// The laws by which cloth resists stretch, shear and bending: which elements each makes of a
// material, on which meshes, and which constants it reads beside stiffness and damping. A law adds
// itself, the constants and kinds of elements that no other law has (detail/law_elements.h), and
// the force of its elements, by a function in the .cpp file of that force.

namespace selvedge {

/// How cloth resists stretch.
struct StretchLaw {
  std::string name;                       ///< as in scene files
  std::string text;                       ///< half a sentence
  SpringCurve (*curve)(const Material&);  ///< of springs and yarns
  std::vector<std::string> reads{};       ///< constants that other laws refuse
  /// Adds finite elements, which carry stretch and shear; springs then only measure strain. Null:
  /// springs carry.
  void (*add_to_triangles)(ClothMesh&, std::span<const Vec3> rest, const Material&) = nullptr;
};

/// How cloth resists shear between warp and weft.
struct ShearLaw {
  std::string name, text;
  std::vector<std::string> reads{};
  bool by_springs = false;  ///< the diagonals of cells resist
  /// Woven triangles resist, and stretch along warp and weft as well, each by itself; springs then
  /// only measure strain. Any mesh whose rest shape is flat.
  bool by_triangles = false;
  /// Null: nothing to add to the springs or triangles.
  void (*add_to_grid)(ClothMesh&, const GridConfig&, const Material&) = nullptr;
};

/// The side between two cells of a grid that is split: hinges v at its ends, one for each call.
struct SplitSide {
  std::array<std::int32_t, 4> hinge;
  double stiffness;                  ///< N·m, of the hinge
  std::array<std::int32_t, 3> line;  ///< particles of the row across the side, at this end
  std::array<double, 2> length;      ///< m, between them
  double rigidity_width;             ///< N·m², rigidity times the width that the row stands for
};

/// How cloth resists bending. All laws use the same plate rigidity B.
struct BendingLaw {
  std::string name, text;
  std::vector<std::string> reads{};  ///< on grids of cells
  std::vector<std::string> reads_on_triangles{};
  bool on_cut_cells = true;  ///< grids whose rim cuts cells
  void (*add_to_grid)(ClothMesh&, const GridConfig&, const Material&);
  /// On any triangles. Null: the law needs rows of particles.
  void (*add_to_triangles)(ClothMesh&, std::span<const Vec3> rest, const Material&) = nullptr;
  /// On grids whose cells are split; the twist of a cell always has a hinge. Null: whole cells
  /// only.
  void (*add_to_side)(ClothMesh&, const SplitSide&, const Material&) = nullptr;
  bool by_sine = false;  ///< its hinges resist by sin(θ/2)
};

/// A constant that only one law reads. The law defines it, as a key of materials in scene files.
struct LawConstant {
  std::string name;
  double initial;
  Key key;

  const double& operator()(const Material& m) const {
    const auto given = m.of_laws.find(name);
    return given == m.of_laws.end() ? initial : given->second;
  }
  double& operator()(Material& m) const {
    return m.of_laws.try_emplace(name, initial).first->second;
  }
};

/// All laws, and the forces of all elements in the order in which they add up.
struct FabricLaws {
  std::vector<StretchLaw> stretch;
  std::vector<ShearLaw> shear;
  std::vector<BendingLaw> bending;
  std::vector<LawConstant> constants;
  ForceLawRegistry forces;
};
const FabricLaws& fabric_laws();

/// The laws that a material names. Throw std::invalid_argument for a name that no law has.
const StretchLaw& stretch_law_of(const Material& material);
const ShearLaw& shear_law_of(const Material& material);
const BendingLaw& bending_law_of(const Material& material);

/// The value of a constant that a law defines. Throws std::logic_error if none has this name.
double constant_of_law(const Material& material, const std::string& name);

/// Whether a law reads a constant.
bool reads(const std::vector<std::string>& constants, const std::string& constant);

}  // namespace selvedge
