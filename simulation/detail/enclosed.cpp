// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/simulation/detail/enclosed.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace selvedge::detail {
namespace {

TriangleMesh bodies_of(const JointSurface& surface, std::span<const Vec3> x) {
  const std::span<const Triangle> all = surface.triangles();
  const auto triangles = all.subspan(surface.cloth_triangles());
  return {{x.begin(), x.end()}, {triangles.begin(), triangles.end()}};
}

}  // namespace

std::optional<Enclosed> find_enclosed(const JointSurface& surface, std::span<const Vec3> x,
                                      std::span<const EdgeCrossing> crossings) {
  const TriangleMesh bodies = bodies_of(surface, x);
  const ClosedParts closed(bodies);
  if (closed.empty()) return std::nullopt;
  std::vector<char> seen(surface.parts(), 0);
  for (const EdgeCrossing& c : crossings) {
    const std::int32_t a = surface.edges()[c.edge][0], b = surface.triangles()[c.triangle][0];
    if (surface.is_cloth(a) != surface.is_cloth(b))
      seen[surface.part(surface.is_cloth(a) ? a : b)] = 1;
  }
  for (std::size_t i = 0; i < surface.cloth_vertices(); ++i) {
    const auto v = static_cast<std::int32_t>(i);
    // A vertex of no triangle is not part of a surface: the sparse layer of a bilayered cloth.
    if (surface.triangles_of_vertex(v).empty()) continue;
    if (std::exchange(seen[surface.part(v)], 1) != 0) continue;
    if (const std::int32_t t = closed.part_around(x[v]); t >= 0)
      return Enclosed{v, bodies.triangles[t][0]};
  }
  return std::nullopt;
}

int count_inside(const JointSurface& surface, std::span<const Vec3> x,
                 std::span<const std::int32_t> vertices) {
  const ClosedParts closed(bodies_of(surface, x));
  return static_cast<int>(
      std::count_if(vertices.begin(), vertices.end(), [&](const std::int32_t v) {
        return closed.may_contain(x[v]) && closed.part_around(x[v]) >= 0;
      }));
}

}  // namespace selvedge::detail
