// SPDX-License-Identifier: MIT
// Whether cloth is at rest: forces that are known in closed form, and runs that end in equilibrium.
#include <gtest/gtest.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/internal/scene_text.h>
#include <selvedge/simulation/detail/rest.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

namespace selvedge::at_rest_test {
namespace {

constexpr double kGravity = 9.81, kAngle = std::numbers::pi / 6.0;

/// A sheet on a plate that is inclined by 30 degrees, at its rest gap.
Scene slope(double friction) {
  Scene scene;
  scene.name = "slope";
  scene.materials["default"] = Material{};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(kAngle, Vec3::UnitY()));
  ClothSpec& sheet = scene.cloths.emplace_back();
  sheet.name = "sheet";
  sheet.shape = ClothGrid{"rectangular", {0.2, 0.2, 4, 4}};
  sheet.placement = {turn * Vec3(0.0, 0.0, scene.contact.rest_gap), turn};
  BodySpec& plate = scene.bodies.emplace_back();
  plate.name = "plate";
  plate.shape = BodyShape{Box{Vec3(4, 4, 0.1)}, 3};
  plate.placement = {turn * Vec3(0.0, 0.0, -0.05), turn};
  plate.friction = friction;
  scene.contact.pairs = {{"sheet", "plate", friction, {}, {}}};
  return scene;
}

/// A sheet that falls on a ball.
Scene drape(const std::string& integrator) {
  Scene scene;
  scene.name = "drape";
  scene.materials["default"] = Material{};
  ClothSpec& sheet = scene.cloths.emplace_back();
  sheet.name = "sheet";
  sheet.shape = ClothGrid{"rectangular", {0.6, 0.6, 12, 12}};
  sheet.placement.translation = Vec3(0.01, 0.005, 0.21);
  BodySpec& ball = scene.bodies.emplace_back();
  ball.name = "ball";
  ball.shape = BodyShape{Sphere{0.2}, 24};
  scene.air.normal_drag = 1.0;
  scene.air.viscous_drag = 0.1;
  scene.time.frames = 600;
  scene.time.until_rest = true;
  scene.solver.integrator = integrator;
  return scene;
}

/// Frames until it is at rest; the scene's frames if it never is.
int frames_to_rest(Simulation& simulation, int most) {
  for (int frame = 1; frame <= most; ++frame) {
    simulation.advance_to_frame(frame);
    if (simulation.is_at_rest()) return frame;
  }
  return most;
}

TEST(AtRest, FallingClothIsUnbalancedByItsWeight) {
  Scene scene = slope(0.3);
  scene.bodies.clear();
  scene.contact.pairs.clear();
  Simulation simulation(scene);
  EXPECT_NEAR(simulation.rest().unbalanced, 1.0, 1e-6) << "at the start";
  simulation.advance_to_frame(3);
  const RestReport rest = simulation.rest();
  EXPECT_NEAR(rest.unbalanced, 1.0, 1e-6);
  EXPECT_FALSE(rest.at_rest);
  EXPECT_TRUE(rest.verdict.starts_with("still moving: ")) << rest.verdict;
  EXPECT_NE(rest.verdict.find("of cloth \"sheet\""), std::string::npos) << rest.verdict;
}

TEST(AtRest, FrictionInsideItsConeIsBalanced) {
  Simulation simulation(slope(0.7));
  simulation.advance_to_frame(10);
  const RestReport rest = simulation.rest();
  EXPECT_LT(rest.unbalanced, 1e-3);
  EXPECT_TRUE(rest.at_rest) << rest.verdict;
  EXPECT_TRUE(rest.verdict.starts_with("at rest")) << rest.verdict;
}

TEST(AtRest, BeyondTheConeTheNearestForceIsLeft) {
  const double friction = 0.3;
  Simulation simulation(slope(friction));
  simulation.advance_to_frame(10);
  const RestReport rest = simulation.rest();
  // The distance of the weight from the cone.
  const double left = (std::sin(kAngle) - friction * std::cos(kAngle)) / std::hypot(1.0, friction);
  EXPECT_NEAR(rest.unbalanced, left, 0.02 * left);
  EXPECT_FALSE(rest.at_rest);
}

TEST(AtRest, ARestoredStateHasTheSameContacts) {
  const Scene scene = slope(0.7);
  Simulation simulation(scene);
  simulation.advance_to_frame(10);
  Simulation other(scene);
  other.restore(simulation.state());
  EXPECT_TRUE(other.rest().at_rest) << other.rest().verdict;
}

TEST(AtRest, AContactOnlyPushes) {
  const std::vector<Vec3> force{Vec3(0.0, 0.0, 2.0 * kGravity)};
  const std::vector<double> mass{1.0}, inv_mass{1.0};
  StepContact contact;
  contact.point = {{0, 1, 2, 3}, {1.0, -1.0, 0.0, 0.0}, Vec3::UnitZ(), 0.0, 0.002, 0.5};
  contact.gap = 0.002;
  contact.impulse = Vec3(0.0, 0.0, -kGravity);  // pulls, as the guess of a solve may
  const std::vector<StepContact> near{contact};
  const auto left = [&] {
    return detail::unbalanced_share(
        {.force = force, .mass = mass, .inv_mass = inv_mass, .near = near}, 1e-4);
  };
  EXPECT_NEAR(left(), 2.0, 1e-12) << "what lifts off is not held";
  std::vector<StepContact> far = near;
  far[0].gap = 0.0022;
  const std::vector<Vec3> weight{Vec3(0.0, 0.0, -kGravity)};
  EXPECT_NEAR(detail::unbalanced_share(
                  {.force = weight, .mass = mass, .inv_mass = inv_mass, .near = far}, 1e-4),
              1.0, 1e-12)
      << "beyond its rest gap a contact bears nothing";
  EXPECT_LT(detail::unbalanced_share(
                {.force = weight, .mass = mass, .inv_mass = inv_mass, .near = near}, 1e-4),
            1e-4);
}

/// A chain of particles of 1 kg, a metre apart in the direction of z; the first is held, and all
/// links are at their limit.
double unbalanced_chain(int links, double direction) {
  const std::size_t n = links + 1;
  const std::vector<Vec3> force(n, Vec3(0.0, 0.0, -kGravity));
  std::vector<double> mass(n, 1.0), inv_mass(n, 1.0);
  inv_mass[0] = 0.0;
  std::vector<HeldStrain> held;
  const Vec3 to_next(0.0, 0.0, direction);
  for (int i = 0; i < links; ++i) held.push_back({{i, i + 1, -1}, {to_next, -to_next, Vec3()}, 2});
  return detail::unbalanced_share(
      {.force = force, .mass = mass, .inv_mass = inv_mass, .near = {}, .held = held}, 1e-4);
}

TEST(AtRest, AStrainAtItsLimitPullsButDoesNotPush) {
  EXPECT_LT(unbalanced_chain(1, -1.0), 1e-4) << "it hangs";
  EXPECT_NEAR(unbalanced_chain(1, 1.0), 1.0, 1e-12) << "it does not stand";
  EXPECT_LT(unbalanced_chain(24, -1.0), 1e-3);
  EXPECT_NEAR(unbalanced_chain(24, 1.0), 1.0, 1e-12);
}

/// A sheet that hangs by two corners, in which springs near them reach their limit of 4 %.
Scene hung(const std::string& limiter) {
  Scene scene;
  scene.name = "hung";
  Material& soft = scene.materials["default"] = Material{};
  soft.stretch_stiffness = 100.0;
  soft.shear_stiffness = 30.0;
  soft.strain_limit = 0.04;
  ClothSpec& sheet = scene.cloths.emplace_back();
  sheet.name = "sheet";
  sheet.shape = ClothGrid{"rectangular", {1.0, 1.0, 12, 12}};
  sheet.placement.rotation = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX());
  scene.handles.push_back({"corners", "sheet", {156, 168}, {}, {}});
  scene.air.viscous_drag = 0.5;
  scene.contact.self = false;
  scene.solver.limiter = limiter;
  scene.time.frames = 600;
  return scene;
}

TEST(AtRest, ClothThatItsStrainLimitHoldsComesToRest) {
  for (const char* limiter : {"position", "continuum"}) {
    Scene scene = hung(limiter);
    Simulation simulation(scene);
    EXPECT_LT(frames_to_rest(simulation, scene.time.frames), scene.time.frames)
        << limiter << ": " << simulation.rest().verdict;
    // Without the limiter the same place is not one of rest.
    scene.solver.strain_limiter = false;
    Simulation other(scene);
    other.restore(simulation.state());
    EXPECT_GT(other.rest().unbalanced, 0.1) << limiter;
  }
}

TEST(AtRest, ClothThatSwingsAtItsStrainLimitIsNot) {
  Scene scene = hung("position");
  scene.cloths[0].placement.rotation = Eigen::AngleAxisd(0.4 * std::numbers::pi, Vec3::UnitX());
  scene.air.viscous_drag = 0.0;
  Simulation simulation(scene);
  for (int frame = 1; frame <= 60; ++frame) {
    simulation.advance_to_frame(frame);
    EXPECT_FALSE(simulation.rest().at_rest) << frame;
    EXPECT_GT(simulation.rest().unbalanced, 5e-3) << frame;
  }
}

// A sheet at its strain limit, and one that sinks at 2 mm/s because the air is as thick as honey.
TEST(AtRest, ClothThatSinksEvenlyBesideALimiterIsNot) {
  Scene scene = hung("position");
  ClothSpec& free = scene.cloths.emplace_back(scene.cloths[0]);
  free.name = "free";
  free.placement.translation = Vec3(0.0, 1.0, 0.0);
  const double speed = 0.002, density = scene.materials["default"].density;
  scene.air.viscous_drag = density * kGravity / speed;
  Simulation simulation(scene);
  for (int frame = 1; frame <= 120; ++frame) {
    simulation.advance_to_frame(frame);
    EXPECT_GT(simulation.rest().unbalanced, 0.5) << frame;
  }
}

TEST(AtRest, QuasiStaticStepsReachTheEquilibriumOfADrape) {
  const Scene scene = drape("quasi_static");
  Simulation simulation(scene);
  const int frames = frames_to_rest(simulation, scene.time.frames);
  const RestReport rest = simulation.rest();
  EXPECT_LT(frames, scene.time.frames);
  EXPECT_TRUE(rest.at_rest) << rest.verdict;
  EXPECT_TRUE(simulation.result().clean);
  const double static_steps = simulation.result().counters.at("quasi_static_steps");
  EXPECT_GT(static_steps, 5.0);
  // Going on, it stays where it is.
  const std::vector<Vec3> x(simulation.positions().begin(), simulation.positions().end());
  simulation.advance_to_frame(frames + 30);
  double most = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i)
    most = std::max(most, (simulation.positions()[i] - x[i]).norm());
  EXPECT_LT(most, 2e-3);
  EXPECT_LT(simulation.rest().unbalanced, 2e-3) << "within what solves and contacts leave";
}

// Most of its particles lie on the face and bear each other through nothing, so that the error of
// the solve is all there is.
TEST(AtRest, ATableClothComesToRest) {
  Scene scene = drape("quasi_static");
  scene.cloths[0].shape = ClothGrid{"rectangular", {1.0, 1.0, 30, 30}};
  scene.cloths[0].placement.translation = Vec3(0.0, 0.0, 0.03);
  scene.bodies[0].shape = BodyShape{Cylinder{0.32, 0.03}, 96};
  scene.bodies[0].friction = 0.4;
  scene.time.frames = 240;
  Simulation simulation(scene);
  EXPECT_LT(frames_to_rest(simulation, scene.time.frames), scene.time.frames)
      << simulation.rest().verdict;
}

TEST(AtRest, QuasiStaticStepsDoNotRaiseTheEnergy) {
  const Scene scene = drape("quasi_static");
  Simulation simulation(scene);
  const auto potential = [&] {
    double sum = 0.0;
    for (const auto& [name, value] : simulation.energies())
      if (name != "kinetic") sum += value;
    return sum;
  };
  int frame = 0;
  while (!(simulation.result().counters.at("quasi_static_steps") > 0.0) && frame < 300)
    simulation.advance_to_frame(++frame);
  ASSERT_LT(frame, 300) << "the motion never died";
  double before = potential();
  for (int k = 0; k < 40; ++k) {
    simulation.advance_to_frame(++frame);
    const double now = potential();
    // The energy guard lets a hundredth of the energy of 0.12 m/s pass.
    EXPECT_LT(now, before + 1e-5) << "frame " << frame;
    before = now;
  }
}

TEST(AtRest, ARestoredQuasiStaticRunHasTheSameBits) {
  const Scene scene = drape("quasi_static");
  Simulation simulation(scene);
  int frame = 0;
  while (!(simulation.result().counters.at("quasi_static_steps") > 5.0) && frame < 300)
    simulation.advance_to_frame(++frame);
  ASSERT_LT(frame, 300);
  Simulation other(scene);
  other.restore(simulation.state());
  simulation.advance_to_frame(frame + 5);
  other.advance_to_frame(frame + 5);
  EXPECT_EQ(state_hash(simulation.state()), state_hash(other.state()));
}

TEST(AtRest, ARunEndsThereAndSaysSo) {
  namespace fs = std::filesystem;
  RunConfig config;
  config.out = fs::path(::testing::TempDir()) / ("selvedge_at_rest_" + std::to_string(getpid()));
  Scene scene = slope(0.7);
  scene.time.frames = 40;
  const RunResult whole = run_scene(scene, config);
  EXPECT_EQ(whole.frames, 41) << "without the key it goes on";
  EXPECT_TRUE(whole.rest.at_rest) << whole.rest.verdict;

  scene.time.until_rest = true;
  scene.name = "until";
  fs::remove_all(config.out);
  const RunResult result = run_scene(scene, config);
  EXPECT_LT(result.frames, 41);
  EXPECT_GT(result.frames, 1);
  EXPECT_TRUE(result.rest.at_rest) << result.rest.verdict;
  EXPECT_EQ(result.stopped, "");
  std::ifstream file(config.out / "result.json");
  const RunResult read = result_from_text(std::string(std::istreambuf_iterator<char>(file), {}));
  EXPECT_EQ(read.rest.verdict, result.rest.verdict);
  EXPECT_EQ(read.rest.unbalanced, result.rest.unbalanced);

  fs::remove_all(config.out);
}

TEST(AtRest, ARunWaitsForAllThatTheScenePrescribes) {
  namespace fs = std::filesystem;
  RunConfig config;
  config.out = fs::path(::testing::TempDir()) / ("selvedge_awaits_" + std::to_string(getpid()));
  constexpr double kLater = 0.3;  // s, of an event; the sheet is at rest before
  Scene plain = slope(0.7);
  plain.time.frames = 60;
  plain.time.until_rest = true;
  const Keyframe start, still{.time = kLater},
      up{.time = kLater + 0.1, .translation = {0, 0, 0.01}};
  std::vector<Scene> scenes(6, plain);
  scenes[0].bodies[0].motion = {start, still, up};
  scenes[1].handles = {
      {.name = "h", .geometry = "sheet", .vertices = {0}, .motion = {}, .release = kLater}};
  scenes[2].handles = {{.name = "h", .geometry = "sheet", .vertices = {0}, .motion = {still, up}}};
  for (Scene* scene : {&scenes[3], &scenes[4]})
    scene->water = WaterSpec{{}, {{.geometry = "sheet", .vertices = {3}, .rate = 1e-4}}};
  scenes[3].water->sources[0].begin = kLater;
  scenes[4].water->sources[0].end = kLater;
  scenes[5].handles = {
      {.name = "h", .geometry = "sheet", .vertices = {0}, .motion = {start, still}}};
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    fs::remove_all(config.out);
    const RunResult result = run_scene(scenes[k], config);
    const bool waits = k < 5;
    EXPECT_EQ(result.frames > 1 + kLater * plain.time.fps, waits) << k << ": " << result.frames;
    if (waits) {
      EXPECT_LT(result.frames, 61) << k << ": " << result.rest.verdict;
    }
  }
  fs::remove_all(config.out);
}

TEST(AtRest, AStoppedRunGoesOnToTheSameRest) {
  namespace fs = std::filesystem;
  RunConfig config;
  config.out = fs::path(::testing::TempDir()) / ("selvedge_at_rest_on_" + std::to_string(getpid()));
  const Scene scene = read_scene_text(R"({
    "geometry": [{"name": "sheet", "size": [0.6, 0.6], "cells": [12, 12],
                  "transformation": {"translation": [0.01, 0.005, 0.21]}}],
    "obstacles": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.2, "resolution": 24}}],
    "air": {"normal_drag": 1, "viscous_drag": 0.1},
    "solver": {"integrator": "quasi_static"},
    "time": {"frames": 600, "until": "rest"}})",
                                      "drape.json");
  const RunResult whole = run_scene(scene, config);
  ASSERT_TRUE(whole.rest.at_rest) << whole.rest.verdict;
  for (const int stop : {3, 60, static_cast<int>(whole.steps) - 2}) {
    config.resume = false;
    config.max_steps = stop;
    EXPECT_NE(run_scene(scene, config).stopped, "");
    config.resume = true;
    config.max_steps = 0;
    const RunResult resumed = run_scene(scene, config);
    EXPECT_EQ(resumed.state_hash, whole.state_hash) << stop;
    EXPECT_EQ(resumed.frames, whole.frames) << stop;
    EXPECT_EQ(resumed.rest.verdict, whole.rest.verdict) << stop;
  }
  fs::remove_all(config.out);
}

}  // namespace
}  // namespace selvedge::at_rest_test
