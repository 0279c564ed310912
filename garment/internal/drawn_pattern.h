// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/sewing_pattern.h>

#include <string>
#include <vector>

namespace selvedge {

/// A mark across an edge that meets the mark of the same name on the other side of a seam.
struct PatternNotch {
  std::int32_t edge = 0;
  double at = 0.5;   ///< share of the length of the edge, in [0, 1]
  std::string name;  ///< empty: meets the notch without a name in the same order
};

/// A fold of cloth that is taken out of an edge and lies behind it, such as below a waist.
struct DrawnPleat {
  std::int32_t edge = 0;
  double at = 0.5;      ///< share of the length of the edge: the middle of the cloth taken up
  double depth = 0.0;   ///< m, of the fold: it takes twice as much out of the edge
  double length = 0.0;  ///< m, by which the folds lead straight on from the edge
  bool to_end = false;  ///< the fold lies toward the end of the edge, otherwise toward its start
};

/// A piece as a person draws it: half of it on a fold, one for a pair, with notches.
struct DrawnPanel {
  PatternPanel panel;
  std::int32_t fold =
      -1;                 ///< edge on which the cloth is folded; the other half is its mirror image
  bool is_pair = false;   ///< cut twice, the second time as a mirror image
  bool is_right = false;  ///< one of a pair, drawn for the right side
  Vec2 grain = Vec2(0.0, 1.0);  ///< unit, direction of the warp
  std::vector<PatternNotch> notches{};
  std::vector<DrawnPleat> pleats{};
  std::vector<char> is_taken_up{};  ///< per edge, by pleats: chains pass over it; empty: none is
};

/// Edges that follow each other along the loop of a piece.
struct DrawnLink {
  std::int32_t panel = 0;
  std::vector<std::int32_t> edges;  ///< in the order of the loop
  bool is_mirrored = false;         ///< those of the other half, or of the other one of a pair
};
/// One side of a seam: edges of one piece or of several, such as an armhole of front and back.
/// Those of the mirror image of a piece are named in the order of its loop, too.
using DrawnChain = std::vector<DrawnLink>;

/// Two chains that are sewn together: the end of one meets the start of the other.
struct DrawnStitch {
  DrawnChain a, b;
  bool start_to_start = false;  ///< the starts meet instead
  PatternStitch::Closure closure = PatternStitch::Closure::seam;
  std::vector<double> buttons{};  ///< shares of the length of side a
};

/// A pattern as people draw it.
struct DrawnPattern {
  std::string name;
  std::vector<DrawnPanel> panels;
  std::vector<DrawnStitch> stitches;
};

/// The pattern as it is sewn: folds opened, pairs made (NAME.left and NAME.right), the grain turned
/// upright, and chains divided so that every edge is sewn to one other edge. A chain of one side
/// meets the other by equal shares of length between notches; ends that are less than 3 mm apart
/// meet. A stitch between pieces that both have a mirror image is made twice. Pleats become folds
/// whose halves are sewn to each other along the edge.
/// Throws std::invalid_argument with pattern, stitch or panel, fault and remedy.
SewingPattern as_sewn(const DrawnPattern& drawn);

/// The same pattern with edges that end at the pleats, lines on which they are folded, and stitches
/// that close them. Throws std::invalid_argument for pleats that do not fit on their edge.
DrawnPattern with_pleats(DrawnPattern drawn);

}  // namespace selvedge
