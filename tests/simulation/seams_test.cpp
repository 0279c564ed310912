// SPDX-License-Identifier: MIT
//
// Surfaces whose parts lie against each other without common vertices count as one.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/simulation/contacts/detail/contact_filter.h>
#include <selvedge/simulation/contacts/detail/surface_union.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "seam_scenes.h"

namespace selvedge::seams_test {
namespace {

constexpr double kGap = 0.002;             // m, rest gap
constexpr double kTolerance = 0.1 * kGap;  // m

double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * std::ldexp(static_cast<double>(random() >> 11U), -53);
}

/// A point, vertex 0, above triangles.
struct Place {
  std::vector<Vec3> x{Vec3::Zero()};
  std::vector<Triangle> triangles;

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto n = static_cast<std::int32_t>(x.size());
    x.insert(x.end(), {a, b, c});
    triangles.push_back({n, n + 1, n + 2});
  }
  /// The parallelogram low, low + u, low + v, in two triangles with four vertices.
  void add_quad(const Vec3& low, const Vec3& u, const Vec3& v) {
    const auto n = static_cast<std::int32_t>(x.size());
    x.insert(x.end(), {low, low + u, low + u + v, low + v});
    triangles.push_back({n, n + 1, n + 2});
    triangles.push_back({n, n + 2, n + 3});
  }
  ContactPoint contact(const Triangle& t) const {
    const ClosestPoints near = point_triangle_closest(x[0], x[t[0]], x[t[1]], x[t[2]]);
    ContactPoint c;
    c.vertex = {0, t[0], t[1], t[2]};
    c.weight = near.weight;
    c.normal = near.separation / near.distance;
    c.gap = near.distance;
    return c;
  }
  /// The contacts with triangles within 4 rest gaps that stay, by common vertices and by geometry.
  std::vector<ContactPoint> stay(std::span<const std::int32_t> surface = {},
                                 std::span<const char> collides = {}) const {
    detail::SurfaceUnion all(triangles);
    all.fit(x);
    const detail::ContactFilter filter(x.size(), triangles);
    std::vector<ContactPoint> out;
    for (const Triangle& t : triangles) {
      ContactPoint c = contact(t);
      if (c.gap < 4.0 * kGap && filter.is_true_point_contact(c, x) &&
          all.is_true_contact(c, x, {kTolerance, surface, collides, {}}))
        out.push_back(c);
    }
    return out;
  }
  double nearest() const {
    double least = 1.0;
    for (const Triangle& t : triangles) least = std::min(least, contact(t).gap);
    return least;
  }
};

/// A plane of triangles with vertices of their own, moved at random.
Place broken_plane(std::mt19937_64& random, double noise) {
  Place place;
  const double cell = uniform(random, 0.01, 0.1);
  const auto moved = [&](double i, double j) {
    return Vec3(cell * i + uniform(random, -noise, noise),
                cell * j + uniform(random, -noise, noise), uniform(random, -noise, noise));
  };
  for (int i = -2; i < 2; ++i)
    for (int j = -2; j < 2; ++j) {
      place.add(moved(i, j), moved(i + 1, j), moved(i + 1, j + 1));
      place.add(moved(i, j), moved(i + 1, j + 1), moved(i, j + 1));
    }
  place.x[0] = {uniform(random, -1.5, 1.5) * cell, uniform(random, -1.5, 1.5) * cell,
                kGap * uniform(random, 0.2, 2.0)};
  return place;
}

TEST(SurfaceUnion, APlaneInPiecesPushesAlongItsNormalOnly) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    std::mt19937_64 random(seed);
    const double noise = std::pow(10.0, uniform(random, -12.0, std::log10(5e-5)));
    Place place = broken_plane(random, noise);
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(Eigen::AngleAxisd(uniform(random, 0.0, 3.0), Vec3::UnitX())) *
        Eigen::AngleAxisd(uniform(random, 0.0, 3.0), Vec3::UnitY());
    for (Vec3& x : place.x) x = turn * x;
    const std::vector<ContactPoint> stay = place.stay();
    ASSERT_FALSE(stay.empty()) << "seed " << seed;
    double least = 1.0;
    for (const ContactPoint& c : stay) {
      EXPECT_GT(c.normal.dot(turn * Vec3::UnitZ()), 0.999) << "seed " << seed << " noise " << noise;
      least = std::min(least, c.gap);
    }
    EXPECT_NEAR(least, place.nearest(), 3.0 * noise + 1e-12) << "seed " << seed;
  }
}

/// A plane of triangles round an apex, the last of which meets the first at the apex alone, and a
/// point near that slit, away from the rim.
Place plane_with_slit(std::mt19937_64& random, double noise) {
  Place place;
  const int n = 4 + static_cast<int>(random() % 29);
  const double radius = uniform(random, 0.02, 2.0);
  place.x.emplace_back(0.0, 0.0, 0.0);
  for (std::int32_t k = 0; k <= n; ++k) {
    const double a = 2.0 * std::numbers::pi * (k % n) / n;
    place.x.push_back(radius * Vec3(std::cos(a), std::sin(a), 0.0) +
                      Vec3(0.0, uniform(random, -noise, noise), uniform(random, -noise, noise)));
    if (k > 0) place.triangles.push_back({1, k + 1, k + 2});
  }
  place.x[0] = {uniform(random, 0.0, 0.5) * radius, kGap * uniform(random, -1.5, 1.5),
                kGap * uniform(random, 0.2, 2.0)};
  return place;
}

TEST(SurfaceUnion, ASlitThatEndsInsidePushesAlongTheNormalOnly) {
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    std::mt19937_64 random(seed);
    const double noise = std::pow(10.0, uniform(random, -12.0, std::log10(5e-5)));
    const Place place = plane_with_slit(random, seed % 8 == 0 ? 0.0 : noise);
    const std::vector<ContactPoint> stay = place.stay();
    ASSERT_FALSE(stay.empty()) << "seed " << seed;
    double least = 1.0;
    for (const ContactPoint& c : stay) {
      EXPECT_GT(c.normal.z(), 0.999) << "seed " << seed << " noise " << noise;
      least = std::min(least, c.gap);
    }
    EXPECT_NEAR(least, place.nearest(), 3.0 * noise + 1e-12) << "seed " << seed;
  }
}

TEST(SurfaceUnion, AStepAboveTheToleranceStaysAnObstacle) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    std::mt19937_64 random(seed);
    const double step = uniform(random, 1.02 * kTolerance, kGap);
    Place place;
    place.add_quad({-1, -1, 0}, {1, 0, 0}, {0, 2, 0});
    place.add_quad({0, -1, step}, {1, 0, 0}, {0, 2, 0});
    place.x[0] = {-uniform(random, 0.5, 1.5) * kGap, 0.01, uniform(random, 1.0, 1.5) * kGap};
    const std::vector<ContactPoint> stay = place.stay();
    const bool met = std::any_of(stay.begin(), stay.end(),
                                 [](const ContactPoint& c) { return c.normal.x() < -0.1; });
    EXPECT_TRUE(met) << "seed " << seed;
  }
}

TEST(SurfaceUnion, AStepBelowTheToleranceLiftsAndDoesNotPushBack) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    std::mt19937_64 random(seed);
    const double step = uniform(random, 0.0, 0.98 * kTolerance);
    Place place;
    place.add_quad({-1, -1, 0}, {1, 0, 0}, {0, 2, 0});
    place.add_quad({0, -1, step}, {1, 0, 0}, {0, 2, 0});
    place.x[0] = {uniform(random, -1.5, 0.5) * kGap, 0.01, uniform(random, 0.5, 1.5) * kGap};
    for (const ContactPoint& c : place.stay())
      EXPECT_GT(c.normal.z(), 1.0 - 1e-12) << "seed " << seed;
  }
}

TEST(SurfaceUnion, FloorAndWallOfAConcaveCornerBothStay) {
  for (const double gap : {0.0, 1e-9, 1e-5, -1e-3}) {  // between the wall's foot and the floor
    Place place;
    place.add_quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    place.add_quad({0, -1, gap}, {0, 2, 0}, {0, 0, 1});
    place.x[0] = {-0.7 * kGap, 0.01, 0.9 * kGap};
    bool floor = false, wall = false;
    for (const ContactPoint& c : place.stay()) {
      floor = floor || c.normal.z() > 0.999;
      wall = wall || c.normal.x() < -0.999;
    }
    EXPECT_TRUE(floor && wall) << gap;
  }
}

TEST(SurfaceUnion, ThePointBetweenTwoPlatesIsHeldByBoth) {
  Place place;
  place.add_quad({0, -1, 0}, {1, 0, 0}, {0, 2, 0});
  place.add_quad({-1, -1, 0.6 * kTolerance}, {3, 0, 1e-5}, {0, 2, 0});
  place.x[0] = {-0.1 * kTolerance, 0.01, 0.3 * kTolerance};
  const std::vector<ContactPoint> stay = place.stay();
  EXPECT_TRUE(
      std::any_of(stay.begin(), stay.end(), [](const auto& c) { return c.normal.z() > 0; }));
  EXPECT_TRUE(
      std::any_of(stay.begin(), stay.end(), [](const auto& c) { return c.normal.z() < 0; }));
}

TEST(SurfaceUnion, FacesThatThePieceDoesNotMeetDoNotCount) {
  Place place;
  place.add_quad({0, -1, 0}, {1, 0, 0}, {0, 2, 0});
  place.add_quad({-1, -1, 0}, {1, 0, 0}, {0, 2, 0});
  place.x[0] = {-kGap, 0.01, kGap};
  std::vector<std::int32_t> surface(place.x.size(), 0);
  for (std::size_t i = 5; i < surface.size(); ++i) surface[i] = 1;
  const auto rim = [](const auto& c) { return c.normal.x() < -0.5; };
  const std::vector<ContactPoint> both = place.stay(),
                                  one = place.stay(surface, std::array{'\1', '\0'});
  EXPECT_TRUE(std::none_of(both.begin(), both.end(), rim));
  EXPECT_TRUE(std::any_of(one.begin(), one.end(), rim));
}

TEST(SurfaceUnion, LayersOfClothDoNotCountAsJoined) {
  Place place;
  place.add_quad({0, -1, 0}, {1, 0, 0}, {0, 2, 0});
  place.add_quad({-1, -1, 0}, {1, 0, 0}, {0, 2, 0});
  place.x[0] = {-kGap, 0.01, kGap};
  detail::SurfaceUnion all(place.triangles);
  all.fit(place.x);
  const auto stays = [&](std::size_t begin, std::size_t end) {  // with these vertices on a border
    std::vector<char> border(place.x.size(), 0);
    for (std::size_t i = begin; i < end; ++i) border[i] = 1;
    ContactPoint rim = place.contact(place.triangles[1]);
    return all.is_true_contact(rim, place.x, {kTolerance, {}, {}, border});
  };
  EXPECT_FALSE(stays(1, 9)) << "a seam";
  EXPECT_TRUE(stays(1, 5)) << "a hem on the middle of a layer";
  EXPECT_TRUE(stays(5, 9)) << "a fold beside a hem";
}

TEST(TriangleTree, FindsWhatAllTrianglesHave) {
  std::mt19937_64 random(3);
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;
  for (std::int32_t k = 0; k < 200; ++k) {
    for (int c = 0; c < 3; ++c)
      x.emplace_back(uniform(random, 0, 1), uniform(random, 0, 1), uniform(random, 0, 0.1));
    triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  }
  TriangleTree tree(triangles);
  tree.fit(x);
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 100; ++i) {
      const Vec3 q(uniform(random, 0, 1), uniform(random, 0, 1), uniform(random, 0, 0.1));
      std::vector<char> found(triangles.size(), 0);
      tree.for_each_near(q, 0.05, [&](std::int32_t k) { found[k] = 1; });
      for (std::size_t k = 0; k < triangles.size(); ++k) {
        const Triangle& t = triangles[k];
        if (point_triangle_closest(q, x[t[0]], x[t[1]], x[t[2]]).distance <= 0.05) {
          EXPECT_TRUE(found[k]);
        }
      }
    }
    for (Vec3& v : x) v = Vec3(v.y(), v.z(), v.x());
    tree.fit(x);
  }
}

void expect_same_slide(const bench::Seam& seam, const bench::Slide& slide) {
  const bench::SlideEnd whole = bench::slide_over(seam, seam.welded, slide);
  const bench::SlideEnd parts = bench::slide_over(seam, seam.parts, slide);
  EXPECT_EQ(parts.stopped, "") << seam.name;
  EXPECT_NEAR(parts.distance / whole.distance, 1.0, 0.02)
      << seam.name << ", " << slide.response << ", " << slide.speed << " m/s, mu "
      << slide.friction;
}

TEST(Seams, DoNotHoldClothBack) {
  for (const bench::Seam& seam : bench::seams(7))
    if (seam.is_quick) expect_same_slide(seam, {.speed = 1.0, .frames = 30});
}

TEST(Seams, DoNotHoldClothBackWhateverAnswersTheContacts) {
  for (const bench::Seam& seam : bench::seams(8))
    for (const auto& [response, entry] : responses()) {
      if (seam.name == "boxes flush within 1e-05")
        expect_same_slide(seam, {.friction = 0.1, .frames = 12, .response = response});
      if (seam.is_cloth || seam.name == "doubled vertices, noise 5e-05")
        expect_same_slide(seam, {.frames = 6, .response = response});
    }
}

// A slit that ends inside a mesh: the faces beside it share the vertex in which it ends.
TEST(Seams, SlitsThatEndInsideDoNotHoldClothBack) {
  std::mt19937_64 random(20261201);
  for (std::uint64_t seed = 100; seed < 112; ++seed)
    for (const bench::Seam& seam : bench::seams(seed)) {
      if (seam.name != "slit that ends in a fan") continue;
      SCOPED_TRACE(seed);
      expect_same_slide(seam, {.speed = uniform(random, 0.1, 1.0),
                               .friction = seed % 2 == 0 ? 0.0 : 0.1,
                               .frames = 30});
    }
}

// Vertices of the cloth below pass under the hem of the sheet at its rest gap.
TEST(Seams, HemsSlideOverVerticesWithoutLoss) {
  std::mt19937_64 random(20261129);
  const std::vector<bench::Seam> all = bench::seams(9);
  const auto seam =
      std::find_if(all.begin(), all.end(), [](const bench::Seam& s) { return s.is_cloth; });
  ASSERT_NE(seam, all.end());
  for (int k = 0; k < 4; ++k) {
    const bench::Slide slide{.speed = uniform(random, 0.2, 0.8),
                             .frames = 30,
                             .aside = Vec3(0.0, uniform(random, 0.0, 0.01), 0.0)};
    const bench::SlideEnd end = bench::slide_over(*seam, seam->welded, slide);
    EXPECT_EQ(end.stopped, "");
    EXPECT_NEAR(end.distance / (0.5 * slide.speed), 1.0, 0.01)
        << slide.speed << " m/s, " << slide.aside.y() << " m aside";
  }
}

// A contact that starts deep cycled between its damper, which pulls there, and no force at all, so
// that it got the friction of a load that it never had.
TEST(Seams, PenaltyBrakesByCoulombOnRoughBodies) {
  std::mt19937_64 random(20261130);
  for (const std::uint64_t seed : {11, 12})
    for (const bench::Seam& seam : bench::seams(seed)) {
      if (seam.name != "doubled vertices, noise 5e-05") continue;
      const bench::Slide slide{
          .speed = uniform(random, 0.5, 1.5), .friction = 0.1, .frames = 15, .response = "penalty"};
      const double t = 0.25, way = slide.speed * t - 0.5 * 0.1 * 9.81 * t * t;
      for (const auto* bodies : {&seam.parts, &seam.welded})
        EXPECT_NEAR(bench::slide_over(seam, *bodies, slide).distance / way, 1.0, 0.03)
            << "seed " << seed << ", " << slide.speed << " m/s";
    }
}

/// A grid of n by n cells in pieces that are up to `apart` away from where they belong.
TriangleMesh soup(std::mt19937_64& random, int n, double apart) {
  TriangleMesh mesh;
  const auto at = [&](int i, int j) {
    const double e = 0.5 / std::sqrt(3.0) * apart;
    return Vec3(i + uniform(random, -e, e), j + uniform(random, -e, e), uniform(random, -e, e));
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const auto first = static_cast<std::int32_t>(mesh.vertices.size());
      for (const Vec3& x : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)})
        mesh.vertices.push_back(x);
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  return mesh;
}

TEST(WeldVertices, JoinsAllThatAreWithinTheDistanceAndCountsThem) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    std::mt19937_64 random(seed);
    const double apart = std::pow(10.0, uniform(random, -9.0, -2.0));
    const int n = 1 + static_cast<int>(random() % 6);
    TriangleMesh mesh = soup(random, n, apart);
    const std::size_t before = mesh.vertices.size(), whole = (n + 1) * (n + 1);
    const WeldReport report = weld_vertices(mesh, apart);
    EXPECT_EQ(mesh.vertices.size(), whole) << "seed " << seed;
    EXPECT_EQ(mesh.triangles.size(), 2u * n * n) << "seed " << seed;
    EXPECT_EQ(report.vertices, before);
    EXPECT_EQ(report.joined, before - whole);
    EXPECT_EQ(report.collapsed, 0u);
    EXPECT_LE(report.farthest, apart);
    // Nothing is left to join.
    EXPECT_EQ(weld_vertices(mesh, apart).joined, 0u);
  }
}

TEST(WeldVertices, RemovesTrianglesThatLoseACorner) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1e-6, 0}}, {{0, 1, 2}, {0, 1, 3}}};
  const WeldReport report = weld_vertices(mesh, 1e-5);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
  EXPECT_EQ(report.collapsed, 1u);
  EXPECT_NEAR(report.farthest, 1e-6, 1e-18);
  EXPECT_THROW(weld_vertices(mesh, 0.0), std::invalid_argument);
  EXPECT_THROW(weld_vertices(mesh, std::nan("")), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::seams_test
