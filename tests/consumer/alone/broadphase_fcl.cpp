// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/adapters.h>

int main() {
  selvedge::BroadPhaseRegistry methods;
  selvedge::register_fcl(methods);
  return methods.empty() ? 1 : 0;
}
