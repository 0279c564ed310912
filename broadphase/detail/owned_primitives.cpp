// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/bytes.h>
#include <selvedge/broadphase/detail/owned_primitives.h>
#include <selvedge/core/parallel.h>

#include <algorithm>
#include <cstring>

namespace selvedge::detail {
namespace {

constexpr std::size_t kEdgeGrain = 8192;  // edges per task of finding their sides

/// Groups 0..owner.size()-1 by owner; those with owner -1 go to `loose`.
void group_by_owner(const std::vector<std::int32_t>& owner, std::size_t owners,
                    std::vector<std::uint32_t>& begin, std::vector<std::int32_t>& owned,
                    std::vector<std::int32_t>& loose) {
  begin.assign(owners + 1, 0);
  loose.clear();
  for (const std::int32_t o : owner)
    if (o >= 0) ++begin[o + 1];
  for (std::size_t o = 0; o < owners; ++o) begin[o + 1] += begin[o];
  owned.resize(begin[owners]);
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t i = 0; i < owner.size(); ++i)
    if (owner[i] >= 0)
      owned[next[owner[i]]++] = static_cast<std::int32_t>(i);
    else
      loose.push_back(static_cast<std::int32_t>(i));
}

}  // namespace

void OwnedPrimitives::VertexTriangles::set(std::span<const Triangle> triangles, std::size_t n) {
  // begin[v + 2] first counts the sides at v; then begin[v + 1] is the next free position; finally
  // begin[v] is the start.
  begin.assign(n + 2, 0);
  triangle.resize(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) ++begin[static_cast<std::size_t>(v) + 2];
  for (std::size_t v = 2; v < n + 2; ++v) begin[v] += begin[v - 1];
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const std::int32_t v : triangles[t])
      triangle[begin[static_cast<std::size_t>(v) + 1]++] = static_cast<std::int32_t>(t);
}

void OwnedPrimitives::set(const SurfaceView& surface) {
  vertex_count = surface.x_t0.size();
  triangles.assign(surface.triangles.begin(), surface.triangles.end());
  edges.assign(surface.edges.begin(), surface.edges.end());
  around_.set(triangles, vertex_count);
  find_sides();
}

void OwnedPrimitives::find_sides() {
  sides_.resize(edges.size());
  parallel_for(edges.size(), kEdgeGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      sides_[e] = {-1, -1};
      int found = 0;
      for (const std::int32_t t : around_.of(static_cast<std::size_t>(edges[e][0]))) {
        const Triangle& corners = triangles[t];
        if (std::find(corners.begin(), corners.end(), edges[e][1]) == corners.end()) continue;
        sides_[e][found++] = t;
        if (found == 2) break;
      }
    }
  });
}

void OwnedPrimitives::forget_sides() {
  around_ = {};
  sides_ = {};
}

bool OwnedPrimitives::equal(const SurfaceView& surface) const {
  return surface.x_t0.size() == vertex_count && same_bytes(surface.edges, edges) &&
         same_bytes(surface.triangles, triangles);
}

/// An edge or point inside one group belongs to it. Of several groups at an edge or point, the one
/// that owns least so far becomes the owner, so that leaves hold similar numbers of edges and
/// points.
void OwnedPrimitives::find_owners(std::span<const std::int32_t> group, int most_edges) {
  const std::size_t count = triangles.size();
  const auto group_of = [&](std::int32_t t) { return group.empty() ? t : group[t]; };
  std::vector<std::int32_t> load(count, 0);  // number owned so far by each group

  std::vector<std::int32_t> owner(edges.size(), -1);
  const auto own_edge = [&](std::size_t e, std::int32_t t) {
    // A list with repeated edges must not overfill a leaf.
    if (load[group_of(t)] >= most_edges) return;
    owner[e] = t;
    ++load[group_of(t)];
  };
  const auto is_inner = [&](const std::array<std::int32_t, 2>& side) {
    return side[0] >= 0 && (side[1] < 0 || group_of(side[0]) == group_of(side[1]));
  };
  for (std::size_t e = 0; e < owner.size(); ++e)
    if (is_inner(sides_[e])) own_edge(e, sides_[e][0]);
  for (std::size_t e = 0; e < owner.size(); ++e) {
    if (is_inner(sides_[e]) || sides_[e][0] < 0) continue;
    const auto [t, u] = sides_[e];
    own_edge(e, load[group_of(u)] < load[group_of(t)] ? u : t);
  }
  group_by_owner(owner, count, owned_edges_begin, owned_edges, loose_edges);

  std::fill(load.begin(), load.end(), 0);
  owner.assign(vertex_count, -1);
  for (const bool inner : {true, false})
    for (std::size_t v = 0; v < vertex_count; ++v) {
      const auto near = around_.of(v);
      if (near.empty() || owner[v] >= 0) continue;
      std::int32_t least = near[0];
      bool is_inside = true;
      for (const std::int32_t t : near) {
        is_inside &= group_of(t) == group_of(near[0]);
        if (load[group_of(t)] < load[group_of(least)]) least = t;
      }
      if (inner && !is_inside) continue;
      owner[v] = least;
      ++load[group_of(least)];
    }
  group_by_owner(owner, count, owned_points_begin, owned_points, loose_points);
}

std::size_t OwnedPrimitives::bytes() const {
  return bytes_of(triangles) + bytes_of(edges) + bytes_of(loose_edges) + bytes_of(loose_points) +
         bytes_of(owned_edges_begin) + bytes_of(owned_points_begin) + bytes_of(owned_edges) +
         bytes_of(owned_points) + bytes_of(around_.begin) + bytes_of(around_.triangle) +
         bytes_of(sides_);
}

}  // namespace selvedge::detail
