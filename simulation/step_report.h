// SPDX-License-Identifier: MIT
//
// What a run, its replay and its pictures read about the last step of a simulation.
#pragma once

#include <selvedge/response/response.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace selvedge {

/// The last rejected attempt of a step.
struct RejectedAttempt {
  double h = 0.0;                   ///< s, its length; 0: no attempt was rejected
  std::string cause;                ///< why it was rejected
  std::vector<ContactPoint> pairs;  ///< that collide on the paths x_t0 -> x_t1, earliest first
  std::int32_t not_finite = -1;  ///< first particle without a finite position; -1: all are finite
  std::vector<Vec3> x_t0, x_t1;  ///< m, cloth particles, then body vertices
};

/// The attempts of the last step.
struct StepReport {
  std::vector<double> lengths;  ///< s, of all attempts, the accepted one included
  RejectedAttempt rejected;     ///< the last rejected one, of any step so far
  bool accepted = false;        ///< the last attempt was accepted, and the state follows from it
  bool given_up = false;        ///< no attempt was accepted
};

/// A contact of an accepted step.
struct StepContact {
  ContactPoint point;  ///< pair, weights, normal, rest gap; `point.gap`: at the start of the step
  double gap = 0.0;    ///< m, at the end of the step, along the normal
  /// N·s, on the first primitive; the second receives the opposite. Of the response alone: zero for
  /// a response that moves particles without impulses, and without the fail-safe's share.
  Vec3 impulse = Vec3::Zero();
};

/// A force and its torque about the origin.
struct Wrench {
  Vec3 force = Vec3::Zero();   ///< N
  Vec3 torque = Vec3::Zero();  ///< N·m

  Vec3 torque_about(const Vec3& point) const { return torque - point.cross(force); }
  /// Adds a force `f` that acts at `x` (m).
  void add(const Vec3& x, const Vec3& f) {
    force += f;
    torque += x.cross(f);
  }
  Wrench& operator+=(const Wrench& other);
  Wrench operator*(double factor) const { return {factor * force, factor * torque}; }
};

/// The cloth that a body carries, as point masses where it touches: the mass of each piece, shared
/// by the sizes of its impulses on bodies. A program that moves the body by the forces of the step
/// before solves (m + m_e) a' = f + m_e a instead of m a' = f, with its own m and the accelerations
/// a of the last and a' of the next step. It would diverge where the cloth is heavier than the
/// body: P. Causin, J. F. Gerbeau, F. Nobile, "Added-mass effect in the design of partitioned
/// algorithms for fluid-structure problems", 2005.
struct EffectiveMass {
  double mass = 0.0;            ///< kg
  Vec3 centre = Vec3::Zero();   ///< m
  Mat3 inertia = Mat3::Zero();  ///< kg·m², about the centre

  void add(const Vec3& x, double m);  ///< a point mass
};

/// What the cloth exerted during a step, or on the mean of several, and what acted on it. The
/// forces are impulses over time and act at the positions of the start of the step. They sum up:
/// change.force = Σ others.force - Σ bodies.force - Σ held_force, and the same for torques.
struct StepWrenches {
  double h = 0.0;                        ///< s, length of the step or of all of them
  std::vector<Wrench> bodies;            ///< on each body, by contacts, friction and pinched cloth
  std::vector<EffectiveMass> body_mass;  ///< of each body; in a mean that of the last step
  /// On each rigid body among the pieces (BuiltScene::solids), by contacts and friction. They are
  /// part of the sums: to them the bodies are cloth.
  std::vector<Wrench> solids;
  std::vector<Wrench> handles;  ///< on what holds the particles of each handle of the scene
  /// The particles that handles or the program held, ascending; those that bodies pinch count for
  /// the bodies, half for each.
  std::vector<std::int32_t> held;
  std::vector<Vec3> held_force;  ///< N, of the cloth on what held each of them
  /// On the cloth, by what gave it: "loads" (weight, air, forces of a program), "internal" (only
  /// the torque of forces taken at other positions, or the error of a method that evaluates them
  /// several times), "solver" (what the linear solve left), "response" (moves without an impulse),
  /// "fail_safe", "strain_limit", "tempering", "followers", "untangling", "water", "sleep", and
  /// "lever_arms": all that angular momentum lacks, which shrinks with the step. Entries that are
  /// zero are left out.
  std::map<std::string, Wrench> others;
  Wrench change;              ///< of the momentum and the angular momentum of the cloth, per s
  double force_error = 0.0;   ///< of that sum, by the sizes of its parts and of the momenta
  double torque_error = 0.0;  ///< the same of the torques
};

/// Whether a step that was accepted after `halvings` of at most `max_halvings` is at most twice as
/// long as the smallest one allowed. Always false if fewer than 4 halvings are allowed, because the
/// smallest step is not yet small then.
bool is_near_smallest(int halvings, int max_halvings);

}  // namespace selvedge
