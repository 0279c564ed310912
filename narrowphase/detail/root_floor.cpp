// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/root_floor.h>

#include <algorithm>
#include <cmath>

namespace selvedge::detail {
namespace {

constexpr int kMostSteps = 80;
/// Newton's method may converge slowly near a multiple root, so every eighth step bisects.
constexpr int kBisectEvery = 8;

}  // namespace

bool floor_of_root(const SharpQuery& f, IsolatedRoot& root) {
  // Newton's method kept strictly inside the bracket [lo, hi], at whose ends the signs are certain.
  // Near the root, a step leads to one end, and the neighbouring double of that end closes the
  // bracket.
  double &lo = root.lo, &hi = root.hi, &t = root.floor;
  t = f.rough_root(lo, hi, root.sign_lo);
  for (int step = 1; std::nextafter(lo, hi) < hi; ++step) {
    t = std::clamp(t, std::nextafter(lo, hi), std::nextafter(hi, lo));
    if (step > kMostSteps) return false;
    int sign = 0;
    const double next = f.newton(t, sign);
    if (sign == 0) return false;
    (sign == root.sign_lo ? lo : hi) = t;
    t = step % kBisectEvery == 0 || std::isnan(next) ? lo + 0.5 * (hi - lo) : next;
  }
  t = lo;
  return true;
}

}  // namespace selvedge::detail
