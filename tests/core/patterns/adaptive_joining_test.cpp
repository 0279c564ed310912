// SPDX-License-Identifier: MIT
//
// Quarters of cells that are joined again.
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/cloth_pattern.h>
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

namespace selvedge::adaptive_joining_test {
namespace {

using adaptive_grids::kGrid;
using adaptive_grids::momentum;
using adaptive_grids::ragged;
using adaptive_grids::springs_by_place;
using adaptive_grids::sum;

/// All cells whose quarters are leaves without finer neighbours; no angle is too large.
std::vector<GridCell> joinable(const AdaptiveGrid& adaptive, const Vectors& x) {
  return adaptive.flat(x, 4.0, 4.0);
}

TEST(AdaptiveGridJoins, JoinedAgainItIsTheRectangularMesh) {
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

TEST(AdaptiveGridJoins, AJoinKeepsMassAndMomentumAndEveryOtherVertex) {
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

TEST(AdaptiveGridJoins, AJoinMovesNoPointOfTheFlattenedSurface) {
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

TEST(AdaptiveGridJoins, IsFlatWhereItDoesNotBend) {
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

TEST(AdaptiveGridJoins, NeighboursDifferByOneLevelAfterAJoin) {
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

}  // namespace
}  // namespace selvedge::adaptive_joining_test
