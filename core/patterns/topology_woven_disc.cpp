// SPDX-License-Identifier: MIT
//
// A disc cut out of a rectangular mesh, as a drape tester's specimen is cut out of a fabric.
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/angles.h>
#include <selvedge/core/cloth/detail/grid_bending.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace selvedge {
namespace {

/// The edges with one triangle, sorted.
std::vector<Edge> border_edges(std::span<const Triangle> triangles) {
  std::map<Edge, int> count;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k)
      ++count[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
  std::vector<Edge> border;
  for (const auto& [edge, triangles_of_edge] : count)
    if (triangles_of_edge == 1) border.push_back(edge);
  return border;
}

/// Angle by which the path v[0] -> v[1] -> v[2] turns, rad.
double turn(std::span<const Vec3> x, const std::array<std::int32_t, 3>& v) {
  return detail::angle_between(x[v[1]] - x[v[0]], x[v[2]] - x[v[1]]);
}

/// How the two triangles of a hinge change when its vertices move from `before` to `now`.
struct HingeChange {
  double stiffness;  ///< factor that keeps the bending energy per area
  double area;       ///< factor of the area
  double angle;      ///< factor of the angle under a curvature of the cloth
};

double doubled_hinge_area(std::span<const Vec3> x, const std::array<std::int32_t, 4>& v) {
  const Vec3 edge = x[v[3]] - x[v[2]];
  return edge.cross(x[v[0]] - x[v[2]]).norm() + edge.cross(x[v[1]] - x[v[2]]).norm();
}

HingeChange hinge_change(std::span<const Vec3> before, std::span<const Vec3> now,
                         const std::array<std::int32_t, 4>& v) {
  HingeChange change{};
  change.stiffness = detail::hinge_stiffness(v, now, 1.0) / detail::hinge_stiffness(v, before, 1.0);
  change.area = doubled_hinge_area(now, v) / doubled_hinge_area(before, v);
  change.angle = std::sqrt(change.area / change.stiffness);
  return change;
}

/// Moves the border vertices onto the circle and sets the rest shape of all elements to the result.
/// The circle flattens some triangles, and a hinge at a flat triangle turns far under a small
/// curvature, so hinges get the stiffness and the friction of their new shape.
void push_rim_out(ClothMesh& disc, double radius, const Material& material) {
  const std::vector<Vec3> before = disc.surface.vertices;
  std::vector<char> moved(disc.surface.vertices.size(), 0);
  for (const Edge& edge : border_edges(disc.surface.triangles))
    for (const std::int32_t v : edge) {
      disc.surface.vertices[v] *= radius / disc.surface.vertices[v].norm();
      moved[v] = 1;
    }
  const auto& x = disc.surface.vertices;
  for (Spring& s : disc.springs) s.rest_length = (x[s.b] - x[s.a]).norm();
  for (MembraneTriangle& triangle : disc.membranes)
    for (int k = 0; k < 3; ++k) triangle.rest[k] = {x[triangle.v[k]].x(), x[triangle.v[k]].y()};
  for (YarnTriangle& triangle : disc.yarns)
    for (int k = 0; k < 3; ++k) triangle.rest[k] = {x[triangle.v[k]].x(), x[triangle.v[k]].y()};
  for (BucklingLink& link : disc.links) {
    if (moved[link.a] == 0 && moved[link.b] == 0) continue;
    link.rest_length = (x[link.b] - x[link.a]).norm();
    link.onset = std::max(link.onset, detail::least_onset(link.rigidity, link.rest_length));
  }
  const auto has_moved = [&](const auto& element) {
    return std::any_of(element.v.begin(), element.v.end(), [&](auto v) { return moved[v] != 0; });
  };
  for (Hinge& hinge : disc.hinges)
    if (has_moved(hinge)) hinge.stiffness *= hinge_change(before, x, hinge.v).stiffness;
  for (HingeFriction& friction : disc.hinge_frictions) {
    if (!has_moved(friction)) continue;
    const HingeChange change = hinge_change(before, x, friction.v);
    friction.moment *= change.area / change.angle;  // the same work per area and curvature
    friction.yield *= change.angle;
  }
  const auto turn_where_moved = [&](auto& elements) {
    for (auto& element : elements)
      if (has_moved(element)) element.rest_angle = turn(x, element.v);
  };
  turn_where_moved(disc.twists);
  turn_where_moved(disc.corner_frictions);
  disc.mass = vertex_areas(x, disc.surface.triangles);
  for (double& m : disc.mass) m *= material.density;
}

/// The cells of a square grid whose centres lie in the disc.
class DiscCells {
 public:
  DiscCells(double radius, std::int32_t cells) : radius_(radius), cells_(cells) {}

  /// True if the cell of a triangle lies in the disc. The triangle has three corners of the cell.
  bool contains(const Triangle& t) const {
    std::int32_t column = cells_, row = cells_;
    for (const std::int32_t v : t) {
      column = std::min(column, v % (cells_ + 1));
      row = std::min(row, v / (cells_ + 1));
    }
    const double size = 2.0 * radius_ / cells_;
    const Vec3 centre = size * Vec3(column + 0.5, row + 0.5, 0.0) - Vec3(radius_, radius_, 0.0);
    return centre.norm() < radius_;
  }

  /// Leaves out the elements on four vertices whose triangles are not both in the disc, by the
  /// vertex -1. A corner of the ragged rim has the four vertices of such an element without having
  /// its cells, and on the circle one of its triangles would lie folded onto the other.
  void leave_out_across_rim(auto& elements) const {
    for (auto& element : elements)
      if (!contains({element.v[0], element.v[2], element.v[3]}) ||
          !contains({element.v[1], element.v[2], element.v[3]}))
        element.v[0] = -1;
  }

 private:
  double radius_;
  std::int32_t cells_;
};

}  // namespace

ClothMesh make_woven_disc(double radius, std::int32_t cells, const Material& material) {
  constexpr std::int32_t kFewest = 8;
  require(cells >= kFewest, "cells across the disc", cells, "at least 8");
  if (!bending_law_of(material).on_cut_cells || !material.bending_curve.empty())
    throw std::invalid_argument(
        "bending_law \"" + material.bending_law +
        "\" or bending_curve needs straight rows of whole cells, but the rim of a disc cuts them; "
        "use \"hinge\", a free mesh of triangles with \"shape_operator\", or a square cloth");
  ClothMesh grid = make_rectangular({2.0 * radius, 2.0 * radius, cells, cells}, material);
  // A cell is either entirely in the disc or not at all, and its diagonals with it.
  const DiscCells disc_cells(radius, cells);
  std::vector<Triangle> inside;
  for (const Triangle& t : grid.surface.triangles)
    if (disc_cells.contains(t)) inside.push_back(t);
  disc_cells.leave_out_across_rim(grid.hinges);
  disc_cells.leave_out_across_rim(grid.hinge_frictions);
  ClothMesh disc = cut(grid, inside);
  push_rim_out(disc, radius, material);
  return disc;
}

}  // namespace selvedge
