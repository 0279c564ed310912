// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/registry.h>
#include <selvedge/core/cloth/cloth_mesh.h>

#include <map>
#include <set>
#include <span>
#include <string_view>
#include <vector>

namespace selvedge {

/// Properties of a pattern.
struct ClothPatternTraits {
  std::string_view promise;  ///< properties of the mesh
  std::string_view source;   ///< author, title, year
  bool splits = false;       ///< its cells or triangles can be split during a run (AdaptiveCloth)
  bool fits_plate = false;   ///< its triangles can be fitted to a plate (make_plate)
  bool two_layers = false;   ///< a second layer follows the vertices of the surface
};

/// The patterns by name. Each fills a rectangle with cloth out of springs, and throws
/// std::invalid_argument if a number is out of range. Cloth that is made out of a mesh or by
/// splitting cells has keys of its own in scenes (add_keyed).
using ClothPatternRegistry =
    Registry<ClothMesh, ClothPatternTraits, const GridConfig&, const Material&>;
ClothPatternRegistry cloth_patterns();

/// A cell of a quadtree grid. Level 0 has cells_x × cells_y cells; level l has 2^l times as many
/// along each side.
struct GridCell {
  std::int32_t level = 0, i = 0, j = 0;
  auto operator<=>(const GridCell&) const = default;
};

/// A rectangular grid whose cells are split in four, adaptively [VillardBorouchaki2005; survey 2.5]
/// or uniformly [ZhangYuen2001; survey 2.2], and joined again. The vertices of level 0 come first,
/// row by row as in make_rectangular, and keep their indices; each split appends its new vertices,
/// and a join keeps the order of those that stay.
///
/// Neighbouring cells differ by at most one level. A hanging node (a node in the middle of the side
/// of a coarser cell) is a vertex of the triangles on both sides, so the surface has no cracks and
/// no overlapping edges. It follows the two ends of that side exactly (Followers). A split
/// places new nodes on the existing surface and moves no point of it, so it cannot cause a
/// collision.
class AdaptiveGrid {
 public:
  /// Largest number of levels beyond level 0.
  static constexpr std::int32_t kMaxLevels = 6;

  /// Throws std::invalid_argument if a size, a material constant or `levels` is out of range, or if
  /// the material uses a law that needs rows of particles.
  AdaptiveGrid(const GridConfig& grid, const Material& material, std::int32_t levels);

  std::int32_t vertex_count() const { return static_cast<std::int32_t>(parents_.size()); }
  /// The cells that are not split, sorted by level and position.
  const std::set<GridCell>& leaves() const { return leaves_; }

  /// Springs, hinges, hanging nodes, masses and the flat rest shape of the current cells. The
  /// spring constants are chosen such that the continuum constants C_ij equal those of
  /// make_rectangular for any cells.
  ClothMesh cloth() const;

  /// Leaves that can still be split (below level `levels`) and whose normal differs from a
  /// neighbour's by more than `angle` (rad) in the state x. Sorted.
  std::vector<GridCell> curved(std::span<const Vec3> x, double angle) const;
  /// All leaves that can still be split.
  std::vector<GridCell> divisible() const;

  /// Splits these cells, and those neighbours that would otherwise be two levels coarser. Cells
  /// that are not leaves are ignored.
  void split(std::span<const GridCell> cells) { split(cells, {}); }
  /// Splits the cells of a cloth in motion: appends the positions (m) and velocities (m/s) of the
  /// new nodes. Mass and momentum are conserved to rounding; kinetic energy and angular momentum
  /// are not, because mass moves from the corners of a cell to its centre.
  void split(std::span<const GridCell> cells, std::vector<Vec3>& x, std::vector<Vec3>& v);

  /// Split cells whose four quarters can be joined: they are leaves, and none of their neighbours
  /// is finer. In the state x the quarters meet each other and their neighbours at no more than
  /// `angle` (rad), and the whole cell would meet no neighbour at more than `limit`, above which
  /// `curved` splits it. Sorted.
  std::vector<GridCell> flat(std::span<const Vec3> x, double angle, double limit) const;
  /// The positions after which joining these cells moves no point of the surface: vertices that go,
  /// and those that hang from then on, lie in the middle between their parents. All vertices, m.
  std::vector<Vec3> flattened(std::span<const GridCell> cells, std::span<const Vec3> x) const;
  /// Joins the quarters of these cells; cells that cannot be joined are ignored. Vertices that are
  /// corners of no leaf are removed. Returns the index of each earlier vertex, -1 if removed.
  std::vector<std::int32_t> join(std::span<const GridCell> cells);
  /// The same for a cloth in motion. `x` is taken to flattened(cells, x). Mass and momentum are
  /// conserved to rounding: a removed vertex gives its momentum to the corners that take its
  /// mass; a vertex that becomes a hanging node gives its ends the difference from their mean.
  std::vector<std::int32_t> join(std::span<const GridCell> cells, std::vector<Vec3>& x,
                                 std::vector<Vec3>& v);
  /// The corners, the side midpoints and the centre of a split cell, where they exist.
  std::vector<std::int32_t> nodes(const GridCell& cell) const;

  /// The two vertices between which vertex i was inserted; (-1, -1) for vertices of level 0.
  const Edge& parents(std::int32_t i) const { return parents_[i]; }

 private:
  using Place = std::array<std::int32_t, 2>;  // position on the lattice of the last level
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
  std::int32_t node(std::int32_t i, std::int32_t j) const;  // -1 if there is no such node
  Corners corners(const GridCell& cell) const;
  std::int32_t middle(std::int32_t a, std::int32_t b) const;
  bool rises(const GridCell& cell) const;
  bool is_leaf(const GridCell& cell) const;
  bool leaf_at(std::int32_t level, std::int32_t i, std::int32_t j, GridCell& leaf) const;
  Vec3 normal(const GridCell& cell, std::span<const Vec3> x) const;
  std::vector<GridCell> neighbours(const GridCell& cell) const;
  double quarter_mass(const GridCell& leaf) const;
  std::vector<double> masses() const;

  bool can_join(const GridCell& cell) const;
  bool is_flat(const GridCell& cell, std::span<const Vec3> x, double angle, double limit) const;
  std::set<GridCell> leaves_without(std::span<const GridCell> joined) const;
  std::vector<char> corners_of(const std::set<GridCell>& leaves) const;
  void hand_momentum(std::span<const GridCell> cells, std::span<const Vec3> v,
                     std::vector<Vec3>& momentum) const;

  void add_surface(ClothMesh& cloth) const;
  void add_springs(ClothMesh& cloth) const;
  void add_hinges(ClothMesh& cloth) const;
  void add_twist_hinge(const GridCell& cell, ClothMesh& cloth) const;
  void add_side_hinges(const GridCell& cell, bool above, ClothMesh& cloth) const;
  void add_twist_hinge(const std::array<std::int32_t, 4>& v, double stiffness,
                       ClothMesh& cloth) const;
  void add_hanging(ClothMesh& cloth) const;

  GridConfig grid_;
  Material material_;
  std::int32_t levels_;
  std::set<GridCell> leaves_;
  std::map<Place, std::int32_t> nodes_;
  std::vector<Place> places_;
  std::vector<Edge> parents_;
};

}  // namespace selvedge
