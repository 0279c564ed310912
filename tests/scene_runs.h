// SPDX-License-Identifier: MIT
//
// Runs of scenes that a test writes, in a folder of its own.
#pragma once

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>

#include "scene_file.h"

namespace selvedge {

/// Results go to the folder `result` in the folder of the test.
class SceneRuns : public SceneFile {
 protected:
  void SetUp() override {
    SceneFile::SetUp();
    config_.out = folder_ / "result";
  }

  /// The message that refuses the scene; "" if it runs.
  std::string refusal(const std::string& json) {
    try {
      run_scene(read(json), config_);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  std::size_t vertices_of_frame(int frame) const {
    return read_mesh(numbered(config_.out / "frames", "cloth", frame, kFrameFileDigits, ".ply"))
        .vertices.size();
  }

  RunConfig config_;
};

}  // namespace selvedge
