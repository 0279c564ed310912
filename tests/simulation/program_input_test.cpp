// SPDX-License-Identifier: MIT
// Forces, held vertices and driven bodies that a program sets between the steps of a simulation.
#include <gtest/gtest.h>
#include <selvedge/bodies/driven_body.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <limits>

namespace selvedge::program_input_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A piece of cloth in empty space.
Scene free_scene() {
  Scene scene;
  scene.materials["default"] = {.density = 0.15, .bending_stiffness = 2e-5};
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "cloth";
  cloth.shape = ClothGrid{.grid = {.size_x = 0.4, .size_y = 0.4, .cells_x = 8, .cells_y = 8}};
  cloth.placement.translation = {0.01, 0.02, 0.5};
  scene.time.frames = 20;
  return scene;
}

Scene ball_scene() {
  Scene scene = free_scene();
  scene.cloths[0].placement.translation = {0.01, 0.02, 0.21};
  BodySpec& ball = scene.bodies.emplace_back();
  ball.name = "ball";
  ball.shape = BodyShape{Sphere{.radius = 0.2}, 24};
  return scene;
}

double largest_distance(std::span<const Vec3> a, std::span<const Vec3> b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

std::vector<Vec3> weights_of(const Simulation& simulation, const Vec3& acceleration) {
  std::vector<Vec3> forces;
  for (const double m : simulation.mass()) forces.push_back(m * acceleration);
  return forces;
}

/// Positions of a body at a time, m.
std::vector<Vec3> body_at(const Body& body, double time) {
  std::vector<Vec3> x(body.vertex_count());
  body.positions(time, x);
  return x;
}

TEST(ProgramScene, ANumberThatIsNotFiniteIsRefused) {
  Scene placed = free_scene();
  placed.cloths[0].placement.translation.x() = kNaN;
  EXPECT_THROW(build_scene(placed), std::invalid_argument);
  Scene blown = free_scene();
  blown.air.jets = {{.position = Vec3(0, kNaN, 0), .direction = Vec3(1, 0, 0), .speed = 1.0}};
  EXPECT_THROW(build_scene(blown), std::invalid_argument);
  blown.air.jets[0].position = Vec3::Zero();
  EXPECT_NO_THROW(build_scene(blown));
}

TEST(ProgramForces, ThoseOfGravityMoveTheClothAsGravityDoes) {
  const Scene heavy = ball_scene();
  Scene light = heavy;
  light.gravity.setZero();
  Simulation expected(heavy), simulation(light);
  simulation.set_forces(weights_of(simulation, heavy.gravity));
  expected.advance_to_frame(12);
  simulation.advance_to_frame(12);
  EXPECT_GT(simulation.contacts().size(), 0u);
  EXPECT_LT(largest_distance(simulation.positions(), expected.positions()), 1e-6);
  EXPECT_TRUE(simulation.result().clean);
}

TEST(ProgramForces, AConstantForceIsNoGainOfEnergy) {
  Scene scene = free_scene();
  scene.gravity.setZero();
  Simulation simulation(scene);
  simulation.set_forces(weights_of(simulation, Vec3(0.0, 0.0, 5.0)));
  for (int step = 0; step < 10; ++step) simulation.step();
  simulation.set_forces(weights_of(simulation, Vec3(0.0, 0.0, -5.0)));
  for (int step = 0; step < 10; ++step) simulation.step();
  const auto balance = simulation.result().ledger.at("balance");
  EXPECT_EQ(balance.at("steps"), 20.0);
  EXPECT_EQ(balance.at("retries"), 0.0);
  EXPECT_EQ(balance.at("gained_steps"), 0.0);
}

TEST(ProgramForces, AreBalancedInTheFrameOfHeldClothThatMoves) {
  const Scene heavy = free_scene();
  Scene light = heavy;
  light.gravity.setZero();
  Simulation expected(heavy), simulation(light);
  simulation.set_forces(weights_of(simulation, heavy.gravity));
  const std::vector<std::int32_t> corners{0, 8};
  for (int step = 0; step < 20; ++step) {
    for (Simulation* s : {&expected, &simulation}) {
      std::vector<Vec3> ends;
      for (const std::int32_t i : corners) ends.push_back(s->positions()[i] + Vec3(0, 0, 0.01));
      s->hold(corners, ends);
      s->step();
    }
  }
  const auto balance = simulation.result().ledger.at("balance");
  const auto wanted = expected.result().ledger.at("balance");
  EXPECT_EQ(balance.at("steps"), wanted.at("steps"));
  EXPECT_EQ(balance.at("retries"), wanted.at("retries"));
  EXPECT_NEAR(balance.at("max_gain_J"), wanted.at("max_gain_J"), 1e-9);
  EXPECT_LT(largest_distance(simulation.positions(), expected.positions()), 1e-9);
}

TEST(ProgramForces, AreFreeOfEffectWhenTheyAreTakenAway) {
  const Scene scene = ball_scene();
  Simulation expected(scene), simulation(scene);
  simulation.set_forces(weights_of(simulation, Vec3(1.0, 2.0, 3.0)));
  simulation.set_forces({});
  expected.advance_to_frame(5);
  simulation.advance_to_frame(5);
  EXPECT_EQ(state_hash(simulation.state()), state_hash(expected.state()));
}

TEST(ProgramScene, AWindOutOfRangeStopsTheStepAtANamedVertex) {
  Scene scene = free_scene();
  scene.air.wind = Vec3(1.0, 2.0, 1e200);
  scene.air.normal_drag = 1e200;
  Simulation simulation(scene);
  try {
    simulation.advance_to_frame(1);
    ADD_FAILURE();
  } catch (const SimulationFailed& failure) {
    EXPECT_EQ(failure.kind, FailureKind::not_finite) << failure.what();
    EXPECT_NE(std::string(failure.what()).find("vertex 0 "), std::string::npos) << failure.what();
  }
}

TEST(ProgramForces, RefuseAWrongLengthAndWhatIsNotFinite) {
  Simulation simulation(free_scene());
  const std::vector<Vec3> few(3, Vec3::Zero());
  EXPECT_THROW(simulation.set_forces(few), std::invalid_argument);
  std::vector<Vec3> bad(simulation.positions().size(), Vec3::Zero());
  bad[5].y() = kNaN;
  try {
    simulation.set_forces(bad);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "forces[5] is not finite");
  }
}

TEST(HeldByProgram, MovesAsAHandleWithTheSameMotionDoes) {
  Scene with_handle = free_scene();
  HandleSpec handle{.name = "rail", .geometry = "cloth", .vertices = {0, 8}, .motion = {}};
  const Vec3 shift(0.05, -0.03, 0.1);
  handle.motion = {{.time = 0.0}, {.time = 0.1, .translation = shift}};
  with_handle.handles.push_back(handle);
  Simulation expected(with_handle), simulation(free_scene());
  const std::vector<std::int32_t> held{0, 8};
  const std::vector<Vec3> start{simulation.positions()[0], simulation.positions()[8]};
  for (int step = 0; step < 24; ++step) {
    const double s = std::min(1.0, simulation.nominal_end() / 0.1);
    simulation.hold(held, std::vector<Vec3>{start[0] + s * shift, start[1] + s * shift});
    simulation.step();
    expected.step();
  }
  EXPECT_EQ(simulation.time(), expected.time());
  EXPECT_LT(largest_distance(simulation.positions(), expected.positions()), 1e-6);
  EXPECT_LT((simulation.positions()[0] - (start[0] + shift)).norm(), 1e-15);
}

TEST(HeldByProgram, ReachesItsEndInStepsThatWereHalved) {
  Scene scene = free_scene();
  scene.solver.integrator = "verlet";  // takes shorter steps than the nominal one
  Simulation simulation(scene);
  const std::vector<std::int32_t> held{0};
  const Vec3 from = simulation.positions()[0], to = from + Vec3(0.0, 0.0, 0.01);
  const double end = simulation.nominal_end();
  simulation.hold(held, std::vector<Vec3>{to});
  int parts = 0;
  for (; simulation.time() < end; ++parts) {
    simulation.step();
    const double s = simulation.time() / end;
    EXPECT_LT((simulation.positions()[0] - (from + s * (to - from))).norm(), 1e-15);
  }
  EXPECT_GT(parts, 1);
  EXPECT_EQ(simulation.positions()[0], to);
  simulation.step();
  EXPECT_EQ(simulation.positions()[0], to);
}

TEST(HeldByProgram, FallsAfterItsRelease) {
  Simulation simulation(free_scene());
  std::vector<std::int32_t> all(simulation.positions().size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int32_t>(i);
  const std::vector<Vec3> start(simulation.positions().begin(), simulation.positions().end());
  simulation.hold(all, start);
  for (int step = 0; step < 3; ++step) simulation.step();
  EXPECT_EQ(largest_distance(simulation.positions(), start), 0.0);
  simulation.release(all);
  for (int step = 0; step < 3; ++step) simulation.step();
  EXPECT_LT(simulation.positions()[40].z(), start[40].z());
}

TEST(HeldByProgram, RefusesAVertexOutOfRangeAndArraysOfDifferentLengths) {
  Simulation simulation(free_scene());
  const std::vector<Vec3> one(1, Vec3::Zero());
  EXPECT_THROW(simulation.hold(std::vector<std::int32_t>{0, 1}, one), std::invalid_argument);
  EXPECT_THROW(simulation.hold(std::vector<std::int32_t>{-1}, one), std::invalid_argument);
  EXPECT_THROW(simulation.release(std::vector<std::int32_t>{81}), std::invalid_argument);
  try {
    simulation.hold(std::vector<std::int32_t>{81}, one);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "vertices[0] is 81; the cloth has vertices 0 to 80");
  }
}

TEST(DrivenBodies, MoveTheClothAsTheSameMotionInTheSceneDoes) {
  Scene scene = ball_scene();
  Scene moving = scene;
  moving.bodies[0].motion = {{.time = 0.0}, {.time = 0.2, .translation = Vec3(0.1, 0.0, 0.05)}};
  Simulation expected(moving);
  const BuiltScene prescribed = build_scene(moving);
  BuiltScene built = build_scene(scene);
  DrivenBody& ball = drive_body(built, 0);
  Simulation simulation(scene, std::move(built));
  EXPECT_TRUE(simulation.bodies_move());
  for (int step = 0; step < 30; ++step) {
    simulation.move_body(ball, body_at(*prescribed.bodies[0], simulation.nominal_end()));
    simulation.step();
    expected.step();
    ASSERT_EQ(simulation.body_positions(), body_at(*prescribed.bodies[0], simulation.time()));
  }
  EXPECT_GT(simulation.contacts().size(), 0u);
  EXPECT_LT(largest_distance(simulation.positions(), expected.positions()), 1e-6);
  simulation.verify_frame();
  EXPECT_TRUE(simulation.result().clean);
}

TEST(DrivenBodies, AtRestAreAsStaticOnes) {
  const Scene scene = ball_scene();
  BuiltScene built = build_scene(scene);
  (void)drive_body(built, 0);
  Simulation expected(scene), simulation(scene, std::move(built));
  expected.advance_to_frame(8);
  simulation.advance_to_frame(8);
  EXPECT_LT(largest_distance(simulation.positions(), expected.positions()), 1e-6);
  EXPECT_TRUE(simulation.result().clean);
}

TEST(DrivenBodies, GiveTheSameBitsOnAnyNumberOfThreads) {
  const Scene scene = ball_scene();
  const auto hash = [&](int threads) {
    const ThreadLimit limit(threads);
    BuiltScene built = build_scene(scene);
    DrivenBody& ball = drive_body(built, 0);
    Simulation simulation(scene, std::move(built));
    simulation.set_forces(weights_of(simulation, Vec3(0.5, 0.0, 0.0)));
    for (int step = 0; step < 12; ++step) {
      std::vector<Vec3> x = simulation.body_positions();
      for (Vec3& p : x) p += Vec3(0.002, 0.0, 0.003);
      simulation.move_body(ball, x);
      simulation.step();
    }
    return state_hash(simulation.state());
  };
  EXPECT_EQ(hash(1), hash(4));
}

TEST(DrivenBodies, OfAnotherSimulationAreRefused) {
  const Scene scene = ball_scene();
  BuiltScene built = build_scene(scene), other = build_scene(scene);
  DrivenBody& strange = drive_body(other, 0);
  (void)drive_body(built, 0);
  Simulation simulation(scene, std::move(built));
  EXPECT_THROW(simulation.move_body(strange, simulation.body_positions()), std::invalid_argument);
  EXPECT_THROW(drive_body(other, 1), std::invalid_argument);
}

/// A press that leaves the cloth no room, and then goes back.
TEST(DrivenBodies, ThatGoBackAfterAFailedStepLeaveACleanResult) {
  Scene scene;
  scene.materials["default"] = {};
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "cloth";
  cloth.shape = ClothGrid{.grid = {.size_x = 0.2, .size_y = 0.2, .cells_x = 4, .cells_y = 4}};
  cloth.placement.translation.z() = 0.02;
  for (const double height : {0.0, 0.05}) {
    BodySpec& plate = scene.bodies.emplace_back();
    plate.name = height > 0.0 ? "press" : "table";
    plate.shape = BodyShape{Box{Vec3(1.0, 1.0, 0.02)}, 3};
    plate.placement.translation.z() = height;
  }
  scene.time.max_halvings = 3;
  BuiltScene built = build_scene(scene);
  DrivenBody& press = drive_body(built, 1);
  Simulation simulation(scene, std::move(built));
  simulation.advance_to_frame(5);
  const auto move_press = [&](double by) {
    const std::vector<Vec3>& all = simulation.body_positions();
    std::vector<Vec3> x(all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2), all.end());
    for (Vec3& p : x) p.z() += by;
    simulation.move_body(press, x);
  };
  for (int trial = 0; trial < 2; ++trial) {
    move_press(-0.032);
    EXPECT_THROW(for (int step = 0; step < 50; ++step) simulation.step(), SimulationFailed);
    EXPECT_FALSE(simulation.result().clean) << "the last step failed";
    move_press(0.02);
    simulation.step();
    EXPECT_TRUE(simulation.result().clean) << "every accepted state is clean";
    EXPECT_TRUE(simulation.result().clean_elsewhere);
  }
}

TEST(DrivenBody, MovesOnStraightLinesAndRests) {
  const std::unique_ptr<Body> start =
      make_static_body({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  DrivenBody body(*start);
  const std::vector<Vec3> up{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  body.move_to(up, 1.0, 2.0);
  EXPECT_EQ(body_at(body, 0.5)[1], Vec3(1, 0, 0));
  EXPECT_EQ(body_at(body, 1.5)[1], Vec3(1, 0, 0.5));
  EXPECT_EQ(body_at(body, 2.0), up);
  EXPECT_EQ(body_at(body, 3.0), up);
  EXPECT_FALSE(body.is_static(1.0, 2.0));
  EXPECT_TRUE(body.is_static(2.5, 3.0));
  body.move_to(up, 1.5, 3.0);  // before the motion has ended: from where it is
  EXPECT_EQ(body_at(body, 1.5)[0], Vec3(0, 0, 0.5));
  EXPECT_THROW(body.move_to(up, 2.0, 2.0), std::invalid_argument);
  EXPECT_THROW(body.move_to(std::span(up).first(2), 2.0, 3.0), std::invalid_argument);
  EXPECT_THROW(body.place(std::vector<Vec3>(3, Vec3(0, kNaN, 0)), 2.0), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::program_input_test
