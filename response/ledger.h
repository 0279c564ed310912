// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <map>
#include <span>
#include <string>

namespace selvedge {

/// What one stage (the response, the fail-safe) gave and took in a step, or in all steps so far.
/// Anchors are what it must not move: body vertices and held particles.
struct Ledger {
  int steps = 0;                       ///< in which it did anything
  Vec3 to_particles = Vec3::Zero();    ///< N·s, to the free particles
  Vec3 to_anchors = Vec3::Zero();      ///< N·s
  Vec3 turn_particles = Vec3::Zero();  ///< N·m·s about the origin, by the positions at t = 0
  Vec3 turn_anchors = Vec3::Zero();    ///< N·m·s
  double momentum_error = 0.0;         ///< worst step: |given + handed| over the momenta moved
  double angular_error = 0.0;          ///< the same of angular momentum; friction and impulses
                                       ///< across a gap have a lever
  double energy_normal = 0.0;          ///< J; negative: taken
  double energy_friction = 0.0;        ///< J
  double energy_gained = 0.0;          ///< J, sum over the steps that gave more than they took
  double energy_kinetic = 0.0;         ///< J, change of the free particles' kinetic energy

  /// Adds a step.
  void add(const Ledger& step);
  /// By name and unit; names that begin with max_ are maxima, the others sums.
  std::map<std::string, double> figures() const;
};

/// What a stage did in one step, from what is known: the motion, what the contacts say they gave
/// (empty: they do not say), and the velocities of the particles before and after.
struct LedgerStep {
  ContactMotion motion;
  std::span<const double> mass;
  std::span<const ContactImpulse> impulses;
  std::span<const Vec3> v_before, v_after;
  /// The impulses acted inside the solve: `v_before` has them already, and v_after - v_before is
  /// what the stage changed besides.
  bool solved = false;
};

/// Momentum that nobody accounts for is what the anchors took, if there are any; else it is an
/// error. Energy of contacts that do not say is that of the free particles, as if anchors stood
/// still.
Ledger measure(const LedgerStep& step);

}  // namespace selvedge
