// SPDX-License-Identifier: MIT
//
// Every response in whole scenes, by either integrator.
#include <gtest/gtest.h>
#include <selvedge/scene/simulation.h>

#include <cmath>

namespace selvedge {
namespace {

Scene sheet_over(const AnalyticShape& shape, int cells, double height) {
  Scene scene;
  scene.name = "test";
  scene.materials["default"] = Material{};
  ClothSpec sheet;
  sheet.name = "cloth";
  sheet.shape = ClothGrid{ClothPattern::rectangular, {0.3, 0.3, cells, cells}, {}};
  sheet.placement.translation = Vec3(0.011, 0.007, height);
  scene.cloths.push_back(sheet);
  BodySpec body;
  body.name = "body";
  body.shape = BodyShape{shape, 12};
  scene.bodies.push_back(body);
  return scene;
}

RunResult run(const Scene& scene, int frames) {
  Simulation simulation(scene, build_scene(scene));
  const std::vector<Vec3> body = simulation.body_positions();
  for (int frame = 1; frame <= frames; ++frame) simulation.advance_to_frame(frame, {});
  EXPECT_EQ(simulation.body_positions(), body) << "the body yields";
  return simulation.result();
}

void expect_honest(const RunResult& result, const ResponseTraits& traits, const std::string& name) {
  EXPECT_TRUE(result.clean) << name;
  const auto& ledger = result.ledger.at("response");
  EXPECT_GT(ledger.at("steps"), 0.0) << name;
  EXPECT_GT(ledger.at("to_particles_z"), 0.0) << name;
  EXPECT_LT(ledger.at("to_anchors_z"), 0.0) << name;
  if (traits.keeps_momentum) {
    EXPECT_LT(ledger.at("max_momentum_error"), 1e-12) << name;
  }
  if (traits.passive) {
    EXPECT_LT(ledger.at("energy_gained_J"), 1e-14) << name;
  }
  EXPECT_GE(result.counters.at("max_gap_lack_m"), 0.0) << name;
}

TEST(EveryResponse, DrapesOnASphereCleanlyInImplicitSteps) {
  for (const auto& [name, make] : responses()) {
    Scene scene = sheet_over(Sphere{0.1}, 10, 0.104);
    scene.contact.response = name;
    expect_honest(run(scene, 10), make({})->traits(), name);
  }
}

TEST(EveryResponse, DrapesOnASphereCleanlyInExplicitSteps) {
  for (const auto& [name, make] : responses()) {
    Scene scene = sheet_over(Sphere{0.1}, 5, 0.104);
    scene.contact.response = name;
    scene.solver.integrator = "symplectic_euler";
    scene.materials["default"].stretch_stiffness = 20.0;
    scene.materials["default"].shear_stiffness = 5.0;
    scene.materials["default"].bending_stiffness = 1e-6;
    expect_honest(run(scene, 5), make({})->traits(), name);
  }
}

TEST(EveryResponse, LeavesHeldParticlesWhereTheyAreHeld) {
  for (const auto& [name, make] : responses()) {
    Scene scene = sheet_over(Sphere{0.1}, 6, 0.104);
    scene.contact.response = name;
    HandleSpec handle;
    handle.name = "corner";
    handle.geometry = "cloth";
    handle.vertices = {0, 24};  // a corner, and the middle, which lies on the ball
    scene.handles.push_back(handle);
    Simulation simulation(scene, build_scene(scene));
    const std::vector<Vec3> start = simulation.state().x;
    simulation.advance_to_frame(4, {});
    for (const std::int32_t i : handle.vertices)
      EXPECT_EQ(simulation.state().x[i], start[i]) << name;
  }
}

TEST(EveryResponse, KeepsTheMomentumOfTwoSheetsThatMeetInTheAir) {
  for (const auto& [name, make] : responses()) {
    Scene scene = sheet_over(Sphere{0.1}, 4, 0.1);
    scene.bodies.clear();
    scene.gravity.setZero();
    scene.contact.response = name;
    scene.solver.tolerance = 1e-10;
    scene.solver.strain_limiter = false;
    scene.cloths.push_back(scene.cloths[0]);
    scene.cloths[1].name = "second";
    scene.cloths[1].placement.translation += Vec3(0.02, 0.03, 0.02);
    scene.cloths[1].velocity = Vec3(0, 0, -1.0);
    Simulation simulation(scene, build_scene(scene));
    const std::vector<double> mass = build_scene(scene).cloth.mass;
    const auto momentum = [&] {
      Vec3 sum = Vec3::Zero();
      for (std::size_t i = 0; i < mass.size(); ++i) sum += mass[i] * simulation.state().v[i];
      return sum;
    };
    const Vec3 before = momentum();
    simulation.advance_to_frame(6, {});
    // Internal forces keep it as well as the solve is solved.
    EXPECT_LT((momentum() - before).norm(), 1e-7 * before.norm()) << name;
    const auto ledger = simulation.result().ledger.at("response");
    EXPECT_GT(ledger.at("steps"), 0.0) << name;
    EXPECT_LT(ledger.at("max_momentum_error"), 1e-12) << name;
    EXPECT_EQ(ledger.at("to_anchors_z"), 0.0) << name;
  }
}

std::string refusal(const Scene& scene) {
  try {
    Simulation(scene, build_scene(scene));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Refusal, NamesTheNumberThatAResponseOrIntegratorCannotServe) {
  const auto contains = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  const Scene good = sheet_over(Sphere{0.1}, 5, 0.104);
  EXPECT_EQ(refusal(good), "");
  Scene scene = good;
  scene.contact.response_config.restitution = 0.5;
  EXPECT_TRUE(contains(refusal(scene), "contact.restitution is 0.5")) << refusal(scene);
  scene.contact.response = "impulse";
  EXPECT_EQ(refusal(scene), "");
  scene = good;
  scene.materials["default"].friction = -0.25;
  EXPECT_TRUE(contains(refusal(scene), "-0.25")) << refusal(scene);
  scene = good;
  scene.bodies[0].friction = -0.75;
  EXPECT_TRUE(contains(refusal(scene), "-0.75")) << refusal(scene);
  scene = good;
  scene.contact.response = "penalty";
  scene.contact.response_config.stiffness = 1e9;
  EXPECT_EQ(refusal(scene), "") << "implicit steps bear it";
  scene.solver.integrator = "symplectic_euler";
  EXPECT_TRUE(contains(refusal(scene), "contact.stiffness is 1e+09 N/m")) << refusal(scene);
  EXPECT_TRUE(contains(refusal(scene), "explicit steps below")) << refusal(scene);
}

TEST(Penalty, AnExplicitStepThatItsStiffnessDoesNotBearIsDivided) {
  Scene scene = sheet_over(Sphere{0.1}, 4, 0.104);
  scene.solver.integrator = "symplectic_euler";
  scene.contact.response = "penalty";
  scene.materials["default"].stretch_stiffness = 20.0;
  scene.materials["default"].shear_stiffness = 5.0;
  std::vector<int> steps;
  for (const double stiffness : {100.0, 10000.0}) {
    scene.contact.response_config.stiffness = stiffness;
    const RunResult result = run(scene, 2);
    EXPECT_TRUE(result.clean);
    steps.push_back(result.steps);
  }
  EXPECT_GT(steps[1], 4 * steps[0]);  // the bound goes with the root
}

}  // namespace
}  // namespace selvedge
