// SPDX-License-Identifier: MIT
// Triangles that are split by bisection of their longest edges: no hanging node, no thin triangle,
// no change of mass, momentum, surface or stretch stiffness.
#include <gtest/gtest.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/patterns/internal/adaptive_triangles.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <stdexcept>
#include <utility>

namespace selvedge::adaptive_triangles_test {
namespace {

Material fabric() {
  Material m;
  m.density = 0.2;
  m.stretch_stiffness = 400.0;
  m.bending_stiffness = 2e-5;
  return m;
}

AdaptiveTriangles triangles(std::int32_t cells, std::int32_t levels) {
  return {make_triangular({0.6, 0.5, cells, cells}, fabric()).surface, fabric(), levels};
}

double area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles)
    sum += 0.5 * (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                     .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                     .z();
  return sum;
}

double smallest_angle(const TriangleMesh& mesh) {
  double smallest = 4.0;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3 u = mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]];
      const Vec3 v = mesh.vertices[t[(k + 2) % 3]] - mesh.vertices[t[k]];
      smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)));
    }
  return smallest;
}

/// Splits random triangles of the mesh that can be split, in rounds.
void split_at_random(AdaptiveTriangles& mesh, std::vector<Vec3>& x, std::vector<Vec3>& v,
                     std::mt19937& random) {
  for (int round = 0; round < 6; ++round) {
    std::vector<std::int32_t> some;
    for (const std::int32_t t : mesh.divisible())
      if (random() % 5 == 0) some.push_back(t);
    mesh.split(some, x, v);
  }
}

TEST(AdaptiveTriangles, HaveNoHangingNodeAndCoverTheSameSurface) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 10; ++trial) {
    AdaptiveTriangles mesh = triangles(4, 3);
    const double whole = area(mesh.rest());
    std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
    split_at_random(mesh, x, v, random);
    EXPECT_GT(mesh.rest().triangles.size(), 100u);
    EXPECT_NEAR(area(mesh.rest()), whole, 1e-12);
    std::map<Edge, int> count;
    std::map<std::pair<double, double>, std::int32_t> at;
    for (std::int32_t i = 0; i < mesh.vertex_count(); ++i)
      at[{mesh.rest().vertices[i].x(), mesh.rest().vertices[i].y()}] = i;
    EXPECT_EQ(at.size(), mesh.rest().vertices.size()) << "a vertex was inserted twice";
    for (const Triangle& t : mesh.rest().triangles)
      for (int k = 0; k < 3; ++k)
        ++count[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
    double border = 0.0;
    for (const auto& [edge, n] : count) {
      const Vec3 &a = mesh.rest().vertices[edge[0]], &b = mesh.rest().vertices[edge[1]];
      const Vec3 middle = 0.5 * (a + b);
      EXPECT_FALSE(at.contains({middle.x(), middle.y()})) << "a node hangs on an edge";
      EXPECT_LE(n, 2);
      if (n == 1) border += (b - a).norm();
    }
    EXPECT_NEAR(border, 2.2, 1e-12) << "only the border of the sheet has one triangle";
  }
}

TEST(AdaptiveTriangles, HaveNoAngleBelowHalfOfTheSmallest) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 10; ++trial) {
    AdaptiveTriangles mesh = triangles(3, 4);
    const double least = smallest_angle(mesh.rest());
    std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
    split_at_random(mesh, x, v, random);
    EXPECT_GE(smallest_angle(mesh.rest()), 0.5 * least * (1.0 - 1e-9));
  }
}

// Rivara's example: the two halves of a square share their longest edge; the halves of those meet
// their neighbours at the sides.
TEST(AdaptiveTriangles, BisectTheLongestEdgeOfBothTriangles) {
  const TriangleMesh square{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  AdaptiveTriangles mesh(square, fabric(), 1);
  std::vector<Vec3> x = square.vertices, v(4, Vec3::Zero());
  const std::int32_t first[] = {0};
  mesh.split(first, x, v);
  ASSERT_EQ(x.size(), 7u);
  EXPECT_EQ(x[4], Vec3(0.5, 0.5, 0)) << "the diagonal";
  EXPECT_EQ(mesh.rest().triangles.size(), 6u) << "four quarters and two halves";
  EXPECT_TRUE((x[5] == Vec3(0.5, 0, 0) && x[6] == Vec3(1, 0.5, 0)) ||
              (x[6] == Vec3(0.5, 0, 0) && x[5] == Vec3(1, 0.5, 0)));
  EXPECT_EQ(mesh.parents(4), (Edge{0, 2}));
  EXPECT_EQ(mesh.parents(0), (Edge{-1, -1}));
}

/// In the half (a, m, c), the edge opposite the newest vertex m is the shortest one.
TEST(AdaptiveTriangles, BisectTheLongestEdgeOfEachHalf) {
  const TriangleMesh slanted{{{0, 0, 0}, {8, 0, 0}, {1, 1, 0}}, {{0, 1, 2}}};
  AdaptiveTriangles mesh(slanted, fabric(), 1);
  std::vector<Vec3> x = slanted.vertices, v(3, Vec3::Zero());
  mesh.split(mesh.divisible(), x, v);
  EXPECT_EQ(
      x, (std::vector<Vec3>{{0, 0, 0}, {8, 0, 0}, {1, 1, 0}, {4, 0, 0}, {2, 0, 0}, {4.5, 0.5, 0}}));
}

TEST(AdaptiveTriangles, SplitEverywhereTheyAreFourTimesAsMany) {
  AdaptiveTriangles mesh = triangles(5, 2);
  std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
  for (int level = 1; level <= 2; ++level) {
    const std::size_t before = mesh.rest().triangles.size();
    const double height = smallest_angle(mesh.rest());
    mesh.split(mesh.divisible(), x, v);
    EXPECT_GE(mesh.rest().triangles.size(), 4 * before);
    EXPECT_LE(mesh.rest().triangles.size(), 5 * before) << "few more than needed";
    EXPECT_GT(smallest_angle(mesh.rest()), 0.4 * height);
  }
  EXPECT_TRUE(mesh.divisible().empty());
}

TEST(AdaptiveTriangles, ASplitKeepsMassMomentumCentreAndSurface) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  AdaptiveTriangles mesh = triangles(4, 3);
  std::vector<Vec3> x = mesh.rest().vertices, v;
  for (Vec3& p : x) {
    p += 0.05 * Vec3(noise(random), noise(random), noise(random));
    v.push_back(Vec3(noise(random), noise(random), noise(random)));
  }
  const auto sums = [&] {
    const std::vector<double> mass = mesh.cloth().mass;
    Vec3 momentum = Vec3::Zero(), moment = Vec3::Zero();
    double all = 0.0;
    for (std::size_t i = 0; i < mass.size(); ++i) {
      all += mass[i];
      momentum += mass[i] * v[i];
      moment += mass[i] * x[i];
    }
    return std::tuple(all, momentum, moment);
  };
  const std::vector<Vec3> start = x;
  const auto [mass, momentum, moment] = sums();
  split_at_random(mesh, x, v, random);
  ASSERT_GT(x.size(), 2 * start.size());
  const auto [mass_after, momentum_after, moment_after] = sums();
  EXPECT_NEAR(mass_after, mass, 1e-14);
  EXPECT_LT((momentum_after - momentum).norm(), 1e-15);
  EXPECT_LT((moment_after - moment).norm(), 1e-15);
  EXPECT_TRUE(std::equal(start.begin(), start.end(), x.begin()));
  for (std::int32_t i = static_cast<std::int32_t>(start.size()); i < mesh.vertex_count(); ++i) {
    const auto [a, b] = mesh.parents(i);
    EXPECT_EQ(x[i], Vec3(0.5 * (x[a] + x[b])));
  }
}

// A dilation by e stretches every edge by e. With k = E h ΣA/l² its energy is (3/2) E h e² A for
// any triangles: a split changes the springs, but not the fabric.
TEST(AdaptiveTriangles, HaveTheFabricsEnergyOfADilationWhateverIsSplit) {
  std::mt19937 random(4);
  AdaptiveTriangles mesh = triangles(4, 3);
  std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
  split_at_random(mesh, x, v, random);
  constexpr double e = 1e-3;
  double energy = 0.0;
  for (const Spring& s : mesh.cloth().springs) {
    const double length =
        (1.0 + e) * (mesh.rest().vertices[s.b] - mesh.rest().vertices[s.a]).norm();
    energy += 0.5 * s.stiffness * (length - s.rest_length) * (length - s.rest_length);
  }
  AdaptiveTriangles whole = triangles(4, 3);
  double before = 0.0;
  for (const Spring& s : whole.cloth().springs)
    before += 0.5 * s.stiffness * e * e * s.rest_length * s.rest_length;
  EXPECT_NEAR(energy, before, 1e-9 * before);
}

TEST(AdaptiveTriangles, AreSplitWhereTheyBendAndNowhereElse) {
  AdaptiveTriangles mesh = triangles(10, 2);
  std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
  EXPECT_TRUE(mesh.curved(x, 1e-6).empty());
  // A ridge at y = 0, where a row of vertices lies.
  for (Vec3& p : x) p.z() = -0.3 * std::abs(p.y());
  const std::vector<std::int32_t> found = mesh.curved(x, 0.3);
  ASSERT_FALSE(found.empty());
  for (const std::int32_t t : found) {
    double nearest = 1.0;
    for (const std::int32_t i : mesh.rest().triangles[t])
      nearest = std::min(nearest, std::abs(mesh.rest().vertices[i].y()));
    EXPECT_LT(nearest, 1e-12);
  }
  EXPECT_TRUE(mesh.curved(x, 0.6).empty()) << "it bends by 0.58";
}

// -- joining --------------------------------------------------------------------------------------

using Corners = std::multiset<std::array<std::pair<double, double>, 3>>;

/// The triangles by their places, however they are numbered and turned.
Corners corners_of(const TriangleMesh& mesh) {
  Corners all;
  for (const Triangle& t : mesh.triangles) {
    std::array<std::pair<double, double>, 3> places;
    for (int k = 0; k < 3; ++k) places[k] = {mesh.vertices[t[k]].x(), mesh.vertices[t[k]].y()};
    std::rotate(places.begin(), std::min_element(places.begin(), places.end()), places.end());
    all.insert(places);
  }
  return all;
}

TEST(AdaptiveTriangles, TheNodesOfAVertexAreThoseOfItsTriangles) {
  std::mt19937 random(8);
  AdaptiveTriangles mesh = triangles(4, 3);
  std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
  split_at_random(mesh, x, v, random);
  std::vector<std::set<std::int32_t>> around(x.size());
  for (const Triangle& t : mesh.rest().triangles)
    for (const std::int32_t i : t) around[i].insert(t.begin(), t.end());
  for (std::int32_t i = 0; i < mesh.vertex_count(); ++i)
    EXPECT_EQ(mesh.nodes(i), std::vector<std::int32_t>(around[i].begin(), around[i].end())) << i;
}

TEST(AdaptiveTriangles, JoinedAgainTheyAreTheFirstMesh) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 10; ++trial) {
    AdaptiveTriangles mesh = triangles(4, 3);
    const TriangleMesh first = mesh.rest();
    std::vector<Vec3> x = first.vertices, v(x.size(), Vec3::Zero());
    split_at_random(mesh, x, v, random);
    int rounds = 0;
    for (std::vector<std::int32_t> some; !(some = mesh.flat(x, 4.0, 4.0)).empty(); ++rounds)
      mesh.join(some, x, v);
    EXPECT_GT(rounds, 2);
    EXPECT_EQ(mesh.rest().vertices, first.vertices);
    EXPECT_EQ(corners_of(mesh.rest()), corners_of(first));
    EXPECT_EQ(mesh.divisible().size(), first.triangles.size());
    // And it can be split as if it never had been.
    AdaptiveTriangles other = triangles(4, 3);
    std::vector<Vec3> y = first.vertices, w(y.size(), Vec3::Zero());
    mesh.split(mesh.divisible(), x, v);
    other.split(other.divisible(), y, w);
    EXPECT_EQ(corners_of(mesh.rest()), corners_of(other.rest()));
  }
}

TEST(AdaptiveTriangles, AJoinLeavesAConformingMeshOfTheSameArea) {
  std::mt19937 random(6);
  for (int trial = 0; trial < 10; ++trial) {
    AdaptiveTriangles mesh = triangles(4, 3);
    const double whole = area(mesh.rest()), least = smallest_angle(mesh.rest());
    std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
    for (int round = 0; round < 4; ++round) {
      split_at_random(mesh, x, v, random);
      std::vector<std::int32_t> some;
      for (const std::int32_t i : mesh.flat(x, 4.0, 4.0))
        if (random() % 2 == 0) some.push_back(i);
      const std::size_t before = x.size();
      mesh.join(some, x, v);
      EXPECT_EQ(x.size() + some.size(), before);
      EXPECT_NEAR(area(mesh.rest()), whole, 1e-12);
      EXPECT_GE(smallest_angle(mesh.rest()), 0.5 * least * (1.0 - 1e-9));
      std::map<Edge, int> count;
      for (const Triangle& t : mesh.rest().triangles)
        for (int k = 0; k < 3; ++k)
          ++count[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
      double border = 0.0;
      for (const auto& [edge, n] : count)
        if (n == 1)
          border += (mesh.rest().vertices[edge[1]] - mesh.rest().vertices[edge[0]]).norm();
      EXPECT_NEAR(border, 2.2, 1e-12) << "a node hangs";
    }
  }
}

TEST(AdaptiveTriangles, AJoinKeepsMassAndMomentumAndEveryOtherVertex) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  AdaptiveTriangles mesh = triangles(4, 3);
  std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
  split_at_random(mesh, x, v, random);
  for (int round = 0; round < 4; ++round) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] += 1e-3 * Vec3(noise(random), noise(random), noise(random));
      v[i] = Vec3(noise(random), noise(random), noise(random));
    }
    const auto sums = [&] {
      const std::vector<double> mass = mesh.cloth().mass;
      Vec3 momentum = Vec3::Zero();
      double all = 0.0;
      for (std::size_t i = 0; i < mass.size(); ++i) {
        all += mass[i];
        momentum += mass[i] * v[i];
      }
      return std::pair(all, momentum);
    };
    std::vector<std::int32_t> some;
    for (const std::int32_t i : mesh.flat(x, 4.0, 4.0))
      if (random() % 3 != 0) some.push_back(i);
    ASSERT_FALSE(some.empty());
    const auto [mass, momentum] = sums();
    const std::vector<Vec3> old_x = x, flat = mesh.flattened(some, x);
    std::set<std::int32_t> leaving(some.begin(), some.end());
    for (std::int32_t i = 0; i < mesh.vertex_count(); ++i) {
      const auto [a, b] = mesh.parents(i);
      EXPECT_EQ(flat[i], leaving.contains(i) ? Vec3(0.5 * (x[a] + x[b])) : x[i]);
    }
    const std::vector<std::int32_t> number = mesh.join(some, x, v);
    const auto [mass_after, momentum_after] = sums();
    EXPECT_NEAR(mass_after, mass, 1e-14);
    EXPECT_LT((momentum_after - momentum).norm(), 1e-15);
    std::int32_t next = 0;
    for (std::size_t i = 0; i < number.size(); ++i) {
      EXPECT_EQ(number[i] < 0, leaving.contains(static_cast<std::int32_t>(i)));
      if (number[i] < 0) continue;
      EXPECT_EQ(number[i], next++);
      EXPECT_EQ(x[number[i]], old_x[i]);
    }
  }
}

TEST(AdaptiveTriangles, AreFlatWhereTheyDoNotBend) {
  AdaptiveTriangles mesh = triangles(10, 1);
  std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
  mesh.split(mesh.divisible(), x, v);
  const std::size_t all = mesh.flat(x, 1e-6, 1e-6).size();
  EXPECT_GT(all, 100u);
  for (Vec3& p : x) p.z() = -0.3 * std::abs(p.y());  // a ridge at y = 0
  const std::vector<std::int32_t> found = mesh.flat(x, 0.1, 0.4);
  EXPECT_LT(found.size(), all);
  EXPECT_GT(found.size(), all / 2);
  for (const std::int32_t i : found) EXPECT_GT(std::abs(x[i].y()), 1e-12) << "on the ridge";
  // A whole triangle that would be split at once is not joined.
  EXPECT_LE(mesh.flat(x, 4.0, 1e-9).size(), found.size());
}

// -- flat patterns as rest shapes -----------------------------------------------------------------

/// A cone and the three quarters of a flat ring that it is made of. One side of its seam is longer
/// than the other by `gathered`.
struct Skirt {
  TriangleMesh surface, pattern;
};
Skirt make_skirt(double gathered = 0.0) {
  constexpr int sides = 8, rings = 3;
  constexpr double pi = std::numbers::pi;
  const double turn = 1.5 * pi, sine = turn / (2.0 * pi), cosine = std::sqrt(1.0 - sine * sine);
  Skirt skirt;
  for (int j = 0; j <= rings; ++j)
    for (int k = 0; k <= sides; ++k) {
      const double r = 0.16 + 0.4 * j / rings, a = 2.0 * pi * k / sides, flat = turn * k / sides;
      const double here = k == sides ? (1.0 + gathered) * r : r;
      skirt.pattern.vertices.emplace_back(here * std::cos(flat), here * std::sin(flat), 0.0);
      if (k == sides) continue;
      skirt.surface.vertices.emplace_back(r * sine * std::cos(a), r * sine * std::sin(a),
                                          -r * cosine);
    }
  for (int j = 0; j < rings; ++j)
    for (int k = 0; k < sides; ++k) {
      const auto add = [&](std::array<int, 3> ring, std::array<int, 3> spoke) {
        Triangle corner, place;
        for (int i = 0; i < 3; ++i) {
          corner[i] = ring[i] * sides + spoke[i] % sides;
          place[i] = ring[i] * (sides + 1) + spoke[i];
        }
        skirt.surface.triangles.push_back(corner);
        skirt.pattern.triangles.push_back(place);
      };
      add({j, j + 1, j + 1}, {k, k, k + 1});
      add({j, j + 1, j}, {k, k + 1, k + 1});
    }
  return skirt;
}

AdaptiveTriangles sewn(const Skirt& skirt, std::int32_t levels) {
  return {skirt.surface, skirt.pattern, fabric(), levels};
}

/// The places of every vertex of the surface in the rest shape.
std::vector<std::set<std::int32_t>> places_of(const AdaptiveTriangles& mesh) {
  const ClothMesh cloth = mesh.cloth();
  std::vector<std::set<std::int32_t>> places(cloth.mass.size());
  for (std::size_t t = 0; t < cloth.surface.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      places[cloth.surface.triangles[t][k]].insert(mesh.rest().triangles[t][k]);
  return places;
}

/// Each new vertex, on every side of a seam, in the middle between the places of its parents there.
void expect_new_places_in_the_middle(const AdaptiveTriangles& mesh) {
  const auto places = places_of(mesh);
  const std::vector<Vec3>& x = mesh.rest().vertices;
  for (std::int32_t i = 0; i < mesh.vertex_count(); ++i) {
    const auto [a, b] = mesh.parents(i);
    if (a < 0) continue;
    for (const std::int32_t own : places[i]) {
      bool found = false;
      for (const std::int32_t p : places[a])
        for (const std::int32_t q : places[b]) found |= x[own] == Vec3(0.5 * (x[p] + x[q]));
      EXPECT_TRUE(found) << i;
    }
  }
}

void expect_to_conform(const TriangleMesh& mesh, int borders) {
  std::map<Edge, int> count;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      ++count[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
  std::map<std::int32_t, int> ends;  // of edges with one triangle: closed lines
  for (const auto& [edge, n] : count) {
    EXPECT_LE(n, 2);
    for (const std::int32_t end : edge) ends[end] += n == 1 ? 1 : 0;
  }
  for (const auto& [vertex, n] : ends) EXPECT_TRUE(n == 0 || n == 2) << vertex;
  const auto vertices = static_cast<int>(mesh.vertices.size()),
             edges = static_cast<int>(count.size()),
             faces = static_cast<int>(mesh.triangles.size());
  EXPECT_EQ(vertices - edges + faces, 2 - borders) << "a node hangs";
}

TEST(AdaptivePatterns, HaveTheRestLengthsOfThePatternWhateverTheSurface) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise;
  const TriangleMesh flat = make_triangular({0.6, 0.5, 4, 4}, fabric()).surface;
  TriangleMesh surface = flat;
  for (Vec3& p : surface.vertices) p += 0.1 * Vec3(noise(random), noise(random), noise(random));
  AdaptiveTriangles mesh(surface, flat, fabric(), 3), alone(flat, fabric(), 3);
  std::vector<Vec3> x = surface.vertices, v(x.size(), Vec3::Zero()), y = x, w = v;
  std::mt19937 same(12), again(12);
  split_at_random(mesh, x, v, same);
  split_at_random(alone, y, w, again);
  ASSERT_GT(x.size(), 3 * surface.vertices.size());
  EXPECT_EQ(x, y);
  const ClothMesh found = mesh.cloth(), exact = alone.cloth();
  EXPECT_EQ(found.surface.triangles, exact.surface.triangles);
  EXPECT_EQ(found.surface.vertices, x);
  for (std::size_t i = 0; i < exact.mass.size(); ++i)
    EXPECT_NEAR(found.mass[i], exact.mass[i], 1e-15);
  const auto lengths = [](const ClothMesh& cloth) {
    std::map<Edge, double> all;
    for (const Spring& s : cloth.springs)
      all[{std::min(s.a, s.b), std::max(s.a, s.b)}] = s.rest_length;
    return all;
  };
  EXPECT_EQ(lengths(found), lengths(exact));
}

TEST(AdaptivePatterns, HaveNoHangingNodeAndKeepBothSidesOfASeam) {
  for (const double gathered : {0.0, 0.3}) {
    std::mt19937 random(13);
    for (int trial = 0; trial < 5; ++trial) {
      const Skirt skirt = make_skirt(gathered);
      AdaptiveTriangles mesh = sewn(skirt, 3);
      std::vector<Vec3> x = skirt.surface.vertices, v(x.size(), Vec3::Zero());
      split_at_random(mesh, x, v, random);
      EXPECT_GT(x.size(), 4 * skirt.surface.vertices.size());
      const ClothMesh cloth = mesh.cloth();
      expect_to_conform(cloth.surface, 2);
      expect_new_places_in_the_middle(mesh);
      EXPECT_NEAR(area(mesh.rest()), area(skirt.pattern), 1e-12);
      int twice = 0;
      for (const auto& places : places_of(mesh)) {
        EXPECT_LE(places.size(), 2u);
        twice += places.size() == 2 ? 1 : 0;
      }
      EXPECT_GT(twice, 8) << "new vertices of the seam have a place on each side";
    }
  }
}

/// Three triangles around a corner. In the flat, each one's side to the next triangle is longer
/// than its side to the one before: if each edge counted by one side alone, no edge would be the
/// longest of both its triangles.
TEST(AdaptivePatterns, AreSplitWhereTheSidesOfSeamsDiffer) {
  Skirt tip{{{{0, 0, 0}, {1, 0, 0.3}, {-0.5, 0.8, 0.3}, {-0.5, -0.8, 0.3}},
             {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}},
            {}};
  for (std::int32_t k = 0; k < 3; ++k) {
    const double x = 4.0 * k;
    for (const Vec3& p : {Vec3(x, 0, 0), Vec3(x + 1, 0, 0), Vec3(x + 1, 1.7, 0)})
      tip.pattern.vertices.push_back(p);
    tip.pattern.triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  }
  AdaptiveTriangles mesh = sewn(tip, 2);
  std::vector<Vec3> x = tip.surface.vertices, v(x.size(), Vec3::Zero());
  for (int level = 0; level < 2; ++level) mesh.split(mesh.divisible(), x, v);
  EXPECT_GE(mesh.rest().triangles.size(), 48u);
  expect_to_conform(mesh.cloth().surface, 1);
  expect_new_places_in_the_middle(mesh);
  EXPECT_NEAR(area(mesh.rest()), area(tip.pattern), 1e-12);
}

TEST(AdaptivePatterns, HaveNoAngleBelowHalfOfTheSmallest) {
  std::mt19937 random(14);
  const Skirt skirt = make_skirt();
  const double least = smallest_angle(skirt.pattern);
  AdaptiveTriangles mesh = sewn(skirt, 4);
  std::vector<Vec3> x = skirt.surface.vertices, v(x.size(), Vec3::Zero());
  split_at_random(mesh, x, v, random);
  EXPECT_GE(smallest_angle(mesh.rest()), 0.5 * least * (1.0 - 1e-9));
}

/// Of finite elements, whose strain is that of the whole triangle in each part.
TEST(AdaptivePatterns, ASplitKeepsMassMomentumCentreAndTheEnergyOfTheStretch) {
  std::mt19937 random(15);
  std::normal_distribution<double> noise;
  Material m = fabric();
  m.stretch_law = "corotated";
  const Skirt skirt = make_skirt(0.2);
  AdaptiveTriangles mesh(skirt.surface, skirt.pattern, m, 3);
  std::vector<Vec3> x = skirt.surface.vertices, v;
  for (Vec3& p : x) {
    p += 0.02 * Vec3(noise(random), noise(random), noise(random));
    v.push_back(Vec3(noise(random), noise(random), noise(random)));
  }
  const auto sums = [&] {
    const ClothMesh cloth = mesh.cloth();
    Vec3 momentum = Vec3::Zero(), moment = Vec3::Zero();
    double all = 0.0;
    for (std::size_t i = 0; i < cloth.mass.size(); ++i) {
      all += cloth.mass[i];
      momentum += cloth.mass[i] * v[i];
      moment += cloth.mass[i] * x[i];
    }
    const double energy =
        make_membrane_force(cloth.membranes, cloth.membranes.front().strain, x.size())
            ->energy({x, v, cloth.mass, 0.0});
    return std::tuple(all, momentum, moment, energy);
  };
  const auto [mass, momentum, moment, energy] = sums();
  EXPECT_NEAR(mass, m.density * area(skirt.pattern), 1e-14);
  split_at_random(mesh, x, v, random);
  const auto [mass_after, momentum_after, moment_after, energy_after] = sums();
  EXPECT_NEAR(mass_after, mass, 1e-14);
  EXPECT_LT((momentum_after - momentum).norm(), 1e-14);
  EXPECT_LT((moment_after - moment).norm(), 1e-14);
  EXPECT_NEAR(energy_after, energy, 1e-10 * energy);
}

TEST(AdaptivePatterns, JoinedAgainTheyAreTheFirstMesh) {
  for (const double gathered : {0.0, 0.3}) {
    std::mt19937 random(16);
    const Skirt skirt = make_skirt(gathered);
    AdaptiveTriangles mesh = sewn(skirt, 3);
    std::vector<Vec3> x = skirt.surface.vertices, v(x.size(), Vec3(1.0, 2.0, 3.0));
    for (int round = 0; round < 3; ++round) {
      split_at_random(mesh, x, v, random);
      std::vector<std::int32_t> some;
      for (const std::int32_t i : mesh.flat(x, 4.0, 4.0))
        if (random() % 2 == 0) some.push_back(i);
      mesh.join(some, x, v);
      expect_to_conform(mesh.cloth().surface, 2);
      expect_new_places_in_the_middle(mesh);
    }
    for (std::vector<std::int32_t> some; !(some = mesh.flat(x, 4.0, 4.0)).empty();)
      mesh.join(some, x, v);
    EXPECT_EQ(x, skirt.surface.vertices);
    EXPECT_EQ(mesh.cloth().surface.vertices, skirt.surface.vertices);
    EXPECT_EQ(mesh.rest().vertices, skirt.pattern.vertices);
    EXPECT_EQ(corners_of(mesh.rest()), corners_of(skirt.pattern));
    EXPECT_EQ(corners_of(mesh.cloth().surface), corners_of(skirt.surface));
    for (const Vec3& u : v) EXPECT_LT((u - Vec3(1.0, 2.0, 3.0)).norm(), 1e-13);
  }
}

TEST(AdaptiveTriangles, BadInputIsRefused) {
  EXPECT_THROW(triangles(4, 7), std::invalid_argument);
  EXPECT_THROW(triangles(4, -1), std::invalid_argument);
  AdaptiveTriangles mesh = triangles(2, 1);
  std::vector<Vec3> x = mesh.rest().vertices, v(x.size(), Vec3::Zero());
  const std::int32_t beyond[] = {1000};
  EXPECT_THROW(mesh.split(beyond, x, v), std::invalid_argument);
  const TriangleMesh fan{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, -1, 0}},
                         {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}}};
  EXPECT_THROW(AdaptiveTriangles(fan, fabric(), 1), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::adaptive_triangles_test
