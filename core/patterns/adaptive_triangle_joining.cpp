// SPDX-License-Identifier: MIT
//
// Takes back bisections of an adaptive mesh of triangles (adaptive_triangles.cpp) where the cloth
// has become flat. The paper that splits, M. Rivara 1984, has no such step; this is ours.
//
// A bisection is taken back when no triangle around its vertex m has been cut since: these are the
// two halves on each side of the edge ab of which m is the middle. Different vertices of this kind
// share no triangle, so they can go at once. The mass of m goes to a and b in halves, as it came,
// and so does its momentum.
#include <selvedge/core/cloth/detail/angles.h>
#include <selvedge/core/patterns/internal/adaptive_triangles.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge {
namespace {

/// The whole of which a half with the middle `m` of `edge` is a part.
Triangle whole_of(Triangle half, std::int32_t m, const Edge& edge) {
  const bool has_first = std::find(half.begin(), half.end(), edge[0]) != half.end();
  std::replace(half.begin(), half.end(), m, has_first ? edge[1] : edge[0]);
  return half;
}

}  // namespace

std::vector<std::vector<std::int32_t>> AdaptiveTriangles::around() const {
  std::vector<std::vector<std::int32_t>> found(parents_.size());
  for (std::size_t t = 0; t < surface_.triangles.size(); ++t)
    for (const std::int32_t v : surface_.triangles[t])
      found[v].push_back(static_cast<std::int32_t>(t));
  return found;
}

bool AdaptiveTriangles::can_join(std::int32_t vertex, std::span<const std::int32_t> halves) const {
  if (parents_[vertex][0] < 0) return false;
  return std::all_of(halves.begin(), halves.end(), [&](std::int32_t t) {
    return !cuts_[t].empty() && cuts_[t].back() == vertex;
  });
}

bool AdaptiveTriangles::is_flat(std::int32_t vertex, std::span<const std::int32_t> halves,
                                std::span<const Vec3> x, double angle, double limit) const {
  for (const std::int32_t t : halves) {
    const Vec3 n = detail::area_vector(x, surface_.triangles[t]);
    const Vec3 whole =
        detail::area_vector(x, whole_of(surface_.triangles[t], vertex, parents_[vertex]));
    for (int side = 0; side < 3; ++side) {
      const std::int32_t other = across(t, side);
      if (other < 0) continue;
      const Vec3 m = detail::area_vector(x, surface_.triangles[other]);
      if (!(detail::angle_between(n, m) <= angle) || !(detail::angle_between(whole, m) <= limit))
        return false;
    }
  }
  return true;
}

std::vector<std::int32_t> AdaptiveTriangles::flat(std::span<const Vec3> x, double angle,
                                                  double limit) const {
  const auto triangles = around();
  std::vector<std::int32_t> found;
  for (std::int32_t i = 0; i < vertex_count(); ++i)
    if (can_join(i, triangles[i]) && is_flat(i, triangles[i], x, angle, limit)) found.push_back(i);
  return found;
}

/// The triangles around a vertex that can be joined meet at its sides, one of which goes to a
/// parent. Others, of which no side is known, are looked for among all.
std::vector<std::int32_t> AdaptiveTriangles::nodes(std::int32_t vertex) const {
  const auto has = [&](std::int32_t t) {
    const Triangle& v = surface_.triangles[t];
    return std::find(v.begin(), v.end(), vertex) != v.end();
  };
  std::vector<std::int32_t> near;
  const std::int32_t parent = parents_[vertex][0];
  const auto side = sides_.find({std::min(parent, vertex), std::max(parent, vertex)});
  if (side != sides_.end()) near.push_back(side->second[0]);
  for (std::size_t i = 0; i < near.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t other = across(near[i], k);
      if (other >= 0 && has(other) && std::find(near.begin(), near.end(), other) == near.end())
        near.push_back(other);
    }
  for (std::int32_t t = 0; side == sides_.end() && t < static_cast<std::int32_t>(cuts_.size()); ++t)
    if (has(t)) near.push_back(t);
  std::vector<std::int32_t> found;
  for (const std::int32_t t : near)
    found.insert(found.end(), surface_.triangles[t].begin(), surface_.triangles[t].end());
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<Vec3> AdaptiveTriangles::flattened(std::span<const std::int32_t> vertices,
                                               std::span<const Vec3> x) const {
  const auto triangles = around();
  std::vector<Vec3> places(x.begin(), x.end());
  for (const std::int32_t i : vertices)
    if (can_join(i, triangles[i])) places[i] = 0.5 * (x[parents_[i][0]] + x[parents_[i][1]]);
  return places;
}

/// Of the two halves with the same opposite corner, the one with the lower number becomes the
/// whole; the other one is marked as gone.
void AdaptiveTriangles::unite(std::int32_t vertex, std::span<const std::int32_t> halves,
                              std::vector<char>& gone) {
  const auto corner = [&](std::int32_t t) {
    for (const std::int32_t v : surface_.triangles[t])
      if (v != vertex && v != parents_[vertex][0] && v != parents_[vertex][1]) return v;
    return -1;
  };
  // The vertex of the rest shape at which triangle t has vertex v.
  const auto place = [&](std::int32_t t, std::int32_t v) {
    int k = 0;
    while (surface_.triangles[t][k] != v) ++k;
    return rest_.triangles[t][k];
  };
  for (std::size_t i = 0; i < halves.size(); ++i)
    for (std::size_t j = i + 1; j < halves.size(); ++j) {
      const std::int32_t t = halves[i], other = halves[j];
      if (gone[t] != 0 || gone[other] != 0 || corner(t) != corner(other)) continue;
      const Triangle before = surface_.triangles[t];
      surface_.triangles[t] = whole_of(before, vertex, parents_[vertex]);
      for (int k = 0; k < 3; ++k)
        if (before[k] == vertex) rest_.triangles[t][k] = place(other, surface_.triangles[t][k]);
      cuts_[t].pop_back();
      gone[other] = 1;
    }
}

/// Leaves out vertices and triangles, and the vertices of the rest shape that splits had added for
/// them; `number`: of each vertex, or -1.
void AdaptiveTriangles::renumber(const std::vector<std::int32_t>& number,
                                 const std::vector<char>& gone) {
  TriangleMesh surface, rest;
  std::vector<std::vector<std::int32_t>> cuts;
  std::vector<Edge> parents;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    const auto [a, b] = parents_[i];
    surface.vertices.push_back(surface_.vertices[i]);
    parents.push_back(a < 0 ? Edge{-1, -1} : Edge{number[a], number[b]});
  }
  std::vector<char> stays(rest_.vertices.size(), 0);
  std::fill_n(stays.begin(), first_places_, 1);
  for (std::size_t t = 0; t < gone.size(); ++t)
    for (const std::int32_t v : rest_.triangles[t])
      if (gone[t] == 0) stays[v] = 1;
  std::vector<std::int32_t> place(stays.size(), -1);
  for (std::size_t i = 0; i < stays.size(); ++i) {
    if (stays[i] == 0) continue;
    place[i] = static_cast<std::int32_t>(rest.vertices.size());
    rest.vertices.push_back(rest_.vertices[i]);
  }
  for (std::size_t t = 0; t < gone.size(); ++t) {
    if (gone[t] != 0) continue;
    for (std::int32_t& v : surface_.triangles[t]) v = number[v];
    for (std::int32_t& v : rest_.triangles[t]) v = place[v];
    for (std::int32_t& v : cuts_[t]) v = number[v];
    surface.triangles.push_back(surface_.triangles[t]);
    rest.triangles.push_back(rest_.triangles[t]);
    cuts.push_back(std::move(cuts_[t]));
  }
  surface_ = std::move(surface);
  rest_ = std::move(rest);
  cuts_ = std::move(cuts);
  parents_ = std::move(parents);
  sides_ = sides_of(surface_);
}

std::vector<std::int32_t> AdaptiveTriangles::join(std::span<const std::int32_t> vertices,
                                                  std::vector<Vec3>& x, std::vector<Vec3>& v) {
  for (const std::size_t size : {x.size(), v.size()})
    if (size != parents_.size())
      throw std::invalid_argument("join: " + std::to_string(size) +
                                  " positions or velocities for " +
                                  std::to_string(parents_.size()) + " vertices of the mesh");
  const auto triangles = around();
  const std::vector<double> before = cloth().mass;
  std::vector<char> gone(surface_.triangles.size(), 0), leaves(parents_.size(), 0);
  std::vector<Vec3> momentum;
  for (std::size_t i = 0; i < v.size(); ++i) momentum.push_back(before[i] * v[i]);
  std::vector<char> takes(parents_.size(), 0);
  for (const std::int32_t i : vertices) {
    if (i < 0 || i >= vertex_count() || leaves[i] != 0 || !can_join(i, triangles[i])) continue;
    for (const std::int32_t end : parents_[i]) {
      momentum[end] += 0.5 * before[i] * v[i];
      takes[end] = 1;
    }
    leaves[i] = 1;
  }
  for (std::int32_t i = 0; i < vertex_count(); ++i)
    if (leaves[i] != 0) unite(i, triangles[i], gone);
  std::vector<std::int32_t> number(parents_.size(), -1);
  std::int32_t count = 0;
  for (std::size_t i = 0; i < number.size(); ++i)
    if (leaves[i] == 0) number[i] = count++;
  renumber(number, gone);
  const std::vector<double> after = cloth().mass;
  std::vector<Vec3> new_x, new_v;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    new_x.push_back(x[i]);
    new_v.push_back(takes[i] != 0 ? Vec3(momentum[i] / after[number[i]]) : v[i]);
  }
  x = std::move(new_x);
  v = std::move(new_v);
  return number;
}

}  // namespace selvedge
