// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

namespace selvedge {

/// Throws std::invalid_argument "<name> must be <rule>, not <value>" unless `good`.
void require(bool good, const std::string& name, double value, const char* rule);

}  // namespace selvedge

/// Checks a cheap invariant unless NDEBUG is defined. On failure it prints file, line and condition
/// and aborts. SELVEDGE_VALIDATE does the same for expensive invariants; the CMake option
/// SELVEDGE_VALIDATION turns it on.
#define SELVEDGE_CHECK_OR_ABORT(condition)                                                 \
  ((condition) ? static_cast<void>(0)                                                      \
               : (std::fprintf(stderr, "%s:%d: selvedge invariant broken: %s\n", __FILE__, \
                               __LINE__, #condition),                                      \
                  std::abort()))

#ifdef NDEBUG
#define SELVEDGE_ASSERT(condition) static_cast<void>(0)
#else
#define SELVEDGE_ASSERT(condition) SELVEDGE_CHECK_OR_ABORT(condition)
#endif

#ifdef SELVEDGE_VALIDATION
#define SELVEDGE_VALIDATE(condition) SELVEDGE_CHECK_OR_ABORT(condition)
#else
#define SELVEDGE_VALIDATE(condition) static_cast<void>(0)
#endif
