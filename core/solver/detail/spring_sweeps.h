// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/strain_limiter.h>

#include <span>

namespace selvedge::detail {

/// Removes the relative velocity (m/s) that stretches springs at or beyond their limit at `x`.
/// Works in sweeps and conserves the momentum of each spring.
void stop_stretching(const StrainLimiter& limiter, const LimitStep& step, std::span<const Vec3> x,
                     std::span<Vec3> v);

}  // namespace selvedge::detail
