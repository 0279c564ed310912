// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/integrator.h>
#include <selvedge/core/strain_limiter.h>
#include <selvedge/narrowphase/narrow_phase.h>
#include <selvedge/response/fail_safe.h>
#include <selvedge/response/response.h>

#include <stdexcept>
#include <string>

namespace selvedge {

/// The methods that a scene may name. A program that links adapters registers them here.
struct Methods {
  BroadPhaseRegistry broad_phases = selvedge::broad_phases();
  NarrowPhaseRegistry narrow_phases = selvedge::narrow_phases();
  ResponseRegistry responses = selvedge::responses();
  FailSafeRegistry fail_safes = selvedge::fail_safes();
  IntegratorRegistry integrators = selvedge::integrators();
  StrainLimiterRegistry strain_limiters = selvedge::strain_limiters();
};

/// The method of that name; throws std::invalid_argument with the names there are. `key` is where
/// the scene names it.
template <class Registry, class... Config>
auto make_method(const Registry& registry, const std::string& name, const char* key,
                 const Config&... config) {
  const auto found = registry.find(name);
  if (found != registry.end()) return found->second(config...);
  std::string known;
  for (const auto& entry : registry) known += (known.empty() ? "" : ", ") + entry.first;
  throw std::invalid_argument(std::string(key) + ": there is no \"" + name +
                              "\" in this build; it has " + known);
}

}  // namespace selvedge
