// SPDX-License-Identifier: MIT
// Rest and friction of the default contact: how still a sheet, a stack and a drape lie, how hard a
// stack presses on the floor, and how well Coulomb's law holds on an incline, in a sliding stop and
// around a capstan. Each row is one case; `--verbose` prints its course, a line per interval.
#include "bench.h"
#include "rest_scenes.h"

#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace selvedge {
namespace rest_bench {
namespace {

using namespace selvedge::bench;

Vec3 momentum(const SimulationState& state, const std::vector<double>& mass) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < mass.size(); ++i) sum += mass[i] * state.v[i];
  return sum;
}

Vec3 centre(const SimulationState& state) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& x : state.x) sum += x;
  return sum / static_cast<double>(state.x.size());
}

/// Measurements of a run over an interval.
struct Interval {
  double rms = 0.0, fastest = 0.0;               // m/s, over particles and steps
  double force_least = 1e300, force_most = 0.0;  // N; upwards sum of all forces except gravity
  int steps = 0;
};

/// A simulation that is measured in every step.
class Watched {
 public:
  Watched(const Scene& scene, BuiltScene built)
      : gravity_(scene.gravity),
        mass_(built.cloth.mass),
        weight_(total_mass(built) * kGravity),
        simulation_(scene, std::move(built)),
        before_(simulation_.state()) {}

  Interval run_to_frame(int frame) {
    Interval seen;
    double squares = 0.0;
    for (; frame_ < frame; ++frame_)
      simulation_.advance_to_frame(frame_ + 1, [&](double) { note(seen, squares); });
    const double n = static_cast<double>(mass_.size()) * std::max(seen.steps, 1);
    seen.rms = std::sqrt(squares / n);
    return seen;
  }

  Simulation& simulation() { return simulation_; }
  const SimulationState& state() const { return simulation_.state(); }
  double weight() const { return weight_; }

 private:
  void note(Interval& seen, double& squares) {
    const SimulationState& now = simulation_.state();
    for (const Vec3& v : now.v) {
      squares += v.squaredNorm();
      seen.fastest = std::max(seen.fastest, v.norm());
    }
    // m dv/dt = m g + F, with velocities from differences of positions.
    const double h = now.time - before_.time;
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < mass_.size(); ++i) p += mass_[i] * (now.x[i] - before_.x[i]) / h;
    if (last_momentum_.allFinite()) {
      const double force = (p - last_momentum_).z() / h + weight_;
      seen.force_least = std::min(seen.force_least, force);
      seen.force_most = std::max(seen.force_most, force);
    }
    last_momentum_ = p;
    ++seen.steps;
    before_ = now;
  }

  Vec3 gravity_;
  std::vector<double> mass_;
  double weight_;
  Simulation simulation_;
  SimulationState before_;
  Vec3 last_momentum_ = Vec3::Constant(std::nan(""));
  int frame_ = 0;
};

double energy(const SimulationState& state, const std::vector<double>& mass) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mass.size(); ++i)
    sum += mass[i] * (0.5 * state.v[i].squaredNorm() + kGravity * state.x[i].z());
  return sum;
}

void print_interval(const Watched&, double time, const Interval& seen,
                    const std::map<std::string, double>& before,
                    const std::map<std::string, double>& now, double weight) {
  const auto per_step = [&](const char* name) {
    const auto a = before.find(name), b = now.find(name);
    return ((b == now.end() ? 0.0 : b->second) - (a == before.end() ? 0.0 : a->second)) /
           std::max(seen.steps, 1);
  };
  fmt::print(
      "  {:7.2f} s  rms {:9.2e}  max {:9.2e} m/s  force/weight {:.5f}..{:.5f}  contacts {:.0f} "
      "solves {:.2f} iterations {:.1f} collisions {:.3f}\n",
      time, seen.rms, seen.fastest, seen.force_least / weight, seen.force_most / weight,
      per_step("contacts"), per_step("solves"), per_step("solver_iterations"),
      per_step("impulse_passes"));
  std::fflush(stdout);
}

/// Runs to `seconds` and prints; returns the measurements of the last interval.
Interval watch(Watched& watched, double seconds, double interval, bool verbose, double fps = 60.0) {
  Interval seen;
  std::map<std::string, double> before;
  const int total = static_cast<int>(std::lround(seconds * fps));
  const int part = std::max(1, static_cast<int>(std::lround(interval * fps)));
  for (int frame = 0; frame < total;) {
    frame = std::min(frame + part, total);
    seen = watched.run_to_frame(frame);
    const RunResult result = watched.simulation().result();
    if (verbose)
      print_interval(watched, frame / fps, seen, before, result.counters, watched.weight());
    before = result.counters;
  }
  return seen;
}

void print_row(const std::string& name, Watched& watched, const Interval& seen, double wall) {
  const RunResult result = watched.simulation().result();
  const auto counter = [&](const char* key) {
    const auto found = result.counters.find(key);
    return found == result.counters.end() ? 0.0 : found->second / std::max(result.steps, 1);
  };
  fmt::print(
      "{}: {} steps, clean {}, last interval: rms {:.3e} max {:.3e} m/s, floor/weight "
      "{:.6f}..{:.6f}; solves/step {:.2f}, iterations/step {:.1f}; {:.2f} s\n",
      name, result.steps, result.clean ? "yes" : "NO", seen.rms, seen.fastest,
      seen.force_least / watched.weight(), seen.force_most / watched.weight(), counter("solves"),
      counter("solver_iterations"), wall);
}

void run_watched(const std::string& name, const Scene& scene, const BenchOptions& options,
                 double seconds) {
  const Stopwatch clock;
  Watched watched(scene, build_scene(scene));
  const double length = options.seconds > 0.0 ? options.seconds : seconds;
  const Interval seen = watch(watched, length, length / 10.0, options.verbose);
  print_row(name, watched, seen, clock.seconds());
}

void sheet_case(const BenchOptions& options) {
  Scene scene = empty_scene(options);
  const int cells = options.cells > 0 ? options.cells : 10;
  scene.cloths.push_back(sheet(0.2, cells, {0.013, 0.017, 0.004}));
  scene.bodies.push_back(body(Plane{}));
  run_watched("sheet on a plane", scene, options, 5.0);
}

constexpr int kSheets = 20;

Scene stack_scene(const BenchOptions& options, bool turned) {
  Scene scene = empty_scene(options);
  scene.contact.rest_gap = 0.001;
  const int cells = options.cells > 0 ? options.cells : 8;
  for (int k = 0; k < kSheets; ++k) {
    ClothSpec spec = sheet(0.2, cells, {0.013, 0.017, 0.002 * (k + 1)});
    spec.name = fmt::format("sheet {}", k);
    if (turned) {
      spec.placement.translation += Vec3(0.004 * std::sin(5.0 * k), 0.004 * std::cos(3.0 * k), 0.0);
      spec.placement.rotation = Eigen::AngleAxisd(0.3 * k, Vec3::UnitZ());
    }
    scene.cloths.push_back(spec);
  }
  scene.bodies.push_back(body(Plane{}));
  return scene;
}

void stack_report(const std::string& name, const Scene& scene, const BenchOptions& options) {
  const Stopwatch clock;
  Watched watched(scene, build_scene(scene));
  const double length = options.seconds > 0.0 ? options.seconds : 5.0;
  const Interval seen = watch(watched, length, length / 10.0, options.verbose);
  print_row(name, watched, seen, clock.seconds());
  // Use the inner part of each sheet, away from overhanging corners, as the height of its layer.
  const std::size_t per = watched.state().x.size() / scene.cloths.size();
  const double rest_gap = scene.contact.rest_gap;
  double worst = 0.0, below = 0.0;
  bool ordered = true;
  for (std::size_t k = 0; k < scene.cloths.size(); ++k) {
    double mean = 0.0, count = 0.0;
    for (std::size_t i = 0; i < per; ++i) {
      const Vec3& x = watched.state().x[k * per + i];
      if ((x - scene.cloths[k].placement.translation).head<2>().norm() > 0.05) continue;
      mean += x.z();
      count += 1.0;
    }
    mean /= count;
    ordered = ordered && mean > below;
    worst = std::max(worst, rest_gap - (mean - below));
    below = mean;
  }
  fmt::print(
      "  order {}, largest gap violation of layers {:.3g} rest gaps, top at {:.4f} rest gaps\n",
      ordered ? "kept" : "LOST", worst / scene.contact.rest_gap, below / scene.contact.rest_gap);
}

void stack_case(const BenchOptions& options) {
  stack_report("20 sheets, aligned", stack_scene(options, false), options);
}
void turned_case(const BenchOptions& options) {
  stack_report("20 sheets, turned", stack_scene(options, true), options);
}

void ball_case(const BenchOptions& options) {
  Scene scene = empty_scene(options);
  const int cells = options.cells > 0 ? options.cells : 30;
  scene.cloths.push_back(sheet(0.6, cells, {0.02, 0.01, 0.22}));
  scene.bodies.push_back(body(Sphere{0.2}, 64));
  scene.air.normal_drag = 1.0;
  scene.air.viscous_drag = 0.1;
  run_watched("ball drape", scene, options, 8.0);
}

void incline_case(const BenchOptions& options) {
  const double angle = std::numbers::pi / 6.0;
  {
    const Scene scene = incline_scene(options, 0.6, angle);
    Simulation simulation(scene, build_scene(scene));
    for (int f = 1; f <= 12; ++f) simulation.advance_to_frame(f, {});
    const Vec3 start = centre(simulation.state());
    for (int f = 13; f <= 612; ++f) simulation.advance_to_frame(f, {});
    fmt::print("incline, mu 0.6: creep {:.3e} m in 10 s (< 1e-6), solves/step {:.2f}\n",
               (centre(simulation.state()) - start).norm(),
               simulation.result().counters["solves"] / simulation.result().steps);
  }
  {
    const Scene scene = incline_scene(options, 0.3, angle);
    Simulation simulation(scene, build_scene(scene));
    for (int f = 1; f <= 12; ++f) simulation.advance_to_frame(f, {});
    const Vec3 v0 = momentum(
        simulation.state(),
        std::vector<double>(simulation.state().x.size(), 1.0 / simulation.state().x.size()));
    for (int f = 13; f <= 72; ++f) simulation.advance_to_frame(f, {});
    const Vec3 v1 = momentum(
        simulation.state(),
        std::vector<double>(simulation.state().x.size(), 1.0 / simulation.state().x.size()));
    const double right = kGravity * (std::sin(angle) - 0.3 * std::cos(angle));
    fmt::print("incline, mu 0.3: a = {:.5f} m/s^2 ({:.5f}, {:+.3f} %), solves/step {:.2f}\n",
               (v1 - v0).norm(), right, 100.0 * ((v1 - v0).norm() / right - 1.0),
               simulation.result().counters["solves"] / simulation.result().steps);
  }
}

void slide_case(const BenchOptions& options) {
  Scene scene = incline_scene(options, 0.3, 0.0);
  scene.cloths[0].velocity = Vec3(1.0, 0.0, 0.0);
  Simulation simulation(scene, build_scene(scene));
  const Vec3 start = centre(simulation.state());
  for (int f = 1; f <= 60; ++f) simulation.advance_to_frame(f, {});
  const double way = (centre(simulation.state()) - start).x();
  fmt::print("sliding stop from 1 m/s, mu 0.3: {:.5f} m (0.16990, {:+.3f} %)\n", way,
             100.0 * (way / 0.16990 - 1.0));
}

double mean_height(const SimulationState& state, const std::vector<std::int32_t>& of) {
  double sum = 0.0;
  for (const std::int32_t i : of) sum += state.x[i].z();
  return sum / static_cast<double>(of.size());
}

/// kg, of a load and of the strip that hangs with it below the axis of the cylinder.
double hanging_mass(const Simulation& simulation, const std::vector<std::int32_t>& load,
                    const std::vector<double>& mass) {
  double sum = 0.0;
  for (const std::int32_t i : load) sum += mass[i];
  return sum - kCapstanLine * simulation.state().x[load[0]].z();
}

/// T2/T1 from the acceleration of sliding loads.
void capstan_slide(const BenchOptions& options, double ratio, int resolution) {
  const double mu = 0.3;
  Capstan c = capstan(options, ratio, mu, resolution, 2000.0);
  std::vector<double> mass = c.built.cloth.mass;
  const std::vector<std::int32_t> left = c.left, right = c.right;
  Simulation simulation(c.scene, std::move(c.built));
  const auto speed = [&](const std::vector<std::int32_t>& of) {
    double sum = 0.0;
    for (const std::int32_t i : of) sum += simulation.state().v[i].z();
    return sum / static_cast<double>(of.size());
  };
  const int settle = 18, end = 42;
  for (int f = 1; f <= settle; ++f) simulation.advance_to_frame(f, {});
  const double up0 = speed(left), down0 = speed(right), t = (end - settle) / 60.0;
  const double light = hanging_mass(simulation, left, mass),
               heavy = hanging_mass(simulation, right, mass);
  double last_up = up0, last_down = down0;
  for (int f = settle + 1; f <= end; ++f) {
    simulation.advance_to_frame(f, {});
    if (options.verbose && f % 4 == 0) {
      const double up = (speed(left) - last_up) * 15.0, down = (speed(right) - last_down) * 15.0;
      last_up = speed(left);
      last_down = speed(right);
      fmt::print("   frame {}: up {:.4f} m/s, down {:.4f} m/s, T2/T1 {:.4f}\n", f, last_up,
                 last_down, ratio * (kGravity + down) / (kGravity + up));
    }
  }
  const double up = (speed(left) - up0) / t, down = (speed(right) - down0) / t;
  const double left_mean = 0.5 * (light + hanging_mass(simulation, left, mass)),
               right_mean = 0.5 * (heavy + hanging_mass(simulation, right, mass));
  const double seen = right_mean / left_mean * (kGravity + down) / (kGravity + up);
  const double expected = std::exp(mu * std::numbers::pi);
  fmt::print(
      "capstan, loads 1:{:.2f}, {} facets: a {:.4f} {:.4f} m/s^2, T2/T1 {:.4f} ({:.4f}, {:+.2f} "
      "%), solves/step {:.2f} iterations/step {:.1f}\n",
      ratio, resolution, up, down, seen, expected, 100.0 * (seen / expected - 1.0),
      simulation.result().counters["solves"] / simulation.result().steps,
      simulation.result().counters["solver_iterations"] / simulation.result().steps);
}

void capstan_onset(const BenchOptions& options, int resolution) {
  for (const double ratio : {2.2, 2.4, 2.49, 2.57, 2.65, 2.75, 3.0}) {
    Capstan c = capstan(options, ratio, 0.3, resolution, 2000.0);
    const std::vector<std::int32_t> right = c.right, left = c.left;
    Simulation simulation(c.scene, std::move(c.built));
    for (int f = 1; f <= 30; ++f) simulation.advance_to_frame(f, {});
    const double a0 = mean_height(simulation.state(), right),
                 b0 = mean_height(simulation.state(), left);
    for (int f = 31; f <= 60; ++f) simulation.advance_to_frame(f, {});
    const double a1 = mean_height(simulation.state(), right),
                 b1 = mean_height(simulation.state(), left);
    for (int f = 61; f <= 90; ++f) simulation.advance_to_frame(f, {});
    const double a2 = mean_height(simulation.state(), right),
                 b2 = mean_height(simulation.state(), left);
    fmt::print(
        "  loads 1:{:.2f}: heavy end falls {:+.3e} then {:+.3e} m, light end rises {:+.3e} then "
        "{:+.3e} m in 0.5 s\n",
        ratio, a0 - a1, a1 - a2, b1 - b0, b2 - b1);
    std::fflush(stdout);
  }
}

/// T2/T1 of a strip that a handle pulls slowly over the cylinder, from the force on the handle. The
/// closed form includes the weight of the strip.
void capstan_pull(const BenchOptions& options, int resolution) {
  constexpr double kMu = 0.3, kSpeed = 0.02;  // m/s
  Capstan c = capstan(options, 1.0, kMu, resolution, 2000.0);
  Keyframe end;
  end.time = 4.0;
  end.translation = Vec3(0.0, 0.0, -kSpeed * end.time);
  c.scene.handles.push_back({"pull", c.scene.cloths[0].name, c.right, {Keyframe{}, end}, {}});
  const std::vector<Vec3>& x = c.built.cloth.surface.vertices;
  const std::size_t cells = x.size() / (kCapstanAcross + 1) - 1;
  const double load = kCapstanLoad * kGravity;  // N, at each end
  const double line = kCapstanLine * kGravity;  // N/m
  const double radius = x[x.size() / 2].norm();
  const double light = load - line * x[c.left[0]].z();
  const double heavy = load - line * x[c.right[0]].z();  // without the handle
  Simulation simulation(c.scene, std::move(c.built));
  simulation.measure_wrenches(true);
  const int settle = 90, total = 210;
  double pull = 0.0;
  for (int f = 1; f <= total; ++f) {
    simulation.advance_to_frame(f, {});
    if (f <= settle) continue;
    const double force = simulation.frame_wrenches().handles[0].force.z();
    pull += force / (total - settle);
    if (options.verbose && f % 30 == 0)
      fmt::print("   frame {}: T2/T1 {:.4f}\n", f, (heavy + force) / light);
  }
  // While the handle goes down, the light end rises by as much.
  const double moved = line * kSpeed * 0.5 * (settle + total) / 60.0;
  const double t1 = light - moved, t2 = heavy + moved + pull,
               grows = std::exp(kMu * std::numbers::pi);
  const double right = grows + 2.0 * kMu / (1.0 + kMu * kMu) * line * radius * (grows + 1.0) / t1;
  fmt::print(
      "capstan, pulled at {} m/s, {} facets, {} cells: T2/T1 {:.4f} ({:.4f}, {:+.2f} %), "
      "solves/step {:.2f}\n",
      kSpeed, resolution, cells, t2 / t1, right, 100.0 * (t2 / t1 / right - 1.0),
      simulation.result().counters["solves"] / simulation.result().steps);
}

void capstan_case(const BenchOptions& options) {
  for (const int resolution : {64, 128, 256}) capstan_pull(options, resolution);
  BenchOptions fine = options;
  if (options.cells == 0) fine.cells = 240;
  capstan_pull(fine, 64);
  capstan_onset(options, 128);
  for (const double ratio : {2.7, 3.0, 4.0}) capstan_slide(options, ratio, 64);
}

void hour_case(const BenchOptions& options) {
  Scene scene = empty_scene(options);
  scene.cloths.push_back(sheet(0.2, 6, {0.013, 0.017, 0.003}));
  scene.bodies.push_back(body(Plane{}));
  BuiltScene built = build_scene(scene);
  const std::vector<double> mass = built.cloth.mass;
  Simulation simulation(scene, std::move(built));
  const double seconds = options.seconds > 0.0 ? options.seconds : 3600.0;
  const int total = static_cast<int>(std::lround(60.0 * seconds)), settle = 120;
  for (int f = 1; f <= settle; ++f) simulation.advance_to_frame(f, {});
  const double start = energy(simulation.state(), mass);
  const Vec3 place = centre(simulation.state());
  double most = start, fastest = 0.0;
  const Stopwatch clock;
  for (int f = settle + 1; f <= total; ++f)
    simulation.advance_to_frame(f, [&](double) {
      most = std::max(most, energy(simulation.state(), mass));
      for (const Vec3& v : simulation.state().v) fastest = std::max(fastest, v.norm());
    });
  fmt::print(
      "{:.0f} s at rest, {} steps: energy {:+.3e} J at most above the start, {:+.3e} J at the "
      "end (of {:.3e}), fastest {:.3e} m/s, moved {:.3e} m, clean {}; {:.1f} s\n",
      seconds, simulation.result().steps, most - start, energy(simulation.state(), mass) - start,
      start, fastest, (centre(simulation.state()) - place).norm(),
      simulation.result().clean ? "yes" : "NO", clock.seconds());
}

const std::map<std::string, std::function<void(const BenchOptions&)>>& cases() {
  static const std::map<std::string, std::function<void(const BenchOptions&)>> all = {
      {"sheet", sheet_case},     {"stack", stack_case},
      {"turned", turned_case},   {"ball", ball_case},
      {"incline", incline_case}, {"slide", slide_case},
      {"capstan", capstan_case}, {"creep", creep_case},
      {"hour", hour_case},       {"equilibrium", equilibrium_case},
      {"spread", spread_case}};
  return all;
}

}  // namespace
}  // namespace rest_bench

int bench_rest(int argc, char** argv) {
  using namespace rest_bench;
  BenchOptions options;
  CommandLine app("Rest and friction of the default contact");
  std::vector<std::string> names;
  for (const auto& [name, run] : cases()) names.push_back(name);
  app.option("cases", options.cases,
             "Names of cases (default: all except `creep`, `hour`, `equilibrium` and `spread`)")
      .one_of(names);
  app.option("--seconds", options.seconds, "Simulated time, s").non_negative();
  app.option("--steps-per-frame", options.steps_per_frame, "Steps of a frame of 1/60 s").positive();
  app.option("--tolerance", options.tolerance, "Tolerance of the linear solve");
  app.option("--cells", options.cells, "Cells per side").non_negative();
  app.option("--threads", options.threads, "Maximum number of threads").non_negative();
  app.flag("--verbose", options.verbose, "Print each frame of a case");
  if (const auto code = app.parse(argc, argv)) return *code;
  const ThreadLimit limit(options.threads);
  if (options.cases.empty())
    for (const auto& name : names)
      if (name != "creep" && name != "hour" && name != "equilibrium" && name != "spread")
        options.cases.push_back(name);
  for (const std::string& name : options.cases) {
    cases().at(name)(options);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace selvedge
