// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/closed_surface.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace selvedge::judging {
namespace {

// For each vertex, the lowest index of a vertex at exactly the same position (-0 equals 0).
std::vector<std::int32_t> weld(std::span<const Vec3> x) {
  std::vector<std::int32_t> order(x.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::int32_t i) { return std::tuple(x[i][0], x[i][1], x[i][2]); };
  std::sort(order.begin(), order.end(), [&](std::int32_t i, std::int32_t j) {
    return std::tuple_cat(key(i), std::tuple(i)) < std::tuple_cat(key(j), std::tuple(j));
  });
  std::vector<std::int32_t> first(x.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && key(order[i - 1]) == key(order[i]) ? first[order[i - 1]] : order[i];
  return first;
}

struct HalfEdge {
  std::int32_t low, high, triangle;
  int direction;  // +1 from low to high
};

std::vector<HalfEdge> sorted_half_edges(const TriangleMesh& mesh) {
  const std::vector<std::int32_t> place = weld(mesh.vertices);
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = place[mesh.triangles[t][k]], b = place[mesh.triangles[t][(k + 1) % 3]];
      if (a != b)
        half_edges.push_back(
            {std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), a < b ? 1 : -1});
    }
  std::sort(half_edges.begin(), half_edges.end(), [](const HalfEdge& e, const HalfEdge& f) {
    return std::tie(e.low, e.high, e.triangle) < std::tie(f.low, f.high, f.triangle);
  });
  return half_edges;
}

std::int32_t root_of(std::vector<std::int32_t>& parent, std::int32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Calls visit(run) for each edge, with the run of its half edges.
template <class Visit>
void for_each_edge(std::span<const HalfEdge> half_edges, const Visit& visit) {
  while (!half_edges.empty()) {
    const HalfEdge& first = half_edges.front();
    const auto end = std::find_if(half_edges.begin(), half_edges.end(), [&](const HalfEdge& e) {
      return e.low != first.low || e.high != first.high;
    });
    const auto length = static_cast<std::size_t>(end - half_edges.begin());
    visit(half_edges.first(length));
    half_edges = half_edges.subspan(length);
  }
}

struct Parts {
  std::vector<std::int32_t> part;    // per triangle: its part, identified by one of its triangles
  std::vector<char> open, oriented;  // valid for the triangles that identify a part
};

Parts find_parts(const TriangleMesh& mesh) {
  const std::vector<HalfEdge> half_edges = sorted_half_edges(mesh);
  const std::size_t n = mesh.triangles.size();
  Parts parts{std::vector<std::int32_t>(n), std::vector<char>(n, 0), std::vector<char>(n, 1)};
  std::iota(parts.part.begin(), parts.part.end(), 0);
  for_each_edge(half_edges, [&](std::span<const HalfEdge> run) {
    for (const HalfEdge& e : run)
      parts.part[root_of(parts.part, e.triangle)] = root_of(parts.part, run.front().triangle);
  });
  for (std::size_t t = 0; t < n; ++t)
    parts.part[t] = root_of(parts.part, static_cast<std::int32_t>(t));
  for_each_edge(half_edges, [&](std::span<const HalfEdge> run) {
    int sum = 0;
    for (const HalfEdge& e : run) sum += e.direction;
    const std::int32_t part = parts.part[run.front().triangle];
    if (run.size() % 2 == 1) parts.open[part] = 1;
    if (sum != 0) parts.oriented[part] = 0;
  });
  return parts;
}

// Side of the line a b, seen from above, on which the point p + (e, e²) lies for all sufficiently
// small e > 0 [EdelsbrunnerMuecke1990]. It is 0 only if one of a and b is vertically above the
// other.
int perturbed_side(const Vec3& a, const Vec3& b, const Vec3& p) {
  if (const int side = orient2d(a, b, p, 2); side != 0) return side;
  if (a[1] != b[1]) return a[1] > b[1] ? 1 : -1;
  return (b[0] > a[0]) - (b[0] < a[0]);
}

// +1 if the upward ray from the perturbed p crosses the triangle along its normal, -1 if it crosses
// against the normal, 0 if it misses. p must not lie on the triangle.
int crossing_above(const Vec3& p, const TrianglePoints& t) {
  const int side = perturbed_side(t[0], t[1], p);
  if (side == 0 || perturbed_side(t[1], t[2], p) != side || perturbed_side(t[2], t[0], p) != side)
    return 0;
  return orient3d(t[0], t[1], t[2], p) == side ? side : 0;
}

double squared_distance_to_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length = ab.squaredNorm();
  const double s = length > 0.0 ? std::clamp((x - a).dot(ab) / length, 0.0, 1.0) : 0.0;
  return (x - a - s * ab).squaredNorm();
}

double squared_distance_to_triangle(const Vec3& x, const TrianglePoints& t) {
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double area = normal.squaredNorm();
  double nearest = INFINITY;
  bool above = area > 0.0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &a = t[i], &b = t[(i + 1) % 3];
    above = above && normal.dot((b - a).cross(x - a)) >= 0.0;
    nearest = std::min(nearest, squared_distance_to_segment(x, a, b));
  }
  const double height = normal.dot(x - t[0]);
  return above ? std::min(nearest, height * height / area) : nearest;
}

}  // namespace

ClosedSurface::ClosedSurface(const TriangleMesh& mesh) {
  const Parts parts = find_parts(mesh);
  std::vector<ClosedBox> boxes;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::int32_t part = parts.part[i];
    if (part == static_cast<std::int32_t>(i)) ++(parts.open[part] ? open_parts_ : closed_parts_);
    if (parts.open[part]) continue;
    const Triangle& t = mesh.triangles[i];
    faces_.push_back({{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]},
                      part,
                      parts.oriented[part] != 0});
    boxes.emplace_back();
    for (const Vec3& x : faces_.back().points) boxes.back().add(x);
  }
  tree_ = BoxTree(std::move(boxes));
}

bool ClosedSurface::strictly_contains(const Vec3& x) const {
  int winding = 0;
  bool on_surface = false;
  std::vector<std::int32_t> odd;  // unoriented parts crossed an odd number of times so far
  const auto above = [&x](const ClosedBox& box) {
    return box.low[0] <= x[0] && x[0] <= box.high[0] && box.low[1] <= x[1] && x[1] <= box.high[1] &&
           x[2] <= box.high[2];
  };
  tree_.visit(above, [&](std::int32_t i) {
    const Face& face = faces_[i];
    if (tree_.boxes()[i].contains(x) && segment_meets_triangle(x, x, face.points))
      on_surface = true;
    const int crossing = crossing_above(x, face.points);
    if (crossing == 0) return;
    if (face.oriented) {
      winding += crossing;
    } else if (const auto known = std::find(odd.begin(), odd.end(), face.part);
               known != odd.end()) {
      odd.erase(known);
    } else {
      odd.push_back(face.part);
    }
  });
  return !on_surface && (winding != 0 || !odd.empty());
}

double ClosedSurface::distance(const Vec3& x, double floor) const {
  const double squared = tree_.nearest(x, floor * floor, [&](std::int32_t i) {
    return squared_distance_to_triangle(x, faces_[i].points);
  });
  return squared > floor * floor ? std::sqrt(squared) : floor;
}

}  // namespace selvedge::judging
