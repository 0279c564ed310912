// SPDX-License-Identifier: MIT
//
// Scenes whose cells are split and joined; shared by the tests of refinement.
#pragma once

#include <string>

namespace selvedge {

inline const std::string kBall = R"(,
  "obstacles": [{"shape": {"type": "sphere", "radius": 0.15, "resolution": 16}}],
  "time": {"frames": 16, "fps": 60})";

inline std::string over_ball(const std::string& keys, const std::string& more = "") {
  return R"({"geometry": [{"size": [0.6, 0.6], "cells": [8, 8],
    "transformation": {"translation": [0, 0, 0.156]}, )" +
         keys + "}]" + kBall + more + "}";
}

inline const std::string kCurved = R"("refine": {"when": "curved", "levels": 2, "angle_deg": 12})";
inline const std::string kSettled =
    R"("refine": {"when": "settled", "levels": 2, "speed": 100, "after": 0.08})";

/// A strip between two edges that come nearer, so that it sags, and part again.
inline const std::string kSagging = R"({"geometry": [{"size": [0.6, 0.15], "cells": [8, 2],
    "refine": {"when": "curved", "levels": 2, "angle_deg": 12, "join_deg": 5}}],
  "handles": [{"select": "x0", "motion": [{"time": 0, "translation": [0, 0, 0]},
                {"time": 0.3, "translation": [0.15, 0, 0]}, {"time": 0.6, "translation": [0, 0, 0]}]},
              {"select": "x1"}],
  "materials": {"default": {"bending_stiffness": 1e-4, "bending_damping": 1e-4}},
  "time": {"frames": 60, "fps": 60}})";

}  // namespace selvedge
