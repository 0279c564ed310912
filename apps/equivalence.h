// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

namespace selvedge {

/// What paired differences say of their mean: a t-test against each end of ±tolerance.
enum class EquivalenceVerdict {
  equivalent,  ///< the mean is within ±tolerance, with 95 % confidence
  different,   ///< it is outside, with 95 % confidence
  undecided,   ///< neither was shown: more seeds are needed
};

struct Equivalence {
  EquivalenceVerdict verdict = EquivalenceVerdict::undecided;
  double mean = 0.0;
  double low = 0.0, high = 0.0;  ///< each a one-sided bound at 95 %: together the 90 % interval
};

/// Two one-sided tests [Schuirmann1987] at the level of 5 % each, for differences that are drawn
/// independently from about a normal distribution. Undecided for fewer than two values. Where all
/// values are the same they are taken at their word.
Equivalence test_equivalence(std::span<const double> differences, double tolerance);

/// Student's t that is exceeded with 5 %, for `freedom` >= 1 degrees of freedom.
double student_95(std::size_t freedom);

}  // namespace selvedge
