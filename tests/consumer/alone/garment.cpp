// SPDX-License-Identifier: MIT
#include <selvedge/garment/panel_mesh.h>

#include <array>

int main() {
  const std::array<selvedge::Vec2, 3> loop = {selvedge::Vec2(0, 0), {0.01, 0}, {0, 0.01}};
  return selvedge::mesh_polygon(loop).triangles.empty() ? 1 : 0;
}
