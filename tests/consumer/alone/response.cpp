// SPDX-License-Identifier: MIT
#include <selvedge/response/response.h>

int main() { return selvedge::responses().at("impulse")() != nullptr ? 0 : 1; }
