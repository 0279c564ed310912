// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Vertices (n,3) in metres and triangles (k,3).
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// Every edge of the triangles once, lower index first, sorted.
std::vector<Edge> unique_edges(std::span<const Triangle> triangles);

/// Area-weighted unit normal of each vertex; zero where the vertex has no triangle with area.
std::vector<Vec3> vertex_normals(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// A third of the area of the adjacent triangles of each vertex, m².
std::vector<double> vertex_areas(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// Throws std::invalid_argument naming the first vertex that is not finite or the first triangle
/// with an index outside [0, n) or with a repeated index. `name` starts the sentence.
void validate(const TriangleMesh& mesh, const std::string& name);

}  // namespace selvedge
