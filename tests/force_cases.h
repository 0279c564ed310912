// SPDX-License-Identifier: MIT
//
// One element of every internal force, an independent formulation of its energy, and test states,
// degenerate ones included. Used by internal_force_test.
#pragma once

#include <selvedge/tests/dense_force.h>
#include <selvedge/tests/hyper_dual.h>

#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace selvedge::testing {

/// The energy of a case as its paper gives it, as a function of hyper-dual positions.
using EnergyOracle = std::function<HyperDual(std::span<const HyperVec>)>;

struct ForceCase {
  std::string name;
  std::unique_ptr<Force> force;
  std::vector<double> mass;
  Vectors rest;         ///< a rest shape of sizes about 1
  EnergyOracle energy;  ///< empty: the force has no energy, or none in closed form
  /// A shape for which the Jacobian drops no term; empty if there is none.
  Vectors exact_jacobian{};
};

std::vector<ForceCase> internal_force_cases();

/// Kinds of shapes that random_state generates.
enum class Shape {
  anywhere,       ///< positions in a cube of any size from 1e-3 to 1e3
  near_rest,      ///< rest shape displaced by 1e-6 to 0.3
  far_away,       ///< near rest, 1e4 from the origin
  together,       ///< two particles at the same place
  collapsed,      ///< all at the same place
  on_a_line,      ///< collinear: exactly along an axis, or up to rounding along any line
  flat,           ///< coplanar
  nearly_a_line,  ///< displaced from a line by 1e-16 to 1e-6
};
constexpr int kShapes = 8;

ForceStateOwner random_state(const ForceCase& c, Shape shape, std::mt19937& random);

/// Sum and moment of the forces of a state, relative to Σ|f| and Σ|x - centre| |f|; infinite if a
/// force is not finite.
struct Balance {
  double sum = 0.0, moment = 0.0;
};
Balance balance_of(const ForceCase& c, const ForceStateOwner& state);

}  // namespace selvedge::testing
