// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <array>
#include <vector>

namespace selvedge {

/// A root of a cubic: lo <= root <= hi. lo equals hi if the root is a double; otherwise they are
/// neighbouring doubles.
struct CubicRoot {
  double lo = 0.0, hi = 0.0;
  int multiplicity = 1;
};

/// The distinct real roots of a cubic in the closed interval [0, 1], in ascending order.
struct CubicRoots {
  bool identically_zero = false;  ///< every t is a root; `roots` is empty
  std::vector<CubicRoot> roots;   ///< at most three
};

/// The exact number of roots of c[0] + c[1] t + c[2] t^2 + c[3] t^3 in [0, 1], with multiplicity
/// and enclosures, for any finite doubles; leading zeros are allowed. Throws std::invalid_argument
/// otherwise.
CubicRoots cubic_roots(const std::array<double, 4>& c);

/// The same for the coplanarity cubic of four vertices on straight paths: the times at which they
/// lie in one plane.
CubicRoots coplanarity_roots(const Query& query);

/// Roots that estimate_cubic_roots finds: the first `count` entries of t, ascending.
struct CubicRootEstimates {
  /// Three roots and, where they touch, both ends and both stationary points.
  static constexpr int kMost = 7;
  int count = 0;
  std::array<double, kMost> t;
};

/// The same roots in plain doubles, as naive solvers compute them: fast, without allocation and
/// without guarantee. A root whose bracket is lost to rounding is missed, and rounding may create a
/// false one; the others are within rounding of the coefficients. Ends and stationary points whose
/// |value| <= `touching` count as roots; for the zero cubic, 0 and 1 are reported. Throws like
/// cubic_roots.
CubicRootEstimates estimate_cubic_roots(const std::array<double, 4>& c, double touching = 0.0);

}  // namespace selvedge
