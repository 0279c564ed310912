// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/floating_point.h>
#include <selvedge/detection/detail/surface_checks.h>

#include <limits>
#include <stdexcept>

namespace selvedge::detail {
namespace {

std::string text(const Vec3& x) {
  return "(" + std::to_string(x[0]) + ", " + std::to_string(x[1]) + ", " + std::to_string(x[2]) +
         ")";
}

}  // namespace

void check_vertices(std::span<const Vec3> x, const std::string& name, const char* array) {
  require_ieee_arithmetic();  // the bounds of the exact tests need it
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  if (x.size() > kMost)
    throw std::invalid_argument(name + ": " + std::to_string(x.size()) +
                                " vertices; at most 2^31 - 1 have an index");
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!x[i].allFinite())
      throw std::invalid_argument(name + ": " + array + "[" + std::to_string(i) + "] is " +
                                  text(x[i]) + "; coordinates must be finite");
}

void check_triangles(std::span<const Triangle> triangles, std::size_t n, const std::string& name) {
  // Edges are at most three times as many, and have indices of the same type.
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) / 3;
  if (triangles.size() > kMost)
    throw std::invalid_argument(name + ": " + std::to_string(triangles.size()) +
                                " triangles; at most " + std::to_string(kMost) + " are possible");
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const std::int32_t v : triangles[t])
      if (v < 0 || static_cast<std::size_t>(v) >= n)
        throw std::invalid_argument(name + ": triangles[" + std::to_string(t) + "] has the index " +
                                    std::to_string(v) + "; it must be in [0, " + std::to_string(n) +
                                    ")");
}

}  // namespace selvedge::detail
