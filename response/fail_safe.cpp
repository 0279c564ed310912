// SPDX-License-Identifier: MIT
#include <selvedge/response/fail_safe.h>

namespace selvedge {

FailSafeRegistry fail_safes() {
  return {{"impulse_zones", [] { return make_impulse_zones(); }},
          {"projection_zones", [] { return make_projection_zones(); }},
          {"displacement_bound", [] { return make_displacement_bound(); }},
          {"separating_planes", [] { return make_separating_planes(); }},
          {"layered", [] { return make_layered(); }}};
}

}  // namespace selvedge
