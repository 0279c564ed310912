// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <cstdlib>

/// Cheap invariant, on unless NDEBUG. Says file, line and condition, then aborts.
/// SELVEDGE_VALIDATE is the same for expensive ones, on with the CMake option SELVEDGE_VALIDATION.
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
