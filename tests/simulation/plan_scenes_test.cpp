// SPDX-License-Identifier: MIT
// Every scene file of the repository in shadow: with proofs and without, a run gives the same bits
// and the same counts, so that what was left out would have done nothing; what is refused is
// refused by both in the same words.
#include <gtest/gtest.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge::plan_scenes_test {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(SELVEDGE_SOURCE_DIR) / "data";

/// All there are, so that none can be forgotten: "scenes/flag", ...
std::vector<std::string> scene_files() {
  std::vector<std::string> names;
  for (const char* folder : {"scenes", "extreme", "experiments"})
    for (const auto& entry : fs::directory_iterator(kData / folder))
      if (entry.path().extension() == ".json" && entry.path().filename() != "scene.schema.json")
        names.push_back(std::string(folder) + "/" + entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// How a run ended: what it said, if it could not start or go on.
struct Shadow {
  std::string stopped;
  RunResult result;
};

/// Some frames of each; small cloth for longer, so that what meets after a while meets, too.
/// Counted is what has been done, because cells are split as they run.
bool goes_on(int frame, double particle_steps) {
  constexpr int least = 3, most = 30;
  constexpr double enough = 1e4;
  return frame < least || (frame < most && particle_steps < enough);
}

Shadow run(Scene scene, bool proofs) {
  scene.plan.proofs = proofs;
  const Methods methods;
  Shadow shadow;
  try {
    Simulation simulation(scene, methods);
    try {
      double done = 0.0;
      for (int frame = 0; frame < scene.time.frames && goes_on(frame, done); ++frame) {
        simulation.advance_to_frame(
            frame + 1, [&](double) { done += static_cast<double>(simulation.state().x.size()); });
      }
    } catch (const std::runtime_error& error) {  // a step that cannot be made clean
      shadow.stopped = error.what();
    }
    shadow.result = simulation.result();
  } catch (const std::invalid_argument& error) {  // it cannot start
    shadow.stopped = error.what();
  }
  return shadow;
}

/// All counts but of the work that is left out.
std::map<std::string, double> what_was_found(const RunResult& result) {
  std::map<std::string, double> counters = result.counters;
  counters.erase("candidate_rebuilds");
  return counters;
}

class PlanOfScene : public ::testing::TestWithParam<std::string> {};

TEST_P(PlanOfScene, GivesTheSameBits) {
  Scene scene;
  try {
    scene = read_scene(kData / (GetParam() + ".json"), {});
  } catch (const std::invalid_argument& error) {
    GTEST_SKIP() << error.what();
  }
  const Shadow with = run(scene, true), without = run(scene, false);
  EXPECT_EQ(with.stopped, without.stopped);
  const RunResult &on = with.result, &off = without.result;
  EXPECT_EQ(on.state_hash, off.state_hash);
  EXPECT_EQ(on.steps, off.steps);
  EXPECT_EQ(on.halvings, off.halvings);
  EXPECT_EQ(on.clean, off.clean);
  EXPECT_EQ(on.max_stretch, off.max_stretch);
  EXPECT_EQ(on.strain_residual, off.strain_residual);
  EXPECT_EQ(on.worst_self_intersections, off.worst_self_intersections);
  EXPECT_EQ(on.worst_body_intersections, off.worst_body_intersections);
  EXPECT_EQ(what_was_found(on), what_was_found(off));
  EXPECT_EQ(on.ledger, off.ledger);
  for (const auto& [part, p] : off.plan) EXPECT_EQ(p.left_out, 0) << part;
}

INSTANTIATE_TEST_SUITE_P(All, PlanOfScene, ::testing::ValuesIn(scene_files()),
                         [](const auto& info) {
                           std::string name = info.param;
                           for (char& c : name)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return name;
                         });

}  // namespace
}  // namespace selvedge::plan_scenes_test
