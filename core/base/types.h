// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// A point, direction or velocity. All lengths are in metres and all times in seconds.
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Two vertex indices of one surface.
using Edge = std::array<std::int32_t, 2>;
/// Three vertex indices of one surface, counter-clockwise seen from the front.
using Triangle = std::array<std::int32_t, 3>;

/// Vertices (n,3) in metres and triangles (k,3), counter-clockwise from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// The edges of the triangles without repetition, lower index first, sorted.
std::vector<Edge> unique_edges(std::span<const Triangle> triangles);

/// Area-weighted unit normal of each vertex; zero if the vertex has no triangle with area.
std::vector<Vec3> vertex_normals(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// A third of the area of the triangles at each vertex, m².
std::vector<double> vertex_areas(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// Throws std::invalid_argument naming the first vertex that is not finite, or the first triangle
/// that has an index outside [0, n) or a repeated index. `name` starts the message.
void validate(const TriangleMesh& mesh, const std::string& name);

// Decompositions of small matrices: one source instantiates Eigen's templates for them, which take
// seconds to compile.

/// Eigenvalues in increasing order, and unit eigenvectors as columns.
struct SymmetricEigen {
  Vec3 values;
  Mat3 vectors;
  bool converged;
};
SymmetricEigen symmetric_eigen(const Mat3& m);

/// The rotation R with the largest trace of Rᵀ m: for m = Σ (x - x̄)(p - p̄)ᵀ the one that best takes
/// the points p to x [Kabsch1976].
Mat3 nearest_rotation(const Mat3& m);

/// The pseudoinverse of a symmetric matrix without negative eigenvalues. Eigenvalues up to `cut`
/// times the largest count as zero.
Mat3 pseudo_inverse(const Mat3& m, double cut);

}  // namespace selvedge
