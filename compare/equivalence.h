// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

namespace selvedge {

/// Verdict on the mean of paired differences, from a t-test against each end of ±tolerance.
enum class EquivalenceVerdict {
  equivalent,  ///< the mean is within ±tolerance, with 95 % confidence
  different,   ///< the mean is outside, with 95 % confidence
  undecided,   ///< neither is shown; more seeds are needed
};

struct Equivalence {
  EquivalenceVerdict verdict = EquivalenceVerdict::undecided;
  double mean = 0.0;
  double low = 0.0, high = 0.0;  ///< one-sided 95 % bounds; together the 90 % interval
};

/// Two one-sided tests [Schuirmann1987] at the level of 5 % each, for independent differences with
/// an approximately normal distribution. Returns `undecided` for fewer than two values. If all
/// values are equal, their common value decides without a test.
Equivalence test_equivalence(std::span<const double> differences, double tolerance);

/// Student's t with an exceedance probability of 5 %, for `freedom` >= 1 degrees of freedom.
double student_95(std::size_t freedom);

}  // namespace selvedge
