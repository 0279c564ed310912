// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/cubic_solver.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/moving_differences.h>
#include <selvedge/narrowphase/detail/per_query.h>

// [Provot1997] X. Provot, "Collision and self-collision handling in cloth model dedicated to design
// garments", 1997, with the tolerance that implementations usually add to its inside test: at a
// root of the coplanarity cubic the primitives collide if the barycentric coordinates (edges: the
// parameters) lie in [-tolerance, 1 + tolerance].
//
// Deviations: ends of the step and stationary points at which the cubic is zero within rounding
// count as roots, so that touching contacts at t = 0, t = 1 and double roots are found. Erratum in
// the survey's form, eq. (41): its second line should read V_ij = V_j - V_i.
//
// Misses: contacts that begin inside the step while all vertices stay coplanar, parallel edges,
// triangles without area, edges without length. False alarms: primitives that are apart by up to
// the tolerance times their size.

namespace selvedge {
namespace {

using detail::MovingDifferences;

/// Dimensionless. One micrometre on a mesh of metre-sized triangles; above the rounding error of
/// the barycentric coordinates down to angles of 1e-5 in the triangle (between the edges).
constexpr double kBarycentricTolerance = 1e-6;

class ProvotRule {
 public:
  explicit ProvotRule(double tolerance) : tolerance_(tolerance) {}

  double time(const Query& query) const {
    int exponent = 0;
    const MovingDifferences d = detail::differences_in_range(query, exponent);
    CubicRootEstimates roots;
    detail::estimate_roots(detail::coplanarity_coefficients(d), detail::coplanarity_error(d),
                           roots);
    for (int i = 0; i < roots.count; ++i)
      if (detail::meet(query.kind, d.at(roots.t[i]), tolerance_)) return roots.t[i];
    return kNoCollision;
  }

  NarrowPhaseTraits traits() const {
    return {.source =
                "X. Provot, Collision and self-collision handling in cloth model dedicated to "
                "design garments, 1997; with a tolerance on the barycentric coordinates",
            .limits =
                "Misses contacts of parallel edges and degenerate triangles, and contacts that "
                "begin inside the step while all vertices stay in one plane."};
  }

 private:
  double tolerance_;
};

}  // namespace

std::unique_ptr<NarrowPhase> make_ccd_cubic_provot(const NarrowPhaseConfig& config) {
  constexpr const char* kName = "ccd_cubic_provot";
  detail::refuse_min_separation(config, kName);
  return detail::per_query(ProvotRule(detail::tolerance_or(config, kBarycentricTolerance, kName)));
}

void register_ccd_cubic_provot(NarrowPhaseRegistry& registry) {
  registry.add(
      "ccd_cubic_provot",
      {detail::tolerance_option(
          kBarycentricTolerance, "1",
          "tolerance on the barycentric coordinates of the inside test; larger: fewer misses, more "
          "false alarms")},
      [](const MethodOptions& o) { return make_ccd_cubic_provot({.tolerance = o["tolerance"]}); });
}

}  // namespace selvedge
