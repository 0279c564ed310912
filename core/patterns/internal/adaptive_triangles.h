// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>

#include <map>
#include <span>
#include <vector>

namespace selvedge {

/// A mesh of triangles that are split, adaptively [VillardBorouchaki2005; survey 2.5] or uniformly
/// [ZhangYuen2001; survey 2.2], by bisection of their longest edges [Rivara1984], and joined again.
///
/// A bisection cuts both triangles of an edge, so a mesh never has a hanging node. If the edge is
/// not the longest of the other triangle, that one is bisected first. Lengths are those of the rest
/// shape; of equally long edges, the one with the smaller vertex numbers counts as longer. No angle
/// becomes smaller than half the smallest angle of the first mesh.
///
/// The rest shape may be a flat pattern with vertices of its own (make_from_pattern): then an edge
/// of a seam has a place on each of its sides, gets a middle on each, and counts by the mean of the
/// squares of both lengths. Where the two sides of a seam differ in length, the bound on angles
/// does not hold.
///
/// A split places new vertices in the middle of an edge and moves no point of the surface, so it
/// cannot cause a collision. The vertices of the first mesh come first and keep their indices; a
/// split appends its new vertices, and a join keeps the order of those that stay.
class AdaptiveTriangles {
 public:
  /// `rest`: the flat rest shape. A triangle is split up to `levels` times in four. Throws
  /// std::invalid_argument if the mesh or the material is unsuited (make_from_mesh), or if
  /// `levels` is out of [0, AdaptiveGrid::kMaxLevels].
  AdaptiveTriangles(const TriangleMesh& rest, const Material& material, std::int32_t levels);
  /// The same for a surface whose triangle i has the rest shape of triangle i of `pattern`.
  AdaptiveTriangles(TriangleMesh surface, TriangleMesh pattern, const Material& material,
                    std::int32_t levels);

  std::int32_t vertex_count() const { return static_cast<std::int32_t>(parents_.size()); }
  /// The present triangles, in the rest shape, with the vertices of the pattern.
  const TriangleMesh& rest() const { return rest_; }

  /// Springs, hinges, masses and the rest shape of the present triangles: those of make_from_mesh
  /// or of make_from_pattern.
  ClothMesh cloth() const;

  /// Triangles that can still be split and whose normal differs from a neighbour's by more than
  /// `angle` (rad) in the state x. Sorted.
  std::vector<std::int32_t> curved(std::span<const Vec3> x, double angle) const;
  /// All triangles that can still be split.
  std::vector<std::int32_t> divisible() const;

  /// Splits these triangles in four by two bisections, and those neighbours whose longest edges are
  /// in the way. The first part of a triangle keeps its number. Appends the positions (m) and
  /// velocities (m/s) of the new vertices. Mass, momentum and the centre of mass are conserved to
  /// rounding. Throws std::invalid_argument if a number is not that of a triangle.
  void split(std::span<const std::int32_t> triangles, std::vector<Vec3>& x, std::vector<Vec3>& v);

  /// Vertices whose bisection can be taken back: no triangle around them has been cut since. In the
  /// state x these triangles meet each other and their neighbours at no more than `angle` (rad),
  /// and the whole ones would meet no neighbour at more than `limit`, above which `curved` splits
  /// them. Sorted.
  std::vector<std::int32_t> flat(std::span<const Vec3> x, double angle, double limit) const;
  /// The positions after which taking back the bisections of these vertices moves no point of the
  /// surface: each lies in the middle between its parents. All vertices, m.
  std::vector<Vec3> flattened(std::span<const std::int32_t> vertices,
                              std::span<const Vec3> x) const;
  /// Takes back the bisections of these vertices; those that cannot be taken back are ignored. `x`
  /// is taken to flattened(vertices, x). Returns the index of each earlier vertex, -1 where it has
  /// gone. Mass and momentum are conserved to rounding.
  std::vector<std::int32_t> join(std::span<const std::int32_t> vertices, std::vector<Vec3>& x,
                                 std::vector<Vec3>& v);
  /// A vertex and those of the triangles around it, sorted.
  std::vector<std::int32_t> nodes(std::int32_t vertex) const;

  /// The two vertices between which vertex i was inserted; (-1, -1) for those of the first mesh.
  const Edge& parents(std::int32_t i) const { return parents_[i]; }

 private:
  AdaptiveTriangles(TriangleMesh surface, TriangleMesh rest, bool has_pattern,
                    const Material& material, std::int32_t levels);

  /// The one or two triangles of an edge; -1: none.
  using Sides = std::array<std::int32_t, 2>;

  using SideMap = std::map<Edge, Sides>;

  /// Throws std::invalid_argument for an edge of more than two triangles.
  static SideMap sides_of(const TriangleMesh& mesh);
  std::vector<std::vector<std::int32_t>> around() const;
  bool can_join(std::int32_t vertex, std::span<const std::int32_t> halves) const;
  bool is_flat(std::int32_t vertex, std::span<const std::int32_t> halves, std::span<const Vec3> x,
               double angle, double limit) const;
  void unite(std::int32_t vertex, std::span<const std::int32_t> halves, std::vector<char>& gone);
  void renumber(const std::vector<std::int32_t>& number, const std::vector<char>& gone);
  std::int32_t generation(std::int32_t triangle) const {
    return static_cast<std::int32_t>(cuts_[triangle].size());
  }
  bool is_divisible(std::int32_t triangle) const;
  double squared_length(std::int32_t triangle, int side) const;
  int longest_side(std::int32_t triangle) const;
  std::int32_t across(std::int32_t triangle, int side) const;
  void replace_side(const Edge& edge, std::int32_t from, std::int32_t to);
  void bisect(std::int32_t triangle, std::vector<std::int32_t>& changed);
  /// A new vertex, of the surface and of the rest shape.
  struct Middle {
    std::int32_t vertex, place;
  };
  void cut(std::int32_t triangle, int side, const Middle& middle,
           std::vector<std::int32_t>& changed);
  std::int32_t add_middle(const Edge& edge);
  std::int32_t add_place(const Edge& edge);

  TriangleMesh surface_;      // at its start
  TriangleMesh rest_;         // triangle i is that of the surface
  bool has_pattern_;          // rest_ has vertices of its own; else it equals surface_
  std::size_t first_places_;  // vertices of rest_ before any split
  Material material_;
  std::int32_t levels_;
  std::vector<std::vector<std::int32_t>> cuts_;  // of each triangle: middles of its bisections
  SideMap sides_;
  std::vector<Edge> parents_;
};

}  // namespace selvedge
