// SPDX-License-Identifier: MIT
#include <selvedge.h>

int main() { return selvedge_interface_version() == 1 ? 0 : 1; }
