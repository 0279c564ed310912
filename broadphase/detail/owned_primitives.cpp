// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/bytes.h>
#include <selvedge/broadphase/detail/owned_primitives.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

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

/// Triangles around each vertex.
struct VertexTriangles {
  std::vector<std::uint32_t> begin;
  std::vector<std::int32_t> triangle;

  VertexTriangles(std::span<const Triangle> triangles, std::size_t n)
      : begin(n + 2, 0), triangle(3 * triangles.size()) {
    // begin[v + 2] first counts the sides at v; then begin[v + 1] is the next free position;
    // finally begin[v] is the start.
    for (const Triangle& t : triangles)
      for (const std::int32_t v : t) ++begin[static_cast<std::size_t>(v) + 2];
    for (std::size_t v = 2; v < n + 2; ++v) begin[v] += begin[v - 1];
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (const std::int32_t v : triangles[t])
        triangle[begin[static_cast<std::size_t>(v) + 1]++] = static_cast<std::int32_t>(t);
  }
  std::span<const std::int32_t> of(std::size_t v) const {
    return {triangle.data() + begin[v], begin[v + 1] - begin[v]};
  }
};

}  // namespace

void OwnedPrimitives::set(const SurfaceView& surface) {
  vertex_count = surface.x_t0.size();
  triangles.assign(surface.triangles);
  edges.assign(surface.edges);
}

void OwnedPrimitives::set_loose(std::span<const std::int32_t> loose_edges_now,
                                std::span<const std::int32_t> loose_points_now) {
  loose_edges.assign(loose_edges_now.begin(), loose_edges_now.end());
  loose_points.assign(loose_points_now.begin(), loose_points_now.end());
  for (auto* list : {&owned_edges_begin, &owned_points_begin}) *list = {};
  for (auto* list : {&owned_edges, &owned_points}) *list = {};
}

bool OwnedPrimitives::equal(const SurfaceView& surface) const {
  return surface.x_t0.size() == vertex_count && same_bytes(surface.edges, edges) &&
         same_bytes(surface.triangles, triangles);
}

void OwnedPrimitives::find_owners() {
  const VertexTriangles around(triangles, vertex_count);
  std::vector<std::int32_t> load(triangles.size(), 0);  // number owned so far by each triangle
  const auto least = [&](std::size_t v, auto may_own) {
    std::int32_t best = -1;
    for (const std::int32_t t : around.of(v))
      if (may_own(t) && (best < 0 || load[t] < load[best])) best = t;
    if (best >= 0) ++load[best];
    return best;
  };
  std::vector<std::int32_t> owner(edges.size());
  for (std::size_t e = 0; e < edges.size(); ++e)
    owner[e] = least(static_cast<std::size_t>(edges[e][0]), [&](std::int32_t t) {
      const Triangle& corners = triangles[t];
      // A list with repeated edges must not overfill a leaf.
      return load[t] < kMostOwned &&
             std::find(corners.begin(), corners.end(), edges[e][1]) != corners.end();
    });
  group_by_owner(owner, triangles.size(), owned_edges_begin, owned_edges, loose_edges);

  std::fill(load.begin(), load.end(), 0);
  owner.resize(vertex_count);
  for (std::size_t v = 0; v < vertex_count; ++v)
    owner[v] = least(v, [](std::int32_t) { return true; });
  group_by_owner(owner, triangles.size(), owned_points_begin, owned_points, loose_points);
}

std::size_t OwnedPrimitives::bytes() const {
  return triangles.bytes() + edges.bytes() + bytes_of(loose_edges) + bytes_of(loose_points) +
         bytes_of(owned_edges_begin) + bytes_of(owned_points_begin) + bytes_of(owned_edges) +
         bytes_of(owned_points);
}

}  // namespace selvedge::detail
