// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/fail_safe.h>

#include <string>

namespace selvedge::detail {

/// An option that counts rounds of a fail-safe.
inline MethodOption rounds_option(const std::string& name, int initial,
                                  const std::string& meaning) {
  return {.name = name,
          .initial = static_cast<double>(initial),
          .unit = "1",
          .least = 0.0,
          .most = 1000.0,
          .kind = OptionKind::whole,
          .meaning = meaning};
}

/// The option `plane_rounds` of the fail-safes that have it.
inline MethodOption plane_rounds_option() {
  return rounds_option(
      "plane_rounds", FailSafeRounds{}.plane_rounds,
      "rounds that add planes only for pairs that collide; the next one adds planes "
      "for all pairs");
}

}  // namespace selvedge::detail
