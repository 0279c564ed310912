// SPDX-License-Identifier: MIT
// The largest stable steps that `stability` finds, against what theory says of them.
#include <gtest/gtest.h>
#include <selvedge/compare/internal/stability.h>

#include <cmath>

#include "run_program.h"

namespace selvedge::stability_test {
namespace {

using namespace selvedge::testing;

/// A square decimetre, free, without damping.
Scene patch() {
  Scene scene;
  scene.materials["default"].spring_damping = 0.0;
  scene.materials["default"].bending_damping = 0.0;
  scene.cloths.emplace_back().shape =
      ClothGrid{.grid = {.size_x = 0.1, .size_y = 0.1, .cells_x = 5, .cells_y = 5}};
  return scene;
}

StabilityRow row(const std::string& integrator, double stiffness, double damping = 0.0) {
  StabilityConfig config;
  config.steps = 600;
  return largest_stable_step(integrator, StabilitySubject(patch(), stiffness, 1.0, damping),
                             config);
}

TEST(Stability, TwoParticlesOfOneSpringHaveTheFrequencyOfTheTextbook) {
  Scene scene = patch();
  StabilitySubject subject(scene, 0.0, 1.0, 0.0);
  subject.cloth.hinges.clear();
  subject.cloth.springs = {{0, 1, subject.cloth.springs[0].rest_length, 40.0, 0.0}};
  subject.cloth.curve_of_spring.clear();
  subject.cloth.mass.assign(subject.cloth.mass.size(), 0.1);
  subject.inv_mass.assign(subject.inv_mass.size(), 10.0);
  EXPECT_NEAR(fastest_mode(subject).omega, std::sqrt(2.0 * 40.0 / 0.1), 1e-3);
}

TEST(Stability, SymplecticEulerAndVerletHoldUpToTwoOverOmega) {
  for (const char* name : {"symplectic_euler", "verlet"}) {
    const StabilityRow r = row(name, 500.0);
    EXPECT_NEAR(r.measured / r.predicted, 1.0, 0.03) << name;
    EXPECT_LE(r.bound, r.predicted * 1.001) << name;
  }
}

TEST(Stability, RungeKuttaOfFourthOrderHoldsUpToItsOwnLimit) {
  const StabilityRow r = row("runge_kutta_4", 500.0);
  EXPECT_NEAR(r.measured / r.predicted, 1.0, 0.03);
  const StabilityRow verlet = row("verlet", 500.0);
  EXPECT_NEAR(r.predicted / verlet.predicted, std::sqrt(2.0), 0.01);  // 2.83 against 2
}

TEST(Stability, FourTimesTheStiffnessHalvesTheStep) {
  EXPECT_NEAR(row("symplectic_euler", 400.0).measured / row("symplectic_euler", 1600.0).measured,
              2.0, 0.06);
}

TEST(Stability, ALightParticleShortensTheStepByTheRootOfItsMass) {
  StabilityConfig config;
  config.steps = 600;
  const StabilitySubject alike(patch(), 500.0, 1.0, 0.0), light(patch(), 500.0, 1e-2, 0.0);
  const double ratio = fastest_mode(light).omega / fastest_mode(alike).omega;
  EXPECT_GT(ratio, 3.0);
  EXPECT_LT(ratio, 10.0);
  const StabilityRow r = largest_stable_step("symplectic_euler", light, config);
  EXPECT_NEAR(r.measured / r.predicted, 1.0, 0.03);
}

/// The patch held by two corners, to swing.
Scene hung_patch() {
  Scene scene = patch();
  scene.cloths[0].name = "cloth";
  scene.handles.push_back({"corners", "cloth", {30, 35}, {}, {}});
  return scene;
}

TEST(Stability, ALimiterDoesNotLengthenTheStepOfAClothThatSwings) {
  StabilityConfig config;
  config.steps = 400;
  const StabilitySubject subject(hung_patch(), 500.0, 1.0, 0.0);
  const double bound = 2.0 / fastest_mode(subject).omega;
  for (const char* limiter : {"none", "ordered_position", "ordered_position_velocity"}) {
    config.limiter = limiter;
    EXPECT_TRUE(try_step_length("verlet", subject, 0.9 * bound, config).stable) << limiter;
    EXPECT_FALSE(try_step_length("verlet", subject, 1.1 * bound, config).stable) << limiter;
    EXPECT_TRUE(try_step_length("implicit_euler", subject, 20.0 * bound, config).stable) << limiter;
  }
}

TEST(Stability, ALimiterHoldsBackWhatOneLongImplicitStepOvershoots) {
  // From level, a net has no stiffness across: a long linearised step falls as if nothing held it.
  StabilityConfig config;
  config.steps = 400;
  const StabilitySubject soft(hung_patch(), 50.0, 1.0, 0.0);
  const double step = 100.0 * 2.0 / fastest_mode(soft).omega;
  config.limiter = "none";
  EXPECT_FALSE(try_step_length("implicit_euler", soft, step, config).stable);
  config.limiter = "ordered_position";
  EXPECT_TRUE(try_step_length("implicit_euler", soft, step, config).stable);
}

TEST(Stability, ImplicitEulerHoldsAtAnyStepAndForwardEulerAtNone) {
  const StabilityRow implicit = row("implicit_euler", 500.0);
  EXPECT_TRUE(implicit.any_step);
  EXPECT_EQ(implicit.measured, 1.0);
  EXPECT_EQ(row("forward_euler", 500.0).bound, 0.0);
}

// 100,000 inner steps are not enough for 1 s of springs with periods of some 20 microseconds.
TEST(Stability, AStepThatNeedsTooManyInnerStepsIsNotUnstable) {
  StabilityConfig config;
  config.seconds = 0.01;
  const StabilityMap map = map_stability("rkf45", patch(), {1e6}, {1e-4, config.longest}, config);
  EXPECT_EQ(map.verdict,
            (std::vector<StabilityVerdict>{StabilityVerdict::stable, StabilityVerdict::refused}));
}

TEST(Stability, TheMapTellsStableFromRefusedFromUnstable) {
  StabilityConfig config;
  config.steps = 300;
  const StabilityMap map =
      map_stability("symplectic_euler", patch(), {100.0, 1e4}, {1e-5, 1.0}, config);
  EXPECT_EQ(map.verdict[0], StabilityVerdict::stable);
  EXPECT_EQ(map.verdict[1], StabilityVerdict::unstable);
  EXPECT_GT(map.bound[0], map.bound[1]);
  EXPECT_NE(draw_maps({map}).find("symplectic_euler"), std::string::npos);
}

class StabilityCommand : public Program {};

TEST_F(StabilityCommand, PrintsARowForEachIntegratorAndStiffnessAndDrawsTheMap) {
  write("patch.json", R"({"geometry": [{"size": [0.1, 0.1], "cells": [3, 3]}]})");
  const Outcome outcome =
      run("stability patch.json --integrator symplectic_euler,implicit_euler --stiffness 100,1000 "
          "--steps 100 --map map.svg --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  EXPECT_EQ(Json::parse(outcome.out)["results"].size(), 4u);
  EXPECT_SAYS(content(folder_ / "map.svg"), "<svg");
  EXPECT_REFUSED(run("stability patch.json --integrator leap"), "there is no \"leap\"");
  EXPECT_REFUSED(run("stability patch.json --strain-limiter rope"), "there is no \"rope\"");
  EXPECT_REFUSED(run("stability patch.json --strain-limiter all"), "takes one name");
}

// -- the scenes of a folder -----------------------------------------------------------------------

const std::string kCases = std::string("stability ") + SELVEDGE_SOURCE_DIR + "/data/extreme ";

class SettledFolder : public Program {};

TEST_F(SettledFolder, ARowEachWithItsAnswerAndEnergyLedger) {
  const Outcome outcome = run(kCases + "--cases s03_dup,s17_one_triangle --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  const auto rows = Json::parse(outcome.out)["results"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0]["answer"], "refused");
  EXPECT_SAYS(rows[0]["note"].get<std::string>(), "weld");
  EXPECT_EQ(rows[1]["answer"], "correct");
  EXPECT_TRUE(rows[1]["given_J"].contains("response"));
}

TEST_F(SettledFolder, AnyFolderWithScenesButNotTheirSchemas) {
  fs::create_directories(folder_ / "own");
  fs::copy_file(folder_ / "small.json", folder_ / "own/small.json");
  write("own/inside.json", R"({
    "geometry": [{"size": [0.2, 0.2], "cells": [3, 3]}],
    "obstacles": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.1, "resolution": 8}}],
    "time": {"frames": 1}})");
  write("own/x.schema.json", "{}");
  const Outcome outcome = run("stability own --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  const auto rows = Json::parse(outcome.out)["results"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0]["case"], "inside");
  EXPECT_EQ(rows[0]["answer"], "refused");
  EXPECT_EQ(rows[1]["case"], "small");
  EXPECT_EQ(rows[1]["answer"], "correct");
  EXPECT_EQ(rows[1]["crossings"], 0);
}

TEST_F(SettledFolder, OneThatTakesTooLongIsUnfinishedAndNotTheEnd) {
  const Outcome outcome = run(kCases + "--cases knot,s17_empty --limit 0.5");
  EXPECT_EQ(outcome.code, 0) << "it says nothing against the program";
  EXPECT_SAYS(outcome.out, "unfinished | 0");
  EXPECT_SAYS(outcome.out, "s after 0.5 s of the processor");
  EXPECT_SAYS(outcome.out, "1 refused, 1 unfinished, 0 FAILED");
}

TEST_F(SettledFolder, AStepLongerThanItsTimeIsUnfinishedToo) {
  fs::create_directories(folder_ / "slow");
  write("slow/slow.json", R"({
    "geometry": [{"size": [1, 1], "cells": [40, 40]}],
    "solver": {"integrator": {"type": "rkf45", "error": 1e-30}},
    "time": {"frames": 1}})");
  const Outcome outcome = run("stability slow --limit 0.1");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_SAYS(outcome.out, "unfinished | a step takes more than 0.3 s of the processor");
  EXPECT_SAYS(outcome.out, "1 unfinished, 0 FAILED");
}

TEST_F(SettledFolder, MethodsOfOneFamilyAreTriedOnEveryScene) {
  const auto answers = [&](const std::string& option) {
    const Outcome outcome = run(kCases + "--cases s17_one_triangle --json " + option);
    EXPECT_EQ(outcome.code, 0) << outcome.err << outcome.out;
    std::vector<std::string> methods;
    const Json all = Json::parse(outcome.out);
    for (const Json& row : all["results"]) methods.push_back(row["method"].get<std::string>());
    return methods;
  };
  EXPECT_EQ(answers(""), (std::vector<std::string>{""}));
  EXPECT_EQ(answers("--integrators verlet,bdf2"), (std::vector<std::string>{"verlet", "bdf2"}));
  EXPECT_EQ(answers("--limiters none,velocity"), (std::vector<std::string>{"none", "velocity"}));
  EXPECT_EQ(answers("--responses impulse"), (std::vector<std::string>{"impulse"}));
  EXPECT_REFUSED(run(kCases + "--limiters velocity --integrators verlet"), "give only one of");
  EXPECT_REFUSED(run(kCases + "--integrators verlett"), "nearest is \"verlet\"");
}

TEST_F(SettledFolder, AMethodReplacesThatOfTheScene) {
  const auto stretch = [&](const std::string& option) {
    const Outcome outcome = run(kCases + "--cases s01_stiffness --json " + option);
    const Json all = Json::parse(outcome.out);
    return all["results"][0]["max_stretch"].get<double>();
  };
  EXPECT_EQ(stretch("--integrators implicit_blend"), stretch(""));
  EXPECT_NE(stretch("--integrators bdf2"), stretch(""));
}

TEST_F(SettledFolder, OptionsOfTheOtherKindOfRunAreRefused) {
  const std::string data = std::string(SELVEDGE_SOURCE_DIR) + "/data/";
  EXPECT_REFUSED(run(kCases + "--steps 20"), "--steps: ");
  EXPECT_REFUSED(run("stability " + data + "scenes/flag.json --cases s03"), "--cases: ");
  EXPECT_REFUSED(run(kCases + "--cases s99"), "there is no scene \"s99\"");
  EXPECT_REFUSED(run("stability " + data + "makers"), "the folder has no scenes");
}

}  // namespace

}  // namespace selvedge::stability_test
