// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/adapter_embree.h>

int main() {
  selvedge::BroadPhaseRegistry methods;
  selvedge::register_embree(methods);
  return methods.empty() ? 1 : 0;
}
