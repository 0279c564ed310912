// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <map>
#include <span>
#include <string>

namespace selvedge {

/// Momentum and energy that one stage (the response, the fail-safe) exchanged in a step, or in all
/// steps so far. Anchors are the vertices that it must not move: body vertices and held particles.
struct Ledger {
  int steps = 0;                       ///< steps in which the stage acted
  Vec3 to_particles = Vec3::Zero();    ///< N·s, given to the free particles
  Vec3 to_anchors = Vec3::Zero();      ///< N·s, given to the anchors
  Vec3 turn_particles = Vec3::Zero();  ///< N·m·s about the origin, with the positions at t = 0
  Vec3 turn_anchors = Vec3::Zero();    ///< N·m·s
  double momentum_error = 0.0;         ///< worst step: |to particles + to anchors|, relative to the
                                       ///< momenta exchanged
  double angular_error = 0.0;    ///< the same for angular momentum; friction and impulses across a
                                 ///< gap act with a lever arm
  double energy_normal = 0.0;    ///< J; negative: dissipated
  double energy_friction = 0.0;  ///< J
  double energy_gained = 0.0;    ///< J, sum over the steps in which energy increased
  double energy_kinetic = 0.0;   ///< J, change of the free particles' kinetic energy

  /// Adds the figures of a step.
  void add(const Ledger& step);
  /// The figures by name and unit. Names that begin with max_ are maxima, the others sums.
  std::map<std::string, double> figures() const;
};

/// Input of `measure`: the motion of one step, the impulses that the stage reports (empty: it
/// reports none), and the velocities of the particles before and after.
struct LedgerStep {
  ContactMotion motion;
  std::span<const double> mass;
  std::span<const ContactImpulse> impulses;
  std::span<const Vec3> v_before, v_after;
  /// The impulses acted inside the solve: `v_before` already contains them, and v_after - v_before
  /// is the additional change that the stage made.
  bool solved = false;
};

/// Computes the exchange of momentum and energy in one step. Unaccounted momentum is attributed to
/// the anchors if there are any; otherwise it is an error. If the stage reports no impulses, its
/// energy is the change of the free particles' energy, as if anchors stood still.
Ledger measure(const LedgerStep& step);

}  // namespace selvedge
