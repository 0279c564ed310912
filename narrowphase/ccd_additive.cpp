// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/per_query.h>
#include <selvedge/narrowphase/detail/separating_direction.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

// [Li2021] M. Li, D. M. Kaufman, C. Jiang, "Codimensional incremental potential contact", 2021,
// section 5, algorithm 1 (additive CCD). Points of the two primitives approach each other by at
// most l_p in a step: the sum of the longest displacements of the two primitives after the mean
// displacement is subtracted. While they are D apart they cannot meet for a time of D / l_p. The
// method adds such times, each multiplied by 1 - s, until the gap is below the fraction s of the
// initial one. It thus stops before contact; the time is early by the time that closing a gap of s
// D(0) takes.
//
// Safe rounding: D is the lower bound of separating_direction(), l_p is rounded upward, and a time
// is added only if the unused fraction s of it exceeds the rounding of the sum.
//
// False alarms: primitives that come nearer than s D(0) without touching, primitives that are
// within about 2^-47 of the query's size at t = 0, and primitives that are still approaching after
// max_steps. Cost: one distance per step; the number of steps is proportional to l_p / (s D(0)). A
// pair that starts close and slides far uses the whole budget of steps.
//
// Deviations: the last gap is measured at the returned time (the paper returns the time before the
// last step); the number of steps is limited.

namespace selvedge {
namespace {

using detail::RelativeQuery;

/// Error reserve in the bound of l_p: each displacement is off by at most 2 units for the input and
/// one rounding of 2, and the mean by as much and two more, in three coordinates, for both
/// primitives: 2 sqrt(3) (4 + 6) < 35; the rest covers the norms and the sum.
constexpr double kSpeedError = 64.0 * detail::kRoundoff;
constexpr double kUp = 1.0 + 16.0 * detail::kRoundoff;

class AdditiveRule {
 public:
  explicit AdditiveRule(const CcdAdditiveConfig& config) : config_(config) {}

  double time(const Query& query) const {
    const RelativeQuery relative = detail::relative_query(query);
    if (relative.one_point) return 0.0;
    const double separation = detail::scaled_up(config_.min_separation, relative);
    return advance(relative, separation);
  }

  NarrowPhaseTraits traits() const {
    return {.misses_nothing = true,
            .source =
                "M. Li, D. M. Kaufman, C. Jiang, Codimensional incremental potential contact, 2021",
            .limits =
                "False alarms where the distance falls below `tolerance` times the initial one, "
                "and where the steps run out."};
  }

 private:
  /// Upper bound of the speed at which two points of the primitives approach each other.
  static double speed(const RelativeQuery& q) {
    std::array<Vec3, 4> p;
    Vec3 mean = Vec3::Zero();
    for (int k = 0; k < 4; ++k) mean += p[k] = q.x_t1[k] - q.x_t0[k];
    mean *= 0.25;
    double first = 0.0, second = 0.0;
    for (int k = 0; k < 4; ++k) {
      double& longest = k < (q.edges ? 2 : 1) ? first : second;
      longest = std::max(longest, (p[k] - mean).norm());
    }
    return (first + second + kSpeedError) * kUp;
  }

  static double gap(const RelativeQuery& q, double t, double separation) {
    const auto x = detail::places(q, t);
    const auto w = detail::vertex_differences(q.edges, x);
    const double distance = detail::separating_direction(q.edges, x, w).distance;
    return distance - separation * kUp;
  }

  double advance(const RelativeQuery& q, double separation) const {
    /// The sum t + step is off by at most u; the unused fraction s of the step must exceed that.
    constexpr double kRounding = 2.0 * detail::kRoundoff;
    const double s = config_.gap, l_p = speed(q);
    const double first = gap(q, 0.0, separation);
    double t = 0.0, left = first;
    for (int i = 0; left > s * first && left > 0.0 && i < config_.max_steps; ++i) {
      const double step = (1.0 - s) * left / l_p;  // [Li2021] alg. 1, line 8
      if (t + step > 1.0) return kNoCollision;
      if (!(s * step > kRounding)) return t;
      t += step;
      left = gap(q, t, separation);
    }
    return t;
  }

  CcdAdditiveConfig config_;
};

void validate(const CcdAdditiveConfig& config) {
  detail::require_separation(config.min_separation, "ccd_additive");
  if (!(config.gap > 0.0 && config.gap < 1.0))
    throw std::invalid_argument(
        "ccd_additive: the gap (tolerance) is " + std::to_string(config.gap) +
        "; it is a fraction of the initial distance and must lie in (0, 1)");
  if (config.max_steps < 1)
    throw std::invalid_argument("ccd_additive: max_steps is " + std::to_string(config.max_steps) +
                                "; it must be 1 or more");
}

}  // namespace

std::unique_ptr<NarrowPhase> make_ccd_additive(const CcdAdditiveConfig& config) {
  validate(config);
  return detail::per_query(AdditiveRule(config));
}

std::unique_ptr<NarrowPhase> make_ccd_additive(const NarrowPhaseConfig& config) {
  CcdAdditiveConfig own;
  own.gap = detail::tolerance_or(config, own.gap, "ccd_additive");
  own.min_separation = config.min_separation;
  return make_ccd_additive(own);
}

void register_ccd_additive(NarrowPhaseRegistry& registry) {
  const CcdAdditiveConfig initial;
  registry.add("ccd_additive",
               {{.name = "tolerance",
                 .initial = initial.gap,
                 .unit = "1",
                 .least = 0.0,
                 .most = 1.0,
                 .above_least = true,
                 .meaning = "fraction of the initial distance at which the method stops; below 1; "
                            "smaller: fewer false alarms, more steps"},
                detail::min_separation_option()},
               [](const MethodOptions& o) {
                 return make_ccd_additive(CcdAdditiveConfig{.gap = o["tolerance"],
                                                            .min_separation = o["min_separation"]});
               });
}

}  // namespace selvedge
