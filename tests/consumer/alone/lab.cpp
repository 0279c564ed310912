// SPDX-License-Identifier: MIT
#include <selvedge/lab/fabric_drape.h>

int main() {
  return selvedge::make_woven_disc(0.1, 8, {.density = 0.15}).surface.triangles.empty() ? 1 : 0;
}
