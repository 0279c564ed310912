// SPDX-License-Identifier: MIT
#include <selvedge/core/patterns/make_cloth.h>

int main() {
  return selvedge::make_rectangular({0.1, 0.1, 2, 2}, {}).surface.vertices.empty() ? 1 : 0;
}
