// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/cubic_solver.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/moving_differences.h>
#include <selvedge/narrowphase/detail/per_query.h>

// [Bridson2002] R. Bridson, R. Fedkiw, J. Anderson, "Robust treatment of collisions, contact and
// friction for cloth animation", 2002: the primitives collide if they are nearer than a tolerance
// at a root of the coplanarity cubic, in ascending order, or at the end of the step.
//
// Deviations: the distance is that of the closest points, which is exact also for degenerate
// triangles and parallel edges; the paper clamps barycentric coordinates. Ends of the step and
// stationary points at which the cubic is zero within rounding count as roots.
//
// Misses: contacts that begin and end inside the step while all vertices stay coplanar, and roots
// that rounding moves by more than the tolerance. False alarms: primitives that are apart by up to
// the tolerance at a root or at the end of the step.

namespace selvedge {
namespace {

using detail::Differences;
using detail::MovingDifferences;

/// Metres: the 10 nm of the paper.
constexpr double kOwnTolerance = 1e-8;

class BridsonRule {
 public:
  explicit BridsonRule(double tolerance) : tolerance_(tolerance) {}

  double time(const Query& query) const {
    int exponent = 0;
    const MovingDifferences d = detail::differences_in_range(query, exponent);
    const double reach = exponent == 0 ? tolerance_ : std::ldexp(tolerance_, -exponent);
    CubicRootEstimates roots;
    detail::estimate_roots(detail::coplanarity_coefficients(d), detail::coplanarity_error(d),
                           roots);
    for (int i = 0; i < roots.count; ++i)
      if (detail::nearer(query.kind, d.at(roots.t[i]), reach)) return roots.t[i];
    return detail::nearer(query.kind, d.at(1.0), reach) ? 1.0 : kNoCollision;
  }

  NarrowPhaseTraits traits() const {
    return {.source =
                "R. Bridson, R. Fedkiw, J. Anderson, Robust treatment of collisions, contact and "
                "friction for cloth animation, 2002",
            .limits =
                "Misses contacts that begin and end inside the step while all vertices stay in one "
                "plane, and reports primitives that come within the tolerance."};
  }

 private:
  double tolerance_;
};

}  // namespace

std::unique_ptr<NarrowPhase> make_ccd_cubic_bridson(const NarrowPhaseConfig& config) {
  constexpr const char* kName = "ccd_cubic_bridson";
  detail::refuse_min_separation(config, kName);
  return detail::per_query(BridsonRule(detail::tolerance_or(config, kOwnTolerance, kName)));
}

void register_ccd_cubic_bridson(NarrowPhaseRegistry& registry) {
  registry.add(
      "ccd_cubic_bridson",
      {detail::tolerance_option(
          kOwnTolerance, "m",
          "distance at a root or at the end of the step that counts as a collision; larger: fewer "
          "misses, more false alarms")},
      [](const MethodOptions& o) { return make_ccd_cubic_bridson({.tolerance = o["tolerance"]}); });
}

}  // namespace selvedge
