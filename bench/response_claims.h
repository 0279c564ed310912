// SPDX-License-Identifier: MIT
//
// What the survey says of responses, measured.
#pragma once

#include <cstdint>

namespace selvedge::bench {

struct ClaimOptions {
  int cells = 24;          ///< a side of the timed drapes
  int repeats = 7;         ///< timed pairs
  std::uint32_t seed = 1;  ///< of samples and bootstrap
};

/// C9, C10, C28 and C29, each with figures and, where they are ratios, their 95 % interval.
void print_claims(const ClaimOptions& options);

}  // namespace selvedge::bench
