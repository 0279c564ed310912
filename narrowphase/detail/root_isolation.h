// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>

namespace selvedge::narrowphase_detail {

enum class Verdict : std::uint8_t { no, yes, open };

/// The times [k, k + 1] / 2^m.
struct TimeBox {
  std::int64_t k = 0;
  int m = 0;
  bool monotonic = false;  ///< the coplanarity cubic is strictly so there: it has one root
};

/// Stage C. With `yes` the first contact is at the first root of the coplanarity cubic in `box`.
Verdict isolate(const Query& query, TimeBox& box);

}  // namespace selvedge::narrowphase_detail
