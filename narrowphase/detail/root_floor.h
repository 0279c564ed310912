// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/root_isolation.h>
#include <selvedge/narrowphase/detail/sharp_query.h>

namespace selvedge::detail {

/// Narrows root.lo and root.hi, where f certainly has opposite signs, to neighbouring doubles and
/// sets root.floor to the first. False where the error bound of f does not settle it; then
/// root.floor is a double between them at which the sign is not certain.
bool floor_of_root(const SharpQuery& f, IsolatedRoot& root);

}  // namespace selvedge::detail
