// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/strain_guard.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

// A quarter above the limit, as 12.5 % at a limit of 10 %.
constexpr double kFar = 0.25;

// Growth of accepted strain from which on shorter steps are tried again.
constexpr double kGrown = 1.5;

// A halving helps if the strain grows at most at this share of its rate before. Strain that is
// prescribed grows at the same rate.
constexpr double kStrainHelps = 0.8;

// Halvings in a row that may fail to help: contact found half-way through a step needs more than
// one to show.
constexpr int kInVain = 2;

}  // namespace

bool StrainGuard::is_far(double end) { return end > kFar; }

bool StrainGuard::wants_shorter(const StrainTrial& t) {
  if (!is_far(t.end) || t.end <= std::max(t.start, kGrown * t.given)) return false;
  const double rate = (t.end - t.start) / t.h;
  in_vain_ = last_rate_ >= 0.0 && rate > kStrainHelps * last_rate_ ? in_vain_ + 1 : 0;
  last_rate_ = rate;
  gave_up_ = in_vain_ >= kInVain || !t.may_shorten;
  return !gave_up_;
}

double StrainGuard::given_after(const StrainTrial& t) const {
  if (!is_far(t.end)) return 0.0;
  return gave_up_ ? t.end : std::min(t.given, t.end);
}

}  // namespace selvedge::detail
