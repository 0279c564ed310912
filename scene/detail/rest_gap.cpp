// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/rest_gap.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace selvedge::detail {
namespace {

// Contacts are searched as far as this many rest gaps (kPointReach of simulation/detail/contacts).
constexpr double kReach = 1.5;

// Pairs for each pair of vertices: 2 points and triangles, and half of 3 x 3 edges.
constexpr double kPairsPerVertexPair = 6.5;

// Each pair takes up to 2 kB in the solve, so this is at most about 4 GB and a minute a step.
constexpr double kMostPairs = 2e6;

double area_of(const TriangleMesh& mesh) {
  double area = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[1]] - mesh.vertices[t[0]];
    area += 0.5 * a.cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm();
  }
  return area;
}

}  // namespace

void warn_of_rest_gap(const ClothMesh& piece, double rest_gap, const std::string& place,
                      std::vector<std::string>& warnings) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const Edge& e : piece.edges)
    shortest =
        std::min(shortest, (piece.surface.vertices[e[0]] - piece.surface.vertices[e[1]]).norm());
  if (shortest >= rest_gap) return;
  warnings.push_back(fmt::format(
      "{}: contact.rest_gap (or that of contact.pairs) is {:g} m, but the shortest edge is {:g} m. "
      "Contacts between neighbouring particles make the cloth stiffer; use a rest gap of at most "
      "{:g} m or larger cells",
      place, rest_gap, shortest, shortest));
}

// In a flat sheet of n vertices and area A, n π r² / A vertices lie within r of each.
void refuse_rest_gap(const TriangleMesh& piece, double rest_gap) {
  const auto n = static_cast<double>(piece.vertices.size());
  const double area = area_of(piece), reach = kReach * rest_gap;
  const double cell = std::sqrt(area / std::max(n, 1.0));
  if (!(cell > 0.0) || rest_gap <= cell) return;
  const double near = std::min(n, n * std::numbers::pi * reach * reach / area);
  if (kPairsPerVertexPair * n * near <= kMostPairs) return;
  throw std::invalid_argument(fmt::format(
      "contact.rest_gap (or that of contact.pairs) is {:g} m, {:.0f} times the distance of "
      "neighbouring particles, so that about {:.0g} pairs of this piece would be in contact; use a "
      "rest gap of at most {:.2g} m or larger cells",
      rest_gap, rest_gap / cell, kPairsPerVertexPair * n * near, cell));
}

}  // namespace selvedge::detail
