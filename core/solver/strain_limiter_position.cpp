// SPDX-License-Identifier: MIT
//
// X. Provot, "Deformation constraints in a mass-spring model to describe rigid cloth behavior",
// 1995 [Provot1995; survey 4.1]: the position correction of strain_limiter.h, alone or combined
// with the removal of the velocity that stretches springs at their limit, as in Y. Zhong, B. Xu,
// "Three-dimensional garment dressing simulation", 2009 [ZhongXu2009; survey 4.4].
// `with_velocity` false is the paper's method: it corrects positions and leaves velocities
// unchanged. The same stretch then returns in the next step, and the energy of the springs changes
// without work being done. The survey calls that "another advantage"; it is the opposite. Otherwise
// the velocity follows from the corrected path. Guarantee: no spring exceeds its limit by more than
// the tolerance, or the report gives the residual; the momentum of the free particles is conserved.
#include <selvedge/core/solver/detail/register_limiter.h>
#include <selvedge/core/solver/detail/spring_sweeps.h>

namespace selvedge {
namespace {

class PositionLimiter : public StrainLimitMethod {
 public:
  PositionLimiter(std::span<const Spring> springs, std::span<const double> limits,
                  std::size_t particles, bool with_velocity, LimitedStrain limited)
      : limiter_(springs, limits, particles, limited), with_velocity_(with_velocity) {}

  LimiterTraits traits() const override {
    return {.promise = with_velocity_
                           ? "bounds the strain and reports the residual; keeps momentum"
                           : "as printed: corrects positions only; velocities continue to stretch",
            .source = "Provot, Deformation constraints in a mass-spring model, 1995; survey 4.1",
            .keeps_velocity = !with_velocity_,
            .limits = limiter_.limited()};
  }
  const StrainLimiter* limiter() const override { return &limiter_; }
  StrainReport limit_ends(const LimitStep& step, std::span<Vec3> x_t1) override {
    return limiter_.apply(step.inv_mass, step.tolerance, step.max_sweeps, x_t1);
  }

 private:
  StrainLimiter limiter_;
  bool with_velocity_;
};

class PositionVelocityLimiter final : public PositionLimiter {
 public:
  PositionVelocityLimiter(std::span<const Spring> springs, std::span<const double> limits,
                          std::size_t particles, LimitedStrain limited)
      : PositionLimiter(springs, limits, particles, true, limited) {}

  LimiterTraits traits() const override {
    return {.promise = "bounds the strain; springs at their limit stop stretching; keeps momentum",
            .source =
                "Zhong, Xu, Three-dimensional garment dressing simulation, 2009; velocities after "
                "Bridson, Fedkiw, Anderson 2002; survey 4.4",
            .limits = limiter()->limited()};
  }
  void limit_velocities(const LimitStep& step, std::span<const Vec3> x,
                        std::span<Vec3> v) override {
    detail::stop_stretching(*limiter(), step, x, v);
  }
};

}  // namespace

void StrainLimitMethod::limit_velocities(const LimitStep&, std::span<const Vec3>, std::span<Vec3>) {
}

std::optional<LimitedValue> StrainLimitMethod::worst(std::span<const Vec3>) const {
  return std::nullopt;
}

void StrainLimitMethod::set_directions(std::span<const Triangle>, const TriangleMesh&) {}

std::unique_ptr<StrainLimitMethod> make_position_limiter(std::span<const Spring> springs,
                                                         std::span<const double> limits,
                                                         std::size_t particles, bool with_velocity,
                                                         LimitedStrain limited) {
  return std::make_unique<PositionLimiter>(springs, limits, particles, with_velocity, limited);
}

std::unique_ptr<StrainLimitMethod> make_position_velocity_limiter(std::span<const Spring> springs,
                                                                  std::span<const double> limits,
                                                                  std::size_t particles,
                                                                  LimitedStrain limited) {
  return std::make_unique<PositionVelocityLimiter>(springs, limits, particles, limited);
}

void register_position_limiters(StrainLimiterRegistry& registry) {
  for (const bool with_velocity : {true, false})
    detail::register_method(registry, with_velocity ? "position" : "position_as_printed",
                            [with_velocity](std::span<const Spring> s, std::span<const double> l,
                                            std::size_t n, LimitedStrain limited) {
                              return make_position_limiter(s, l, n, with_velocity, limited);
                            });
  detail::register_method(registry, "position_velocity", make_position_velocity_limiter);
}

}  // namespace selvedge
