// SPDX-License-Identifier: MIT
#include <selvedge/compare/extreme_cases.h>

int main() { return selvedge::extreme_cases().empty() ? 1 : 0; }
