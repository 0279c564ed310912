// SPDX-License-Identifier: MIT
// Runs of scenes that are made in code, as the sample of the README makes them.
#include <gtest/gtest.h>
#include <selvedge/scene/run.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

class RunOfASceneMadeInCode : public testing::Test {
 protected:
  RunOfASceneMadeInCode() {
    scene_.materials["default"] = {};
    scene_.cloths.emplace_back().shape = ClothGrid{.grid = {.cells_x = 8, .cells_y = 8}};
    scene_.cloths[0].placement.translation = {0.0, 0.0, 0.32};
    scene_.bodies.emplace_back().shape = BodyShape{Sphere{.radius = 0.3}, 16};
    scene_.time.frames = 3;
    config_.out = fs::path(testing::TempDir()) / ("selvedge_run_" + std::to_string(getpid()));
  }
  ~RunOfASceneMadeInCode() override { fs::remove_all(config_.out); }

  Scene scene_;
  RunConfig config_;
};

TEST_F(RunOfASceneMadeInCode, RepeatsInItsFolderWithTheSameBits) {
  const RunResult first = run_scene(scene_, config_);
  const RunResult second = run_scene(scene_, config_);
  EXPECT_TRUE(first.clean);
  EXPECT_EQ(first.frames, 4);
  EXPECT_EQ(first.state_hash, second.state_hash);
}

TEST_F(RunOfASceneMadeInCode, LeavesTheFolderOfAnotherSceneAlone) {
  scene_.name = "one";
  run_scene(scene_, config_);
  scene_.name = "other";
  EXPECT_THROW(run_scene(scene_, config_), std::invalid_argument);
}

TEST_F(RunOfASceneMadeInCode, IsNotResumedBecauseItCannotBeCompared) {
  run_scene(scene_, config_);
  config_.resume = true;
  EXPECT_THROW(run_scene(scene_, config_), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge
