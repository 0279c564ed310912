// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

#include <map>
#include <set>
#include <span>
#include <vector>

namespace selvedge {

/// A cell of a grid that is split in four again and again: level 0 has cells_x × cells_y cells,
/// level l 2^l times as many along each side.
struct GridCell {
  std::int32_t level = 0, i = 0, j = 0;
  auto operator<=>(const GridCell&) const = default;
};

/// A rectangular grid of cells that are split where they need to be [VillardBorouchaki2005; survey
/// 2.5] or everywhere [ZhangYuen2001; survey 2.2]. Vertices keep their indices: those of level 0
/// come first, row by row as in make_rectangular, then those of each split in its order.
///
/// Neighbouring cells differ by one level at most. A node in the middle of a coarser cell's side is
/// a corner of the surface on both sides of it, so that cloth has no gap and no edge lies upon
/// another, and it is tied to the ends of the side (force_tie.cpp). New nodes are put onto the
/// surface that was there, so that a split moves no point of it: what did not touch does not.
class AdaptiveGrid {
 public:
  /// At most so many levels beyond level 0.
  static constexpr std::int32_t max_levels = 6;

  /// Throws std::invalid_argument for sizes, materials and numbers of levels out of range, and laws
  /// that need rows of particles.
  AdaptiveGrid(const GridConfig& grid, const Material& material, std::int32_t levels);

  std::int32_t vertex_count() const { return static_cast<std::int32_t>(parents_.size()); }
  /// The cells that are not split, in the order of their places.
  const std::set<GridCell>& leaves() const { return leaves_; }

  /// Springs, hinges, ties, masses and the flat rest shape of the present cells. The springs have
  /// the constants C_ij of make_rectangular for any cells.
  ClothMesh cloth() const;

  /// Leaves of a level below the last whose normal and that of a neighbour differ by more than
  /// `angle` rad in the state x, sorted.
  std::vector<GridCell> curved(std::span<const Vec3> x, double angle) const;
  /// All leaves of a level below the last.
  std::vector<GridCell> divisible() const;

  /// Splits cells, and neighbours that would be two levels coarser. Those that are no leaves are
  /// left alone.
  void split(std::span<const GridCell> cells) { split(cells, {}); }
  /// The same for a cloth in motion: appends positions, m, and velocities, m/s, of the new nodes.
  /// Mass and momentum are kept to rounding; kinetic energy and angular momentum are not exactly,
  /// as masses go from corners to the middle.
  void split(std::span<const GridCell> cells, std::vector<Vec3>& x, std::vector<Vec3>& v);

  /// The two vertices in whose middle vertex i was made; (-1, -1) on level 0.
  const Edge& parents(std::int32_t i) const { return parents_[i]; }

 private:
  using Place = std::array<std::int32_t, 2>;  // on the lattice of the last level
  struct Motion {
    std::vector<Vec3>*x = nullptr, *v = nullptr;
  };
  struct Corners {
    std::int32_t v00, v10, v01, v11;
  };

  void split(std::span<const GridCell> cells, const Motion& motion);
  void split_cell(const GridCell& cell, const Motion& motion);
  std::int32_t add_middle(std::int32_t a, std::int32_t b, const Motion& motion);
  void add_centre(const GridCell& cell, const Motion& motion);

  std::int32_t width(const GridCell& cell) const { return 1 << (levels_ - cell.level); }
  Place low(const GridCell& cell) const { return {cell.i * width(cell), cell.j * width(cell)}; }
  std::int32_t node(std::int32_t i, std::int32_t j) const;  // -1: none
  Corners corners(const GridCell& cell) const;
  std::int32_t middle(std::int32_t a, std::int32_t b) const;
  bool rises(const GridCell& cell) const;
  bool is_leaf(const GridCell& cell) const;
  bool leaf_at(std::int32_t level, std::int32_t i, std::int32_t j, GridCell& leaf) const;

  void add_surface(ClothMesh& cloth) const;
  void add_masses(ClothMesh& cloth) const;
  void add_springs(ClothMesh& cloth) const;
  void add_hinges(ClothMesh& cloth) const;
  void add_twist_hinge(const GridCell& cell, ClothMesh& cloth) const;
  void add_side_hinges(const GridCell& cell, bool above, ClothMesh& cloth) const;
  void add_side_hinge(const std::array<std::int32_t, 4>& v, double stiffness,
                      ClothMesh& cloth) const;
  void add_ties(ClothMesh& cloth) const;

  GridConfig grid_;
  Material material_;
  std::int32_t levels_;
  std::set<GridCell> leaves_;
  std::map<Place, std::int32_t> nodes_;
  std::vector<Place> places_;
  std::vector<Edge> parents_;
};

}  // namespace selvedge
