// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/integrator.h>
#include <selvedge/response/contact_point.h>

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>

namespace selvedge {

/// What a response knows of one step. Views: they must stay alive until the next begin.
struct ResponseStep {
  ContactMotion motion;
  std::span<const double> mass;             ///< kg, of the particles
  std::span<const Vec3> body_displacement;  ///< x_t1 - x_t0 of the body vertices, m
  std::span<const Vec3> v;                  ///< of the particles at the start, m/s
  std::span<const Vec3> v_predicted;        ///< a guess of those at the end, m/s
};

/// What a response or a fail-safe says of itself.
struct ResponseTraits {
  std::string promise;  ///< what holds whatever the scene is
  std::string source;   ///< author, title, year
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
  /// Takes the solved velocities, m/s; true if another solve is due because the forces that follow
  /// from them differ.
  virtual bool update(std::span<const Vec3> v) {
    static_cast<void>(v);
    return false;
  }
  /// Changes where the particles end, m.
  virtual void correct(std::span<Vec3> x_t1) { static_cast<void>(x_t1); }
  /// Changes the velocities of an accepted step, m/s; they come as displacement over time.
  virtual void finish(std::span<Vec3> v) const { static_cast<void>(v); }
  virtual ResponseTraits traits() const = 0;
};

/// Names and factories of the responses.
using ResponseRegistry = std::map<std::string, std::function<std::unique_ptr<Response>()>>;
ResponseRegistry responses();

}  // namespace selvedge
