// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace selvedge::narrowphase_detail {

/// The tolerance the config asks for, or the method's own; one that is not finite is refused.
inline double tolerance_or(const NarrowPhaseConfig& config, double own, const char* method) {
  if (!std::isfinite(config.tolerance))
    throw std::invalid_argument(std::string(method) + ": the tolerance is not a finite number");
  return config.tolerance < 0.0 ? own : config.tolerance;
}

/// Refuses a minimum separation that is no length.
inline void require_min_separation(const NarrowPhaseConfig& config, const char* method) {
  if (config.min_separation >= 0.0 && std::isfinite(config.min_separation)) return;
  throw std::invalid_argument(std::string(method) + ": the minimum separation is " +
                              std::to_string(config.min_separation) +
                              " m, but must be finite and not negative");
}

/// For methods that only know contact: refuses a minimum separation.
inline void refuse_min_separation(const NarrowPhaseConfig& config, const char* method) {
  if (config.min_separation == 0.0) return;
  throw std::invalid_argument(std::string(method) + ": cannot keep a minimum separation (" +
                              std::to_string(config.min_separation) +
                              " m asked); use ccd_exact, or 0");
}

}  // namespace selvedge::narrowphase_detail
