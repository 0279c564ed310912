// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

#include <string_view>
#include <vector>

namespace selvedge {

/// Options of single patterns.
struct PatternOptions {
  LayerConfig layers{};  ///< of "bilayered"
};

/// A way to make cloth out of springs: its names, and how it fills a rectangle.
struct ClothPattern {
  std::string_view name;
  std::string_view promise;  ///< properties of the mesh
  std::string_view source;   ///< author, title, year
  bool splits = false;       ///< AdaptiveGrid can split its cells
  bool fits_plate = false;   ///< its triangles can be fitted to a plate (make_plate)
  bool two_layers = false;   ///< a second layer follows the vertices of the surface
  /// Cloth that fills the rectangle. Null if the cloth is made out of a mesh or by splitting cells.
  /// Throws std::invalid_argument if a number is out of range.
  ClothMesh (*make)(const GridConfig&, const Material&, const PatternOptions&) = nullptr;
};

/// All patterns.
std::vector<ClothPattern> cloth_patterns();
/// The pattern of that name that fills a rectangle. Throws std::invalid_argument with the names
/// that there are.
ClothPattern cloth_pattern(std::string_view name);

}  // namespace selvedge
