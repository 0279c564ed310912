// SPDX-License-Identifier: MIT
//
// Runs of scenes that a test writes, in a folder of its own.
#pragma once

#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {

/// A separate folder for each test, removed afterwards; results go to its folder `result`.
class SceneRuns : public ::testing::Test {
 protected:
  SceneRuns() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("selvedge_runs_" + std::to_string(getpid()) + "_" + info->name());
    std::filesystem::create_directories(folder_);
    config_.out = folder_ / "result";
  }
  ~SceneRuns() override { std::filesystem::remove_all(folder_); }

  Scene scene(const std::string& json, const std::vector<Override>& overrides = {}) {
    const std::filesystem::path file = folder_ / "scene.json";
    std::ofstream(file) << json;
    return read_scene(file, overrides);
  }

  /// The message that refuses the scene; "" if it runs.
  std::string refusal(const std::string& json) {
    try {
      run_scene(scene(json), config_);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  std::size_t vertices_of_frame(int frame) const {
    return read_mesh(numbered(config_.out / "frames", "cloth", frame, kFrameFileDigits, ".ply"))
        .vertices.size();
  }

  std::filesystem::path folder_;
  RunConfig config_;
};

}  // namespace selvedge
