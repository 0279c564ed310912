// SPDX-License-Identifier: MIT
// Tests the removal of tangles on generated scenes. Each scene runs until it is free of tangles and
// for a few more frames, and the exact predicates of `check` judge every state and path. Prints a
// line for each scene and a summary. Exits with 1 if a tangle remains, moves too fast, or if the
// cloth crosses anywhere else.
#include <fmt/core.h>
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/tests/tangles.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "bench.h"

namespace selvedge {
namespace untangle_bench {
namespace {

constexpr double kTooFast = 10.0;  // m/s

struct BenchOptions {
  int count = 50;
  unsigned first_seed = 1;
  int frames = 240, after = 6;
  bool no_judge = false;
};

BenchOptions parse(int argc, char** argv) {
  BenchOptions o;
  CommandLine app("Untangling of generated scenes: number resolved, time, speed");
  app.option("--count", o.count, "Number of tangles").range(1, 100000);
  app.option("--seed", o.first_seed, "Seed of the first; the others count up");
  app.option("--frames", o.frames, "Frames after which a tangle counts as unresolved");
  app.option("--after", o.after, "Frames to continue after the tangle is resolved");
  app.flag("--no-judge", o.no_judge, "Omit the exact check of states and paths");
  if (const auto code = app.parse(argc, argv)) std::exit(*code);
  return o;
}

bool is_good(const TangleOutcome& o) {
  return o.stopped.empty() && o.pairs == 0 && o.elsewhere == 0 && o.after == 0 && o.only_shrinks &&
         o.max_speed < kTooFast && o.result.clean;
}

}  // namespace
}  // namespace untangle_bench

int bench_untangle(int argc, char** argv) {
  using namespace untangle_bench;
  const BenchOptions o = parse(argc, argv);
  int good = 0, free = 0;
  double fastest = 0.0, apart = 0.0, longest = 0.0;
  std::size_t elsewhere = 0;
  fmt::print("{:<6} {:<7} {:>6} {:>6} {:>7} {:>7} {:>7} {:>9} {:>6} {:>7}  {}\n", "seed", "kind",
             "pairs", "steps", "free s", "m/s", "apart", "elsewhere", "left", "wall s", "drawn");
  for (int i = 0; i < o.count; ++i) {
    const unsigned seed = o.first_seed + static_cast<unsigned>(i);
    const auto kind = static_cast<TangleKind>(i % kTangleKinds);
    TangledScene tangled = make_tangle(kind, seed);
    const std::string text = tangled.text;
    const auto start = std::chrono::steady_clock::now();
    const TangleOutcome r = untangle(std::move(tangled), o.frames, o.after, !o.no_judge);
    good += is_good(r) ? 1 : 0;
    free += r.pairs == 0 && r.stopped.empty() ? 1 : 0;
    fastest = std::max(fastest, r.max_speed);
    apart = std::max(apart, r.max_apart);
    longest = std::max(longest, r.until_s);
    elsewhere += r.elsewhere + r.after;
    fmt::print("{:<6} {:<7} {:>6} {:>6} {:>7.3f} {:>7.2f} {:>7.2f} {:>9} {:>6} {:>7.2f}  {}{}{}\n",
               seed, tangle_name(kind), r.start_pairs, r.steps, r.until_s, r.max_speed, r.max_apart,
               r.elsewhere + r.after, r.pairs, seconds_since(start),
               is_good(r) ? "" : "BAD: ", r.only_shrinks ? "" : "regions grew; ",
               r.stopped.empty() ? text : r.stopped);
    std::fflush(stdout);
  }
  fmt::print(
      "{} of {} resolved, {} without a fault; at most {:.2f} m/s, {:.2f} m/s against the mean of "
      "the cloth, {:.3f} s; {} crossings "
      "elsewhere\n",
      free, o.count, good, fastest, apart, longest, elsewhere);
  return good == o.count ? 0 : 1;
}

}  // namespace selvedge
