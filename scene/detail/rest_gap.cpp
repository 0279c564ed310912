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

// Pairs are searched about as far as this many rest gaps (simulation/contacts/candidates.cpp).
constexpr double kReach = 1.5;

// Pairs for each pair of vertices of two surfaces: 2 points and triangles each way, and 3 x 3
// edges.
constexpr double kPairsPerVertexPair = 13.0;

// Each pair in reach takes about this much, measured on a sheet of 0.033 mm cells, alone and beside
// a ball, with a rest gap of 2 mm: 1.9 and 9.8 GB.
constexpr double kBytesPerPair = 330.0;
constexpr double kMostBytes = 2e9;

// A rest gap of fewer cells is not what makes the pairs many.
constexpr double kFewCells = 2.0;

}  // namespace

SurfaceGrain grain_of(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  SurfaceGrain grain;
  std::vector<char> used(x.size(), 0);
  for (const Triangle& t : triangles) {
    grain.area += 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
    for (const std::int32_t v : t) used[v] = 1;
  }
  grain.vertices = static_cast<double>(std::count(used.begin(), used.end(), 1));
  return grain;
}

double SurfaceGrain::cell() const { return std::sqrt(area / std::max(vertices, 1.0)); }

double SurfaceGrain::within(double reach) const {
  return std::min(vertices, vertices * std::numbers::pi * reach * reach / area);
}

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

// The coarser of the two surfaces decides whether the rest gap is one of many cells, the one with
// fewer pairs how many there can be: it may lie on the other one as a whole.
void refuse_rest_gap(const SurfaceGrain& piece, const SurfaceGrain& other, bool itself,
                     double rest_gap) {
  const double cell = std::max(piece.cell(), other.cell()), reach = kReach * rest_gap;
  if (!(std::min(piece.cell(), other.cell()) > 0.0) || rest_gap <= kFewCells * cell) return;
  const double vertex_pairs =
      std::min(piece.vertices * other.within(reach), other.vertices * piece.within(reach));
  const double pairs = (itself ? 0.5 : 1.0) * kPairsPerVertexPair * vertex_pairs;
  if (kBytesPerPair * pairs <= kMostBytes) return;
  throw std::invalid_argument(fmt::format(
      "contact.rest_gap (or that of contact.pairs) is {:g} m, {:.0f} times the distance of "
      "neighbouring vertices, so that up to {:.0e} pairs would be in reach at once, {:.0f} GB; use "
      "a rest gap of at most {:.2g} m or larger cells",
      rest_gap, rest_gap / cell, pairs, std::ceil(1e-9 * kBytesPerPair * pairs), cell));
}

}  // namespace selvedge::detail
