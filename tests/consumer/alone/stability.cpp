// SPDX-License-Identifier: MIT
#include <selvedge/compare/stability.h>

int main() { return selvedge::extreme_case_names().empty() ? 1 : 0; }
