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
#include <string>
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
  detail::require(std::isfinite(t.grading) && t.grading >= 1.0, "grading", t.grading, "at least 1");
  positive("step in s", t.step);
  positive("rest_speed in m/s", t.rest_speed);
  detail::require(std::isfinite(t.damping) && t.damping >= 0.0, "damping in s", t.damping,
                  "at least 0");
  detail::require(std::isfinite(t.noise) && t.noise >= 0.0, "noise in m", t.noise, "at least 0");
  detail::require(t.most_steps >= 1, "most_steps", t.most_steps, "at least 1");
}

/// Rings and spokes of a polar specimen. The rings beyond the support lie apart by a geometric
/// series. The support ends in the middle between two rings that are held: from there on the cloth
/// bends, as a hinge stands for half of the cells on both sides. Farther in, where nothing moves,
/// the rings are as few as a mesh needs.
struct PolarMesh {
  std::vector<double> radii;  ///< m, ascending
  std::int32_t spokes;
  std::size_t held;  ///< rings
};

PolarMesh polar_mesh(const DrapeTrial& t) {
  constexpr std::int32_t cells_per_turn = 5;  // 2π · 0.8
  // With so many rings the widest are about as wide as equal ones would be.
  constexpr double more_rings = 1.5, inwards = 1.6;
  const double overhang = t.specimen - t.support, growth = std::log(t.grading);
  const double rings = std::max(3.0, std::round(more_rings * t.cells * overhang / t.specimen));
  const auto radius = [&](double share) {
    const double way = growth > 0.0 ? std::expm1(growth * share) / std::expm1(growth) : share;
    return t.support + overhang * way;
  };
  const double first = radius(1.0 / (rings - 0.5)) - t.support;
  PolarMesh mesh{{}, cells_per_turn * t.cells, 0};
  for (double h = first, r = t.support - 0.5 * first; r > 0.5 * h; h *= inwards, r -= h)
    mesh.radii.push_back(r);
  std::reverse(mesh.radii.begin(), mesh.radii.end());
  mesh.radii.push_back(t.support + 0.5 * first);
  mesh.held = mesh.radii.size();
  for (double j = 1.5; j < rings; ++j) mesh.radii.push_back(radius(j / (rings - 0.5)));
  mesh.radii.back() = t.specimen;
  return mesh;
}

ClothMesh make_specimen(Material material, const DrapeTrial& trial) {
  material.spring_damping = std::max(material.spring_damping, trial.damping);
  material.bending_damping = std::max(material.bending_damping, trial.damping);
  if (!trial.polar) return make_woven_disc(trial.specimen, trial.cells, material);
  const PolarMesh mesh = polar_mesh(trial);
  return detail::make_rings(mesh.radii, mesh.spokes, material);
}

/// Largest radius at which particles are held, m.
double held_radius(const DrapeTrial& trial) {
  constexpr double rounding = 1e-9;
  if (!trial.polar) return trial.support + trial.specimen / trial.cells;
  const PolarMesh mesh = polar_mesh(trial);
  return mesh.radii[mesh.held - 1] * (1.0 + rounding);
}

/// Heights to start with: waves around the support that grow outwards, their phases and sizes by
/// the seed. They do not depend on the mesh.
class Waves {
 public:
  explicit Waves(const DrapeTrial& trial) : trial_(trial) {
    std::mt19937 generator(trial.seed);
    std::uniform_real_distribution<double> size(-1.0, 1.0);
    for (auto& wave : waves_)
      for (double& part : wave) part = size(generator);
  }

  double height(const Vec3& x) const {
    const double angle = std::atan2(x.y(), x.x());
    double sum = 0.0;
    for (int n = 0; n < count; ++n)
      sum += waves_[n][0] * std::cos((n + fewest) * angle) +
             waves_[n][1] * std::sin((n + fewest) * angle);
    const double outwards = (x.norm() - trial_.support) / (trial_.specimen - trial_.support);
    return trial_.noise * outwards * sum / std::sqrt(double(count));
  }

 private:
  static constexpr int fewest = 2, count = 23;  // folds; more than a cloth makes
  const DrapeTrial& trial_;
  std::array<std::array<double, 2>, count> waves_;
};

Particles at_rest(const ClothMesh& cloth, const DrapeTrial& trial) {
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  const double held = held_radius(trial);
  for (std::size_t i = 0; i < n; ++i)
    p.inv_mass.push_back(p.x[i].norm() <= held ? 0.0 : 1.0 / p.mass[i]);
  return p;
}

Particles start(const ClothMesh& cloth, const DrapeTrial& trial) {
  Particles p = at_rest(cloth, trial);
  const Waves waves(trial);
  for (std::size_t i = 0; i < p.size(); ++i)
    if (p.inv_mass[i] > 0.0) p.x[i].z() = waves.height(p.x[i]);
  return p;
}

/// Where the cloth of another polar drape is: linear along spokes, cubic around (Catmull-Rom),
/// where lines between particles would be inside of a fold.
class Draped {
 public:
  Draped(const DrapeTrial& trial, const DrapeOutcome& outcome)
      : mesh_(polar_mesh(trial)), x_(outcome.shape.vertices) {}

  /// The place of what lies at `rest` when flat, m, not within the innermost ring.
  Vec3 at(const Vec3& rest) const {
    const auto& radii = mesh_.radii;
    const double r = rest.norm();
    const auto above = std::upper_bound(radii.begin() + 1, radii.end() - 1, r);
    const auto ring = static_cast<std::int32_t>(above - radii.begin());
    const double share = std::min(1.0, (r - *(above - 1)) / (*above - *(above - 1)));
    const double turn = std::atan2(rest.y(), rest.x()) / (2.0 * std::numbers::pi);
    const double place = mesh_.spokes * (turn < 0.0 ? turn + 1.0 : turn);
    return (1.0 - share) * around(ring - 1, place) + share * around(ring, place);
  }

 private:
  Vec3 around(std::int32_t ring, double place) const {
    const auto k = static_cast<std::int32_t>(std::floor(place));
    const double w = place - k;
    const auto x = [&](std::int32_t spoke) {
      return x_[1 + ring * mesh_.spokes + (spoke + mesh_.spokes) % mesh_.spokes];
    };
    return 0.5 * (w * (w * (2.0 - w) - 1.0) * x(k - 1) + (w * w * (3.0 * w - 5.0) + 2.0) * x(k) +
                  w * (w * (4.0 - 3.0 * w) + 1.0) * x(k + 1) + w * w * (w - 1.0) * x(k + 2));
  }

  PolarMesh mesh_;
  const std::vector<Vec3>& x_;
};

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

namespace {

DrapeOutcome settle(const ClothMesh& cloth, Particles p, const DrapeTrial& trial) {
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

}  // namespace

DrapeOutcome drape(const Material& material, const DrapeTrial& trial) {
  validate(trial);
  const ClothMesh cloth = make_specimen(material, trial);
  return settle(cloth, start(cloth, trial), trial);
}

std::vector<DrapeOutcome> drape_refined(const Material& material, const DrapeTrial& trial,
                                        std::int32_t levels) {
  detail::require(levels >= 1, "levels", levels, "at least 1");
  detail::require(trial.polar, "polar", 0, "true: only polar meshes are refined");
  std::vector<DrapeOutcome> outcomes{drape(material, trial)};
  DrapeTrial coarse = trial, fine = trial;
  for (; static_cast<std::int32_t>(outcomes.size()) < levels; coarse = fine) {
    fine.cells *= 2;
    const ClothMesh cloth = make_specimen(material, fine);
    Particles p = at_rest(cloth, fine);
    const Draped before(coarse, outcomes.back());
    for (std::size_t i = 0; i < p.size(); ++i)
      if (p.inv_mass[i] > 0.0) p.x[i] = before.at(p.x[i]);
    outcomes.push_back(settle(cloth, std::move(p), fine));
  }
  return outcomes;
}

MeshLimit mesh_limit(std::span<const double> values) {
  constexpr double lowest_order = 1.0, highest_order = 2.0, of_two = 3.0, of_three = 1.25;
  const std::size_t n = values.size();
  if (n < 2)
    throw std::invalid_argument("mesh_limit needs two values, and not " + std::to_string(n));
  const double last = values[n - 1], change = last - values[n - 2];
  if (n == 2) return {last + change / 3.0, of_two * std::abs(change) / 3.0, highest_order};
  const double before = values[n - 2] - values[n - 3];
  // Changes of one sign that shrink, or there is no order.
  if (before * change < 0.0 || std::abs(change) >= std::abs(before)) {
    const double apart = std::abs(last - values[n - 3]);
    return {last, std::max({std::abs(change), std::abs(before), apart}), 0.0};
  }
  const double ratio = change == 0.0 ? HUGE_VAL : before / change;
  const double order = std::clamp(std::log2(ratio), lowest_order, highest_order);
  const double correction = change / (std::exp2(order) - 1.0);
  return {last + correction, of_three * std::abs(correction), order};
}

}  // namespace selvedge
