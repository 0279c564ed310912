// SPDX-License-Identifier: MIT
// Compares all fail-safes: first alone on single steps (share of the step kept, rounds, time,
// remaining sliding and energy), then in whole scenes. Prints two tables in Markdown.
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/judge/judge.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/tests/fail_safe_trial.h>

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "bench.h"

namespace selvedge {
namespace fail_safe_bench {
namespace {

namespace fs = std::filesystem;

struct Case {
  std::string name;
  Scene scene;
  int frames = 0;
  double slide = 0.0;  // m/s along x at the end by Coulomb's law; 0: not measured
};

struct BenchOptions {
  std::vector<std::string> only, fail_safes;
  bool judged = true, steps = true, scenes = true;
  double seconds = 60.0;  // limit for one run
};

constexpr double kFallSpeed = 10.0, kSlideSpeed = 5.0, kFriction = 0.3, kGravity = 9.81;

Scene stack(int sheets, int cells, double slide) {
  Scene scene;
  scene.materials["default"] = Material{};
  scene.materials["default"].friction = kFriction;
  for (int k = 0; k < sheets; ++k) {
    ClothSpec sheet;
    sheet.name = "sheet" + std::to_string(k);
    sheet.shape = ClothGrid{"rectangular", {0.2, 0.2, cells, cells}, {}};
    sheet.placement.translation = Vec3(0.003 * k, 0.002 * k, 0.01 + 0.003 * k);
    sheet.placement.rotation = Eigen::AngleAxisd(0.2 * k, Vec3::UnitZ());
    sheet.velocity = Vec3(slide, 0.0, -kFallSpeed);
    scene.cloths.push_back(sheet);
  }
  BodySpec floor;
  floor.name = "floor";
  floor.shape = BodyShape{Box{Vec3(10, 10, 0.005)}, 16};
  floor.friction = kFriction;
  scene.bodies.push_back(floor);
  return scene;
}

// Remaining sideways speed by Coulomb's law after the floor has stopped the fall, one frame before
// `frames`. The impulse that stops the fall and the weight each cause friction of mu times their
// size.
double coulomb_slide(int frames, double fps) {
  return kSlideSpeed - kFriction * (kFallSpeed + kGravity * frames / fps);
}

Case from_file(const char* file, int frames) {
  const fs::path path = fs::path(SELVEDGE_SOURCE_DIR) / "data" / file;
  return {path.stem().string(), read_scene(path), frames, 0.0};
}

std::vector<Case> cases() {
  std::vector<Case> list;
  list.push_back({"stack of 12 at 10 m/s", stack(12, 4, 0.0), 20, 0.0});
  list.push_back({"the same, 16 x 16 cells", stack(12, 16, 0.0), 20, 0.0});
  list.push_back({"one sheet, 5 m/s sideways", stack(1, 12, kSlideSpeed), 6, coulomb_slide(6, 60)});
  list.push_back({"8 sheets, 5 m/s sideways", stack(8, 6, kSlideSpeed), 6, coulomb_slide(6, 60)});
  list.push_back(from_file("extreme/s10_fast_sphere.json", 40));
  list.push_back(from_file("extreme/s07_twist.json", 240));
  list.push_back(from_file("extreme/s06_ring_5cm.json", 90));
  list.push_back(from_file("extreme/pinch.json", 120));
  list.push_back(from_file("extreme/pinch_and_go.json", 120));
  return list;
}

struct Row {
  RunResult result;
  std::string stopped;
  double wall = 0.0, sliding = 0.0;
  std::size_t wrong = 0;  // crossings and collisions found by the judge
};

TriangleMesh mesh(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  return {{x.begin(), x.end()}, {triangles.begin(), triangles.end()}};
}

double mean_x(const std::vector<Vec3>& v) {
  double sum = 0.0;
  for (const Vec3& u : v) sum += u.x();
  return sum / static_cast<double>(v.size());
}

class Judged {
 public:
  explicit Judged(const Simulation& simulation) : simulation_(simulation) { now(last_, body_); }
  std::size_t wrong() {
    TriangleMesh cloth, body;
    now(cloth, body);
    const PathVerdict path = judge_path(last_, cloth.vertices, body_, body.vertices);
    std::swap(last_, cloth);
    std::swap(body_, body);
    return path.self_collisions + path.body_collisions;
  }

 private:
  void now(TriangleMesh& cloth, TriangleMesh& body) const {
    cloth = mesh(simulation_.state().x, simulation_.cloth_triangles());
    body = mesh(simulation_.body_positions(), simulation_.body_triangles());
  }
  const Simulation& simulation_;
  TriangleMesh last_, body_;
};

Row run(Scene scene, int frames, const std::string& fail_safe, const BenchOptions& options) {
  scene.contact.fail_safe = fail_safe;
  Simulation simulation(scene, build_scene(scene));
  Judged judged(simulation);
  Row row;
  double aside = 0.0;  // s, of the judge
  const auto clock = [] { return std::chrono::steady_clock::now(); };
  const auto start = clock();
  try {
    for (int frame = 1; frame <= frames; ++frame) {
      simulation.advance_to_frame(frame, [&](double) {
        if (!options.judged) return;
        const auto t = clock();
        row.wrong += judged.wrong();
        aside += seconds_since(t);
      });
      if (seconds_since(start) - aside > options.seconds) {
        row.stopped = fmt::format("time, frame {} of {}", frame, frames);
        break;
      }
    }
  } catch (const SimulationFailed& failed) {
    row.stopped = failed.what();
  }
  row.wall = seconds_since(start) - aside;
  row.result = simulation.result();
  row.sliding = mean_x(simulation.state().v);
  return row;
}

void print(const Case& c, const std::string& name, Row& row) {
  const auto count = [&](const char* key) {
    const auto at = row.result.counters.find(key);
    return at == row.result.counters.end() ? 0.0 : at->second;
  };
  const auto phase = [&](const char* key) {
    const auto at = row.result.phase_s.find(key);
    return at == row.result.phase_s.end() ? 0.0 : at->second;
  };
  const double rounds = count("impulse_passes") + count("projection_rounds") +
                        count("zone_rounds") + count("plane_rounds") + count("bound_rounds");
  fmt::print("| {} | {} | {} | {} | {:.0f} | {:.2f} | {:.2f} | {:.2f} | {} | {} |\n", c.name, name,
             row.result.steps, row.result.halvings, rounds, row.wall, phase("repair"),
             row.result.final_max_speed,
             c.slide > 0.0 ? fmt::format("{:.2f} of {:.2f}", row.sliding, c.slide) : "",
             row.wrong             ? fmt::format("**{} wrong**", row.wrong)
             : row.stopped.empty() ? "clean"
                                   : row.stopped);
  std::fflush(stdout);
}

struct StepCase {
  std::string name;
  std::vector<Stage> stages;
};

// The displacement of a sheet that moves down and sideways at 12 m/s for one step; in a swarm all
// triangles meet.
std::vector<StepCase> step_cases() {
  constexpr unsigned kSwarms = 20;
  const Vec3 oblique(0.1, 0.0, -0.1);
  std::vector<StepCase> list;
  for (const int sheets : {1, 4, 12}) {
    list.push_back({fmt::format("{} sheets on a plate", sheets), {}});
    list.back().stages.push_back(falling_sheets(sheets, 10, oblique));
    list.back().stages.back().friction = kFriction;
  }
  list.push_back({fmt::format("{} swarms, free", kSwarms), {}});
  for (unsigned seed = 1; seed <= kSwarms; ++seed) list.back().stages.push_back(swarm(seed, 1.0));
  for (const bool moving : {false, true}) {
    list.push_back(
        {fmt::format("{} swarms, anchors {}", kSwarms, moving ? "moving" : "still"), {}});
    for (unsigned seed = 1; seed <= kSwarms; ++seed)
      list.back().stages.push_back(swarm_with_anchors(seed, 0.6, moving));
  }
  return list;
}

struct StepSum {
  double share = 0.0, rounds = 0.0, seconds = 0.0, energy = 0.0, momentum = 0.0, spin = 0.0;
  double sideways = 0.0, coulomb = 0.0;
  std::int64_t still = 0,
               hit = 0;  // particles that collide, and those of them that end without motion
};

void one_step(const Stage& stage, FailSafe& fail_safe, StepSum& sum) {
  Trial trial(stage);
  double share = 1.0;
  for (int rounds = -1; share > 0.0; share = share > 1e-3 ? 0.5 * share : 0.0) {
    trial.aim(share);
    const auto start = std::chrono::steady_clock::now();
    rounds = trial.resolve(fail_safe);
    sum.seconds += seconds_since(start);
    if (rounds < 0) continue;
    sum.rounds += rounds;
    break;
  }
  const std::vector<Vec3> end = trial.x_t1;
  const double energy = trial.energy();
  const Vec3 momentum = trial.momentum(), spin = trial.angular_momentum();
  const Vec3 mean = mean_move(trial, stage.n());
  trial.aim(share);
  const Vec3 wish = mean_move(trial, stage.n());
  sum.share += share;
  sum.energy += energy / trial.energy();
  sum.momentum = std::max(sum.momentum, (momentum - trial.momentum()).norm() / momentum.norm());
  sum.spin = std::max(sum.spin, (spin - trial.angular_momentum()).norm() / spin.norm());
  // The plate removes the missing part of the fall, and friction removes mu times that from the
  // sliding.
  sum.sideways += mean.x() / wish.x();
  sum.coulomb += 1.0 - stage.friction * (mean.z() - wish.z()) / wish.x();
  std::set<std::int32_t> particles;
  for (const ContactPoint& c : trial.hits) particles.insert(c.vertex.begin(), c.vertex.end());
  for (const std::int32_t i : particles)
    if (trial.inv_mass[i] > 0.0) ++sum.hit, sum.still += end[i] == trial.x_t0[i] ? 1 : 0;
}

void print_steps(const BenchOptions& options) {
  const auto all = fail_safes();
  fmt::print(
      "| one step | fail-safe | of the step | rounds | ms | energy left | momentum lost | spin "
      "lost | "
      "at rest | sideways left | by Coulomb |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const StepCase& c : step_cases())
    for (const std::string& name : options.fail_safes) {
      const auto fail_safe = all.at(name)();
      StepSum sum;
      for (const Stage& stage : c.stages) one_step(stage, *fail_safe, sum);
      const double n = static_cast<double>(c.stages.size());
      const bool free = c.stages[0].body.vertices.empty(),
                 sheets = c.stages[0].held.empty() && !free;
      fmt::print("| {} | {} | {:.2f} | {:.1f} | {:.2f} | {:.3f} | {} | {} | {:.0f} % | {} | {} |\n",
                 c.name, name, sum.share / n, sum.rounds / n, 1e3 * sum.seconds / n, sum.energy / n,
                 free ? fmt::format("{:.0e}", sum.momentum) : "",
                 free ? fmt::format("{:.0e}", sum.spin) : "",
                 100.0 * static_cast<double>(sum.still) / static_cast<double>(sum.hit),
                 sheets ? fmt::format("{:.3f}", sum.sideways) : "",
                 sheets ? fmt::format("{:.3f}", sum.coulomb) : "");
    }
  fmt::print("\n");
}

BenchOptions parse(int argc, char** argv, const std::vector<Case>& all) {
  BenchOptions options;
  CommandLine app("All fail-safes on scenes that need one");
  app.option("--case", options.only, "Only cases whose name contains this");
  app.option("--fail-safe", options.fail_safes, "Names of fail-safes (default: all)");
  app.option("--seconds", options.seconds, "Time limit of one run, s");
  app.flag("!--unjudged", options.judged, "Omit the exact check");
  app.flag("!--no-steps", options.steps, "Omit the single steps");
  app.flag("!--no-scenes", options.scenes, "Omit the scenes");
  std::string names = "Cases:";
  for (const Case& c : all) names += "\n  " + c.name;
  app.footer(names);
  if (const auto code = app.parse(argc, argv)) std::exit(*code);
  return options;
}

}  // namespace
}  // namespace fail_safe_bench

int bench_fail_safe(int argc, char** argv) {
  using namespace fail_safe_bench;
  const std::vector<Case> all = cases();
  BenchOptions options = parse(argc, argv, all);
  if (options.fail_safes.empty())
    for (const auto& [name, make] : fail_safes()) options.fail_safes.push_back(name);
  if (options.steps) print_steps(options);
  if (!options.scenes) return 0;
  fmt::print(
      "| scene | fail-safe | steps | halvings | rounds | s | s in response | "
      "fastest "
      "at the end, m/s | sliding, m/s | verdict "
      "|\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Case& c : all) {
    if (!options.only.empty() &&
        std::none_of(options.only.begin(), options.only.end(),
                     [&](const auto& o) { return c.name.find(o) != std::string::npos; }))
      continue;
    for (const std::string& name : options.fail_safes) {
      Row row = run(c.scene, c.frames, name, options);
      print(c, name, row);
    }
  }
  return 0;
}

}  // namespace selvedge
