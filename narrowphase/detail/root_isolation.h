// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>

namespace selvedge::narrowphase_detail {

enum class ContactDecision : std::uint8_t { no, yes, open };

/// A simple root of the coplanarity cubic strictly between `floor` and the next double. Below it
/// the cubic has the sign `sign_lo`; `sign_lo` = 0 means that no such root is known. With
/// `is_beside`, floating point cannot tell on which side of `floor` the root is, if on any.
struct IsolatedRoot {
  double floor = 0.0;
  int sign_lo = 0;
  bool is_beside = false;
};

/// Stage C: floating point with error bounds, first in doubles, then with the cubic in
/// double-doubles. Asks stage D about a root where the inside tests are open. `yes`: the first
/// contact is after the double `toi` and before the next one, or at `toi`. `open`: undecided.
/// `is_exact` tells whether stage D was asked.
ContactDecision isolate_contact(const Query& query, double& toi, bool& is_exact);

}  // namespace selvedge::narrowphase_detail
