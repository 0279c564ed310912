// SPDX-License-Identifier: MIT
#include <selvedge/core/patterns/cloth_pattern.h>

// A pattern is a source that defines register_NAME(ClothPatternRegistry&), and a line here.
#define SELVEDGE_PATTERNS(PATTERN) \
  PATTERN(rectangular)             \
  PATTERN(triangular)              \
  PATTERN(simplified)              \
  PATTERN(responsive)              \
  PATTERN(arc)                     \
  PATTERN(bilayered)               \
  PATTERN(refined)                 \
  PATTERN(support)                 \
  PATTERN(nets)                    \
  PATTERN(mesh)                    \
  PATTERN(weave)                   \
  PATTERN(knit)

namespace selvedge {

#define SELVEDGE_DECLARE_PATTERN(name) void register_##name(ClothPatternRegistry& registry);
SELVEDGE_PATTERNS(SELVEDGE_DECLARE_PATTERN)
#undef SELVEDGE_DECLARE_PATTERN

ClothPatternRegistry cloth_patterns() {
  ClothPatternRegistry registry;
#define SELVEDGE_ADD_PATTERN(name) register_##name(registry);
  SELVEDGE_PATTERNS(SELVEDGE_ADD_PATTERN)
#undef SELVEDGE_ADD_PATTERN
  return registry;
}

}  // namespace selvedge
