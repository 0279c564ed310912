// SPDX-License-Identifier: MIT
#include <selvedge/dress/dress_result.h>

int main() { return selvedge::dress_result_text("tube", {}, "body").empty() ? 1 : 0; }
