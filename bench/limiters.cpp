// SPDX-License-Identifier: MIT
//
// Compares the strain limiters on one swinging cloth of 2,500 particles, all limited to the same
// strain: time, sweeps, strain, momentum and energy (survey section 4.6, claims on its Fig. 21, 22
// and Table VI).
//   bench limiters [--frames 30] [--cells 49] [--repeats 3] [--markdown]
//   bench limiters --replay [--stiffness 3] [--seeds 5] [--cells 49]: times the limiters alone, on
//   the same ends of steps and to the same residual (limiter_replay.h; claims C4 and C5)
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <cmath>

#include "bench.h"
#include "limiter_replay.h"
#include "table.h"

namespace selvedge {
namespace limiters_bench {
namespace {

/// A level cloth held by two corners, soft enough to stretch far beyond its limit of 10 %.
Scene swing(int cells) {
  Scene scene;
  scene.name = "swing";
  Material soft;
  soft.stretch_stiffness = 60.0;
  soft.shear_stiffness = 15.0;
  soft.spring_damping = 1e-4;
  scene.materials["default"] = soft;
  ClothSpec cloth;
  cloth.name = "cloth";
  cloth.shape = ClothGrid{"rectangular", {1.0, 1.0, cells, cells}};
  scene.cloths.push_back(cloth);
  const int row = cells + 1;
  scene.handles.push_back({"corners", "cloth", {row * cells, row * cells + cells}, {}, {}});
  scene.contact.self = false;
  return scene;
}

struct Outcome {
  double seconds = 1e300;  // minimum over the repeats, of the phase "strain"
  double whole = 1e300;    // the same for all phases
  RunResult result;
  std::vector<Vec3> x;
  double energy = 0.0;  // J; kinetic, elastic and potential energy at the end
};

double energy_of(const Scene& scene, const BuiltScene& built, const Simulation& simulation) {
  const std::size_t n = built.cloth.mass.size();
  auto parts = make_internal_forces(built.cloth);
  parts.push_back(make_gravity(scene.gravity));
  StrainLimit limit =
      strain_limiters().at(scene.solver.limiter)(built.cloth.springs, built.cloth.strain_limit, n);
  if (limit.force) parts.push_back(std::move(limit.force));
  const ForceSum forces(std::move(parts), n);
  const SimulationState& state = simulation.state();
  double sum = forces.energy({state.x, state.v, built.cloth.mass, state.time});
  for (std::size_t i = 0; i < n; ++i) sum += 0.5 * built.cloth.mass[i] * state.v[i].squaredNorm();
  return sum;
}

void run(const std::string& limiter, int cells, int frames, Outcome& outcome) {
  Scene scene = swing(cells);
  scene.solver.limiter = limiter;
  scene.solver.strain_limiter = limiter != "none";
  Simulation simulation(scene, build_scene(scene));
  const Stopwatch watch;
  for (int frame = 1; frame <= frames; ++frame) simulation.advance_to_frame(frame, {});
  const double seconds = watch.seconds();
  outcome.result = simulation.result();
  outcome.whole = std::min(outcome.whole, seconds);
  const auto strain = outcome.result.phase_s.find("strain");
  if (strain != outcome.result.phase_s.end())
    outcome.seconds = std::min(outcome.seconds, strain->second);
  outcome.x = simulation.state().x;
  outcome.energy = energy_of(scene, build_scene(scene), simulation);
}

double mean_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).norm();
  return sum / static_cast<double>(a.size());
}

double figure(const Outcome& o, const char* name) {
  const auto ledger = o.result.ledger.find("strain_limiter");
  return ledger == o.result.ledger.end() ? std::nan("") : ledger->second.at(name);
}

std::string number(const char* format, double value) {
  return std::isfinite(value) && value < 1e299 ? fmt::format(fmt::runtime(format), value) : "";
}

}  // namespace
}  // namespace limiters_bench

int bench_limiters(int argc, char** argv) {
  using namespace limiters_bench;
  CommandLine app("Strain limiters on one swinging cloth");
  int frames = 30, cells = 49, repeats = 3;
  bool markdown = false, replay = false;
  bench::ReplayOptions drapes;
  app.option("--frames", frames, "Frames of 1/60 s").range(1, 100000);
  app.option("--cells", cells, "Cells along a side").range(1, 1000);
  app.option("--repeats", repeats, "Runs, interleaved; times are minima").range(1, 100);
  app.flag("--markdown", markdown, "Print the table in Markdown");
  app.flag("--replay", replay, "Time the limiters alone, on the ends of the steps of drapes");
  app.option("--stiffness", drapes.stiffness, "Of the springs of --replay, N/m");
  app.option("--seeds", drapes.seeds, "Drapes of --replay").range(1, 100);
  if (const auto code = app.parse(argc, argv)) return *code;
  if (replay) {
    drapes.cells = cells;
    const ThreadLimit one(1);
    fmt::print("{}", bench::replay_limiters(drapes));
    return 0;
  }
  std::map<std::string, Outcome> outcomes;
  for (int r = 0; r < repeats; ++r)
    for (const auto& [name, entry] : strain_limiters()) run(name, cells, frames, outcomes[name]);
  Table table({"limiter", "max strain %", "residual %", "sweeps", "strain s", "total s",
               "momentum error", "energy given J", "energy at end J", "distance to position mm"});
  const Outcome& position = outcomes.at("position");
  for (const auto& [name, o] : outcomes) {
    const auto sweeps = o.result.counters.find("strain_sweeps");
    table.add({name, number("{:.2f}", 100.0 * o.result.max_stretch),
               number("{:.2f}", 100.0 * o.result.strain_residual),
               sweeps == o.result.counters.end() ? "" : number("{:.0f}", sweeps->second),
               number("{:.3f}", o.seconds), number("{:.2f}", o.whole),
               number("{:.1e}", figure(o, "max_momentum_error")),
               number("{:+.4f}", figure(o, "energy_kinetic_J")), number("{:+.4f}", o.energy),
               number("{:.1f}", 1e3 * mean_distance(o.x, position.x))});
  }
  fmt::print("{}", markdown ? table.markdown() : table.text());
  return 0;
}

}  // namespace selvedge
