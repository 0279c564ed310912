// SPDX-License-Identifier: MIT
// What must not depend on who looks, and what must not move: the same scene in a frame that moves
// at constant velocity, and bodies that cloth pushes.
#include <gtest/gtest.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace selvedge::invariance_test {
namespace {

constexpr int kFrames = 12;

/// A cloth over a ball that is driven up into it, one corner held; all of it flies with `velocity`.
Scene flying_scene(const Vec3& velocity, bool with_ball, const std::string& integrator) {
  Scene scene;
  scene.name = "flying";
  scene.materials["default"] = Material{};
  scene.time.frames = kFrames;
  // A linear solve stops at a residual relative to the momentum, which another frame has more of.
  scene.solver.tolerance = 1e-13;
  scene.solver.integrator = integrator;
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "cloth";
  cloth.shape = ClothGrid{.grid = {0.4, 0.4, 12, 12}, .path = {}};
  cloth.placement.translation = Vec3(0.013, 0.017, 0.103);
  cloth.velocity = velocity;
  const double end = scene.time.frames / scene.time.fps;
  HandleSpec& corner = scene.handles.emplace_back();
  corner.name = "corner";
  corner.geometry = "cloth";
  corner.vertices = {0};
  corner.motion = {{}, {end, end * velocity}};
  if (!with_ball) return scene;
  BodySpec& ball = scene.bodies.emplace_back();
  ball.name = "ball";
  ball.shape = BodyShape{Sphere{0.1}, 24};
  ball.motion = {{}, {end, end * (velocity + Vec3(0.0, 0.0, 0.5))}};
  return scene;
}

/// Largest distance between the scene at rest and in flight, seen from its own frame, m.
double worst_difference(const Vec3& velocity, bool with_ball,
                        const std::string& integrator = SolverSpec{}.integrator) {
  const Scene rest = flying_scene(Vec3::Zero(), with_ball, integrator);
  const Scene flying = flying_scene(velocity, with_ball, integrator);
  Simulation a(rest, build_scene(rest)), b(flying, build_scene(flying));
  double worst = 0.0;
  for (int frame = 1; frame <= kFrames; ++frame) {
    a.advance_to_frame(frame, {});
    b.advance_to_frame(frame, {});
    const Vec3 way = b.state().time * velocity;
    for (std::size_t i = 0; i < a.state().x.size(); ++i)
      worst = std::max(worst, (b.state().x[i] - way - a.state().x[i]).norm());
  }
  if (with_ball) {
    EXPECT_GT(a.result().counters.at("contacts"), 100.0) << "the ball has to touch";
  }
  return worst;
}

TEST(Invariance, AFlyingClothMovesAsOneAtRest) {
  EXPECT_LT(worst_difference(Vec3(10.0, 0.0, 0.0), false), 1e-9);
  EXPECT_LT(worst_difference(Vec3(-3.0, 7.0, 20.0), false), 1e-9);
}

// Contacts amplify rounding, in motion that is less damped more.
TEST(Invariance, AFlyingClothMeetsAFlyingBallAsOneAtRest) {
  for (const Vec3& velocity : {Vec3(10.0, 0.0, 0.0), Vec3(-3.0, 7.0, 20.0)}) {
    EXPECT_LT(worst_difference(velocity, true, "implicit_euler"), 1e-6);
    EXPECT_LT(worst_difference(velocity, true), 1e-3);
  }
}

/// A heavy, fast sheet on a ball at rest and on one that turns and rises.
Scene pushing_scene(bool driven) {
  Scene scene;
  scene.name = "pushing";
  scene.materials["default"] = {.density = 50.0, .stretch_stiffness = 5e4};
  scene.time.frames = kFrames;
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "cloth";
  cloth.shape = ClothGrid{.grid = {0.3, 0.3, 10, 10}, .path = {}};
  cloth.placement.translation = Vec3(0.013, 0.017, 0.11);
  cloth.velocity = Vec3(0.0, 0.0, -3.0);
  BodySpec& ball = scene.bodies.emplace_back();
  ball.name = "ball";
  ball.shape = BodyShape{Sphere{0.1}, 24};
  if (!driven) return scene;
  Keyframe end;
  end.time = 0.3;
  end.translation = Vec3(0.02, 0.01, 0.1);
  end.rotation = Eigen::AngleAxisd(1.0, Vec3(1.0, 2.0, 3.0).normalized());
  ball.motion = {Keyframe{}, end};
  return scene;
}

class BodyNeverYields : public ::testing::TestWithParam<std::string> {};

TEST_P(BodyNeverYields, ByOneBitWhateverTheClothDoes) {
  for (const bool driven : {false, true}) {
    Scene scene = pushing_scene(driven);
    scene.contact.response = GetParam();
    const BuiltScene prescribed = build_scene(scene);
    std::vector<Vec3> should(prescribed.bodies[0]->vertex_count());
    Simulation simulation(scene, build_scene(scene));
    int steps = 0;
    try {
      simulation.advance_to_frame(kFrames, [&](double time) {
        prescribed.bodies[0]->positions(time, should);
        ASSERT_TRUE(simulation.body_positions() == should) << "at " << time << " s";
        ++steps;
      });
    } catch (const SimulationFailed&) {  // a response that gives up has not moved the body either
    }
    EXPECT_GT(steps, 4);
  }
}

std::vector<std::string> response_names() {
  std::vector<std::string> names;
  for (const auto& [name, factory] : responses()) names.push_back(name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Responses, BodyNeverYields, ::testing::ValuesIn(response_names()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace selvedge::invariance_test
