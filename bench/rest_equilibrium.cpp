// SPDX-License-Identifier: MIT
#include "rest_scenes.h"

#include <selvedge/core/base/parallel.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <string>
#include <vector>

namespace selvedge::bench {
namespace {

double potential(const Simulation& simulation) {
  double sum = 0.0;
  for (const auto& [name, energy] : simulation.energies())
    if (name != "kinetic") sum += energy;
  return sum;
}

/// A way to the equilibrium.
struct Way {
  const char* name;
  const char* integrator;
  bool until_rest;  // with contact forces and solves that are exact near the end
};

constexpr Way kWays[] = {{"dynamics", "implicit_blend", false},
                         {"dynamics, exact contacts", "implicit_blend", true},
                         {"quasi-static", "quasi_static", true}};

Scene scene_of(const std::string& name, const BenchOptions& options, const Way& way, int seed) {
  std::vector<Override> set{{"time.until", way.until_rest ? "rest" : "end"},
                            {"solver.integrator", way.integrator}};
  if (options.cells > 0)
    set.push_back({"geometry.0.cells", fmt::format("[{0},{0}]", options.cells)});
  if (seed > 0) {
    set.push_back({"perturbation.speed", "0.001"});
    set.push_back({"perturbation.seed", std::to_string(seed)});
  }
  return read_scene(SELVEDGE_SOURCE_DIR "/data/scenes/" + name + ".json", set);
}

/// Residual against time, a row every half second, until the cloth is at rest.
void residual_rows(const std::string& name, const BenchOptions& options, const Way& way) {
  const Scene scene = scene_of(name, options, way, 0);
  Simulation simulation(scene, build_scene(scene));
  const double length = options.seconds > 0.0 ? options.seconds : 10.0;
  const int frames = static_cast<int>(std::lround(length * scene.time.fps));
  const int part = static_cast<int>(std::lround(0.5 * scene.time.fps));
  double used = 0.0;
  for (int frame = 1; frame <= frames; ++frame) {
    const std::clock_t begin = std::clock();
    simulation.advance_to_frame(frame);
    const bool rests = way.until_rest && simulation.is_at_rest();
    used += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    if (frame % part != 0 && !rests) continue;
    const RestReport rest = simulation.rest();
    const RunResult result = simulation.result();
    fmt::print("| {} | {} | {} | {:.1f} | {:.0f} | {:.2g} | {:.2g} | {:.6f} | {} |\n", name,
               way.name, frame, used, result.counters.at("solves"), rest.unbalanced,
               1e3 * rest.max_speed, potential(simulation), result.clean ? "yes" : "NO");
    std::fflush(stdout);
    if (rests) return;
  }
}

/// The height of the cloth over a grid of places, seen from above; NaN where there is none.
std::vector<double> heights(const Simulation& simulation) {
  constexpr int kSide = 41;
  const auto x = simulation.positions();
  Vec3 low = x[0], high = x[0];
  for (const Vec3& p : x) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  constexpr double kReach = 0.6;  // m, of the scenes from their middle
  std::vector<double> height(kSide * kSide, std::nan(""));
  for (const Triangle& t : simulation.cloth_triangles()) {
    const Vec3 &a = x[t[0]], &b = x[t[1]], &c = x[t[2]];
    const double area = (b - a).head<2>().x() * (c - a).head<2>().y() -
                        (b - a).head<2>().y() * (c - a).head<2>().x();
    if (std::abs(area) < 1e-12) continue;
    const auto index = [&](double at) { return (at + kReach) / (2.0 * kReach) * (kSide - 1); };
    const int first_x = static_cast<int>(std::ceil(index(std::min({a.x(), b.x(), c.x()}))));
    const int last_x = static_cast<int>(std::floor(index(std::max({a.x(), b.x(), c.x()}))));
    const int first_y = static_cast<int>(std::ceil(index(std::min({a.y(), b.y(), c.y()}))));
    const int last_y = static_cast<int>(std::floor(index(std::max({a.y(), b.y(), c.y()}))));
    for (int i = std::max(0, first_x); i <= std::min(kSide - 1, last_x); ++i)
      for (int j = std::max(0, first_y); j <= std::min(kSide - 1, last_y); ++j) {
        const double px = -kReach + 2.0 * kReach * i / (kSide - 1) - a.x();
        const double py = -kReach + 2.0 * kReach * j / (kSide - 1) - a.y();
        const double s = (px * (c - a).y() - py * (c - a).x()) / area;
        const double r = ((b - a).x() * py - (b - a).y() * px) / area;
        if (s < 0.0 || r < 0.0 || s + r > 1.0) continue;
        const double z = a.z() + s * (b - a).z() + r * (c - a).z();
        double& h = height[static_cast<std::size_t>(i * kSide + j)];
        if (!(h >= z)) h = z;
      }
  }
  return height;
}

/// Root mean square of the difference where both have cloth, m.
double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) || std::isnan(b[i])) continue;
    sum += (a[i] - b[i]) * (a[i] - b[i]);
    count += 1.0;
  }
  return std::sqrt(sum / std::max(count, 1.0));
}

/// A shape at the end of a run.
struct End {
  double energy = 0.0, share = 0.0;  // J; of the area of the flat cloth that is seen from above
  std::vector<double> height;
};

End end_of(const std::string& name, const BenchOptions& options, const Way& way, int seed) {
  const Scene scene = scene_of(name, options, way, seed);
  Simulation simulation(scene, build_scene(scene));
  const double length = options.seconds > 0.0 ? options.seconds : 10.0;
  const int frames = static_cast<int>(std::lround(length * scene.time.fps));
  for (int frame = 1; frame <= frames; ++frame) {
    simulation.advance_to_frame(frame);
    if (way.until_rest && simulation.is_at_rest()) break;
  }
  End end{potential(simulation), 0.0, heights(simulation)};
  const auto& rest = simulation.built().rest;
  end.share = projected_area(simulation.positions(), simulation.cloth_triangles()) /
              surface_area(rest.vertices, rest.triangles);
  return end;
}

/// The ends of ten seeds, by dynamics and by quasi-static steps.
void spread_rows(const std::string& name, const BenchOptions& options) {
  constexpr int kSeeds = 10;
  std::vector<End> dynamic, fast;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    dynamic.push_back(end_of(name, options, kWays[0], seed));
    fast.push_back(end_of(name, options, kWays[2], seed));
  }
  const auto nearest = [&](const End& end, const End* own) {
    double least = 1e300;
    for (const End& other : dynamic)
      if (&other != own) least = std::min(least, apart(end.height, other.height));
    return least;
  };
  for (int seed = 0; seed < kSeeds; ++seed)
    fmt::print("| {} | {} | {:.6f} | {:.6f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} |\n", name,
               seed + 1, dynamic[seed].energy, fast[seed].energy, 100.0 * dynamic[seed].share,
               100.0 * fast[seed].share, 1e3 * nearest(dynamic[seed], &dynamic[seed]),
               1e3 * nearest(fast[seed], nullptr));
}

}  // namespace

void equilibrium_case(const BenchOptions& options) {
  fmt::print(
      "| scene | way | frame | processor time, s | solves | unbalanced | fastest, mm/s | potential "
      "energy, J | clean |\n|---|---|--:|--:|--:|--:|--:|--:|---|\n");
  for (const char* name : {"cloth_on_sphere", "round_table", "mannequin"})
    for (const Way& way : kWays) residual_rows(name, options, way);
}

void spread_case(const BenchOptions& options) {
  fmt::print(
      "| scene | seed | energy, dynamics, J | energy, quasi-static, J | area seen from above, "
      "dynamics, % | quasi-static, % | height to the nearest other dynamic end, dynamics, mm | "
      "quasi-static, mm |\n|---|--:|--:|--:|--:|--:|--:|--:|\n");
  for (const char* name : {"cloth_on_sphere", "round_table"}) spread_rows(name, options);
}

}  // namespace selvedge::bench
