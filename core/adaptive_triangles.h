// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

#include <map>
#include <span>
#include <vector>

namespace selvedge {

/// A mesh of triangles that are split, adaptively [VillardBorouchaki2005; survey 2.5] or uniformly
/// [ZhangYuen2001; survey 2.2], by bisection of their longest edges [Rivara1984].
///
/// A bisection cuts both triangles of an edge, so a mesh never has a hanging node. If the edge is
/// not the longest of the other triangle, that one is bisected first. Lengths are those of the rest
/// shape; of equally long edges, the one with the smaller vertex numbers counts as longer. No angle
/// becomes smaller than half the smallest angle of the first mesh.
///
/// A split places new vertices in the middle of an edge and moves no point of the surface, so it
/// cannot cause a collision. The vertices of the first mesh come first and keep their indices; a
/// split appends its new vertices.
class AdaptiveTriangles {
 public:
  /// `rest`: the flat rest shape. A triangle is split up to `levels` times in four. Throws
  /// std::invalid_argument if the mesh or the material is unsuited (make_from_mesh), or if
  /// `levels` is out of [0, AdaptiveGrid::kMaxLevels].
  AdaptiveTriangles(TriangleMesh rest, const Material& material, std::int32_t levels);

  std::int32_t vertex_count() const { return static_cast<std::int32_t>(parents_.size()); }
  /// The present triangles, in the rest shape.
  const TriangleMesh& rest() const { return rest_; }

  /// Springs, hinges, masses and the rest shape of the present triangles: those of make_from_mesh.
  ClothMesh cloth() const { return make_from_mesh(rest_, rest_, material_); }

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

  /// The two vertices between which vertex i was inserted; (-1, -1) for those of the first mesh.
  const Edge& parents(std::int32_t i) const { return parents_[i]; }

 private:
  /// The one or two triangles of an edge; -1: none.
  using Sides = std::array<std::int32_t, 2>;

  bool is_divisible(std::int32_t triangle) const;
  int longest_side(std::int32_t triangle) const;
  std::int32_t across(std::int32_t triangle, int side) const;
  void replace_side(const Edge& edge, std::int32_t from, std::int32_t to);
  void bisect(std::int32_t triangle, std::vector<std::int32_t>& changed);
  void cut(std::int32_t triangle, int side, std::int32_t middle,
           std::vector<std::int32_t>& changed);
  std::int32_t add_middle(const Edge& edge);

  TriangleMesh rest_;
  Material material_;
  std::int32_t levels_;
  std::vector<std::int32_t> generation_;  // bisections that made each triangle
  std::map<Edge, Sides> sides_;
  std::vector<Edge> parents_;
};

}  // namespace selvedge
