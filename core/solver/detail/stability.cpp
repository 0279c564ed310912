// SPDX-License-Identifier: MIT
#include <selvedge/core/solver/detail/stability.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace selvedge::detail {
namespace {

// Growth per step that counts as rounding. A mode with less growth needs more than 1e11 steps to
// grow by a factor of e.
constexpr double kGrowth = 1e-11;

// Range of step times frequency in which the end of stability is searched, and the factor between
// two samples. Stability ends at 4 or below; a method that is unstable below kShortest is useless.
// Windows of stability beyond a window of growth do not count.
constexpr double kShortest = 5e-3, kLongest = 64.0, kFactor = 1.04;

constexpr int kStepBisections = 40;

}  // namespace

double spectral_radius(const Eigen::Matrix2d& m) {
  const double half = 0.5 * m.trace(), det = m.determinant();
  const double squared = half * half - det;
  if (squared <= 0.0) return std::sqrt(std::max(0.0, det));
  return std::abs(half) + std::sqrt(squared);
}

double stable_step_of(Amplification amplification, const ModeBound& mode, double wanted) {
  const double speed = mode.omega + mode.rate;
  if (!(speed > 0.0)) return wanted;
  const double omega = mode.omega / speed, rate = mode.rate / speed;
  const auto grows = [&](double tau) {
    const Eigen::Matrix2d m = amplification(tau * tau * omega * omega, tau * rate);
    return !(spectral_radius(m) <= 1.0 + kGrowth);
  };
  double stable = 0.0, tau = kShortest;
  while (tau < kLongest && stable < wanted * speed && !grows(tau)) {
    stable = tau;
    tau *= kFactor;
  }
  if (stable <= 0.0) return 0.0;
  if (stable >= wanted * speed || tau >= kLongest) return std::min(wanted, stable / speed);
  for (int i = 0; i < kStepBisections; ++i) {
    const double middle = 0.5 * (stable + tau);
    (grows(middle) ? tau : stable) = middle;
  }
  return std::min(wanted, stable / speed);
}

}  // namespace selvedge::detail
