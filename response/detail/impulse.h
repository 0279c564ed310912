// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <span>

namespace selvedge::detail {

/// Options of apply_impulses.
struct ImpulseConfig {
  /// Target gap at the end of the step, as a share of the rest gap: large enough for the
  /// proximities of the next step to take over, too small to be visible.
  double end_gap = 0.1;
  /// A gap grows by at most this share of the rest gap per step.
  double recovery = 0.2;
  /// Gauss-Seidel sweeps over the contacts; more sweeps carry an impulse through a deeper stack.
  int sweeps = 4;
};

/// Applies inelastic impulses with Coulomb friction [Bridson2002, sections 7.1 to 7.3; survey eq.
/// 52-55 corrected] to the end positions `x_t1`, metres. Works on displacements, v = (x_t1 -
/// x_t0)/h, so that a collision at any time in the step is resolved by its end. Each contact gets
/// the impulse I = m_eff·Δv_n·n, spread by its weights, where Δv_n removes the violation of its
/// target gap, and a tangential impulse of at most μ·I against the slip. The impulses of a contact
/// sum to zero, so the linear momentum of free particles is kept. The result depends on the order
/// of `contacts`: pass the earliest time of impact first.
void apply_impulses(const ContactMotion& motion, std::span<const ContactPoint> contacts,
                    const ImpulseConfig& config, std::span<Vec3> x_t1);

}  // namespace selvedge::detail
