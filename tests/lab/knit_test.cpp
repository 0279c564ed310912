// SPDX-License-Identifier: MIT
//
// Plain knit at the level of its yarn: the loop of Peirce 1947, its interlocks, and what tension
// makes of a swatch.
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/lab/fabric_drape.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace selvedge::knit_test {
namespace {

constexpr GridConfig kSwatch{0.007, 0.0065, 9, 10};

KnitConfig knit_of(std::int32_t links) { return {.yarn = {}, .links = links}; }

// All yarns touch where wales are 4 d and courses 2√3 d apart; Peirce's loop then is 16.66 d long.
TEST(Knit, TheClosestLoopHasPeircesLength) {
  constexpr double d = 1.7e-4;
  const KnitLoop loop(4.0 * d, 2.0 * std::numbers::sqrt3 * d, d);
  EXPECT_NEAR(loop.length() / d, 16.66, 0.01);
  EXPECT_NEAR(loop.radius, 1.5 * d, 1e-12);
  EXPECT_NEAR(loop.leg, std::sqrt(7.0) * d, 1e-12);
}

TEST(Knit, ALoopIsAsLongAsItsPlan) {
  for (const double open : {1.0, 1.2, 1.6}) {
    constexpr double d = 1.7e-4;
    const KnitLoop loop(4.0 * open * d, 3.6 * open * d, d);
    constexpr int parts = 20000;
    double length = 0.0;
    for (int k = 0; k < parts; ++k) {
      const double step = 0.5 * loop.length() / parts;
      length += (loop.place((k + 1) * step) - loop.place(k * step)).head<2>().norm();
    }
    EXPECT_NEAR(2.0 * length, loop.length(), 1e-6 * loop.length()) << open;
  }
}

TEST(Knit, YarnsThatDoNotFitAreRefused) {
  constexpr double d = 1.7e-4;
  EXPECT_THROW(KnitLoop(3.9 * d, 3.6 * d, d), std::invalid_argument);
  EXPECT_THROW(KnitLoop(4.0 * d, 3.4 * d, d), std::invalid_argument);
  EXPECT_THROW(make_knit(kSwatch, {.yarn = {.tex = 200.0}}, Material{}), std::invalid_argument);
  EXPECT_THROW(make_knit(kSwatch, knit_of(3), Material{}), std::invalid_argument);
  EXPECT_THROW(make_knit(kSwatch, {.yarn = {}, .sliding = 0.0}, Material{}), std::invalid_argument);
}

// Each loop is held by the next course at four places: twice a leg of that course lies before its
// head, twice a sinker of that course behind its legs.
TEST(Knit, HeadsPassBehindLegsAndLegsBeforeSinkers) {
  for (const std::int32_t links : {2, 4}) {
    const KnitConfig knit = knit_of(links);
    const ClothMesh cloth = make_knit(kSwatch, knit, Material{});
    const KnitLayout at(kSwatch, knit);
    const std::vector<Vec3>& x = cloth.surface.vertices;
    const double d = knit.yarn.diameter();
    std::vector<int> heads(x.size(), 0), legs(x.size(), 0);
    std::size_t count = 0;
    for (const Spring& s : cloth.springs) {
      if (s.b == s.a + 1) continue;  // a link
      ++count;
      EXPECT_NEAR((x[s.a] - x[s.b]).head<2>().norm(), 0.0, 1e-12);
      EXPECT_NEAR(std::abs(x[s.a].z() - x[s.b].z()), d, 1e-12);
      EXPECT_NEAR(s.rest_length, d, 1e-12);
      const std::int32_t course = (s.a - at.on(0, 0, 0)) / at.on_course();
      const std::int32_t wale = (s.a - at.on(0, course, 0)) / at.on_loop();
      EXPECT_GE(s.b, at.on(0, course + 1, 0)) << "with the next course";
      const bool is_behind = x[s.a].z() < x[s.b].z();
      const bool is_head = x[s.a].y() > x[at.middle(wale, course)].y() + 0.5 / 1500.0;
      EXPECT_EQ(is_behind, is_head);
      ++(is_behind ? heads : legs)[at.middle(wale, course)];
    }
    EXPECT_EQ(count, static_cast<std::size_t>(4 * at.wales * (at.courses - 1)));
    for (std::int32_t k = 0; k < at.wales * (at.courses - 1); ++k) {
      EXPECT_EQ(heads[k], 2);
      EXPECT_EQ(legs[k], 2);
    }
  }
}

// Between its two interlocks a leg passes from the front to the back beside the other yarn, a
// little nearer than at them.
TEST(Knit, NoTwoYarnsAreMuchNearerThanTheirDiameter) {
  const KnitConfig knit = knit_of(8);
  const ClothMesh cloth = make_knit(kSwatch, knit, Material{});
  const KnitLayout at(kSwatch, knit);
  const std::vector<Vec3>& x = cloth.surface.vertices;
  double nearest = 1.0;
  for (std::int32_t a = at.on(4, 4, 0); a <= at.on(5, 4, 0); ++a)
    for (std::int32_t b = at.on(0, 5, 0); b < static_cast<std::int32_t>(x.size()); ++b)
      nearest = std::min(nearest, (x[a] - x[b]).norm());
  EXPECT_GT(nearest, 0.92 * knit.yarn.diameter());
  EXPECT_LE(nearest, knit.yarn.diameter() * (1.0 + 1e-9));
}

TEST(Knit, HasTheMassOfItsYarn) {
  KnitConfig knit = knit_of(16);
  knit.yarn.tex = 15.0;
  const ClothMesh cloth = make_knit(kSwatch, knit, Material{});
  double length = 0.0;
  for (const Spring& s : cloth.springs)
    if (s.b == s.a + 1) length += s.rest_length;
  const double mass = std::accumulate(cloth.mass.begin(), cloth.mass.end(), 0.0);
  EXPECT_NEAR(mass, 15e-6 * length, 1e-12 * mass);
  const KnitLayout at(kSwatch, knit);
  const double surface =
      std::accumulate(cloth.mass.begin(), cloth.mass.begin() + at.wales * at.courses, 0.0);
  EXPECT_NEAR(surface, 0.5 * mass, 1e-12 * mass);
  // In space, a loop is some percent longer than its plan.
  const KnitLoop loop(kSwatch.size_x / 9, kSwatch.size_y / 10, knit.yarn.diameter());
  const double plan = at.wales * at.courses * loop.length();
  EXPECT_GT(length, plan);
  EXPECT_LT(length, 1.1 * plan);
}

TEST(Knit, IsAtRest) {
  const ClothMesh cloth = make_knit(kSwatch, knit_of(4), Material{});
  const std::vector<Vec3> still(cloth.mass.size(), Vec3::Zero());
  std::vector<Vec3> f(cloth.mass.size());
  ForceSum forces(make_internal_forces(cloth), cloth.mass.size());
  forces.evaluate({cloth.surface.vertices, still, cloth.mass, 0.0}, f);
  double largest = 0.0;
  for (const Vec3& force : f) largest = std::max(largest, force.norm());
  EXPECT_LT(largest, 1e-8);  // N; EA is 80 N
}

TEST(Knit, IsAPatternOfScenesThatTakesNoLawOfASheet) {
  const auto pattern = cloth_patterns().at("knit");
  const ClothMesh cloth = pattern({{"tex", 15.0}, {"links", 4.0}}, kSwatch, Material{});
  KnitConfig knit = knit_of(4);
  knit.yarn.tex = 15.0;
  const ClothMesh same = make_knit(kSwatch, knit, Material{});
  EXPECT_EQ(cloth.mass, same.mass);
  EXPECT_EQ(cloth.surface.vertices, same.surface.vertices);
  Material sheet;
  sheet.bending_law = "hinge";
  EXPECT_THROW(pattern(kSwatch, sheet), std::invalid_argument);
}

// -- rib and interlock
// ------------------------------------------------------------------------------

KnitConfig structure_of(KnitStructure structure, std::int32_t links) {
  return {.yarn = {}, .links = links, .structure = structure};
}

Vec3 at_middle(const std::vector<Vec3>& x, const KnitLayout& at, std::int32_t row) {
  return 0.5 * (x[at.on(0, row, at.on_loop() / 4)] + x[at.on(0, row, 3 * at.on_loop() / 4)]);
}

/// The plane between both sides lies at half of the height of the surface's other wale.
double middle_of(const ClothMesh& cloth) { return 0.5 * cloth.surface.vertices[1].z(); }

// Half a turn about a wale's direction shows the same side again, which jersey does not.
TEST(KnitStructures, AreTheSameFromBothSides) {
  for (const KnitStructure structure : {KnitStructure::rib, KnitStructure::interlock}) {
    const KnitConfig knit = structure_of(structure, 4);
    const ClothMesh cloth = make_knit(kSwatch, knit, Material{});
    const KnitLayout at(kSwatch, knit);
    const std::vector<Vec3>& x = cloth.surface.vertices;
    const double middle = middle_of(cloth);
    ASSERT_LT(middle, -knit.yarn.diameter());
    for (std::int32_t row = 0; row < at.rows(); ++row)
      for (std::int32_t k = 0; k < at.on_course(); ++k) {
        const Vec3 a = x[at.on(0, row, k)], b = x[at.on(0, row, at.on_course() - 1 - k)];
        EXPECT_LT((Vec3(-b.x(), b.y(), 2.0 * middle - b.z()) - a).norm(), 1e-12);
      }
  }
}

TEST(KnitStructures, HoldEachLoopOnItsOwnSideAsJerseyDoes) {
  for (const KnitStructure structure : {KnitStructure::rib, KnitStructure::interlock}) {
    const KnitConfig knit = structure_of(structure, 2);
    const ClothMesh cloth = make_knit(kSwatch, knit, Material{});
    const KnitLayout at(kSwatch, knit);
    const std::vector<Vec3>& x = cloth.surface.vertices;
    const double d = knit.yarn.diameter(), middle = middle_of(cloth);
    std::size_t held = 0, between_ribs = 0;
    for (const Spring& s : cloth.springs) {
      if (s.b == s.a + 1) continue;  // a link
      const auto row = [&](std::int32_t k) { return (k - at.on(0, 0, 0)) / at.on_course(); };
      if (row(s.b) != row(s.a) + at.yarns) {
        ++between_ribs;
        EXPECT_NEAR(x[s.a].z(), middle, 1e-12);
        continue;
      }
      ++held;
      EXPECT_NEAR((x[s.a] - x[s.b]).head<2>().norm(), 0.0, 1e-12);
      EXPECT_NEAR(std::abs(x[s.a].z() - x[s.b].z()), d, 1e-12);
      // Of the two yarns, the leg is further from the middle; a head is that of the lower row.
      const bool is_back = x[s.a].z() + x[s.b].z() < 2.0 * middle;
      const bool is_head = x[s.a].y() > at_middle(x, at, row(s.a)).y() + 0.5 / 1500.0;
      EXPECT_EQ(is_head, (x[s.a].z() < x[s.b].z()) != is_back);
    }
    EXPECT_EQ(held, static_cast<std::size_t>(4 * at.wales * (at.rows() - at.yarns)));
    EXPECT_EQ(between_ribs, structure == KnitStructure::rib
                                ? 0u
                                : static_cast<std::size_t>((at.wales - 1) * (at.rows() - 1)));
  }
}

// No yarn of a rib or an interlock passes through another one.
TEST(KnitStructures, KeepTheirYarnsApart) {
  for (const KnitStructure structure : {KnitStructure::rib, KnitStructure::interlock}) {
    const KnitConfig knit = structure_of(structure, 8);
    const ClothMesh cloth = make_knit(kSwatch, knit, Material{});
    const KnitLayout at(kSwatch, knit);
    const std::vector<Vec3>& x = cloth.surface.vertices;
    const std::int32_t row = 4 * at.yarns;
    double nearest = 1.0;
    for (std::int32_t a = at.on(4, row, 0); a <= at.on(6, row, 0); ++a)
      for (std::int32_t b = at.on(0, row + 1, 0); b < static_cast<std::int32_t>(x.size()); ++b)
        nearest = std::min(nearest, (x[a] - x[b]).norm());
    EXPECT_GT(nearest, 0.92 * knit.yarn.diameter());
  }
}

TEST(KnitStructures, AreAtRestAndTwiceAsThickAsJersey) {
  const auto thickness = [](const ClothMesh& cloth) {
    double low = 0.0, high = 0.0;
    for (const Vec3& x : cloth.surface.vertices) {
      low = std::min(low, x.z());
      high = std::max(high, x.z());
    }
    return high - low;
  };
  const double jersey = thickness(make_knit(kSwatch, knit_of(4), Material{}));
  for (const auto& [structure, times] :
       {std::pair{KnitStructure::rib, 2.0}, {KnitStructure::interlock, 2.6}}) {
    const ClothMesh cloth = make_knit(kSwatch, structure_of(structure, 4), Material{});
    EXPECT_NEAR(thickness(cloth) / jersey, times, 0.1);
    const std::vector<Vec3> still(cloth.mass.size(), Vec3::Zero());
    std::vector<Vec3> f(cloth.mass.size());
    ForceSum forces(make_internal_forces(cloth), cloth.mass.size());
    forces.evaluate({cloth.surface.vertices, still, cloth.mass, 0.0}, f);
    for (const Vec3& force : f) EXPECT_LT(force.norm(), 1e-8);
  }
}

TEST(KnitStructures, HaveTheYarnsOfTheirLoops) {
  const auto mass = [](const KnitConfig& knit) {
    const ClothMesh cloth = make_knit(kSwatch, knit, Material{});
    return std::accumulate(cloth.mass.begin(), cloth.mass.end(), 0.0);
  };
  const double jersey = mass(knit_of(8));
  EXPECT_NEAR(mass(structure_of(KnitStructure::rib, 8)) / jersey, 1.0, 1e-9);
  EXPECT_NEAR(mass(structure_of(KnitStructure::interlock, 8)) / jersey, 2.0, 0.05);
}

/// Moment per width and strain, N/m·m, that a swatch stretched along its courses exerts: the change
/// of its energy when it is bent about the direction of its wales, to one side and to the other.
double moment_of_stretched(const KnitConfig& knit) {
  const ClothMesh cloth = make_knit(kSwatch, knit, Material{});
  const ForceSum forces(make_internal_forces(cloth), cloth.mass.size());
  constexpr double strain = 0.02, bend = 1.0;  // 1/m
  const double middle = knit.structure == KnitStructure::jersey ? 0.0 : middle_of(cloth);
  const std::vector<Vec3> still(cloth.mass.size(), Vec3::Zero());
  const auto energy = [&](double curvature) {
    std::vector<Vec3> x = cloth.surface.vertices;
    for (Vec3& p : x) {
      const double angle = curvature * (1.0 + strain) * p.x(), z = p.z() - middle;
      p.x() = std::sin(angle) / curvature + z * std::sin(angle);
      p.z() = (std::cos(angle) - 1.0) / curvature + z * std::cos(angle);
    }
    return forces.energy({x, still, cloth.mass, 0.0});
  };
  return (energy(bend) - energy(-bend)) / (2.0 * bend * strain * kSwatch.size_x * kSwatch.size_y);
}

// The loops of jersey lie to one side of their yarns, so that its edges roll; those of a rib
// balance each other.
TEST(KnitStructures, DoNotRollWhereJerseyDoes) {
  const double jersey = std::abs(moment_of_stretched(knit_of(4)));
  EXPECT_GT(jersey, 0.0);
  for (const KnitStructure structure : {KnitStructure::rib, KnitStructure::interlock})
    EXPECT_LT(std::abs(moment_of_stretched(structure_of(structure, 4))), 1e-6 * jersey);
}

TEST(KnitStructures, OfTwoWalesHaveTwoWalesOnEachSide) {
  KnitConfig knit = structure_of(KnitStructure::rib, 2);
  knit.wales = 2;
  const ClothMesh cloth = make_knit(kSwatch, knit, Material{});
  for (std::int32_t i = 0; i <= kSwatch.cells_x; ++i)
    EXPECT_EQ(cloth.surface.vertices[i].z() < 0.0, i / 2 % 2 == 1) << i;
  knit.wales = 0;
  EXPECT_THROW(make_knit(kSwatch, knit, Material{}), std::invalid_argument);
  const ClothMesh same = cloth_patterns().at("rib")({{"wales", 2.0}}, kSwatch, Material{});
  EXPECT_EQ(same.surface.vertices, cloth.surface.vertices);
}

// -- tension --------------------------------------------------------------------------------------

KnitTrial trial() {
  KnitTrial t;
  t.strain = 0.06;
  t.points = 3;
  return t;
}

TEST(KnitSwatch, IsSofterAlongItsCoursesThanAlongItsWales) {
  const KnitTrial t = trial();
  const double course = pull_knit(t, KnitPull::course).curve.back().force / t.strain;
  const double wale = pull_knit(t, KnitPull::wale).curve.back().force / t.strain;
  EXPECT_LT(course, wale / 3.0);
  // The same yarn straight, one for each course or two legs for each wale.
  const double yarn = t.knit.yarn.stretch();
  EXPECT_LT(course, 1e-2 * yarn * t.courses);
  EXPECT_LT(wale, 3e-2 * 2.0 * yarn * t.wales);
}

TEST(KnitSwatch, ExtendsByItsLoopsAndKeepsTheLengthOfItsYarn) {
  const KnitTrial t = trial();
  for (const KnitPull pull : {KnitPull::course, KnitPull::wale}) {
    const KnitTest test = pull_knit(t, pull);
    EXPECT_GT(test.yarn_strain, 0.0);
    EXPECT_LT(test.yarn_strain, 0.02 * t.strain);
  }
}

TEST(KnitSwatch, OfAYarnThatBendsMoreEasilyIsSofter) {
  KnitTrial t = trial();
  const double stiff = pull_knit(t, KnitPull::course).curve.back().force;
  t.knit.yarn.bending_share *= 0.2;
  const double soft = pull_knit(t, KnitPull::course).curve.back().force;
  EXPECT_LT(soft, 0.6 * stiff);
  EXPECT_GT(soft, 0.15 * stiff);
}

TEST(KnitSwatch, TakesItsDensityAndTightnessFromItsLoop) {
  const KnitTrial t;
  EXPECT_NEAR(t.density(), 20e-6 * t.loop().length() * 1450.0 * 1650.0, 1e-12);
  EXPECT_GT(t.tightness(), 13.0);  // the range of jersey
  EXPECT_LT(t.tightness(), 17.0);
}

}  // namespace
}  // namespace selvedge::knit_test
