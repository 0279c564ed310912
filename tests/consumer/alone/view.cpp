// SPDX-License-Identifier: MIT
#include <selvedge/view/result_view.h>

int main() { return selvedge::view_page({}).empty() ? 1 : 0; }
