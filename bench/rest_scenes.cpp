// SPDX-License-Identifier: MIT
#include "rest_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace selvedge::bench {

Scene empty_scene(const BenchOptions& options) {
  Scene scene;
  scene.name = "rest";
  scene.materials["default"] = Material{};
  scene.time.steps_per_frame = options.steps_per_frame;
  scene.solver.tolerance = options.tolerance;
  return scene;
}

ClothSpec sheet(double size, int cells, const Vec3& where) {
  ClothSpec spec;
  spec.name = "sheet";
  spec.shape = ClothGrid{"rectangular", {size, size, cells, cells}};
  spec.placement.translation = where;
  return spec;
}

BodySpec body(const AnalyticShape& shape, int resolution) {
  BodySpec spec;
  spec.name = "body";
  spec.shape = BodyShape{shape, resolution};
  return spec;
}

double total_mass(const BuiltScene& built) {
  double sum = 0.0;
  for (const double m : built.cloth.mass) sum += m;
  return sum;
}

Scene incline_scene(const BenchOptions& options, double mu, double angle) {
  Scene scene = empty_scene(options);
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(-angle, Vec3::UnitY()));
  scene.cloths.push_back(sheet(0.2, 8, tilt * Vec3(0.031, 0.017, 0.002)));
  scene.cloths[0].placement.rotation = tilt;
  scene.bodies.push_back(body(Plane{20.0}));
  scene.bodies[0].placement.rotation = tilt;
  scene.bodies[0].friction = mu;
  return scene;
}

Scene jaws_scene(const BenchOptions& options, double load, double press) {
  Scene scene = empty_scene(options);
  Material& m = scene.materials["default"];
  m.density = 0.2;
  m.stretch_stiffness = 3000.0;
  m.bending_stiffness = 1e-5;
  m.spring_damping = m.bending_damping = 0.02;
  constexpr int kAcross = 8, kAlong = 24;
  ClothSpec strip = sheet(1.0, 1, Vec3::Zero());
  strip.shape = ClothGrid{"rectangular", {0.04, 0.12, kAcross, kAlong}};
  strip.placement.rotation = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX());
  scene.cloths.push_back(strip);
  HandleSpec top{"top", strip.name, {}, {}, 0.6};
  WeightSpec weight{"load", strip.name, {}, load / (kAcross + 1)};
  for (std::int32_t i = 0; i <= kAcross; ++i) {
    top.vertices.push_back(kAlong * (kAcross + 1) + i);
    weight.vertices.push_back(i);
  }
  scene.handles.push_back(top);
  scene.weights.push_back(weight);
  for (const double side : {1.0, -1.0}) {
    BodySpec jaw = body(Box{{0.06, 0.02, 0.03}}, 3);
    jaw.name = side > 0.0 ? "front" : "back";
    jaw.friction = 0.5;
    jaw.placement.translation = Vec3(0.0, side * 0.016, 0.045);
    Keyframe closed;
    closed.time = 0.4;
    closed.translation = Vec3(0.0, -side * (0.004 + press), 0.0);
    jaw.motion = {Keyframe{}, closed};
    scene.bodies.push_back(jaw);
  }
  return scene;
}

Capstan capstan(const BenchOptions& options, double ratio, double mu, int resolution,
                double stretch) {
  Capstan c;
  c.scene = empty_scene(options);
  Material& m = c.scene.materials["default"];
  m.density = 0.02;
  m.stretch_stiffness = stretch;
  m.shear_stiffness = 20.0;
  m.bending_stiffness = 1e-7;
  c.scene.contact.rest_gap = 0.002;
  c.scene.contact.self = false;
  const double radius = 0.1;
  const int along = options.cells > 0 ? options.cells : 120, across = kCapstanAcross;
  const double length = std::numbers::pi * (radius + 0.002) + 1.0;
  ClothSpec spec = sheet(1.0, 1, Vec3::Zero());
  spec.shape = ClothGrid{"rectangular", {length, 0.04, along, across}};
  c.scene.cloths.push_back(spec);
  c.scene.bodies.push_back(body(Cylinder{radius, 0.3}, resolution));
  c.scene.bodies[0].friction = mu;
  c.scene.bodies[0].placement.rotation = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX());
  c.built = build_scene(c.scene);
  // Start around the cylinder: a half circle at radius + rest gap, then straight down.
  const double r = radius + 0.0021;
  for (Vec3& x : c.built.cloth.surface.vertices) {
    const double s = x.x(), half = 0.5 * std::numbers::pi * r;
    const double angle = std::clamp(s / r, -0.5 * std::numbers::pi, 0.5 * std::numbers::pi);
    x = Vec3(r * std::sin(angle), x.y(), r * std::cos(angle) - std::max(0.0, std::abs(s) - half));
  }
  const double load = kCapstanLoad / (across + 1);
  for (int j = 0; j <= across; ++j) {
    c.left.push_back(j * (along + 1));
    c.right.push_back(j * (along + 1) + along);
    c.built.cloth.mass[c.left.back()] += load;
    c.built.cloth.mass[c.right.back()] += ratio * load;
  }
  return c;
}

}  // namespace selvedge::bench
