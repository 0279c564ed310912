// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/moving_differences.h>
#include <selvedge/narrowphase/detail/per_query.h>

// Discrete detection: the primitives count as colliding if they are nearer than a thickness at the
// start or at the end of the step. [Bridson2002] section 6 uses this test before its continuous
// one. Ignores everything in between.
//
// If they are near at the start, toi is 0. If they are near only at the end, toi is a time before
// which they cannot have been near: no two of their points approach faster than the fastest pair of
// vertices, so the distance decreases by at most that speed.

namespace selvedge {
namespace {

using detail::Differences;
using detail::MovingDifferences;

/// Metres: the cloth thickness of the paper.
constexpr double kPaperThickness = 1e-3;

/// The largest displacement of a vertex of one primitive relative to one of the other.
double largest_approach(ContactKind kind, const Differences& rate) {
  const Vec3 x = rate.x, y = rate.y, z = rate.z;
  if (kind == ContactKind::edge_edge)
    return std::max({z.norm(), Vec3(z + y).norm(), Vec3(z - x).norm(), Vec3(z + y - x).norm()});
  return std::max({z.norm(), Vec3(z - x).norm(), Vec3(z - y).norm()});
}

class ProximityRule {
 public:
  explicit ProximityRule(double reach) : reach_(reach) {}

  double time(const Query& query) const {
    int exponent = 0;
    const MovingDifferences d = detail::differences_in_range(query, exponent);
    const double reach = std::ldexp(reach_, -exponent);
    if (detail::nearer(query.kind, d.start, reach)) return 0.0;
    if (!detail::nearer(query.kind, d.at(1.0), reach)) return kNoCollision;
    const double away = detail::closest_points(query.kind, d.start.vertices(query.kind)).distance;
    const double t = (away - reach) / largest_approach(query.kind, d.rate);
    return t < 1.0 ? std::max(t, 0.0) : 1.0;
  }

  NarrowPhaseTraits traits() const {
    return {.gives_time = false,
            .source =
                "R. Bridson, R. Fedkiw, J. Anderson, Robust treatment of collisions, contact and "
                "friction for cloth animation, 2002; its proximity test at both ends of the step",
            .limits =
                "Tests only the two ends of the step: misses primitives that pass through each "
                "other in between, and reports primitives that are within the tolerance without "
                "touching."};
  }

 private:
  double reach_;
};

}  // namespace

std::unique_ptr<NarrowPhase> make_proximity(const NarrowPhaseConfig& config) {
  constexpr const char* kName = "proximity";
  detail::require_min_separation(config, kName);
  const double own = config.min_separation > 0.0 ? config.min_separation : kPaperThickness;
  const double tolerance = detail::tolerance_or(config, own, kName);
  return detail::per_query(ProximityRule(std::max(tolerance, config.min_separation)));
}

void register_proximity(NarrowPhaseRegistry& registry) {
  registry.add(
      "proximity",
      {{.name = "tolerance",
        .initial = NarrowPhaseConfig{}.tolerance,
        .unit = "m",
        .least = -1.0,
        .most = 1e6,
        .meaning = "distance at the start or the end of the step that counts as a "
                   "collision; negative: min_separation, or 1e-3 without it"},
       detail::min_separation_option()},
      [](const MethodOptions& o) {
        return make_proximity({.tolerance = o["tolerance"], .min_separation = o["min_separation"]});
      });
}

}  // namespace selvedge
