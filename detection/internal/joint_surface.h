// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <span>
#include <vector>

namespace selvedge {

/// Cloth and bodies as one surface, by the joint index space of ContactPoint: cloth vertices,
/// edges and triangles first, then those of all bodies. Topology only.
class JointSurface {
 public:
  JointSurface() = default;
  /// Edges and triangles of the bodies count from 0; their joint indices follow those of the cloth.
  JointSurface(std::size_t cloth_vertices, std::size_t body_vertices,
               std::span<const Edge> cloth_edges, std::span<const Triangle> cloth_triangles,
               std::span<const Edge> body_edges, std::span<const Triangle> body_triangles);

  std::size_t vertices() const { return cloth_vertices_ + body_vertices_; }
  std::size_t cloth_vertices() const { return cloth_vertices_; }
  std::size_t cloth_edges() const { return cloth_edges_; }
  std::size_t cloth_triangles() const { return cloth_triangles_; }
  const std::vector<Edge>& edges() const { return edges_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

  std::span<const std::int32_t> triangles_of_edge(std::int32_t e) const;
  std::span<const std::int32_t> triangles_of_vertex(std::int32_t v) const;
  std::span<const std::int32_t> edges_of_vertex(std::int32_t v) const;
  std::int32_t other_end(std::int32_t e, std::int32_t v) const {
    return edges_[e][0] == v ? edges_[e][1] : edges_[e][0];
  }

  /// Connected parts, by vertex; a part without border is closed.
  std::int32_t part(std::int32_t v) const { return part_[v]; }
  std::size_t parts() const { return closed_.size(); }
  bool is_closed(std::int32_t part) const { return closed_[part] != 0; }
  bool is_cloth(std::int32_t v) const { return static_cast<std::size_t>(v) < cloth_vertices_; }

 private:
  struct Lists {  // values of item i: value[begin[i]] to value[begin[i + 1]]
    std::vector<std::size_t> begin;
    std::vector<std::int32_t> value;
    std::span<const std::int32_t> operator[](std::int32_t i) const {
      return std::span(value).subspan(begin[i], begin[i + 1] - begin[i]);
    }
  };
  template <class Items>
  static Lists lists_by_vertex(const Items& items, std::size_t vertices);
  void list_triangles_of_edges();
  void find_parts();

  std::size_t cloth_vertices_ = 0, body_vertices_ = 0, cloth_edges_ = 0, cloth_triangles_ = 0;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
  Lists edge_triangles_, vertex_triangles_, vertex_edges_;
  std::vector<std::int32_t> part_;
  std::vector<char> closed_;
};

/// An edge that passes through a triangle with which it has no common vertex; joint indices.
struct EdgeCrossing {
  std::int32_t edge, triangle;
  auto operator<=>(const EdgeCrossing&) const = default;
};

}  // namespace selvedge
