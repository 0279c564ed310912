// SPDX-License-Identifier: MIT
#include <selvedge/detection/detail/common_vertices.h>

#include <algorithm>
#include <utility>

namespace selvedge::detail {
namespace {

bool names_a_vertex_twice(const Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

void add_pair(std::int32_t s, std::int32_t t, std::vector<TrianglePair>& pairs) {
  if (s != t) pairs.push_back({std::min(s, t), std::max(s, t)});
}

/// The sides of the triangles, sorted into one list for each lower vertex.
class SidesByVertex {
 public:
  struct Side {
    std::int32_t high, triangle;
    auto operator<=>(const Side&) const = default;
  };

  SidesByVertex(std::span<const Triangle> triangles, std::size_t vertices)
      : begin_(vertices + 1, 0), sides_(3 * triangles.size()) {
    for (const Triangle& t : triangles)
      for (int k = 0; k < 3; ++k) ++begin_[low(t, k) + 1];
    for (std::size_t v = 0; v < vertices; ++v) begin_[v + 1] += begin_[v];
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < triangles.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const Triangle& t = triangles[i];
        sides_[next[low(t, k)]++] = {std::max(t[k], t[(k + 1) % 3]), static_cast<std::int32_t>(i)};
      }
  }

  std::span<Side> at(std::size_t vertex) {
    return std::span(sides_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
  }

 private:
  static std::size_t low(const Triangle& t, int k) {
    return static_cast<std::size_t>(std::min(t[k], t[(k + 1) % 3]));
  }

  std::vector<std::size_t> begin_;
  std::vector<Side> sides_;
};

void add_pairs_of(std::span<SidesByVertex::Side> sides, std::vector<TrianglePair>& pairs) {
  std::sort(sides.begin(), sides.end());
  for (std::size_t i = 0; i < sides.size(); ++i)
    for (std::size_t j = i + 1; j < sides.size() && sides[j].high == sides[i].high; ++j)
      add_pair(sides[i].triangle, sides[j].triangle, pairs);
}

/// Pairs of a triangle that names a vertex twice and any other one at its vertices.
void add_pairs_of_repeated(std::span<const Triangle> triangles, std::vector<TrianglePair>& pairs) {
  std::vector<std::pair<std::int32_t, std::int32_t>> at_vertex;  // vertex, triangle
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (names_a_vertex_twice(triangles[i]))
      for (const std::int32_t v : triangles[i])
        at_vertex.emplace_back(v, static_cast<std::int32_t>(i));
  if (at_vertex.empty()) return;
  std::sort(at_vertex.begin(), at_vertex.end());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (const std::int32_t v : triangles[i])
      for (auto at = std::lower_bound(at_vertex.begin(), at_vertex.end(), std::pair(v, 0));
           at != at_vertex.end() && at->first == v; ++at)
        add_pair(static_cast<std::int32_t>(i), at->second, pairs);
}

}  // namespace

std::vector<TrianglePair> pairs_with_common_edge(std::span<const Triangle> triangles,
                                                 std::size_t vertices) {
  std::vector<TrianglePair> pairs;
  SidesByVertex sides(triangles, vertices);
  for (std::size_t v = 0; v < vertices; ++v) add_pairs_of(sides.at(v), pairs);
  add_pairs_of_repeated(triangles, pairs);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

bool names(const Triangle& t, std::int32_t v) { return v == t[0] || v == t[1] || v == t[2]; }

int common_vertices(const Triangle& s, const Triangle& t) {
  int common = 0;
  for (int i = 0; i < 3; ++i)
    common += names(t, s[i]) && std::find(s.begin(), s.begin() + i, s[i]) == s.begin() + i;
  return common;
}

}  // namespace selvedge::detail
