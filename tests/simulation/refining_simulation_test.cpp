// SPDX-License-Identifier: MIT
//
// Scenes whose mesh changes: steps in memory, runs and resumed runs have the same bits and
// counters.
#include <gtest/gtest.h>
#include <selvedge/run/run.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

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
  Simulation simulation(scene);
  simulation.advance_to_frame(scene.time.frames);
  return state_hash(simulation.state());
}

TEST_F(RefiningSimulations, StepsInMemorySplitAndJoinToTheBitsOfARun) {
  int number = 0;
  for (const std::string& json : {over_ball(kCurved), over_ball(kSettled), kSagging}) {
    const Scene s = read(json);
    config_.out = folder_ / std::to_string(number++);
    EXPECT_EQ(hash_in_memory(s), run_scene(s, config_).state_hash) << json;
  }
}

TEST_F(RefiningSimulations, AChangeOfTheMeshIsAStepOnceAtAFrame) {
  const Scene s = read(kSagging, {{"time.frames", "45"}});
  Simulation simulation(s);
  int changes = 0;
  while (!simulation.reached(45)) {
    const double before = simulation.time();
    simulation.step();
    if (simulation.time() > before) continue;
    ++changes;
    EXPECT_TRUE(simulation.is_at_frame());
    EXPECT_TRUE(simulation.last_step().lengths.empty());
    simulation.step();
    EXPECT_GT(simulation.time(), before) << "once at each frame";
  }
  EXPECT_GT(changes, 0);
  const RunResult result = simulation.result();
  EXPECT_GT(result.counters.at("joined_cells"), 0.0);
  EXPECT_EQ(result.state_hash, hash_in_memory(s));
}

TEST_F(RefiningSimulations, AStateOfAnotherMeshIsRestoredToTheSameBits) {
  const Scene s = read(over_ball(kCurved));
  Simulation simulation(s);
  const SimulationState start = simulation.state();
  simulation.advance_to_frame(9);
  const SimulationState refined = simulation.state();
  ASSERT_GT(refined.x.size(), start.x.size());
  simulation.advance_to_frame(s.time.frames);
  const std::string end = state_hash(simulation.state());
  for (const SimulationState& state : {refined, start}) {
    simulation.restore(state);
    EXPECT_EQ(simulation.time(), state.time);
    simulation.advance_to_frame(s.time.frames);
    EXPECT_EQ(state_hash(simulation.state()), end);
  }
}

TEST_F(RefiningSimulations, ArraysOfAnEarlierMeshStayWithTheirOwner) {
  Simulation simulation(read(over_ball(kCurved)));
  const auto owner = simulation.owner();
  const auto triangles = simulation.cloth_triangles();
  const Triangle first = triangles[0];
  simulation.advance_to_frame(9);
  ASSERT_NE(simulation.owner(), owner);
  EXPECT_EQ(triangles[0], first);
}

TEST_F(RefiningSimulations, InputsOnAMeshThatChangesAreRefused) {
  Simulation simulation(read(over_ball(kCurved)));
  try {
    simulation.set_forces({});
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_SAYS(std::string(error.what()), "\"refine\" changes the mesh");
  }
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
