// SPDX-License-Identifier: MIT
#include <selvedge/dress/dress.h>

int main() {
  selvedge::SewingPattern pattern;
  pattern.panels.emplace_back();
  pattern = selvedge::turned_upright(pattern, selvedge::UpAxis::y);
  return pattern.panels.size() == 1 ? 0 : 1;
}
