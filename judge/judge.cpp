// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/box_tree.h>
#include <selvedge/judge/detail/check_surface.h>
#include <selvedge/judge/detail/closed_surface.h>
#include <selvedge/judge/detail/triangle_meetings.h>
#include <selvedge/judge/judge.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace selvedge {
namespace judging {

void check_surface(std::span<const Vec3> x, std::span<const Triangle> triangles,
                   const std::string& name) {
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!x[i].allFinite())
      throw std::invalid_argument(name + ": vertex " + std::to_string(i) +
                                  " has a coordinate that is not finite");
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (const std::int32_t v : triangles[i])
      if (v < 0 || static_cast<std::size_t>(v) >= x.size())
        throw std::invalid_argument(name + ": triangle " + std::to_string(i) + " has index " +
                                    std::to_string(v) + ", but there are " +
                                    std::to_string(x.size()) + " vertices");
}

}  // namespace judging

namespace {

using judging::BoxTree;
using judging::ClosedBox;
using judging::Meeting;
using judging::TrianglePoints;
using IndexPair = std::pair<std::int32_t, std::int32_t>;

constexpr std::size_t reported_pairs = 10;

TrianglePoints corners(const TriangleMesh& mesh, std::size_t triangle) {
  const Triangle& t = mesh.triangles[triangle];
  return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

std::vector<ClosedBox> triangle_boxes(const TriangleMesh& mesh) {
  std::vector<ClosedBox> boxes(mesh.triangles.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (const std::int32_t v : mesh.triangles[i]) boxes[i].add(mesh.vertices[v]);
  return boxes;
}

bool share_a_vertex(const Triangle& s, const Triangle& t) {
  return std::any_of(s.begin(), s.end(),
                     [&t](std::int32_t v) { return v == t[0] || v == t[1] || v == t[2]; });
}

// Keeps the first pairs in lexicographic order, independently of the order in which the tree
// reports them.
class FirstPairs {
 public:
  void add(IndexPair pair) {
    if (pairs_.size() == reported_pairs && pair > *pairs_.rbegin()) return;
    pairs_.insert(pair);
    if (pairs_.size() > reported_pairs) pairs_.erase(std::prev(pairs_.end()));
  }
  void remove(IndexPair pair) { pairs_.erase(pair); }
  std::vector<IndexPair> list() const { return {pairs_.begin(), pairs_.end()}; }

 private:
  std::set<IndexPair> pairs_;
};

/// Counts crossing and touching pairs apart.
class Meetings {
 public:
  /// Triangle i of `a` and triangle j of `b`.
  void add(const TriangleMesh& a, std::int32_t i, const TriangleMesh& b, std::int32_t j,
           Meeting meeting) {
    count(meeting, {i, j});
    if (meeting != Meeting::touch) return;
    add_leaves(a, i, b, j, {i, j});
    add_leaves(b, j, a, i, {i, j});
  }

  /// A surface passes through a triangle along an edge whose triangles lean on both of its sides:
  /// they cross.
  void count_passages() {
    std::set<IndexPair> passing;
    for (const auto& [place, leaves] : leaning_) {
      const auto [low, high] = std::minmax_element(leaves.begin(), leaves.end());
      if (low->first == high->first) continue;
      for (const auto& [side, pair] : leaves) passing.insert(pair);
    }
    for (const IndexPair& pair : passing) {
      count(Meeting::cross, pair);
      first_touches_.remove(pair);
    }
    touches_ -= passing.size();
  }

  /// Numbers of pairs that cross and that touch, and the first pairs of both.
  std::tuple<std::size_t, std::size_t, std::vector<IndexPair>, std::vector<IndexPair>> result()
      const {
    return {crossings_, touches_, first_crossings_.list(), first_touches_.list()};
  }

 private:
  void count(Meeting meeting, IndexPair pair) {
    if (meeting == Meeting::apart) return;
    ++(meeting == Meeting::cross ? crossings_ : touches_);
    (meeting == Meeting::cross ? first_crossings_ : first_touches_).add(pair);
  }

  /// Notes how triangle t of `leaves` leans on triangle s of `mesh`, which it touches.
  void add_leaves(const TriangleMesh& mesh, std::int32_t s, const TriangleMesh& leaves,
                  std::int32_t t, IndexPair pair) {
    const TrianglePoints on = corners(mesh, s), points = corners(leaves, t);
    // A leaf has one corner off the plane, its apex.
    int apex = -1, off = 0;
    for (int k = 0; k < 3; ++k)
      if (judging::orient3d(on[0], on[1], on[2], points[k]) != 0) apex = k, ++off;
    if (off != 1) return;
    const int k = (apex + 1) % 3, l = (apex + 2) % 3;
    const int side = judging::leaning_side(on, points[k], points[l], points[apex]);
    if (side == 0) return;
    const auto [v, w] = std::minmax(leaves.triangles[t][k], leaves.triangles[t][l]);
    leaning_[{&mesh, s, v, w}].push_back({side, pair});
  }

  std::size_t crossings_ = 0, touches_ = 0;
  FirstPairs first_crossings_, first_touches_;
  // By the triangle leant on and the edge: sides and pairs. Sums of the groups do not depend on
  // their order.
  std::map<std::tuple<const TriangleMesh*, std::int32_t, std::int32_t, std::int32_t>,
           std::vector<std::pair<int, IndexPair>>>
      leaning_;
};

void count_self_intersections(const TriangleMesh& mesh, const BoxTree& tree, Verdict& verdict) {
  Meetings found;
  tree.find_meeting_pairs([&](std::int32_t i, std::int32_t j) {
    const Triangle &s = mesh.triangles[i], &t = mesh.triangles[j];
    const Meeting meeting = share_a_vertex(s, t)
                                ? judging::meeting_of_neighbours(mesh.vertices, s, t)
                                : judging::meeting_of(corners(mesh, i), corners(mesh, j));
    found.add(mesh, i, mesh, j, meeting);
  });
  found.count_passages();
  std::tie(verdict.self_intersections, verdict.self_touches, verdict.first_self,
           verdict.first_self_touches) = found.result();
}

void count_body_intersections(const TriangleMesh& mesh, const TriangleMesh& body,
                              const BoxTree& tree, Verdict& verdict) {
  Meetings found;
  const std::vector<ClosedBox> boxes = triangle_boxes(body);
  for (std::size_t j = 0; j < boxes.size(); ++j) {
    const TrianglePoints points = corners(body, j);
    const auto of_body = static_cast<std::int32_t>(j);
    tree.find_meeting(boxes[j], [&](std::int32_t i) {
      found.add(mesh, i, body, of_body, judging::meeting_of(corners(mesh, i), points));
    });
  }
  found.count_passages();
  std::tie(verdict.body_intersections, verdict.body_touches, verdict.first_body,
           verdict.first_body_touches) = found.result();
}

void measure_penetration(const TriangleMesh& mesh, const TriangleMesh& body, Verdict& verdict) {
  const judging::ClosedSurface surface(body);
  verdict.closed_parts = surface.closed_parts();
  verdict.open_parts = surface.open_parts();
  // Vertices without a triangle are not part of the surface: the sparse layer of a bilayered cloth
  // may lie inside the body.
  std::vector<char> loose(mesh.vertices.size(), mesh.triangles.empty() ? 0 : 1);
  for (const Triangle& t : mesh.triangles)
    for (const std::int32_t i : t) loose[i] = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3& x = mesh.vertices[i];
    if (loose[i] != 0 || !surface.strictly_contains(x)) continue;
    ++verdict.inside_vertices;
    verdict.max_penetration_m = surface.distance(x, verdict.max_penetration_m);
  }
}

void check_rest(const TriangleMesh& mesh, const TriangleMesh& rest) {
  judging::check_surface(rest.vertices, rest.triangles, "rest mesh");
  if (rest.vertices.size() != mesh.vertices.size() || rest.triangles != mesh.triangles)
    throw std::invalid_argument("rest mesh: its triangles are not those of the mesh (" +
                                std::to_string(rest.vertices.size()) + " vertices, " +
                                std::to_string(rest.triangles.size()) + " triangles against " +
                                std::to_string(mesh.vertices.size()) + " and " +
                                std::to_string(mesh.triangles.size()) +
                                "); give the mesh the strain is measured from");
}

void measure_strain(const TriangleMesh& mesh, const TriangleMesh& rest, Verdict& verdict) {
  check_rest(mesh, rest);
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      if (a == b) continue;
      // stableNorm scales its argument: squares of very large or very small lengths leave the range
      // of double.
      const double rest_length = (rest.vertices[b] - rest.vertices[a]).stableNorm();
      if (!(rest_length > 0.0))
        throw std::invalid_argument("rest mesh: edge " + std::to_string(a) + "-" +
                                    std::to_string(b) +
                                    " has length 0, so its strain has no meaning");
      const double length = (mesh.vertices[b] - mesh.vertices[a]).stableNorm();
      const double strain = (length - rest_length) / rest_length;
      verdict.max_stretch = std::max(verdict.max_stretch, strain);
      verdict.max_compression = std::max(verdict.max_compression, -strain);
    }
}

}  // namespace

Verdict judge(const TriangleMesh& mesh, const TriangleMesh& body, const TriangleMesh& rest) {
  judging::check_surface(mesh.vertices, mesh.triangles, "mesh");
  judging::check_surface(body.vertices, body.triangles, "body");
  Verdict verdict;
  verdict.vertices = mesh.vertices.size();
  verdict.triangles = mesh.triangles.size();
  const BoxTree tree(triangle_boxes(mesh));
  count_self_intersections(mesh, tree, verdict);
  if (!body.triangles.empty()) {
    count_body_intersections(mesh, body, tree, verdict);
    measure_penetration(mesh, body, verdict);
  }
  if (!rest.vertices.empty() || !rest.triangles.empty()) measure_strain(mesh, rest, verdict);
  return verdict;
}

}  // namespace selvedge
