// SPDX-License-Identifier: MIT
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
          "a stiffness in N/m must be finite and not negative");
  require(not_negative(config.damping), "contact.damping", config.damping,
          "a damping in N·s/m must be finite and not negative");
  require(share(config.restitution), "contact.restitution", config.restitution,
          "the ratio of normal speeds after and before an impact must be from 0 to 1");
  require(share(config.retention), "contact.retention", config.retention,
          "the share of the tangential velocity that a contact keeps must be from 0 to 1");
  require(std::isfinite(config.slip_speed) && config.slip_speed > 0.0, "contact.slip_speed",
          config.slip_speed, "a speed in m/s must be finite and above 0");
}

double Response::stable_step() const { return std::numeric_limits<double>::infinity(); }

double Response::stable_step(double inv_mass) const {
  static_cast<void>(inv_mass);
  return std::numeric_limits<double>::infinity();
}

void Response::restore_memory(std::span<const double> memory, std::size_t vertices) {
  static_cast<void>(vertices);
  if (!memory.empty())
    throw std::invalid_argument("the memory of the contacts belongs to another response");
}

// Each response registers itself in its own file. A new one adds its name to both lists.
void register_contact_force(ResponseRegistry& registry);
void register_impulse(ResponseRegistry& registry);
void register_inverse_dynamics(ResponseRegistry& registry);
void register_penalty(ResponseRegistry& registry);
void register_position_correction(ResponseRegistry& registry);
void register_position_velocity(ResponseRegistry& registry);
void register_reflection(ResponseRegistry& registry);

ResponseRegistry responses() {
  ResponseRegistry registry;
  for (const auto add :
       {register_contact_force, register_impulse, register_inverse_dynamics, register_penalty,
        register_position_correction, register_position_velocity, register_reflection})
    add(registry);
  return registry;
}

}  // namespace selvedge
