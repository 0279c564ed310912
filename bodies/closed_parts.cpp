// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/core/base/internal/orientation.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <span>

namespace selvedge {
namespace {

// For each vertex the first one at the same position.
std::vector<std::int32_t> first_at_place(std::span<const Vec3> x) {
  std::vector<std::int32_t> order(x.size()), first(x.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t i, std::int32_t j) {
    if (x[i] == x[j]) return i < j;
    return std::lexicographical_compare(x[i].begin(), x[i].end(), x[j].begin(), x[j].end());
  });
  for (std::size_t k = 0; k < order.size(); ++k)
    first[order[k]] = k > 0 && x[order[k]] == x[order[k - 1]] ? first[order[k - 1]] : order[k];
  return first;
}

// One side of a triangle.
struct Side {
  Edge edge;  // lower vertex first
  std::int32_t triangle;
  int direction;  // +1: from the lower to the higher vertex
};

std::vector<Side> sorted_sides(const TriangleMesh& mesh) {
  const std::vector<std::int32_t> place = first_at_place(mesh.vertices);
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = place[mesh.triangles[t][k]], b = place[mesh.triangles[t][(k + 1) % 3]];
      if (a == b) continue;
      sides.push_back(
          {{std::min(a, b), std::max(a, b)}, static_cast<std::int32_t>(t), a < b ? 1 : -1});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
    return s.edge != t.edge ? s.edge < t.edge : s.triangle < t.triangle;
  });
  return sides;
}

template <class Visit>
void for_each_edge(std::span<const Side> sides, const Visit& visit) {
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].edge == sides[begin].edge) ++end;
    visit(sides.subspan(begin, end - begin));
  }
}

std::int32_t root(std::vector<std::int32_t>& parent, std::int32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Turn of a, b, p as seen along the x axis, p moved by (e, e²) in that plane with e > 0 as small as
// need be [EdelsbrunnerMuecke1990]; 0 only if a and b are one point of that plane.
int turn(const Vec3& a, const Vec3& b, const Vec3& p) {
  if (const int exact = orientation(a, b, p, 0); exact != 0) return exact;
  if (a.z() != b.z()) return a.z() > b.z() ? 1 : -1;
  return (b.y() > a.y()) - (b.y() < a.y());
}

// How a ray from p along the x axis crosses the triangle: +1 with its normal, -1 against it, 0 not
// at all.
int ray_crossing(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const auto beside = [&](int k) {
    return (p[k] < a[k] && p[k] < b[k] && p[k] < c[k]) ||
           (p[k] > a[k] && p[k] > b[k] && p[k] > c[k]);
  };
  if (beside(1) || beside(2)) return 0;
  const int side = turn(a, b, p);
  if (side == 0 || turn(b, c, p) != side || turn(c, a, p) != side) return 0;
  return orientation(a, b, c, p) == side ? side : 0;
}

}  // namespace

ClosedParts::ClosedParts(const TriangleMesh& mesh)
    : oriented_(mesh.triangles.size(), 1),
      lower_(Vec3::Constant(std::numeric_limits<double>::infinity())),
      upper_(-lower_) {
  const std::vector<Side> sides = sorted_sides(mesh);
  std::vector<std::int32_t> parent(mesh.triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  for_each_edge(sides, [&](std::span<const Side> run) {
    for (const Side& side : run)
      parent[root(parent, side.triangle)] = root(parent, run[0].triangle);
  });
  std::vector<char> open(mesh.triangles.size(), 0);
  for_each_edge(sides, [&](std::span<const Side> run) {
    const std::int32_t part = root(parent, run[0].triangle);
    int sum = 0;
    for (const Side& side : run) sum += side.direction;
    if (run.size() % 2 == 1) open[part] = 1;
    if (sum != 0) oriented_[part] = 0;
  });
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto triangle = static_cast<std::int32_t>(t);
    const std::int32_t part = root(parent, triangle);
    if (open[part] != 0) continue;
    const Triangle& v = mesh.triangles[t];
    faces_.push_back(
        {triangle, part, mesh.vertices[v[0]], mesh.vertices[v[1]], mesh.vertices[v[2]]});
    for (const std::int32_t i : v) {
      lower_ = lower_.cwiseMin(mesh.vertices[i]);
      upper_ = upper_.cwiseMax(mesh.vertices[i]);
    }
  }
}

std::int32_t ClosedParts::part_around(const Vec3& x) const {
  if (!may_contain(x)) return -1;
  struct Count {
    std::int32_t triangle;
    int crossings = 0, winding = 0;
  };
  std::map<std::int32_t, Count> counts;  // of the parts that the ray crosses
  for (const Face& face : faces_) {
    const int crossing = ray_crossing(face.a, face.b, face.c, x);
    if (crossing == 0) continue;
    Count& count = counts.try_emplace(face.part, Count{face.triangle}).first->second;
    ++count.crossings;
    count.winding += crossing;
  }
  int winding = 0;
  std::int32_t around = -1;
  for (const auto& [part, count] : counts) {
    if (oriented_[part] == 0 && count.crossings % 2 == 1) return count.triangle;
    if (oriented_[part] == 0) continue;
    winding += count.winding;
    if (count.winding != 0 && around < 0) around = count.triangle;
  }
  return winding != 0 ? around : -1;
}

}  // namespace selvedge
