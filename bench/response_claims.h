// SPDX-License-Identifier: MIT
//
// Measures the survey's claims on responses.
#pragma once

#include <cstdint>
#include <string>

namespace selvedge::bench {

struct ClaimOptions {
  int cells = 24;          ///< per side of the timed drapes
  int repeats = 7;         ///< timed pairs
  std::uint32_t seed = 1;  ///< of samples and bootstrap
  std::string only;        ///< "C9", "C10", "C28" or "C29"; empty: all
};

/// Claims C9, C10, C28 and C29, each with figures; ratios have a 95 % interval.
void print_claims(const ClaimOptions& options);

}  // namespace selvedge::bench
