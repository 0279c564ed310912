// SPDX-License-Identifier: MIT
#include <selvedge/core/detail/rings.h>
#include <selvedge/core/detail/topology.h>
#include <selvedge/core/fabric_drape.h>
#include <selvedge/core/force.h>
#include <selvedge/core/integrator.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

/// Numbers of the vertices that are kept, -1 for the others.
struct Kept {
  std::vector<std::int32_t> number;
  std::int32_t count = 0;

  bool has(std::int32_t v) const { return number[v] >= 0; }
};

Kept used_vertices(std::size_t n, const std::vector<Triangle>& triangles) {
  Kept kept{std::vector<std::int32_t>(n, -1), 0};
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) kept.number[v] = 0;
  for (std::int32_t& number : kept.number)
    if (number == 0) number = kept.count++;
  return kept;
}

std::map<Edge, int> triangles_of_edges(const std::vector<Triangle>& triangles) {
  std::map<Edge, int> count;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      ++count[{std::min(a, b), std::max(a, b)}];
    }
  return count;
}

/// The part of `grid` that has `inside` triangles. Springs along a new border stand for the half
/// that is left of them; a diagonal that is no edge of a triangle stays where its cell is whole.
ClothMesh cut(const ClothMesh& grid, const std::vector<Triangle>& inside) {
  const Kept kept = used_vertices(grid.surface.vertices.size(), inside);
  const auto before = triangles_of_edges(grid.surface.triangles), now = triangles_of_edges(inside);
  ClothMesh disc;
  for (std::size_t v = 0; v < kept.number.size(); ++v)
    if (kept.number[v] >= 0) disc.surface.vertices.push_back(grid.surface.vertices[v]);
  for (Triangle t : inside) {
    for (std::int32_t& v : t) v = kept.number[v];
    disc.surface.triangles.push_back(t);
  }
  disc.edges = unique_edges(disc.surface.triangles);
  for (std::size_t s = 0; s < grid.springs.size(); ++s) {
    Spring spring = grid.springs[s];
    if (!kept.has(spring.a) || !kept.has(spring.b)) continue;
    const Edge edge{std::min(spring.a, spring.b), std::max(spring.a, spring.b)};
    if (const auto was = before.find(edge); was != before.end()) {
      const auto is = now.find(edge);
      if (is == now.end()) continue;
      spring.stiffness *= double(is->second) / was->second;
    }
    spring.a = kept.number[spring.a];
    spring.b = kept.number[spring.b];
    disc.springs.push_back(spring);
    disc.strain_limit.push_back(grid.strain_limit[s]);
    if (!grid.curve_of_spring.empty()) disc.curve_of_spring.push_back(grid.curve_of_spring[s]);
  }
  disc.curves = grid.curves;
  const auto add = [&](auto& to, const auto& from) {
    for (auto element : from) {
      if (!std::all_of(element.v.begin(), element.v.end(),
                       [&](std::int32_t v) { return kept.has(v); }))
        continue;
      for (std::int32_t& v : element.v) v = kept.number[v];
      to.push_back(element);
    }
  };
  add(disc.hinges, grid.hinges);
  add(disc.twists, grid.twists);
  add(disc.hinge_frictions, grid.hinge_frictions);
  add(disc.corner_frictions, grid.corner_frictions);
  return disc;
}

void push_rim_out(ClothMesh& disc, double radius, const Material& material) {
  for (const auto& [edge, count] : triangles_of_edges(disc.surface.triangles)) {
    if (count != 1) continue;
    for (const std::int32_t v : edge)
      disc.surface.vertices[v] *= radius / disc.surface.vertices[v].norm();
  }
  const auto& x = disc.surface.vertices;
  for (Spring& s : disc.springs) s.rest_length = (x[s.b] - x[s.a]).norm();
  disc.mass = vertex_areas(x, disc.surface.triangles);
  for (double& m : disc.mass) m *= material.density;
}

}  // namespace

ClothMesh make_woven_disc(double radius, std::int32_t cells, const Material& material) {
  constexpr std::int32_t fewest = 8;
  detail::require(cells >= fewest, "cells across the disc", cells, "at least 8");
  const ClothMesh grid = make_rectangular({2.0 * radius, 2.0 * radius, cells, cells}, material);
  // A cell belongs to the disc whole or not at all, so that its diagonals do too.
  const double size = 2.0 * radius / cells;
  std::vector<Triangle> inside;
  for (const Triangle& t : grid.surface.triangles) {
    const Vec3 middle =
        (grid.surface.vertices[t[0]] + grid.surface.vertices[t[1]] + grid.surface.vertices[t[2]]) /
        3.0;
    const Vec3 corner(std::floor((middle.x() + radius) / size),
                      std::floor((middle.y() + radius) / size), 0.0);
    const Vec3 centre = size * (corner + Vec3(0.5, 0.5, 0.0)) - Vec3(radius, radius, 0.0);
    if (centre.norm() < radius) inside.push_back(t);
  }
  ClothMesh disc = cut(grid, inside);
  push_rim_out(disc, radius, material);
  return disc;
}

namespace {

void validate(const DrapeTrial& t) {
  const auto positive = [](const char* name, double value) {
    detail::require(std::isfinite(value) && value > 0.0, name, value, "positive and finite");
  };
  positive("support radius in m", t.support);
  detail::require(std::isfinite(t.specimen) && t.specimen > t.support, "specimen radius in m",
                  t.specimen, "larger than the support");
  detail::require(t.cells >= 4, "cells", t.cells, "at least 4");
  positive("step in s", t.step);
  positive("rest_speed in m/s", t.rest_speed);
  detail::require(std::isfinite(t.damping) && t.damping >= 0.0, "damping in s", t.damping,
                  "at least 0");
  detail::require(std::isfinite(t.noise) && t.noise >= 0.0, "noise in m", t.noise, "at least 0");
  detail::require(t.most_steps >= 1, "most_steps", t.most_steps, "at least 1");
}

/// Distance of two rings, or sides of the cells of a woven disc, m.
double cell_size(const DrapeTrial& t) {
  if (!t.polar) return 2.0 * t.specimen / t.cells;
  const double overhang = t.specimen - t.support;
  const double free_rings = std::max(1.0, std::round(t.cells * overhang / t.specimen));
  return overhang / (free_rings - 0.5);
}

/// Rings from the rim inwards such that the support ends in the middle between two that are held:
/// from there on the cloth bends, as a hinge stands for half of the cells on both sides.
std::vector<double> ring_radii(const DrapeTrial& t) {
  const double h = cell_size(t);
  std::vector<double> radii;
  for (double r = t.specimen; r > 0.5 * h; r -= h) radii.push_back(r);
  std::reverse(radii.begin(), radii.end());
  return radii;
}

ClothMesh make_specimen(Material material, const DrapeTrial& trial) {
  material.spring_damping = std::max(material.spring_damping, trial.damping);
  material.bending_damping = std::max(material.bending_damping, trial.damping);
  if (!trial.polar) return make_woven_disc(trial.specimen, trial.cells, material);
  constexpr double cells_per_turn = 2.0 * std::numbers::pi * 0.8;  // square at four fifths of it
  const auto spokes = static_cast<std::int32_t>(std::lround(cells_per_turn * trial.cells));
  return detail::make_rings(ring_radii(trial), spokes, material);
}

Particles start(const ClothMesh& cloth, const DrapeTrial& trial) {
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  std::mt19937 generator(trial.seed);
  std::uniform_real_distribution<double> height(-trial.noise, trial.noise);
  constexpr double rounding = 1e-9;
  const double held_radius = (trial.support + 0.5 * cell_size(trial)) * (1.0 + rounding);
  for (std::size_t i = 0; i < n; ++i) {
    const double z = height(generator);
    const bool held = p.x[i].norm() <= held_radius;
    p.inv_mass.push_back(held ? 0.0 : 1.0 / p.mass[i]);
    if (!held) p.x[i].z() = z;
  }
  return p;
}

std::vector<std::unique_ptr<Force>> trial_forces(const ClothMesh& cloth) {
  auto forces = make_internal_forces(cloth);
  forces.push_back(make_gravity({0.0, 0.0, -9.81}));
  AirConfig air;
  air.viscous_drag = 0.5;  // N·s/m³: to rest within a second or two, without a say where
  std::vector<double> areas;
  const auto& x = cloth.surface.vertices;
  for (const Triangle& t : cloth.surface.triangles)
    areas.push_back(0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm());
  forces.push_back(make_air_force(air, cloth.surface.triangles, areas, cloth.mass.size()));
  return forces;
}

double largest_speed(const std::vector<Vec3>& v) {
  double largest = 0.0;
  for (const Vec3& u : v) largest = std::max(largest, u.squaredNorm());
  return std::sqrt(largest);
}

}  // namespace

DrapeOutcome drape(const Material& material, const DrapeTrial& trial) {
  validate(trial);
  const ClothMesh cloth = make_specimen(material, trial);
  Particles p = start(cloth, trial);
  constexpr ImplicitConfig solver{1e-4, 2000};
  const auto integrator = make_implicit_euler(trial_forces(cloth), p.size(), {.solve = solver});
  DrapeOutcome outcome;
  constexpr std::int32_t warm_up = 20;  // it starts at rest, too
  std::vector<Vec3> v;
  while (outcome.steps < trial.most_steps && !outcome.settled) {
    const double time = outcome.steps * trial.step;
    integrator->begin({p, time, trial.step}, {});
    v = p.v;
    integrator->solve({}, {v, {}}, 1.0);
    p.v = v;
    for (std::size_t i = 0; i < v.size(); ++i) p.x[i] += trial.step * v[i];
    integrator->accept({p.x, p.v, p.mass, time + trial.step});
    outcome.settled = ++outcome.steps > warm_up && largest_speed(p.v) < trial.rest_speed;
  }
  const auto& triangles = cloth.surface.triangles;
  outcome.coefficient = drape_coefficient(projected_area(p.x, triangles),
                                          surface_area(cloth.surface.vertices, triangles),
                                          std::numbers::pi * trial.support * trial.support);
  outcome.rim = rim_profile(p.x, triangles, {});
  outcome.shape = {std::move(p.x), triangles};
  return outcome;
}

}  // namespace selvedge
