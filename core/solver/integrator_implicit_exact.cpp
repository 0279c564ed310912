// SPDX-License-Identifier: MIT
//
// Implicit Euler of survey eq. 30-34 without simplification of the system:
//   (I - h² M⁻¹ H) Δv = h M⁻¹ (F + h H v),  x⁺ = x + h (v + Δv),
// H_ij = ∂F_i/∂x_j as 3×3 blocks (eq. 32 misprints them), without the part that is indefinite under
// compression. Written for v⁺: (M - h² H) v⁺ = M v + h F(x, v). There is no ∂F/∂v: damping uses the
// velocities at the start. Guarantee: first order. Elastic forces are stable for any step length; a
// mode with damping c is stable for h c < 2 + ½ (hω)². Springs with F = -k (ΔL + d·rate) are stable
// for h above 2 d and for h below a bound set by the stiffest of them, and grow in between.
// implicit_euler has no such gap.
#include <selvedge/core/solver/detail/linear_integrator.h>

#include <algorithm>
#include <cmath>

namespace selvedge {
namespace {

class ImplicitExact final : public detail::LinearIntegrator {
 public:
  using LinearIntegrator::LinearIntegrator;

  IntegratorTraits traits() const override {
    return {.promise = "elastic forces are stable at any step; damping is explicit and checked",
            .source = "survey eq. 30-34 corrected",
            .is_implicit = true,
            .ends_with_mean = true};
  }

  // The amplification polynomial of a mode, (1+θ) μ² - (2-δ) μ + (1-δ) with θ = h²ω² and δ = hc,
  // has a root on the unit circle at μ = -1, where 4 + θ = 2δ.
  double stable_step(const ModeBound& mode, double wanted) const override {
    const double square = 0.5 * mode.omega * mode.omega;
    // ½ω² h² - c h + 2 = 0
    const double under = mode.rate * mode.rate - 8.0 * square;
    if (under <= 0.0 || mode.rate <= 0.0) return wanted;
    if (square <= 0.0) return std::min(wanted, 2.0 / mode.rate);
    // Lower modes have the same ratio c/ω²: beyond twice that ratio none of them grows.
    if (wanted >= mode.rate / square) return wanted;
    return std::min(wanted, 4.0 / (mode.rate + std::sqrt(under)));
  }

 private:
  detail::SystemAt system_of(const StepStart& start, std::span<const Vec3>) const override {
    const Particles& p = start.particles;
    return {{p.x, p.v, p.mass, start.time}, start.h, p.v,
            detail::elastic_tau(start.h),   1.0,     detail::kElasticGain};
  }
};

}  // namespace

void register_implicit_exact(IntegratorRegistry& registry) {
  registry.add("implicit_exact", {},
               [](const MethodOptions&, ForceList forces, std::size_t particles,
                  const ImplicitConfig& solve) {
                 return std::make_unique<ImplicitExact>(std::move(forces), particles, solve);
               });
}

}  // namespace selvedge
