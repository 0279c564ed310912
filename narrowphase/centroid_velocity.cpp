// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/moving_differences.h>
#include <selvedge/narrowphase/detail/per_query.h>

// [ZhongXu2009] Y. Zhong, B. Xu, "Three-dimensional garment dressing simulation", 2009, as
// described in [survey] section 6.1.2. The edge P moves with the velocity V_G of its centroid and
// sweeps a plane. The edge Q pierces that plane in Q_3, and from there the ray along -V_G meets P
// in P_3. The edges collide if Q_3 and P_3 are nearer than the tolerance zeta.
//
// Deviations: V_G is the velocity of P's centroid relative to that of Q; the survey uses the
// absolute velocity, which depends on the frame of reference. zeta is the distance that V_G covers
// in the step unless `tolerance` (metres) is given. The time is the distance over the speed, at
// most 1.
//
// Approximate: exact except for rounding while both edges keep their direction and length. Edges
// that turn are missed, or reported at places that they have left. Edges at rest relative to each
// other and edges parallel to the swept plane are missed. Point-triangle pairs are not supported.

namespace selvedge {
namespace {

using detail::MovingDifferences;

class CentroidVelocityRule {
 public:
  /// A negative reach means the distance moved in one step.
  explicit CentroidVelocityRule(double reach) : reach_(reach) {}

  double time(const Query& query) const {
    if (query.kind != ContactKind::edge_edge) return kNoCollision;
    int exponent = 0;
    const MovingDifferences d = detail::differences_in_range(query, exponent);
    const auto& [x, y, z] = d.start;
    const Vec3 g = 0.5 * (d.rate.x - d.rate.y) - d.rate.z;
    // s x + t g - r y = z by Cramer's rule: s x is P_3, z + r y is Q_3.
    const Vec3 swept = x.cross(g);
    const double det = swept.dot(y);
    if (det == 0.0) return kNoCollision;
    const double s = z.dot(g.cross(y)) / det, r = -swept.dot(z) / det;
    const double t = -z.dot(x.cross(y)) / det;
    if (!(s >= 0.0 && s <= 1.0 && r >= 0.0 && r <= 1.0 && t >= 0.0)) return kNoCollision;
    const bool near = reach_ < 0.0 ? t <= 1.0 : t * g.norm() <= std::ldexp(reach_, -exponent);
    return near ? std::min(t, 1.0) : kNoCollision;
  }

  NarrowPhaseTraits traits() const {
    return {.source = "Y. Zhong, B. Xu, Three-dimensional garment dressing simulation, 2009",
            .limits =
                "Handles only edge pairs and assumes that edges do not rotate: misses and false "
                "alarms where they rotate, stretch, or lie in the plane of the motion."};
  }

 private:
  double reach_;
};

}  // namespace

std::unique_ptr<NarrowPhase> make_centroid_velocity(const NarrowPhaseConfig& config) {
  constexpr const char* kName = "centroid_velocity";
  detail::refuse_min_separation(config, kName);
  return detail::per_query(CentroidVelocityRule(detail::tolerance_or(config, -1.0, kName)));
}

void register_centroid_velocity(NarrowPhaseRegistry& registry) {
  registry.add(
      "centroid_velocity",
      {{.name = "tolerance",
        .initial = -1.0,
        .unit = "m",
        .least = -1.0,
        .most = 1e6,
        .meaning = "how far along the motion an edge is searched; negative: the distance moved in "
                   "the step"}},
      [](const MethodOptions& o) { return make_centroid_velocity({.tolerance = o["tolerance"]}); });
}

}  // namespace selvedge
