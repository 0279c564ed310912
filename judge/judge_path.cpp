// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/box_tree.h>
#include <selvedge/judge/detail/check_surface.h>
#include <selvedge/judge/judge.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

using judging::BoxTree;
using judging::ClosedBox;

/// A surface in both states of the path, with each primitive as a list of vertex indices.
struct MovingSurface {
  std::span<const Vec3> x_t0, x_t1;
  std::vector<std::array<std::int32_t, 1>> points;
  std::vector<Edge> edges;
  std::span<const Triangle> triangles;
  std::span<const std::int32_t> one;  // numbers of the vertices that become one; may be empty

  bool same(std::int32_t a, std::int32_t b) const {
    return a == b || (!one.empty() && one[a] == one[b]);
  }
};

void check_states(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1,
                  std::span<const Triangle> triangles, const std::string& name) {
  judging::check_surface(x_t0, triangles, name + " at the start");
  if (x_t0.size() != x_t1.size())
    throw std::invalid_argument(name + ": " + std::to_string(x_t0.size()) +
                                " vertices at the start of the path, " +
                                std::to_string(x_t1.size()) + " at its end");
  judging::check_surface(x_t1, triangles, name + " at the end");
}

template <class Primitive>
void keep_distinct(std::vector<Primitive>& primitives) {
  std::sort(primitives.begin(), primitives.end());
  primitives.erase(std::unique(primitives.begin(), primitives.end()), primitives.end());
}

// A repeated index gives an edge from a vertex to itself. It is kept and counts as a point.
MovingSurface moving_surface(const TriangleMesh& mesh_t0, std::span<const Vec3> x_t1,
                             const std::string& name) {
  check_states(mesh_t0.vertices, x_t1, mesh_t0.triangles, name);
  MovingSurface surface{mesh_t0.vertices, x_t1, {}, {}, mesh_t0.triangles, {}};
  for (const Triangle& t : mesh_t0.triangles)
    for (int k = 0; k < 3; ++k) {
      surface.points.push_back({t[k]});
      surface.edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    }
  keep_distinct(surface.points);
  keep_distinct(surface.edges);
  return surface;
}

template <class Primitive>
ClosedBox swept_box(const MovingSurface& surface, const Primitive& primitive) {
  ClosedBox box;
  for (const std::int32_t v : primitive) {
    box.add(surface.x_t0[v]);
    box.add(surface.x_t1[v]);
  }
  return box;
}

template <class Primitives>
BoxTree swept_tree(const MovingSurface& surface, const Primitives& primitives) {
  std::vector<ClosedBox> boxes;
  boxes.reserve(primitives.size());
  for (const auto& primitive : primitives) boxes.push_back(swept_box(surface, primitive));
  return BoxTree(std::move(boxes));
}

template <class A, class B>
bool share_a_vertex(const MovingSurface& s, const A& a, const B& b) {
  return std::any_of(a.begin(), a.end(), [&](std::int32_t v) {
    return std::any_of(b.begin(), b.end(), [&](std::int32_t w) { return s.same(v, w); });
  });
}

template <class A, class B>
bool touch(PathKind kind, const MovingSurface& s, const A& a, const MovingSurface& t, const B& b) {
  std::array<Vec3, 8> points;
  std::size_t i = 0;
  for (const std::int32_t v : a) points[i] = s.x_t0[v], points[4 + i++] = s.x_t1[v];
  for (const std::int32_t v : b) points[i] = t.x_t0[v], points[4 + i++] = t.x_t1[v];
  return paths_touch(kind, points);
}

struct Count {
  std::size_t pairs = 0, collisions = 0;
};

// Tests the points of s against the triangles of t. If both are the same surface, pairs that share
// a vertex are skipped.
Count count_point_triangle(const MovingSurface& s, const MovingSurface& t, const BoxTree& tree) {
  Count count;
  for (const auto& point : s.points)
    tree.find_meeting(swept_box(s, point), [&](std::int32_t i) {
      if (&s == &t && share_a_vertex(s, point, t.triangles[i])) return;
      ++count.pairs;
      count.collisions += touch(PathKind::point_triangle, s, point, t, t.triangles[i]);
    });
  return count;
}

// Tests the edges of s against the edges of t. If both are the same surface, each pair is tested
// once, and pairs that share a vertex are skipped.
Count count_edge_edge(const MovingSurface& s, const MovingSurface& t, const BoxTree& tree) {
  Count count;
  for (std::size_t i = 0; i < s.edges.size(); ++i)
    tree.find_meeting(swept_box(s, s.edges[i]), [&](std::int32_t j) {
      const Edge &a = s.edges[i], &b = t.edges[j];
      if (&s == &t && (static_cast<std::size_t>(j) <= i || share_a_vertex(s, a, b))) return;
      ++count.pairs;
      count.collisions += touch(PathKind::edge_edge, s, a, t, b);
    });
  return count;
}

}  // namespace

PathVerdict judge_path(const TriangleMesh& mesh_t0, std::span<const Vec3> mesh_t1,
                       const TriangleMesh& body_t0, std::span<const Vec3> body_t1,
                       std::span<const std::int32_t> one) {
  MovingSurface mesh = moving_surface(mesh_t0, mesh_t1, "mesh");
  if (!one.empty() && one.size() != mesh_t0.vertices.size())
    throw std::invalid_argument("mesh: " + std::to_string(one.size()) + " numbers for " +
                                std::to_string(mesh_t0.vertices.size()) + " vertices");
  mesh.one = one;
  const MovingSurface body = moving_surface(body_t0, body_t1, "body");
  const BoxTree triangles = swept_tree(mesh, mesh.triangles), edges = swept_tree(mesh, mesh.edges);
  const BoxTree body_triangles = swept_tree(body, body.triangles);
  PathVerdict verdict;
  for (const Count& c :
       {count_point_triangle(mesh, mesh, triangles), count_edge_edge(mesh, mesh, edges)}) {
    verdict.pairs += c.pairs;
    verdict.self_collisions += c.collisions;
  }
  for (const Count& c :
       {count_point_triangle(mesh, body, body_triangles),
        count_point_triangle(body, mesh, triangles), count_edge_edge(body, mesh, edges)}) {
    verdict.pairs += c.pairs;
    verdict.body_collisions += c.collisions;
  }
  return verdict;
}

}  // namespace selvedge
