// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/force.h>

#include <Eigen/Core>

namespace selvedge::detail {

/// The matrix by which one step multiplies (x, h x') of a mode x'' = -ω² x - c x', with θ = h²ω²
/// and δ = hc. Two-step methods may use another pair of variables.
using Amplification = FunctionRef<Eigen::Matrix2d(double theta, double delta)>;

/// The longest h <= wanted such that no shorter step amplifies the mode, found by a search upwards
/// from tiny steps; 0 if the mode grows from the start.
double stable_step_of(Amplification amplification, const ModeBound& mode, double wanted);

/// The larger absolute eigenvalue.
double spectral_radius(const Eigen::Matrix2d& m);

/// Matrix A of the mode's equation h·(x, h x')' = A (x, h x'), for polynomials in A.
inline Eigen::Matrix2d mode_matrix(double theta, double delta) {
  return (Eigen::Matrix2d() << 0.0, 1.0, -theta, -delta).finished();
}

}  // namespace selvedge::detail
