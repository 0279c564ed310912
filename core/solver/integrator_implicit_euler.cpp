// SPDX-License-Identifier: MIT
//
// D. Baraff, A. Witkin, "Large steps in cloth simulation", SIGGRAPH 1998, solved for v⁺ instead of
// Δv: forces are linear in v, so F(x, v⁺) ≈ F(x, 0) + h ∂F/∂x v⁺ + ∂F/∂v v⁺ is exact in the
// damping. Survey eq. 38 omits x and v and prints H for M⁻¹; corrected. Its text says that implicit
// methods need small steps and are more accurate than explicit Euler; in fact they allow large
// steps, and both are of first order. Guarantee: no growth for any step length, as far as the
// dropped indefinite part of ∂F/∂x allows (compressed springs buckle, which is physical growth).
#include <selvedge/core/solver/detail/implicit_system.h>
#include <selvedge/core/solver/integrator.h>

namespace selvedge {
namespace {

class LinearlyImplicit final : public Integrator {
 public:
  LinearlyImplicit(std::vector<std::unique_ptr<Force>> forces, std::size_t particles,
                   const ImplicitConfig& config)
      : Integrator(std::move(forces), particles), system_(forces_.members(), particles, config) {}

  IntegratorTraits traits() const override {
    return {.promise = "stable at any step of the scene; loses energy, first order",
            .source = "Baraff, Witkin, Large steps in cloth simulation, 1998",
            .any_step = true,
            .is_implicit = true,
            .ends_with_mean = true};
  }

  void begin(const StepStart& start, StepEnd) override {
    const Particles& p = start.particles;
    system_.hold(p);
    system_.assemble({{p.x, system_.zeros(), p.mass, start.time}, start.h, p.v, start.h});
  }
  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) override {
    return system_.solve(terms, end.mean, looser * system_.config().tolerance);
  }
  std::span<const Vec3> unbalanced(std::span<const Vec3> mean) override {
    return system_.unbalanced(mean);
  }

 private:
  detail::ImplicitSystem system_;
};

}  // namespace

std::unique_ptr<Integrator> make_implicit_euler(std::vector<std::unique_ptr<Force>> forces,
                                                std::size_t particles,
                                                const IntegratorConfig& config) {
  return std::make_unique<LinearlyImplicit>(std::move(forces), particles, config.solve);
}

void register_implicit_euler(IntegratorRegistry& registry) {
  registry.add("implicit_euler", {},
               [](const MethodOptions&, std::vector<std::unique_ptr<Force>> forces,
                  std::size_t particles, const ImplicitConfig& solve) {
                 return make_implicit_euler(std::move(forces), particles, {.solve = solve});
               });
}

}  // namespace selvedge
