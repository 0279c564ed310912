// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/force_sum.h>
#include <selvedge/core/parallel.h>

#include <Eigen/Core>

namespace selvedge::detail {

/// What one step makes of (x, h x') of a mode x'' = -ω² x - c x', by θ = h²ω² and δ = hc. Methods
/// of two steps may use any other pair.
using Amplification = FunctionRef<Eigen::Matrix2d(double theta, double delta)>;

/// The longest h <= wanted up to which no step lets the mode grow, found by walking up from tiny
/// ones; 0 where it grows from the start.
double stable_step_of(Amplification amplification, const ModeBound& mode, double wanted);

/// The larger absolute eigenvalue.
double spectral_radius(const Eigen::Matrix2d& m);

/// The mode's equation as a system, h·(x, h x')' = A (x, h x'), for polynomials in it.
inline Eigen::Matrix2d mode_matrix(double theta, double delta) {
  return (Eigen::Matrix2d() << 0.0, 1.0, -theta, -delta).finished();
}

}  // namespace selvedge::detail
