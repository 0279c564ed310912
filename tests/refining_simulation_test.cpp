// SPDX-License-Identifier: MIT
//
// Frames of scenes whose mesh changes begin in one place: steps in memory, runs and resumed runs
// have the same bits and counters, and a Simulation refuses such scenes.
#include <gtest/gtest.h>
#include <selvedge/run/run.h>
#include <selvedge/simulation/refinement.h>

#include <cstdint>
#include <stdexcept>
#include <string>

#include "refined_scenes.h"
#include "scene_runs.h"

namespace selvedge::refining_simulation_test {
namespace {

class RefiningSimulations : public SceneRuns {};

/// The hash after all frames of a scene that is stepped in memory.
std::string hash_in_memory(const Scene& scene) {
  const Methods methods;
  RefiningSimulation simulation(scene, build_scene(scene), methods);
  simulation.advance_to_frame(scene.time.frames);
  return state_hash(simulation.now().state());
}

TEST_F(RefiningSimulations, StepsInMemorySplitAndJoinToTheBitsOfARun) {
  int number = 0;
  for (const std::string& json : {over_ball(kCurved), over_ball(kSettled), kSagging}) {
    const Scene s = read(json);
    config_.out = folder_ / std::to_string(number++);
    EXPECT_EQ(hash_in_memory(s), run_scene(s, config_).state_hash) << json;
  }
}

TEST_F(RefiningSimulations, SingleStepsBeginTheFramesThatTheyStartFrom) {
  const Scene s = read(kSagging, {{"time.frames", "45"}});
  const Methods methods;
  RefiningSimulation simulation(s, build_scene(s), methods);
  while (!simulation.now().reached(45)) simulation.step();
  const RunResult result = simulation.result();
  EXPECT_GT(result.counters.at("joined_cells"), 0.0);
  EXPECT_EQ(result.state_hash, hash_in_memory(s));
  simulation.begin_frame();
  const std::int64_t steps = simulation.now().state().step;
  simulation.begin_frame();
  EXPECT_EQ(simulation.now().state().step, steps) << "a frame begins once";
}

TEST_F(RefiningSimulations, ASimulationWithOneMeshRefusesThem) {
  const Scene s = read(over_ball(kCurved));
  for (int constructor = 0; constructor < 3; ++constructor) try {
      if (constructor == 0) Simulation simulation(s);
      if (constructor == 1) Simulation simulation(s, build_scene(s));
      if (constructor == 2) Simulation simulation(s, build_scene(s), SimulationState{});
      ADD_FAILURE() << constructor;
    } catch (const std::invalid_argument& error) {
      EXPECT_SAYS(std::string(error.what()), "\"refine\" changes the mesh");
      EXPECT_SAYS(std::string(error.what()), "RefiningSimulation");
    }
  EXPECT_NO_THROW(Simulation(with_fixed_mesh(s), build_scene(s)));
}

TEST_F(RefiningSimulations, TheCountersOfAResumedRunGoOn) {
  const RunResult whole = run_scene(read(over_ball(kCurved)), config_);
  config_.out = folder_ / "in_parts";
  const RunResult part = run_scene(read(over_ball(kCurved), {{"time.frames", "9"}}), config_);
  config_.resume = true;
  const RunResult resumed = run_scene(read(over_ball(kCurved)), config_);
  EXPECT_EQ(resumed.counters, whole.counters);
  EXPECT_EQ(resumed.ledger, whole.ledger);
  for (const auto& [name, figures] : part.plan) {
    EXPECT_GE(resumed.plan.at(name).asked, whole.plan.at(name).asked) << name;
    EXPECT_GE(resumed.plan.at(name).left_out, figures.left_out) << name;
  }
}

}  // namespace
}  // namespace selvedge::refining_simulation_test
