// SPDX-License-Identifier: MIT
//
// Explicit elastic forces, implicit damping, after R. Bridson, S. Marino, R. Fedkiw, "Simulation of
// clothing with folds and wrinkles", SCA 2003 [Bridson2003]:
//   v½ = v + ½h a(x, v½),  x⁺ = x + h v½,  v⁺ = v½ + ½h a(x⁺, v⁺),
// where a is linear in its velocities. Each half is therefore a linear system, (M + ½h D) v.
// Contacts act on the end of the first half. Guarantee: second order without damping, first order
// in the damping; stable below hω = 2 for any damping, whereas explicit damping would need ever
// shorter steps.
//
// Survey table VII, row 4, calls this "Combine Runge-Kutta with Euler implicit", credits it to
// [Bridson2003] and [HanStyliosWatt2009], and prints no equation. Here the explicit part is the
// central difference of [Bridson2003], of second order, and not a Runge-Kutta method.
#include <selvedge/core/solver/detail/implicit_system.h>
#include <selvedge/core/solver/detail/stability.h>
#include <selvedge/core/solver/integrator.h>

#include <algorithm>

namespace selvedge {
namespace {

class Imex final : public Integrator {
 public:
  Imex(ForceList forces, std::size_t n, const ImplicitConfig& config)
      : Integrator(std::move(forces), n), system_(forces_.members(), n, config), x_(n) {}

  IntegratorTraits traits() const override {
    return {.promise = "stable below h omega = 2, which is checked, whatever the damping",
            .source =
                "Bridson, Marino, Fedkiw, Simulation of clothing with folds and wrinkles, 2003; "
                "survey table VII, row 4: Runge-Kutta with implicit Euler, also Han et al. 2009",
            .order = 2};
  }

  double stable_step(const ModeBound& mode, double wanted) const override {
    return detail::stable_step_of(
        [](double theta, double delta) {
          const double d = 1.0 + 0.5 * delta;
          Eigen::Matrix2d half, move, end;
          half << 1.0, 0.0, -0.5 * theta / d, 1.0 / d;
          move << 1.0, 1.0, 0.0, 1.0;
          return Eigen::Matrix2d(half * move * half);
        },
        mode, wanted);
  }

  void begin(const StepStart& start, StepEnd end) override {
    const Particles& p = start.particles;
    const double h = start.h;
    system_.hold(p);
    half(p.x, p.v, p, start.time, 0.5 * h, end.mean);
    for (std::size_t i = 0; i < p.size(); ++i) x_[i] = p.x[i] + h * end.mean[i];
    std::copy(end.mean.begin(), end.mean.end(), end.v.begin());
    half(x_, end.mean, p, start.time + h, 0.5 * h, end.v);
  }

 private:
  // (M + τ D(x)) v = M momentum + τ F(x, 0)
  void half(std::span<const Vec3> x, std::span<const Vec3> momentum, const Particles& p,
            double time, double tau, std::span<Vec3> v) {
    system_.assemble({{x, system_.zeros(), p.mass, time},
                      tau,
                      momentum,
                      detail::damping_tau(tau),
                      1.0,
                      detail::kDampingGain});
    system_.solve({}, v, system_.config().tolerance);
  }

  detail::ImplicitSystem system_;
  std::vector<Vec3> x_;
};

}  // namespace

void register_imex(IntegratorRegistry& registry) {
  registry.add("imex", {},
               [](const MethodOptions&, ForceList forces, std::size_t particles,
                  const ImplicitConfig& solve) {
                 return std::make_unique<Imex>(std::move(forces), particles, solve);
               });
}

}  // namespace selvedge
