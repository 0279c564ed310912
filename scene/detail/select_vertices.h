// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Finds vertices of the pieces of a scene. Makes each piece once, however many selections there
/// are.
class VertexSelector {
 public:
  /// `patterns` make the pieces; `materials` are those of the scene. Refers to its arguments.
  VertexSelector(const LocatedJson& document, const std::map<std::string, Material>& materials,
                 const ClothPatternRegistry& patterns)
      : document_(document), materials_(materials), patterns_(patterns) {}

  /// The vertices of the piece that "select" names: a side or corner of a grid, a list of these and
  /// of numbers, or a box; ascending, each once. `path` is its place in the document. Throws
  /// std::invalid_argument through `fail` for a vertex that does not exist, an empty box, or a
  /// corner of a piece that is not a grid.
  std::vector<std::int32_t> select(const Json& select, const ClothSpec& cloth,
                                   const std::string& path);

  /// Positions of the vertices of a piece, m: at the start, and in the plane of a grid.
  struct Points {
    std::vector<Vec3> placed, flat;
  };

 private:
  const Points& points(const ClothSpec& cloth);

  const LocatedJson& document_;
  const std::map<std::string, Material>& materials_;
  const ClothPatternRegistry& patterns_;
  std::map<std::string, Points> points_;  // by the name of the piece
};

}  // namespace selvedge::detail
