// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>

namespace selvedge::narrowphase_detail {

enum class Verdict : std::uint8_t { no, yes, open };

/// A simple root of the coplanarity cubic strictly between `floor` and the next double. Below it
/// the cubic has the sign `sign_lo`; 0 says that there is no such root to tell of.
struct IsolatedRoot {
  double floor = 0.0;
  int sign_lo = 0;
};

/// Stage C: floating point with error bounds, first in doubles, then with the cubic in
/// double-doubles. With `yes` the first contact is at `root`. With `open` no earlier root is a
/// contact, and `root`, if there is one, may be.
Verdict isolate_contact(const Query& query, IsolatedRoot& root);

}  // namespace selvedge::narrowphase_detail
