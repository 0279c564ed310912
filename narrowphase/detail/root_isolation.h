// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>

namespace selvedge::narrowphase_detail {

enum class Verdict : std::uint8_t { no, yes, open };

/// Stage C: floating point with error bounds, first in doubles, then with the cubic in
/// double-doubles. With `yes` toi is the largest double not later than the first contact.
Verdict isolate_contact(const Query& query, double& toi);

}  // namespace selvedge::narrowphase_detail
