// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/dress/internal/arrange.h>
#include <selvedge/garment/internal/pattern_files.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>

namespace selvedge {

SewingPattern open_pattern(const std::filesystem::path& file, const ArrangeConfig& config,
                           std::vector<std::string>& notes) {
  std::string suffix = file.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  PatternLimits limits;
  limits.places = false;
  if (suffix != ".dxf" && suffix != ".svg") return read_sewing_pattern(file, limits);
  const std::string text = read_whole_file(file, {.what = "pattern", .pipes = true});
  PatternImport import = suffix == ".dxf" ? parse_dxf_pattern(text, file.string())
                                          : parse_svg_pattern(text, file.string());
  notes = std::move(import.notes);
  SewingPattern pattern = as_sewn(import.drawn);
  if (pattern.stitches.empty()) {
    std::vector<std::string> why;
    const std::vector<PanelRole> roles = panel_roles(pattern, config, why);
    pattern = guess_seams(pattern, roles, notes);
  }
  try {
    check_sewing_pattern(pattern, limits);
  } catch (const std::invalid_argument& fault) {
    // Why a panel has no seam.
    std::string met;
    for (const std::string& note : notes)
      if (note.find("no seam") != std::string::npos || note.find("not sewn") != std::string::npos)
        met += "; " + note;
    throw std::invalid_argument(fault.what() + met);
  }
  return pattern;
}

}  // namespace selvedge
