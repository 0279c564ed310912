// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/query_file.h>

#include <stdexcept>

int main() {
  try {
    selvedge::read_queries("no_such_file.csv");
    return 1;
  } catch (const std::invalid_argument&) {
    return 0;
  }
}
