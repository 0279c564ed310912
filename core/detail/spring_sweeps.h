// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/strain_limiter.h>

#include <span>

namespace selvedge::detail {

/// Removes the relative velocity, m/s, that goes on stretching springs which stand at their limit
/// or beyond at `x`, in sweeps, each spring's momentum kept.
void stop_stretching(const StrainLimiter& limiter, const LimitStep& step, std::span<const Vec3> x,
                     std::span<Vec3> v);

}  // namespace selvedge::detail
