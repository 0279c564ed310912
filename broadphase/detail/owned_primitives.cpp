// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/owned_primitives.h>

#include <algorithm>
#include <cstring>

namespace selvedge::detail {
namespace {

template <class T>
std::size_t bytes_of(const std::vector<T>& v) {
  return v.capacity() * sizeof(T);
}

template <class T>
bool same_bytes(std::span<const T> a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// Triangles around each vertex.
struct VertexTriangles {
  std::vector<std::uint32_t> begin;
  std::vector<std::int32_t> triangle;

  VertexTriangles(std::span<const Triangle> triangles, std::size_t n)
      : begin(n + 1, 0), triangle(3 * triangles.size()) {
    for (const Triangle& t : triangles)
      for (const std::int32_t v : t) ++begin[v + 1];
    for (std::size_t v = 0; v < n; ++v) begin[v + 1] += begin[v];
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (const std::int32_t v : triangles[t]) triangle[next[v]++] = static_cast<std::int32_t>(t);
  }
  std::span<const std::int32_t> of(std::int32_t v) const {
    return {triangle.data() + begin[v], begin[v + 1] - begin[v]};
  }
};

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

void OwnedPrimitives::set(const SurfaceView& surface) {
  vertex_count = surface.x_t0.size();
  triangles.assign(surface.triangles.begin(), surface.triangles.end());
  edges.assign(surface.edges.begin(), surface.edges.end());
  find_owners();
}

bool OwnedPrimitives::equal(const SurfaceView& surface) const {
  return surface.x_t0.size() == vertex_count && same_bytes(surface.edges, edges) &&
         same_bytes(surface.triangles, triangles);
}

/// Of the triangles that contain it, the owner of an edge or a point is the one that owns least so
/// far: leaves of equal size then hold about the same number of edges and points.
void OwnedPrimitives::find_owners() {
  const VertexTriangles around(triangles, vertex_count);
  const std::size_t count = triangles.size();
  std::vector<std::uint16_t> load(count, 0);  // owned so far
  const auto take_least = [&](std::int32_t& best, std::int32_t t) {
    if (best < 0 || load[t] < load[best]) best = t;
  };

  std::vector<std::int32_t> owner(edges.size(), -1);
  for (std::size_t e = 0; e < owner.size(); ++e) {
    for (const std::int32_t t : around.of(edges[e][0])) {
      const Triangle& corners = triangles[t];
      if (std::find(corners.begin(), corners.end(), edges[e][1]) != corners.end())
        take_least(owner[e], t);
    }
    // A list with repeated edges must not overfill a leaf.
    if (owner[e] >= 0 && load[owner[e]] >= kMostOwned) owner[e] = -1;
    if (owner[e] >= 0) ++load[owner[e]];
  }
  group_by_owner(owner, count, owned_edges_begin, owned_edges, loose_edges);

  std::fill(load.begin(), load.end(), std::uint16_t{0});
  owner.assign(vertex_count, -1);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    for (const std::int32_t t : around.of(static_cast<std::int32_t>(v))) take_least(owner[v], t);
    if (owner[v] >= 0) ++load[owner[v]];
  }
  group_by_owner(owner, count, owned_points_begin, owned_points, loose_points);
}

std::size_t OwnedPrimitives::bytes() const {
  return bytes_of(triangles) + bytes_of(edges) + bytes_of(loose_edges) + bytes_of(loose_points) +
         bytes_of(owned_edges_begin) + bytes_of(owned_points_begin) + bytes_of(owned_edges) +
         bytes_of(owned_points);
}

}  // namespace selvedge::detail
