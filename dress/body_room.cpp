// SPDX-License-Identifier: MIT
//
// Room for cloth where a body nearly touches itself, as thighs and armpits do: skin yields to cloth
// between two parts of a body, but a mesh does not. Where two sides of the body face each other
// across a narrow gap, both are moved back along their normals.
#include <selvedge/core/base/types.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/body_room.h>
#include <selvedge/dress/detail/winding_number.h>
#include <selvedge/dress/dress.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <vector>

namespace selvedge {
namespace {

constexpr double kFacing = -0.3;  // cosine of two normals below which two sides face each other
constexpr double kAhead = 0.5;    // cosine above which the other side lies ahead, not behind
constexpr double kAbove = 1e-4;   // m above the surface, where a vertex is outside of its own part
constexpr int kSpread = 4;        // rounds in which the neighbours follow
constexpr double kFollow = 0.7;   // share of the mean of its neighbours that a vertex follows
constexpr int kEase = 3;          // frames by which a vertex of a moving body goes back earlier

Vec3 normal_of(const TriangleMesh& body, std::int32_t triangle) {
  const Triangle& t = body.triangles[triangle];
  return (body.vertices[t[1]] - body.vertices[t[0]])
      .cross(body.vertices[t[2]] - body.vertices[t[0]])
      .normalized();
}

/// Distance of a vertex from a triangle that faces it, m: positive if the triangle lies ahead,
/// negative if the vertex is in another part of the body, and nullopt if the triangle is only the
/// other side of a thin part.
std::optional<double> gap_ahead(const TriangleMesh& body, const detail::WindingNumber& winding,
                                const Vec3& normal, const Proximity& near) {
  const double ahead = -normal.dot(near.normal);  // `near.normal` points towards the vertex
  if (ahead > kAhead) return near.gap;
  if (ahead > -kAhead) return std::nullopt;
  const Vec3 above = body.vertices[near.vertex[0]] + kAbove * normal;
  if (winding.at(above) < 0.5) return std::nullopt;
  return -near.gap;
}

/// How far each vertex has to go back so that both sides of every gap are `room` apart, m.
std::vector<double> distances_back(const TriangleMesh& body, std::span<const Vec3> normals,
                                   std::span<const double> room) {
  std::vector<double> back(body.vertices.size(), 0.0);
  const double most = room.empty() ? 0.0 : *std::max_element(room.begin(), room.end());
  if (most <= 0.0) return back;
  const detail::WindingNumber winding(body);
  for (const Proximity& near : find_contacts(body.vertices, body.triangles, most)) {
    if (near.kind == ContactKind::edge_edge) continue;
    const std::int32_t vertex = near.vertex[0];
    if (room[vertex] <= 0.0) continue;
    if (normals[vertex].dot(normal_of(body, near.primitive_b)) > kFacing) continue;
    if (const auto gap = gap_ahead(body, winding, normals[vertex], near))
      back[vertex] = std::max(back[vertex], 0.5 * (room[vertex] - *gap));
  }
  return back;
}

/// Lets the neighbours of a vertex that goes back follow it, so that no spike is left.
void spread(std::span<const Edge> edges, std::vector<double>& back) {
  for (int round = 0; round < kSpread; ++round) {
    std::vector<double> sum(back.size(), 0.0), count(back.size(), 0.0);
    for (const auto& [a, b] : edges) {
      sum[a] += back[b];
      sum[b] += back[a];
      count[a] += 1.0;
      count[b] += 1.0;
    }
    for (std::size_t v = 0; v < back.size(); ++v)
      if (count[v] > 0.0) back[v] = std::max(back[v], kFollow * sum[v] / count[v]);
  }
}

std::vector<double> spread_distances(const TriangleMesh& body, std::span<const Vec3> normals,
                                     std::span<const double> room) {
  std::vector<double> back = distances_back(body, normals, room);
  spread(unique_edges(body.triangles), back);
  return back;
}

/// Mean over the frames around k of the largest value around each of them: at least the value of
/// frame k, and smooth in time.
double eased(const std::vector<std::vector<double>>& back, std::size_t k, std::size_t v) {
  const auto last = static_cast<std::ptrdiff_t>(back.size()) - 1;
  const auto value = [&](std::ptrdiff_t i) {
    return back[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, last))][v];
  };
  double sum = 0.0;
  for (std::ptrdiff_t i = -kEase; i <= kEase; ++i) {
    double largest = 0.0;
    for (std::ptrdiff_t j = -kEase; j <= kEase; ++j)
      largest = std::max(largest, value(static_cast<std::ptrdiff_t>(k) + i + j));
    sum += largest;
  }
  return sum / (2 * kEase + 1);
}

}  // namespace

std::vector<Vec3> detail::with_room(const TriangleMesh& body, std::span<const double> room) {
  const std::vector<Vec3> normals = vertex_normals(body.vertices, body.triangles);
  const std::vector<double> back = spread_distances(body, normals, room);
  std::vector<Vec3> x = body.vertices;
  for (std::size_t v = 0; v < back.size(); ++v)
    if (back[v] > 0.0) x[v] -= back[v] * normals[v];
  return x;
}

BodyRoom make_room(const TriangleMesh& body, double room) {
  BodyRoom made{body, 0, 0.0};
  if (room <= 0.0) return made;
  const std::vector<Vec3> normals = vertex_normals(body.vertices, body.triangles);
  const std::vector<double> everywhere(body.vertices.size(), room);
  const std::vector<double> back = spread_distances(body, normals, everywhere);
  for (std::size_t v = 0; v < back.size(); ++v) {
    if (back[v] <= 0.0) continue;
    made.body.vertices[v] -= back[v] * normals[v];
    made.largest = std::max(made.largest, back[v]);
    ++made.vertices;
  }
  return made;
}

void make_room(std::vector<TriangleMesh>& frames, double room) {
  if (room <= 0.0) return;
  std::vector<std::vector<Vec3>> normals;
  std::vector<std::vector<double>> back;
  for (const TriangleMesh& frame : frames) {
    normals.push_back(vertex_normals(frame.vertices, frame.triangles));
    const std::vector<double> everywhere(frame.vertices.size(), room);
    back.push_back(spread_distances(frame, normals.back(), everywhere));
  }
  for (std::size_t k = 0; k < frames.size(); ++k)
    for (std::size_t v = 0; v < back[k].size(); ++v)
      frames[k].vertices[v] -= eased(back, k, v) * normals[k][v];
}

}  // namespace selvedge
