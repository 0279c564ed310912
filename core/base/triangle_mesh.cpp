// SPDX-License-Identifier: MIT
#include <selvedge/core/base/types.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <string>

namespace selvedge {

std::vector<Edge> unique_edges(std::span<const Triangle> triangles) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k)
      edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

std::vector<Vec3> vertex_normals(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  std::vector<Vec3> normals(x.size(), Vec3::Zero());
  for (const Triangle& t : triangles) {
    const Vec3 n = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
    for (const std::int32_t v : t) normals[v] += n;
  }
  for (Vec3& n : normals) {
    const double length = n.norm();
    n = length > 0.0 ? Vec3(n / length) : Vec3::Zero();
  }
  return normals;
}

std::vector<double> vertex_areas(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  std::vector<double> areas(x.size(), 0.0);
  for (const Triangle& t : triangles) {
    const double third = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm() / 6.0;
    for (const std::int32_t v : t) areas[v] += third;
  }
  return areas;
}

void validate(const TriangleMesh& mesh, const std::string& name) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite())
      throw std::invalid_argument(name + ": vertex " + std::to_string(i) +
                                  " has a coordinate that is not finite");
  const auto n = static_cast<std::int32_t>(mesh.vertices.size());
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const Triangle& t = mesh.triangles[k];
    for (const std::int32_t v : t)
      if (v < 0 || v >= n)
        throw std::invalid_argument(name + ": triangle " + std::to_string(k) + " names vertex " +
                                    std::to_string(v) + ", but the mesh has vertices 0 to " +
                                    std::to_string(n - 1));
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      throw std::invalid_argument(name + ": triangle " + std::to_string(k) +
                                  " names the same vertex twice");
  }
}

}  // namespace selvedge
