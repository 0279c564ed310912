// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/image_space/image_space.h>

int main() {
  selvedge::BroadPhaseRegistry methods;
  selvedge::register_image_space(methods);
  return methods.empty() ? 1 : 0;
}
