// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>

namespace selvedge::narrowphase_detail {

enum class ContactDecision : std::uint8_t { no, yes, open };

/// A simple root of the coplanarity cubic strictly between `floor` and the next double. Below it
/// the cubic has the sign `sign_lo`; `sign_lo` = 0 means that no such root is known.
struct IsolatedRoot {
  double floor = 0.0;
  int sign_lo = 0;
};

/// Stage C: floating point with error bounds, first in doubles, then with the cubic in
/// double-doubles. `yes`: the first contact is at `root`. `open`: no earlier root is a contact, and
/// `root`, if set, may be one.
ContactDecision isolate_contact(const Query& query, IsolatedRoot& root);

}  // namespace selvedge::narrowphase_detail
