// SPDX-License-Identifier: MIT
// What bodies, handles and held vertices feel, and the account of the momentum of the cloth.
#include <gtest/gtest.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/response/fail_safe.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <random>
#include <string>

namespace selvedge::wrench_test {
namespace {

constexpr double kMomentum = 1e-9;  // of the momenta exchanged, asked

/// A sheet that one side of it holds above a ball, or that falls onto it.
Scene sheet_scene(int cells = 8) {
  Scene scene;
  scene.materials["default"] = {
      .density = 0.15, .stretch_stiffness = 200.0, .bending_stiffness = 2e-5};
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "cloth";
  cloth.shape =
      ClothGrid{.grid = {.size_x = 0.4, .size_y = 0.4, .cells_x = cells, .cells_y = cells}};
  cloth.placement.translation = {0.01, 0.02, 0.22};
  scene.time.frames = 20;
  return scene;
}

void add_ball(Scene& scene) {
  BodySpec& ball = scene.bodies.emplace_back();
  ball.name = "ball";
  ball.shape = BodyShape{Sphere{.radius = 0.2}, 16};
}

void hold_corner(Scene& scene) {
  HandleSpec& handle = scene.handles.emplace_back();
  handle.name = "corner";
  handle.geometry = "cloth";
  handle.vertices = {0, 1};
}

Vec3 weight_of(const Simulation& simulation) {
  double mass = 0.0;
  for (const double m : simulation.mass()) mass += m;
  return Vec3(0.0, 0.0, -9.81 * mass);
}

double other(const StepWrenches& w, const char* name) {
  const auto found = w.others.find(name);
  return found == w.others.end() ? 0.0 : found->second.force.norm();
}

/// The size by which errors of forces are measured here, N.
double size_of(const Simulation& simulation, const StepWrenches& w) {
  double size = w.change.force.norm();
  for (std::size_t i = 0; i < simulation.mass().size(); ++i)
    size += simulation.mass()[i] * simulation.velocities()[i].norm() / w.h;
  for (const auto& [name, line] : w.others) size += line.force.norm();
  return size;
}

TEST(Wrenches, AreMeasuredOnRequestAlone) {
  Scene scene = sheet_scene();
  Simulation simulation(scene);
  EXPECT_FALSE(simulation.measures_wrenches());
  EXPECT_THROW(simulation.wrenches(), std::logic_error);
  simulation.measure_wrenches(true);
  simulation.step();
  EXPECT_EQ(simulation.wrenches().bodies.size(), 0u);
  EXPECT_GT(simulation.wrenches().h, 0.0);
}

TEST(Wrenches, OfAFreeFallAreTheWeight) {
  Scene scene = sheet_scene();
  Simulation simulation(scene);
  simulation.measure_wrenches(true);
  for (int step = 0; step < 6; ++step) {
    simulation.step();
    const StepWrenches& w = simulation.wrenches();
    EXPECT_LT((w.others.at("loads").force - weight_of(simulation)).norm(), 1e-12);
    EXPECT_LT((w.change.force - weight_of(simulation)).norm(), 1e-9);
  }
}

TEST(Wrenches, ABallAtRestUnderClothBearsItsWeight) {
  Scene scene = sheet_scene(12);
  add_ball(scene);
  scene.bodies[0].friction = 0.6;
  scene.time.frames = 240;
  Simulation simulation(scene);
  simulation.advance_to_frame(239);
  simulation.measure_wrenches(true);
  simulation.advance_to_frame(240);
  const StepWrenches w = simulation.frame_wrenches();
  const Vec3 weight = weight_of(simulation);
  EXPECT_LT((w.bodies[0].force - weight).norm(), 0.01 * weight.norm());
  Vec3 centre = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < simulation.mass().size(); ++i) {
    centre += simulation.mass()[i] * simulation.positions()[i];
    mass += simulation.mass()[i];
  }
  const Vec3 torque = (centre / mass).cross(weight);
  EXPECT_LT((w.bodies[0].torque - torque).norm(), 0.01 * 0.2 * weight.norm());
}

TEST(Wrenches, AHandleBearsWhatHangsFromIt) {
  Scene scene = sheet_scene();
  hold_corner(scene);
  scene.air.viscous_drag = 2.0;
  scene.time.frames = 300;
  Simulation simulation(scene);
  simulation.advance_to_frame(299);
  simulation.measure_wrenches(true);
  simulation.advance_to_frame(300);
  const StepWrenches w = simulation.frame_wrenches();
  ASSERT_EQ(w.held, (std::vector<std::int32_t>{0, 1}));
  EXPECT_LT((w.handles[0].force - w.held_force[0] - w.held_force[1]).norm(), 1e-12);
  EXPECT_LT((w.handles[0].force - weight_of(simulation)).norm(),
            1e-3 * weight_of(simulation).norm());
}

TEST(Wrenches, MeasuringThemChangesNoBit) {
  Scene scene = sheet_scene();
  add_ball(scene);
  hold_corner(scene);
  Simulation plain(scene), measured(scene);
  measured.measure_wrenches(true);
  plain.advance_to_frame(20);
  measured.advance_to_frame(20);
  EXPECT_EQ(state_hash(plain.state()), state_hash(measured.state()));
}

/// Draws a scene in which the response, the fail-safe and the limiter have work.
Scene drawn(std::mt19937& draw, const std::string& response, const std::string& fail_safe) {
  const auto uniform = [&](double low, double high) {
    return low +
           (high - low) * static_cast<double>(draw()) / static_cast<double>(std::mt19937::max());
  };
  Scene scene = sheet_scene(6);
  add_ball(scene);
  if (draw() % 2 == 0) hold_corner(scene);
  scene.cloths[0].velocity = {uniform(-3, 3), uniform(-3, 3), uniform(-20, -1)};
  scene.bodies[0].friction = uniform(0.0, 1.0);
  scene.bodies[0].placement.translation = {uniform(-0.1, 0.1), 0.0, uniform(-0.01, 0.0)};
  scene.contact.response = response;
  scene.contact.fail_safe = fail_safe;
  constexpr const char* integrators[] = {"implicit_blend", "implicit_euler", "bdf2", "verlet"};
  scene.solver.integrator = integrators[draw() % 4];
  if (scene.solver.integrator == "verlet" && response == "penalty")
    scene.solver.integrator = "bdf2";
  if (draw() % 2 == 0)
    scene.air = {.wind = Vec3(2.0, 0.0, 0.5), .normal_drag = 0.5, .viscous_drag = 0.1};
  return scene;
}

struct Worst {
  double force = 0.0, torque = 0.0, response = 0.0, internal = 0.0;
  int steps = 0, parted = 0, limited = 0;
};

Worst worst_of(const Scene& scene) {
  Simulation simulation(scene);
  simulation.measure_wrenches(true);
  const bool keeps = responses().at(scene.contact.response).traits().keeps_momentum;
  const bool known = scene.solver.integrator.starts_with("implicit");
  Worst worst;
  for (int step = 0; step < 16; ++step) {
    simulation.step();
    const StepWrenches& w = simulation.wrenches();
    const double size = size_of(simulation, w);
    worst.force = std::max(worst.force, w.force_error);
    worst.torque = std::max(worst.torque, w.torque_error);
    if (keeps) worst.response = std::max(worst.response, other(w, "response") / size);
    if (known) worst.internal = std::max(worst.internal, other(w, "internal") / size);
    ++worst.steps;
    worst.parted += w.others.contains("fail_safe") ? 1 : 0;
    worst.limited += w.others.contains("strain_limit") ? 1 : 0;
  }
  return worst;
}

// What the bodies feel comes from the impulses of the response. That all of them are in it shows in
// "response", which is what it moved beyond its impulses.
TEST(Wrenches, SumUpToTheChangeOfMomentumForEveryResponse) {
  std::mt19937 draw(46);
  int parted = 0, limited = 0;
  for (const auto& [response, entry] : responses())
    for (const auto& [fail_safe, other] : fail_safes())
      for (int k = 0; k < 3; ++k) {
        const Scene scene = drawn(draw, response, fail_safe);
        SCOPED_TRACE(response + " " + fail_safe + " " + scene.solver.integrator);
        const Worst worst = worst_of(scene);
        EXPECT_LE(worst.force, kMomentum);
        EXPECT_LE(worst.torque, kMomentum);
        EXPECT_LE(worst.response, kMomentum);
        EXPECT_LE(worst.internal, kMomentum);
        parted += worst.parted;
        limited += worst.limited;
      }
  EXPECT_GT(parted, 20);
  EXPECT_GT(limited, 20);
}

TEST(Wrenches, WhatAngularMomentumLacksShrinksWithTheStep) {
  std::vector<double> missing;
  for (const int steps : {2, 8, 32}) {
    Scene scene = sheet_scene();
    add_ball(scene);
    hold_corner(scene);
    scene.time.steps_per_frame = steps;
    scene.time.step_error = 0.0;
    Simulation simulation(scene);
    simulation.measure_wrenches(true);
    double sum = 0.0;
    while (!simulation.reached(12)) {
      simulation.step();
      const StepWrenches& w = simulation.wrenches();
      if (const auto found = w.others.find("lever_arms"); found != w.others.end())
        sum += w.h * found->second.torque.norm();
    }
    missing.push_back(sum);
  }
  EXPECT_LT(missing[1], 0.5 * missing[0]);
  EXPECT_LT(missing[2], 0.5 * missing[1]);
}

TEST(Wrenches, HaveTheSameBitsForAnyNumberOfThreads) {
  Scene scene = sheet_scene();
  add_ball(scene);
  hold_corner(scene);
  std::vector<Vec3> felt[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    Simulation simulation(scene);
    simulation.measure_wrenches(true);
    for (int step = 0; step < 20; ++step) {
      simulation.step();
      felt[threads - 1].push_back(simulation.wrenches().bodies[0].force);
      felt[threads - 1].push_back(simulation.wrenches().handles[0].torque);
    }
  }
  EXPECT_EQ(felt[0], felt[1]);
}

// The piece alone touches them, so both together carry its mass, each the more the more it bears.
TEST(Wrenches, KnowTheMassThatBodiesCarry) {
  Scene scene = sheet_scene();
  add_ball(scene);
  add_ball(scene);
  scene.bodies[0].placement.translation = {-0.1, 0.0, -0.01};
  scene.bodies[1].placement.translation = {0.3, 0.0, -0.01};
  Simulation simulation(scene);
  simulation.measure_wrenches(true);
  simulation.step();
  EXPECT_EQ(simulation.wrenches().body_mass[0].mass, 0.0) << "nothing touches yet";
  simulation.advance_to_frame(20);
  const StepWrenches& w = simulation.wrenches();
  const double mass = weight_of(simulation).norm() / 9.81;
  EXPECT_NEAR(w.body_mass[0].mass + w.body_mass[1].mass, mass, 1e-12);
  const bool first_bears = w.bodies[0].force.norm() > w.bodies[1].force.norm();
  EXPECT_EQ(w.body_mass[0].mass > w.body_mass[1].mass, first_bears);
  for (std::size_t b = 0; b < 2; ++b) {
    const EffectiveMass& e = w.body_mass[b];
    const Vec3 from_ball = e.centre - scene.bodies[b].placement.translation;
    EXPECT_LT(from_ball.norm(), 0.21) << "within the ball, to which the points belong";
    EXPECT_GE(e.inertia.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-12);
    EXPECT_LT(e.inertia.trace(), 2.0 * e.mass * 0.3 * 0.3);
  }
}

TEST(Wrenches, AddPointMassesToABodyOfThem) {
  EffectiveMass pair;
  pair.add(Vec3(1.0, 0.0, 0.0), 1.0);
  pair.add(Vec3(-2.0, 0.0, 0.0), 2.0);
  EXPECT_NEAR(pair.mass, 3.0, 1e-15);
  EXPECT_LT((pair.centre - Vec3(-1.0, 0.0, 0.0)).norm(), 1e-15);
  // 1 · 2² + 2 · 1² about y and z
  EXPECT_LT((pair.inertia - Mat3(Vec3(0.0, 6.0, 6.0).asDiagonal())).norm(), 1e-14);
}

}  // namespace
}  // namespace selvedge::wrench_test
