// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/integrator.h>
#include <selvedge/response/contact_point.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// What a scene can set of the responses. Each names the fields that it heeds; `check` refuses the
/// rest where it would be ignored in silence.
struct ResponseConfig {
  /// `penalty`: N/m per contact. More leaves less penetration, v sqrt(m/K) of an impact at v, and
  /// asks for shorter explicit steps, 2 sqrt(m/K).
  double stiffness = 1000.0;
  /// `penalty`: N·s/m per contact, against the approach. More leaves less rebound.
  double damping = 0.1;
  /// `impulse`, `reflection`, `position_velocity`: normal speed after an impact over that before
  /// it, in [0, 1].
  double restitution = 0.0;
  /// `reflection`, `position_velocity`: share of the tangential relative velocity that a contact
  /// keeps in a step, in [0, 1]; 1 is frictionless. It depends on the step and is not Coulomb's.
  double retention = 0.9;
  /// `penalty`: slip below which friction is a viscosity, m/s. Less sticks better and asks for
  /// shorter explicit steps.
  double slip_speed = 1e-4;
  /// `inverse_dynamics`: the whole relative velocity is taken, as printed, not its normal part.
  bool sticking = false;
};

/// Throws std::invalid_argument with the number that is out of its range.
void validate(const ResponseConfig& config);

/// What a response knows of one step. Views: they must stay alive until the next begin.
struct ResponseStep {
  ContactMotion motion;
  std::span<const double> mass;             ///< kg, of the particles
  std::span<const Vec3> body_displacement;  ///< x_t1 - x_t0 of the body vertices, m
  std::span<const Vec3> v;                  ///< of the particles at the start, m/s
  std::span<const Vec3> v_predicted;        ///< a guess of those at the end, m/s
  bool implicit = true;  ///< a solve heeds `terms`; otherwise `correct` has to do everything
};

/// What one contact gave in a step: weight·impulse to each of its vertices, whose weights sum to 0.
struct ContactImpulse {
  std::array<std::int32_t, 4> vertex;  ///< in the index space of ContactPoint
  std::array<double, 4> weight;
  Vec3 impulse;                ///< N·s
  double work_normal = 0.0;    ///< J, in the frame of the second primitive; negative: taken
  double work_friction = 0.0;  ///< J
};

/// What a response or a fail-safe says of itself.
struct ResponseTraits {
  std::string promise;           ///< what holds whatever the scene is
  std::string source;            ///< author, title, year
  bool keeps_momentum = false;   ///< linear momentum of free particles to rounding, and says to
                                 ///< whom it went (`impulses`)
  bool passive = false;          ///< never gives energy, beyond rounding
  bool has_restitution = false;  ///< heeds ResponseConfig::restitution
  bool stores_energy = false;    ///< its contacts are springs, which give back what they took
};

/// Answers contacts. A response may act as a force inside the solve (`terms`, `update`), on the end
/// of the step after it (`correct`), on the velocities with which the cloth goes on (`finish`), or
/// on several of them; what it does not do, it inherits. Body vertices and held particles are never
/// moved. Calls of a step: begin, then add, then terms, solve and update as often as `update` asks
/// or collisions found on the way are added, then correct, and finish once the step is accepted.
class Response {
 public:
  virtual ~Response() = default;

  virtual void begin(const ResponseStep& step) = 0;
  /// Contacts of the step: pairs that are near at its start, and later those that collide on the
  /// way.
  virtual void add(std::span<const ContactPoint> contacts) = 0;
  /// What enters the implicit solve.
  virtual std::span<const ImplicitTerm> terms() { return {}; }
  /// Takes the solved velocities, m/s, and may pull them back towards those of the solve before;
  /// true if another solve is due because the forces that follow from them differ.
  virtual bool update(std::span<Vec3> v) {
    static_cast<void>(v);
    return false;
  }
  /// Changes where the particles end, m. May be called again from the same ends, once more contacts
  /// have been added.
  virtual void correct(std::span<Vec3> x_t1) { static_cast<void>(x_t1); }
  /// Changes the velocities of an accepted step, m/s; they come as displacement over time.
  virtual void finish(std::span<Vec3> v) const { static_cast<void>(v); }

  /// Appends what the contacts gave in the last solve, whose velocities `v` are, or in the last
  /// correct. Without the changes of finish.
  virtual void impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const {
    static_cast<void>(v);
    static_cast<void>(out);
  }
  /// Longest explicit step, s, that bears the contacts that have been added.
  virtual double stable_step() const;
  /// Longest explicit step, s, that bears a single contact of a particle of that inverse mass.
  virtual double stable_step(double inv_mass) const;
  virtual ResponseTraits traits() const = 0;
};

/// Names and factories of the responses.
using ResponseRegistry =
    std::map<std::string, std::function<std::unique_ptr<Response>(const ResponseConfig&)>>;
ResponseRegistry responses();

// Members; each file names its paper. All of them but `contact_force` (contact_force.h), which
// stands in the registry too.
std::unique_ptr<Response> make_penalty(const ResponseConfig& config = {});
std::unique_ptr<Response> make_inverse_dynamics(const ResponseConfig& config = {});
std::unique_ptr<Response> make_reflection(const ResponseConfig& config = {});
std::unique_ptr<Response> make_position_correction(const ResponseConfig& config = {});
std::unique_ptr<Response> make_position_velocity(const ResponseConfig& config = {});
std::unique_ptr<Response> make_impulse(const ResponseConfig& config = {});

}  // namespace selvedge
