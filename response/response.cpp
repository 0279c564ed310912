// SPDX-License-Identifier: MIT
#include <selvedge/response/response.h>

#include <limits>
#include <stdexcept>

namespace selvedge {
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
