// SPDX-License-Identifier: MIT
//
// Midpoint rule (Runge-Kutta of second order, Runge 1895):
//   x½ = x + ½h v,  v½ = v + ½h a(x, v, t),  v⁺ = v + h a(x½, v½, t + ½h),  x⁺ = x + h v½.
// Survey eq. 15 prints V(t) + h/2 without the a, moves positions with V(t+h) instead of v½ and
// evaluates the force at the start; corrected. Guarantee: second order. Without damping it grows by
// (hω)⁴/8 per step for any step length.
#include <selvedge/core/solver/detail/runge_kutta.h>

namespace selvedge {

void register_midpoint(IntegratorRegistry& registry) {
  detail::Tableau midpoint{2, {}, {0.0, 1.0}, {0.0, 0.5}};
  midpoint.a[1][0] = 0.5;
  detail::add_runge_kutta(registry, "midpoint", midpoint,
                          {.promise = "second order; grows slowly in every step unless damped",
                           .source = "Runge 1895; survey eq. 15 corrected",
                           .order = 2});
}

}  // namespace selvedge
