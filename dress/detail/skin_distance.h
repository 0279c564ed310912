// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <span>
#include <utility>
#include <vector>

namespace selvedge::detail {

/// Distances along a surface, by its edges and the lines across each two triangles.
class SkinDistance {
 public:
  explicit SkinDistance(const TriangleMesh& mesh);
  /// m, from the nearest of the vertices; infinity where the surface is not connected.
  std::vector<double> from(std::span<const std::int32_t> vertices) const;

 private:
  void add(std::int32_t a, std::int32_t b, double length);
  std::size_t vertices_;
  struct Way {
    std::int32_t from, to;
    double length;  // m
  };
  std::vector<Way> ways_;
  std::vector<std::int32_t> first_;
};

/// A closed line on a surface.
struct SkinLoop {
  std::vector<Vec3> points;  ///< m
  /// Where they lie: an edge of the surface, and the share of it from its first vertex on.
  std::vector<std::pair<Edge, double>> places;
  /// Another value of the vertices at point i.
  double value(std::span<const double> of_vertices, std::size_t i) const {
    const auto& [edge, share] = places[i];
    return of_vertices[edge[0]] + share * (of_vertices[edge[1]] - of_vertices[edge[0]]);
  }
  Vec3 middle() const;  ///< m, by length
  /// Length of a tape around it: of its convex hull in the plane with this normal, m.
  double girth(const Vec3& normal) const;
};

/// Convex hull of points of the plane, counter-clockwise (Andrew's monotone chain).
std::vector<Eigen::Vector2d> hull_around(std::vector<Eigen::Vector2d> points);

/// The closed lines on which a value of the vertices is `level`, the longest first.
std::vector<SkinLoop> level_loops(const TriangleMesh& mesh, std::span<const double> value,
                                  double level);

/// The part of a mesh with the largest area, its vertices renumbered.
TriangleMesh largest_part(const TriangleMesh& mesh);

}  // namespace selvedge::detail
