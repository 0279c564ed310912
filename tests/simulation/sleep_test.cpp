// SPDX-License-Identifier: MIT
// Cloth at rest that leaves out its steps, and what wakes it.
#include <gtest/gtest.h>
#include <selvedge/bodies/driven_body.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/sleep.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace selvedge::sleep_test {
namespace {

constexpr double kSpeed = 0.02;  // m/s

/// A sheet on a plate, 1 mm above it at the start.
Scene resting() {
  Scene scene;
  scene.name = "sleep";
  scene.materials["default"] = Material{};
  ClothSpec& sheet = scene.cloths.emplace_back();
  sheet.name = "sheet";
  sheet.shape = ClothGrid{"rectangular", {0.3, 0.3, 6, 6}};
  sheet.placement.translation = Vec3(0, 0, 0.003);
  BodySpec& plate = scene.bodies.emplace_back();
  plate.name = "plate";
  plate.shape = BodyShape{Box{Vec3(1, 1, 0.1)}, 3};
  plate.placement.translation = Vec3(0, 0, -0.05);
  scene.time.frames = 240;
  scene.time.sleep_speed = kSpeed;
  return scene;
}

/// A sheet held by two neighbouring corners, in air that soon stops it.
Scene hanging() {
  Scene scene = resting();
  scene.bodies.clear();
  scene.air.viscous_drag = 2.0;
  HandleSpec& handle = scene.handles.emplace_back();
  handle.name = "corners";
  handle.geometry = "sheet";
  handle.vertices = {0, 6};
  return scene;
}

double asleep(const Simulation& simulation) {
  const RunResult result = simulation.result();
  const auto found = result.counters.find("steps_asleep");
  return found == result.counters.end() ? 0.0 : found->second;
}

std::vector<Vec3> positions(const Simulation& simulation) {
  return {simulation.positions().begin(), simulation.positions().end()};
}

double fastest(const Simulation& simulation) {
  double largest = 0.0;
  for (const Vec3& v : simulation.velocities()) largest = std::max(largest, v.norm());
  return largest;
}

/// Advances until the cloth sleeps; the frame from which on it does.
int advance_to_sleep(Simulation& simulation, int last) {
  for (int frame = 1; frame <= last; ++frame) {
    simulation.advance_to_frame(frame);
    if (asleep(simulation) > 0.0) return frame;
  }
  ADD_FAILURE() << "never sleeps";
  return last;
}

TEST(Sleep, ClothAtRestKeepsItsPlaceAndTakesNoSteps) {
  const Scene scene = resting();
  Simulation simulation(scene);
  const int frame = advance_to_sleep(simulation, 120);
  const std::vector<Vec3> before = positions(simulation);
  const std::int64_t steps = simulation.state().step;
  simulation.advance_to_frame(frame + 60);
  EXPECT_EQ(positions(simulation), before);
  EXPECT_EQ(fastest(simulation), 0.0);
  EXPECT_EQ(simulation.state().step, steps);
  EXPECT_EQ(asleep(simulation), 60 * 2 + 2);
  EXPECT_NEAR(simulation.time(), (frame + 60) / 60.0, 1e-12);
  EXPECT_TRUE(simulation.result().clean);
  EXPECT_FALSE(simulation.contacts().empty()) << "it still rests on the plate";
  ASSERT_FALSE(simulation.last_step().lengths.empty()) << "their impulses are of the last step";
  double push = 0.0, weight = 0.0;
  for (const StepContact& c : simulation.contacts()) push += c.impulse.z();
  for (const double m : simulation.mass()) weight += 9.81 * m;
  EXPECT_NEAR(push / simulation.last_step().lengths.back(), weight, 0.1 * weight);
}

TEST(Sleep, TheFirstHalfSecondOfRestIsComputed) {
  Scene scene = resting();
  Simulation simulation(scene), awake([&] {
    scene.time.sleep_speed = 0.0;
    return scene;
  }());
  int still = 0;
  for (int frame = 1; frame <= 120 && asleep(simulation) == 0.0; ++frame) {
    awake.advance_to_frame(frame);
    const std::vector<Vec3> expected = positions(awake);
    simulation.advance_to_frame(frame);
    if (asleep(simulation) > 0.0) break;
    EXPECT_EQ(positions(simulation), expected) << frame;
    still = fastest(awake) <= kSpeed ? still + 1 : 0;
  }
  EXPECT_GE(still, 29);
  EXPECT_LE(still, 31);
}

TEST(Sleep, IsOffUnlessASceneAsksForIt) {
  Scene scene = resting();
  scene.time.sleep_speed = TimeSpec{}.sleep_speed;
  Simulation simulation(scene);
  simulation.advance_to_frame(100);
  EXPECT_EQ(asleep(simulation), 0.0);
}

TEST(Sleep, StillnessEndsWithOneFastParticle) {
  const Scene scene = resting();
  const BuiltScene built = build_scene(scene);
  const detail::Sleep sleep(scene, built);
  std::vector<Vec3> v(49, Vec3(0, 0, kSpeed));
  EXPECT_EQ(sleep.still_after(0.25, v, 0.125), 0.375);
  v[17] = Vec3(0, kSpeed, kSpeed);
  EXPECT_EQ(sleep.still_after(0.25, v, 0.125), 0.0);
  v[17] = Vec3::Constant(NAN);
  EXPECT_EQ(sleep.still_after(0.25, v, 0.125), 0.0);
  SimulationState state;
  state.still = 0.499;
  EXPECT_FALSE(sleep.is_due(state));
  state.still = 0.5;
  EXPECT_TRUE(sleep.is_due(state));
}

// With three steps per frame, two are left out at once and one follows: the handle lets go in the
// first of them.
TEST(Sleep, AHandleThatLetsGoWakesTheCloth) {
  for (const int steps_per_frame : {2, 3}) {
    Scene scene = hanging();
    scene.time.steps_per_frame = steps_per_frame;
    scene.handles[0].release = steps_per_frame == 2 ? 3.5 : 3.5 + 0.3 / 180.0;
    Simulation simulation(scene);
    EXPECT_LT(advance_to_sleep(simulation, 200), 200);
    simulation.advance_to_frame(210);  // 3.5 s
    EXPECT_EQ(fastest(simulation), 0.0);
    const Vec3 before = simulation.positions()[0];
    simulation.advance_to_frame(216);
    EXPECT_GT(before.z() - simulation.positions()[0].z(), 0.01) << "it falls";
  }
}

TEST(Sleep, ClothThatWasWokenStaysAwakeWhileItIsStillSlow) {
  Scene scene = hanging();
  scene.air.viscous_drag = 0.0;
  scene.gravity = Vec3(0, 0, -0.5);
  for (std::int32_t i = 1; i < 49; ++i)
    if (i != 6) scene.handles[0].vertices.push_back(i);
  scene.handles[0].release = 1.0;
  Simulation simulation(scene);
  EXPECT_LT(advance_to_sleep(simulation, 59), 59);
  simulation.advance_to_frame(60);
  const double before = asleep(simulation);
  simulation.advance_to_frame(61);
  EXPECT_GT(fastest(simulation), 0.0);
  EXPECT_LT(fastest(simulation), kSpeed);
  simulation.advance_to_frame(90);
  EXPECT_NEAR(fastest(simulation), 0.25, 1e-3);
  EXPECT_EQ(asleep(simulation), before);
}

TEST(Sleep, AHandleWakesTheClothOnlyWhileItMoves) {
  Scene scene = hanging();
  const Vec3 aside(0.1, 0, 0);
  scene.handles[0].motion = {{.time = 0.0}, {.time = 3.0}, {.time = 3.5, .translation = aside}};
  Simulation simulation(scene);
  EXPECT_LT(advance_to_sleep(simulation, 175), 175) << "between equal keyframes";
  simulation.advance_to_frame(180);  // 3 s
  const Vec3 before = simulation.positions()[0];
  simulation.advance_to_frame(210);
  EXPECT_NEAR((simulation.positions()[0] - before - aside).norm(), 0.0, 1e-12);
}

TEST(Sleep, ABodyThatMovesWakesTheClothEvenIfItMovesElsewhere) {
  Scene scene = resting();
  scene.bodies[0].motion = {
      {.time = 0.0}, {.time = 2.5}, {.time = 3.5, .translation = {0, 0, 0.1}}};
  BodySpec far = scene.bodies[0];
  far.name = "far";
  far.placement.translation = Vec3(9, 0, 0);
  far.motion = {{.time = 2.0}, {.time = 2.25, .translation = {1, 0, 0}}};
  scene.bodies.push_back(far);
  Simulation simulation(scene);
  EXPECT_LT(advance_to_sleep(simulation, 119), 119);
  simulation.advance_to_frame(120);  // 2 s
  const double before = asleep(simulation);
  simulation.advance_to_frame(135);  // 2.25 s
  EXPECT_EQ(asleep(simulation), before);
  const double height = simulation.positions()[24].z();
  simulation.advance_to_frame(210);
  EXPECT_NEAR(simulation.positions()[24].z() - height, 0.1, 1e-3) << "the plate carries it";
}

TEST(Sleep, TheProgramWakesTheCloth) {
  const Scene scene = resting();
  BuiltScene built = build_scene(scene);
  DrivenBody& plate = drive_body(built, 0);
  Simulation simulation(scene, std::move(built));
  int frame = advance_to_sleep(simulation, 120);
  const auto wakes = [&](const char* what, const auto& act) {
    const double before = asleep(simulation);
    act();
    simulation.advance_to_frame(frame + 10);
    EXPECT_EQ(asleep(simulation), before) << what;
    simulation.advance_to_frame(frame + 80);
    EXPECT_GT(asleep(simulation), before) << what << ": it sleeps again";
    frame += 80;
  };
  wakes("set_forces", [&] { simulation.set_forces(std::vector<Vec3>(49, Vec3(0, 0, 1e-5))); });
  const std::vector<std::int32_t> vertices{3};
  wakes("hold", [&] { simulation.hold(vertices, simulation.positions().subspan(3, 1)); });
  wakes("release", [&] { simulation.release(vertices); });
  wakes("release_all", [&] { simulation.release_all(); });
  std::vector<Vec3> x(simulation.body_positions().begin(), simulation.body_positions().end());
  wakes("move_body", [&] { simulation.move_body(plate, x); });
}

TEST(Sleep, ClothInGustsAndWetClothStayAwake) {
  Scene gusts = resting();
  gusts.air.normal_drag = 1e-6;
  gusts.air.gusts.speed = 1e-3;
  Scene wet = resting();
  wet.water.emplace();
  for (const Scene& scene : {gusts, wet}) {
    Simulation simulation(scene);
    simulation.advance_to_frame(100);
    EXPECT_EQ(asleep(simulation), 0.0);
  }
}

TEST(Sleep, ARestoredRunSleepsAndWakesAtTheSameTimes) {
  Scene scene = hanging();
  scene.handles[0].release = 3.5;
  Simulation whole(scene);
  const int frame = advance_to_sleep(whole, 200);
  for (const int at : {frame - 15, frame + 1}) {
    Simulation first(scene), second(scene);
    first.advance_to_frame(at);
    second.restore(first.state());
    second.advance_to_frame(220);
    if (at < frame) whole.advance_to_frame(220);
    EXPECT_EQ(state_hash(second.state()), state_hash(whole.state())) << at - frame;
    EXPECT_EQ(second.state().step, whole.state().step);
  }
}

}  // namespace
}  // namespace selvedge::sleep_test
