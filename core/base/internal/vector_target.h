// SPDX-License-Identifier: MIT
#pragma once

/// Kernels in vectors for processors that a build does not require. A source compiles its kernel,
/// an .inc file, once for each set of instructions, each time in a namespace of its own:
///
///   #ifdef SELVEDGE_VECTOR_TARGETS
///   SELVEDGE_TARGET_BEGIN("avx2,fma")
///   namespace avx2 {
///   ...
///   }
///   SELVEDGE_TARGET_END
///   #endif
///
/// It calls what it compiled only where __builtin_cpu_supports has found these instructions. The
/// pragmas affect the functions between them alone. A compiler flag would also affect the standard
/// library's inline functions, of which the linker keeps one copy for the whole program; for the
/// same reason a kernel calls no function that is compiled elsewhere.
#if defined(__x86_64__) && defined(__GNUC__)

#define SELVEDGE_VECTOR_TARGETS
#define SELVEDGE_PRAGMA(text) _Pragma(#text)

#ifdef __clang__
#define SELVEDGE_TARGET_BEGIN(instructions) \
  SELVEDGE_PRAGMA(clang attribute push(__attribute__((target(instructions))), apply_to = function))
#define SELVEDGE_TARGET_END SELVEDGE_PRAGMA(clang attribute pop)
#else
#define SELVEDGE_TARGET_BEGIN(instructions) \
  SELVEDGE_PRAGMA(GCC push_options)         \
  SELVEDGE_PRAGMA(GCC target(instructions))
#define SELVEDGE_TARGET_END SELVEDGE_PRAGMA(GCC pop_options)
#endif

#endif
