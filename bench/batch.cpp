// SPDX-License-Identifier: MIT
// Many scenes stepped together: steps per second beside one scene on one core, and memory. Both
// take turns in rounds, so that a disturbance of the machine affects both; the figures are medians
// of the ratios of the rounds. Where other programs use the machine, the ratio of processor times
// is the one to read: it has no waiting in it.
#include "bench.h"

#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/batch.h>
#include <selvedge/simulation/simulation.h>

#include <fmt/core.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {
namespace batch_bench {
namespace {

Scene sheet_over_ball(int cells) {
  Scene scene;
  scene.materials["default"] = {.density = 0.15, .bending_stiffness = 2e-5};
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.shape =
      ClothGrid{.grid = {.size_x = 0.5, .size_y = 0.5, .cells_x = cells, .cells_y = cells}};
  cloth.placement.translation = {0.0, 0.0, 0.22};
  scene.bodies.emplace_back().shape = BodyShape{Sphere{.radius = 0.2}, 24};
  scene.time.frames = 600;
  return scene;
}

/// MB that are resident.
double resident() {
  std::ifstream in("/proc/self/statm");
  double pages = 0.0, resident = 0.0;
  in >> pages >> resident;
  return resident * 4096.0 / 1e6;
}

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Rate {
  double wall = 0.0, processor = 0.0;  // s per step
};

template <class Act>
Rate rate(double steps, Act act) {
  const Stopwatch watch;
  const double begin = processor_s();
  act();
  return {watch.seconds() / steps, (processor_s() - begin) / steps};
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

}  // namespace
}  // namespace batch_bench

int bench_batch(int argc, char** argv) {
  using namespace batch_bench;
  int members = 32, cells = 29, rounds = 7, frames = 5;
  CommandLine app("Many scenes stepped together beside one scene on one core");
  app.option("--members", members, "Scenes of the batch").range(3, 100000).show_default();
  app.option("--cells", cells, "Cells along a side of each sheet").range(1, 1000).show_default();
  app.option("--rounds", rounds, "Rounds").range(1, 1000).show_default();
  app.option("--frames", frames, "Frames of each member in a round").range(1, 100).show_default();
  if (const auto code = app.parse(argc, argv)) return *code;

  const auto scene = std::make_shared<const Scene>(sheet_over_ball(cells));
  constexpr int first = 20;  // the sheet lies on the ball
  std::optional<Batch> batch;
  batch.emplace(std::vector<std::shared_ptr<const Scene>>(2, scene));
  batch->advance(first);
  const double two = resident();
  batch.emplace(
      std::vector<std::shared_ptr<const Scene>>(static_cast<std::size_t>(members), scene));
  batch->advance(first);
  fmt::print("memory of each further member: {:.2f} MB\n", (resident() - two) / (members - 2));

  Simulation single(*scene);
  const MemberState start = batch->save(0);
  std::vector<double> wall, processor;
  for (int round = 0; round < rounds; ++round) {
    Rate one, all;
    {
      const ThreadLimit limit(1);
      single.restore(start.state);
      one = rate(1.0, [&] { single.advance_to_frame(single.frame() + frames); });
    }
    for (std::size_t k = 0; k < batch->size(); ++k) batch->restore(k, start);
    all = rate(members, [&] { batch->advance(frames); });
    wall.push_back(one.wall / all.wall);
    processor.push_back(one.processor / all.processor);
  }
  const int threads = thread_count();
  fmt::print(
      "members {}, threads {}: {:.2f} x one scene on one core by the clock = {:.3f} x threads; "
      "processor time {:.3f} of its per step\n",
      members, threads, median(wall), median(wall) / threads, 1.0 / median(processor));
  return 0;
}

}  // namespace selvedge
