// SPDX-License-Identifier: MIT
#include <selvedge/response/response.h>

int main() { return selvedge::make_impulse() != nullptr ? 0 : 1; }
