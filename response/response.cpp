// SPDX-License-Identifier: MIT
#include <selvedge/response/contact_force.h>
#include <selvedge/response/response.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace selvedge {
namespace {

std::string text(double value) {
  std::string s = std::to_string(value);
  return s;
}

void require(bool good, const char* name, double value, const char* rule) {
  if (!good)
    throw std::invalid_argument(std::string(name) + " is " + text(value) + ", but " + rule);
}

}  // namespace

void validate(const ResponseConfig& config) {
  const auto not_negative = [](double value) { return std::isfinite(value) && value >= 0.0; };
  const auto share = [](double value) { return value >= 0.0 && value <= 1.0; };
  require(not_negative(config.stiffness), "contact.stiffness", config.stiffness,
          "a stiffness is a number of N/m from 0 on");
  require(not_negative(config.damping), "contact.damping", config.damping,
          "a damping is a number of N·s/m from 0 on");
  require(share(config.restitution), "contact.restitution", config.restitution,
          "it is the share of the normal speed that an impact gives back, from 0 to 1");
  require(share(config.retention), "contact.retention", config.retention,
          "it is the share of the tangential velocity that a contact keeps, from 0 to 1");
  require(std::isfinite(config.slip_speed) && config.slip_speed > 0.0, "contact.slip_speed",
          config.slip_speed, "it is a speed in m/s above 0");
}

double Response::stable_step() const { return std::numeric_limits<double>::infinity(); }

double Response::stable_step(double inv_mass) const {
  static_cast<void>(inv_mass);
  return std::numeric_limits<double>::infinity();
}

ResponseRegistry responses() {
  return {
      {"contact_force", [](const ResponseConfig&) { return std::make_unique<ContactForce>(); }},
      {"impulse", make_impulse},
      {"inverse_dynamics", make_inverse_dynamics},
      {"penalty", make_penalty},
      {"position_correction", make_position_correction},
      {"position_velocity", make_position_velocity},
      {"reflection", make_reflection},
  };
}

}  // namespace selvedge
