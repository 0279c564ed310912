// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/moving_differences.h>
#include <selvedge/narrowphase/detail/per_query.h>

// [ChenZhuKaufman1998] Y. Chen, Q. Zhu, A. Kaufman, "Physically based animation", 1998, as
// described in [survey] eq. (39): a particle has crossed a plane when E(P) = a P_x + b P_y + c P_z
// + d has changed its sign between two time steps.
//
// Corrected: the crossing lies in [t_{i-1}, t_i] (printed the other way round), E = 0 counts, and a
// particle that comes from below crosses too. Completed: E is the distance to the triangle's plane,
// each at its own end of the step. The time is where E, interpolated linearly, is zero, t = E_0 /
// (E_0 - E_1); at that time the foot of the particle must lie in the triangle.
//
// Exact except for rounding while the triangle does not turn or change its shape. Otherwise
// approximate: E is a cubic over the length of the normal; two crossings leave the sign unchanged
// and are missed, and the triangle is tested at the wrong time. Does not handle edge pairs.

namespace selvedge {
namespace {

using detail::Differences;
using detail::MovingDifferences;

/// E(P), or NaN for a triangle without area.
double distance_to_plane(const Differences& d) {
  const Vec3 n = d.x.cross(d.y);
  return n.dot(d.z) / n.norm();
}

class PlaneCrossingRule {
 public:
  explicit PlaneCrossingRule(double tolerance) : tolerance_(tolerance) {}

  double time(const Query& query) const {
    if (query.kind == ContactKind::edge_edge) return kNoCollision;
    int exponent = 0;
    const MovingDifferences d = detail::differences_in_range(query, exponent);
    const double e0 = distance_to_plane(d.start), e1 = distance_to_plane(d.at(1.0));
    const bool changes = (e0 <= 0.0 && e1 >= 0.0) || (e0 >= 0.0 && e1 <= 0.0);
    if (!changes) return kNoCollision;
    const double t = e0 == 0.0 ? 0.0 : e0 / (e0 - e1);
    if (detail::meet(query.kind, d.at(t), tolerance_)) return t;
    // The particle is in the plane at both ends: it may have slid into the triangle.
    const bool slid = e0 == 0.0 && e1 == 0.0;
    return slid && detail::meet(query.kind, d.at(1.0), tolerance_) ? 1.0 : kNoCollision;
  }

  NarrowPhaseTraits traits() const {
    return {
        .source = "Y. Chen, Q. Zhu, A. Kaufman, Physically based animation, 1998",
        .limits =
            "Handles no edge pairs, misses an even number of crossings, and is inaccurate where "
            "the triangle rotates or changes its shape during the step."};
  }

 private:
  double tolerance_;
};

}  // namespace

std::unique_ptr<NarrowPhase> make_plane_crossing(const NarrowPhaseConfig& config) {
  constexpr const char* kName = "plane_crossing";
  detail::refuse_min_separation(config, kName);
  return detail::per_query(PlaneCrossingRule(detail::tolerance_or(config, 0.0, kName)));
}

void register_plane_crossing(NarrowPhaseRegistry& registry) {
  registry.add(
      "plane_crossing",
      {detail::tolerance_option(
          0.0, "1",
          "tolerance on the barycentric coordinates of the inside test; larger: fewer "
          "misses, more false alarms")},
      [](const MethodOptions& o) { return make_plane_crossing({.tolerance = o["tolerance"]}); });
}

}  // namespace selvedge
