// SPDX-License-Identifier: MIT
//
// Detection on plain arrays against brute force over all pairs of primitives, decided by the judge.
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/types.h>
#include <selvedge/detection/find.h>
#include <selvedge/judge/judge.h>
#include <selvedge/narrowphase/distance.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "broad_phase_trial.h"

namespace selvedge::detection_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Mesh {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Triangle> triangles;

  MovingSurface moving() const { return {x_t0, x_t1, triangles}; }
  SurfaceState state() const { return {x_t0, triangles}; }
};

/// Vertices on a coarse lattice, so that touching, overlap in a plane and degenerate triangles are
/// frequent; `lattice` 0: anywhere. The last vertex belongs to no triangle.
Mesh random_mesh(Random& random, int vertices, int triangles, int lattice) {
  const auto point = [&] {
    if (lattice == 0) return random.vector(1.0);
    return Vec3(random.integer(0, lattice), random.integer(0, lattice), random.integer(0, lattice));
  };
  Mesh mesh;
  for (int i = 0; i < vertices; ++i) {
    mesh.x_t0.push_back(point());
    mesh.x_t1.push_back(random.integer(0, 2) == 0 ? mesh.x_t0.back() : point());
  }
  for (int t = 0; t < triangles; ++t)
    mesh.triangles.push_back({random.integer(0, vertices - 2), random.integer(0, vertices - 2),
                              random.integer(0, vertices - 2)});
  return mesh;
}

using Primitives = std::tuple<ContactKind, std::int32_t, std::int32_t>;
using Timed = std::set<std::tuple<Primitives, double>>;

Primitives primitives_of(const PrimitivePair& pair) {
  return {pair.kind, pair.primitive_a, pair.primitive_b};
}

template <class Found>
std::set<Primitives> primitives_of(const std::vector<Found>& found) {
  std::set<Primitives> all;
  for (const Found& f : found) all.insert(primitives_of(f));
  EXPECT_EQ(all.size(), found.size()) << "a pair is reported twice";
  return all;
}

Timed timed(const std::vector<Collision>& found) {
  Timed all;
  for (const Collision& c : found) all.insert({primitives_of(c), c.toi});
  return all;
}

/// Calls visit(kind, primitive_a, primitive_b, points of the four vertices at t0, at t1) for all
/// pairs of primitives; without those that share a vertex if both meshes are the same object.
template <class Visit>
void visit_pairs(const Mesh& a, const Mesh& b, Visit visit) {
  const bool self = &a == &b;
  const auto offer = [&](ContactKind kind, std::int32_t i, std::int32_t j, const Mesh& first,
                         std::vector<std::int32_t> f, const Mesh& second,
                         std::vector<std::int32_t> s) {
    if (self)
      for (const std::int32_t v : f)
        if (std::find(s.begin(), s.end(), v) != s.end()) return;
    std::array<Vec3, 8> x;
    std::size_t k = 0;
    for (const std::int32_t v : f) x[k] = first.x_t0[v], x[4 + k++] = first.x_t1[v];
    for (const std::int32_t v : s) x[k] = second.x_t0[v], x[4 + k++] = second.x_t1[v];
    visit(kind, i, j, x);
  };
  const auto points_against_triangles = [&](const Mesh& p, const Mesh& q, bool swapped) {
    std::set<std::int32_t> used;
    for (const Triangle& t : p.triangles) used.insert(t.begin(), t.end());
    for (const std::int32_t v : used)
      for (std::size_t t = 0; t < q.triangles.size(); ++t) {
        const auto index = static_cast<std::int32_t>(t);
        const Triangle& corners = q.triangles[t];
        offer(swapped ? ContactKind::triangle_point : ContactKind::point_triangle,
              swapped ? index : v, swapped ? v : index, p, {v}, q,
              {corners[0], corners[1], corners[2]});
      }
  };
  points_against_triangles(a, b, false);
  if (!self) points_against_triangles(b, a, true);
  const std::vector<Edge> edges_a = unique_edges(a.triangles), edges_b = unique_edges(b.triangles);
  for (std::size_t i = 0; i < edges_a.size(); ++i)
    for (std::size_t j = self ? i + 1 : 0; j < edges_b.size(); ++j)
      offer(ContactKind::edge_edge, static_cast<std::int32_t>(i), static_cast<std::int32_t>(j), a,
            {edges_a[i][0], edges_a[i][1]}, b, {edges_b[j][0], edges_b[j][1]});
}

/// What the judge finds, with the largest double not later than the time of impact.
Timed judged_collisions(const Mesh& a, const Mesh& b) {
  Timed all;
  visit_pairs(a, b, [&](ContactKind kind, auto i, auto j, const std::array<Vec3, 8>& x) {
    const auto path =
        kind == ContactKind::edge_edge ? PathKind::edge_edge : PathKind::point_triangle;
    if (const std::optional<TouchTime> time = first_touch(path, x))
      all.insert({{kind, i, j}, time->lo});
  });
  return all;
}

/// The judge counts the same pairs and names the same first ones.
void expect_as_judged(const TriangleMeetings& found, std::size_t crossings,
                      const std::vector<std::pair<std::int32_t, std::int32_t>>& first,
                      std::size_t touches) {
  EXPECT_EQ(found.crossings.size(), crossings);
  EXPECT_EQ(found.touches.size(), touches);
  for (std::size_t i = 0; i < std::min(first.size(), found.crossings.size()); ++i)
    EXPECT_EQ(std::pair(found.crossings[i].triangle_a, found.crossings[i].triangle_b), first[i]);
}

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no std::invalid_argument";
}

class Trials : public ::testing::TestWithParam<int> {};  // the lattice of random_mesh
INSTANTIATE_TEST_SUITE_P(Lattices, Trials, ::testing::Values(0, 2, 5));

TEST_P(Trials, CollisionsBetweenTwoSurfacesAreThoseOfTheJudge) {
  std::size_t found = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const Mesh a = random_mesh(random, 8, 6, GetParam()), b = random_mesh(random, 9, 7, GetParam());
    const Timed expected = judged_collisions(a, b);
    EXPECT_EQ(timed(find_collisions(a.moving(), b.moving())), expected) << "seed " << seed;
    found += expected.size();
  }
  EXPECT_GT(found, 100u);
}

TEST_P(Trials, CollisionsOfOneSurfaceAreThoseOfTheJudge) {
  std::size_t found = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const Mesh a = random_mesh(random, 12, 10, GetParam());
    const Timed expected = judged_collisions(a, a);
    EXPECT_EQ(timed(find_collisions(a.x_t0, a.x_t1, a.triangles)), expected) << "seed " << seed;
    found += expected.size();
  }
  EXPECT_GT(found, 100u);
}

TEST_P(Trials, EveryConservativeBroadPhaseLeadsToTheSameCollisions) {
  for (unsigned seed = 21; seed <= 24; ++seed) {
    Random random(seed);
    const Mesh a = random_mesh(random, 8, 6, GetParam()), b = random_mesh(random, 9, 7, GetParam());
    const Timed between = timed(find_collisions(a.moving(), b.moving()));
    const Timed self = timed(find_collisions(b.x_t0, b.x_t1, b.triangles));
    for (const auto& [name, make] : broad_phases()) {
      const BroadPhaseTraits traits = make()->traits();
      if (traits.guarantee != Guarantee::conservative || traits.closed_body_only) continue;
      const DetectionConfig config{.broad_phase = name};
      EXPECT_EQ(timed(find_collisions(a.moving(), b.moving(), config)), between)
          << name << ", seed " << seed;
      if (traits.self) {
        EXPECT_EQ(timed(find_collisions(b.x_t0, b.x_t1, b.triangles, config)), self)
            << name << ", seed " << seed;
      }
    }
  }
}

TEST_P(Trials, CollisionsAreSymmetricUnderASwapOfTheSurfaces) {
  for (unsigned seed = 31; seed <= 36; ++seed) {
    Random random(seed);
    const Mesh a = random_mesh(random, 8, 6, GetParam()), b = random_mesh(random, 9, 7, GetParam());
    Timed swapped;
    for (const Collision& c : find_collisions(b.moving(), a.moving())) {
      const ContactKind kind = c.kind == ContactKind::point_triangle   ? ContactKind::triangle_point
                               : c.kind == ContactKind::triangle_point ? ContactKind::point_triangle
                                                                       : ContactKind::edge_edge;
      swapped.insert({{kind, c.primitive_b, c.primitive_a}, c.toi});
    }
    EXPECT_EQ(swapped, timed(find_collisions(a.moving(), b.moving()))) << "seed " << seed;
  }
}

TEST_P(Trials, CrossingsAreThoseOfTheJudge) {
  std::size_t found = 0;
  for (unsigned seed = 41; seed <= 60; ++seed) {
    Random random(seed);
    const Mesh a = random_mesh(random, 8, 6, GetParam());
    const Mesh b = random_mesh(random, 12, 10, GetParam());
    SCOPED_TRACE(seed);
    const TriangleMeetings between = find_meetings(a.state(), b.state());
    const TriangleMeetings self = find_meetings(b.x_t0, b.triangles);
    const Verdict of_a = judge({a.x_t0, a.triangles}, {b.x_t0, b.triangles}, {});
    const Verdict of_b = judge({b.x_t0, b.triangles}, {}, {});
    expect_as_judged(between, of_a.body_intersections, of_a.first_body, of_a.body_touches);
    expect_as_judged(self, of_b.self_intersections, of_b.first_self, of_b.self_touches);
    EXPECT_EQ(find_crossings(a.state(), b.state()), between.crossings);
    EXPECT_EQ(find_crossings(b.x_t0, b.triangles), self.crossings);
    found += between.all().size() + self.all().size();
  }
  EXPECT_GT(found, 100u);
}

TEST_P(Trials, ContactsAreThePairsNearerThanTheDistance) {
  const double distance = GetParam() == 0 ? 0.3 : 0.75;
  for (unsigned seed = 61; seed <= 70; ++seed) {
    Random random(seed);
    const Mesh a = random_mesh(random, 8, 6, GetParam()), b = random_mesh(random, 9, 7, GetParam());
    for (const Mesh* other : {&b, &a}) {
      const auto found = other == &a ? find_contacts(a.x_t0, a.triangles, distance)
                                     : find_contacts(a.state(), b.state(), distance);
      std::set<Primitives> expected;
      visit_pairs(a, *other, [&](ContactKind kind, auto i, auto j, const auto& x) {
        const ClosestPoints near = kind == ContactKind::edge_edge
                                       ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                       : point_triangle_closest(x[0], x[1], x[2], x[3]);
        if (near.distance < distance) expected.insert({kind, i, j});
      });
      EXPECT_EQ(primitives_of(found), expected) << "seed " << seed;
      EXPECT_TRUE(std::is_sorted(found.begin(), found.end(),
                                 [](const auto& p, const auto& q) { return p.gap < q.gap; }));
    }
  }
}

TEST(Collisions, AreSortedByTimeAndNameVerticesWeightsAndNormal) {
  // A triangle falls flat through a larger one at rest; one of its corners is lower.
  const std::vector<Vec3> start = {{0, 0, 1}, {1, 0, 1}, {0, 1, 0.5}};
  const std::vector<Vec3> end = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1.5}};
  const std::vector<Vec3> ground = {{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const std::vector<Collision> found =
      find_collisions({start, end, triangles}, {ground, ground, triangles});
  ASSERT_EQ(found.size(), 3u);
  const Collision& first = found[0];
  EXPECT_EQ(first.kind, ContactKind::point_triangle);
  EXPECT_EQ(first.primitive_a, 2);
  EXPECT_EQ(first.primitive_b, 0);
  EXPECT_EQ(first.vertex, (std::array<std::int32_t, 4>{2, 0, 1, 2}));
  EXPECT_EQ(first.toi, 0.25);
  EXPECT_NEAR((first.normal - Vec3::UnitZ()).norm(), 0.0, 1e-12);
  const Vec3 on_triangle =
      -(first.weight[1] * ground[0] + first.weight[2] * ground[1] + first.weight[3] * ground[2]);
  EXPECT_NEAR((on_triangle - Vec3(0, 1, 0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(found[1].toi, 0.5);
  EXPECT_EQ(found[1].primitive_a, 0);
  EXPECT_EQ(found[2].toi, 0.5);
  EXPECT_EQ(found[2].primitive_a, 1);
}

TEST(Collisions, TouchingAtTheLastInstantCounts) {
  const std::vector<Vec3> start = {{0, 0, 1}, {1, 0, 2}, {0, 1, 2}};
  std::vector<Vec3> end = {{0, 0, 0}, {1, 0, 1}, {0, 1, 1}};
  const std::vector<Vec3> ground = {{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const auto found = find_collisions({start, end, triangles}, {ground, ground, triangles});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].toi, 1.0);
  end[0].z() = std::numeric_limits<double>::denorm_min();
  EXPECT_TRUE(find_collisions({start, end, triangles}, {ground, ground, triangles}).empty());
}

TEST(Collisions, NeighboursOfOneSurfaceAreOmitted) {
  // Two triangles with a common edge fold onto each other.
  const std::vector<Vec3> start = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}};
  const std::vector<Vec3> end = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 0, 0}};
  const std::vector<Triangle> triangles = {{0, 2, 1}, {0, 1, 3}};
  for (const Collision& c : find_collisions(start, end, triangles)) {
    const std::set<std::int32_t> vertices(c.vertex.begin(), c.vertex.end());
    EXPECT_EQ(vertices.size(), 4u);
  }
  EXPECT_EQ(find_crossings(end, triangles).size(), 1u) << "they overlap in area";
}

TEST(Collisions, WithASeparationIncludeWhatPassesWithinIt) {
  const std::vector<Vec3> start = {{0, 0, 1}, {1, 0, 2}, {0, 1, 2}};
  const std::vector<Vec3> end = {{0, 0, 0.125}, {1, 0, 1}, {0, 1, 1}};
  const std::vector<Vec3> ground = {{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const MovingSurface a{start, end, triangles}, b{ground, ground, triangles};
  EXPECT_TRUE(find_collisions(a, b).empty());
  EXPECT_TRUE(find_collisions(a, b, {.min_separation = 0.1}).empty());
  EXPECT_EQ(find_collisions(a, b, {.min_separation = 0.125}).size(), 1u);
}

TEST(Collisions, AtExactlyTheSeparationAreFoundWithEveryBroadPhase) {
  Random random(7);
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  for (int trial = 0; trial < 100; ++trial) {
    const double z = random.uniform(1.0, 2.0), separation = random.uniform(0.1, 0.9);
    double low = z + separation;
    if (low - z > separation) low = std::nextafter(low, z);  // the difference is exact
    const std::vector<Vec3> ground = {{-1, -1, z}, {3, -1, z}, {-1, 3, z}};
    const std::vector<Vec3> start = {{0, 0, 9}, {1, 0, 9}, {0, 1, 9}};
    const std::vector<Vec3> end = {{0, 0, low}, {1, 0, 8}, {0, 1, 8}};
    const MovingSurface a{start, end, triangles}, b{ground, ground, triangles};
    for (const auto& [name, make] : broad_phases()) {
      const BroadPhaseTraits traits = make()->traits();
      if (traits.guarantee != Guarantee::conservative || traits.closed_body_only) continue;
      EXPECT_EQ(find_collisions(a, b, {.broad_phase = name, .min_separation = separation}).size(),
                1u)
          << name << ", trial " << trial;
    }
  }
}

TEST(Contacts, GiveGapNormalAndWeights) {
  const std::vector<Vec3> high = {{0, 0, 0.25}, {1, 0, 2}, {0, 1, 2}};
  const std::vector<Vec3> ground = {{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const auto found = find_contacts({high, triangles}, {ground, triangles}, 0.3);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, ContactKind::point_triangle);
  EXPECT_DOUBLE_EQ(found[0].gap, 0.25);
  EXPECT_NEAR((found[0].normal - Vec3::UnitZ()).norm(), 0.0, 1e-12);
  EXPECT_NEAR(found[0].weight[1] + found[0].weight[2] + found[0].weight[3], -1.0, 1e-12);
  EXPECT_TRUE(find_contacts({high, triangles}, {ground, triangles}, 0.25).empty());
}

TEST(Detection, OfEmptySurfacesFindsNothing) {
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const MovingSurface none{}, some{x, x, triangles};
  EXPECT_TRUE(find_collisions(std::span<const Vec3>(), {}, {}).empty());
  EXPECT_TRUE(find_collisions(none, none).empty());
  EXPECT_TRUE(find_collisions(none, some).empty());
  EXPECT_TRUE(find_collisions(some, none).empty());
  EXPECT_TRUE(find_crossings({}, {x, triangles}).empty());
  EXPECT_TRUE(find_crossings(std::span<const Vec3>(), {}).empty());
  EXPECT_TRUE(find_contacts({x, triangles}, {}, 1.0).empty());
}

TEST(Detection, NamesTheIndexAndTheValueOfBadInput) {
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Triangle> good = {{0, 1, 2}}, high = {{0, 1, 2}, {0, 3, 1}}, low = {{0, -1, 2}};
  std::vector<Vec3> shorter = x, not_finite = x;
  shorter.pop_back();
  not_finite[1].y() = kInfinity;
  const MovingSurface b{x, x, good};
  EXPECT_EQ(message_of([&] {
              find_collisions({x, x, high}, b);
            }),
            "a: triangles[1] has the index 3; it must be in [0, 3)");
  EXPECT_EQ(message_of([&] {
              find_collisions(b, {x, x, low});
            }),
            "b: triangles[0] has the index -1; it must be in [0, 3)");
  EXPECT_EQ(message_of([&] { find_collisions(x, shorter, good); }),
            "surface: x_t0 has 3 vertices, x_t1 has 2");
  EXPECT_EQ(message_of([&] { find_collisions(x, not_finite, good); }),
            "surface: x_t1[1] is (1.000000, inf, 0.000000); coordinates must be finite");
  EXPECT_EQ(message_of([&] { find_crossings(not_finite, good); }),
            "surface: x[1] is (1.000000, inf, 0.000000); coordinates must be finite");
  EXPECT_EQ(message_of([&] {
              find_contacts({x, good}, {x, high}, 0.1);
            }),
            "b: triangles[1] has the index 3; it must be in [0, 3)");
  EXPECT_EQ(message_of([&] { find_contacts(x, good, 0.0); }),
            "distance is 0.000000 m; it must be finite and positive");
  EXPECT_EQ(message_of([&] { find_contacts(x, good, kInfinity); }),
            "distance is inf m; it must be finite and positive");
}

TEST(Detection, RefusesAMissingOrUnsuitableMethod) {
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const auto message = [&](const DetectionConfig& config) {
    return message_of([&] { find_collisions(x, x, triangles, config); });
  };
  EXPECT_NE(message({.broad_phase = "bvh"}).find("there is no \"bvh\""), std::string::npos);
  EXPECT_NE(message({.broad_phase = "bvh"}).find("bvh_aabb"), std::string::npos);
  EXPECT_NE(message({.narrow_phase = "ccd"}).find("ccd_exact"), std::string::npos);
  EXPECT_NE(message({.broad_phase = "minimal_enclosure"}).find("minimal_enclosure cannot"),
            std::string::npos);
  EXPECT_NE(message({.narrow_phase = "ccd_cubic", .min_separation = 0.1}).find("min_separation"),
            std::string::npos);
  EXPECT_NE(message({.min_separation = -1.0}).find("min_separation is -1"), std::string::npos);
  EXPECT_NE(message({.min_separation = kInfinity}).find("min_separation is inf"),
            std::string::npos);
}

TEST(Detection, WithMethodsOfTheCallerFindsTheSameFromCallToCall) {
  Random random(31);
  const auto broad = broad_phases().at("voxel")({{"voxel", 2.5}});
  const auto narrow = narrow_phases().at("ccd_exact")();
  const DetectionMethods methods{*broad, *narrow};
  for (int call = 0; call < 3; ++call) {
    const Mesh a = random_mesh(random, 8, 6, 0), b = random_mesh(random, 9, 7, 0);
    EXPECT_EQ(timed(find_collisions(methods, a.moving(), b.moving())),
              timed(find_collisions(a.moving(), b.moving())));
    EXPECT_EQ(timed(find_collisions(methods, a.moving())),
              timed(find_collisions(a.x_t0, a.x_t1, a.triangles)));
  }
}

TEST(Detection, CandidatesContainEveryCollisionAndNoVertexOfNoTriangle) {
  Random random(32);
  const auto broad = make_bvh_aabb();
  const Mesh a = random_mesh(random, 20, 16, 0), b = random_mesh(random, 20, 16, 0);
  const CandidatePairs pairs = find_candidates(*broad, a.moving(), b.moving());
  for (const Collision& c : find_collisions(a.moving(), b.moving())) {
    const PointTrianglePair forward{c.primitive_a, c.primitive_b};
    const PointTrianglePair backward{c.primitive_b, c.primitive_a};
    const EdgeEdgePair edges{c.primitive_a, c.primitive_b};
    EXPECT_TRUE(c.kind == ContactKind::point_triangle
                    ? std::ranges::binary_search(pairs.point_triangle, forward)
                : c.kind == ContactKind::triangle_point
                    ? std::ranges::binary_search(pairs.triangle_point, backward)
                    : std::ranges::binary_search(pairs.edge_edge, edges));
  }
  for (const PointTrianglePair& pair : pairs.point_triangle) EXPECT_NE(pair.point, 19);
  EXPECT_GT(find_candidates(*broad, a.moving(), 0.5).size(),
            find_candidates(*broad, a.moving()).size());
  EXPECT_NE(message_of([&] { find_candidates(*broad, a.moving(), -1.0); }).find("distance is -1"),
            std::string::npos);
}

TEST(TrianglesOfEdges, ListsEachTriangleOnceAtEachOfItsEdges) {
  const std::vector<Triangle> triangles = {{0, 1, 2}, {2, 1, 3}, {3, 3, 1}};
  const std::vector<Edge> edges = unique_edges(triangles);
  const TrianglesOfEdges at_edge(edges, triangles);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    std::vector<std::int32_t> expected;
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (const Edge& own : unique_edges(std::span(triangles).subspan(t, 1)))
        if (own == edges[e]) expected.push_back(static_cast<std::int32_t>(t));
    const auto found = at_edge.at(static_cast<std::int32_t>(e));
    EXPECT_EQ(std::vector<std::int32_t>(found.begin(), found.end()), expected) << "edge " << e;
  }
}

}  // namespace
}  // namespace selvedge::detection_test
