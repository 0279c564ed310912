// SPDX-License-Identifier: MIT
#include <selvedge/dress/detail/skin_distance.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

namespace selvedge::detail {
namespace {

/// One side of a triangle, and the corner across it.
struct Side {
  Edge edge;
  std::int32_t corner, triangle;
};

/// The sides of all triangles; those of one edge follow each other.
std::vector<Side> sides_of(std::span<const Triangle> triangles) {
  std::vector<Side> sides;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const std::int32_t a = triangles[t][i], b = triangles[t][(i + 1) % 3];
      sides.push_back({{std::min(a, b), std::max(a, b)},
                       triangles[t][(i + 2) % 3],
                       static_cast<std::int32_t>(t)});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
    return std::pair(s.edge, s.triangle) < std::pair(t.edge, t.triangle);
  });
  return sides;
}

}  // namespace

std::vector<Eigen::Vector2d> hull_around(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  });
  std::vector<Eigen::Vector2d> hull;
  const auto turns_left = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d u = hull.back() - hull[hull.size() - 2], v = p - hull.back();
    return u.x() * v.y() - u.y() * v.x() > 0.0;
  };
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() >= start + 2 && !turns_left(p)) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

SkinDistance::SkinDistance(const TriangleMesh& mesh) : vertices_(mesh.vertices.size()) {
  const std::vector<Side> sides = sides_of(mesh.triangles);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const auto& [a, b] = sides[i].edge;
    if (i == 0 || sides[i - 1].edge != sides[i].edge) {
      add(a, b, (mesh.vertices[a] - mesh.vertices[b]).norm());
    } else {
      const std::int32_t c = sides[i - 1].corner, d = sides[i].corner;
      add(c, d, (mesh.vertices[c] - mesh.vertices[d]).norm());
    }
  }
  std::sort(ways_.begin(), ways_.end(), [](const Way& v, const Way& w) {
    return std::pair(v.from, v.to) < std::pair(w.from, w.to);
  });
  first_.assign(vertices_ + 1, 0);
  for (const Way& way : ways_) ++first_[way.from + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
}

void SkinDistance::add(std::int32_t a, std::int32_t b, double length) {
  ways_.push_back({a, b, length});
  ways_.push_back({b, a, length});
}

std::vector<double> SkinDistance::from(std::span<const std::int32_t> vertices) const {
  std::vector<double> distance(vertices_, std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const std::int32_t v : vertices) queue.emplace(distance[v] = 0.0, v);
  while (!queue.empty()) {
    const auto [so_far, v] = queue.top();
    queue.pop();
    if (so_far > distance[v]) continue;
    for (std::int32_t k = first_[v]; k < first_[v + 1]; ++k) {
      const double next = so_far + ways_[k].length;
      if (next >= distance[ways_[k].to]) continue;
      distance[ways_[k].to] = next;
      queue.emplace(next, ways_[k].to);
    }
  }
  return distance;
}

Vec3 SkinLoop::middle() const {
  Vec3 sum = Vec3::Zero();
  double length = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 &a = points[i], &b = points[(i + 1) % points.size()];
    sum += 0.5 * (a + b) * (b - a).norm();
    length += (b - a).norm();
  }
  return length > 0.0 ? Vec3(sum / length) : points.front();
}

double SkinLoop::girth(const Vec3& normal) const {
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Eigen::Vector2d> flat;
  for (const Vec3& p : points) flat.emplace_back(u.dot(p), v.dot(p));
  const std::vector<Eigen::Vector2d> hull = hull_around(std::move(flat));
  double length = 0.0;
  for (std::size_t i = 0; i < hull.size(); ++i)
    length += (hull[(i + 1) % hull.size()] - hull[i]).norm();
  return length;
}

std::vector<SkinLoop> level_loops(const TriangleMesh& mesh, std::span<const double> value,
                                  double level) {
  // A triangle that the level crosses joins two of its sides.
  std::vector<std::pair<Edge, Edge>> links;
  for (const Triangle& t : mesh.triangles) {
    std::vector<Edge> crossed;
    for (int i = 0; i < 3; ++i) {
      const std::int32_t a = t[i], b = t[(i + 1) % 3];
      if ((value[a] < level) != (value[b] < level))
        crossed.push_back({std::min(a, b), std::max(a, b)});
    }
    if (crossed.size() != 2) continue;
    links.emplace_back(crossed[0], crossed[1]);
    links.emplace_back(crossed[1], crossed[0]);
  }
  std::sort(links.begin(), links.end());
  std::vector<char> used(links.size(), 0);
  const auto share_of = [&](const Edge& e) {
    return (level - value[e[0]]) / (value[e[1]] - value[e[0]]);
  };
  const auto point = [&](const Edge& e) -> Vec3 {
    return mesh.vertices[e[0]] + share_of(e) * (mesh.vertices[e[1]] - mesh.vertices[e[0]]);
  };
  std::vector<std::pair<double, SkinLoop>> found;
  for (std::size_t start = 0; start < links.size(); ++start) {
    if (used[start]) continue;
    SkinLoop loop;
    double length = 0.0;
    for (std::size_t at = start; at < links.size() && !used[at];) {
      used[at] = 1;
      const auto [from, to] = links[at];
      const auto back = std::lower_bound(links.begin(), links.end(), std::pair(to, from));
      used[static_cast<std::size_t>(back - links.begin())] = 1;
      loop.points.push_back(point(from));
      loop.places.emplace_back(from, share_of(from));
      length += (point(to) - point(from)).norm();
      // The next link from `to` that is not the way back.
      auto next = std::lower_bound(links.begin(), links.end(), std::pair(to, Edge{-1, -1}));
      while (next != links.end() && next->first == to &&
             used[static_cast<std::size_t>(next - links.begin())])
        ++next;
      if (next == links.end() || next->first != to) break;
      at = static_cast<std::size_t>(next - links.begin());
    }
    if (loop.points.size() > 2) found.emplace_back(length, std::move(loop));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<SkinLoop> loops;
  for (auto& [length, loop] : found) loops.push_back(std::move(loop));
  return loops;
}

TriangleMesh largest_part(const TriangleMesh& mesh) {
  std::vector<std::int32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : mesh.triangles)
    for (int i = 1; i < 3; ++i) {
      const std::int32_t a = root(t[0]), b = root(t[i]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::vector<double> area(mesh.vertices.size(), 0.0);
  const std::vector<Vec3>& x = mesh.vertices;
  for (const Triangle& t : mesh.triangles)
    area[root(t[0])] += (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
  const auto largest =
      static_cast<std::int32_t>(std::max_element(area.begin(), area.end()) - area.begin());
  TriangleMesh part;
  std::vector<std::int32_t> number(mesh.vertices.size(), -1);
  for (const Triangle& t : mesh.triangles) {
    if (root(t[0]) != largest) continue;
    Triangle& copy = part.triangles.emplace_back(t);
    for (std::int32_t& v : copy) {
      if (number[v] < 0) {
        number[v] = static_cast<std::int32_t>(part.vertices.size());
        part.vertices.push_back(x[v]);
      }
      v = number[v];
    }
  }
  return part;
}

}  // namespace selvedge::detail
