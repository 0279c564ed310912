// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>

namespace selvedge::detail {

/// Renames keys of older scene files: "thickness" in "contact" and "contact.pairs" becomes
/// "rest_gap". Call it before the document is checked. Throws std::invalid_argument through `fail`
/// if an object has both names.
void rename_old_keys(LocatedJson& document);

}  // namespace selvedge::detail
