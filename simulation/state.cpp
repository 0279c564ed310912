// SPDX-License-Identifier: MIT
#include <selvedge/simulation/simulation_state.h>

#include <cstdint>
#include <cstdio>
#include <cstring>

namespace selvedge {

std::string state_hash(const SimulationState& state) {
  std::uint64_t hash = 14695981039346656037ull;  // FNV-1a, 64 bit
  const auto add = [&](double value) {
    unsigned char bytes[sizeof(double)];
    std::memcpy(bytes, &value, sizeof(double));
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 1099511628211ull;
  };
  for (const auto* values : {&state.x, &state.v})
    for (const Vec3& u : *values)
      for (int k = 0; k < 3; ++k) add(u[k]);
  for (const double kg : state.water) add(kg);
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace selvedge
