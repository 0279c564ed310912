// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/adapters.h>

int main() {
  selvedge::NarrowPhaseRegistry methods;
  selvedge::register_libccd(methods);
  return methods.empty() ? 1 : 0;
}
