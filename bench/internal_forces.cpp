// SPDX-License-Identifier: MIT
//
// Evaluates every internal force in a million random states, degenerate ones included. Reports the
// largest sum and moment, relative to the sizes of the forces, and whether any force was not
// finite.
#include <fmt/format.h>
#include <selvedge/apps/command_line.h>
#include <selvedge/core/resources.h>
#include <selvedge/tests/force_cases.h>

#include <algorithm>
#include <array>
#include <cmath>

int main(int argc, char** argv) {
  using namespace selvedge::testing;
  selvedge::CommandLine app("Sum and moment of every internal force in random states.");
  int states = 1000000;
  unsigned seed = 1;
  app.option("--states", states, "states per force").positive();
  app.option("--seed", seed, "seed of the generator");
  if (const auto code = app.parse(argc, argv)) return *code;
  constexpr double allowed = 1e-12;
  bool good = true;
  fmt::print("{:<16} {:>9} {:>10} {:>10} {:>11} {:>7}\n", "force", "states", "worst sum",
             "worst mom.", "not finite", "s");
  for (const ForceCase& c : internal_force_cases()) {
    std::mt19937 random(seed);
    const selvedge::Stopwatch watch;
    Balance worst;
    int not_finite = 0;
    for (int i = 0; i < states; ++i) {
      const Balance b = balance_of(c, random_state(c, static_cast<Shape>(i % kShapes), random));
      not_finite += std::isfinite(b.sum) ? 0 : 1;
      worst = {std::max(worst.sum, b.sum), std::max(worst.moment, b.moment)};
    }
    const double seconds = watch.seconds();
    good = good && worst.sum <= allowed && worst.moment <= allowed;
    fmt::print("{:<16} {:>9} {:>10.1e} {:>10.1e} {:>11} {:>7.2f}\n", c.name, states, worst.sum,
               worst.moment, not_finite, seconds);
  }
  fmt::print("{}\n", good ? "every sum and moment is below 1e-12"
                          : "a sum or moment is above 1e-12, or a force is not finite");
  return good ? 0 : 1;
}
