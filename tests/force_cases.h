// SPDX-License-Identifier: MIT
//
// One element of every internal force, its energy written down once more by itself, and states to
// try it in, degenerate ones included. For internal_force_test, and a million states in
// bench/internal_forces.
#pragma once

#include <selvedge/tests/dense_force.h>
#include <selvedge/tests/hyper_dual.h>

#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace selvedge::testing {

/// The energy of a case as its paper has it, of hyper-dual positions.
using EnergyOracle = std::function<HyperDual(std::span<const HyperVec>)>;

struct ForceCase {
  std::string name;
  std::unique_ptr<Force> force;
  std::vector<double> mass;
  Vectors rest;         ///< a shape in which it is at rest, sizes about 1
  EnergyOracle energy;  ///< empty: not the gradient of an energy, or one with no closed form
  /// A shape in which nothing of the Jacobian is dropped; empty: there is none.
  Vectors exact_jacobian{};
};

std::vector<ForceCase> internal_force_cases();

/// Of the shapes that random_state makes.
enum class Shape {
  anywhere,       ///< anywhere in a cube of any size from 1e-3 to 1e3
  near_rest,      ///< off the rest shape by 1e-6 to 0.3
  far_away,       ///< near rest, 1e4 from the origin
  together,       ///< two particles at the same place
  collapsed,      ///< all at the same place
  on_a_line,      ///< all on a line, to the bit along an axis or to rounding along any
  flat,           ///< all in a plane
  nearly_a_line,  ///< off a line by 1e-16 to 1e-6
};
constexpr int kShapes = 8;

ForceStateOwner random_state(const ForceCase& c, Shape shape, std::mt19937& random);

/// Sum and moment of the forces of a state, relative to Σ|f| and Σ|x - centre| |f|; infinite where
/// a force is not finite.
struct Balance {
  double sum = 0.0, moment = 0.0;
};
Balance balance_of(const ForceCase& c, const ForceStateOwner& state);

}  // namespace selvedge::testing
