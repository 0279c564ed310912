// SPDX-License-Identifier: MIT
#include <selvedge/compare/compare_table.h>

int main() { return selvedge::quartiles({1.0, 2.0, 3.0}).median == 2.0 ? 0 : 1; }
