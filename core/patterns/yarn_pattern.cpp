// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/patterns/detail/yarn_pattern.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace selvedge {
namespace {

constexpr double kKgPerMetreOfTex = 1e-6;

double round_section(double diameter) { return 0.25 * std::numbers::pi * diameter * diameter; }

}  // namespace

double YarnConfig::diameter() const {
  return std::sqrt(4.0 * tex * kKgPerMetreOfTex / (std::numbers::pi * density));
}

double YarnConfig::stretch() const { return modulus * round_section(diameter()); }

double YarnConfig::bending() const {
  const double d = diameter();
  return bending_share * modulus * round_section(d) * d * d / 16.0;
}

namespace detail {

void validate_yarn(const std::string& which, const YarnConfig& yarn) {
  const auto positive = [&](const char* name, double value) {
    require(std::isfinite(value) && value > 0.0, which + " " + name, value, "positive and finite");
  };
  positive("tex", yarn.tex);
  positive("density", yarn.density);
  positive("modulus", yarn.modulus);
  require(yarn.bending_share > 0.0 && yarn.bending_share <= 1.0, which + " bending_share",
          yarn.bending_share, "above 0 and at most 1");
}

void validate_meeting(double contact, double rotation, std::int32_t links) {
  require(std::isfinite(contact) && contact > 0.0, "contact", contact, "positive and finite");
  require(std::isfinite(rotation) && rotation >= 0.0, "rotation", rotation,
          "at least 0 and finite");
  require(links >= 2 && links % 2 == 0, "links", links, "even and at least 2");
}

void refuse_laws_of_a_sheet(const std::string& pattern, const Material& m) {
  const Material plain;
  if (m.stretch_law == plain.stretch_law && m.shear_law == plain.shear_law &&
      m.bending_law == plain.bending_law && m.bending_friction == 0.0 && m.shear_friction == 0.0 &&
      m.bending_curve.empty())
    return;
  throw std::invalid_argument(
      "cloth: " + pattern +
      " takes its constants from its yarns; leave out the laws of stretch, shear and bending and "
      "the friction within cloth, or take pattern \"rectangular\"");
}

Vec3 place_on(const GridConfig& grid, double i, double j) {
  return {grid.size_x * (i / grid.cells_x - 0.5), grid.size_y * (j / grid.cells_y - 0.5), 0.0};
}

ClothMesh surface_of_yarns(const GridConfig& grid) {
  ClothMesh cloth;
  for (std::int32_t j = 0; j <= grid.cells_y; ++j)
    for (std::int32_t i = 0; i <= grid.cells_x; ++i)
      cloth.surface.vertices.push_back(place_on(grid, i, j));
  const std::int32_t up = grid.cells_x + 1;
  for (std::int32_t j = 0; j < grid.cells_y; ++j)
    for (std::int32_t i = 0; i < grid.cells_x; ++i) {
      const std::int32_t a = j * up + i, b = a + up;
      cloth.surface.triangles.push_back({a, a + 1, b + 1});
      cloth.surface.triangles.push_back({a, b + 1, b});
    }
  cloth.edges = unique_edges(cloth.surface.triangles);
  cloth.mass.assign(cloth.surface.vertices.size(), 0.0);
  return cloth;
}

void add_yarn_springs(ClothMesh& cloth, std::int32_t first, std::int32_t count,
                      const YarnConfig& yarn, const Material& material) {
  const std::vector<Vec3>& x = cloth.surface.vertices;
  for (std::int32_t k = first; k + 1 < first + count; ++k) {
    const double length = (x[k + 1] - x[k]).norm();
    cloth.springs.push_back({k, k + 1, length, yarn.stretch() / length, material.spring_damping});
    cloth.strain_limit.push_back(material.strain_limit);
    for (const std::int32_t end : {k, k + 1})
      cloth.mass[end] += 0.5 * yarn.tex * kKgPerMetreOfTex * length;
  }
}

void add_yarn_bend(ClothMesh& cloth, std::int32_t k, double angle, const YarnConfig& yarn,
                   const Material& material) {
  const std::vector<Vec3>& x = cloth.surface.vertices;
  const double around = (x[k] - x[k - 1]).norm() + (x[k + 1] - x[k]).norm();
  cloth.twists.push_back(
      {{k - 1, k, k + 1}, angle, 2.0 * yarn.bending() / around, material.bending_damping});
}

void add_yarn_angle(ClothMesh& cloth, const std::array<std::int32_t, 4>& v, double stiffness,
                    const Material& material) {
  if (stiffness <= 0.0) return;
  const std::vector<Vec3>& x = cloth.surface.vertices;
  const Vec3 u = (x[v[1]] - x[v[0]]).normalized(), w = (x[v[3]] - x[v[2]]).normalized();
  const double angle = elementary::atan2(u.dot(w), u.cross(w).norm());
  cloth.crossings.push_back({v, angle, stiffness, material.bending_damping});
}

void add_yarn_crossing(ClothMesh& cloth, std::int32_t a, std::int32_t b,
                       const CrossingStiffness& stiffness, const Material& material) {
  const std::vector<Vec3>& x = cloth.surface.vertices;
  const double gap = (x[a] - x[b]).norm(), slide = stiffness.sliding * gap * gap;
  cloth.springs.push_back({a, b, gap, stiffness.contact, material.spring_damping});
  cloth.strain_limit.push_back(std::numeric_limits<double>::max());
  add_yarn_angle(cloth, {a - 1, a + 1, b - 1, b + 1}, stiffness.rotation, material);
  add_yarn_angle(cloth, {a - 1, a + 1, a, b}, slide, material);
  add_yarn_angle(cloth, {b - 1, b + 1, b, a}, slide, material);
}

void add_yarn_tie(ClothMesh& cloth, std::int32_t middle, std::int32_t a, std::int32_t b,
                  double share_of_a, double stiffness, const Material& material) {
  cloth.yarn_ties.push_back(
      {{middle, a, b}, {share_of_a, 1.0 - share_of_a}, stiffness, material.spring_damping});
}

std::vector<MethodOption> yarn_options(const YarnConfig& initial) {
  return {positive_option("modulus", initial.modulus, "Pa", 1e13, "Young's modulus of a yarn"),
          positive_option("bending_share", initial.bending_share, "1", 1.0,
                          "bending rigidity of a yarn relative to a solid rod; fibres that slide "
                          "lower it")};
}

YarnConfig yarn_of(const MethodOptions& options, const char* tex) {
  return {.tex = options[tex],
          .density = YarnConfig{}.density,
          .modulus = options["modulus"],
          .bending_share = options["bending_share"]};
}

MethodOption rotation_option(double initial) {
  return {.name = "rotation",
          .initial = initial,
          .unit = "N·m/rad",
          .least = 0.0,
          .most = 1e3,
          .meaning = "moment that turns one yarn on another; resists shear"};
}

MethodOption whole_option(const char* name, double initial, double least, const char* meaning) {
  return {.name = name,
          .initial = initial,
          .unit = "1",
          .least = least,
          .most = 100.0,
          .kind = OptionKind::whole,
          .meaning = meaning};
}

MethodOption positive_option(const char* name, double initial, const char* unit, double most,
                             const char* meaning) {
  return {.name = name,
          .initial = initial,
          .unit = unit,
          .least = 0.0,
          .most = most,
          .above_least = true,
          .meaning = meaning};
}

}  // namespace detail
}  // namespace selvedge
