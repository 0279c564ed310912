// SPDX-License-Identifier: MIT
#include <selvedge/compare/internal/ablation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace selvedge {

/// Table for 1 to 30 degrees of freedom; beyond 30 the last value is conservative.
double student_95(std::size_t freedom) {
  constexpr std::array<double, 30> table = {6.314, 2.920, 2.353, 2.132, 2.015, 1.943, 1.895, 1.860,
                                            1.833, 1.812, 1.796, 1.782, 1.771, 1.761, 1.753, 1.746,
                                            1.740, 1.734, 1.729, 1.725, 1.721, 1.717, 1.714, 1.711,
                                            1.708, 1.706, 1.703, 1.701, 1.699, 1.697};
  return table[std::clamp<std::size_t>(freedom, 1, table.size()) - 1];
}

Equivalence test_equivalence(std::span<const double> differences, double tolerance) {
  Equivalence e;
  const auto n = static_cast<double>(differences.size());
  if (differences.size() < 2) {
    if (!differences.empty()) e.mean = e.low = e.high = differences[0];
    return e;
  }
  for (const double d : differences) e.mean += d / n;
  double squares = 0.0;
  for (const double d : differences) squares += (d - e.mean) * (d - e.mean);
  // mean ± t s/√n
  const double half = student_95(differences.size() - 1) * std::sqrt(squares / (n - 1.0) / n);
  e.low = e.mean - half;
  e.high = e.mean + half;
  if (e.low > -tolerance && e.high < tolerance)
    e.verdict = EquivalenceVerdict::equivalent;
  else if (e.low >= tolerance || e.high <= -tolerance)
    e.verdict = EquivalenceVerdict::different;
  return e;
}

}  // namespace selvedge
