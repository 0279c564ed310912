// SPDX-License-Identifier: MIT
//
// A disc cut out of a rectangular mesh, as a drape tester's specimen is cut out of a fabric.
#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/detail/grid_bending.h>
#include <selvedge/core/detail/topology.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

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
  const Vec3 in = x[v[1]] - x[v[0]], out = x[v[2]] - x[v[1]];
  return std::atan2(in.cross(out).norm(), in.dot(out));
}

/// Moves the border vertices onto the circle and sets the rest shape of all elements to the result.
void push_rim_out(ClothMesh& disc, double radius, const Material& material) {
  std::vector<char> moved(disc.surface.vertices.size(), 0);
  for (const Edge& edge : border_edges(disc.surface.triangles))
    for (const std::int32_t v : edge) {
      disc.surface.vertices[v] *= radius / disc.surface.vertices[v].norm();
      moved[v] = 1;
    }
  const auto& x = disc.surface.vertices;
  for (Spring& s : disc.springs) s.rest_length = (x[s.b] - x[s.a]).norm();
  for (BucklingLink& link : disc.links) {
    if (moved[link.a] == 0 && moved[link.b] == 0) continue;
    link.rest_length = (x[link.b] - x[link.a]).norm();
    link.onset = std::max(link.onset, detail::least_onset(link.rigidity, link.rest_length));
  }
  const auto turn_where_moved = [&](auto& elements) {
    for (auto& element : elements)
      if (std::any_of(element.v.begin(), element.v.end(), [&](auto v) { return moved[v] != 0; }))
        element.rest_angle = turn(x, element.v);
  };
  turn_where_moved(disc.twists);
  turn_where_moved(disc.corner_frictions);
  disc.mass = vertex_areas(x, disc.surface.triangles);
  for (double& m : disc.mass) m *= material.density;
}

}  // namespace

ClothMesh make_woven_disc(double radius, std::int32_t cells, const Material& material) {
  constexpr std::int32_t kFewest = 8;
  require(cells >= kFewest, "cells across the disc", cells, "at least 8");
  const ClothMesh grid = make_rectangular({2.0 * radius, 2.0 * radius, cells, cells}, material);
  // A cell is either entirely in the disc or not at all, and its diagonals with it.
  const double size = 2.0 * radius / cells;
  std::vector<Triangle> inside;
  for (const Triangle& t : grid.surface.triangles) {
    const Vec3 middle =
        (grid.surface.vertices[t[0]] + grid.surface.vertices[t[1]] + grid.surface.vertices[t[2]]) /
        3.0;
    const Vec3 corner(std::floor((middle.x() + radius) / size),
                      std::floor((middle.y() + radius) / size), 0.0);
    const Vec3 centre = size * (corner + Vec3(0.5, 0.5, 0.0)) - Vec3(radius, radius, 0.0);
    if (centre.norm() < radius) inside.push_back(t);
  }
  ClothMesh disc = cut(grid, inside);
  push_rim_out(disc, radius, material);
  return disc;
}

}  // namespace selvedge
