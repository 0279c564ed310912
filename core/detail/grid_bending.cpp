// SPDX-License-Identifier: MIT
//
// Bending of a grid by lines of three particles p-t, p, p+t along the four directions t: rows,
// columns and both diagonals. If the cloth is bent to curvature κ along n, a line along t has the
// curvature κ (n·t̂)². With the fractions A and C of the rigidity for rows and columns and D for
// each diagonal, the energy per area is
//   ½ κ² [A c⁴ + C s⁴ + D (2 a⁴c⁴ + 12 a²b² c²s² + 2 b⁴s⁴)/l⁴],  n = (c,s),  l² = a² + b²,
// which equals that of the plate, ½ κ² (√B c² + √B' s²)² [Peirce1930], for
//   D = √(BB') l⁴/(6 a²b²),  A = B - √(BB') a²/(3 b²),  C = B' - √(BB') b²/(3 a²).
#include <selvedge/core/detail/grid_bending.h>
#include <selvedge/core/detail/grid_mesh.h>
#include <selvedge/core/detail/topology.h>
#include <selvedge/core/elementary.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace selvedge::detail {
namespace {

/// Three particles in a line: the spacing of neighbours, and the line's part of the plate rigidity
/// times the area that the line represents.
struct Line {
  std::int32_t before, centre, after;
  double spacing;        // m
  double rigidity_area;  // N·m·m²
};

/// Parts of the plate rigidity for rows, columns and each diagonal, N·m.
struct LineShares {
  double row, column, diagonal;
};

LineShares line_shares(const CellConstants& c, const Material& m) {
  const double warp = m.bending_stiffness, weft = bending_along_weft(m);
  const double a2 = c.a * c.a, b2 = c.b * c.b, l2 = a2 + b2, between = std::sqrt(warp * weft);
  const LineShares shares{warp - between * a2 / (3.0 * b2), weft - between * b2 / (3.0 * a2),
                          between * l2 * l2 / (6.0 * a2 * b2)};
  if (shares.row > 0.0 && shares.column > 0.0) return shares;
  std::ostringstream text;
  text << "bending_law: buckling links and twisting springs need cells whose sides differ by less "
          "than "
          "1.73 to 1 if warp and weft bend alike, not "
       << c.a << " m by " << c.b << " m of " << warp << " and " << weft
       << " N*m; change cells_x or cells_y, or use \"hinge\"";
  throw std::invalid_argument(text.str());
}

void for_each_line(const GridConfig& grid, const Material& material,
                   const std::function<void(const Line&)>& add) {
  const CellConstants c = cell_sides(grid);
  const LineShares share = line_shares(c, material);
  const double area = c.a * c.b, diagonal = elementary::hypot(c.a, c.b);
  const std::int32_t nx = grid.cells_x, ny = grid.cells_y, up = nx + 1;
  for (std::int32_t j = 0; j <= ny; ++j)
    for (std::int32_t i = 0; i <= nx; ++i) {
      const std::int32_t p = j * up + i;
      const bool inner_x = i > 0 && i<nx, inner_y = j> 0 && j < ny;
      // A line on the border represents half a cell.
      if (inner_x) add({p - 1, p, p + 1, c.a, share.row * area * (inner_y ? 1.0 : 0.5)});
      if (inner_y) add({p - up, p, p + up, c.b, share.column * area * (inner_x ? 1.0 : 0.5)});
      if (!inner_x || !inner_y) continue;
      add({p - up - 1, p, p + up + 1, diagonal, share.diagonal * area});
      add({p + up - 1, p, p - up + 1, diagonal, share.diagonal * area});
    }
}

// A link over two cells bends to an arc of length 2d and stores ½ k κ² 2d: k = (share·area)/(2d).
// Before it buckles it is as stiff as a strip of cloth of its width.
void add_links(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  for_each_line(grid, m, [&](const Line& line) {
    const double length = 2.0 * line.spacing;
    const double rigidity = line.rigidity_area / length;
    const double width = line.rigidity_area / (m.bending_stiffness * line.spacing);
    const double onset =
        std::max(least_onset(rigidity, length), m.stretch_stiffness * width / length);
    cloth.links.push_back({line.before, line.after, length, rigidity, onset, m.bending_damping});
  });
}

// A torsional spring at a particle rotates by κ d and stores ½ k κ² d²: k = (share·area)/d².
void add_bend_twists(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  for_each_line(grid, m, [&](const Line& line) {
    cloth.twists.push_back({{line.before, line.centre, line.after},
                            0.0,
                            line.rigidity_area / (line.spacing * line.spacing),
                            m.bending_damping});
  });
}

void refuse_bending_friction(const Material& m) {
  if (m.bending_friction > 0.0)
    throw std::invalid_argument(
        "bending_friction needs hinges; use bending_law \"hinge\", \"shape_operator\" or "
        "\"bridson\"");
}

// If the cloth is bent to curvature κ along n = (c,s), rows have the curvature κ c² and columns κ
// s². Frictions HB along both do the work HB κ (c² + s²) = HB κ in every direction, so twist needs
// none. A hinge of rows a × b with span d (θ = κ d) represents half a cell: moment HB a b/(2 d).
void add_bending_friction(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  if (m.bending_friction <= 0.0) return;
  const CellConstants c = cell_sides(grid);
  for (const Hinge& hinge : cloth.hinges) {
    const std::int32_t along = std::abs(hinge.v[3] - hinge.v[2]);
    if (along != 1 && along != grid.cells_x + 1) continue;  // a diagonal
    const double span = along == 1 ? c.b : c.a;
    cloth.hinge_frictions.push_back({hinge.v, hinge.rest_angle,
                                     m.bending_friction * c.a * c.b / (2.0 * span),
                                     kYieldCurvature * span});
  }
}

// A hinge along a row or column represents the area k d²/B, of its stiffness k.
void add_bending_curve(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  if (m.bending_curve.empty()) return;
  if (grid.cells_x == 1) throw std::invalid_argument("bending_curve needs at least 2 cells_x");
  const CellConstants c = cell_sides(grid);
  const std::array<std::int32_t, 2> shapes = add_bending_shapes(cloth, m);
  const std::array<double, 2> rigidity{m.bending_stiffness, bending_along_weft(m)};
  for (std::size_t h = 0; h < cloth.hinges.size(); ++h) {
    const Hinge& hinge = cloth.hinges[h];
    const std::int32_t along = std::abs(hinge.v[3] - hinge.v[2]);
    if (along != 1 && along != grid.cells_x + 1) continue;  // a diagonal
    const int direction = along == 1 ? 1 : 0;
    const double span = along == 1 ? c.b : c.a;
    if (rigidity[direction] <= 0.0) continue;
    Vec3 curvature = Vec3::Zero();
    curvature[direction] = 1.0 / span;
    cloth.curvature_curves.push_back({{{static_cast<std::int32_t>(h), curvature}},
                                      hinge.stiffness * span * span / rigidity[direction],
                                      rigidity,
                                      shapes});
  }
}

// A link over two cells of a row stands for a strip of one cell, on the border of half a cell.
// Before it bends it is as stiff as that strip, and at least strong enough to bear it folded.
void add_chords(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  const CellConstants c = cell_sides(grid);
  const std::array<double, 2> rigidity{m.bending_stiffness, bending_along_weft(m)};
  const std::array<double, 2> stretch{m.stretch_stiffness, stretch_along_weft(m)};
  std::array<std::int32_t, 2> shapes{-1, -1};
  if (!m.bending_curve.empty()) shapes = add_bending_shapes(cloth, m);
  const auto add = [&](std::int32_t at, std::int32_t step, int direction, bool inner) {
    const double d = direction == 0 ? c.a : c.b;
    const double w = (direction == 0 ? c.b : c.a) * (inner ? 1.0 : 0.5);
    if (rigidity[direction] <= 0.0) return;
    double folded = rigidity[direction] * std::numbers::pi / d;  // N, M at θ = π
    if (shapes[direction] >= 0) {
      const MonotoneCurve& curve = cloth.curves[shapes[direction]].measured;
      folded = rigidity[direction] / curve.slope_at_rest() * curve.value(std::numbers::pi / d);
    }
    constexpr double steeper = 2.0;
    const double onset =
        std::max(steeper * folded * w / (2.0 * d * d), stretch[direction] * w / (2.0 * d));
    cloth.chords.push_back({at - step, at + step, d, w, rigidity[direction], onset,
                            m.bending_damping, shapes[direction]});
  };
  const std::int32_t nx = grid.cells_x, ny = grid.cells_y, up = nx + 1;
  for (std::int32_t j = 0; j <= ny; ++j)
    for (std::int32_t i = 0; i <= nx; ++i) {
      const bool inner_x = i > 0 && i<nx, inner_y = j> 0 && j < ny;
      if (inner_x) add(j * up + i, 1, 0, inner_y);
      if (inner_y) add(j * up + i, up, 1, inner_x);
    }
}

}  // namespace

double least_onset(double rigidity, double length) {
  // The onset must be steeper than any later slope, with a safety factor; see
  // make_buckling_force.
  constexpr double kSteeper = 2.0 * 4.0 * std::numbers::pi * std::numbers::pi;
  return kSteeper * rigidity / (length * length * length);
}

void add_grid_bending(ClothMesh& cloth, const GridConfig& grid, const Material& material) {
  if (material.bending_stiffness <= 0.0) return;
  if (material.bending_friction > 0.0 && grid.cells_x == 1)
    throw std::invalid_argument("bending_friction needs at least 2 cells_x");
  switch (material.bending_law) {
    case BendingLaw::shape_operator:
    case BendingLaw::hinge:
    case BendingLaw::bridson:
      add_grid_hinges(cloth, grid, material);
      add_bending_curve(cloth, grid, material);
      return add_bending_friction(cloth, grid, material);
    case BendingLaw::beam:
      refuse_bending_friction(material);
      return add_grid_hinges(cloth, grid, material);
    case BendingLaw::buckling:
      refuse_bending_friction(material);
      return add_links(cloth, grid, material);
    case BendingLaw::chord:
      refuse_bending_friction(material);
      return add_chords(cloth, grid, material);
    case BendingLaw::twisting:
      refuse_bending_friction(material);
      return add_bend_twists(cloth, grid, material);
  }
}

void add_grid_twist(ClothMesh& cloth, const GridConfig& grid, const Material& material) {
  if (material.shear_stiffness <= 0.0) return;
  const CellConstants c = cell_sides(grid);
  // Under a shear γ each of the four corners of a cell rotates by γ: 4 · ½ k γ² = ½ G γ² a b.
  const double stiffness = 0.25 * material.shear_stiffness * c.a * c.b;
  const std::int32_t up = grid.cells_x + 1;
  const auto add = [&](std::int32_t x_end, std::int32_t corner, std::int32_t y_end) {
    cloth.twists.push_back(
        {{x_end, corner, y_end}, 0.5 * std::numbers::pi, stiffness, material.spring_damping});
  };
  for (std::int32_t j = 0; j < grid.cells_y; ++j)
    for (std::int32_t i = 0; i < grid.cells_x; ++i) {
      const std::int32_t v00 = j * up + i, v10 = v00 + 1, v01 = v00 + up, v11 = v01 + 1;
      add(v10, v00, v01);
      add(v00, v10, v11);
      add(v11, v01, v00);
      add(v01, v11, v10);
    }
  if (material.shear_friction <= 0.0) return;
  // As above, 4 M γ = HG γ a b.
  const double moment = 0.25 * material.shear_friction * c.a * c.b;
  for (const TwistSpring& twist : cloth.twists)
    if (twist.rest_angle > 0.0)
      cloth.corner_frictions.push_back({twist.v, twist.rest_angle, moment, kYieldShear});
}

}  // namespace selvedge::detail
