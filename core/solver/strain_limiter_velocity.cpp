// SPDX-License-Identifier: MIT
//
// Velocity correction [survey 4.3]: springs that would end the step over their limit lose velocity
// along themselves, and the resulting velocities determine the end of the step.
// - T. Vassilev, B. Spanlang, "Efficient cloth model for dressing animated virtual people", 2000
//   [VassilevSpanlang2000], as the survey prints it: both ends of a stretching spring lose all of
//   their velocity along the spring. This removes the momentum of the pair along the spring: two
//   particles that fly along their spring together stop as soon as it stretches. The method slows
//   the cloth as a whole and is not Galilean invariant.
// - R. Bridson, R. Fedkiw, J. Anderson, "Robust treatment of collisions, contact and friction for
//   cloth animation", 2002 [Bridson2002]: the ends lose only relative velocity, in inverse
//   proportion to their masses, and only the part that leads over the limit. Momentum is conserved.
//
// Guarantee: neither method shortens a spring that is over its limit at the start of the step; the
// report gives the remaining excess.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/solver/detail/register_limiter.h>
#include <selvedge/core/solver/detail/spring_sweeps.h>

#include <algorithm>
#include <vector>

namespace selvedge {
namespace {

// A sweep has converged if it changes the strain of every spring over the step by no more than this
// fraction of the tolerance.
constexpr double kWithinTolerance = 0.5;

class VelocityLimiter final : public StrainLimitMethod {
 public:
  VelocityLimiter(std::span<const Spring> springs, std::span<const double> limits,
                  std::size_t particles, bool as_printed, LimitedStrain limited)
      : limiter_(springs, limits, particles, limited), as_printed_(as_printed), u_(particles) {}

  LimiterTraits traits() const override {
    if (as_printed_)
      return {.promise = "as printed: both ends stop along the spring; loses momentum",
              .source =
                  "Vassilev, Spanlang, Efficient cloth model for dressing animated virtual people, "
                  "2000; survey 4.3",
              .bounds_strain = false,
              .keeps_momentum = false,
              .limits = limiter_.limited()};
    return {
        .promise = "no spring stretches beyond its limit; one that is beyond stays; keeps momentum",
        .source = "Bridson, Fedkiw, Anderson, 2002; survey 4.3",
        .bounds_strain = false,
        .limits = limiter_.limited()};
  }

  const StrainLimiter* limiter() const override { return &limiter_; }
  StrainReport limit_ends(const LimitStep& step, std::span<Vec3> x_t1) override;

 private:
  double sweep(const LimitStep& step);
  double correct(const LimitStep& step, std::size_t s);

  StrainLimiter limiter_;
  bool as_printed_;
  std::vector<Vec3> u_;  // m/s, mean velocities of the step
  std::vector<double> change_;
};

/// Corrects one spring; returns by how much it changed the strain at the end of the step.
double VelocityLimiter::correct(const LimitStep& step, std::size_t s) {
  const Spring& spring = limiter_.springs()[s];
  const double wa = step.inv_mass[spring.a], wb = step.inv_mass[spring.b];
  const Vec3 d = step.x_t0[spring.b] - step.x_t0[spring.a];
  const Vec3 relative = u_[spring.b] - u_[spring.a];
  const double now = d.norm();
  if (now <= 0.0 || wa + wb <= 0.0) return 0.0;
  const double squared = (d + step.h * relative).squaredNorm();
  if (!limiter_.is_beyond(s, squared)) return 0.0;
  // In a spring that becomes too short, all that follows has the other sign.
  const double end = std::sqrt(squared), allowed = limiter_.allowed_length(s, end);
  const double sign = end > allowed ? 1.0 : -1.0;
  const Vec3 along = sign / now * d;
  const double rate = relative.dot(along);
  if (as_printed_) {
    if (rate <= 0.0) return 0.0;
    const double before = std::abs(u_[spring.a].dot(along)) + std::abs(u_[spring.b].dot(along));
    if (wa > 0.0) u_[spring.a] -= u_[spring.a].dot(along) * along;
    if (wb > 0.0) u_[spring.b] -= u_[spring.b].dot(along) * along;
    return before * step.h / spring.rest_length;
  }
  const double excess = rate - std::max(0.0, sign * (allowed - now)) / step.h;
  if (excess <= 0.0) return 0.0;
  const Vec3 impulse = (excess / (wa + wb)) * along;
  u_[spring.a] += wa * impulse;
  u_[spring.b] -= wb * impulse;
  return excess * step.h / spring.rest_length;
}

double VelocityLimiter::sweep(const LimitStep& step) {
  change_.assign(limiter_.springs().size() / detail::kColorChunk + 1, 0.0);
  detail::for_each_color(limiter_.color_begin(), [&](std::size_t begin, std::size_t end) {
    // Chunks of one colour start kColorChunk apart, so no two of them share a slot.
    double worst = 0.0;
    for (std::size_t s = begin; s < end; ++s) worst = std::max(worst, correct(step, s));
    double& slot = change_[begin / detail::kColorChunk];
    slot = std::max(slot, worst);
  });
  return change_.empty() ? 0.0 : *std::max_element(change_.begin(), change_.end());
}

StrainReport VelocityLimiter::limit_ends(const LimitStep& step, std::span<Vec3> x_t1) {
  StrainReport report = limiter_.measure(x_t1);
  if (report.residual <= step.tolerance) return report;
  for (std::size_t i = 0; i < x_t1.size(); ++i) u_[i] = (x_t1[i] - step.x_t0[i]) / step.h;
  int sweeps = 0;
  while (sweeps < step.max_sweeps) {
    ++sweeps;
    if (sweep(step) <= kWithinTolerance * step.tolerance) break;
  }
  for (std::size_t i = 0; i < x_t1.size(); ++i)
    if (step.inv_mass[i] > 0.0) x_t1[i] = step.x_t0[i] + step.h * u_[i];
  report = limiter_.measure(x_t1);
  report.sweeps = sweeps;
  return report;
}

}  // namespace

std::unique_ptr<StrainLimitMethod> make_velocity_limiter(std::span<const Spring> springs,
                                                         std::span<const double> limits,
                                                         std::size_t particles, bool as_printed,
                                                         LimitedStrain limited) {
  return std::make_unique<VelocityLimiter>(springs, limits, particles, as_printed, limited);
}

namespace detail {

void stop_stretching(const StrainLimiter& limiter, const LimitStep& step, std::span<const Vec3> x,
                     std::span<Vec3> v) {
  // A few sweeps suffice: the next step handles the rest.
  constexpr int kSweeps = 10;
  for (int k = 0; k < kSweeps; ++k)
    detail::for_each_color(limiter.color_begin(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t s = begin; s < end; ++s) {
        const Spring& spring = limiter.springs()[s];
        const double wa = step.inv_mass[spring.a], wb = step.inv_mass[spring.b];
        const Vec3 d = x[spring.b] - x[spring.a];
        const double length = d.norm();
        const double strain = length / spring.rest_length - 1.0;
        const double near = limiter.limits()[s] - step.tolerance;
        const bool is_short = limiter.limits_compression() && -strain >= near && length > 0.0;
        if ((strain < near && !is_short) || wa + wb <= 0.0) continue;
        const double rate = d.dot(v[spring.b] - v[spring.a]) / length;
        if (is_short ? rate >= 0.0 : rate <= 0.0) continue;
        const Vec3 impulse = (rate / ((wa + wb) * length)) * d;
        v[spring.a] += wa * impulse;
        v[spring.b] -= wb * impulse;
      }
    });
}

}  // namespace detail

void register_velocity_limiters(StrainLimiterRegistry& registry) {
  for (const bool as_printed : {false, true})
    detail::register_method(registry, as_printed ? "velocity_as_printed" : "velocity",
                            [as_printed](std::span<const Spring> s, std::span<const double> l,
                                         std::size_t n, LimitedStrain limited) {
                              return make_velocity_limiter(s, l, n, as_printed, limited);
                            });
}

}  // namespace selvedge
