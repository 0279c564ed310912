// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/surface_check.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace selvedge::detail {
namespace {

constexpr std::size_t kCheckGrain = 2048;  // vertices per range: about 5 µs of work

template <class Primitive>
void check_primitives(std::span<const Primitive> primitives, std::size_t n, const std::string& name,
                      const char* kind) {
  std::vector<std::uint8_t> bad(primitives.size() / kCheckGrain + 1, 0);
  parallel_for(primitives.size(), kCheckGrain, [&](std::size_t begin, std::size_t end) {
    bool wrong = false;
    for (std::size_t i = begin; i < end; ++i)
      for (const std::int32_t v : primitives[i])
        wrong |= static_cast<std::size_t>(static_cast<std::uint32_t>(v)) >= n;
    bad[begin / kCheckGrain] = wrong;
  });
  if (std::find(bad.begin(), bad.end(), 1) == bad.end()) return;
  for (std::size_t i = 0; i < primitives.size(); ++i)
    for (const std::int32_t v : primitives[i])
      if (v < 0 || static_cast<std::size_t>(v) >= n)
        throw std::invalid_argument(name + ": " + kind + " " + std::to_string(i) +
                                    " names vertex " + std::to_string(v) + " of " +
                                    std::to_string(n));
}

std::string text(const Vec3& x) {
  std::string out;
  for (int k = 0; k < 3; ++k) {
    out += k == 0 ? "(" : ", ";
    out += std::to_string(x[k]);
  }
  return out + ")";
}

[[noreturn]] void throw_first_not_finite(const SurfaceView& surface, const std::string& name) {
  for (std::size_t i = 0; i < surface.x_t0.size(); ++i) {
    const bool start = !surface.x_t0[i].allFinite();
    if (start || !surface.x_t1[i].allFinite())
      throw std::invalid_argument(name + ": vertex " + std::to_string(i) + " is at " +
                                  text(start ? surface.x_t0[i] : surface.x_t1[i]) + " at the " +
                                  (start ? "start" : "end") +
                                  " of the step; coordinates must be finite");
  }
  throw std::logic_error(name + ": a vertex changed while it was read");
}

}  // namespace

void check_shape(const SurfaceView& surface, const std::string& name) {
  if (surface.x_t0.size() != surface.x_t1.size())
    throw std::invalid_argument(name + ": " + std::to_string(surface.x_t0.size()) +
                                " vertices at the start of the step but " +
                                std::to_string(surface.x_t1.size()) + " at its end");
  constexpr auto most = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  if (std::max({surface.x_t0.size(), surface.edges.size(), surface.triangles.size()}) > most)
    throw std::invalid_argument(name + ": more than 2^31 - 1 vertices, edges or triangles");
  if (!(surface.thickness >= 0.0) || !std::isfinite(surface.thickness))
    throw std::invalid_argument(name + ": thickness is " + std::to_string(surface.thickness) +
                                " m; it must be finite and not negative");
}

void check_indices(const SurfaceView& surface, const std::string& name) {
  check_primitives(surface.edges, surface.x_t0.size(), name, "edge");
  check_primitives(surface.triangles, surface.x_t0.size(), name, "triangle");
}

Bounds check_finite(const SurfaceView& surface, const std::string& name) {
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::size_t n = surface.x_t0.size();
  struct Part {
    Bounds bounds{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
    Vec3 residue = Vec3::Zero();
  };
  std::vector<Part> parts(n / kCheckGrain + 1);
  parallel_for(n, kCheckGrain, [&](std::size_t begin, std::size_t end) {
    Part part;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 &x0 = surface.x_t0[i], &x1 = surface.x_t1[i];
      // 0·x is 0 for every finite x and NaN otherwise, and a NaN stays in the sum.
      part.residue += 0.0 * x0 + 0.0 * x1;
      part.bounds.lo = part.bounds.lo.cwiseMin(x0);
      part.bounds.hi = part.bounds.hi.cwiseMax(x0);
    }
    parts[begin / kCheckGrain] = part;
  });
  Bounds all{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  for (const Part& part : parts) {
    if (!(part.residue.array() == 0.0).all()) throw_first_not_finite(surface, name);
    all.lo = all.lo.cwiseMin(part.bounds.lo);
    all.hi = all.hi.cwiseMax(part.bounds.hi);
  }
  return all;
}

}  // namespace selvedge::detail
