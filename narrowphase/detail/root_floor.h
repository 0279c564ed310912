// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/sharp_query.h>

namespace selvedge::narrowphase_detail {

/// The largest double not above the only root of f strictly between lo and hi, where f has the sign
/// `sign_lo` at lo and the opposite one at hi. False where the error bound of f does not settle it;
/// then `root` is a double between lo and hi where the sign is not certain.
bool floor_of_root(const SharpQuery& f, double lo, double hi, int sign_lo, double& root);

}  // namespace selvedge::narrowphase_detail
