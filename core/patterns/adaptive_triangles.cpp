// SPDX-License-Identifier: MIT
//
// Adaptive triangles by M. Rivara, "Algorithms for refining triangular grids suitable for adaptive
// and multigrid techniques", International Journal for Numerical Methods in Engineering 1984, with
// the criterion of J. Villard, H. Borouchaki, "Adaptive meshing for cloth animation", Engineering
// with Computers 2005, who split quads.
//
// A triangle (a, b, c) of area A gives A/3 to the mass of each corner. Cut from c to the middle m
// of ab, its halves give A/6 to a and to b, and A/3 to m and to c. So m takes A/6 from each end,
// and with v_m = (v_a + v_b)/2 the momentum stays.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/cloth/detail/angles.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/internal/adaptive_triangles.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge {
namespace {

/// Two bisections make four quarters.
constexpr std::int32_t kBisectionsPerLevel = 2;

Edge edge_of_side(const Triangle& t, int side) {
  const std::int32_t a = t[side], b = t[(side + 1) % 3];
  return {std::min(a, b), std::max(a, b)};
}

}  // namespace

AdaptiveTriangles::AdaptiveTriangles(TriangleMesh surface, TriangleMesh rest, bool has_pattern,
                                     const Material& material, std::int32_t levels)
    : surface_(std::move(surface)),
      rest_(std::move(rest)),
      has_pattern_(has_pattern),
      first_places_(rest_.vertices.size()),
      material_(material),
      levels_(levels),
      cuts_(surface_.triangles.size()),
      parents_(surface_.vertices.size(), Edge{-1, -1}) {
  require(levels >= 0 && levels <= AdaptiveGrid::kMaxLevels, "levels", levels, "between 0 and 6");
  (void)cloth();  // throws where the mesh is unsuited
  sides_ = sides_of(surface_);
}

AdaptiveTriangles::AdaptiveTriangles(const TriangleMesh& rest, const Material& material,
                                     std::int32_t levels)
    : AdaptiveTriangles(rest, rest, false, material, levels) {}

AdaptiveTriangles::AdaptiveTriangles(TriangleMesh surface, TriangleMesh pattern,
                                     const Material& material, std::int32_t levels)
    : AdaptiveTriangles(std::move(surface), std::move(pattern), true, material, levels) {}

ClothMesh AdaptiveTriangles::cloth() const {
  return has_pattern_ ? make_from_pattern(surface_, rest_, material_)
                      : make_from_mesh(rest_, rest_, material_);
}

AdaptiveTriangles::SideMap AdaptiveTriangles::sides_of(const TriangleMesh& mesh) {
  SideMap sides;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int side = 0; side < 3; ++side) {
      const Edge edge = edge_of_side(mesh.triangles[i], side);
      const auto t = static_cast<std::int32_t>(i);
      const auto [at, is_new] = sides.try_emplace(edge, Sides{t, -1});
      if (is_new) continue;
      if (at->second[1] >= 0)
        throw std::invalid_argument("cloth: edge " + std::to_string(edge[0]) + ", " +
                                    std::to_string(edge[1]) +
                                    " has more than two triangles, so it cannot be split");
      at->second[1] = t;
    }
  return sides;
}

bool AdaptiveTriangles::is_divisible(std::int32_t triangle) const {
  return generation(triangle) + kBisectionsPerLevel <= kBisectionsPerLevel * levels_;
}

std::vector<std::int32_t> AdaptiveTriangles::divisible() const {
  std::vector<std::int32_t> all;
  for (std::int32_t t = 0; t < static_cast<std::int32_t>(cuts_.size()); ++t)
    if (is_divisible(t)) all.push_back(t);
  return all;
}

std::vector<std::int32_t> AdaptiveTriangles::curved(std::span<const Vec3> x, double angle) const {
  std::vector<std::int32_t> found;
  for (const std::int32_t t : divisible()) {
    const Vec3 n = detail::area_vector(x, surface_.triangles[t]);
    for (int side = 0; side < 3; ++side) {
      const std::int32_t other = across(t, side);
      if (other < 0) continue;
      const Vec3 m = detail::area_vector(x, surface_.triangles[other]);
      if (!(detail::angle_between(n, m) > angle)) continue;
      found.push_back(t);
      break;
    }
  }
  return found;
}

double AdaptiveTriangles::squared_length(std::int32_t triangle, int side) const {
  const auto own = [&](std::int32_t t, int k) {
    const auto [a, b] = edge_of_side(rest_.triangles[t], k);
    return (rest_.vertices[b] - rest_.vertices[a]).squaredNorm();
  };
  const double here = own(triangle, side);
  const std::int32_t other = has_pattern_ ? across(triangle, side) : -1;
  if (other < 0) return here;
  const Edge edge = edge_of_side(surface_.triangles[triangle], side);
  int there = 0;
  while (edge_of_side(surface_.triangles[other], there) != edge) ++there;
  return 0.5 * (here + own(other, there));
}

/// Ties have one winner for both triangles of an edge, so that a chain of bisections ends.
int AdaptiveTriangles::longest_side(std::int32_t triangle) const {
  const Triangle& t = surface_.triangles[triangle];
  const auto rank = [&](int side) {
    return std::pair(-squared_length(triangle, side), edge_of_side(t, side));
  };
  int longest = 0;
  for (const int side : {1, 2})
    if (rank(side) < rank(longest)) longest = side;
  return longest;
}

std::int32_t AdaptiveTriangles::across(std::int32_t triangle, int side) const {
  const Sides& sides = sides_.at(edge_of_side(surface_.triangles[triangle], side));
  return sides[0] == triangle ? sides[1] : sides[0];
}

void AdaptiveTriangles::replace_side(const Edge& edge, std::int32_t from, std::int32_t to) {
  for (std::int32_t& t : sides_.at(edge))
    if (t == from) t = to;
}

std::int32_t AdaptiveTriangles::add_middle(const Edge& edge) {
  const std::vector<Vec3>& x = surface_.vertices;
  const std::int32_t middle = vertex_count();
  surface_.vertices.push_back(0.5 * (x[edge[0]] + x[edge[1]]));
  parents_.push_back(edge);
  return middle;
}

std::int32_t AdaptiveTriangles::add_place(const Edge& edge) {
  std::vector<Vec3>& x = rest_.vertices;
  x.push_back(0.5 * (x[edge[0]] + x[edge[1]]));
  return static_cast<std::int32_t>(x.size()) - 1;
}

/// Triangle (a, b, c) becomes (a, m, c), and (m, b, c) is appended; its number is noted.
void AdaptiveTriangles::cut(std::int32_t triangle, int side, const Middle& middle,
                            std::vector<std::int32_t>& changed) {
  const auto halve = [&](std::vector<Triangle>& all, std::int32_t m) {
    const Triangle t = all[triangle];
    const std::int32_t a = t[side], b = t[(side + 1) % 3], c = t[(side + 2) % 3];
    all[triangle] = {a, m, c};
    all.push_back({m, b, c});
    return Triangle{a, b, c};
  };
  const std::int32_t m = middle.vertex;
  halve(rest_.triangles, middle.place);
  const auto [a, b, c] = halve(surface_.triangles, m);
  const auto added = static_cast<std::int32_t>(surface_.triangles.size()) - 1;
  cuts_[triangle].push_back(m);
  cuts_.push_back(cuts_[triangle]);
  const auto note = [&](std::int32_t v, std::int32_t w, std::int32_t of) {
    const auto [at, is_new] = sides_.try_emplace({std::min(v, w), std::max(v, w)}, Sides{of, -1});
    if (!is_new) at->second[1] = of;
  };
  note(a, m, triangle);
  note(m, b, added);
  sides_[{std::min(c, m), std::max(c, m)}] = {triangle, added};
  replace_side({std::min(b, c), std::max(b, c)}, triangle, added);
  changed.push_back(triangle);
}

/// Longest-edge propagation: each triangle of the chain has a longer longest edge than the one
/// before, so the chain ends at two triangles with the same longest edge, or at the border.
void AdaptiveTriangles::bisect(std::int32_t triangle, std::vector<std::int32_t>& changed) {
  std::vector<std::int32_t> chain = {triangle};
  while (!chain.empty()) {
    const std::int32_t last = chain.back();
    const int side = longest_side(last);
    const Edge edge = edge_of_side(surface_.triangles[last], side);
    const std::int32_t other = across(last, side);
    if (other >= 0 && edge_of_side(surface_.triangles[other], longest_side(other)) != edge) {
      chain.push_back(other);
      continue;
    }
    const int other_side = other >= 0 ? longest_side(other) : 0;
    const Edge here = edge_of_side(rest_.triangles[last], side);
    const Edge there = other >= 0 ? edge_of_side(rest_.triangles[other], other_side) : here;
    const Middle middle{add_middle(edge), add_place(here)};
    sides_.erase(edge);
    cut(last, side, middle, changed);
    if (other >= 0)
      cut(other, other_side, {middle.vertex, there == here ? middle.place : add_place(there)},
          changed);
    chain.pop_back();
  }
}

void AdaptiveTriangles::split(std::span<const std::int32_t> triangles, std::vector<Vec3>& x,
                              std::vector<Vec3>& v) {
  const auto count = static_cast<std::int32_t>(surface_.triangles.size());
  std::vector<std::int32_t> target(count, 0);  // generation of the parts of each triangle
  for (const std::int32_t t : triangles) {
    require(t >= 0 && t < count, "triangle", t, "of the mesh");
    target[t] = generation(t) + kBisectionsPerLevel;
  }
  std::vector<std::int32_t> whole(count), changed;  // whole: the triangle that each is a part of
  std::iota(whole.begin(), whole.end(), 0);
  for (std::int32_t t = 0; t < static_cast<std::int32_t>(cuts_.size()); ++t)
    while (generation(t) < target[whole[t]]) {
      changed.clear();
      bisect(t, changed);
      for (const std::int32_t cut : changed) whole.push_back(whole[cut]);
    }
  for (auto i = static_cast<std::int32_t>(x.size()); i < vertex_count(); ++i) {
    const auto [a, b] = parents_[i];
    x.push_back(0.5 * (x[a] + x[b]));
    v.push_back(0.5 * (v[a] + v[b]));
  }
}

}  // namespace selvedge
