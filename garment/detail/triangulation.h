// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/garment/detail/grid_plane.h>

#include <array>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Constrained Delaunay triangulation of the plane about a simple loop and lines inside it, with
/// exact decisions.
/// Points are inserted one at a time [Lawson1977]; sides and lines are recovered by flips
/// [Sloan1993]. The first three points are a triangle around everything and belong to no inner
/// triangle.
class Triangulation {
 public:
  static constexpr std::int32_t kOuter = 3;
  static constexpr std::int32_t kNone = -1;

  struct Cell {
    std::array<std::int32_t, 3> v;       // counter-clockwise
    std::array<std::int32_t, 3> across;  // the cell across the side opposite v[i], or kNone
    std::array<bool, 3> fixed = {false, false, false};  // that side is one of the loop or of a line
    bool inside = false;
  };

  /// The first `sides` points are a simple loop (see loop_crossing), the others lie inside. Point i
  /// becomes point kOuter + i. `lines` join two of the points each, cross nothing and pass none.
  Triangulation(std::span<const GridPoint> points, std::int32_t sides,
                std::span<const std::array<std::int32_t, 2>> lines);

  const std::vector<GridPoint>& points() const { return points_; }
  const std::vector<Cell>& cells() const { return cells_; }
  const Cell& cell(std::int32_t c) const { return cells_[c]; }
  /// Some cell with the point.
  std::int32_t cell_of(std::int32_t point) const { return cell_of_[point]; }

  /// A cell that contains p, searched from the cell `start` on.
  std::int32_t locate(const GridPoint& p, std::int32_t start) const;
  /// Inserts p into the inner cell `c` that contains it and flips sides until the triangulation is
  /// constrained Delaunay again. Returns the new point, or kNone where p is a point already or lies
  /// on a side of the loop or outside. changed() then lists the cells that are new.
  std::int32_t insert(const GridPoint& p, std::int32_t c);
  const std::vector<std::int32_t>& changed() const { return changed_; }

  /// The inner cells around a point, counter-clockwise if all cells around it are inner ones.
  void star(std::int32_t point, std::vector<std::int32_t>& cells) const;
  /// Moves a point. The cells around it must stay counter-clockwise.
  void move(std::int32_t point, const GridPoint& to) { points_[point] = to; }
  /// Flips sides until the triangulation is constrained Delaunay.
  void restore();
  /// Whether the side of cell c opposite v[i] can be flipped, and the flip.
  bool can_flip(std::int32_t c, int i) const;
  void flip(std::int32_t c, int i);
  /// Divides the side of cell c opposite v[i], which is not fixed, at p near its middle, without
  /// flips. Returns the new point, or kNone where a cell would have no area.
  std::int32_t divide(std::int32_t c, int i, const GridPoint& p);

 private:
  int side_to(std::int32_t c, std::int32_t other) const;
  int corner_of(std::int32_t c, std::int32_t point) const;
  std::int32_t add_point(const GridPoint& p);
  std::int32_t add_cell(const Cell& cell);
  void replace_across(std::int32_t cell, std::int32_t from, std::int32_t to);
  std::int32_t split_cell(std::int32_t c, const GridPoint& p);
  std::int32_t split_side(std::int32_t c, int i, const GridPoint& p);
  void legalize(std::int32_t point);
  bool is_illegal(std::int32_t c, int i) const;
  bool find_side(std::int32_t a, std::int32_t b, std::int32_t& c, int& i) const;
  void recover(std::int32_t a, std::int32_t b);
  void mark_inside();
  void all_cells_at(std::int32_t point, std::vector<std::int32_t>& cells) const;

  std::vector<GridPoint> points_;
  std::vector<Cell> cells_;
  std::vector<std::int32_t> cell_of_;
  std::vector<std::int32_t> changed_, stack_;
};

}  // namespace selvedge::detail
