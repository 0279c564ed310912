// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <sstream>
#include <stdexcept>

namespace selvedge::detail {

/// Throws std::invalid_argument unless 0 <= particle < particles.
inline void require_particle(const char* what, std::size_t element, std::int32_t particle,
                             std::size_t particles) {
  if (particle >= 0 && static_cast<std::size_t>(particle) < particles) return;
  std::ostringstream text;
  text << what << " " << element << " names particle " << particle << ", but there are "
       << particles;
  throw std::invalid_argument(text.str());
}

/// Throws std::invalid_argument unless there is a law number `curve`, with the points of a test if
/// it must be `measured`.
inline void require_curve(const char* what, std::size_t element, std::int32_t curve,
                          const auto& curves, bool measured = true) {
  const bool there = curve >= 0 && static_cast<std::size_t>(curve) < curves.size();
  if (there && !(measured && curves[curve].measured.empty())) return;
  std::ostringstream text;
  text << what << " " << element << " names curve " << curve
       << (there ? ", which has no points" : ", which the cloth does not have");
  throw std::invalid_argument(text.str());
}

/// Throws std::invalid_argument unless `value` is finite and at least 0 (or above 0).
inline void require_number(const char* what, double value, bool zero_allowed = true) {
  if (std::isfinite(value) && (value > 0.0 || (zero_allowed && value == 0.0))) return;
  std::ostringstream text;
  text << what << " must be finite and " << (zero_allowed ? "at least 0" : "positive") << ", not "
       << value;
  throw std::invalid_argument(text.str());
}

/// As require_number, for the `quantity` of element number `element`; the message gives its index.
inline void require_number_of(const char* quantity, const char* what, std::size_t element,
                              double value, bool zero_allowed = true) {
  if (std::isfinite(value) && (value > 0.0 || (zero_allowed && value == 0.0))) return;
  std::ostringstream name;
  name << quantity << " of " << what << " " << element;
  require_number(name.str().c_str(), value, zero_allowed);
}

/// Throws std::invalid_argument if a memory of `there` numbers is shorter than `needed`.
inline void require_memory(const char* what, std::size_t there, std::size_t needed) {
  if (there >= needed) return;
  std::ostringstream text;
  text << "the memory of " << what << " has " << there << " numbers left, but needs " << needed
       << "; it belongs to another cloth";
  throw std::invalid_argument(text.str());
}

}  // namespace selvedge::detail
