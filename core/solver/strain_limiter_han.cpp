// SPDX-License-Identifier: MIT
//
// Modified structural springs of Han et al. 2009 [HanStyliosWatt2009], as the survey describes them
// (section 4.7): a non-linear function gives the force of the spring by its elongation; the
// tangential components of the velocities of springs that are elongated or compressed too far
// decrease; after several iterations, the lengths reach the critical threshold.
// - Velocities: u is the mean velocity of a particle over the step, so a spring ends with the
// vector
//   d + h (u_b - u_a). While its length leaves [(1-τ) L0, (1+τ) L0], a sweep takes the share σ of
//   the relative velocity along the spring that is too much:
//     (u_b - u_a)·n -= σ (L - L_τ)/h,  L_τ: the threshold that is passed, n: unit vector of the
//   spring at the end of the step,
//   from both ends in inverse proportion to their masses. The excess decreases by the factor 1 - σ
//   from sweep to sweep. Unlike the limiter "velocity", this brings springs back that are beyond
//   their threshold when the step starts. Unlike "position", it also limits compression, and acts
//   gradually.
// - Force: the survey does not print the function. Here it is the least one that is odd, smooth and
//   stiffens towards both thresholds, F = K ΔL (1 + γ (ΔL/(τ L0))²): 1 + γ times Hooke's force at
//   the threshold. The springs have Hooke's force already; this force is the rest.
//
// Deviations: it acts on all springs, since cloth does not say which of them are structural. The
// decrease applies to the relative velocity, so that momentum is kept and rigid motion is free. The
// survey does not say at which time the tangent is meant. Along the spring at the start of the step
// the sweeps diverge on fine cloth: a spring that turns by nearly a right angle becomes longer.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/solver/strain_limiter.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace selvedge {
namespace {

class HanLimiter final : public StrainLimitMethod {
 public:
  HanLimiter(std::span<const Spring> springs, std::span<const double> limits, std::size_t particles,
             double share)
      : limiter_(springs, limits, particles), share_(share), u_(particles) {}

  LimiterTraits traits() const override {
    return {.promise = "stretch and compression reach the limit gradually; keeps momentum",
            .source = "Han et al. 2009; survey 4.7",
            .adds_force = true,
            .limits = LimitedStrain::stretch_and_compression};
  }

  const StrainLimiter* limiter() const override { return &limiter_; }
  StrainReport limit_ends(const LimitStep& step, std::span<Vec3> x_t1) override {
    for (std::size_t i = 0; i < x_t1.size(); ++i) u_[i] = (x_t1[i] - step.x_t0[i]) / step.h;
    int sweeps = 0;
    while (sweeps < step.max_sweeps && sweep(step, 0.0) > step.tolerance) {
      sweep(step, share_);
      ++sweeps;
    }
    if (sweeps > 0)
      for (std::size_t i = 0; i < x_t1.size(); ++i)
        if (step.inv_mass[i] > 0.0) x_t1[i] = step.x_t0[i] + step.h * u_[i];
    StrainReport report = limiter_.measure(x_t1);
    report.sweeps = sweeps;
    return report;
  }

 private:
  // Takes this share of what is too much from one spring; returns by how much its strain passed a
  // threshold before.
  double decrease_one(const LimitStep& step, std::size_t s, double share) {
    const Spring& spring = limiter_.springs()[s];
    const double wa = step.inv_mass[spring.a], wb = step.inv_mass[spring.b];
    const Vec3 d = step.x_t0[spring.b] - step.x_t0[spring.a];
    const Vec3 end = d + step.h * (u_[spring.b] - u_[spring.a]);
    const double now = d.norm(), length = end.norm(), l0 = spring.rest_length;
    const double most = limiter_.limits()[s] * l0;
    const double excess = length - std::clamp(length, std::max(0.0, l0 - most), l0 + most);
    if (excess == 0.0 || now <= 0.0 || wa + wb <= 0.0) return 0.0;
    const Vec3 n = length > 0.0 ? Vec3(end / length) : Vec3(d / now);
    const Vec3 impulse = (share * excess / (step.h * (wa + wb))) * n;
    u_[spring.a] += wa * impulse;
    u_[spring.b] -= wb * impulse;
    return std::abs(excess) / l0;
  }

  // Takes this share from every spring; returns the largest strain by which one passed a threshold.
  double sweep(const LimitStep& step, double share) {
    worst_.assign(limiter_.springs().size() / detail::kColorChunk + 1, 0.0);
    detail::for_each_color(limiter_.color_begin(), [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t s = begin; s < end; ++s)
        worst = std::max(worst, decrease_one(step, s, share));
      double& slot = worst_[begin / detail::kColorChunk];  // one for each chunk of a colour
      slot = std::max(slot, worst);
    });
    return *std::max_element(worst_.begin(), worst_.end());
  }

  StrainLimiter limiter_;
  double share_;
  std::vector<Vec3> u_;  // m/s
  std::vector<double> worst_;
};

// γ: force at the limit beyond Hooke's, relative to it.
constexpr double kGrowth = 1.0;

/// K γ ΔL³/(τ L0)², which is what the non-linear function adds to Hooke's force.
class ModifiedSprings {
 public:
  static constexpr int arity = 2;
  static constexpr const char* name = "modified spring";

  ModifiedSprings(std::span<const Spring> springs, std::span<const double> limits) {
    for (std::size_t i = 0; i < springs.size(); ++i) {
      const double most = limits[i] * springs[i].rest_length;
      springs_.push_back({springs[i], kGrowth * springs[i].stiffness / (most * most)});
    }
  }

  std::size_t size() const { return springs_.size(); }
  std::int32_t particle(std::size_t e, int k) const {
    return k == 0 ? springs_[e].spring.a : springs_[e].spring.b;
  }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(springs_, order); }

  detail::ElementSample<2> sample(std::size_t e, std::span<const Vec3> x) const {
    const Spring& s = springs_[e].spring;
    return detail::sample_link(x[s.a], x[s.b], 0.0, [&s, c = springs_[e].cubic](double length) {
      const double d = length - s.rest_length;
      return detail::Tension{0.25 * c * d * d * d * d, c * d * d * d, 3.0 * c * d * d};
    });
  }

 private:
  struct Modified {
    Spring spring;
    double cubic;  // N/m³
  };
  std::vector<Modified> springs_;
};

}  // namespace

void register_modified_springs(StrainLimiterRegistry& registry) {
  const std::vector<MethodOption> options = {
      {.name = "max_sweeps",
       .initial = static_cast<double>(LimitStep{}.max_sweeps),
       .unit = "1",
       .least = 1.0,
       .most = 1e6,
       .kind = OptionKind::whole,
       .meaning =
           "sweeps over the springs in one step; more leave a smaller residual and cost more"},
      {.name = "share",
       .initial = 0.5,
       .unit = "1",
       .least = 0.0,
       .most = 1.0,
       .above_least = true,
       .meaning = "part of the excess that one sweep takes; less is more gradual and takes more "
                  "sweeps"}};
  const auto make = [](const MethodOptions& o, std::span<const Spring> s, std::span<const double> l,
                       std::size_t n) {
    StrainLimit limit{.method = std::make_unique<HanLimiter>(s, l, n, o["share"]),
                      .force = nullptr,
                      .max_sweeps = o.whole("max_sweeps")};
    limit.force = std::make_unique<detail::ElementForce<ModifiedSprings>>(ModifiedSprings(s, l), n);
    return limit;
  };
  registry.add("han", options, make, HanLimiter({}, {}, 0, 1.0).traits());
}

}  // namespace selvedge
