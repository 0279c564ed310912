// SPDX-License-Identifier: MIT
#include <selvedge/detection/internal/joint_surface.h>

#include <algorithm>

namespace selvedge {

JointSurface::JointSurface(std::size_t cloth_vertices, std::size_t body_vertices,
                           std::span<const Edge> cloth_edges,
                           std::span<const Triangle> cloth_triangles,
                           std::span<const Edge> body_edges,
                           std::span<const Triangle> body_triangles)
    : cloth_vertices_(cloth_vertices),
      body_vertices_(body_vertices),
      cloth_edges_(cloth_edges.size()),
      cloth_triangles_(cloth_triangles.size()),
      edges_(cloth_edges.begin(), cloth_edges.end()),
      triangles_(cloth_triangles.begin(), cloth_triangles.end()) {
  const auto n = static_cast<std::int32_t>(cloth_vertices);
  for (const Edge& e : body_edges) edges_.push_back({e[0] + n, e[1] + n});
  for (const Triangle& t : body_triangles) triangles_.push_back({t[0] + n, t[1] + n, t[2] + n});
  vertex_edges_ = lists_by_vertex(edges_, vertices());
  vertex_triangles_ = lists_by_vertex(triangles_, vertices());
  list_triangles_of_edges();
  find_parts();
}

std::span<const std::int32_t> JointSurface::triangles_of_edge(std::int32_t e) const {
  return edge_triangles_[e];
}
std::span<const std::int32_t> JointSurface::triangles_of_vertex(std::int32_t v) const {
  return vertex_triangles_[v];
}
std::span<const std::int32_t> JointSurface::edges_of_vertex(std::int32_t v) const {
  return vertex_edges_[v];
}

template <class Items>
JointSurface::Lists JointSurface::lists_by_vertex(const Items& items, std::size_t vertices) {
  Lists lists;
  lists.begin.assign(vertices + 1, 0);
  for (const auto& item : items)
    for (const std::int32_t v : item) ++lists.begin[v + 1];
  for (std::size_t v = 0; v < vertices; ++v) lists.begin[v + 1] += lists.begin[v];
  lists.value.resize(lists.begin.back());
  std::vector<std::size_t> next(lists.begin.begin(), lists.begin.end() - 1);
  for (std::size_t i = 0; i < items.size(); ++i)
    for (const std::int32_t v : items[i]) lists.value[next[v]++] = static_cast<std::int32_t>(i);
  return lists;
}

void JointSurface::list_triangles_of_edges() {
  edge_triangles_.begin.assign(1, 0);
  for (const Edge& e : edges_) {
    for (const std::int32_t t : vertex_triangles_[e[0]]) {
      const Triangle& corners = triangles_[t];
      if (std::find(corners.begin(), corners.end(), e[1]) != corners.end())
        edge_triangles_.value.push_back(t);
    }
    edge_triangles_.begin.push_back(edge_triangles_.value.size());
  }
}

void JointSurface::find_parts() {
  part_.assign(vertices(), -1);
  std::vector<std::int32_t> stack;
  for (std::size_t first = 0; first < vertices(); ++first) {
    if (part_[first] >= 0) continue;
    const auto part = static_cast<std::int32_t>(closed_.size());
    closed_.push_back(vertex_edges_[static_cast<std::int32_t>(first)].empty() ? 0 : 1);
    part_[first] = part;
    stack.push_back(static_cast<std::int32_t>(first));
    while (!stack.empty()) {
      const std::int32_t v = stack.back();
      stack.pop_back();
      for (const std::int32_t e : vertex_edges_[v]) {
        if (edge_triangles_[e].size() < 2) closed_[part] = 0;
        const std::int32_t w = other_end(e, v);
        if (part_[w] < 0) {
          part_[w] = part;
          stack.push_back(w);
        }
      }
    }
  }
}

}  // namespace selvedge
