// SPDX-License-Identifier: MIT
//
// Compares the responses on scenes with closed forms: time, residual penetration, and errors of
// friction, momentum and energy. Also measures the survey's claims on responses, with 95 %
// intervals. Prints Markdown.
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/parallel.h>

#include "bench.h"
#include "response_claims.h"
#include "response_scenes.h"

#include <fmt/core.h>

#include <cstdio>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {
namespace response_bench {
namespace {

using namespace selvedge::bench;

struct BenchOptions {
  std::vector<std::string> responses;
  std::string scene;
  int cells = 16;
  int drape_cells = 24;
  ClaimOptions claims;
  bool table = true, claim = true;
  int threads = 1;
};

BenchOptions parse(int argc, char** argv) {
  BenchOptions options;
  CommandLine app("Responses: a table of response and scene, and the survey's claims");
  app.option("--response", options.responses, "Names of responses (default: all)");
  app.option("--scene", options.scene, "Only scenes whose name contains this");
  app.option("--cells", options.cells, "Cells per side of the small sheets").range(2, 200);
  app.option("--drape-cells", options.drape_cells, "Cells per side on ball and table")
      .range(2, 200);
  app.option("--claim-cells", options.claims.cells, "Cells per side of the timed pairs")
      .range(2, 200);
  app.option("--claim", options.claims.only, "Only this claim: C9, C10, C28 or C29");
  app.option("--repeats", options.claims.repeats, "Timed pairs of each scene").range(2, 1000);
  app.option("--seed", options.claims.seed, "Seed of the samples and the bootstrap");
  app.option("--threads", options.threads, "Threads; 0: all").range(0, 1024);
  app.flag("!--no-table", options.table, "Omit the table");
  app.flag("!--no-claims", options.claim, "Omit the claims");
  if (const auto code = app.parse(argc, argv)) std::exit(*code);
  const ResponseRegistry known = responses();
  for (const std::string& name : options.responses)
    if (!known.contains(name)) throw std::invalid_argument("there is no response " + name);
  if (options.responses.empty())
    for (const auto& [name, make] : known) options.responses.push_back(name);
  return options;
}

/// Percentage of the steps' time spent on contacts after the solve.
double share_of_response(const std::map<std::string, double>& phases) {
  double sum = 0.0;
  for (const auto& [name, seconds] : phases) sum += seconds;
  return sum > 0.0 ? 100.0 * phases.at("response") / sum : 0.0;
}

void print_row(const ResponseCase& c, const std::string& response, const ResponseRun& run) {
  const auto& ledger = run.result.ledger.at("response");
  const auto count = [&](const char* key) {
    const auto at = run.result.counters.find(key);
    return at == run.result.counters.end() ? 0.0 : at->second;
  };
  fmt::print(
      "| {} | {} | {:.2f} | {:.1f} | {} | {:.0f} | {:.3f} | {} | {:.1e} | {:.3g} | {:.3g} | {:.2f} "
      "| {} |\n",
      c.name, response, run.seconds, share_of_response(run.result.phase_s), run.result.halvings,
      count("fail_safe_steps"), 1e3 * count("max_gap_violation_m"),
      c.unit.empty() ? "" : fmt::format("{:.3g} {}", run.error, c.unit),
      ledger.at("max_momentum_error"), 1e3 * ledger.at("energy_gained_J"),
      1e3 * (ledger.at("energy_normal_J") + ledger.at("energy_friction_J")), 1e3 * run.rms_speed,
      !run.stopped.empty() ? run.stopped
      : run.result.clean   ? "clean"
                           : "**not clean**");
  std::fflush(stdout);
}

void print_table(const BenchOptions& options) {
  fmt::print(
      "| scene | response | s | response % | halvings | steps with fail-safe | gap violation, mm | "
      "error | momentum error | gained, mJ | given, mJ | RMS speed at the end, mm/s | states |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|\n");
  const std::vector<ResponseCase> cases = {ball(options.drape_cells),
                                           table(options.drape_cells),
                                           incline_sliding(options.cells),
                                           incline_sticking(options.cells),
                                           capstan(0.9),
                                           capstan(1.1),
                                           stack(6, options.cells / 2),
                                           drop(options.cells)};
  for (const ResponseCase& c : cases)
    if (options.scene.empty() || c.name.find(options.scene) != std::string::npos)
      for (const std::string& name : options.responses) print_row(c, name, run(c, name));
}

}  // namespace
}  // namespace response_bench

int bench_response(int argc, char** argv) {
  using namespace response_bench;
  const BenchOptions options = parse(argc, argv);
  const ThreadLimit limit(options.threads);
  if (options.table) print_table(options);
  if (options.claim) print_claims(options.claims);
  return 0;
}

}  // namespace selvedge
