// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>

namespace selvedge::detail {

/// Reads a piece of cloth from a sewing pattern: `cloth` gets its panels as they stand and their
/// flat rest shape, `seams` one seam for each stitch. The document is checked and completed.
void read_garment(LocatedJson& document, Json& geometry, const std::string& path, ClothSpec& cloth,
                  std::vector<SeamSpec>& seams);

}  // namespace selvedge::detail
