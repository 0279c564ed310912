// SPDX-License-Identifier: MIT
#include "garments.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace selvedge::bench {
namespace {

constexpr double kPi = std::numbers::pi;

/// Rows of points over the unit square: row j lies at s = j / (rows - 1), its points at t = 0 to 1.
struct RowMesh {
  std::vector<std::vector<double>> rows;  // t of each point
  std::vector<std::int32_t> first;        // number of the first point of each row
  std::vector<Triangle> triangles;

  double s(std::size_t row) const {
    return static_cast<double>(row) / static_cast<double>(rows.size() - 1);
  }
};

/// Every second row begins and ends with half a cell, so that triangles become equilateral.
std::vector<double> row_points(int cells, bool shifted) {
  std::vector<double> t = {0.0};
  const double shift = shifted ? 0.5 : 1.0;
  for (int k = 0; k + shift < cells; ++k) t.push_back((k + shift) / cells);
  t.push_back(1.0);
  return t;
}

/// Triangles between two rows: the next one is on the side whose next edge has the nearer middle.
void stitch(const RowMesh& mesh, std::size_t row, std::vector<Triangle>& out) {
  const std::vector<double>&low = mesh.rows[row], &high = mesh.rows[row + 1];
  std::size_t i = 0, j = 0;
  const auto a = [&](std::size_t k) { return mesh.first[row] + static_cast<std::int32_t>(k); };
  const auto b = [&](std::size_t k) { return mesh.first[row + 1] + static_cast<std::int32_t>(k); };
  while (i + 1 < low.size() || j + 1 < high.size()) {
    const bool advance_low = j + 1 == high.size() ||
                             (i + 1 < low.size() && low[i] + low[i + 1] <= high[j] + high[j + 1]);
    if (advance_low) {
      out.push_back({a(i), a(i + 1), b(j)});
      ++i;
    } else {
      out.push_back({a(i), b(j + 1), b(j)});
      ++j;
    }
  }
}

RowMesh make_rows(int rows, const std::function<double(double s)>& cells_at) {
  RowMesh mesh;
  std::int32_t points = 0;
  for (int j = 0; j < rows; ++j) {
    const int cells = static_cast<int>(std::lround(cells_at(static_cast<double>(j) / (rows - 1))));
    mesh.rows.push_back(row_points(std::max(cells, 3), j % 2 == 1));
    mesh.first.push_back(points);
    points += static_cast<std::int32_t>(mesh.rows.back().size());
  }
  for (std::size_t j = 0; j + 1 < mesh.rows.size(); ++j) stitch(mesh, j, mesh.triangles);
  return mesh;
}

using Place = std::function<Vec3(double t, double s)>;

TriangleMesh open_mesh(const RowMesh& mesh, const Place& place) {
  TriangleMesh out{{}, mesh.triangles};
  for (std::size_t j = 0; j < mesh.rows.size(); ++j)
    for (const double t : mesh.rows[j]) out.vertices.push_back(place(t, mesh.s(j)));
  return out;
}

/// The last point of every row is the first one.
TriangleMesh closed_mesh(const RowMesh& mesh, const Place& place) {
  TriangleMesh out;
  std::vector<std::int32_t> number;
  for (std::size_t j = 0; j < mesh.rows.size(); ++j) {
    const auto first = static_cast<std::int32_t>(out.vertices.size());
    for (std::size_t k = 0; k + 1 < mesh.rows[j].size(); ++k) {
      number.push_back(static_cast<std::int32_t>(out.vertices.size()));
      out.vertices.push_back(place(mesh.rows[j][k], mesh.s(j)));
    }
    number.push_back(first);
  }
  for (const Triangle& t : mesh.triangles)
    out.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  return out;
}

/// Edge of the equilateral triangles that cover `area` with this many particles.
double edge_length(double area, double particles) {
  return std::sqrt(2.0 * area / (std::sqrt(3.0) * particles));
}

int rows_of(double length, double edge) {
  return 1 + static_cast<int>(std::lround(length / (edge * std::sqrt(3.0) / 2.0)));
}

double ring_area(double inner, double outer) { return kPi * (outer * outer - inner * inner); }

Garment make_poncho(int side) {
  constexpr double inner = 0.13, outer = 0.58, height = 1.47;  // m, 3 cm above the shoulders
  constexpr double behind = -0.01;                             // m, y of the neck
  const double edge = edge_length(ring_area(inner, outer), double(side) * side);
  const auto radius = [&](double s) { return inner + (outer - inner) * s; };
  const RowMesh rows = make_rows(rows_of(outer - inner, edge),
                                 [&](double s) { return 2.0 * kPi * radius(s) / edge; });
  return {.pieces = {{"poncho",
                      closed_mesh(rows,
                                  [&](double t, double s) {
                                    const double angle = 2.0 * kPi * t;
                                    return Vec3(radius(s) * std::cos(angle),
                                                behind - radius(s) * std::sin(angle), height);
                                  }),
                      {}}}};
}

Garment make_skirt(int side) {
  constexpr double inner = 0.32, outer = 0.87;  // m, radii of the flat half ring
  constexpr double height = 1.05;               // m, of the waist
  constexpr double sine = 0.5;                  // of half the opening angle of the cone
  const double edge = edge_length(0.5 * ring_area(inner, outer), double(side) * side);
  const auto radius = [&](double s) { return inner + (outer - inner) * s; };
  const RowMesh rows =
      make_rows(rows_of(outer - inner, edge), [&](double s) { return kPi * radius(s) / edge; });
  const auto flat = [&](double t, double s) {
    return Vec3(radius(s) * std::cos(kPi * t), -radius(s) * std::sin(kPi * t), 0.0);
  };
  const auto cone = [&](double t, double s) {
    const double angle = 2.0 * kPi * t, r = sine * radius(s);
    return Vec3(r * std::cos(angle), -r * std::sin(angle),
                height - (radius(s) - inner) * std::sqrt(1.0 - sine * sine));
  };
  Garment skirt{.pieces = {{"skirt", closed_mesh(rows, cone), open_mesh(rows, flat)}}};
  for (std::size_t k = 0; k + 1 < rows.rows[0].size(); ++k)
    skirt.held.push_back(static_cast<std::int32_t>(k));
  return skirt;
}

/// Outline of a panel of the torso, m: half of its width by height, and its top with the neckline.
struct Panel {
  static constexpr double hem = 0.92, shoulder = 1.62, neckline = 0.08, slope = 0.03;
  static constexpr double half_hem = 0.26, half_chest = 0.23, half_shoulder = 0.20;
  static constexpr double armhole = 0.45;  // s where it begins
  static constexpr double neck = 0.5;      // half of the neckline by half of the shoulders

  static double half_width(double s) {
    return s < armhole
               ? half_hem + (half_chest - half_hem) * s / armhole
               : half_chest + (half_shoulder - half_chest) * (s - armhole) / (1.0 - armhole);
  }
  static double top(double across) {  // -1 to 1
    const double out = std::abs(across) / neck;
    return out >= 1.0 ? shoulder - slope * (std::abs(across) - neck) / (1.0 - neck)
                      : shoulder - 0.5 * neckline * (1.0 + std::cos(kPi * out));
  }
};

Garment make_torso(int side) {
  constexpr double front = -0.14, back = 0.155;  // m, y of the panels
  constexpr double tension = 10.0;               // N per metre of seam
  const double area = 2.0 * (Panel::half_hem + Panel::half_chest) * (Panel::shoulder - Panel::hem);
  const double edge = edge_length(area, double(side) * side);
  const RowMesh rows = make_rows(rows_of(Panel::shoulder - Panel::hem, edge),
                                 [&](double s) { return 2.0 * Panel::half_width(s) / edge; });
  // Both panels show their outer side; t runs from right to left on the back.
  const auto panel = [&](double y, double right) {
    return open_mesh(rows, [=](double t, double s) {
      const double across = right * (2.0 * t - 1.0);
      return Vec3(across * Panel::half_width(s), y,
                  Panel::hem + s * (Panel::top(across) - Panel::hem));
    });
  };
  Garment torso{.pieces = {{"front", panel(front, 1.0), {}}, {"back", panel(back, -1.0), {}}},
                .pull = tension * edge,
                .arms_level = true};
  std::vector<std::int32_t> first, last;  // of the rows below the armholes
  for (std::size_t j = 0; j < rows.rows.size() && rows.s(j) <= Panel::armhole; ++j) {
    first.push_back(rows.first[j]);
    last.push_back(rows.first[j] + static_cast<std::int32_t>(rows.rows[j].size()) - 1);
  }
  std::vector<std::int32_t> left, right;  // of the top row, outside of the neckline
  for (std::size_t k = 0; k < rows.rows.back().size(); ++k) {
    const double across = 2.0 * rows.rows.back()[k] - 1.0;
    const std::int32_t v = rows.first.back() + static_cast<std::int32_t>(k);
    if (across <= -Panel::neck) left.push_back(v);
    if (across >= Panel::neck) right.push_back(v);
  }
  std::reverse(right.begin(), right.end());  // both from the arm to the neck
  for (const auto& [a, b] : {std::pair(first, last), {last, first}, {left, right}, {right, left}})
    torso.seams.push_back({"front", "back", a, b});
  return torso;
}

}  // namespace

const std::vector<std::string>& garment_names() {
  static const std::vector<std::string> names = {"poncho", "skirt", "torso"};
  return names;
}

Garment make_garment(const std::string& name, int side) {
  if (side < 8) {
    throw std::invalid_argument("a garment of " + std::to_string(side) +
                                " particles per side is too coarse; take at least 8");
  }
  if (name == "poncho") return make_poncho(side);
  if (name == "skirt") return make_skirt(side);
  if (name == "torso") return make_torso(side);
  throw std::invalid_argument("there is no garment " + name + "; take poncho, skirt or torso");
}

}  // namespace selvedge::bench
