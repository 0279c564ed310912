// SPDX-License-Identifier: MIT
#include <selvedge/compare/detectors/conformance.h>

int main() {
  const auto report =
      selvedge::check_conformance([] { return selvedge::make_bvh_aabb(); }, {.scenes = 2});
  return report.passed() ? 0 : 1;
}
