// SPDX-License-Identifier: MIT
//
// The tests of Romero et al. 2021 on strips, in short; bench/slender has the whole curves.
#include <selvedge/tests/slender.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace selvedge::testing::slender_test {
namespace {

const SlenderStrips strips{SELVEDGE_SOURCE_DIR "/data/validation", 20};

TEST(SlenderTheory, OfTheCantileverHasItsLimits) {
  EXPECT_NEAR(cantilever_ratio(0.01) / (0.01 / 8.0), 1.0, 1e-4);
  EXPECT_NEAR(cantilever_ratio(10.0), 1.06680,
              2e-5);  // tests/core/solver/oracles_test.cpp has the same
  EXPECT_NEAR(cantilever_ratio(1e-9, 1.0), (1.0 - std::cos(1.0)) / std::sin(1.0), 1e-8);
}

/// The moment about the tangent at the distance x from the tip is Γ (n x - sin n x)/n² for the
/// weight and (1 - cos n x)/n for a unit force at the tip; half their product is integrated.
TEST(SlenderTheory, OfBendTwistBeginsWithTheTwistOfAnArc) {
  for (const double n : {0.5, 1.0, 2.0}) {
    constexpr double gamma = 1e-3;
    const auto found = bent_and_twisted({.gamma = gamma, .natural = n});
    ASSERT_TRUE(found) << n;
    EXPECT_NEAR(found->drop / (gamma * std::pow(n - std::sin(n), 2) / (4.0 * std::pow(n, 4))), 1.0,
                1e-4);
    EXPECT_NEAR(found->forward, std::sin(n) / n, 1e-6);
  }
}

TEST(SlenderTheory, OfAHangingStripLeavesThePlaneOnlyWithLittleTwistStiffness) {
  for (const double natural : {1.0, 3.0, 6.0})
    for (const double gamma : {5.0, 20.0, 80.0})
      EXPECT_TRUE(hangs_in_its_plane(gamma, natural).value()) << gamma << ", " << natural;
  EXPECT_TRUE(hangs_in_its_plane(20.0, 6.0, 0.5).value());
  EXPECT_FALSE(hangs_in_its_plane(20.0, 6.0, 0.3).value());
}

/// The solution is a Bessel function of order -1/6, whose first zero is 2.1423: 6·2.1423·√2.
TEST(SlenderTheory, OfLateralBucklingIsThatOfPrandtlAndMichell) {
  EXPECT_NEAR(lateral_buckling_gamma(), 18.178, 0.005);
}

/// Upright, the column buckles by Euler's mode, and the force leans by √(descent/5.05).
TEST(SlenderTheory, OfThePushedStripBeginsWithEulersColumn) {
  const auto states = pushed_strip({.lean = 1e-5, .sideways = 0.0, .first = 0.001, .last = 0.002});
  ASSERT_FALSE(states.empty());
  EXPECT_NEAR(states.front().ratio / std::sqrt(0.001 / 5.05), 1.0, 0.01);
}

TEST(SlenderStrip, CantileversFollowTheElastica) {
  for (const double gamma : {1.0, 10.0, 50.0})
    EXPECT_NEAR(strips.cantilever(gamma) / cantilever_ratio(gamma), 1.0, 0.01) << gamma;
}

TEST(SlenderStrip, CantileversConvergeWithOrderTwo) {
  const double exact = cantilever_ratio(20.0);
  const auto error = [&](int cells) {
    return SlenderStrips{strips.folder, cells}.cantilever(20.0) / exact - 1.0;
  };
  const double coarse = error(10), middle = error(20), fine = error(40);
  EXPECT_NEAR(coarse / middle, 4.0, 0.5);
  EXPECT_NEAR(middle / fine, 4.0, 0.5);
  // From here on, what is left of the motion at the end of the scene counts as well.
  EXPECT_NEAR(error(80), 0.0, 5e-4);
}

TEST(SlenderStrip, CantileversThatAreCurvedAtRestFollowTheElastica) {
  for (const double natural : {-1.0, 1.0})
    EXPECT_NEAR(strips.cantilever(5.0, natural) / cantilever_ratio(5.0, natural), 1.0, 0.01)
        << natural;
}

/// The error is of first order, as that of lateral buckling.
TEST(SlenderStrip, ThatIsCurvedAtRestBendsAndTwistsOutOfItsPlane) {
  const SlenderStrips fine{strips.folder, 40};
  for (const double natural : {1.0, 2.0})
    for (const double gamma : {5.0, 10.0, 20.0}) {
      const auto exact = bent_and_twisted(SlenderStrips::bend_twist_load(gamma, natural));
      ASSERT_TRUE(exact);
      const BendTwist found = fine.bend_twist(gamma, natural);
      EXPECT_NEAR(found.drop / exact->drop, 1.0, 0.1) << gamma << ", " << natural;
      EXPECT_NEAR(found.forward / exact->forward, 1.0, 0.03) << gamma << ", " << natural;
      if (gamma < 20.0) continue;
      const double coarse = strips.bend_twist(gamma, natural).drop;
      EXPECT_LT(std::abs(found.drop - exact->drop), 0.6 * std::abs(coarse - exact->drop));
    }
}

TEST(SlenderStrip, ThatHangsReturnsToItsPlane) {
  for (const double natural : {1.0, 3.0, 6.0})
    EXPECT_LT(strips.out_of_plane(20.0, natural, 0.5), 1e-5) << natural;
}

TEST(SlenderStrip, StandsOnItsSideUpToTheCriticalGamma) {
  constexpr double breadth = 0.2;
  const double exact = lateral_buckling_gamma(breadth);
  const double coarse = strips.buckling_gamma(breadth);
  const double fine = SlenderStrips{strips.folder, 40}.buckling_gamma(breadth);
  EXPECT_LT(std::abs(fine - exact), 0.6 * std::abs(coarse - exact)) << coarse << " " << fine;
  EXPECT_NEAR((2.0 * fine - coarse) / exact, 1.0, 0.02) << coarse << " " << fine;
}

TEST(SlenderStrip, FallsOverBeyondTheCriticalGamma) {
  const double critical = lateral_buckling_gamma(0.1);
  EXPECT_LT(strips.buckled(0.9 * critical), 0.05);
  EXPECT_GT(strips.buckled(1.1 * critical), 0.15);
}

TEST(SlenderStrip, PushedOnTheGroundHasTheForceOfTheElastica) {
  const auto states = pushed_strip();
  const auto found = strips.pushed(10.0);
  for (const double descent : {0.05, 0.1, 0.15, 0.2, 0.25}) {
    const auto at = [&](const std::vector<Pushed>& list) {
      return std::find_if(list.begin(), list.end(),
                          [&](const Pushed& p) { return p.descent >= descent; })
          ->ratio;
    };
    EXPECT_NEAR(at(found) / at(states), 1.0, 0.025) << descent;
  }
}

TEST(SlenderStrip, PushedOnTheGroundSlipsWhenTheForceExceedsTheFriction) {
  const auto states = pushed_strip();
  for (const double friction : {0.3, 0.4, 0.5}) {
    const auto exact = slip_descent(states, friction), found = strips.slip(friction);
    ASSERT_TRUE(exact && found) << friction;
    EXPECT_NEAR(*found, *exact, 0.01) << friction;
  }
  EXPECT_FALSE(strips.slip(0.7).has_value());
}

}  // namespace
}  // namespace selvedge::testing::slender_test
