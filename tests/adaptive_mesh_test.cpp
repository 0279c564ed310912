// SPDX-License-Identifier: MIT
//
// Meshes that are split where they bend, or everywhere, and meshes of two layers.
#include <selvedge/core/cloth_pattern.h>
#include <selvedge/core/force.h>
#include <selvedge/core/integrator.h>
#include <selvedge/core/measure.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "dense_force.h"

namespace selvedge::adaptive_mesh_test {
namespace {

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double v : values) total += v;
  return total;
}

Vec3 momentum(const std::vector<double>& mass, const Vectors& v) {
  Vec3 total = Vec3::Zero();
  for (std::size_t i = 0; i < v.size(); ++i) total += mass[i] * v[i];
  return total;
}

const GridConfig kGrid{0.6, 0.4, 6, 4};

/// Split at random: levels beside one another, corners, borders.
AdaptiveGrid ragged(const GridConfig& grid, const Material& material, unsigned seed, int rounds = 3,
                    Vectors* x = nullptr, Vectors* v = nullptr) {
  AdaptiveGrid adaptive(grid, material, 3);
  std::mt19937 generator(seed);
  for (int round = 0; round < rounds; ++round) {
    std::vector<GridCell> some;
    for (const GridCell& cell : adaptive.divisible())
      if (generator() % 4 == 0) some.push_back(cell);
    if (x != nullptr)
      adaptive.split(some, *x, *v);
    else
      adaptive.split(some);
  }
  return adaptive;
}

std::vector<std::pair<Edge, double>> springs_by_place(const ClothMesh& cloth) {
  // Vertices are numbered differently; rest positions tell which is which.
  std::vector<std::pair<std::array<double, 4>, double>> list;
  for (const Spring& s : cloth.springs) {
    const Vec3 a = cloth.surface.vertices[s.a], b = cloth.surface.vertices[s.b];
    const bool swap = std::pair(a.x(), a.y()) > std::pair(b.x(), b.y());
    const Vec3 p = swap ? b : a, q = swap ? a : b;
    list.push_back({{p.x(), p.y(), q.x(), q.y()}, s.stiffness});
  }
  std::sort(list.begin(), list.end());
  std::vector<std::pair<Edge, double>> rounded;
  constexpr double grain = 1e6;
  for (const auto& [place, k] : list)
    rounded.push_back({{static_cast<std::int32_t>(std::lround(grain * (place[0] + 7 * place[1]))),
                        static_cast<std::int32_t>(std::lround(grain * (place[2] + 7 * place[3])))},
                       std::round(k * grain) / grain});
  std::sort(rounded.begin(), rounded.end());
  return rounded;
}

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

TEST(AdaptiveGrid, ASplitKeepsMassAndMomentumAndPutsNewNodesOntoTheSurface) {
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

/// All cells whose quarters are leaves without finer neighbours; no angle is too large.
std::vector<GridCell> joinable(const AdaptiveGrid& adaptive, const Vectors& x) {
  return adaptive.flat(x, 4.0, 4.0);
}

TEST(AdaptiveGrid, JoinedAgainItIsTheRectangularMesh) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    AdaptiveGrid adaptive = ragged(kGrid, Material{}, seed);
    ASSERT_GT(adaptive.leaves().size(), 24u);
    const AdaptiveGrid whole(kGrid, Material{}, 3);
    for (int round = 0; round < 3; ++round)
      adaptive.join(joinable(adaptive, adaptive.cloth().surface.vertices));
    EXPECT_EQ(adaptive.leaves(), whole.leaves());
    const ClothMesh a = adaptive.cloth(), b = whole.cloth();
    EXPECT_EQ(a.surface.vertices, b.surface.vertices);
    EXPECT_EQ(a.surface.triangles, b.surface.triangles);
    EXPECT_EQ(a.mass, b.mass);
    EXPECT_EQ(a.hinges.size(), b.hinges.size());
    EXPECT_TRUE(a.hanging.empty());
    EXPECT_EQ(springs_by_place(a), springs_by_place(b));
  }
}

TEST(AdaptiveGrid, AJoinKeepsMassAndMomentumAndEveryOtherVertex) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    AdaptiveGrid adaptive(kGrid, Material{}, 3);
    Vectors x = adaptive.cloth().surface.vertices, v(x.size(), Vec3::Zero());
    adaptive = ragged(kGrid, Material{}, seed, 3, &x, &v);
    std::mt19937 generator(seed);
    for (int round = 0; round < 3; ++round) {
      v = random_vectors(x.size(), 2.0, seed + 50);
      const Vectors push = random_vectors(x.size(), 1e-3, seed + 100);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += push[i];
      const ClothMesh before = adaptive.cloth();
      // Nodes that hang are in the middle, as the solve keeps them, and have that velocity.
      for (int chain = 0; chain < 3; ++chain)
        for (const HangingNode& node : before.hanging)
          for (Vectors* u : {&x, &v}) (*u)[node.v[0]] = 0.5 * ((*u)[node.v[1]] + (*u)[node.v[2]]);
      std::vector<GridCell> some;
      for (const GridCell& cell : joinable(adaptive, x))
        if (generator() % 3 != 0) some.push_back(cell);
      const Vectors old_x = x, flat = adaptive.flattened(some, x);
      const Vec3 p = momentum(before.mass, v);
      const std::vector<std::int32_t> number = adaptive.join(some, x, v);
      const ClothMesh after = adaptive.cloth();
      ASSERT_EQ(x.size(), after.mass.size());
      EXPECT_NEAR(sum(after.mass), sum(before.mass), 1e-15);
      EXPECT_LT((momentum(after.mass, v) - p).norm(), 1e-14);
      std::vector<char> hangs(x.size(), 0);
      for (const HangingNode& node : after.hanging) {
        hangs[node.v[0]] = 1;
        EXPECT_EQ(x[node.v[0]], Vec3(0.5 * (x[node.v[1]] + x[node.v[2]])));
        EXPECT_LT((v[node.v[0]] - 0.5 * (v[node.v[1]] + v[node.v[2]])).norm(), 1e-15);
      }
      std::size_t gone = 0;
      for (std::size_t i = 0; i < number.size(); ++i) {
        if (number[i] < 0) {
          ++gone;
          const auto place = before.surface.vertices[i];
          EXPECT_EQ(std::count(after.surface.vertices.begin(), after.surface.vertices.end(), place),
                    0);
          continue;
        }
        EXPECT_EQ(after.surface.vertices[number[i]], before.surface.vertices[i]);
        EXPECT_EQ(x[number[i]], flat[i]);
        if (!hangs[number[i]]) {
          EXPECT_EQ(x[number[i]], old_x[i]);
        }
      }
      EXPECT_GE(gone, some.size());  // their centres, at least
    }
  }
}

TEST(AdaptiveGrid, AJoinMovesNoPointOfTheFlattenedSurface) {
  // The surfaces before and after are over the same points of the plane: the height at every
  // vertex of the one, on the other, is the same.
  AdaptiveGrid adaptive(kGrid, Material{}, 3);
  Vectors x = adaptive.cloth().surface.vertices, v(x.size(), Vec3::Zero());
  for (Vec3& p : x) p.z() = 0.1 * std::sin(20.0 * p.x()) * std::cos(15.0 * p.y());
  adaptive = ragged(kGrid, Material{}, 7);
  x = adaptive.cloth().surface.vertices;
  v.assign(x.size(), Vec3::Zero());
  for (Vec3& p : x) p.z() = 0.1 * std::sin(20.0 * p.x()) * std::cos(15.0 * p.y());
  const std::vector<GridCell> cells = joinable(adaptive, x);
  ASSERT_FALSE(cells.empty());
  const Vectors flat = adaptive.flattened(cells, x);
  adaptive.join(cells, x, v);
  const std::vector<Triangle> triangles = adaptive.cloth().surface.triangles;
  for (const Vec3& p : flat) {
    double height = std::nan("");
    for (const Triangle& t : triangles) {
      const Vec3 a = x[t[0]], e = x[t[1]] - a, f = x[t[2]] - a, d = p - a;
      const double area = e.x() * f.y() - e.y() * f.x();
      const double s = (d.x() * f.y() - d.y() * f.x()) / area;
      const double r = (e.x() * d.y() - e.y() * d.x()) / area;
      if (s > -1e-9 && r > -1e-9 && s + r < 1.0 + 1e-9) height = a.z() + s * e.z() + r * f.z();
    }
    EXPECT_NEAR(height, p.z(), 1e-13);
  }
}

TEST(AdaptiveGrid, IsFlatWhereItDoesNotBend) {
  AdaptiveGrid adaptive({1.0, 0.1, 20, 2}, Material{}, 1);
  adaptive.split(adaptive.divisible());
  Vectors x = adaptive.cloth().surface.vertices;
  for (Vec3& p : x) p.z() = 0.2 * std::max(0.0, p.x());  // a crease at x = 0, of 11.3 degrees
  constexpr double degree = 3.14159265358979323846 / 180.0;
  for (const GridCell& cell : adaptive.flat(x, 5.0 * degree, 45.0 * degree))
    EXPECT_TRUE(cell.i < 9 || cell.i > 10) << cell.i;
  EXPECT_EQ(adaptive.flat(x, 5.0 * degree, 45.0 * degree).size(), 36u);
  EXPECT_EQ(adaptive.flat(x, 12.0 * degree, 45.0 * degree).size(), 40u);
  EXPECT_EQ(adaptive.flat(x, 12.0 * degree, 10.0 * degree).size(), 36u);  // they would split again
}

TEST(AdaptiveGrid, NeighboursDifferByOneLevelAfterAJoin) {
  AdaptiveGrid adaptive(kGrid, Material{}, 2);
  adaptive.split(adaptive.divisible());
  const std::vector<GridCell> one{{1, 2, 2}};
  adaptive.split(one);
  const Vectors x = adaptive.cloth().surface.vertices;
  for (const GridCell& cell : joinable(adaptive, x)) {
    // {1, 2, 2} is split: of level 0, neither its cell (1, 1) nor those below and left of it.
    if (cell.level == 0) {
      EXPECT_FALSE(cell.i == 1 && cell.j == 1);
      EXPECT_FALSE(cell.i == 0 && cell.j == 1);
      EXPECT_FALSE(cell.i == 1 && cell.j == 0);
    }
  }
  EXPECT_EQ(joinable(adaptive, x).size(), 24u - 3u + 1u);
  // Cells that cannot be joined are ignored.
  const std::vector<GridCell> no{{0, 1, 1}, {0, 0, 1}, {2, 0, 0}, {0, 99, 0}};
  const std::set<GridCell> leaves = adaptive.leaves();
  adaptive.join(no);
  EXPECT_EQ(adaptive.leaves(), leaves);
}

std::unique_ptr<Integrator> make_constrained(const ClothMesh& cloth,
                                             std::vector<std::unique_ptr<Force>> forces,
                                             const std::string& name, double tolerance) {
  return make_following(Followers(cloth), std::move(forces), [&](auto inner, std::size_t n) {
    return integrators().at(name)(std::move(inner), n, ImplicitConfig{tolerance, 5000});
  });
}

double off_the_middle(const ClothMesh& cloth, const Vectors& x) {
  double off = 0.0;
  for (const HangingNode& node : cloth.hanging)
    off = std::max(off, (x[node.v[0]] - 0.5 * (x[node.v[1]] + x[node.v[2]])).norm());
  return off;
}

/// Newton's equilibrium under a uniform strain of the border, by implicit steps with friction.
TEST(AdaptiveGrid, AUniformStrainIsInEquilibrium) {
  Material material;
  material.bending_stiffness = 0.0;
  constexpr double strain = 0.01;
  const AdaptiveGrid adaptive = ragged(kGrid, material, 3, 2);
  const ClothMesh cloth = adaptive.cloth();
  const Vectors& rest = cloth.surface.vertices;
  const std::size_t n = rest.size();
  const auto solver = make_constrained(cloth, make_internal_forces(cloth), "implicit_euler", 1e-10);
  Particles p{rest, Vectors(n, Vec3::Zero()), cloth.mass, std::vector<double>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    p.x[i].x() *= 1.0 + strain;
    const bool border = std::abs(std::abs(rest[i].x()) - 0.5 * kGrid.size_x) < 1e-9 ||
                        std::abs(std::abs(rest[i].y()) - 0.5 * kGrid.size_y) < 1e-9;
    p.inv_mass[i] = border ? 0.0 : 1.0 / cloth.mass[i];
  }
  const Vectors uniform = p.x;
  // It comes back from a push, and stays.
  const Vectors push = random_vectors(n, 0.002, 5);
  for (std::size_t i = 0; i < n; ++i)
    if (p.inv_mass[i] > 0.0) p.x[i] += push[i];
  Followers(cloth).place(p.x);
  constexpr double h = 0.1;
  for (int step = 0; step < 60; ++step) {
    p.v.assign(n, Vec3::Zero());
    solver->begin({p, 0.0, h}, {});
    solver->solve({}, {p.v, {}}, 1.0);
    for (std::size_t i = 0; i < n; ++i) p.x[i] += h * p.v[i];
    EXPECT_LT(off_the_middle(cloth, p.x), 1e-15);
  }
  double off = 0.0;
  for (std::size_t i = 0; i < n; ++i) off = std::max(off, (p.x[i] - uniform[i]).norm());
  EXPECT_LT(off, 1e-9 * strain);
}

TEST(Followers, FollowTheLeadersOfChainsWithForcesOfTheSameSumAndMoment) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    ClothMesh cloth = ragged(kGrid, Material{}, seed).cloth();
    // Cells that differ by one level have no chains: other nodes hang on hanging ones.
    const std::int32_t m = cloth.hanging[0].v[0];
    for (const std::int32_t i : {20, 21, 22})
      if (Followers(cloth).shares(i).size() == 1) cloth.hanging.push_back({{i, m, i - 12}});
    const Followers followers(cloth);
    const std::size_t n = cloth.mass.size();
    EXPECT_EQ(followers.particles(), n);
    EXPECT_EQ(followers.nodes().size(), cloth.hanging.size());
    EXPECT_EQ(followers.leaders().size() + followers.nodes().size(), n);
    std::size_t chained = 0;
    for (const std::int32_t i : followers.nodes()) {
      double weights = 0.0;
      for (const Followers::Share& s : followers.shares(i)) weights += s.weight;
      EXPECT_EQ(weights, 1.0);
      chained += followers.shares(i).size() > 2 ? 1 : 0;
    }
    EXPECT_GT(chained, 0u);
    Vectors x = random_vectors(n, 1.0, seed);
    followers.place(x);
    EXPECT_LT(off_the_middle(cloth, x), 4e-16);
    const Vectors f = random_vectors(n, 1.0, seed + 9), y = followers.select(x);
    Vectors g(y.size(), Vec3::Zero());
    followers.gather(std::span<const Vec3>(f), std::span(g));
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (std::size_t i = 0; i < n; ++i) sum += f[i], moment += x[i].cross(f[i]);
    for (std::size_t l = 0; l < y.size(); ++l) sum -= g[l], moment -= y[l].cross(g[l]);
    EXPECT_LT(sum.norm() + moment.norm(), 1e-12);
  }
}

TEST(Followers, HandOverTheMomentumOfWhatMovedThem) {
  const ClothMesh cloth = ragged(kGrid, Material{}, 2).cloth();
  const Followers followers(cloth);
  std::vector<double> inv_mass;
  for (const double m : cloth.mass) inv_mass.push_back(1.0 / m);
  Vectors x = random_vectors(cloth.mass.size(), 1.0, 1);
  const Vec3 before = momentum(cloth.mass, x);
  followers.hand_over(cloth.mass, inv_mass, x);
  EXPECT_LT((momentum(cloth.mass, x) - before).norm(), 1e-14);
  EXPECT_LT(off_the_middle(cloth, x), 4e-16);
  const Vectors kept = x;  // what follows already stays
  followers.hand_over(cloth.mass, inv_mass, x);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT((x[i] - kept[i]).norm(), 1e-15);
  inv_mass[cloth.hanging[0].v[1]] = 0.0;  // a held leader does not move
  x = random_vectors(cloth.mass.size(), 1.0, 2);
  const Vec3 held = x[cloth.hanging[0].v[1]];
  followers.hand_over(cloth.mass, inv_mass, x);
  EXPECT_EQ(x[cloth.hanging[0].v[1]], held);
}

TEST(Followers, ANodeThatHangsOnItselfIsRefused) {
  ClothMesh cloth = make_rectangular(kGrid, Material{});
  cloth.hanging = {{{0, 1, 2}}, {{1, 0, 2}}};
  EXPECT_THROW(Followers{cloth}, std::invalid_argument);
}

/// A contact on a hanging node, in the solve: (M + w wᵀ K) v = w K u, nothing else acting.
TEST(Followers, AContactOfAHangingNodeMovesItsLeadersByTheirWeights) {
  for (const char* name : {"implicit_euler", "implicit_newton", "bdf2", "implicit_exact"}) {
    const ClothMesh cloth = ragged(kGrid, Material{}, 4).cloth();
    const Followers followers(cloth);
    const std::size_t n = cloth.mass.size();
    std::vector<std::unique_ptr<Force>> none;
    none.push_back(make_gravity(Vec3::Zero()));
    const auto solver = make_constrained(cloth, std::move(none), name, 1e-13);
    Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
    for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
    std::vector<double> lumped(followers.leaders().size(), 0.0);
    followers.gather(std::span<const double>(cloth.mass), std::span(lumped));
    const auto node = static_cast<std::size_t>(cloth.hanging.back().v[0]);
    constexpr double k = 0.3;
    const Vec3 u(1.0, -2.0, 0.5);
    const ImplicitTerm term{{static_cast<std::int32_t>(node), -1, -1, -1},
                            {1.0, 0.0, 0.0, 0.0},
                            k * Mat3::Identity(),
                            k * u};
    Vectors mean(n, Vec3::Zero()), end(mean);
    const std::vector<std::int32_t> touched{static_cast<std::int32_t>(node)};
    solver->begin({p, 0.0, 0.01, true, touched}, {mean, end});
    EXPECT_TRUE(solver->solve(std::vector{term}, {mean, end}, 1.0).converged) << name;
    double mobility = 0.0;  // wᵀ M⁻¹ w
    for (const Followers::Share& s : followers.shares(node))
      mobility += s.weight * s.weight / lumped[s.leader];
    const Vec3 impulse = k * u / (1.0 + k * mobility);
    EXPECT_LT((mean[node] - mobility * impulse).norm(), 1e-9) << name;
    for (const Followers::Share& s : followers.shares(node))
      EXPECT_LT(
          (mean[followers.leaders()[s.leader]] - s.weight / lumped[s.leader] * impulse).norm(),
          1e-9)
          << name;
    EXPECT_LT((momentum(cloth.mass, mean) - impulse).norm(), 1e-12) << name;
  }
}

/// P as a dense matrix.
Eigen::MatrixXd dense_rows(const Followers& followers) {
  const auto n = static_cast<Eigen::Index>(followers.particles());
  const auto m = static_cast<Eigen::Index>(followers.leaders().size());
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(3 * n, 3 * m);
  for (Eigen::Index i = 0; i < n; ++i)
    for (const Followers::Share& s : followers.shares(static_cast<std::size_t>(i)))
      for (int k = 0; k < 3; ++k) p(3 * i + k, 3 * s.leader + k) = s.weight;
  return p;
}

/// An undamped step away from equilibrium: (M + Pᵀ J P) y' = M y + h Pᵀ f, where M has the row sums
/// of Pᵀ M P and J = -h² ∂f/∂x.
TEST(Followers, AnImplicitStepSolvesTheReducedSystem) {
  Material material;
  material.spring_damping = material.bending_damping = 0.0;
  const ClothMesh cloth = ragged(kGrid, material, 5).cloth();
  const Followers followers(cloth);
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, random_vectors(n, 0.05, 3), cloth.mass, {}};
  const Vectors noise = random_vectors(n, 1e-3, 4);
  for (std::size_t i = 0; i < n; ++i)
    p.x[i] += noise[i] + 0.02 * std::sin(9.0 * p.x[i].x()) * Vec3::UnitZ();
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  followers.place(p.x);
  followers.place(p.v);
  constexpr double h = 0.005;
  const ForceState state{p.x, p.v, p.mass, 0.0};
  const auto size = static_cast<Eigen::Index>(3 * n);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(size);
  Eigen::MatrixXd j = Eigen::MatrixXd::Zero(size, size);
  for (const auto& force : make_internal_forces(cloth)) {
    f += flat(force_at(*force, state));
    j += assembled(*force, state, h);
  }
  const auto solver = make_constrained(cloth, make_internal_forces(cloth), "implicit_euler", 1e-13);
  Vectors mean = p.v, end = p.v;
  solver->begin({p, 0.0, h}, {mean, end});
  ASSERT_TRUE(solver->solve({}, {mean, end}, 1.0).converged);
  std::vector<double> mass(followers.leaders().size(), 0.0);
  followers.gather(std::span<const double>(cloth.mass), std::span(mass));
  const Eigen::MatrixXd rows = dense_rows(followers);
  const Vectors before = followers.select(p.v), after = followers.select(mean);
  Eigen::VectorXd left = rows.transpose() * (j * (rows * flat(after)));
  for (std::size_t l = 0; l < mass.size(); ++l)
    left.segment<3>(static_cast<Eigen::Index>(3 * l)) += mass[l] * (after[l] - before[l]);
  const Eigen::VectorXd right = h * (rows.transpose() * f);
  EXPECT_LT((left - right).norm(), 1e-8 * right.norm());
}

TEST(Followers, EveryIntegratorKeepsThemInTheMiddleAndTheWeightOfAll) {
  const ClothMesh cloth = ragged(kGrid, Material{}, 7).cloth();
  const Vec3 g(0.0, 0.0, -9.81);
  const double total = sum(cloth.mass);
  const IntegratorRegistry all = integrators();
  for (const auto* entry : all.in_order()) {
    const std::string name(entry->name());
    auto forces = make_internal_forces(cloth);
    forces.push_back(make_gravity(g));
    const auto solver = make_constrained(cloth, std::move(forces), name, 1e-10);
    const std::size_t n = cloth.mass.size();
    Particles p{cloth.surface.vertices, random_vectors(n, 0.05, 3), cloth.mass, {}};
    for (Vec3& x : p.x) x.z() = 0.02 * std::sin(9.0 * x.x());
    for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
    Followers(cloth).place(p.x);
    Followers(cloth).place(p.v);
    const Vec3 before = momentum(cloth.mass, p.v);
    const double h = 0.5 * std::min(1e-3, solver->stable_step(p, 0.0, 1e-3));
    ASSERT_GT(h, 0.0) << name;
    Vectors mean = p.v, end = p.v;
    solver->begin({p, 0.0, h}, {mean, end});
    solver->solve({}, {mean, end}, 1.0);
    EXPECT_LT(off_the_middle(cloth, mean), 1e-14) << name;
    const Vectors& v = solver->traits().ends_with_mean ? mean : end;
    EXPECT_LT(off_the_middle(cloth, v), 1e-14) << name;
    if (name.find("printed") != std::string::npos || name == "damped_verlet") continue;
    EXPECT_LT((momentum(cloth.mass, v) - before - total * h * g).norm(), 2e-6 * total) << name;
  }
}

/// Waving cloth with hanging nodes, stepped by one integrator.
struct Waving {
  explicit Waving(const std::string& name)
      : cloth(ragged(kGrid, Material{}, 7).cloth()),
        solver(make_constrained(cloth, make_internal_forces(cloth), name, 1e-12)) {
    const std::size_t n = cloth.mass.size();
    p = {cloth.surface.vertices, random_vectors(n, 0.05, 3), cloth.mass, {}};
    for (Vec3& x : p.x) x.z() = 0.02 * std::sin(9.0 * x.x());
    for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
    Followers(cloth).place(p.x);
    Followers(cloth).place(p.v);
  }
  void step(std::span<const std::int32_t> touched = {}) {
    Vectors mean = p.v, end = p.v;
    solver->begin({p, time, kStep, !touched.empty(), touched}, {mean, end});
    EXPECT_TRUE(solver->solve({}, {mean, end}, 1.0).converged);
    for (std::size_t i = 0; i < p.x.size(); ++i) p.x[i] += kStep * mean[i];
    p.v = solver->traits().ends_with_mean ? mean : end;
    solver->accept({p.x, p.v, p.mass, time});
    time += kStep;
  }

  static constexpr double kStep = 2e-3;  // s
  ClothMesh cloth;
  std::unique_ptr<Integrator> solver;
  Particles p;
  double time = 0.0;
};

TEST(Followers, AnIntegratorOfSeveralStepsContinuesFromItsSavedMemory) {
  Waving whole("bdf2"), resumed("bdf2"), anew("bdf2");
  for (int i = 0; i < 3; ++i) whole.step();
  std::vector<double> memory;
  whole.solver->save_memory(memory);
  for (Waving* other : {&resumed, &anew}) other->p = whole.p, other->time = whole.time;
  resumed.solver->restore_memory(memory);
  for (Waving* one : {&whole, &resumed, &anew}) one->step();
  EXPECT_EQ(resumed.p.x, whole.p.x);
  EXPECT_EQ(resumed.p.v, whole.p.v);
  EXPECT_NE(anew.p.v, whole.p.v);  // its first step is one of implicit Euler
  memory.resize(memory.size() / 2);
  EXPECT_THROW(resumed.solver->restore_memory(memory), std::invalid_argument);
}

TEST(Followers, AHangingNodeInContactPutsItsPieceIntoContact) {
  Waving touched("bdf2"), euler("implicit_euler"), free("bdf2");
  for (int i = 0; i < 3; ++i) touched.step(), free.step();
  euler.p = touched.p;
  euler.time = touched.time;
  const std::vector<std::int32_t> node{touched.cloth.hanging.front().v[0]};
  touched.step(node);
  euler.step(node);
  free.step();
  double to_euler = 0.0, to_free = 0.0;
  for (std::size_t i = 0; i < euler.p.v.size(); ++i) {
    to_euler = std::max(to_euler, (touched.p.v[i] - euler.p.v[i]).norm());
    to_free = std::max(to_free, (touched.p.v[i] - free.p.v[i]).norm());
  }
  EXPECT_LT(to_euler, 1e-9);
  EXPECT_GT(to_free, 1e-5);
}

/// A force of one newton per particle that only acts after a time.
class LateForce final : public Force {
 public:
  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    for (Vec3& g : f) g.x() += state.time > 1.0 ? 1.0 : 0.0;
  }
  double energy(const ForceState&) const override { return 0.0; }
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const ForceState&, double, BlockMatrix&) const override {}
  void add_stiffness_bound(const ForceState&, std::span<double>, std::span<double>) const override {
  }
};

TEST(Followers, ForcesOfTheLeadersKnowTheTime) {
  const ClothMesh cloth = ragged(kGrid, Material{}, 7).cloth();
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  for (const double time : {0.0, 2.0}) {
    std::vector<std::unique_ptr<Force>> late;
    late.push_back(std::make_unique<LateForce>());
    const auto solver = make_constrained(cloth, std::move(late), "implicit_euler", 1e-12);
    Vectors mean = p.v, end = p.v;
    solver->begin({p, time, 0.01}, {mean, end});
    solver->solve({}, {mean, end}, 1.0);
    const double expected = time > 1.0 ? 0.01 * static_cast<double>(n) : 0.0;
    EXPECT_NEAR(momentum(cloth.mass, mean).x(), expected, 1e-9);
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
    if (seed % 2 == 0) material.bending_law = BendingLaw::beam;
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
  rows.bending_law = BendingLaw::buckling;
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
