// SPDX-License-Identifier: MIT
//
// Forward (explicit) Euler: x⁺ = x + h v, v⁺ = v + h a(x, v). The survey's eq. 14 moves positions
// with V(t+h), which is symplectic Euler, a different method with a different stability limit
// (symplectic_euler). Table VII and Fig. 27 refer to forward Euler. Guarantee: first order. Without
// damping each step amplifies by sqrt(1 + (hω)²) for any step length; with damping ratio ζ < 1 it
// is stable up to hω = 2ζ.
#include <selvedge/core/solver/detail/runge_kutta.h>

namespace selvedge {

void register_forward_euler(IntegratorRegistry& registry) {
  const detail::Tableau euler{1, {}, {1.0}, {0.0}};
  detail::add_runge_kutta(
      registry, "forward_euler", euler,
      {.promise = "grows in every step unless damped; stable below h omega = 2 zeta",
       .source = "Euler 1768; survey eq. 14 as its text means it"});
}

}  // namespace selvedge
