// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/dress/internal/landmarks.h>
#include <selvedge/garment/sewing_pattern.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace selvedge {

/// What a panel is, and where around the body it belongs.
struct PanelRole {
  enum class Part { unknown, torso, skirt, leg, sleeve, cuff, hood, collar, waistband, patch };
  enum class Side { none, left, right };
  enum class Face { none, front, back };
  Part part = Part::unknown;
  Side side = Side::none;
  Face face = Face::none;
  /// Such as "sleeve.left.front".
  std::string text() const;
};

/// The role that the words of a name give: "left_ftorso", "lfsleeve", "Rback", "sleeve.left".
PanelRole role_of_name(const std::string& name);

struct ArrangeConfig {
  /// Roles of panels by their names, such as {"piece 3", "sleeve.left"}; they go before the words
  /// in the names.
  std::map<std::string, std::string> table;
  double clearance = 0.04;  ///< m, of the panels from the skin
};

/// A pattern whose panels stand around a body.
struct Arrangement {
  SewingPattern pattern;
  std::vector<PanelRole> roles;    ///< per panel
  std::vector<std::string> why;    ///< per panel, what gave its role
  std::vector<std::string> notes;  ///< sentences for the user
};

/// Roles of all panels: by the table, by words in their names, or by what they are sewn to. `why`
/// gets a word for each.
std::vector<PanelRole> panel_roles(const SewingPattern& pattern, const ArrangeConfig& config,
                                   std::vector<std::string>& why);

/// Seams of a pattern that has none, by the outlines that fronts, backs, sleeves, skirts, legs and
/// bands have; panels stand upright. `notes` gets a sentence for each seam and for each run of
/// edges that stays open although another one belongs to it.
SewingPattern guess_seams(const SewingPattern& pattern, const std::vector<PanelRole>& roles,
                          std::vector<std::string>& notes);

/// Reads a pattern without places: JSON as read_sewing_pattern, or DXF or SVG by their suffixes. If
/// a file names no seam, they are guessed. `notes` gets what was met. Errors as
/// read_sewing_pattern.
SewingPattern open_pattern(const std::filesystem::path& file, const ArrangeConfig& config,
                           std::vector<std::string>& notes);

/// Places the panels around the body: those of the trunk and the legs in planes before and behind
/// it, rings of panels, whole sleeves and bands on cylinders around trunk and limbs. The first
/// panel of the trunk hangs from the neck, that of a skirt or of trousers from the waist, and the
/// others beside the edges to which they are sewn. The places that the pattern has are ignored; the
/// pattern and the body have z up. Throws std::invalid_argument for a panel of the table that the
/// pattern does not have, and a role that cannot be read.
Arrangement arrange(const SewingPattern& pattern, const TriangleMesh& body,
                    const BodyLandmarks& landmarks, const ArrangeConfig& config = {});

/// What `arrange` took each panel for, and why: one line for each, then the notes.
std::string arrangement_table(const Arrangement& arrangement);

/// A pattern with z up, turned into axes with `up`: undoes `turned_upright`.
SewingPattern turned_back(SewingPattern pattern, UpAxis up);

/// The body with its landmarks and the panels around it, from the front and from the left side: an
/// SVG document whose unit is the millimetre.
std::string arrangement_svg(const Arrangement& arrangement, const TriangleMesh& body,
                            const BodyLandmarks& landmarks);

}  // namespace selvedge
