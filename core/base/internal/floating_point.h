// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace selvedge {

/// One sentence if this thread does not compute as IEEE 754 asks: with another rounding than to the
/// nearest, or with denormals flushed to zero (by -ffast-math in a program that loads the library,
/// or by a game or audio engine). Results would have other bits, and the error bounds of the exact
/// tests would not hold. Else empty.
std::string floating_point_fault();

/// Throws std::runtime_error with that sentence.
void require_ieee_arithmetic();

}  // namespace selvedge
