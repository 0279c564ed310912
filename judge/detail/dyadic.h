// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <gmpxx.h>

#include <array>
#include <span>
#include <vector>

namespace selvedge::judging {

using IntegerPoint = std::array<mpz_class, 3>;

/// The points, multiplied by the smallest common power of two that makes every coordinate an
/// integer. A finite double is an integer times a power of two, so nothing is rounded. The signs of
/// homogeneous polynomials of the coordinates do not change.
std::vector<IntegerPoint> to_integers(std::span<const Vec3> points);

}  // namespace selvedge::judging
