// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/scene/detail/between_particles.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <vector>

namespace selvedge::detail {
namespace {

constexpr double kEdgesCounted = 0.98;
constexpr double kLargestTurn = 3.0;  // rad: an edge around a rim cannot turn farther
constexpr double kShareOfGap = 0.5;

/// The turn of a surface over one of its edges.
struct Turn {
  double angle = 0.0;  // rad, 0 where the surface is hollow
  double width = 0.0;  // m, the mean of the heights of both triangles above the edge
};

Turn turn_between(std::span<const Vec3> x, const Triangle& a, const Triangle& b, const Edge& edge) {
  const auto normal = [&](const Triangle& t) {
    return Vec3((x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]));
  };
  const Vec3 n = normal(a), m = normal(b);
  const double length = (x[edge[1]] - x[edge[0]]).norm();
  if (!(n.norm() > 0.0 && m.norm() > 0.0 && length > 0.0)) return {};
  const Vec3 apart = (x[b[0]] + x[b[1]] + x[b[2]] - x[a[0]] - x[a[1]] - x[a[2]]) / 3.0;
  if (n.dot(apart) >= 0.0) return {};  // hollow or flat
  return {.angle = elementary::atan2(n.cross(m).norm(), n.dot(m)),
          .width = 0.5 * (n.norm() + m.norm()) / length};
}

std::vector<Turn> turns_of(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  std::map<Edge, const Triangle*> first;
  std::vector<Turn> turns;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge edge = {std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])};
      const auto [at, is_new] = first.try_emplace(edge, &t);
      if (!is_new) turns.push_back(turn_between(x, *at->second, t, edge));
    }
  return turns;
}

/// The height of an arc or a corner above its chord, m.
double rise(const Turn& turn, double chord) {
  if (!(turn.width > 0.0)) return 0.0;
  const bool is_arc = chord > turn.width;
  const double whole = std::min(turn.angle * (is_arc ? chord / turn.width : 1.0), kLargestTurn);
  return 0.5 * chord * elementary::tan(whole * (is_arc ? 0.25 : 0.5));
}

double longest_edge(const BuiltScene& built, std::size_t piece) {
  double longest = 0.0;
  for (const Edge& e : built.cloth.edges)
    if (e[0] >= built.piece_begin[piece] && e[0] < built.piece_begin[piece + 1])
      longest = std::max(
          longest,
          (built.cloth.surface.vertices[e[0]] - built.cloth.surface.vertices[e[1]]).norm());
  return longest;
}

double thinnest(std::span<const Vec3> x) {
  Vec3 lo = x[0], hi = x[0];
  for (const Vec3& p : x) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  return (hi - lo).minCoeff();
}

}  // namespace

double rise_above_edge(std::span<const Vec3> x, std::span<const Triangle> triangles,
                       double length) {
  std::vector<double> rises;
  for (const Turn& turn : turns_of(x, triangles)) rises.push_back(rise(turn, length));
  if (rises.empty()) return 0.0;
  const auto at = rises.begin() + static_cast<std::ptrdiff_t>(
                                      kEdgesCounted * static_cast<double>(rises.size() - 1));
  std::nth_element(rises.begin(), at, rises.end());
  return *at;
}

void warn_between_particles(const Scene& scene, BuiltScene& built) {
  const ContactPairs pairs(scene);
  for (std::size_t b = 0; b < built.bodies.size(); ++b) {
    const Body& body = *built.bodies[b];
    std::vector<Vec3> x(body.vertex_count());
    body.positions(0.0, x);
    if (x.empty()) continue;
    for (std::size_t p = 0; p < scene.cloths.size(); ++p) {
      const auto piece = static_cast<std::int32_t>(p),
                 other = static_cast<std::int32_t>(scene.cloths.size() + b);
      if (!pairs.collide(piece, other)) continue;
      const double gap = pairs.rest_gap(piece, other), length = longest_edge(built, p);
      const double high = rise_above_edge(x, body.triangles(), length);
      if (high > kShareOfGap * gap)
        built.warnings.push_back(fmt::format(
            "obstacle \"{}\": {} tests the particles of \"{}\" alone, and between two of them, "
            "{:.2g} m apart, this body rises by {:.2g} m, more than half of the rest gap of {:g} "
            "m, "
            "so it may pass through the cloth; use smaller cells, a rest gap of at least {:.2g} m "
            "or "
            "another contact.broad_phase",
            scene.bodies[b].name, scene.contact.broad_phase, scene.cloths[p].name, length, high,
            gap, high / kShareOfGap));
      if (const double thin = thinnest(x); thin < gap)
        built.warnings.push_back(fmt::format(
            "obstacle \"{}\": is {:.2g} m thin, less than the rest gap of {:g} m, so {} cannot "
            "tell its sides apart; use a rest gap of at most {:.2g} m or another "
            "contact.broad_phase",
            scene.bodies[b].name, thin, gap, scene.contact.broad_phase, thin));
    }
  }
}

}  // namespace selvedge::detail
