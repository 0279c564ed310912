// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>

namespace selvedge {

BroadPhaseRegistry broad_phases() {
  return {{"brute_force", [] { return make_brute_force(); }},
          {"bvh_aabb", [] { return make_bvh_aabb(); }}};
}

}  // namespace selvedge
