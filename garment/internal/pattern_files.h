// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/internal/drawn_pattern.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

/// Pieces of a file that says nothing of seams or places, and what was met in it.
struct PatternImport {
  DrawnPattern drawn;
  std::vector<std::string> notes;  ///< sentences for the user: units, gaps, what was left out
};

/// Reads pattern pieces in DXF by AAMA/ASTM D6673, or plain closed lines. The sew line counts where
/// there is one, else the boundary; turn points, or corners above 25 degrees, end its edges. A
/// mirror line is a fold, a quantity of two a pair, the grain line the warp. Annotations "Seam N",
/// as dxf_pattern_text writes them, join edges. `name` stands for the file in messages.
/// Throws std::invalid_argument with file, piece or line, fault and remedy.
PatternImport parse_dxf_pattern(const std::string& text, const std::string& name);

/// Reads pattern pieces in SVG: one closed path a piece, its title or id the name; groups called
/// grain, sew, notch, mirror and so on count as the layers of DXF. Errors as parse_dxf_pattern.
PatternImport parse_svg_pattern(const std::string& text, const std::string& name);

/// The panels as pieces in DXF by AAMA/ASTM D6673, in millimetres: boundaries as POLYLINE on layer
/// 1, turn points, curve points, grain lines, and an annotation "Seam N" in the middle of each sewn
/// edge. Curves are chords: lengths are within 0.1 %.
std::string dxf_pattern_text(const SewingPattern& pattern);

}  // namespace selvedge
