// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/core/base/registry.h>
#include <selvedge/core/base/types.h>
#include <selvedge/core/solver/integrator.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge {

/// A contact in the index space of the response: cloth particles first, [0, particles), then body
/// vertices. Σ weight·x is the vector from the point on the second primitive to the point on the
/// first; its product with `normal` is the gap. The weights sum to 0.
struct ContactPoint {
  std::array<std::int32_t, 4> vertex;
  std::array<double, 4> weight;
  Vec3 normal;
  double gap = 0.0;       ///< m, at t = 0, signed distance along `normal`
  double rest_gap = 0.0;  ///< m, distance that the contact keeps at rest
  double friction = 0.0;  ///< Coulomb coefficient
  /// point_triangle and triangle_point: vertex 0 is the point; edge_edge: 0 and 1 are one edge.
  ContactKind kind = ContactKind::point_triangle;
};

/// The motion that a response works on. Body vertices follow the particles in the arrays and have
/// inv_mass 0.
struct ContactMotion {
  std::span<const Vec3> x_t0;
  std::span<const double> inv_mass;  ///< 1/kg, 0 for held particles and body vertices
  std::size_t particles = 0;         ///< number of cloth particles
  double h = 0.0;                    ///< s, length of the step
  /// Not null: some of these particles follow others. A fail-safe keeps to that at the ends.
  const Followers* followers = nullptr;
};

/// Σ weight·x over the four vertices.
inline Vec3 relative(const ContactPoint& c, std::span<const Vec3> x) {
  return c.weight[0] * x[c.vertex[0]] + c.weight[1] * x[c.vertex[1]] +
         c.weight[2] * x[c.vertex[2]] + c.weight[3] * x[c.vertex[3]];
}

/// Number of vertices that belong to the first primitive.
inline int first_count(const ContactPoint& c) { return c.kind == ContactKind::edge_edge ? 2 : 1; }

/// Compliance of a contact, 1/kg: Σ weight²/mass. An impulse along the contact changes its relative
/// velocity by this factor.
inline double compliance(const ContactPoint& c, std::span<const double> inv_mass) {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) sum += c.weight[k] * c.weight[k] * inv_mass[c.vertex[k]];
  return sum;
}

/// Input of a response for one step. The views must stay alive until the next `begin`.
struct ResponseStep {
  ContactMotion motion;                     ///< positions, inverse masses and length of the step
  std::span<const double> mass;             ///< kg, of the particles
  std::span<const Vec3> body_displacement;  ///< m, x_t1 - x_t0 of the body vertices
  std::span<const Vec3> v;                  ///< m/s, of the particles at the start of the step
  std::span<const Vec3> v_predicted;  ///< m/s, estimate of the particles' velocities at the end
  bool implicit = true;  ///< true: an implicit solve uses `terms`; false: `correct` must do all the
                         ///< work
  /// N·s, impulses of all other forces if the particles keep the velocities `v`, which contacts
  /// would have to balance; empty: unknown.
  std::span<const Vec3> unbalanced{};
  /// s, at most motion.h: length of the step by which contacts set their stiffness. 0: motion.h. A
  /// step that joins two nominal ones has that of one, so that cloth at rest yields the same.
  double stiffness_h = 0.0;
  /// The cloth comes to rest: forces of contacts should be as exact as they can.
  bool settles = false;
};

/// The impulse of one contact in a step. Vertex k receives weight[k]·impulse; the weights sum to 0.
struct ContactImpulse {
  std::array<std::int32_t, 4> vertex;  ///< indices as in ContactPoint
  std::array<double, 4> weight;
  Vec3 impulse;                ///< N·s
  double work_normal = 0.0;    ///< J, in the frame of the second primitive; negative: dissipated
  double work_friction = 0.0;  ///< J
};

/// Properties of a response or a fail-safe.
struct ResponseTraits {
  std::string promise;          ///< property that holds for every scene
  std::string source;           ///< author, title, year
  bool keeps_momentum = false;  ///< keeps the linear momentum of free particles to rounding, and
                                ///< reports in `impulses` where it went
  bool passive = false;         ///< never adds energy, beyond rounding
  bool stores_energy = false;   ///< its contacts are springs, which return the energy they absorbed
};

/// Responds to contacts. A response may act as a force inside the solve (`terms`, `update`), on the
/// end positions after the solve (`correct`), on the velocities with which the cloth continues
/// (`finish`), or on several of these; the defaults do nothing. A response never moves body
/// vertices or held particles.
///
/// Order of the calls in a step: `begin` and `add`; then `terms`, solve and `update`, repeated
/// while `update` returns true or new collisions are added; then `correct`; then `finish` once the
/// step is accepted.
class Response {
 public:
  virtual ~Response() = default;

  /// Starts a step and discards the contacts of the previous one.
  virtual void begin(const ResponseStep& step) = 0;
  /// Adds contacts of the step: first the pairs that are near at its start, later the pairs that
  /// collide during it.
  virtual void add(std::span<const ContactPoint> contacts) = 0;
  /// Terms that the response adds to the implicit solve.
  virtual std::span<const ImplicitTerm> terms() { return {}; }
  /// Takes the solved velocities, m/s, and may pull them back towards those of the previous solve.
  /// Returns true if the contact forces changed and another solve is needed.
  virtual bool update(std::span<Vec3> v) {
    static_cast<void>(v);
    return false;
  }
  /// Changes the end positions of the particles, m. May be called again with the same initial end
  /// positions after more contacts have been added.
  virtual void correct(std::span<Vec3> x_t1) { static_cast<void>(x_t1); }
  /// Changes the velocities of an accepted step, m/s. On entry they are displacement over time.
  virtual void finish(std::span<Vec3> v) const { static_cast<void>(v); }

  /// Appends the impulses by which `finish` would change the velocities `v`, m/s, as far as it
  /// knows them by contact.
  virtual void finish_impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const {
    static_cast<void>(v);
    static_cast<void>(out);
  }

  /// Tells the response that the step was accepted and ended at `x_t1`, m, joint. A response with a
  /// memory changes it here alone, so that a rejected step leaves none.
  virtual void accept(std::span<const Vec3> x_t1) { static_cast<void>(x_t1); }
  /// Appends the memory; a response without a memory appends nothing.
  virtual void save_memory(std::vector<double>& memory) const { static_cast<void>(memory); }
  /// Replaces the memory; `vertices`: of the cloth and the bodies. Throws std::invalid_argument if
  /// it does not fit.
  virtual void restore_memory(std::span<const double> memory, std::size_t vertices);

  /// Appends the impulses of the contacts in the last solve, which gave the velocities `v` (m/s),
  /// or in the last `correct`. Changes made by `finish` are not included.
  virtual void impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const {
    static_cast<void>(v);
    static_cast<void>(out);
  }
  /// Longest stable explicit step, s, with the contacts added so far.
  virtual double stable_step() const;
  /// Longest stable explicit step, s, with a single contact of a particle of inverse mass
  /// `inv_mass`, 1/kg.
  virtual double stable_step(double inv_mass) const;
  /// The response that answers the contacts of this step in its place; empty: it does so itself.
  virtual std::string_view substitute() const { return {}; }
  /// Properties of the response, the same at all times.
  virtual ResponseTraits traits() const = 0;
};

/// The responses by name.
using ResponseRegistry = Registry<std::unique_ptr<Response>, ResponseTraits>;
/// All responses.
ResponseRegistry responses();

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
