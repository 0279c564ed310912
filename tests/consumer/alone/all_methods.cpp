// SPDX-License-Identifier: MIT
#include <selvedge/scene/methods.h>

int main() { return selvedge::methods_of_this_build().broad_phases.empty() ? 1 : 0; }
