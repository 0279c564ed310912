// SPDX-License-Identifier: MIT
//
// Meshes that are split where they bend, or everywhere, and meshes of two layers.
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "adaptive_grids.h"
#include "dense_force.h"

namespace selvedge::adaptive_mesh_test {
namespace {

using adaptive_grids::kGrid;
using adaptive_grids::momentum;
using adaptive_grids::ragged;
using adaptive_grids::springs_by_place;
using adaptive_grids::sum;

TEST(AdaptiveGrid, UnsplitAndSplitEverywhereItIsTheRectangularMesh) {
  AdaptiveGrid adaptive(kGrid, Material{}, 1);
  GridConfig grid = kGrid;
  for (int level = 0; level < 2; ++level) {
    const ClothMesh cloth = adaptive.cloth(), other = make_rectangular(grid, Material{});
    EXPECT_EQ(springs_by_place(cloth), springs_by_place(other)) << level;
    EXPECT_EQ(cloth.hinges.size(), other.hinges.size());
    double stiffness = 0.0;
    for (const Hinge& hinge : cloth.hinges) stiffness += hinge.stiffness;
    for (const Hinge& hinge : other.hinges) stiffness -= hinge.stiffness;
    EXPECT_NEAR(stiffness, 0.0, 1e-15);
    EXPECT_TRUE(cloth.hanging.empty());
    adaptive.split(adaptive.divisible());
    grid.cells_x *= 2;
    grid.cells_y *= 2;
  }
}

TEST(AdaptiveGrid, HasTheBendingFrictionOfTheRectangularMesh) {
  Material material;
  material.bending_friction = 1e-3;
  const auto total = [](const ClothMesh& cloth) {
    double moment = 0.0;
    for (const HingeFriction& f : cloth.hinge_frictions) moment += f.moment;
    return moment;
  };
  const auto mean_yield = [](double moment, const ClothMesh& cloth) {
    double work = 0.0;
    for (const HingeFriction& f : cloth.hinge_frictions) work += f.moment * f.yield;
    return work / moment;
  };
  GridConfig grid = kGrid;
  const ClothMesh coarse = make_rectangular(grid, material);
  const ClothMesh unsplit = AdaptiveGrid(grid, material, 1).cloth();
  EXPECT_EQ(unsplit.hinge_frictions.size(), coarse.hinge_frictions.size());
  EXPECT_NEAR(total(unsplit), total(coarse), 1e-12);
  EXPECT_NEAR(mean_yield(total(unsplit), unsplit), mean_yield(total(coarse), coarse), 1e-12);
  AdaptiveGrid adaptive(grid, material, 1);
  adaptive.split(adaptive.divisible());
  grid.cells_x *= 2;
  grid.cells_y *= 2;
  const ClothMesh fine = make_rectangular(grid, material), split = adaptive.cloth();
  EXPECT_EQ(split.hinge_frictions.size(), fine.hinge_frictions.size());
  EXPECT_NEAR(total(split), total(fine), 1e-12);
  EXPECT_NEAR(mean_yield(total(split), split), mean_yield(total(fine), fine), 1e-12);
}

TEST(AdaptiveGrid, HasTheConstantsAndTheMassOfTheFabricWhateverIsSplit) {
  const ClothMesh whole = make_rectangular(kGrid, Material{});
  const double area = kGrid.size_x * kGrid.size_y;
  const ContinuumConstants c = continuum_constants(whole, whole.surface.vertices, area);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const ClothMesh cloth = ragged(kGrid, Material{}, seed).cloth();
    EXPECT_FALSE(cloth.hanging.empty());
    EXPECT_LT(relative_distance(continuum_constants(cloth, cloth.surface.vertices, area), c),
              1e-12);
    EXPECT_NEAR(sum(cloth.mass), Material{}.density * area, 1e-15);
    for (const double m : cloth.mass) EXPECT_GT(m, 0.0);
  }
}

TEST(AdaptiveGrid, HasNoGap) {
  // Every edge has two triangles, or lies on the border; and the areas add up.
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const ClothMesh cloth = ragged(kGrid, Material{}, seed).cloth();
    std::map<Edge, int> sides;
    double area = 0.0;
    for (const Triangle& t : cloth.surface.triangles) {
      const Vectors& x = cloth.surface.vertices;
      area += 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).z();
      for (int k = 0; k < 3; ++k)
        ++sides[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
    }
    EXPECT_NEAR(area, kGrid.size_x * kGrid.size_y, 1e-14);
    for (const auto& [edge, count] : sides) {
      const Vec3 middle = 0.5 * (cloth.surface.vertices[edge[0]] + cloth.surface.vertices[edge[1]]);
      const bool border = std::abs(std::abs(middle.x()) - 0.5 * kGrid.size_x) < 1e-9 ||
                          std::abs(std::abs(middle.y()) - 0.5 * kGrid.size_y) < 1e-9;
      EXPECT_EQ(count, border ? 1 : 2);
    }
  }
}

TEST(AdaptiveGrid, NeighboursDifferByOneLevelAtMost) {
  AdaptiveGrid adaptive(kGrid, Material{}, 4);
  for (int round = 0; round < 4; ++round) {  // always the cell at the origin's corner
    const std::vector<GridCell> corner{{round, 0, 0}};
    adaptive.split(corner);
  }
  for (const GridCell& a : adaptive.leaves())
    for (const GridCell& b : adaptive.leaves()) {
      if (b.level <= a.level) continue;
      // b beside a: its square, grown by its own size along one axis, meets a's.
      const int s = 1 << (b.level - a.level);
      const bool x_in = b.i >= a.i * s && b.i < (a.i + 1) * s;
      const bool y_in = b.j >= a.j * s && b.j < (a.j + 1) * s;
      const bool x_by = b.i == a.i * s - 1 || b.i == (a.i + 1) * s;
      const bool y_by = b.j == a.j * s - 1 || b.j == (a.j + 1) * s;
      if ((x_in && y_by) || (y_in && x_by)) {
        EXPECT_EQ(b.level, a.level + 1);
      }
    }
}

TEST(AdaptiveGrid, ASplitKeepsMassMomentumAndSurface) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    AdaptiveGrid adaptive(kGrid, Material{}, 3);
    Vectors x = adaptive.cloth().surface.vertices;
    Vectors v = random_vectors(x.size(), 2.0, seed + 50);
    for (Vec3& p : x) p.z() = 0.1 * std::sin(20.0 * p.x()) * std::cos(15.0 * p.y());
    std::mt19937 generator(seed);
    for (int round = 0; round < 4; ++round) {
      // Nodes that were there move by themselves, hanging ones off their middles too.
      const Vectors push = random_vectors(x.size(), 1.0, seed + 100);
      for (std::size_t i = 0; i < v.size(); ++i) v[i] += push[i];
      const ClothMesh before = adaptive.cloth();
      const Vec3 p = momentum(before.mass, v);
      const std::size_t old = x.size();
      std::vector<GridCell> some;
      for (const GridCell& cell : adaptive.divisible())
        if (generator() % 3 == 0) some.push_back(cell);
      adaptive.split(some, x, v);
      const ClothMesh after = adaptive.cloth();
      EXPECT_NEAR(sum(after.mass), sum(before.mass), 1e-15);
      EXPECT_LT((momentum(after.mass, v) - p).norm(), 1e-15 + 1e-13 * p.norm());
      for (std::size_t i = old; i < x.size(); ++i) {
        const auto [a, b] = adaptive.parents(static_cast<std::int32_t>(i));
        EXPECT_EQ(x[i], Vec3(0.5 * (x[a] + x[b])));
      }
      for (std::size_t i = 0; i < old; ++i)
        EXPECT_EQ(before.surface.vertices[i], after.surface.vertices[i]);
    }
  }
}

TEST(AdaptiveGrid, SplitsWhereItBendsAndNowhereElse) {
  AdaptiveGrid adaptive({1.0, 1.0, 16, 16}, Material{}, 2);
  Vectors x = adaptive.cloth().surface.vertices, v(x.size(), Vec3::Zero());
  const auto fold = [](Vec3& p) {  // a roof along y
    if (p.x() > 0.0) p = Vec3(0.5 * p.x(), p.y(), -0.8 * p.x());
  };
  for (Vec3& p : x) fold(p);
  EXPECT_TRUE(adaptive.curved(x, 1.2).empty());  // the roof turns by atan(1.6) = 1.012 rad
  const std::vector<GridCell> cells = adaptive.curved(x, 0.9);
  EXPECT_EQ(cells.size(), 32u);
  for (const GridCell& cell : cells) EXPECT_TRUE(cell.i == 7 || cell.i == 8);
  adaptive.split(cells, x, v);
  EXPECT_EQ(adaptive.curved(x, 0.9).size(), 64u);  // both rows beside the ridge, at level 1
  for (const Vec3& p : x) {                        // still the roof
    EXPECT_NEAR(p.z(), p.x() > 0.0 ? -1.6 * p.x() : 0.0, 1e-15);
  }
}

TEST(AdaptiveGrid, RolledToACylinderItStoresThePlatesEnergy) {
  constexpr double radius = 2.0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Material material;
    if (seed % 2 == 0) material.bending_law = "beam";
    const ClothMesh cloth = ragged({1.0, 1.0, 12, 12}, material, seed, 1).cloth();
    Vectors x = cloth.surface.vertices;
    const Vectors v(x.size(), Vec3::Zero());
    for (const bool along_y : {false, true}) {
      for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3& r = cloth.surface.vertices[i];
        const double s = along_y ? r.y() : r.x(), t = along_y ? r.x() : r.y();
        const double bent = radius * std::sin(s / radius);
        x[i] = along_y ? Vec3(t, bent, radius * std::cos(s / radius))
                       : Vec3(bent, t, radius * std::cos(s / radius));
      }
      const double energy =
          make_bending_force(cloth.hinges, x.size())->energy({x, v, cloth.mass, 0.0}) +
          make_beam_force(cloth.beams, x.size())->energy({x, v, cloth.mass, 0.0});
      EXPECT_EQ(cloth.beams.empty(), seed % 2 == 1);
      const double plate = 0.5 * material.bending_stiffness / (radius * radius);
      // Half a cell at two borders does not bend: 1/12 of it.
      EXPECT_NEAR(energy / plate, 11.0 / 12.0, 0.05) << seed;
    }
  }
}

TEST(AdaptiveGrid, BadInputIsRefused) {
  EXPECT_THROW(AdaptiveGrid(kGrid, Material{}, 7), std::invalid_argument);
  EXPECT_THROW(AdaptiveGrid(kGrid, Material{}, -1), std::invalid_argument);
  EXPECT_THROW(AdaptiveGrid({1.0, 1.0, 5000, 5000}, Material{}, 4), std::invalid_argument);
  Material rows;
  rows.bending_law = "buckling";
  EXPECT_THROW(AdaptiveGrid(kGrid, rows, 1), std::invalid_argument);
  AdaptiveGrid adaptive(kGrid, Material{}, 1);
  Vectors x(3), v(3);
  EXPECT_THROW(adaptive.split(adaptive.divisible(), x, v), std::invalid_argument);
  EXPECT_THROW(adaptive.join(adaptive.divisible(), x, v), std::invalid_argument);
}

TEST(Bilayered, TheSparseLayerHasTheFabricAndBothHaveItsMass) {
  const GridConfig grid{0.8, 0.4, 16, 8};
  const ClothMesh cloth = make_bilayered(grid, {4, 0.3, 2000.0}, Material{});
  const ClothMesh single = make_rectangular(grid, Material{});
  const double area = grid.size_x * grid.size_y;
  EXPECT_EQ(cloth.surface.vertices.size(), 17u * 9u + 5u * 3u);
  EXPECT_EQ(cloth.surface.triangles, single.surface.triangles);
  EXPECT_NEAR(sum(cloth.mass), Material{}.density * area, 1e-15);
  const LayerParts parts = split_layers(cloth);
  EXPECT_LT(relative_distance(continuum_constants(parts.carrying, cloth.surface.vertices, area),
                              continuum_constants(single, single.surface.vertices, area)),
            1e-12);
  EXPECT_EQ(parts.local.springs.size(), single.springs.size());
  EXPECT_EQ(parts.local.springs.size() + parts.carrying.springs.size(), cloth.springs.size());
  EXPECT_EQ(parts.local.layers.size(), 17u * 9u);
  EXPECT_TRUE(parts.carrying.layers.empty());
}

std::unique_ptr<Integrator> make_both_layers(const ClothMesh& cloth, const Vec3& gravity,
                                             const std::string& name) {
  const LayerParts parts = split_layers(cloth);
  auto forces = make_internal_forces(parts.carrying);
  forces.push_back(make_gravity(gravity));
  return make_layered(
      Followers::of_layers(cloth), std::move(forces), make_internal_forces(parts.local),
      [&](auto inner, std::size_t n) {
        return integrators().at(name)(std::move(inner), n, ImplicitConfig{1e-11, 5000});
      });
}

/// Steps of a cloth of which some particles are held.
void make_steps(Integrator& integrator, Particles& p, int steps, double h, Vectors& mean) {
  const std::size_t n = p.size();
  for (int step = 0; step < steps; ++step) {
    mean = p.v;
    for (std::size_t i = 0; i < n; ++i)
      if (p.inv_mass[i] <= 0.0) mean[i].setZero();
    Vectors end = mean;
    integrator.begin({p, step * h, h}, {mean, end});
    integrator.solve({}, {mean, end}, 1.0);
    for (std::size_t i = 0; i < n; ++i) p.x[i] += h * mean[i];
    p.v = integrator.traits().ends_with_mean ? mean : end;
    integrator.accept({p.x, p.v, p.mass, (step + 1) * h});
  }
}

TEST(Bilayered, TheSparseLayerMovesLikeTheSparseNetAlone) {
  const GridConfig grid{0.8, 0.4, 16, 8}, coarse{0.8, 0.4, 4, 2};
  const ClothMesh cloth = make_bilayered(grid, {4, 0.3, 2000.0}, Material{});
  const ClothMesh sparse = make_rectangular(coarse, Material{});
  const std::size_t dense = 17u * 9u, n = cloth.mass.size();
  const Vec3 g(0.0, 0.0, -9.81);
  for (const char* name : {"implicit_euler", "symplectic_euler", "verlet"}) {
    const auto both = make_both_layers(cloth, g, name);
    auto forces = make_internal_forces(sparse);
    forces.push_back(make_gravity(g));
    const auto alone =
        integrators().at(name)(std::move(forces), n - dense, ImplicitConfig{1e-11, 5000});
    Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
    for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
    p.inv_mass[0] = p.inv_mass[dense] = 0.0;  // a corner of both
    Particles q{sparse.surface.vertices, Vectors(n - dense, Vec3::Zero()), sparse.mass, {}};
    for (const double m : sparse.mass) q.inv_mass.push_back(1.0 / m);
    q.inv_mass[0] = 0.0;
    Vectors mean;
    const bool implicit = both->traits().is_implicit;
    const double h = implicit ? 0.01 : 1e-4;
    for (int part = 0; part < 10; ++part) {
      make_steps(*both, p, implicit ? 5 : 100, h, mean);
      make_steps(*alone, q, implicit ? 5 : 100, h, mean);
      for (std::size_t i = 0; i < q.size(); ++i)
        EXPECT_LT((p.x[dense + i] - q.x[i]).norm(), 1e-7) << name;
    }
    EXPECT_LT(q.x[14].z(), -0.005) << name;
    // The dense layer has stayed near, and is not flat between the sparse particles any more.
    const Followers layers = Followers::of_layers(cloth);
    Vectors carried = p.x;
    layers.place(carried);
    double off = 0.0;
    for (std::size_t i = 0; i < dense; ++i) off = std::max(off, (p.x[i] - carried[i]).norm());
    EXPECT_LT(off, 0.02) << name;
    EXPECT_GT(off, 1e-6) << name;
  }
}

TEST(Bilayered, FreeFallMovesBothLayersAlike) {
  const ClothMesh cloth = make_bilayered({0.8, 0.4, 16, 8}, {4, 0.3, 2000.0}, Material{});
  const std::size_t n = cloth.mass.size();
  const auto both = make_both_layers(cloth, Vec3(0.0, 0.0, -9.81), "implicit_euler");
  Particles p{cloth.surface.vertices, Vectors(n, Vec3(1.0, 0.0, 0.0)), cloth.mass, {}};
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  Vectors mean;
  make_steps(*both, p, 30, 0.01, mean);
  for (std::size_t i = 0; i < n; ++i)
    EXPECT_LT((p.v[i] - Vec3(1.0, 0.0, -9.81 * 0.3)).norm(), 1e-9);
}

/// The momentum of an impulse on a dense particle goes to the sparse layer.
TEST(Bilayered, AContactOfTheDenseLayerMovesTheSparseOne) {
  const ClothMesh cloth = make_bilayered({0.8, 0.4, 16, 8}, {4, 0.3, 2000.0}, Material{});
  const Followers layers = Followers::of_layers(cloth);
  const std::size_t n = cloth.mass.size();
  const auto both = make_both_layers(cloth, Vec3::Zero(), "implicit_euler");
  Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  constexpr std::int32_t node = 3 * 17 + 6;  // between sparse particles
  constexpr double k = 0.05;
  const Vec3 u(0.0, 0.0, 1.0);
  const ImplicitTerm term{{node, -1, -1, -1}, {1.0, 0.0, 0.0, 0.0}, k * Mat3::Identity(), k * u};
  std::vector<double> whole(layers.leaders().size(), 0.0);
  layers.gather(std::span<const double>(cloth.mass), std::span(whole));
  for (const double own : {0.0, 0.4}) {  // m/s, of the dense layer beside the sparse one
    for (const std::int32_t i : layers.nodes()) p.v[i] = own * Vec3::UnitZ();
    Vectors mean(n, Vec3::Zero()), end(mean);
    both->begin({p, 0.0, 0.01, true, {}}, {mean, end});
    both->solve(std::vector{term}, {mean, end}, 1.0);
    Vec3 given = Vec3::Zero();
    for (std::size_t l = 0; l < whole.size(); ++l) given += whole[l] * mean[layers.leaders()[l]];
    EXPECT_GT(given.z(), 0.0);
    EXPECT_LT((given - k * (u - mean[node])).norm(), 1e-9);
    Vectors carried = mean;
    layers.place(carried);
    const double offset = (carried[node] - mean[node]).norm();
    EXPECT_TRUE(own == 0.0 ? offset < 1e-12 : offset > 0.1) << offset;
  }
  // What moves dense particles after the solve.
  Vectors off(n, Vec3::Zero()), v(n, Vec3::Zero());
  off[node] = u;
  layers.push_leaders(cloth.mass, p.inv_mass, off, v);
  Vec3 pushed = Vec3::Zero();
  for (std::size_t l = 0; l < whole.size(); ++l) pushed += whole[l] * v[layers.leaders()[l]];
  EXPECT_LT((pushed - cloth.mass[node] * u).norm(), 1e-15);
}

/// In the local iteration of the dense layer the sparse one is held, so its masses do not matter.
TEST(Bilayered, TheDenseLayerIsDrawnBackToAHeldSparseLayer) {
  const ClothMesh cloth = make_bilayered({0.8, 0.4, 16, 8}, {4, 0.3, 2000.0}, Material{});
  const Followers layers = Followers::of_layers(cloth);
  const std::size_t n = cloth.mass.size();
  std::vector<Vectors> drawn;
  for (const double heavier : {1.0, 1000.0}) {
    const auto both = make_both_layers(cloth, Vec3::Zero(), "implicit_euler");
    Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
    for (const std::int32_t i : layers.leaders()) p.mass[i] *= heavier;
    for (const double m : p.mass) p.inv_mass.push_back(1.0 / m);
    for (const std::int32_t i : layers.nodes()) p.x[i].z() += 1e-3;
    Vectors mean(n, Vec3::Zero()), end(mean);
    both->begin({p, 0.0, 0.01}, {mean, end});
    both->solve({}, {mean, end}, 1.0);
    for (const std::int32_t i : layers.leaders()) EXPECT_LT(mean[i].norm(), 1e-13);
    for (const std::int32_t i : layers.nodes()) EXPECT_LT(mean[i].z(), -5e-4);
    drawn.push_back(mean);
  }
  for (const std::int32_t i : layers.nodes())
    EXPECT_LT((drawn[0][i] - drawn[1][i]).norm(), 1e-13) << i;
}

/// Held particles of either layer, and those that a handle moves.
TEST(Bilayered, HeldParticlesOfBothLayersMoveAsTheyAreMoved) {
  const ClothMesh cloth = make_bilayered({0.8, 0.4, 16, 8}, {4, 0.3, 2000.0}, Material{});
  const Followers layers = Followers::of_layers(cloth);
  const std::size_t n = cloth.mass.size();
  for (const char* name : {"implicit_euler", "symplectic_euler"}) {
    const auto both = make_both_layers(cloth, Vec3(0.0, 0.0, -9.81), name);
    Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
    for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
    // Three of each layer, none of which is above a held one of the other.
    const auto &dense = layers.nodes(), &sparse = layers.leaders();
    const std::vector<std::int32_t> held{dense[1],  dense[53],  dense[100],
                                         sparse[4], sparse[10], sparse[14]};
    const Vec3 still = Vec3::Zero();
    for (const Vec3& u : {still, Vec3(0.3, -0.2, 0.1)}) {
      Vectors mean = p.v;
      for (const std::int32_t i : held) {
        p.inv_mass[i] = 0.0;
        mean[i] = u;
      }
      Vectors end = mean;
      const double h = both->traits().is_implicit ? 0.01 : 1e-4;
      both->begin({p, 0.0, h}, {mean, end});
      both->solve({}, {mean, end}, 1.0);
      for (const std::int32_t i : held) EXPECT_LT((mean[i] - u).norm(), 1e-15) << name << i;
      EXPECT_LT(mean[sparse[7]].z(), -1e-4) << name;
    }
  }
}

TEST(Bilayered, AtRestAndInAnyAffineShapeTheLayersAreTogether) {
  const ClothMesh cloth = make_bilayered({0.8, 0.4, 16, 8}, {4, 0.3, 2000.0}, Material{});
  const auto ties = make_tie_force(cloth.layers, cloth.mass.size());
  Mat3 shape;
  shape << 1.1, 0.2, 0.0, -0.1, 0.9, 0.0, 0.3, 0.4, 1.0;
  Vectors x = cloth.surface.vertices;
  const Vectors v(x.size(), Vec3::Zero());
  for (Vec3& p : x) p = shape * p + Vec3(1.0, 2.0, 3.0);
  EXPECT_LT(ties->energy({x, v, cloth.mass, 0.0}), 1e-25);
}

TEST(Bilayered, TheDenseLayerIsDrawnBackByHoldPerArea) {
  const LayerConfig layers{4, 0.3, 2000.0};
  const GridConfig grid{0.8, 0.4, 16, 8};
  const ClothMesh cloth = make_bilayered(grid, layers, Material{});
  const std::size_t dense = 17u * 9u;
  Vectors x = cloth.surface.vertices, f(x.size(), Vec3::Zero());
  const Vectors v(x.size(), Vec3::Zero());
  constexpr double apart = 1e-3;
  for (std::size_t i = 0; i < dense; ++i) x[i].z() += apart;
  make_tie_force(cloth.layers, x.size())->add_force({x, v, cloth.mass, 0.0}, f);
  double force = 0.0;
  for (std::size_t i = dense; i < f.size(); ++i) force += f[i].z();
  EXPECT_NEAR(force, layers.hold * apart * grid.size_x * grid.size_y, 1e-12);
}

TEST(Bilayered, BadInputIsRefused) {
  const GridConfig grid{0.8, 0.4, 16, 8};
  EXPECT_THROW(make_bilayered(grid, {3, 0.3, 2000.0}, Material{}), std::invalid_argument);
  EXPECT_THROW(make_bilayered(grid, {1, 0.3, 2000.0}, Material{}), std::invalid_argument);
  EXPECT_THROW(make_bilayered(grid, {4, 0.0, 2000.0}, Material{}), std::invalid_argument);
  EXPECT_THROW(make_bilayered(grid, {4, 1.0, 2000.0}, Material{}), std::invalid_argument);
  EXPECT_THROW(make_bilayered(grid, {4, 0.3, 0.0}, Material{}), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::adaptive_mesh_test
