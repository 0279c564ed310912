// SPDX-License-Identifier: MIT
// Jaws of random size, gap, offset and tilt close on cloth: held cloth must stay flat, and closed
// jaws must hold what hangs from them and free it when they part (tests/grips.h). Prints a line for
// each grip with its seed and parameters. Exits with 1 if one has a fault.
#include <fmt/core.h>
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/tests/grips.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bench.h"

namespace selvedge {
namespace grips_bench {
namespace {

struct GripBenchOptions {
  int count = 120;
  unsigned first_seed = 1;
  std::string kind;  // empty: one after another
};

GripBenchOptions parse_grips(int argc, char** argv) {
  GripBenchOptions o;
  CommandLine app("Cloth that jaws grip: stretch, slip, speed when it is freed");
  app.option("--count", o.count, "Number of grips").range(1, 100000);
  app.option("--seed", o.first_seed, "Seed of the first; the others count up");
  app.option("--kind", o.kind, "Only grips of this kind (default: all, in turn)")
      .one_of({"held", "closed", "towel", "shears"});
  if (const auto code = app.parse(argc, argv)) std::exit(*code);
  return o;
}

// With one kind, the seeds are those of the whole list that draw it.
unsigned next_seed(const GripBenchOptions& o, unsigned seed) {
  while (!o.kind.empty() && grip_name(static_cast<GripKind>(seed % kGripKinds)) != o.kind) ++seed;
  return seed;
}

}  // namespace
}  // namespace grips_bench

int bench_grips(int argc, char** argv) {
  using namespace grips_bench;
  const GripBenchOptions o = parse_grips(argc, argv);
  int good = 0;
  fmt::print("{:<5} {:<7} {:>6} {:>9} {:>8} {:>8} {:>8} {:>7} {:>6} {:>5} {:>6}  {}\n", "seed",
             "kind", "bodies", "stretch %", "bent mm", "slip um", "pinched", "freed", "jams",
             "clean", "wall s", "drawn");
  unsigned seed = o.first_seed;
  for (int i = 0; i < o.count; ++i, ++seed) {
    seed = next_seed(o, seed);
    const GripScene scene =
        make_grip(static_cast<GripKind>(seed % kGripKinds), seed / kGripKinds % 2 == 1, seed);
    const auto start = std::chrono::steady_clock::now();
    const GripOutcome r = grip(scene);
    const std::string fault = grip_fault(scene, r);
    good += fault.empty() ? 1 : 0;
    fmt::print(
        "{:<5} {:<7} {:>6} {:>9.3f} {:>8.3f} {:>8.3f} {:>8} {:>7.3f} {:>6} {:>5} {:>6.2f}  {}{}\n",
        seed, grip_name(scene.kind), scene.one_body ? 1 : 2, 100.0 * r.stretch, 1e3 * r.bent,
        1e6 * r.slipped, r.pinched, r.freed, r.result.tangle.jams, r.result.clean ? "yes" : "no",
        seconds_since(start), fault.empty() ? "" : "BAD, " + fault + ": ", scene.text);
    std::fflush(stdout);
  }
  fmt::print("{} of {} without a fault\n", good, o.count);
  return good == o.count ? 0 : 1;
}

}  // namespace selvedge
