// SPDX-License-Identifier: MIT
//
// Joins the quarters of cells of an adaptive mesh (topology_adaptive.cpp) where the cloth has
// become flat. The paper that splits cells, J. Villard, H. Borouchaki, "Adaptive meshing for cloth
// animation", Engineering with Computers 2005 (survey section 2.5), only splits; this is ours.
//
// A quarter of mass m gives m/4 to each of its corners. So a whole cell of mass 4 m gives each
// corner 3 m/4 more than before: m/4 from each of two side midpoints and from the centre. These
// hand over the momentum of that mass with their own velocity.
#include <selvedge/core/cloth/detail/angles.h>
#include <selvedge/core/cloth/followers.h>
#include <selvedge/core/patterns/cloth_pattern.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

std::array<GridCell, 4> quarters(const GridCell& cell) {
  std::array<GridCell, 4> parts;
  for (std::int32_t k = 0; k < 4; ++k)
    parts[k] = {cell.level + 1, 2 * cell.i + k % 2, 2 * cell.j + k / 2};
  return parts;
}

}  // namespace

/// Four leaves, without a node on their sides: a finer neighbour would be two levels below the
/// whole cell.
bool AdaptiveGrid::can_join(const GridCell& cell) const {
  for (const GridCell& part : quarters(cell)) {
    if (!is_leaf(part)) return false;
    const Corners c = corners(part);
    for (const auto& [a, b] : {Edge{c.v00, c.v10}, {c.v01, c.v11}, {c.v00, c.v01}, {c.v10, c.v11}})
      if (middle(a, b) >= 0) return false;
  }
  return true;
}

bool AdaptiveGrid::is_flat(const GridCell& cell, std::span<const Vec3> x, double angle,
                           double limit) const {
  const Vec3 whole = normal(cell, x);
  for (const GridCell& part : quarters(cell)) {
    const Vec3 n = normal(part, x);
    // Neighbours of a quarter are other quarters, or beyond the side of the whole cell.
    for (const GridCell& other : neighbours(part)) {
      const Vec3 m = normal(other, x);
      if (!(detail::angle_between(n, m) <= angle) || !(detail::angle_between(whole, m) <= limit))
        return false;
    }
  }
  return true;
}

std::vector<GridCell> AdaptiveGrid::flat(std::span<const Vec3> x, double angle,
                                         double limit) const {
  std::vector<GridCell> cells;
  for (const GridCell& leaf : leaves_) {
    const GridCell whole{leaf.level - 1, leaf.i / 2, leaf.j / 2};
    // Of its quarters, the first one speaks for the cell.
    if (leaf.level == 0 || leaf != quarters(whole)[0]) continue;
    if (can_join(whole) && is_flat(whole, x, angle, limit)) cells.push_back(whole);
  }
  return cells;
}

std::vector<std::int32_t> AdaptiveGrid::nodes(const GridCell& cell) const {
  std::vector<std::int32_t> found;
  for (const GridCell& part : quarters(cell)) {
    const Corners c = corners(part);
    for (const std::int32_t v : {c.v00, c.v10, c.v01, c.v11})
      if (v >= 0) found.push_back(v);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::set<GridCell> AdaptiveGrid::leaves_without(std::span<const GridCell> joined) const {
  std::set<GridCell> leaves = leaves_;
  for (const GridCell& cell : joined) {
    if (!can_join(cell)) continue;
    for (const GridCell& part : quarters(cell)) leaves.erase(part);
    leaves.insert(cell);
  }
  return leaves;
}

std::vector<char> AdaptiveGrid::corners_of(const std::set<GridCell>& leaves) const {
  std::vector<char> is_corner(parents_.size(), 0);
  for (const GridCell& leaf : leaves) {
    const Corners c = corners(leaf);
    for (const std::int32_t v : {c.v00, c.v10, c.v01, c.v11}) is_corner[v] = 1;
  }
  return is_corner;
}

// The parents of a vertex come before it, so that they are in their places already.
std::vector<Vec3> AdaptiveGrid::flattened(std::span<const GridCell> cells,
                                          std::span<const Vec3> x) const {
  const std::set<GridCell> leaves = leaves_without(cells);
  const std::vector<char> stays = corners_of(leaves);
  std::vector<char> follows(parents_.size(), 0);
  for (std::size_t i = 0; i < stays.size(); ++i) follows[i] = !stays[i];
  for (const GridCell& leaf : leaves) {
    const Corners c = corners(leaf);
    for (const auto& [a, b] : {Edge{c.v00, c.v10}, {c.v01, c.v11}, {c.v00, c.v01}, {c.v10, c.v11}})
      if (const std::int32_t m = middle(a, b); m >= 0) follows[m] = 1;
  }
  std::vector<Vec3> places(x.begin(), x.end());
  for (std::size_t i = 0; i < places.size(); ++i)
    if (follows[i]) places[i] = 0.5 * (places[parents_[i][0]] + places[parents_[i][1]]);
  return places;
}

std::vector<std::int32_t> AdaptiveGrid::join(std::span<const GridCell> cells) {
  leaves_ = leaves_without(cells);
  const std::vector<char> stays = corners_of(leaves_);
  std::vector<std::int32_t> number(stays.size(), -1);
  std::vector<Place> places;
  std::vector<Edge> parents;
  nodes_.clear();
  for (std::size_t i = 0; i < stays.size(); ++i) {
    if (!stays[i]) continue;
    number[i] = static_cast<std::int32_t>(places.size());
    nodes_[places_[i]] = number[i];
    places.push_back(places_[i]);
    const auto [a, b] = parents_[i];
    parents.push_back(a < 0 ? Edge{-1, -1} : Edge{number[a], number[b]});
  }
  places_ = std::move(places);
  parents_ = std::move(parents);
  return number;
}

/// Moves the momentum of the mass that changes its vertex when these cells are joined.
void AdaptiveGrid::hand_momentum(std::span<const GridCell> cells, std::span<const Vec3> v,
                                 std::vector<Vec3>& momentum) const {
  for (const GridCell& cell : cells) {
    if (!can_join(cell)) continue;
    const double share = quarter_mass(quarters(cell)[0]);
    const Corners c = corners(cell);
    const auto give = [&](std::int32_t from, std::int32_t to) {
      momentum[from] -= share * v[from];
      momentum[to] += share * v[from];
    };
    for (const auto& [a, b] :
         {Edge{c.v00, c.v10}, {c.v01, c.v11}, {c.v00, c.v01}, {c.v10, c.v11}}) {
      give(middle(a, b), a);
      give(middle(a, b), b);
    }
    const std::int32_t centre = middle(c.v00, c.v11);
    for (const std::int32_t corner : {c.v00, c.v10, c.v01, c.v11}) give(centre, corner);
  }
}

std::vector<std::int32_t> AdaptiveGrid::join(std::span<const GridCell> cells, std::vector<Vec3>& x,
                                             std::vector<Vec3>& v) {
  for (const std::size_t size : {x.size(), v.size()})
    if (size != parents_.size())
      throw std::invalid_argument("join: " + std::to_string(size) +
                                  " positions or velocities for " +
                                  std::to_string(parents_.size()) + " vertices of the grid");
  const std::vector<double> before = masses();
  std::vector<Vec3> momentum;
  for (std::size_t i = 0; i < v.size(); ++i) momentum.push_back(before[i] * v[i]);
  hand_momentum(cells, v, momentum);
  const std::vector<Vec3> places = flattened(cells, x);
  const std::vector<std::int32_t> number = join(cells);
  const ClothMesh after = cloth();
  std::vector<Vec3> new_x(parents_.size()), new_v(parents_.size());
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    const bool same = momentum[i] == before[i] * v[i];
    new_x[number[i]] = places[i];
    new_v[number[i]] = same ? v[i] : Vec3(momentum[i] / after.mass[number[i]]);
  }
  std::vector<double> inv_mass;
  for (const double m : after.mass) inv_mass.push_back(1.0 / m);
  Followers(after).hand_over(after.mass, inv_mass, new_v);
  x = std::move(new_x);
  v = std::move(new_v);
  return number;
}

}  // namespace selvedge
