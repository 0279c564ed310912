// SPDX-License-Identifier: MIT
#include <selvedge/compare/stability.h>

#include <stdexcept>

int main() {
  try {
    selvedge::settle_scenes({.folder = "nowhere"}, {});
  } catch (const std::invalid_argument&) {  // no scenes
    return 0;
  }
  return 1;
}
