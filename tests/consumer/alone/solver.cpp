// SPDX-License-Identifier: MIT
#include <selvedge/core/solver/integrator.h>

int main() { return selvedge::integrators().empty() ? 1 : 0; }
