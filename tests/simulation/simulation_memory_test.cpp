// SPDX-License-Identifier: MIT
// A scene made in code, stepped and read without a file.
#include <gtest/gtest.h>
#include <selvedge/run/run.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>
#include <unistd.h>

#include <algorithm>
#include <cfenv>
#include <filesystem>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace selvedge::simulation_memory_test {
namespace {

/// A cloth over a ball, on a floor.
Scene ball_scene() {
  Scene scene;
  scene.name = "memory";
  scene.materials["default"] = {.density = 0.15, .bending_stiffness = 2e-5};
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "cloth";
  cloth.shape = ClothGrid{.grid = {.size_x = 0.5, .size_y = 0.5, .cells_x = 10, .cells_y = 10}};
  cloth.placement.translation = {0.01, 0.02, 0.21};
  BodySpec& ball = scene.bodies.emplace_back();
  ball.name = "ball";
  ball.shape = BodyShape{Sphere{.radius = 0.2}, 24};
  scene.time.frames = 20;
  return scene;
}

/// A scene whose contacts carry a flat cloth: its weight is known.
Scene table_scene() {
  Scene scene = ball_scene();
  scene.bodies[0].shape = BodyShape{Box{Vec3(1.0, 1.0, 0.1)}, 3};
  scene.cloths[0].placement.translation = {0.01, 0.02, 0.05 + 1.1 * scene.contact.rest_gap};
  return scene;
}

TEST(SimulationInMemory, AnotherArithmeticOfTheProgramIsRefusedInsteadOfChangingBits) {
  Simulation simulation(ball_scene());
  simulation.step();
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    ASSERT_EQ(std::fesetround(mode), 0);
    EXPECT_THROW(simulation.step(), std::runtime_error);
    EXPECT_THROW(Simulation{ball_scene()}, std::runtime_error);
    std::fesetround(FE_TONEAREST);
  }
#if defined(__SSE2__)
  constexpr unsigned flush_to_zero = 0x8000, denormals_are_zero = 0x0040;
  const unsigned usual = _mm_getcsr();
  for (const unsigned mode : {flush_to_zero, denormals_are_zero}) {
    _mm_setcsr(usual | mode);
    EXPECT_THROW(simulation.step(), std::runtime_error);
    _mm_setcsr(usual);
  }
#endif
  EXPECT_NO_THROW(simulation.step());
}

TEST(SimulationInMemory, StepsASceneMadeInCodeToTheBitsOfRunScene) {
  const Scene scene = ball_scene();
  const auto folder = std::filesystem::temp_directory_path() /
                      ("selvedge_memory_test_" + std::to_string(::getpid()));
  RunConfig config;
  config.out = folder;
  const RunResult of_run = run_scene(scene, config);
  std::filesystem::remove_all(folder);

  Simulation simulation(scene);
  int steps = 0;
  for (; !simulation.reached(scene.time.frames); ++steps) simulation.step();
  EXPECT_EQ(of_run.steps, steps);
  EXPECT_EQ(state_hash(simulation.state()), of_run.state_hash);
  EXPECT_DOUBLE_EQ(simulation.time(), scene.time.frames / scene.time.fps);
}

TEST(SimulationInMemory, StepContinuesBeyondTheLastFrameOfTheScene) {
  Scene scene = ball_scene();
  scene.time.frames = 1;
  Simulation simulation(scene);
  simulation.advance_to_frame(1);
  const double time = simulation.time();
  simulation.step();
  EXPECT_NEAR(simulation.time() - time, 1.0 / (scene.time.fps * scene.time.steps_per_frame), 1e-12);
}

TEST(SimulationInMemory, PositionsAndVelocitiesAreThoseOfTheState) {
  Simulation simulation(ball_scene());
  simulation.step();
  EXPECT_EQ(simulation.positions().data(), simulation.state().x.data());
  EXPECT_EQ(simulation.velocities().data(), simulation.state().v.data());
  EXPECT_EQ(simulation.positions().size(), 11u * 11u);
  EXPECT_EQ(simulation.time(), simulation.state().time);
}

TEST(SimulationInMemory, ContactsOfClothAtRestCarryItsWeight) {
  const Scene scene = table_scene();
  Simulation simulation(scene);
  EXPECT_TRUE(simulation.contacts().empty());
  const auto momentum = [&] {  // N·s, upwards
    double sum = 0.0;
    for (std::size_t i = 0; i < simulation.mass().size(); ++i)
      sum += simulation.mass()[i] * simulation.velocities()[i].z();
    return sum;
  };
  simulation.advance_to_frame(20);
  const double before = momentum();
  simulation.step();
  double weight = 0.0, impulse = 0.0;
  for (const double m : simulation.mass()) weight += 9.81 * m;
  for (const StepContact& c : simulation.contacts()) {
    // The first primitive of some pairs is the table's.
    const bool cloth_first = simulation.names().is_cloth(c.point.vertex[0]);
    impulse += (cloth_first ? 1.0 : -1.0) * c.impulse.z();
    EXPECT_NEAR(std::abs(c.point.normal.z()), 1.0, 1e-6);
    const Vec3 apart = relative(c.point, [&] {
      std::vector<Vec3> x(simulation.positions().begin(), simulation.positions().end());
      x.insert(x.end(), simulation.body_positions().begin(), simulation.body_positions().end());
      return x;
    }());
    EXPECT_NEAR(c.gap, c.point.normal.dot(apart), 1e-15);
  }
  const double of_weight = weight * simulation.last_step().lengths.back();
  EXPECT_NEAR(impulse, momentum() - before + of_weight, 0.02 * of_weight);
}

TEST(SimulationInMemory, ContactsAreEmptyAfterARestore) {
  Simulation simulation(table_scene());
  simulation.advance_to_frame(2);
  ASSERT_FALSE(simulation.contacts().empty());
  simulation.restore(simulation.state());
  EXPECT_TRUE(simulation.contacts().empty());
}

TEST(SimulationInMemory, EnergiesOfFreeFallMoveFromGravityToMotion) {
  Scene scene = ball_scene();
  scene.bodies.clear();
  Simulation simulation(scene);
  const auto before = simulation.energies();
  EXPECT_EQ(before.at("kinetic"), 0.0);
  for (int step = 0; step < 12; ++step) simulation.step();
  const auto after = simulation.energies();
  double mass = 0.0;
  for (const double m : simulation.mass()) mass += m;
  double speed = 0.0;
  for (const Vec3& v : simulation.velocities()) speed = std::max(speed, v.norm());
  EXPECT_NEAR(speed, 9.81 * simulation.time(), 1e-6);
  EXPECT_NEAR(after.at("kinetic"), 0.5 * mass * speed * speed, 1e-6 * after.at("kinetic"));
  EXPECT_LT(after.at("gravity"), before.at("gravity"));
}

TEST(SimulationInMemory, ASceneThatStartsCrossedIsRefusedByTheConstructor) {
  Scene scene = ball_scene();
  scene.cloths[0].placement.translation.z() = 0.1;
  EXPECT_THROW(Simulation{scene}, std::invalid_argument);
}

/// A blade that turns about z, and a small sheet in its way a quarter of a turn on. Nominal steps
/// of 0.1 s.
Scene blade_scene(std::vector<std::pair<double, double>> degrees_at) {
  Scene scene = ball_scene();
  scene.gravity.setZero();
  ClothSpec& cloth = scene.cloths[0];
  cloth.shape = ClothGrid{.grid = {.size_x = 0.1, .size_y = 0.1, .cells_x = 5, .cells_y = 5}};
  cloth.placement.rotation = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitY());
  cloth.placement.translation = {0.0, 0.2, 0.0};
  scene.bodies[0].shape = BodyShape{Box{Vec3(0.6, 0.01, 0.3)}, 3};
  for (const auto& [time, degrees] : degrees_at)
    scene.bodies[0].motion.push_back({.time = time,
                                      .rotation = Eigen::Quaterniond(Eigen::AngleAxisd(
                                          degrees * std::numbers::pi / 180.0, Vec3::UnitZ()))});
  scene.time.fps = 10.0;
  scene.time.steps_per_frame = 1;
  scene.time.frames = 1;
  return scene;
}

TEST(SimulationInMemory, ABladeThatTurnsFarInAStepTakesTheSheetAlong) {
  Simulation simulation(blade_scene({{0.0, 0.0}, {0.1, 170.0}}));
  while (simulation.time() < 0.1) {
    simulation.step();
    // In the frame of the blade, the sheet is ahead of it, as far as the blade reaches.
    const double angle = simulation.time() / 0.1 * 170.0 * std::numbers::pi / 180.0;
    const Eigen::AngleAxisd back(-angle, Vec3::UnitZ());
    for (const Vec3& x : simulation.positions())
      if (x.head<2>().norm() < 0.3) {
        EXPECT_GT((back * x).y(), 0.005) << simulation.time();
      }
  }
  EXPECT_TRUE(simulation.result().clean);
  EXPECT_GT(simulation.result().steps, 10);
  for (const Vec3& x : simulation.positions()) EXPECT_LT(x.x(), -0.05);
}

TEST(SimulationInMemory, AStepEndsWhereATurnChanges) {
  Simulation simulation(blade_scene({{0.0, 0.0}, {0.035, 1.0}, {0.07, 0.0}}));
  std::vector<double> times;
  while (simulation.time() < 0.1) {
    simulation.step();
    times.push_back(simulation.time());
  }
  ASSERT_EQ(times.size(), 3u);
  EXPECT_NEAR(times[0], 0.035, 1e-12);
  EXPECT_NEAR(times[1], 0.07, 1e-12);
}

TEST(SimulationInMemory, ASlowTurnDoesNotShortenSteps) {
  Simulation simulation(blade_scene({{0.0, 0.0}, {1.0, 20.0}}));
  simulation.advance_to_frame(1);
  EXPECT_EQ(simulation.result().steps, 1);
}

}  // namespace
}  // namespace selvedge::simulation_memory_test
