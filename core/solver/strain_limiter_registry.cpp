// SPDX-License-Identifier: MIT
#include <selvedge/core/solver/detail/register_limiter.h>

namespace selvedge {

void detail::register_method(StrainLimiterRegistry& registry, const std::string& name,
                             const MakeLimitMethod& make) {
  const auto product = [make](const MethodOptions& o, std::span<const Spring> springs,
                              std::span<const double> limits, std::size_t particles) {
    const LimitedStrain limited =
        o.flag("compression") ? LimitedStrain::stretch_and_compression : LimitedStrain::stretch;
    return StrainLimit{.method = make(springs, limits, particles, limited),
                       .force = nullptr,
                       .max_sweeps = o.whole("max_sweeps")};
  };
  const MethodOption max_sweeps{.name = "max_sweeps",
                                .initial = static_cast<double>(LimitStep{}.max_sweeps),
                                .unit = "1",
                                .least = 1.0,
                                .most = 1e6,
                                .kind = OptionKind::whole,
                                .meaning =
                                    "sweeps over the springs in one step; more leave a "
                                    "smaller residual and cost more"};
  const MethodOption compression{.name = "compression",
                                 .unit = "",
                                 .kind = OptionKind::boolean,
                                 .meaning =
                                     "also lengthens springs shorter by more than their limit, as "
                                     "the survey describes it; cloth then buckles less finely"};
  registry.add(name, {max_sweeps, compression}, product,
               make({}, {}, 0, LimitedStrain::stretch)->traits());
}

void detail::register_policy(StrainLimiterRegistry& registry, const std::string& name,
                             const LimiterTraits& traits) {
  const auto nothing = [](const MethodOptions&, std::span<const Spring>, std::span<const double>,
                          std::size_t) { return StrainLimit{}; };
  registry.add(name, {}, nothing, traits);
}

// The limiters register themselves in their own files. A new one adds its name to both lists.
void register_no_limiter(StrainLimiterRegistry& registry);
void register_position_limiters(StrainLimiterRegistry& registry);
void register_ordered_limiters(StrainLimiterRegistry& registry);
void register_velocity_limiters(StrainLimiterRegistry& registry);
void register_stiffening_forces(StrainLimiterRegistry& registry);
void register_modified_springs(StrainLimiterRegistry& registry);
void register_continuum_limiter(StrainLimiterRegistry& registry);
void register_step_policies(StrainLimiterRegistry& registry);

StrainLimiterRegistry strain_limiters() {
  StrainLimiterRegistry registry;
  for (const auto add :
       {register_no_limiter, register_position_limiters, register_ordered_limiters,
        register_velocity_limiters, register_stiffening_forces, register_modified_springs,
        register_continuum_limiter, register_step_policies})
    add(registry);
  return registry;
}

}  // namespace selvedge
