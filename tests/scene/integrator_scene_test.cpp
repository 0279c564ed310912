// SPDX-License-Identifier: MIT
//
// Every integrator and every strain limiter in whole scenes.
#include <gtest/gtest.h>
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <cmath>
#include <cstdio>
#include <limits>

namespace selvedge::integrator_scene_test {
namespace {

Scene empty_scene() {
  Scene scene;
  scene.name = "test";
  scene.materials["default"] = Material{};
  scene.time.frames = 30;
  return scene;
}

/// A square that hangs by its upper corners in the wind.
Scene flag(int cells = 6) {
  Scene scene = empty_scene();
  ClothSpec cloth;
  cloth.name = "flag";
  cloth.shape = ClothGrid{"rectangular", {0.4, 0.4, cells, cells}};
  cloth.placement.rotation = Eigen::AngleAxisd(std::acos(0.0), Vec3::UnitX());
  scene.cloths.push_back(cloth);
  const int row = cells + 1;
  scene.handles.push_back({"corners", "flag", {row * cells, row * cells + cells}, {}, {}});
  scene.air = {{0.5, 2.5, 0.0}, 0.8, 0.05};
  scene.materials["default"].spring_damping = 0.001;
  scene.materials["default"].bending_damping = 0.001;
  return scene;
}

Simulation simulate(const Scene& scene) { return Simulation(scene, build_scene(scene)); }

RunResult run(const Scene& scene, int frames) {
  Simulation simulation = simulate(scene);
  for (int frame = 1; frame <= frames; ++frame) simulation.advance_to_frame(frame, {});
  return simulation.result();
}

TEST(IntegratorScene, AFlagFliesCleanlyByEachOfThem) {
  const RunResult reference = run(flag(), 6);
  for (const auto& [name, factory] : integrators()) {
    Scene scene = flag();
    scene.solver.integrator = name;
    const RunResult result = run(scene, 6);
    EXPECT_TRUE(result.clean) << name;
    EXPECT_LT(result.max_stretch, 0.1) << name;
    EXPECT_GT(result.final_max_speed, name.starts_with("implicit_kang") ? 1e-3 : 0.05) << name;
    EXPECT_LT(result.final_max_speed, 3.0 * reference.final_max_speed) << name;
  }
}

TEST(StrainLimiterScene, AFlagFliesCleanlyAndKeepsItsLimitWherePromised) {
  for (const auto& [name, entry] : strain_limiters()) {
    Scene scene = flag();
    scene.materials["default"].stretch_stiffness = 10.0;
    scene.materials["default"].shear_stiffness = 2.0;
    scene.materials["default"].strain_limit = 0.05;
    scene.solver.limiter = name;
    scene.solver.strain_limiter = name != "none";
    const RunResult result = run(scene, 10);
    EXPECT_TRUE(result.clean) << name;
    const LimiterTraits traits = entry.traits();
    if (traits.kind != LimiterKind::method) {
      EXPECT_EQ(result.ledger.count("strain_limiter"), 0u) << name;
      EXPECT_TRUE(name == "chittaro" || result.max_stretch > 0.05) << name;
      continue;
    }
    EXPECT_LT(result.max_stretch, !traits.bounds_strain ? 1.0
                                  : traits.of_springs   ? 0.051
                                                        : 0.1)
        << name;
    const auto& ledger = result.ledger.at("strain_limiter");
    EXPECT_GT(ledger.at("steps"), 0.0) << name;
  }
}

TEST(StrainLimiterScene, FewerSweepsLeaveMoreStrain) {
  Scene scene = flag();
  scene.materials["default"].stretch_stiffness = 10.0;
  scene.materials["default"].shear_stiffness = 2.0;
  scene.materials["default"].strain_limit = 0.05;
  const double usual = run(scene, 10).max_stretch;
  scene.solver.limiter_options = {{"max_sweeps", 1.0}};
  EXPECT_GT(run(scene, 10).max_stretch, usual + 1e-3);
}

/// Positions after a second of flight without anything to touch, `steps` a frame.
std::vector<Vec3> flight(const std::string& integrator, int steps) {
  Scene scene = flag(3);
  Material& soft = scene.materials["default"];
  soft.stretch_stiffness = 2.0;
  soft.shear_stiffness = 0.2;
  soft.bending_stiffness = 1e-9;
  soft.spring_damping = soft.bending_damping = 0.0;
  scene.air = {};
  scene.contact.self = false;
  scene.solver.strain_limiter = false;
  scene.solver.integrator = integrator;
  scene.solver.tolerance = 1e-12;
  scene.time.steps_per_frame = steps;
  scene.time.step_error = 0.0;
  Simulation simulation = simulate(scene);
  for (int frame = 1; frame <= 12; ++frame) simulation.advance_to_frame(frame, {});
  EXPECT_EQ(simulation.result().steps, 12 * steps) << integrator;
  return simulation.state().x;
}

double distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum);
}

TEST(IntegratorScene, FlightWithoutContactKeepsTheOrderOfTheMethod) {
  const std::vector<Vec3> exact = flight("runge_kutta_4", 96);
  const std::vector<std::pair<const char*, double>> orders{
      {"runge_kutta_4", 4.0}, {"verlet", 2.0}, {"imex", 2.0}, {"symplectic_euler", 1.0}};
  for (const auto& [name, order] : orders) {
    const double coarse = distance(flight(name, 12), exact),
                 fine = distance(flight(name, 24), exact);
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.15) << name;
  }
  // Springs under compression, whose Jacobian is cut, leave BDF2 of first order, but nearer.
  const double coarse = distance(flight("bdf2", 12), exact),
               fine = distance(flight("bdf2", 24), exact);
  EXPECT_GT(std::log2(coarse / fine), 0.95);
  EXPECT_LT(fine, 0.3 * distance(flight("implicit_euler", 24), exact));
}

/// A sheet of threads that swings and stretches about its upper edge, its springs never compressed,
/// and a second sheet that slides on a tilted table, if `slides` is true. Without damping, whose
/// Jacobian leaves out that springs turn.
Scene one_swings(const std::string& integrator, int steps, bool slides) {
  Scene scene = empty_scene();
  Material& soft = scene.materials["default"];
  soft.stretch_stiffness = 4.0;
  soft.shear_stiffness = 0.0;
  soft.bending_stiffness = 0.0;
  soft.spring_damping = soft.bending_damping = 0.0;
  scene.contact.self = false;
  scene.solver.strain_limiter = false;
  scene.solver.integrator = integrator;
  scene.solver.tolerance = 1e-12;
  scene.time.steps_per_frame = steps;
  scene.time.step_error = 0.0;
  constexpr int kCells = 4, kRow = kCells + 1;
  ClothSpec swing;
  swing.name = "swing";
  swing.shape = ClothGrid{"rectangular", {0.4, 0.4, kCells, kCells}};
  swing.placement.rotation = Eigen::AngleAxisd(0.6 * std::acos(0.0), Vec3::UnitX());
  scene.cloths.push_back(swing);
  std::vector<std::int32_t> top;
  for (int i = 0; i < kRow; ++i) top.push_back(kRow * kCells + i);
  scene.handles.push_back({"edge", "swing", top, {}, {}});
  if (!slides) return scene;
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.3, Vec3::UnitY()));
  ClothSpec sheet;
  sheet.name = "sheet";
  sheet.shape = ClothGrid{"rectangular", {0.2, 0.2, 3, 3}};
  sheet.placement.rotation = tilt;
  sheet.placement.translation = Vec3(3.0, 0.0, 0.0) + tilt * Vec3(0.0, 0.0, 0.012);
  scene.cloths.push_back(sheet);
  BodySpec table;
  table.name = "table";
  table.shape = BodyShape{Box{Vec3(0.4, 0.4, 0.02)}, 4};
  table.placement.rotation = tilt;
  table.placement.translation = Vec3(3.0, 0.0, 0.0);
  table.friction = 0.1;
  scene.bodies.push_back(table);
  return scene;
}

struct Swung {
  std::vector<Vec3> swing, sheet;
  RunResult result;
};

Swung swing(const std::string& integrator, int steps, bool slides) {
  constexpr int kFrames = 8;
  Simulation simulation = simulate(one_swings(integrator, steps, slides));
  for (int frame = 1; frame <= kFrames; ++frame) simulation.advance_to_frame(frame, {});
  EXPECT_EQ(simulation.result().steps, kFrames * steps) << integrator;
  const std::vector<Vec3> x = simulation.state().x;
  const auto middle = x.begin() + 25;
  return {{x.begin(), middle}, {middle, x.end()}, simulation.result()};
}

TEST(IntegratorScene, Bdf2KeepsItsOrderWhereAnotherPieceIsInContact) {
  const std::vector<Vec3> exact = swing("runge_kutta_4", 96, false).swing;
  const Swung coarse = swing("bdf2", 16, true), fine = swing("bdf2", 32, true);
  const double order = std::log2(distance(coarse.swing, exact) / distance(fine.swing, exact));
  EXPECT_NEAR(order, 2.0, 0.2);
  const std::vector<Vec3> rest = swing("bdf2", 256, true).sheet;
  const double in_contact = distance(fine.sheet, rest);
  std::printf("order of the piece that swings %.2f; of the one in contact %.2f, off by %.1e m\n",
              order, std::log2(distance(coarse.sheet, rest) / in_contact), in_contact);

  // One piece of two takes implicit Euler, and the other one in its first step, which has no step
  // before it.
  for (const Swung* run : {&coarse, &fine}) {
    const auto& counters = run->result.counters;
    const double steps = run->result.steps;
    EXPECT_EQ(counters.at("bdf2_steps_of_pieces"), 2.0 * steps);
    EXPECT_GT(counters.at("substituted_bdf2_by_implicit_euler"), 1.0);
    EXPECT_LE(counters.at("substituted_bdf2_by_implicit_euler"), steps + 1.0);
  }
}

/// A sheet of threads, held at its upper edge, that its weight stretches down a smooth slope.
/// Contacts carry it all the time if `lies` is true; otherwise there is no slope, and only the part
/// of gravity along it, so that the motion along the slope is the same.
std::vector<double> stretched(const std::string& integrator, int steps, bool lies) {
  constexpr int kCells = 4, kRow = kCells + 1, kFrames = 8;
  Scene scene = one_swings(integrator, steps, false);
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.3, Vec3::UnitY()));
  const Vec3 along = tilt * Vec3::UnitX();
  ClothSpec& sheet = scene.cloths[0];
  sheet.placement.rotation = tilt;
  sheet.placement.translation = tilt * Vec3(0.0, 0.0, 0.012);
  scene.handles[0].vertices.clear();
  for (int j = 0; j < kRow; ++j) scene.handles[0].vertices.push_back(kRow * j);
  if (lies) {
    BodySpec slope;
    slope.name = "slope";
    slope.shape = BodyShape{Box{Vec3(2.0, 1.0, 0.02)}, 4};
    slope.placement.rotation = tilt;
    slope.friction = 0.0;
    scene.bodies.push_back(slope);
  } else {
    scene.gravity = scene.gravity.dot(along) * along;
  }
  Simulation simulation = simulate(scene);
  for (int frame = 1; frame <= kFrames; ++frame) simulation.advance_to_frame(frame, {});
  const RunResult result = simulation.result();
  EXPECT_EQ(result.steps, kFrames * steps) << integrator;
  if (integrator == "bdf2") {
    const auto substituted = result.counters.at("substituted_bdf2_by_implicit_euler");
    EXPECT_EQ(substituted, lies ? result.steps : 1.0);
  }
  std::vector<double> places;
  for (const Vec3& x : simulation.state().x) places.push_back(x.dot(along));
  return places;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

TEST(IntegratorScene, Bdf2IsOfFirstOrderInContactAndOfSecondWithoutIt) {
  const std::vector<double> exact = stretched("runge_kutta_4", 96, false);
  const auto error = [&](const char* integrator, int steps, bool lies) {
    return distance(stretched(integrator, steps, lies), exact);
  };
  EXPECT_NEAR(std::log2(error("bdf2", 16, false) / error("bdf2", 32, false)), 2.0, 0.15);
  const double fine = error("bdf2", 32, true);
  EXPECT_NEAR(std::log2(error("bdf2", 16, true) / fine), 1.0, 0.1);
  EXPECT_NEAR(fine / error("implicit_euler", 32, true), 1.0, 1e-3) << "it is implicit Euler there";
}

TEST(IntegratorScene, OnlyAPieceInContactTakesImplicitEuler) {
  const Swung together = swing("bdf2", 16, true), alone = swing("bdf2", 16, false);
  EXPECT_LT(distance(together.swing, alone.swing), 1e-8);
  EXPECT_EQ(alone.result.counters.at("substituted_bdf2_by_implicit_euler"), 1.0);
  const Swung euler = swing("implicit_euler", 16, true);
  EXPECT_GT(distance(together.swing, euler.swing), 1e-3);
  EXPECT_EQ(euler.result.counters.count("substituted_bdf2_by_implicit_euler"), 0u);
}

TEST(SubstitutionsInAResult, NameTheResponseOfExplicitStepsThatTouch) {
  const auto counters = [](const char* integrator, const char* response) {
    Scene scene = one_swings(integrator, 16, true);
    scene.contact.response = response;
    Simulation simulation = simulate(scene);
    simulation.advance_to_frame(4, {});
    return simulation.result().counters;
  };
  const std::string name = "substituted_contact_force_by_impulse";
  const auto explicit_steps = counters("symplectic_euler", "contact_force");
  EXPECT_GT(explicit_steps.at(name), 0.0);
  EXPECT_LE(explicit_steps.at(name), 64.0);
  EXPECT_EQ(counters("symplectic_euler", "impulse").count(name), 0u);
  EXPECT_EQ(counters("implicit_euler", "contact_force").count(name), 0u);
}

TEST(SubstitutionsInAResult, NameTheBroadPhaseOfSelfCollisions) {
  const auto counters = [](const char* broad_phase, bool self) {
    Scene scene = one_swings("implicit_euler", 4, true);
    scene.contact.broad_phase = broad_phase;
    scene.contact.self = self;
    scene.plan.proofs = false;
    Simulation simulation = simulate(scene);
    simulation.advance_to_frame(2, {});
    return simulation.result().counters;
  };
  const std::string name = "substituted_minimal_enclosure_by_bvh_aabb";
  EXPECT_GE(counters("minimal_enclosure", true).at(name), 8.0) << "one search in each step";
  EXPECT_EQ(counters("minimal_enclosure", false).count(name), 0u);
  EXPECT_EQ(counters("voxel", true).count("substituted_voxel_by_bvh_aabb"), 0u);
}

TEST(IntegratorScene, RestoredItGoesOnToTheSameBitsWhateverIsRemembered) {
  for (const char* name :
       {"verlet", "bdf2", "rkf45", "implicit_blend", "implicit_desbrun", "implicit_kang"}) {
    Scene scene = flag();
    scene.solver.integrator = name;
    scene.materials["default"].bending_friction = 1e-4;
    Simulation whole = simulate(scene), half = simulate(scene);
    for (int frame = 1; frame <= 3; ++frame) {
      whole.advance_to_frame(frame, {});
      half.advance_to_frame(frame, {});
    }
    const std::string text = detail::memory_text(half.state().memory);
    ASSERT_FALSE(text.empty()) << name;
    SimulationState state = half.state();
    state.memory = detail::memory_from(text);
    Simulation resumed = simulate(scene);
    resumed.restore(state);
    for (int frame = 4; frame <= 6; ++frame) {
      whole.advance_to_frame(frame, {});
      resumed.advance_to_frame(frame, {});
    }
    EXPECT_EQ(state_hash(whole.state()), state_hash(resumed.state())) << name;
    // And what is remembered matters: without it the run is another one. A blend that has not
    // failed remembers no pause, so it is given one.
    if (name == std::string("implicit_desbrun") || name == std::string("implicit_kang")) continue;
    std::fill(state.memory.begin(), state.memory.end(), 0.0);
    if (name == std::string("implicit_blend")) state.memory[0] = 2.0;
    Simulation forgetful = simulate(scene);
    forgetful.restore(state);
    for (int frame = 4; frame <= 6; ++frame) forgetful.advance_to_frame(frame, {});
    EXPECT_NE(state_hash(whole.state()), state_hash(forgetful.state())) << name;
  }
}

TEST(IntegratorScene, AMemoryThatDoesNotFitIsRefused) {
  Scene scene = flag();
  scene.solver.integrator = "verlet";
  Simulation simulation = simulate(scene);
  SimulationState state = simulation.state();
  state.memory.pop_back();
  EXPECT_THROW(simulation.restore(state), std::invalid_argument);
  EXPECT_THROW(detail::memory_from("0123"), std::invalid_argument);
  EXPECT_THROW(detail::memory_from("012345678901234g"), std::invalid_argument);
  const std::vector<double> numbers{0.1, -0.0, 1e-310, std::numeric_limits<double>::infinity()};
  EXPECT_EQ(detail::memory_from(detail::memory_text(numbers)), numbers);
}

std::string refusal(const Scene& scene) {
  try {
    simulate(scene);
  } catch (const std::invalid_argument& refused) {
    return refused.what();
  }
  return "";
}

TEST(IntegratorScene, AnUnstableStepIsDividedOrRefusedWithTheNumber) {
  Scene scene = flag();
  scene.solver.integrator = "verlet";
  EXPECT_GT(run(scene, 2).steps, 4);
  scene.solver.refuse_unstable_step = true;
  const std::string sentence = refusal(scene);
  EXPECT_NE(sentence.find("verlet"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("time.steps_per_frame to "), std::string::npos) << sentence;
  scene.time.steps_per_frame = 2 * std::stoi(sentence.substr(sentence.find("frame to ") + 9));
  EXPECT_EQ(refusal(scene), "");
}

TEST(IntegratorScene, WhatGrowsInEveryStepIsRefusedUnlessTheSpringsAreDamped) {
  for (const char* name : {"forward_euler", "midpoint"}) {
    Scene scene = flag();
    scene.solver.integrator = name;
    EXPECT_EQ(refusal(scene), "") << name;
    scene.materials["default"].spring_damping = 0.0;
    scene.materials["default"].bending_damping = 0.0;
    scene.air = {};
    EXPECT_NE(refusal(scene).find("spring_damping"), std::string::npos) << name;
  }
}

TEST(IntegratorScene, AStepThatBecomesUnstableEndsTheRunWithTheNumber) {
  Scene scene = flag();
  scene.solver.integrator = "verlet";
  scene.solver.strain_limiter = false;
  scene.solver.refuse_unstable_step = true;
  // Twice as long, the springs across stiffen as they stretch beyond twice their length.
  scene.materials["default"].stretch_stiffness = 0.5;
  scene.materials["default"].shear_stiffness = 0.05;
  scene.time.steps_per_frame = 8;
  scene.gravity = {0, 0, -60};
  try {
    run(scene, 60);
    SUCCEED();
  } catch (const SimulationFailed& failed) {
    EXPECT_EQ(failed.kind, FailureKind::unstable_step);
    EXPECT_NE(std::string(failed.what()).find("verlet is stable up to"), std::string::npos);
  } catch (const std::invalid_argument&) {
    FAIL() << "refused at the start already";
  }
}

TEST(IntegratorScene, UnknownNamesAreRefused) {
  Scene scene = flag();
  scene.solver.integrator = "euler";
  EXPECT_NE(refusal(scene).find("solver.integrator"), std::string::npos);
  scene = flag();
  scene.solver.limiter = "nothing";
  EXPECT_NE(refusal(scene).find("solver.strain_limiter"), std::string::npos);
}

TEST(StrainLimiterScene, TheLedgerShowsWhoLosesMomentum) {
  const auto error = [](const char* name) {
    Scene scene = flag();
    scene.materials["default"].stretch_stiffness = 10.0;
    scene.materials["default"].strain_limit = 0.05;
    scene.handles.clear();
    scene.cloths[0].velocity = Vec3(1, 0, 0);
    scene.air = {};
    scene.gravity.setZero();
    scene.solver.limiter = name;
    // One corner flies away.
    scene.weights.push_back({"button", "flag", {0}, 0.05});
    BuiltScene built = build_scene(scene);
    built.velocity[0] = Vec3(-3, 0, 0);
    Simulation simulation(scene, std::move(built));
    for (int frame = 1; frame <= 8; ++frame) simulation.advance_to_frame(frame, {});
    return simulation.result().ledger.at("strain_limiter").at("max_momentum_error");
  };
  EXPECT_LT(error("position"), 1e-9);
  EXPECT_LT(error("velocity"), 1e-9);
  EXPECT_LT(error("ordered_position"), 1e-9);
  EXPECT_GT(error("velocity_as_printed"), 0.05);
  EXPECT_GT(error("priority_position_velocity"), 1e-3);
}

TEST(StrainLimiterScene, TheCriticalStepIsReported) {
  Scene scene = flag();
  scene.solver.limiter = "critical_step";
  const RunResult result = run(scene, 1);
  EXPECT_GT(result.counters.at("max_critical_step_s"), 1e-5);
  EXPECT_LT(result.counters.at("max_critical_step_s"), 1e-2);
  EXPECT_NEAR(result.counters.at("max_critical_stiffness_factor"),
              std::pow(result.counters.at("max_critical_step_s") * 120.0, 2), 1e-6);
}

TEST(StrainLimiterScene, ChittarosPolicyMakesSoftClothStifferAndItsStepsShorter) {
  Scene soft = flag();
  soft.materials["default"].stretch_stiffness = 5.0;
  soft.solver.limiter = "chittaro";
  const RunResult stiffened = run(soft, 10);
  EXPECT_GT(stiffened.steps, 20);
  soft.solver.limiter = "none";
  soft.solver.strain_limiter = false;
  EXPECT_LT(stiffened.max_stretch, run(soft, 10).max_stretch);
  Scene stiff = flag();
  stiff.solver.limiter = "chittaro";
  EXPECT_EQ(run(stiff, 2).steps, 4);
}

}  // namespace
}  // namespace selvedge::integrator_scene_test
