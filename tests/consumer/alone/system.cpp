// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/processes.h>

int main() {
  const selvedge::ChildResult result = selvedge::run_program({"echo", "a"}, {.output_limit = 100});
  return result.output == "a\n" ? 0 : 1;
}
