// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/internal/pattern_files.h>

#include <string>
#include <string_view>
#include <vector>

namespace selvedge::detail {

/// Layers of AAMA/ASTM that are read.
enum class PieceLayer {
  boundary = 1,
  turn = 2,
  curve = 3,
  notch = 4,
  grade = 5,
  mirror = 6,
  grain = 7,
  internal = 8,
  cutout = 11,
  drill = 13,
  sew = 14,
  annotation = 15,
  other = 0
};
/// The layer of a number ("1", "Layer 14") or a name ("Boundary", "sew line").
PieceLayer piece_layer(std::string_view name);

/// A line of a file, in its units.
struct PieceLine {
  PieceLayer layer = PieceLayer::other;
  std::vector<Vec2> points;
  bool is_closed = false;
};
struct PieceText {
  Vec2 at = Vec2::Zero();
  std::string words;
};
/// What a file has of a piece.
struct PieceDrawing {
  std::string name;
  std::vector<PieceLine> lines;
  std::vector<PieceText> texts;       ///< annotations
  std::vector<Vec2> turns, notches;   ///< points
  std::vector<std::string> left_out;  ///< kinds of entities that cannot be read
  int quantity = 1;
};

/// The seam with a number that annotations name, and one of its edges.
struct SeamMark {
  int number = 0;
  std::int32_t panel = 0, edge = 0;
};

/// Makes a panel of a piece, m. `unit`: metres per unit of the file. Appends it to `import`, and
/// its seam marks to `marks`.
void add_piece(const PieceDrawing& drawing, double unit, PatternImport& import,
               std::vector<SeamMark>& marks);
/// Makes stitches of seam marks that have two edges.
void join_marks(const std::vector<SeamMark>& marks, PatternImport& import);

/// Closed loops of the lines of a layer; those that nearly meet are joined within `gap`.
std::vector<std::vector<Vec2>> closed_loops(const PieceDrawing& drawing, PieceLayer layer,
                                            double gap, const std::string& file,
                                            std::vector<std::string>& notes);

/// Largest width or height of a piece, in its units.
double piece_extent(const PieceDrawing& drawing);

}  // namespace selvedge::detail
