// SPDX-License-Identifier: MIT
#include "rest_scenes.h"

#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <utility>

namespace selvedge::bench {
namespace {

/// Contact forces of the last step.
struct ContactSums {
  double normal = 0.0, limit = 0.0, tangential = 0.0;  // N: ΣN, Σ μN, Σ |T|
};

ContactSums contact_sums(const Simulation& simulation) {
  ContactSums sums;
  const double h = simulation.last_step().lengths.back();
  for (const StepContact& c : simulation.contacts()) {
    const double normal = c.point.normal.dot(c.impulse);
    sums.normal += normal / h;
    sums.limit += c.point.friction * normal / h;
    sums.tangential += (c.impulse - normal * c.point.normal).norm() / h;
  }
  return sums;
}

constexpr double kSettle = 20.0;  // s, until loads that swing have come to rest

/// A row of the table: how far the particles that touch move along the surfaces, on average and at
/// most, once the loads have come to rest. `pull`: N, tangential load; negative: Σ |T|.
void creep_row(const std::string& name, const Scene& scene, BuiltScene built, double pull,
               const BenchOptions& options) {
  Simulation simulation(scene, std::move(built));
  simulation.advance_to_frame(static_cast<int>(std::lround(kSettle * scene.time.fps)));
  const std::vector<Vec3> start = simulation.state().x;
  const auto n = static_cast<std::int32_t>(start.size());
  std::map<std::int32_t, Vec3> normals;  // of the particles that touch
  for (const StepContact& c : simulation.contacts())
    for (const std::int32_t i : c.point.vertex)
      if (i < n && !c.impulse.isZero(0.0)) normals[i] = c.point.normal;
  const ContactSums sums = contact_sums(simulation);
  const double seconds = options.seconds > 0.0 ? options.seconds : 60.0;
  simulation.advance_to_frame(static_cast<int>(std::lround((kSettle + seconds) * scene.time.fps)));
  Vec3 mean = Vec3::Zero();
  double most = 0.0;
  for (const auto& [i, normal] : normals) {
    const Vec3 way = simulation.state().x[i] - start[i];
    const Vec3 slip = way - normal.dot(way) * normal;
    mean += slip / static_cast<double>(normals.size());
    most = std::max(most, slip.norm());
  }
  const RunResult result = simulation.result();
  fmt::print("| {} | {} | {:.4f} | {:.4f} | {:.1f} % | {:.4f} | {:.4f} | {:.2f} |\n", name,
             scene.time.steps_per_frame, sums.normal, sums.limit,
             100.0 * (pull < 0.0 ? sums.tangential : pull) / sums.limit,
             1e6 * mean.norm() / seconds, 1e6 * most / seconds,
             result.counters.at("solves") / result.steps);
  std::fflush(stdout);
}

}  // namespace

// At the default steps and at shorter ones. Contacts are stiffer in shorter steps; there the jaws
// press less, so that they hold with the same force.
void creep_case(const BenchOptions& options) {
  fmt::print(
      "| scene | steps a frame | ΣN, N | Σ μN, N | load / Σ μN | mean slip, µm/s | largest, µm/s | "
      "solves a step |\n|---|--:|--:|--:|--:|--:|--:|--:|\n");
  for (const int finer : {1, 4}) {
    BenchOptions with = options;
    with.steps_per_frame = finer * options.steps_per_frame;
    const double press = finer == 1 ? 0.0008 : 0.000025;
    for (const double load : {0.002, 0.01, 0.02, 0.03, 0.038, 0.042, 0.043}) {
      const Scene scene = jaws_scene(with, load, press);
      BuiltScene built = build_scene(scene);
      const double pull = kGravity * total_mass(built);
      creep_row(fmt::format("strip in jaws, {:.3g} g", 1e3 * load), scene, std::move(built), pull,
                with);
    }
    for (const double ratio : {1.5, 2.0, 2.3, 2.4, 2.45}) {
      Capstan c = capstan(with, ratio, 0.3, 128, 2000.0);
      creep_row(fmt::format("capstan, loads 1:{}", ratio), c.scene, std::move(c.built), -1.0, with);
    }
    const Scene slope = incline_scene(with, 0.6, std::numbers::pi / 6.0);
    creep_row("slope of 30 degrees, friction 0.6", slope, build_scene(slope), -1.0, with);
  }
}

}  // namespace selvedge::bench
