// SPDX-License-Identifier: MIT
#include <selvedge/pictures/result_view.h>

#include <stdexcept>

int main() {
  try {
    selvedge::view_page({});
  } catch (const std::invalid_argument&) {
    return 0;  // a page shows one or two results
  }
  return 1;
}
