// SPDX-License-Identifier: MIT
#include <selvedge/dress/dress.h>

int main() {
  const selvedge::SewingPattern turned =
      selvedge::turned_upright({.panels = {{}}}, selvedge::UpAxis::y);
  return turned.panels.size() == 1 && selvedge::DressResult{.clean = true}.fault() != "" ? 0 : 1;
}
