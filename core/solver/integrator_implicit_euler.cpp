// SPDX-License-Identifier: MIT
//
// D. Baraff, A. Witkin, "Large steps in cloth simulation", SIGGRAPH 1998, solved for v⁺ instead of
// Δv: forces are linear in v, so F(x, v⁺) ≈ F(x, 0) + h ∂F/∂x v⁺ + ∂F/∂v v⁺ is exact in the
// damping. Survey eq. 38 omits x and v and prints H for M⁻¹; corrected. Its text says that implicit
// methods need small steps and are more accurate than explicit Euler; in fact they allow large
// steps, and both are of first order. Guarantee: no growth for any step length, as far as the
// dropped indefinite part of ∂F/∂x allows (compressed springs buckle, which is physical growth).
#include <selvedge/core/solver/detail/linear_integrator.h>

namespace selvedge {
namespace {

class ImplicitEuler final : public detail::LinearIntegrator {
 public:
  using LinearIntegrator::LinearIntegrator;

  IntegratorTraits traits() const override {
    return {.promise = "stable at any step of the scene; loses energy, first order",
            .source = "Baraff, Witkin, Large steps in cloth simulation, 1998",
            .any_step = true,
            .is_implicit = true,
            .ends_with_mean = true};
  }

 private:
  detail::SystemAt system_of(const StepStart& start, std::span<const Vec3> zeros) const override {
    const Particles& p = start.particles;
    return {{p.x, zeros, p.mass, start.time}, start.h, p.v, start.h};
  }
};

}  // namespace

void register_implicit_euler(IntegratorRegistry& registry) {
  registry.add("implicit_euler", {},
               [](const MethodOptions&, ForceList forces, std::size_t particles,
                  const ImplicitConfig& solve) {
                 return std::make_unique<ImplicitEuler>(std::move(forces), particles, solve);
               });
}

}  // namespace selvedge
