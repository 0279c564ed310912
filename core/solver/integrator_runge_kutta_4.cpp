// SPDX-License-Identifier: MIT
//
// The classical Runge-Kutta method of fourth order (Kutta 1901) on y = (x, v), k = (v, a).
// Survey eq. 16-20 print the derivative of the velocity as a function V(t, P), omit 1/m and call
// the average of the stages the acceleration at t+h; corrected. Guarantee: fourth order; stable up
// to hω = 2√2 without damping (the often quoted 2.785 is the limit on the negative real axis, for
// pure damping).
#include <selvedge/core/solver/detail/runge_kutta.h>

namespace selvedge {

void register_runge_kutta_4(IntegratorRegistry& registry) {
  detail::Tableau kutta{4, {}, {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0}, {0.0, 0.5, 0.5, 1.0}};
  kutta.a[1][0] = 0.5;
  kutta.a[2][1] = 0.5;
  kutta.a[3][2] = 1.0;
  detail::add_runge_kutta(registry, "runge_kutta_4", kutta,
                          {.promise = "fourth order; stable below h omega = 2.83, which is checked",
                           .source = "Kutta 1901; survey eq. 16-20 corrected",
                           .order = 4});
}

}  // namespace selvedge
