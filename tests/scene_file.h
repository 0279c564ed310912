// SPDX-License-Identifier: MIT
//
// A folder for scene files, and a file with every key of the schema; shared by the tests that read
// and build scenes.
#pragma once

#include <gtest/gtest.h>
#include <selvedge/scene/scene.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "garment_patterns.h"

namespace selvedge {

namespace fs = std::filesystem;
using Json = nlohmann::json;

inline const fs::path source_dir = SELVEDGE_SOURCE_DIR;

/// A separate folder for each test, removed afterwards.
class SceneFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("selvedge_scene_" + std::to_string(getpid()) + "_" + info->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  Scene read(const std::string& text, const std::vector<Override>& set = {}) const {
    return read_scene(write("scene.json", text), set);
  }

  /// The message that rejects the text; "" if it is accepted.
  std::string fault(const std::string& text, const std::vector<Override>& set = {}) const {
    return fault_of_file(write("scene.json", text), set);
  }

  std::string fault_of_file(const fs::path& file, const std::vector<Override>& set = {}) const {
    try {
      read_scene(file, set);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

#define EXPECT_SAYS(sentence, part) \
  EXPECT_NE((sentence).find(part), std::string::npos) << "the sentence is: " << (sentence)

inline constexpr const char* quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

inline constexpr const char* garment =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 2 2\nvt 0 2\nvt 5 0\nvt 7 2\nvt 5 2\n"
    "f 1/1 2/2 3/3\nf 1/5 3/6 4/7\n";

/// Two objects; the second has two materials.
inline constexpr const char* parts =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 2 2 2\no skin\nusemtl pale\nf 1 2 3\nf 1 2 4\n"
    "o eyes\ng left right\nf 1 3 4\nusemtl lens\nf 2 3 4\nf 1 2 5\n";

/// A scene with keys of every section, each with a value other than its default.
inline constexpr const char* everything = R"({
  // comments are welcome /* of both */
  "$schema": "scene.schema.json",
  "name": "everything",
  "description": "all keys", /* so */
  "gravity": [1, 2, -3],
  "force_laws": {"hooke": {}},
  "geometry": [
    {"name": "grid", "pattern": "triangular", "size": [0.5, 0.75], "cells": [4, 6],
     "transformation": {"translation": [1, 2, 3], "rotation": {"axis": [0, 0, 2], "angle_deg": 90}}, "scale": 2,
     "velocity": [0, 1, 0], "material": "silk"},
    {"name": "file", "mesh": "quad.obj", "rest_mesh": "rest.obj", "refine": {"when": "settled", "levels": 2}, "transformation": {"translation": [0, 0, 9]},
     "velocity": [0, 0, -1], "material": "silk"},
    {"name": "strip", "size": [0.5, 0.1], "cells": [10, 2],
     "path": {"points": [[0, 0, 20], [0.25, 0, 20], [0.5, 0, 20]], "side": [0, 1, 1]}},
    {"name": "inline", "mesh": {"vertices": [[0, 0, 30], [1, 0, 30], [0, 1, 30]], "triangles": [[0, 1, 2]]},
     "plate": 0.2},
    {"name": "garment", "mesh": "garment.obj", "rest_mesh": "texture", "texture_unit": 0.5,
     "transformation": {"translation": [0, 0, 40]}},
    {"name": "plate", "pattern": "triangular", "plate": 0.25, "virtual_springs": {"stiffness": 7, "follow": true}},
    {"name": "layers", "pattern": {"type": "bilayered", "ratio": 5, "share": 0.3, "hold": 900}},
    {"name": "refined", "refine": {"when": "curved", "levels": 3, "speed": 0.2, "energy": 0.01, "after": 0.7, "angle_deg": 30, "join_deg": 9}},
    {"name": "body", "mesh": {"vertices": [[0, 0, 40], [1, 0, 40], [0, 1, 40], [0, 0, 41]],
     "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]}, "support": {"stiffness": 60, "share": 0.4},
     "virtual_springs": {"stiffness": 3}},
    {"name": "net", "pattern": {"type": "rectangular_net", "structural": 1, "shear": 2, "flexion": 3}},
    {"name": "simple_net", "pattern": {"type": "simplified_net", "structural": 4, "shear": 5, "flexion": 6}},
    {"name": "long_net", "pattern": {"type": "responsive_net", "structural": 7, "shear": 8, "flexion": 9}},
    {"name": "triangle_net", "pattern": {"type": "triangular_net", "structural": 10, "flexion": 11}},
    {"name": "woven", "size": [0.02, 0.02], "cells": [8, 8], "pattern": {"type": "weave", "over": 4, "under": 3, "step": 2, "warp_tex": 21, "weft_tex": 22,
     "modulus": 24, "bending_share": 0.25, "contact": 27, "rotation": 28, "links": 6}},
    {"name": "knitted", "size": [0.02, 0.02], "cells": [8, 8], "pattern": {"type": "knit", "tex": 31, "modulus": 33, "bending_share": 0.35,
     "contact": 36, "sliding": 37, "rotation": 38, "links": 4}},
    {"name": "skirt", "sewing_pattern": "skirt.json", "edge_length": 0.1, "up": "y",
     "panels": {"back": [0, 0.5, 50]}, "transformation": {"translation": [0, 0, 60]}, "material": "silk", "velocity": [0, 0, -2], "virtual_springs": {"stiffness": 5},
     "sewing": {"pull": 30, "merge": 0.03}}
  ],
  "seams": [{"sides": [{"geometry": "grid", "select": "x0"},
             {"geometry": "grid", "select": "x1"}], "reverse": true, "pull": 20, "acceleration": 3, "merge": 0.02,
             "tolerance": 0.01, "damping": 0.1}],
  "water": {"diffusivity": 2e-6, "saturation": 1.5, "sources": [
    {"geometry": "inline", "select": [1], "rate": 0.01, "begin": 0.1, "end": 0.2, "velocity": [0, 0, -3]}]},
  "materials": {"silk": {"density": 0.1, "stretch_stiffness": 400, "shear_stiffness": 50,
    "bending_stiffness": 2e-5, "spring_damping": 0.02, "bending_damping": 0.03, "strain_limit": 0.05,
    "friction": 0.2, "stretch_law": "kawabata", "shear_law": "springs", "bending_law": "bridson",
    "biphasic_strain": 0.03, "biphasic_growth": 7, "kawabata_lt": 0.6, "kawabata_strain": 0.04, "kawabata_rt": 0.6,
    "shear_friction": 0, "bending_friction": 0, "fabric": "petrak_2025/M1",
    "stretch_weft": 300, "bending_weft": 1e-5},
    "sheet": {"stretch_law": "corotated", "poisson": 0.2},
    "tested": {"stretch_law": "measured", "shear_law": "angle",
      "tension_curve": [[0, 0], [0.1, 30]],
      "tension_curve_weft": [[0, 0], [0.1, 20]],
      "shear_curve": [[0, 0], [0.1, 5]],
      "bending_curve": [[0, 0], [100, 0.001]],
      "bending_curve_weft": [[0, 0], [100, 0.0005]]}},
  "handles": [
    {"name": "a", "geometry": "grid", "select": ["x0y0", "x1y0"], "motion": "lift", "release": 0.5},
    {"name": "b", "geometry": "file", "select": [2, 0, 2]},
    {"name": "c", "geometry": "file", "select": {"box": [[0.5, -0.5, 8], [1.5, 0.5, 10]]}},
    {"name": "d", "geometry": "grid", "select": "y1", "motion": []}
  ],
  "weights": [{"geometry": "inline", "select": [1], "mass": 0.5}],
  "motions": {"lift": [{"time": 0}, {"time": 1.5, "translation": [0, 0, 1],
    "rotation": [{"axis": [0, 0, 1], "angle_deg": 90}, {"axis": [1, 0, 0], "angle_deg": 90}]}]},
  "obstacles": [
    {"name": "plane", "shape": {"type": "plane", "size": 3}, "motion": "lift", "friction": 0.7},
    {"name": "box", "shape": {"type": "box", "size": [1, 2, 3]}},
    {"name": "sphere", "shape": {"type": "sphere", "radius": 0.2, "resolution": 16}},
    {"name": "capsule", "shape": {"type": "capsule", "radius": 0.3, "height": 0.4, "resolution": 17}},
    {"name": "cylinder", "shape": {"type": "cylinder", "radius": 0.6, "height": 0.7, "resolution": 18}},
    {"name": "cone", "shape": {"type": "cone", "radius": 0.8, "height": 0.9, "resolution": 19}},
    {"name": "torus", "shape": {"type": "torus", "radius": 0.4, "tube": 0.06, "resolution": 20}},
    {"name": "mesh", "mesh": "quad.obj", "unit": 0.01, "up": "y", "weld": false,
     "transformation": {"translation": [0, 0, 1]}, "motion": "lift", "friction": 0.1},
    {"name": "walk", "sequence": {"files": "walk_###.obj", "fps": 24}, "unit": 0.1,
     "up": "x", "friction": 0.9},
    {"name": "listed", "sequence": {"files": ["walk_007.obj", "walk_008.obj"]}, "groups": ["skin"]},
    {"name": "inline", "mesh": {"vertices": [[0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 2, 3], [1, 2, 3]]},
     "unit": 2},
    {"name": "parts", "mesh": "parts.obj", "groups": ["skin", "pale"]},
    {"name": "heavy", "shape": {"type": "box", "size": [1, 2, 3]}, "mass": 4, "slide": [0, 1, 0], "force": [5, 6, 7],
     "transformation": {"translation": [0, 0, 90]}, "friction": 0.6}
  ],
  "air": {"wind": [1, 0, 0], "normal_drag": 0.5, "viscous_drag": 0.25,
          "gusts": {"speed": 0.75, "length": 2, "seed": 7},
          "jets": [{"position": [1, 2, 3], "direction": [0, 0, 2], "speed": 4, "diameter": 0.5}]},
  "perturbation": {"speed": 1e-5, "seed": 7},
  "time": {"frames": 30, "until": "rest", "fps": 25, "steps_per_frame": 3, "step_error": 0.003, "sleep_speed": 0.02,
           "max_halvings": 4, "energy_guard": false},
  "contact": {"rest_gap": 0.003, "self": false, "broad_phase": {"type": "hash_grid", "cell": 0.5},
              "narrow_phase": {"type": "ccd_exact"}, "response": "impulse", "restitution": 0.25,
              "fail_safe": {"type": "impulse_zones"},
              "start": "untangle", "still_tangled": "carry",
              "pairs": [{"a": "plane", "b": "silk", "friction": 0.6, "rest_gap": 0.004, "collide": true},
                        {"a": "strip", "b": "strip", "friction": 0}]},
  "solver": {"integrator": {"type": "damped_verlet", "drag": 0.25}, "strain_limiter": false, "tolerance": 1e-5},
  "plan": false,
  "closed_form": "free_fall",
  "output": {"formats": ["obj", {"type": "vtk", "binary": true, "digits": 9}, "pc2"],
    "camera": {"eye": [1, 1, 1], "target": [0, 0, 1], "field_of_view": 40}}
})";

class EverythingFile : public SceneFile {
 protected:
  Scene read_everything() const {
    write("quad.obj", quad);
    write("parts.obj", parts);
    write("skirt.json", garment_patterns::kSkirt);
    write("garment.obj", garment);
    write("rest.obj", quad);
    write("walk_007.obj", "usemtl lens\no skin\nusemtl pale\n" + std::string(quad));
    write("walk_008.obj", "usemtl lens\no skin\nusemtl pale\n" + std::string(quad));
    return read(everything);
  }
};

}  // namespace selvedge
