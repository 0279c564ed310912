// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>

#include <cstdint>
#include <string>
#include <vector>

namespace selvedge::detail {

/// The vertices of a piece that a "select" object selects by `vertices`, a `box`, or `corners` or
/// an `edge` of a grid; ascending, each once. `path` is the place of the object in the document.
/// `patterns` make the piece. Throws std::invalid_argument through `fail` for a vertex that does
/// not exist, an empty box, or a corner of a piece that is not a grid.
std::vector<std::int32_t> select_vertices(const LocatedJson& document, const Json& select,
                                          const ClothSpec& cloth, const Material& material,
                                          const ClothPatternRegistry& patterns,
                                          const std::string& path);

}  // namespace selvedge::detail
