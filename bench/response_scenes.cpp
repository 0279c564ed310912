// SPDX-License-Identifier: MIT
#include "response_scenes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>

#include "rest_scenes.h"

namespace selvedge::bench {
namespace {

using std::numbers::pi;
constexpr double kRestGap = 0.002;

// Just outside the rest gap, so that no contact starts too close.
constexpr double kAbove = 1.01 * kRestGap;

Scene scene_of(double friction) {
  Scene scene;
  scene.name = "response";
  scene.materials["default"] = Material{};
  scene.materials["default"].friction = friction;
  scene.contact.rest_gap = kRestGap;
  return scene;
}

void add_sheet(Scene& scene, double size, int cells, const Vec3& where) {
  ClothSpec sheet;
  sheet.name = "sheet" + std::to_string(scene.cloths.size());
  sheet.shape = ClothGrid{"rectangular", {size, size, cells, cells}, {}};
  sheet.placement.translation = where;
  scene.cloths.push_back(sheet);
}

BodySpec& add_body(Scene& scene, const AnalyticShape& shape, const Vec3& where, int resolution,
                   double friction) {
  BodySpec body;
  body.name = "body" + std::to_string(scene.bodies.size());
  body.shape = BodyShape{shape, resolution};
  body.placement.translation = where;
  body.friction = friction;
  scene.bodies.push_back(body);
  return scene.bodies.back();
}

// Resolution of boxes. It does not affect the result but must be set.
constexpr int kBoxResolution = 3;

double mean(const std::vector<Vec3>& values, int axis) {
  double sum = 0.0;
  for (const Vec3& v : values) sum += v[axis];
  return sum / static_cast<double>(values.size());
}

// On a slope of 30 degrees. The floor is horizontal and gravity is tilted instead.
ResponseCase incline(int cells, double friction) {
  ResponseCase c;
  c.scene = scene_of(friction);
  c.scene.gravity = kGravity * Vec3(0.5, 0.0, -std::sqrt(0.75));
  add_sheet(c.scene, 0.2, cells, Vec3(-0.3, 0.0, kAbove));
  add_body(c.scene, Box{Vec3(2.0, 1.0, 0.1)}, Vec3(0, 0, -0.05), kBoxResolution, friction);
  c.warm_up = 6;
  c.frames = 36;
  return c;
}

}  // namespace

ResponseCase ball(int cells) {
  ResponseCase c;
  c.name = "ball";
  c.scene = scene_of(0.3);
  add_sheet(c.scene, 0.6, cells, Vec3(0.02, 0.01, 0.205));
  add_body(c.scene, Sphere{0.2}, Vec3::Zero(), 32, 0.3);
  return c;
}

ResponseCase table(int cells) {
  ResponseCase c;
  c.name = "table";
  c.scene = scene_of(0.3);
  add_sheet(c.scene, 0.6, cells, Vec3(0.02, 0.01, 0.105));
  add_body(c.scene, Cylinder{0.18, 0.2}, Vec3::Zero(), 48, 0.3);
  return c;
}

ResponseCase incline_sliding(int cells) {
  ResponseCase c = incline(cells, 0.3);
  c.name = "incline, slides";
  c.unit = "%";
  const double seconds = (c.frames - c.warm_up) / c.scene.time.fps;
  c.error = [seconds](const SimulationState& from, const SimulationState& to) {
    const double expected = kGravity * (0.5 - 0.3 * std::sqrt(0.75));
    return 100.0 * ((mean(to.v, 0) - mean(from.v, 0)) / seconds / expected - 1.0);
  };
  return c;
}

ResponseCase incline_sticking(int cells) {
  ResponseCase c = incline(cells, 0.6);
  c.name = "incline, sticks";
  c.unit = "mm/s";
  const double seconds = (c.frames - c.warm_up) / c.scene.time.fps;
  c.error = [seconds](const SimulationState& from, const SimulationState& to) {
    return 1e3 * (mean(to.x, 0) - mean(from.x, 0)) / seconds;
  };
  return c;
}

ResponseCase capstan(double share) {
  constexpr double radius = 0.05, mu = 0.3, light = 0.05, density = 0.5;
  constexpr double hang = 0.2, width = 0.02;
  const double hanging = density * width * hang;  // kg that hang on each side with the load
  const double heavy = share * std::exp(mu * pi) * (light + hanging) - hanging;
  constexpr int along = 40, across = 1;
  ResponseCase c;
  c.name = share < 1.0 ? "capstan, holds" : "capstan, slips";
  c.unit = "mm/s";
  c.scene = scene_of(mu);
  c.scene.solver.tolerance = 1e-6;  // heavy loads on light cloth
  Material& m = c.scene.materials["default"];
  m.density = density;
  m.spring_damping = 0.02;  // s; damps the swinging of the loads on the strip
  m.stretch_stiffness = 2000.0;
  m.bending_stiffness = 1e-7;
  const double r = radius + kAbove, length = pi * r + 2.0 * hang;
  ClothSpec strip;
  strip.name = "strip";
  ClothGrid grid{"rectangular", {length, width, along, across}, {}};
  constexpr int samples = 24;
  grid.path.points.emplace_back(-r, 0, -hang);
  grid.path.points.emplace_back(-r, 0, -0.5 * hang);
  for (int k = 0; k <= samples; ++k) {
    const double angle = pi * k / samples;
    grid.path.points.emplace_back(-r * std::cos(angle), 0, r * std::sin(angle));
  }
  grid.path.points.emplace_back(r, 0, -0.5 * hang);
  grid.path.points.emplace_back(r, 0, -hang);
  strip.shape = grid;
  c.scene.cloths.push_back(strip);
  add_body(c.scene, Cylinder{radius, 0.1}, Vec3::Zero(), 256, mu).placement.rotation =
      Eigen::AngleAxisd(0.5 * pi, Vec3::UnitX());
  c.added_mass.assign((along + 1) * (across + 1), 0.0);
  std::vector<std::size_t> left, right;
  for (int j = 0; j <= across; ++j) {
    left.push_back(j * (along + 1));
    right.push_back(left.back() + along);
    c.added_mass[left.back()] = light / (across + 1);
    c.added_mass[right.back()] = heavy / (across + 1);
  }
  c.warm_up = 12;  // the strip first stretches and swings
  c.frames = 24;
  const double seconds = (c.frames - c.warm_up) / c.scene.time.fps;
  c.error = [=](const SimulationState& from, const SimulationState& to) {
    double up = 0.0;
    for (const std::size_t i : left) up += (to.x[i] - from.x[i]).z();
    return 1e3 * up / (seconds * static_cast<double>(left.size()));
  };
  return c;
}

ResponseCase stack(int sheets, int cells) {
  ResponseCase c;
  c.name = "stack of " + std::to_string(sheets);
  c.scene = scene_of(0.3);
  for (int k = 0; k < sheets; ++k)
    add_sheet(c.scene, 0.2, cells, Vec3(0.002 * k, 0.001 * k, kRestGap * (2.0 + 1.5 * k)));
  add_body(c.scene, Box{Vec3(1.0, 1.0, 0.1)}, Vec3(0, 0, -0.05), kBoxResolution, 0.3);
  return c;
}

ResponseCase drop(int cells) {
  constexpr double height = 0.2;
  ResponseCase c;
  c.name = "drop";
  c.unit = "%";
  c.scene = scene_of(0.3);
  add_sheet(c.scene, 0.2, cells, Vec3(0, 0, height + kRestGap));
  add_body(c.scene, Box{Vec3(1.0, 1.0, 0.1)}, Vec3(0, 0, -0.05), kBoxResolution, 0.3);
  c.warm_up = 13;  // the impact is at 0.2019 s, in the thirteenth frame
  c.frames = 40;
  c.error = [](const SimulationState& from, const SimulationState&) {
    const double up = std::max(0.0, mean(from.v, 2));
    return 100.0 * up * up / (2.0 * kGravity * height);
  };
  return c;
}

ResponseRun run(ResponseCase c, const std::string& response, const MethodOptions& options) {
  c.scene.contact.response = response;
  c.scene.contact.response_options = options;
  BuiltScene built = build_scene(c.scene);
  for (std::size_t i = 0; i < c.added_mass.size(); ++i) built.cloth.mass[i] += c.added_mass[i];
  Simulation simulation(c.scene, std::move(built));
  ResponseRun run;
  SimulationState from = simulation.state();
  const std::clock_t start = std::clock();
  try {
    simulation.advance_to_frame(c.warm_up, {});
    from = simulation.state();
    simulation.advance_to_frame(c.frames, {});
  } catch (const SimulationFailed& failed) {
    run.stopped = failed.what();
  }
  run.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  run.result = simulation.result();
  run.x = simulation.state().x;
  if (c.error) run.error = c.error(from, simulation.state());
  double sum = 0.0;
  for (const Vec3& v : simulation.state().v) sum += v.squaredNorm();
  run.rms_speed = std::sqrt(sum / static_cast<double>(run.x.size()));
  return run;
}

}  // namespace selvedge::bench
