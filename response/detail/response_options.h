// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

namespace selvedge::detail {

/// The option `restitution` of the responses that have it.
inline MethodOption restitution_option() {
  return {.name = "restitution",
          .initial = 0.0,
          .unit = "1",
          .least = 0.0,
          .most = 1.0,
          .meaning = "normal speed after an impact over that before it"};
}

/// The option `retention` of the responses that have it. Its effect depends on the step length and
/// is not Coulomb friction.
inline MethodOption retention_option() {
  return {.name = "retention",
          .initial = 0.9,
          .unit = "1",
          .least = 0.0,
          .most = 1.0,
          .meaning =
              "share of the tangential velocity that a contact keeps in a step; 1: no "
              "friction"};
}

}  // namespace selvedge::detail
