// SPDX-License-Identifier: MIT
//
// The classical Runge-Kutta method of fourth order (Kutta 1901) on y = (x, v), k = (v, a).
// Survey eq. 16-20 print the derivative of the velocity as a function V(t, P), omit 1/m and call
// the average of the stages the acceleration at t+h; corrected. Guarantee: fourth order; stable up
// to hω = 2√2 without damping (the often quoted 2.785 is the limit on the negative real axis, for
// pure damping).
#include <selvedge/core/solver/detail/runge_kutta.h>

namespace selvedge {

std::unique_ptr<Integrator> make_runge_kutta_4(std::vector<std::unique_ptr<Force>> forces,
                                               std::size_t particles) {
  detail::Tableau kutta{4, {}, {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0}, {0.0, 0.5, 0.5, 1.0}};
  kutta.a[1][0] = 0.5;
  kutta.a[2][1] = 0.5;
  kutta.a[3][2] = 1.0;
  return std::make_unique<detail::RungeKutta>(
      std::move(forces), particles, kutta,
      IntegratorTraits{.promise = "fourth order; stable below h omega = 2.83, which is checked",
                       .source = "Kutta 1901; survey eq. 16-20 corrected",
                       .order = 4});
}

void register_runge_kutta_4(IntegratorRegistry& registry) {
  registry.add(
      "runge_kutta_4", {},
      [](const MethodOptions&, std::vector<std::unique_ptr<Force>> forces, std::size_t particles,
         const ImplicitConfig&) { return make_runge_kutta_4(std::move(forces), particles); });
}

}  // namespace selvedge
