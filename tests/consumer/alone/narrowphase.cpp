// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>

int main() {
  using selvedge::Vec3;
  const selvedge::Query query{selvedge::ContactKind::point_triangle,
                              {Vec3(0.2, 0.2, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                              {Vec3(0.2, 0.2, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  double toi = 0.0;
  return selvedge::make_ccd_exact()->collides(query, toi) && toi == 0.5 ? 0 : 1;
}
