// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>

namespace selvedge::detail {

/// Renames keys of older scene files: "thickness" in "contact" and "contact.pairs" becomes
/// "rest_gap"; the members of "layers" of a geometry become options of its "pattern". Call it
/// before the document is checked. Throws std::invalid_argument through `fail` if both names are
/// there.
void rename_old_keys(LocatedJson& document);

}  // namespace selvedge::detail
