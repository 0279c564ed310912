// SPDX-License-Identifier: MIT
//
// Every response in whole scenes, by either integrator.
#include <gtest/gtest.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/energy_balance.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge::response_scene_test {
namespace {

Scene sheet_over(const AnalyticShape& shape, int cells, double height) {
  Scene scene;
  scene.name = "test";
  scene.materials["default"] = Material{};
  ClothSpec sheet;
  sheet.name = "cloth";
  sheet.shape = ClothGrid{"rectangular", {0.3, 0.3, cells, cells}, {}};
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
  EXPECT_GE(result.counters.at("max_gap_violation_m"), 0.0) << name;
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
  scene.contact.response_options.set("restitution", 0.5);
  EXPECT_TRUE(contains(refusal(scene), "contact_force: has no option \"restitution\""))
      << refusal(scene);
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
  scene.contact.response_options.set("stiffness", 1e9);
  EXPECT_EQ(refusal(scene), "") << "implicit steps bear it";
  scene.solver.integrator = "symplectic_euler";
  EXPECT_TRUE(contains(refusal(scene), "stiffness 1e+09 N/m")) << refusal(scene);
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
    scene.contact.response_options.set("stiffness", stiffness);
    const RunResult result = run(scene, 2);
    EXPECT_TRUE(result.clean);
    steps.push_back(result.steps);
  }
  EXPECT_GT(steps[1], 4 * steps[0]);  // the bound goes with the root
}

// Elastic, kinetic and potential energy, J.
double mechanical_energy(const Scene& scene, const ClothMesh& cloth, const SimulationState& state) {
  double sum = 0.0;
  for (std::size_t i = 0; i < state.x.size(); ++i)
    sum += cloth.mass[i] * (0.5 * state.v[i].squaredNorm() - scene.gravity.dot(state.x[i]));
  for (const Spring& s : cloth.springs) {
    const double longer = (state.x[s.b] - state.x[s.a]).norm() - s.rest_length;
    sum += 0.5 * s.stiffness * longer * longer;
  }
  return sum;
}

// What lands with its border on an edge goes on falling in its middle: springs that are not
// stretched yet resist that in second order only, which one linear solve does not see. Iterated, no
// step gives energy, so it is not the contact that does.
TEST(DefaultResponse, GivesNoEnergyToClothThatLandsOnAnEdge) {
  Scene scene = sheet_over(Box{{0.1, 0.1, 0.1}}, 12, 0.07);
  scene.solver.integrator = "implicit_newton";
  BuiltScene built = build_scene(scene);
  const ClothMesh cloth = built.cloth;
  Simulation simulation(scene, std::move(built));
  double before = mechanical_energy(scene, cloth, simulation.state()), gained = 0.0;
  const double start = before;
  for (int frame = 1; frame <= 12; ++frame)
    simulation.advance_to_frame(frame, [&](double) {
      const double now = mechanical_energy(scene, cloth, simulation.state());
      gained = std::max(gained, now - before);
      before = now;
    });
  EXPECT_LT(gained, 1e-3 * std::abs(start));
}

// Largest gain of a step over the largest kinetic energy of all, and what the run says of it.
struct Gains {
  double worst = 0.0;
  std::map<std::string, double> reported;
  int halvings = 0, retried_steps = 0;
};

Gains gains_on_an_edge(const Scene& scene) {
  BuiltScene built = build_scene(scene);
  const ClothMesh cloth = built.cloth;
  Simulation simulation(scene, std::move(built));
  double before = mechanical_energy(scene, cloth, simulation.state()), kinetic = 0.0;
  Gains gains;
  for (int frame = 1; frame <= 12; ++frame)
    simulation.advance_to_frame(frame, [&](double) {
      const SimulationState& state = simulation.state();
      double moving = 0.0;
      for (std::size_t i = 0; i < state.v.size(); ++i)
        moving += 0.5 * cloth.mass[i] * state.v[i].squaredNorm();
      kinetic = std::max(kinetic, moving);
      const double now = mechanical_energy(scene, cloth, state);
      gains.worst = std::max(gains.worst, now - before);
      before = now;
    });
  gains.worst /= kinetic;
  const RunResult result = simulation.result();
  gains.reported = result.ledger.at("balance");
  gains.halvings = result.halvings;
  gains.retried_steps = result.retried_steps;
  return gains;
}

Scene sheet_on_an_edge(const std::string& response) {
  Scene scene = sheet_over(Box{{0.1, 0.1, 0.1}}, 12, 0.07);
  scene.contact.response = response;
  scene.solver.integrator = "implicit_euler";  // the blend takes the gain out of its velocities
  return scene;
}

TEST(EnergyBalance, AStepThatGainsEnergyWithoutASourceIsRepeatedShorter) {
  // A hundredth and the bending, which is not summed up here; impulses are left some more.
  for (const auto& [response, most] :
       {std::pair{"contact_force", 0.03}, std::pair{"impulse", 0.1}}) {
    const Gains gains = gains_on_an_edge(sheet_on_an_edge(response));
    EXPECT_GT(gains.reported.at("retries"), 0.0) << response;
    EXPECT_LT(gains.worst, most) << response;
    EXPECT_GT(gains.retried_steps, 0) << response;
    EXPECT_LE(gains.retried_steps, gains.halvings) << response;
  }
}

TEST(EnergyBalance, AGainThatCannotOrMayNotBeRetriedIsReported) {
  Scene unguarded = sheet_on_an_edge("impulse");
  unguarded.time.energy_guard = false;
  const Gains without = gains_on_an_edge(unguarded);
  EXPECT_GT(without.worst, 0.1);
  EXPECT_EQ(without.reported.at("retries"), 0.0);
  EXPECT_GT(without.reported.at("gained_steps"), 0.0);
  Scene scene = sheet_on_an_edge("impulse");
  scene.time.max_halvings = 0;
  const Gains gains = gains_on_an_edge(scene);
  EXPECT_GT(gains.worst, 1.0);
  EXPECT_EQ(gains.reported.at("retries"), 0.0);
  EXPECT_EQ(gains.retried_steps, 0);
  EXPECT_GT(gains.reported.at("gained_steps"), 0.0);
  EXPECT_GE(gains.reported.at("energy_gained_J"), gains.reported.at("max_gain_J"));
  EXPECT_GT(gains.reported.at("max_gain_J"), 0.0);
}

// A try of a step of a sheet over a ball, all of it arbitrary.
struct WeighedTry {
  Scene scene = sheet_over(Sphere{0.1}, 4, 0.104);
  BuiltScene built = build_scene(scene);
  ForceSum forces{make_forces(scene, built), built.cloth.mass.size()};
  detail::EnergyBalance balance{scene, built, {}};
  std::vector<Vec3> x_t0 = built.cloth.surface.vertices, x_t1, v_t0, v_t1;
  std::vector<double> inv_mass;
  std::optional<double> work{};  // J, of bodies that move apart; nullopt: not known

  WeighedTry() {
    for (std::size_t i = 0; i < x_t0.size(); ++i) {
      const double wave = std::sin(static_cast<double>(i));
      v_t0.emplace_back(wave, 1.0, -wave);
      v_t1.emplace_back(1.0, wave, -2.0 * wave);
      x_t1.push_back(x_t0[i] + Vec3(0.01 * wave, 0.0, 0.02 * wave));
      inv_mass.push_back(1.0 / built.cloth.mass[i]);
    }
    for (int body_vertex = 0; body_vertex < 2; ++body_vertex) {
      x_t0.emplace_back(0.0, 0.0, 0.1 * body_vertex);
      x_t1.push_back(x_t0.back());
      inv_mass.push_back(0.0);
    }
  }
  bool weigh() {
    constexpr double h = 0.01;
    balance.begin();
    detail::BalanceStep step{x_t0, x_t1, v_t0, v_t1, inv_mass, built.cloth.mass, 0.0, h};
    if (work) step.anchor_work = [this] { return work; };
    return balance.weigh(forces, step);
  }
  void move_as_a_whole(const Vec3& u) {
    for (Vec3& x : x_t1) x += 0.01 * u;
    for (Vec3& v : v_t0) v += u;
    for (Vec3& v : v_t1) v += u;
  }
};

TEST(EnergyBalance, IsThatOfTheSceneAtRestWhereAllOfItMoves) {
  WeighedTry still, moved;
  moved.move_as_a_whole(Vec3(7.0, -3.0, 11.0));
  ASSERT_TRUE(still.weigh());
  ASSERT_TRUE(moved.weigh());
  EXPECT_NE(still.balance.gain(), 0.0);
  EXPECT_NEAR(moved.balance.gain(), still.balance.gain(), 1e-10 * std::abs(still.balance.gain()));
  EXPECT_NEAR(moved.balance.bound(), still.balance.bound(), 1e-10 * still.balance.bound());
}

TEST(EnergyBalance, TakesOffTheWorkOfBodiesThatMoveApart) {
  WeighedTry still, apart;
  apart.x_t1.back().z() += 0.001;
  apart.work = 0.25;
  ASSERT_TRUE(still.weigh());
  ASSERT_TRUE(apart.weigh());
  // Both are weighed in the frame of the room: the bodies of the first do not move.
  EXPECT_NEAR(apart.balance.gain(), still.balance.gain() - 0.25, 1e-12);
}

TEST(EnergyBalance, IsOffWithUnknownWorkOfBodiesWindOrSpringContacts) {
  WeighedTry apart;
  apart.x_t1.back().z() += 0.001;
  EXPECT_FALSE(apart.weigh());
  WeighedTry windy;
  windy.scene.air.wind = Vec3(1.0, 0.0, 0.0);
  windy.balance = detail::EnergyBalance(windy.scene, windy.built, {});
  EXPECT_FALSE(windy.weigh());
  WeighedTry springy;
  ResponseTraits springs;
  springs.stores_energy = true;
  springy.balance = detail::EnergyBalance(springy.scene, springy.built, springs);
  EXPECT_FALSE(springy.weigh());
}

TEST(EnergyBalance, PenaltiesWhichGiveBackWhatTheyTookAreNotCalledAGain) {
  const Gains gains = gains_on_an_edge(sheet_on_an_edge("penalty"));
  EXPECT_EQ(gains.reported.at("steps"), 0.0);
  EXPECT_EQ(gains.reported.at("retries"), 0.0);
}

TEST(EnergyBalance, StepsAreNotMadeShorterWhereThatDoesNotLessenTheGain) {
  WeighedTry one;
  for (Vec3& v : one.v_t1) v *= 10.0;
  ASSERT_TRUE(one.weigh());
  EXPECT_TRUE(one.balance.wants_shorter());
  EXPECT_FALSE(one.balance.wants_shorter());  // as much again
  one.balance.accept();
  EXPECT_EQ(one.balance.figures().at("gained_steps"), 1.0);
}

}  // namespace
}  // namespace selvedge::response_scene_test
