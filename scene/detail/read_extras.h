// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/detail/select_vertices.h>

namespace selvedge::detail {

/// Replaces "fabric" of each material by the fabric's constants, except those that the material
/// gives itself; where its numbers come from is added to the description of the scene. Call it
/// before the document is completed. Throws std::invalid_argument through
/// `fail` for a fabric that does not exist or cannot be used.
void expand_fabrics(LocatedJson& document);

/// The piece that `j` names by "geometry", which may be left out if there is only one; it is then
/// added. `scene` has its pieces already. Throws std::invalid_argument through `fail`.
const ClothSpec& piece_of(LocatedJson& document, Json& j, const std::string& path,
                          const Scene& scene);

/// Read the particles of seams and water of a complete document into `scene`, which has the
/// numbers, its pieces and its materials already. Throw std::invalid_argument through `fail`.
void read_seams(LocatedJson& document, VertexSelector& selector, Scene& scene);
void read_water(LocatedJson& document, VertexSelector& selector, Scene& scene);

}  // namespace selvedge::detail
