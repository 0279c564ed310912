// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/contact_point.h>

#include <span>

namespace selvedge {

struct ImpulseConfig {
  /// Gap wanted at the end of the step, as a share of the rest gap: far enough for the next step's
  /// proximities to take over, near enough not to be seen.
  double end_gap = 0.1;
  /// A gap grows by at most this share of the rest gap in a step.
  double recovery = 0.2;
  /// Gauss-Seidel sweeps over the contacts; more sweeps spread an impulse through a stack.
  int sweeps = 4;
};

/// Inelastic impulses with Coulomb friction [Bridson2002, sections 7.1 to 7.3; survey eq. 52-55
/// mended], written on displacements: v = (x_t1 - x_t0)/h, so that a collision anywhere in the step
/// is answered by its end. Each contact gets I = m_eff·Δv_n·n spread by its weights, where Δv_n is
/// what its end gap lacks, and a tangential impulse of at most μ·I against the slip. The sum of the
/// impulses of a contact is zero: linear momentum of free particles is kept. Order matters and is
/// the caller's: earliest time of impact first.
void apply_impulses(const ContactMotion& motion, std::span<const ContactPoint> contacts,
                    const ImpulseConfig& config, std::span<Vec3> x_t1);

}  // namespace selvedge
