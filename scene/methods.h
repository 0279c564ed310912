// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/solver/integrator.h>
#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/narrowphase/narrow_phase.h>
#include <selvedge/response/fail_safe.h>
#include <selvedge/response/response.h>

#include <array>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace selvedge {

/// The methods that a scene may name. A program that links adapters registers them here.
struct Methods {
  BroadPhaseRegistry broad_phases = selvedge::broad_phases();
  NarrowPhaseRegistry narrow_phases = selvedge::narrow_phases();
  ResponseRegistry responses = selvedge::responses();
  FailSafeRegistry fail_safes = selvedge::fail_safes();
  IntegratorRegistry integrators = selvedge::integrators();
  StrainLimiterRegistry strain_limiters = selvedge::strain_limiters();
  ClothPatternRegistry patterns = cloth_patterns();
  /// The laws of the internal forces. All of them act, on the elements that the cloth of a scene
  /// has; the key kForceLawKey sets their options.
  ForceLawRegistry force_laws = selvedge::force_laws();
};

/// Everything that this build has: the library's own methods and those of the adapters that it was
/// built with. Link selvedge::all_methods.
Methods methods_of_this_build();

/// Keys of scene files that name a method, one for each family; a star as in SceneKey.
inline constexpr std::array<const char*, 7> kMethodKeys{
    "contact.broad_phase", "contact.narrow_phase",  "contact.response",  "contact.fail_safe",
    "solver.integrator",   "solver.strain_limiter", "geometry.*.pattern"};

/// Key of scene files that maps the names of force laws to their options.
inline constexpr const char* kForceLawKey = "force_laws";

/// Calls visit(key, registry) for each family, in the order of kMethodKeys.
template <class Visit>
void for_each_family(const Methods& methods, Visit visit) {
  visit(kMethodKeys[0], methods.broad_phases);
  visit(kMethodKeys[1], methods.narrow_phases);
  visit(kMethodKeys[2], methods.responses);
  visit(kMethodKeys[3], methods.fail_safes);
  visit(kMethodKeys[4], methods.integrators);
  visit(kMethodKeys[5], methods.strain_limiters);
  visit(kMethodKeys[6], methods.patterns);
}

/// One method as lists show it.
struct ListedMethod {
  std::string family;  ///< "broad_phase"
  /// Key of scene files that selects the method: one of kMethodKeys, or a key of its own. For a
  /// force law without a key of its own it is kForceLawKey, which sets options only.
  std::string key;
  std::string name, promise, source;
  std::string library{};  ///< optional library that the method comes from; empty: selvedge itself
  bool available = true;  ///< false: this build lacks the library
  bool keyed = false;     ///< `key` is a key of its own, not that of the family
  std::vector<MethodOption> options{};
};
/// The methods of one family by name; then those with keys of their own, then the absent ones.
template <class Product, class Traits, class... Args>
std::vector<ListedMethod> list_family(const std::string& family, const std::string& key,
                                      const Registry<Product, Traits, Args...>& registry) {
  std::vector<ListedMethod> list;
  for (const auto& [name, entry] : registry)
    list.push_back({.family = family,
                    .key = key,
                    .name = name,
                    .promise = entry.promise(),
                    .source = entry.source(),
                    .library = entry.library(),
                    .options = entry.options()});
  for (const auto& [name, method] : registry.keyed())
    list.push_back({.family = family,
                    .key = method.key,
                    .name = name,
                    .promise = promise_of(method.traits),
                    .source = std::string(method.traits.source),
                    .keyed = true});
  for (const auto& [name, library] : registry.absent())
    list.push_back({.family = family,
                    .key = key,
                    .name = name,
                    .promise = "needs " + library,
                    .source = "",
                    .library = library,
                    .available = false});
  return list;
}
/// All methods, family by family.
std::vector<ListedMethod> list_methods(const Methods& methods);

/// The method of that name with these options and arguments. Throws std::invalid_argument that
/// begins with `key`, the place where the scene names it, for an unknown name or option.
template <class Product, class Traits, class... Args>
Product make_method(const Registry<Product, Traits, Args...>& registry, const std::string& name,
                    const char* key, const MethodOptions& options,
                    std::type_identity_t<Args>... args) {
  if (const std::string fault = registry.fault(name); !fault.empty())
    throw std::invalid_argument(std::string(key) + ": " + fault);
  return registry.at(name)(options, std::forward<Args>(args)...);
}

}  // namespace selvedge
