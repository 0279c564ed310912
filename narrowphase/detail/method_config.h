// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace selvedge::detail {

/// The tolerance of the config, or the method's default. Throws std::invalid_argument if it is not
/// finite.
inline double tolerance_or(const NarrowPhaseConfig& config, double own, const char* method) {
  if (!std::isfinite(config.tolerance))
    throw std::invalid_argument(std::string(method) + ": the tolerance is not a finite number");
  return config.tolerance < 0.0 ? own : config.tolerance;
}

/// Throws std::invalid_argument unless the minimum separation is finite and not negative.
inline void require_min_separation(const NarrowPhaseConfig& config, const char* method) {
  if (config.min_separation >= 0.0 && std::isfinite(config.min_separation)) return;
  throw std::invalid_argument(std::string(method) + ": the minimum separation is " +
                              std::to_string(config.min_separation) +
                              " m, but must be finite and not negative");
}

/// For methods without a minimum separation: throws std::invalid_argument if the config asks for
/// one.
inline void refuse_min_separation(const NarrowPhaseConfig& config, const char* method) {
  if (config.min_separation == 0.0) return;
  throw std::invalid_argument(std::string(method) + ": does not support a minimum separation (" +
                              std::to_string(config.min_separation) +
                              " m given); use ccd_exact, or 0");
}

/// The option `tolerance` of a method, with its default, its unit and its meaning.
inline MethodOption tolerance_option(double initial, const char* unit, const char* meaning) {
  return {.name = "tolerance",
          .initial = initial,
          .unit = unit,
          .least = 0.0,
          .most = 1e6,
          .meaning = meaning};
}

/// The option `min_separation` of the methods that have it.
inline MethodOption min_separation_option() {
  return {.name = "min_separation",
          .initial = 0.0,
          .unit = "m",
          .least = 0.0,
          .most = 1e6,
          .meaning = "primitives that are at most this far apart count as colliding"};
}

}  // namespace selvedge::detail
