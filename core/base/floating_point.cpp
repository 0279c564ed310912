// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/floating_point.h>

#include <stdexcept>

namespace selvedge {
namespace {

// volatile: a compiler would compute these at compile time, in the default mode.

bool rounds_to_nearest() {
  const volatile double one = 1.0, above = 0x1p-54, below = 0x1p-55;
  return one + above == 1.0 && one - below == 1.0;
}

bool keeps_denormals() {
  const volatile double least_normal = 0x1p-1022, denormal = 0x1p-1074, half = 0.5, large = 0x1p80;
  return least_normal * half != 0.0 && denormal * large != 0.0;
}

}  // namespace

std::string floating_point_fault() {
  if (!rounds_to_nearest())
    return "the program has set another rounding than to the nearest; call "
           "std::fesetround(FE_TONEAREST) before selvedge computes";
  if (!keeps_denormals())
    return "the program flushes denormal numbers to zero (FTZ or DAZ, as -ffast-math sets them); "
           "clear both before selvedge computes";
  return {};
}

void require_ieee_arithmetic() {
  if (const std::string fault = floating_point_fault(); !fault.empty())
    throw std::runtime_error("selvedge: " + fault);
}

}  // namespace selvedge
