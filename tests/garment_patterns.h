// SPDX-License-Identifier: MIT
// Sewing patterns for tests, in both generations of the format.
#pragma once

#include <string>

namespace garment_patterns {

/// A bodice of the newer format, cm: a front with a dart, curves of all kinds and a label, a back
/// that faces the other way, and a strip that is gathered to twice its length.
inline const std::string kBodice = R"({
  "pattern": {
    "panels": {
      "front": {
        "translation": [0, 0, 20], "rotation": [0, 0, 0], "label": "body",
        "vertices": [[-25, 0], [-5, 0], [0, 12], [5, 0], [25, 0], [25, 40], [10, 50], [-10, 50], [-25, 40]],
        "edges": [
          {"endpoints": [0, 1], "label": "lower_interface"}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]},
          {"endpoints": [3, 4], "label": "lower_interface"},
          {"endpoints": [4, 5], "curvature": {"type": "quadratic", "params": [[0.5, -0.05]]}},
          {"endpoints": [5, 6]},
          {"endpoints": [6, 7], "curvature": {"type": "circle", "params": [12, 0, 1]}},
          {"endpoints": [7, 8]},
          {"endpoints": [8, 0], "curvature": {"type": "cubic", "params": [[0.3, 0.05], [0.7, -0.05]]}}
        ]
      },
      "back": {
        "translation": [0, 0, -20], "rotation": [0, 180, 0], "label": "",
        "vertices": [[-25, 0], [25, 0], [25, 40], [10, 50], [-10, 50], [-25, 40]],
        "edges": [
          {"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]},
          {"endpoints": [3, 4], "curvature": {"type": "circle", "params": [30, 0, 1]}},
          {"endpoints": [4, 5]}, {"endpoints": [5, 0]}
        ]
      },
      "frill": {
        "translation": [0, -10, -25], "rotation": [0, 180, 0],
        "vertices": [[-50, -8], [50, -8], [50, 0], [-50, 0]],
        "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}]
      }
    },
    "stitches": [
      [{"panel": "front", "edge": 1}, {"panel": "front", "edge": 2}],
      [{"panel": "front", "edge": 4}, {"panel": "back", "edge": 5}],
      [{"panel": "front", "edge": 8}, {"panel": "back", "edge": 1}],
      [{"panel": "front", "edge": 5}, {"panel": "back", "edge": 4}],
      [{"panel": "front", "edge": 7}, {"panel": "back", "edge": 2}],
      [{"panel": "frill", "edge": 2}, {"panel": "back", "edge": 0}]
    ]
  },
  "parameters": {"length": {"value": 1}}, "parameter_order": ["length"],
  "properties": {"units_in_meter": 100, "curvature_coords": "relative", "normalize_panel_translation": false}
})";

/// A skirt of the older format, in thirds of a centimetre. The loop of the back shows its inner
/// side, so that its seams run from start to start.
inline const std::string kSkirt = R"({
  "pattern": {
    "panels": {
      "front": {
        "translation": [0, -150, 60], "rotation": [0, 0, 0],
        "vertices": [[-100, 0], [100, 0], [60, 150], [-60, 150]],
        "edges": [{"endpoints": [0, 1], "curvature": [0.5, -0.1]}, {"endpoints": [1, 2]},
                  {"endpoints": [2, 3], "curvature": [0.5, 0.1]}, {"endpoints": [3, 0]}]
      },
      "back": {
        "translation": [0, -150, -60], "rotation": [0, 0, 0],
        "vertices": [[-100, 0], [100, 0], [60, 150], [-60, 150]],
        "edges": [{"endpoints": [0, 1], "curvature": [0.5, -0.1]}, {"endpoints": [1, 2]},
                  {"endpoints": [2, 3], "curvature": [0.5, 0.1]}, {"endpoints": [3, 0]}]
      }
    },
    "stitches": [
      [{"panel": "front", "edge": 1}, {"panel": "back", "edge": 1}],
      [{"panel": "front", "edge": 3}, {"panel": "back", "edge": 3}]
    ]
  },
  "properties": {"units_in_meter": 300, "curvature_coords": "relative"}
})";

}  // namespace garment_patterns
