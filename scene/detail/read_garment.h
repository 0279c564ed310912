// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/key_types.h>
#include <selvedge/scene/detail/scene_json.h>

namespace selvedge::detail {

/// Makes a piece of cloth from the keys of a sewing pattern: `piece.cloth`, which has its name,
/// gets the panels as they stand and their flat rest shape, `seams` one seam for each stitch.
void read_garment(const LocatedJson& document, const std::string& path, PieceOf<GarmentKeys>& piece,
                  std::vector<SeamSpec>& seams);

}  // namespace selvedge::detail
