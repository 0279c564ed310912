// SPDX-License-Identifier: MIT
#include <selvedge/response/fail_safe.h>

namespace selvedge {

FailSafeRegistry fail_safes() {
  return {{"impulse_zones", [] { return make_impulse_zones(); }},
          {"projection_zones", [] { return make_projection_zones(); }}};
}

}  // namespace selvedge
