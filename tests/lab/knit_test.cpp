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
