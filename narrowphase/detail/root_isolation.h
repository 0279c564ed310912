// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>

namespace selvedge::detail {

enum class ContactDecision : std::uint8_t { no, yes, open };

/// A simple root of the coplanarity cubic, the only one strictly between two doubles. Below it the
/// cubic has the sign `sign_lo`. If these doubles are neighbours, floor = lo; otherwise floating
/// point does not give the sign of the cubic at `floor`, which is between them.
struct IsolatedRoot {
  double lo = 0.0, hi = 1.0, floor = 0.0;
  int sign_lo = 0;
};

/// Stage C: floating point with error bounds, first in doubles, then with the cubic in
/// double-doubles. Asks stage D about a root where the inside tests are open. `yes`: the first
/// contact is after the double `toi` and before the next one, or at `toi`. `open`: undecided.
/// `is_exact` tells whether stage D was asked.
ContactDecision isolate_contact(const Query& query, double& toi, bool& is_exact);

}  // namespace selvedge::detail
