// SPDX-License-Identifier: MIT
//
// Order of convergence of the implicit integrators in contact: a sheet of threads that its weight
// stretches down a smooth slope, and a sheet that slides down a slope with friction. Each row gives
// the error at 8 to 64 steps a frame, the order between the last two, and how far the limit of
// small steps is from the motion without contacts: along the slope both are the same.
//   bench order_in_contact [--markdown]
#include <selvedge/apps/command_line.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench.h"
#include "table.h"

namespace selvedge {
namespace order_in_contact_bench {
namespace {

constexpr double kSlope = 0.3;     // rad
constexpr double kFriction = 0.1;  // of the sheet that slides
constexpr int kCells = 4, kFrames = 8;
constexpr int kSteps[] = {8, 16, 32, 64}, kFinest = 256;

enum class Motion { stretched, slides };

/// The sheet lies on the slope if `lies`; else only what accelerates it along the slope acts.
Scene sheet(Motion motion, const std::string& integrator, int steps, bool lies) {
  Scene scene;
  scene.name = "slope";
  Material& soft = scene.materials["default"] = Material{};
  soft.stretch_stiffness = 4.0;
  soft.shear_stiffness = soft.bending_stiffness = 0.0;
  soft.spring_damping = soft.bending_damping = 0.0;
  scene.contact.self = false;
  scene.solver.strain_limiter = false;
  scene.solver.integrator = integrator;
  scene.solver.tolerance = 1e-12;
  scene.time.steps_per_frame = steps;
  scene.time.step_error = 0.0;
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(kSlope, Vec3::UnitY()));
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "sheet";
  cloth.shape = ClothGrid{"rectangular", {0.4, 0.4, kCells, kCells}};
  cloth.placement.rotation = tilt;
  cloth.placement.translation = tilt * Vec3(0.0, 0.0, 0.012);
  const bool held = motion == Motion::stretched;
  if (held) {
    HandleSpec& edge = scene.handles.emplace_back();
    edge.name = edge.geometry = "sheet";
    for (int j = 0; j <= kCells; ++j) edge.vertices.push_back((kCells + 1) * j);
  }
  const double mu = held ? 0.0 : kFriction;
  if (lies) {
    BodySpec& slope = scene.bodies.emplace_back();
    slope.name = "slope";
    slope.shape = BodyShape{Box{Vec3(2.0, 1.0, 0.02)}, 4};
    slope.placement.rotation = tilt;
    slope.friction = mu;
    return scene;
  }
  const Vec3 along = tilt * Vec3::UnitX(), across = tilt * Vec3::UnitZ();
  scene.gravity = (scene.gravity.dot(along) + mu * scene.gravity.dot(across)) * along;
  return scene;
}

/// Places along the slope, m.
std::vector<double> places(Motion motion, const std::string& integrator, int steps, bool lies) {
  Simulation simulation(sheet(motion, integrator, steps, lies));
  simulation.advance_to_frame(kFrames);
  const Vec3 along = Eigen::AngleAxisd(kSlope, Vec3::UnitY()) * Vec3::UnitX();
  std::vector<double> out;
  for (const Vec3& x : simulation.state().x) out.push_back(x.dot(along));
  return out;
}

double rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

void add_rows(Motion motion, bool lies, Table& table) {
  const std::vector<double> exact = places(motion, "runge_kutta_4", 96, false);
  for (const auto& [name, factory] : integrators()) {
    const IntegratorTraits traits = factory({}, 0, {})->traits();
    if (!traits.is_implicit || !traits.any_step || name == "quasi_static") continue;
    std::vector<std::string> row{motion == Motion::slides ? "slides" : "stretched",
                                 lies ? "yes" : "no", name};
    double coarser = 0.0, error = 0.0;
    for (const int steps : kSteps) {
      coarser = error;
      error = rms(places(motion, name, steps, lies), exact);
      row.push_back(fmt::format("{:.4f}", 1e3 * error));
    }
    row.push_back(fmt::format("{:.2f}", std::log2(coarser / error)));
    row.push_back(fmt::format("{:.4f}", 1e3 * rms(places(motion, name, kFinest, lies), exact)));
    table.add(row);
  }
}

}  // namespace
}  // namespace order_in_contact_bench

int bench_order_in_contact(int argc, char** argv) {
  using namespace order_in_contact_bench;
  CommandLine app("Order of convergence of the implicit integrators in contact");
  bool markdown = false;
  app.flag("--markdown", markdown, "Print the table in Markdown");
  if (const auto code = app.parse(argc, argv)) return *code;
  std::vector<std::string> head{"sheet", "in contact", "integrator"};
  for (const int steps : kSteps) head.push_back(fmt::format("mm at {} steps", steps));
  head.emplace_back("order");
  head.push_back(fmt::format("mm at {}", kFinest));
  Table table(head);
  for (const Motion motion : {Motion::stretched, Motion::slides})
    for (const bool lies : {false, true}) add_rows(motion, lies, table);
  fmt::print("{}", markdown ? table.markdown() : table.text());
  return 0;
}

}  // namespace selvedge
