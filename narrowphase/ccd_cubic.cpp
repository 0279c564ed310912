// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/cubic_solver.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/moving_differences.h>
#include <selvedge/narrowphase/detail/per_query.h>

// Continuous collision of straight vertex paths after X. Provot, "Collision and self-collision
// handling in cloth model dedicated to design garments", 1997 (the survey prints it for points and
// triangles, eq. 40 and 41, after [ChenZhuKaufman1998]): colliding vertices must be coplanar,
// which gives a cubic in t; at each of its roots in [0, 1], in ascending order, the method tests
// whether the primitives meet. Uses plain doubles without error bounds or tolerances: the naive
// solver, as the baseline.
//
// Misses: touching contacts that rounding turns into near misses (at the ends of the step, at
// double roots, at the boundary of a primitive); primitives that meet inside the step while all
// vertices stay coplanar (only t = 0 and t = 1 are tested); parallel edges; triangles without area
// and edges without length. False alarms: near misses within rounding, and more of them near
// degenerate primitives.

namespace selvedge {
namespace {

using detail::MovingDifferences;

/// If the sum of the coefficients' moduli lies between these bounds, their squares (in the
/// discriminant) neither over- nor underflow. The same holds for the products of four differences
/// in the inside test, unless the differences vary in size by more than 2^100.
constexpr double kLeastSum = 0x1p-400, kLargestSum = 0x1p400;

class CubicRule {
 public:
  double time(const Query& query) const {
    const MovingDifferences d(query);
    const std::array<double, 4> c = detail::coplanarity_coefficients(d);
    const double sum = std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]) + std::abs(c[3]);
    if (sum > kLeastSum && sum < kLargestSum) return first_time(query.kind, d, c);
    int exponent = 0;
    const MovingDifferences near_1 = detail::differences_in_range(query, exponent);
    return first_time(query.kind, near_1, detail::coplanarity_coefficients(near_1));
  }

  NarrowPhaseTraits traits() const {
    return {.source =
                "X. Provot, Collision and self-collision handling in cloth model dedicated to "
                "design garments, 1997; in plain doubles without tolerances",
            .limits =
                "Misses touching contacts and near-degenerate cases within rounding, and contacts "
                "that begin inside the step while all vertices stay in one plane."};
  }

 private:
  static double first_time(ContactKind kind, const MovingDifferences& d,
                           const std::array<double, 4>& c) {
    CubicRootEstimates roots;
    detail::estimate_roots(c, 0.0, roots);
    for (int i = 0; i < roots.count; ++i)
      if (detail::meet(kind, d.at(roots.t[i]), 0.0)) return roots.t[i];
    return kNoCollision;
  }
};

}  // namespace

std::unique_ptr<NarrowPhase> make_ccd_cubic(const NarrowPhaseConfig& config) {
  detail::refuse_min_separation(config, "ccd_cubic");
  return detail::per_query(CubicRule());
}

void register_ccd_cubic(NarrowPhaseRegistry& registry) {
  registry.add("ccd_cubic", {}, [](const MethodOptions&) { return make_ccd_cubic(); });
}

}  // namespace selvedge
