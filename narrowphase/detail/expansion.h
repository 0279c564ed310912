// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace selvedge::detail {

/// A number as an exact sum of non-overlapping doubles, smallest first, none zero. Sums and
/// products are exact as long as no term over- or underflows, which the caller must ensure. After
/// J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
/// predicates", 1997 [Shewchuk1997].
class Expansion {
 public:
  Expansion() = default;
  /// head - tail.
  Expansion(double head, double tail);

  int sign() const { return terms_.empty() ? 0 : terms_.back() > 0.0 ? 1 : -1; }

  friend Expansion operator+(Expansion a, const Expansion& b);
  friend Expansion operator-(Expansion a, const Expansion& b);
  friend Expansion operator*(const Expansion& a, const Expansion& b);

 private:
  /// [Shewchuk1997] theorem 10, without zeros.
  void add(double x);

  std::vector<double> terms_;
};

}  // namespace selvedge::detail
