// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>

#include <cstdint>
#include <string>
#include <vector>

namespace selvedge::detail {

/// The vertices of a piece that a "select" object means, ascending, each once: `vertices`, a `box`,
/// `corners` or an `edge` of a grid. `path` is the place of the object in the document. Throws
/// std::invalid_argument by `fail` for a vertex that is not there, a box that holds nothing, or a
/// corner of a piece that is no grid.
std::vector<std::int32_t> select_vertices(const LocatedJson& document, const Json& select,
                                          const ClothSpec& cloth, const Material& material,
                                          const std::string& path);

}  // namespace selvedge::detail
