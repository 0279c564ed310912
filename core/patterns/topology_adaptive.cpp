// SPDX-License-Identifier: MIT
//
// Adaptive mesh after J. Villard, H. Borouchaki, "Adaptive meshing for cloth animation",
// Engineering with Computers 2005 (survey section 2.5): a quad is split in four where the angle
// between the normals of neighbours exceeds a threshold. A node in the middle of a side that the
// neighbour does not share moves with that side, x_mid = (x_a + x_b)/2 (followers.cpp). A uniformly
// split mesh is the multi-level mesh of D. Zhang, M. Yuen, "Cloth simulation using multilevel
// meshes", Computers & Graphics 2001 (survey section 2.2).
//
// The spring constants of a cell depend on its proportions, not on its size: it adds half the
// structural constant to each side and the full constant to each diagonal. A side of two halves has
// two springs in series, each twice as stiff. So the C_ij are those of the rectangular mesh for any
// splitting. With x_mid in the middle a uniform strain is in equilibrium everywhere: central
// symmetry and the virial alone determine the corner forces of a square under uniform stress, so
// these equal an even traction on its sides, half to each end.
//
// Hinges between cells of the same size are those of make_rectangular. Between a cell of height g
// and two of height h, an edge of length l represents the area l (g + h)/2 and rotates by κ (g +
// h)/2: its stiffness is 2 B l/(g + h), half at each end. With the law `beam`, two beams of lengths
// g and h and of rigidity ½ B l stand at each end instead. adaptive_joining.cpp joins cells.
#include <selvedge/core/cloth/detail/angles.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/patterns/cloth_pattern.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

detail::CellConstants constants_of(const GridConfig& grid, const Material& m) {
  detail::CellConstants c = detail::cell_sides(grid);
  const double l_squared = c.a * c.a + c.b * c.b, ratio = c.a / c.b;
  const double g = m.shear_stiffness;
  const auto [c11, c22] = detail::stretch_constants(m.stretch_stiffness, stretch_along_weft(m), g);
  c.spring_x = (c11 - g * ratio * ratio) / ratio;
  c.spring_y = (c22 - g / (ratio * ratio)) * ratio;
  c.spring_diagonal = g * l_squared / (2.0 * c.a * c.b);
  return c;
}

GridConfig finest(GridConfig grid, std::int32_t levels) {
  detail::validate_grid(grid);
  require(levels >= 0 && levels <= AdaptiveGrid::kMaxLevels, "levels", levels, "between 0 and 6");
  constexpr std::int32_t most_cells = 1 << 24;  // the indices of the last level must fit an int32_t
  require(std::max(grid.cells_x, grid.cells_y) < most_cells, "cells to split",
          std::max(grid.cells_x, grid.cells_y), "below 2^24");
  grid.cells_x <<= levels;
  grid.cells_y <<= levels;
  return grid;
}

}  // namespace

AdaptiveGrid::AdaptiveGrid(const GridConfig& grid, const Material& material, std::int32_t levels)
    : grid_(grid), material_(material), levels_(levels) {
  detail::validate_grid(finest(grid, levels));
  detail::validate_material(material);
  detail::require_hinges(material, "a grid that is split", true);
  detail::validate_cells(constants_of(grid, material), material);
  const std::int32_t width = 1 << levels;
  for (std::int32_t j = 0; j <= grid.cells_y; ++j)
    for (std::int32_t i = 0; i <= grid.cells_x; ++i) {
      nodes_[{i * width, j * width}] = vertex_count();
      places_.push_back({i * width, j * width});
      parents_.push_back({-1, -1});
      if (i < grid.cells_x && j < grid.cells_y) leaves_.insert({0, i, j});
    }
}

std::int32_t AdaptiveGrid::node(std::int32_t i, std::int32_t j) const {
  const auto found = nodes_.find({i, j});
  return found == nodes_.end() ? -1 : found->second;
}

AdaptiveGrid::Corners AdaptiveGrid::corners(const GridCell& cell) const {
  const auto [i, j] = low(cell);
  const std::int32_t w = width(cell);
  return {node(i, j), node(i + w, j), node(i, j + w), node(i + w, j + w)};
}

/// The node halfway between two nodes, or -1.
std::int32_t AdaptiveGrid::middle(std::int32_t a, std::int32_t b) const {
  const Place p = places_[a], q = places_[b];
  if ((p[0] + q[0]) % 2 != 0 || (p[1] + q[1]) % 2 != 0) return -1;
  return node((p[0] + q[0]) / 2, (p[1] + q[1]) / 2);
}

/// The diagonal of a cell has the direction of its cell of level 0, so that the triangles of its
/// parts lie on the triangles of the whole cell.
bool AdaptiveGrid::rises(const GridCell& cell) const {
  return ((cell.i >> cell.level) + (cell.j >> cell.level)) % 2 == 0;
}

bool AdaptiveGrid::is_leaf(const GridCell& cell) const { return leaves_.contains(cell); }

/// The leaf that equals or contains a cell. False outside the grid and where the cell is split.
bool AdaptiveGrid::leaf_at(std::int32_t level, std::int32_t i, std::int32_t j,
                           GridCell& leaf) const {
  if (i < 0 || j < 0) return false;
  for (; level >= 0; --level, i /= 2, j /= 2)
    if (is_leaf({level, i, j})) {
      leaf = {level, i, j};
      return true;
    }
  return false;
}

// -- splitting ------------------------------------------------------------------------------------

std::int32_t AdaptiveGrid::add_middle(std::int32_t a, std::int32_t b, const Motion& motion) {
  if (const std::int32_t m = middle(a, b); m >= 0) return m;
  const Place place{(places_[a][0] + places_[b][0]) / 2, (places_[a][1] + places_[b][1]) / 2};
  const std::int32_t m = vertex_count();
  nodes_[place] = m;
  places_.push_back(place);
  parents_.push_back({a, b});
  if (motion.x == nullptr) return m;
  motion.x->push_back(0.5 * ((*motion.x)[a] + (*motion.x)[b]));
  motion.v->push_back(0.5 * ((*motion.v)[a] + (*motion.v)[b]));
  return m;
}

// The centre lies on the diagonal of the surface. Its velocity conserves the momentum of the cell,
// a quarter of its mass times the sum over its corners: the mean of the corners, minus half of the
// excess velocity of the side midpoints over their ends (midpoints that existed before may differ).
void AdaptiveGrid::add_centre(const GridCell& cell, const Motion& motion) {
  const Corners c = corners(cell);
  const bool up = rises(cell);
  add_middle(up ? c.v00 : c.v10, up ? c.v11 : c.v01, motion);
  if (motion.v == nullptr) return;
  const std::vector<Vec3>& v = *motion.v;
  const auto excess = [&](std::int32_t a, std::int32_t b) {
    return Vec3(v[middle(a, b)] - 0.5 * (v[a] + v[b]));
  };
  const Vec3 mean = 0.25 * ((v[c.v00] + v[c.v10]) + (v[c.v01] + v[c.v11]));
  motion.v->back() = mean - 0.5 * ((excess(c.v00, c.v10) + excess(c.v01, c.v11)) +
                                   (excess(c.v00, c.v01) + excess(c.v10, c.v11)));
}

void AdaptiveGrid::split_cell(const GridCell& cell, const Motion& motion) {
  if (!is_leaf(cell) || cell.level >= levels_) return;
  for (const auto& [di, dj] : {Place{-1, 0}, Place{1, 0}, Place{0, -1}, Place{0, 1}})
    if (GridCell leaf; leaf_at(cell.level, cell.i + di, cell.j + dj, leaf))
      if (leaf.level < cell.level) split_cell(leaf, motion);
  const Corners c = corners(cell);
  add_middle(c.v00, c.v10, motion);
  add_middle(c.v01, c.v11, motion);
  add_middle(c.v00, c.v01, motion);
  add_middle(c.v10, c.v11, motion);
  add_centre(cell, motion);
  leaves_.erase(cell);
  for (std::int32_t part = 0; part < 4; ++part)
    leaves_.insert({cell.level + 1, 2 * cell.i + part % 2, 2 * cell.j + part / 2});
}

void AdaptiveGrid::split(std::span<const GridCell> cells, const Motion& motion) {
  const std::vector<GridCell> order(cells.begin(), cells.end());
  for (const GridCell& cell : order) split_cell(cell, motion);
}

void AdaptiveGrid::split(std::span<const GridCell> cells, std::vector<Vec3>& x,
                         std::vector<Vec3>& v) {
  for (const std::size_t size : {x.size(), v.size()})
    if (size != parents_.size())
      throw std::invalid_argument("split: " + std::to_string(size) +
                                  " positions or velocities for " +
                                  std::to_string(parents_.size()) + " vertices of the grid");
  split(cells, Motion{&x, &v});
}

std::vector<GridCell> AdaptiveGrid::divisible() const {
  std::vector<GridCell> cells;
  for (const GridCell& leaf : leaves_)
    if (leaf.level < levels_) cells.push_back(leaf);
  return cells;
}

Vec3 AdaptiveGrid::normal(const GridCell& cell, std::span<const Vec3> x) const {
  const Corners c = corners(cell);
  return (x[c.v11] - x[c.v00]).cross(x[c.v01] - x[c.v10]);
}

/// The leaves of the same level or coarser beyond the sides of a cell.
std::vector<GridCell> AdaptiveGrid::neighbours(const GridCell& cell) const {
  std::vector<GridCell> found;
  for (const auto& [di, dj] : {Place{1, 0}, Place{0, 1}, Place{-1, 0}, Place{0, -1}})
    if (GridCell other; leaf_at(cell.level, cell.i + di, cell.j + dj, other))
      found.push_back(other);
  return found;
}

std::vector<GridCell> AdaptiveGrid::curved(std::span<const Vec3> x, double angle) const {
  std::vector<GridCell> cells;
  for (const GridCell& leaf : leaves_)
    for (const GridCell& other : neighbours(leaf)) {
      const Vec3 n = normal(leaf, x), m = normal(other, x);
      if (detail::angle_between(n, m) <= angle) continue;
      for (const GridCell& cell : {leaf, other})
        if (cell.level < levels_) cells.push_back(cell);
    }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

// ----------------------------------------------------------------- the cloth of the current cells

ClothMesh AdaptiveGrid::cloth() const {
  ClothMesh cloth;
  add_surface(cloth);
  cloth.mass = masses();
  add_springs(cloth);
  add_hinges(cloth);
  add_hanging(cloth);
  detail::set_stretch_law(cloth, cloth.surface.vertices, material_);
  return cloth;
}

void AdaptiveGrid::add_surface(ClothMesh& cloth) const {
  const double a = grid_.size_x / (grid_.cells_x << levels_);
  const double b = grid_.size_y / (grid_.cells_y << levels_);
  for (const auto& [i, j] : places_)
    cloth.surface.vertices.emplace_back(i * a - 0.5 * grid_.size_x, j * b - 0.5 * grid_.size_y,
                                        0.0);
  std::vector<Triangle>& triangles = cloth.surface.triangles;
  // Half a cell: two sides that meet at `peak`, and the diagonal, which no neighbour can split.
  const auto add_half = [&](std::int32_t from, std::int32_t peak, std::int32_t to) {
    const std::int32_t m = middle(from, peak), n = middle(peak, to);
    if (m < 0 && n < 0) triangles.push_back({from, peak, to});
    if (m >= 0 && n < 0) triangles.insert(triangles.end(), {{from, m, to}, {m, peak, to}});
    if (m < 0 && n >= 0) triangles.insert(triangles.end(), {{from, peak, n}, {from, n, to}});
    if (m >= 0 && n >= 0)
      triangles.insert(triangles.end(), {{from, m, to}, {m, n, to}, {m, peak, n}});
  };
  for (const GridCell& leaf : leaves_) {
    const Corners c = corners(leaf);
    if (rises(leaf)) {
      add_half(c.v00, c.v10, c.v11);
      add_half(c.v11, c.v01, c.v00);
    } else {
      add_half(c.v01, c.v00, c.v10);
      add_half(c.v10, c.v11, c.v01);
    }
  }
  cloth.edges = unique_edges(triangles);
}

double AdaptiveGrid::quarter_mass(const GridCell& leaf) const {
  const double area = (grid_.size_x / grid_.cells_x) * (grid_.size_y / grid_.cells_y);
  return 0.25 * material_.density * std::ldexp(area, -2 * leaf.level);
}

// A vertex gets a quarter of the mass of each cell of which it is a corner.
std::vector<double> AdaptiveGrid::masses() const {
  std::vector<double> mass(parents_.size(), 0.0);
  for (const GridCell& leaf : leaves_) {
    const Corners c = corners(leaf);
    for (const std::int32_t v : {c.v00, c.v10, c.v01, c.v11}) mass[v] += quarter_mass(leaf);
  }
  return mass;
}

void AdaptiveGrid::add_springs(ClothMesh& cloth) const {
  const detail::CellConstants k = constants_of(grid_, material_);
  std::map<Edge, double> stiffness;
  const auto add = [&](std::int32_t a, std::int32_t b, double share) {
    if (share > 0.0) stiffness[{std::min(a, b), std::max(a, b)}] += share;
  };
  const auto add_side = [&](std::int32_t a, std::int32_t b, double spring) {
    const std::int32_t m = middle(a, b);
    if (m < 0) return add(a, b, 0.5 * spring);
    add(a, m, spring);
    add(m, b, spring);
  };
  for (const GridCell& leaf : leaves_) {
    const Corners c = corners(leaf);
    add_side(c.v00, c.v10, k.spring_x);
    add_side(c.v01, c.v11, k.spring_x);
    add_side(c.v00, c.v01, k.spring_y);
    add_side(c.v10, c.v11, k.spring_y);
    add(c.v00, c.v11, k.spring_diagonal);
    add(c.v10, c.v01, k.spring_diagonal);
  }
  const std::vector<Vec3>& x = cloth.surface.vertices;
  for (const auto& [edge, value] : stiffness) {
    cloth.springs.push_back(
        {edge[0], edge[1], (x[edge[1]] - x[edge[0]]).norm(), value, material_.spring_damping});
    cloth.strain_limit.push_back(material_.strain_limit);
  }
}

void AdaptiveGrid::add_hinges(ClothMesh& cloth) const {
  if (material_.bending_stiffness <= 0.0) return;
  for (const GridCell& leaf : leaves_) {
    add_twist_hinge(leaf, cloth);
    add_side_hinges(leaf, true, cloth);
    add_side_hinges(leaf, false, cloth);
  }
}

void AdaptiveGrid::add_twist_hinge(const GridCell& leaf, ClothMesh& cloth) const {
  const detail::CellConstants k = detail::cell_sides(grid_);
  const double rigidity = std::sqrt(material_.bending_stiffness * bending_along_weft(material_));
  const double stiffness = 2.0 * rigidity * k.a * k.b / (k.a * k.a + k.b * k.b);
  const Corners c = corners(leaf);
  if ((leaf.i + leaf.j) % 2 == 0)
    add_twist_hinge({c.v01, c.v10, c.v00, c.v11}, stiffness, cloth);
  else
    add_twist_hinge({c.v00, c.v11, c.v10, c.v01}, stiffness, cloth);
}

void AdaptiveGrid::add_twist_hinge(const std::array<std::int32_t, 4>& v, double stiffness,
                                   ClothMesh& cloth) const {
  cloth.hinges.push_back(
      {v, 0.0, stiffness, material_.bending_damping, bending_law_of(material_).by_sine});
}

// The hinges between a leaf and its neighbour above (beyond its side of larger y) or to its right.
// The side of the coarser of the two has one hinge at each end.
void AdaptiveGrid::add_side_hinges(const GridCell& leaf, bool above, ClothMesh& cloth) const {
  const std::int32_t w = width(leaf);
  const Place corner = low(leaf);
  const std::int32_t i = corner[0], j = corner[1];
  // Nodes by their distance along the side and across it.
  const auto at = [&](std::int32_t along, std::int32_t across) {
    return above ? node(i + along, j + w + across) : node(i + w + across, j + along);
  };
  GridCell other;
  const bool found = leaf_at(leaf.level, leaf.i + (above ? 0 : 1), leaf.j + (above ? 1 : 0), other);
  std::int32_t length = w, beyond = w;
  if (!found) {  // the border, or smaller cells
    beyond = w / 2;
    if (beyond == 0 || at(0, beyond) < 0) return;
  } else if (other.level < leaf.level) {
    // One of two smaller cells at the side of a larger one: only the first of the two adds the
    // hinges.
    if ((above ? leaf.i : leaf.j) % 2 != 0) return;
    length = beyond = 2 * w;
  }
  const detail::CellConstants k = detail::cell_sides(grid_);
  const double ratio = above ? k.a / k.b : k.b / k.a;
  const double rigidity = above ? bending_along_weft(material_) : material_.bending_stiffness;
  const double stiffness = rigidity * ratio * 2.0 * length / (w + beyond);
  const BendingLaw& law = bending_law_of(material_);
  const std::int32_t a = at(0, 0), b = at(length, 0);
  // Metres, of the edge and across it; a hinge stands for half of their product.
  const double finest = std::ldexp(1.0, -levels_);
  const double edge = finest * length * (above ? k.a : k.b);
  const double span = finest * 0.5 * (w + beyond) * (above ? k.b : k.a);
  for (const std::int32_t end : {0, length}) {
    const std::int32_t far = at(end, beyond), near = at(end, -w);
    const double unit = above ? finest * k.b : finest * k.a;
    const std::array<std::int32_t, 4> v =
        above ? std::array{far, near, a, b} : std::array{near, far, a, b};
    law.add_to_side(cloth,
                    {.hinge = v,
                     .stiffness = 0.5 * stiffness,
                     .line = {near, at(end, 0), far},
                     .length = {unit * w, unit * beyond},
                     .rigidity_width = 0.5 * rigidity * edge},
                    material_);
    if (material_.bending_friction > 0.0)
      cloth.hinge_frictions.push_back(
          {v, 0.0, 0.5 * material_.bending_friction * edge, detail::kYieldCurvature * span});
  }
}

void AdaptiveGrid::add_hanging(ClothMesh& cloth) const {
  const auto add = [&](std::int32_t a, std::int32_t b) {
    if (const std::int32_t m = middle(a, b); m >= 0) cloth.hanging.push_back({{m, a, b}});
  };
  for (const GridCell& leaf : leaves_) {
    const Corners c = corners(leaf);
    add(c.v00, c.v10);
    add(c.v01, c.v11);
    add(c.v00, c.v01);
    add(c.v10, c.v11);
  }
}

void register_refined(ClothPatternRegistry& registry) {
  registry.add_keyed(
      "refine curved", "geometry.*.refine",
      {.promise = "cells split where they bend; hanging nodes exactly in the middle, no gap",
       .source = "Villard, Borouchaki, Adaptive meshing for cloth animation, 2005"});
  registry.add_keyed("refine settled", "geometry.*.refine",
                     {.promise = "cells split everywhere at rest; mass and momentum kept",
                      .source = "Zhang, Yuen, Cloth simulation using multilevel meshes, 2001"});
}

}  // namespace selvedge
