// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/solver/integrator.h>
#include <selvedge/lab/fabric_drape.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge {
namespace {

void validate(const DrapeTrial& t) {
  const auto positive = [](const char* name, double value) {
    require(std::isfinite(value) && value > 0.0, name, value, "positive and finite");
  };
  positive("support radius in m", t.support);
  require(std::isfinite(t.specimen) && t.specimen > t.support, "specimen radius in m", t.specimen,
          "larger than the support");
  require(t.cells >= 4, "cells", t.cells, "at least 4");
  require(std::isfinite(t.grading) && t.grading >= 1.0, "grading", t.grading, "at least 1");
  positive("step in s", t.step);
  positive("rest_speed in m/s", t.rest_speed);
  require(std::isfinite(t.damping) && t.damping >= 0.0, "damping in s", t.damping, "at least 0");
  require(std::isfinite(t.noise) && t.noise >= 0.0, "noise in m", t.noise, "at least 0");
  require(t.most_steps >= 1, "most_steps", t.most_steps, "at least 1");
}

/// Rings and spokes of a polar specimen. Beyond the support the ring spacing is a geometric series.
/// The edge of the support is midway between two held rings, because bending starts there: a hinge
/// represents half of the cells on both sides. A cloth that is laid on the support bends at a ring
/// on the edge. Farther in, where nothing moves, there are only as many rings as the mesh needs.
struct PolarMesh {
  std::vector<double> radii;  ///< m, ascending
  std::int32_t spokes;
  std::size_t held;  ///< number of held rings
};

PolarMesh polar_mesh(const DrapeTrial& t) {
  constexpr std::int32_t cells_per_turn = 5;  // 2π · 0.8
  // With this many rings the widest spacing is about that of equal rings.
  constexpr double more_rings = 1.5, inwards = 1.6;
  const double overhang = t.specimen - t.support, growth = std::log(t.grading);
  const double rings = std::max(3.0, std::round(more_rings * t.cells * overhang / t.specimen));
  const auto radius = [&](double share) {
    const double way = growth > 0.0 ? std::expm1(growth * share) / std::expm1(growth) : share;
    return t.support + overhang * way;
  };
  const double beyond = t.hold == DrapeHold::held ? 0.5 : 0.0;  // cells, of the ring at the edge
  const double first = radius(1.0 / (rings - beyond)) - t.support;
  PolarMesh mesh{{}, cells_per_turn * t.cells, 0};
  for (double h = first, r = t.support - (1.0 - beyond) * first; r > 0.5 * h; h *= inwards, r -= h)
    mesh.radii.push_back(r);
  std::reverse(mesh.radii.begin(), mesh.radii.end());
  mesh.radii.push_back(t.support + beyond * first);
  mesh.held = mesh.radii.size();
  for (double j = 1.0 + beyond; j < rings + 0.5 - beyond; ++j)
    mesh.radii.push_back(radius(j / (rings - beyond)));
  mesh.radii.back() = t.specimen;
  return mesh;
}

/// Rings about the centre, the k-th of 6 k vertices, `cells` edges across the disc.
TriangleMesh triangular_disc(double radius, std::int32_t cells) {
  require(cells >= 4 && cells % 2 == 0, "cells across the disc", cells, "even and at least 4");
  const std::int32_t rings = cells / 2;
  TriangleMesh disc;
  disc.vertices.emplace_back(0.0, 0.0, 0.0);
  const auto vertex = [](std::int32_t ring, std::int32_t k) {
    return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1) + k % (6 * ring);
  };
  for (std::int32_t ring = 1; ring <= rings; ++ring)
    for (std::int32_t k = 0; k < 6 * ring; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / (6 * ring), r = radius * ring / rings;
      disc.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.0);
    }
  for (std::int32_t ring = 1; ring <= rings; ++ring)
    for (std::int32_t sector = 0; sector < 6; ++sector)
      for (std::int32_t k = 0; k < ring; ++k) {
        const std::int32_t outer = sector * ring + k, inner = sector * (ring - 1) + k;
        disc.triangles.push_back(
            {vertex(ring - 1, inner), vertex(ring, outer), vertex(ring, outer + 1)});
        if (k + 1 < ring)
          disc.triangles.push_back(
              {vertex(ring - 1, inner), vertex(ring, outer + 1), vertex(ring - 1, inner + 1)});
      }
  return disc;
}

ClothMesh make_specimen(Material material, const DrapeTrial& trial) {
  material.spring_damping = std::max(material.spring_damping, trial.damping);
  material.bending_damping = std::max(material.bending_damping, trial.damping);
  if (trial.mesh == DrapeMesh::woven) return make_woven_disc(trial.specimen, trial.cells, material);
  if (trial.mesh == DrapeMesh::triangular) {
    const TriangleMesh disc = triangular_disc(trial.specimen, trial.cells);
    return make_from_mesh(disc, disc, material);
  }
  const PolarMesh mesh = polar_mesh(trial);
  return make_rings(mesh.radii, mesh.spokes, material);
}

/// Largest radius of held particles, m.
double held_radius(const DrapeTrial& trial) {
  constexpr double rounding = 1e-9;
  if (trial.hold != DrapeHold::held) return rounding;
  if (trial.mesh != DrapeMesh::arc) return trial.support + trial.specimen / trial.cells;
  const PolarMesh mesh = polar_mesh(trial);
  return mesh.radii[mesh.held - 1] * (1.0 + rounding);
}

/// Initial heights: waves around the support that grow outwards, with phases and amplitudes from
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
  static constexpr int fewest = 2, count = 23;  // number of folds; more than a cloth forms
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

/// Positions on another polar drape: interpolated linearly along spokes and by a cubic
/// (Catmull-Rom) around, because straight lines between particles would cut inside a fold.
class Draped {
 public:
  Draped(const DrapeTrial& trial, const DrapeOutcome& outcome)
      : mesh_(polar_mesh(trial)), x_(outcome.shape.vertices) {}

  /// Position of the point that lies at `rest` (m) in the flat cloth, outside the innermost ring.
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
  air.viscous_drag =
      0.5;  // N·s/m³: at rest within a second or two, without an effect on the rest shape.
  std::vector<double> areas;
  const auto& x = cloth.surface.vertices;
  for (const Triangle& t : cloth.surface.triangles)
    areas.push_back(0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm());
  forces.push_back(make_air_force(air, cloth.surface.triangles, areas, cloth.mass.size()));
  return forces;
}

/// The support as one disc at z = 0, which pushes on the cloth from below and on which it does not
/// slide. Empty if the cloth is held.
class Disc {
 public:
  Disc(const ClothMesh& cloth, const DrapeTrial& trial) : step_(trial.step) {
    if (trial.hold != DrapeHold::laid) return;
    constexpr double rounding = 1e-9;
    const auto& x = cloth.surface.vertices;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (x[i].norm() <= trial.support * (1.0 + rounding))
        over_.push_back(static_cast<std::int32_t>(i));
  }

  /// The pushes of one step.
  std::span<const ImplicitTerm> terms(const Particles& p) {
    terms_.clear();
    for (const std::int32_t i : over_) {
      const double depth = -p.x[i].z();
      if (p.inv_mass[i] == 0.0 || depth <= 0.0) continue;
      const double push = p.mass[i] * kStiffness * step_, drag = p.mass[i] * kDrag;
      terms_.push_back({{i, -1, -1, -1},
                        {1.0, 0.0, 0.0, 0.0},
                        Vec3(drag, drag, push * step_).asDiagonal().toDenseMatrix(),
                        push * depth * Vec3::UnitZ()});
    }
    return terms_;
  }

 private:
  static constexpr double kStiffness = 1e7;  // 1/s² per mass: 6 cm of cloth sink by 0.1 mm
  static constexpr double kDrag = 1e4;       // per mass: what touches slides by a ten thousandth

  double step_;  // s
  std::vector<std::int32_t> over_;
  std::vector<ImplicitTerm> terms_;
};

double largest_speed(const std::vector<Vec3>& v) {
  double largest = 0.0;
  for (const Vec3& u : v) largest = std::max(largest, u.squaredNorm());
  return std::sqrt(largest);
}

}  // namespace

namespace {

DrapeOutcome settle(const ClothMesh& cloth, Particles p, const DrapeTrial& trial) {
  constexpr ImplicitConfig solver{1e-4, 2000};
  const auto integrator = integrators().at("implicit_euler")(trial_forces(cloth), p.size(), solver);
  DrapeOutcome outcome;
  // the first steps are slow too, because the cloth starts at rest.
  constexpr std::int32_t warm_up = 20;
  std::vector<Vec3> v;
  Disc disc(cloth, trial);
  while (outcome.steps < trial.most_steps && !outcome.settled) {
    const double time = outcome.steps * trial.step;
    const std::span<const ImplicitTerm> pushes = disc.terms(p);
    integrator->begin({p, time, trial.step, !pushes.empty()}, {});
    v = p.v;
    integrator->solve(pushes, {v, {}}, 1.0);
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
  require(levels >= 1, "levels", levels, "at least 1");
  require(trial.mesh == DrapeMesh::arc, "mesh", static_cast<int>(trial.mesh),
          "arc: the others are not refined");
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
    throw std::invalid_argument("mesh_limit needs at least two values, not " + std::to_string(n));
  const double last = values[n - 1], change = last - values[n - 2];
  if (n == 2) return {last + change / 3.0, of_two * std::abs(change) / 3.0, highest_order};
  const double before = values[n - 2] - values[n - 3];
  // An order exists only if the changes have the same sign and shrink.
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
