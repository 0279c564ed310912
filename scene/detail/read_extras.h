// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>

namespace selvedge::detail {

/// Puts the constants of each material's "fabric" where the material does not give its own, and
/// notes where they come from instead of the name. Before the document is completed. Throws
/// std::invalid_argument by `fail` for a fabric that is not there or not fit to be used.
void expand_fabrics(LocatedJson& document);

/// The seams and the water of a document that is complete, whose pieces and materials `scene`
/// has. Throw std::invalid_argument by `fail`.
void read_seams(LocatedJson& document, Scene& scene);
void read_water(LocatedJson& document, Scene& scene);

}  // namespace selvedge::detail
