// SPDX-License-Identifier: MIT
// The tests of J. Pan, S. Chitta, D. Manocha, "FCL: A general purpose library for collision and
// proximity queries", 2012 [Pan2012]; the cubic is that of [Provot1997].
#include <selvedge/narrowphase/adapters.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/per_query.h>
#include <selvedge/narrowphase/detail/unit_size.h>

#include <fcl/narrowphase/detail/traversal/collision/intersect.h>

#include <algorithm>

namespace selvedge {
namespace {

using Intersect = fcl::detail::Intersect<double>;

struct FclRule {
  double time(const Query& query) const {
    const auto [x, y, motion] = detail::to_unit_size(query);
    double toi = kNoCollision;
    Vec3 place;
    // Without Newton's method the library misses a fifth of the collisions.
    const bool hit = query.kind == ContactKind::edge_edge
                         ? Intersect::intersect_EE(x[0], x[1], x[2], x[3], y[0], y[1], y[2], y[3],
                                                   &toi, &place, true)
                         : Intersect::intersect_VF(x[1], x[2], x[3], x[0], y[1], y[2], y[3], y[0],
                                                   &toi, &place, true);
    // The comparison is written so that a NaN time counts as the start of the step.
    return !hit ? kNoCollision : toi > 0.0 ? std::min(toi, 1.0) : 0.0;
  }

  NarrowPhaseTraits traits() const {
    return {.source =
                "vertex-face and edge-edge tests of FCL; J. Pan, S. Chitta, D. Manocha, FCL: A "
                "general purpose library for collision and proximity queries, 2012",
            .limits =
                "misses coplanar motion, parallel edges and degenerate primitives, and may be "
                "wrong by its absolute tolerances on primitives scaled to size one"};
  }
};

}  // namespace

void register_fcl(NarrowPhaseRegistry& registry) {
  registry.add("fcl_vertex_face_edge_edge", {},
               [](const MethodOptions&) { return detail::per_query(FclRule{}); });
}

}  // namespace selvedge
