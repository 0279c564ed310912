// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/strain_limiter.h>

#include <functional>
#include <string>

namespace selvedge::detail {

/// Makes a limiter that changes the ends of steps, for springs, their limits, a number of
/// particles, and the springs that it corrects.
using MakeLimitMethod = std::function<std::unique_ptr<StrainLimitMethod>(
    std::span<const Spring>, std::span<const double>, std::size_t, LimitedStrain)>;

/// Registers a limiter that changes the ends of steps, with the options `max_sweeps` and
/// `compression`.
void register_method(StrainLimiterRegistry& registry, const std::string& name,
                     const MakeLimitMethod& make);
/// Registers a name without a method or a force of its own.
void register_policy(StrainLimiterRegistry& registry, const std::string& name,
                     const LimiterTraits& traits);

}  // namespace selvedge::detail
