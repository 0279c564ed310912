// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>

int main() {
  selvedge::CandidatePairs pairs;
  selvedge::make_bvh_aabb()->find_self_pairs({}, pairs);
  return pairs.size() == 0 ? 0 : 1;
}
