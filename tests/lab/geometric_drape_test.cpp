// SPDX-License-Identifier: MIT
//
// The geometric drape: threads against the closed form of the catenary, and whole cloths.
#include <selvedge/lab/fabric_drape.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace selvedge::geometric_drape_test {
namespace {

constexpr double kClosedForm = 1e-9;  // m

/// The catenary z = c cosh(x/c) from x = p to x = q, at equal arc lengths, by its closed form.
struct ClosedForm {
  double c, p, q;

  double arc(double x) const { return c * (std::sinh(x / c) - std::sinh(p / c)); }
  Vec3 at(double x) const { return {x, 0.0, c * std::cosh(x / c)}; }
  double length() const { return arc(q); }
};

TEST(Catenary, IsTheClosedForm) {
  for (const ClosedForm& t :
       {ClosedForm{0.3, -0.4, 0.4}, ClosedForm{0.05, -0.2, 0.3}, ClosedForm{1.0, 0.1, 0.5},
        ClosedForm{2.0, -1.5, -0.2}, ClosedForm{40.0, -0.5, 0.5}}) {
    std::vector<double> arc, x;
    for (int k = 0; k <= 20; ++k) {
      x.push_back(t.p + (t.q - t.p) * k / 20.0);
      arc.push_back(std::clamp(t.arc(x.back()), 0.0, t.length()));
    }
    const std::vector<Vec3> points = catenary(t.at(t.p), t.at(t.q), t.length(), arc);
    for (std::size_t k = 0; k < x.size(); ++k)
      EXPECT_LT((points[k] - t.at(x[k])).norm(), kClosedForm) << "c " << t.c << ", x " << x[k];
  }
}

TEST(Catenary, TurnsWithItsEnds) {
  const std::vector<double> arc{0.0, 0.2, 0.7, 1.0};
  const auto along_x = catenary({0, 0, 0}, {0.6, 0, 0.2}, 1.0, arc);
  const auto along_y = catenary({1, 2, 3}, {1, 2.6, 3.2}, 1.0, arc);
  for (std::size_t k = 0; k < arc.size(); ++k)
    EXPECT_LT((along_y[k] - Vec3(1.0, 2.0 + along_x[k].x(), 3.0 + along_x[k].z())).norm(),
              kClosedForm);
}

TEST(Catenary, TautThreadsAreStraightAndUprightOnesHangDouble) {
  const std::vector<double> arc{0.0, 0.25, 0.5, 1.0};
  const auto straight = catenary({0, 0, 0}, {0, 0.6, 0.8}, 1.0, arc);
  EXPECT_LT((straight[2] - Vec3(0.0, 0.3, 0.4)).norm(), 1e-15);
  const auto doubled = catenary({0, 0, 0}, {0, 0, 0.2}, 1.0, arc);
  EXPECT_NEAR(doubled[1].z(), -0.25, 1e-15);
  EXPECT_NEAR(doubled[2].z(), -0.3, 1e-15);  // 0.4 down, 0.1 up again
  EXPECT_NEAR(doubled[3].z(), 0.2, 1e-15);
  EXPECT_THROW(catenary({0, 0, 0}, {1, 0, 0}, 0.0, {}), std::invalid_argument);
  EXPECT_THROW(catenary({0, 0, 0}, {1, 0, 0}, 2.0, std::vector<double>{2.1}),
               std::invalid_argument);
}

constexpr GridConfig kGrid{1.0, 1.0, 20, 20};

std::vector<HeldVertex> corners(double span) {
  const double s = 0.5 * span;
  return {{0, {-s, -s, 0}}, {20, {s, -s, 0}}, {420, {-s, s, 0}}, {440, {s, s, 0}}};
}

TEST(GeometricDrape, SidesBetweenHeldCornersAreCatenariesOfTheirLength) {
  const auto drape = drape_geometrically(kGrid, corners(0.8), {.most_sweeps = 0});
  std::vector<double> arc;
  for (int i = 0; i <= 20; ++i) arc.push_back(0.05 * i > 1.0 ? 1.0 : 0.05 * i);
  const auto side = catenary({-0.4, -0.4, 0}, {0.4, -0.4, 0}, 1.0, arc);
  for (int i = 0; i <= 20; ++i)
    EXPECT_LT((drape.shape.vertices[i] - side[i]).norm(), kClosedForm) << i;
  // Both diagonals are as high where they cross, so the first stays: it is a catenary as well.
  for (double& s : arc) s = std::min(s * std::numbers::sqrt2, std::numbers::sqrt2);
  const auto diagonal = catenary({-0.4, -0.4, 0}, {0.4, 0.4, 0}, std::numbers::sqrt2, arc);
  const Vec3 middle = drape.shape.vertices[220];
  EXPECT_LT((middle - diagonal[10]).norm(), kClosedForm);
  EXPECT_GT(drape.curves, 20);
}

TEST(GeometricDrape, TheUpperOfTwoCurvesThatCrossStays) {
  std::vector<HeldVertex> held = corners(0.8);
  held[1].x.z() = held[2].x.z() = 0.4;  // the other diagonal is the upper one
  const auto drape = drape_geometrically(kGrid, held, {.most_sweeps = 0});
  const auto diagonal =
      catenary(held[1].x, held[2].x, std::numbers::sqrt2, std::vector{0.5 * std::numbers::sqrt2});
  EXPECT_LT((drape.shape.vertices[220] - diagonal[0]).norm(), kClosedForm);
}

TEST(GeometricDrape, RelaxationKeepsHeldVerticesAndBringsLengthsBack) {
  const auto rough = drape_geometrically(kGrid, corners(0.8), {.most_sweeps = 0});
  const auto smooth = drape_geometrically(kGrid, corners(0.8));
  EXPECT_GT(rough.residual, 0.1);
  EXPECT_LT(smooth.residual, 0.5 * rough.residual);
  EXPECT_GT(smooth.sweeps, 1);
  for (const HeldVertex& h : corners(0.8)) EXPECT_EQ(smooth.shape.vertices[h.vertex], h.x);
}

TEST(GeometricDrape, AFlatClothStaysFlat) {
  const auto drape = drape_geometrically(kGrid, corners(1.0));
  // A curve takes the vertices nearest to its line, which leaves the next curves a little slack.
  for (const Vec3& x : drape.shape.vertices) EXPECT_NEAR(x.z(), 0.0, 0.005);
  EXPECT_LT(drape.residual, 0.2);
}

TEST(GeometricDrape, VerticesOutsideTheHullHangBelow) {
  const std::vector<HeldVertex> held{{420, {-0.4, 0, 0}}, {440, {0.4, 0, 0}}};
  const auto drape = drape_geometrically(kGrid, held, {.most_sweeps = 0});
  for (int i = 0; i <= 20; ++i) {
    const Vec3 &top = drape.shape.vertices[420 + i], &low = drape.shape.vertices[i];
    EXPECT_LT(low.z(), top.z() - 0.9) << i;
  }
}

TEST(GeometricDrape, RefusesWhatCannotHang) {
  EXPECT_THROW(drape_geometrically(kGrid, corners(1.1)), std::invalid_argument);
  EXPECT_THROW(drape_geometrically(kGrid, std::vector<HeldVertex>{{0, {0, 0, 0}}}),
               std::invalid_argument);
  EXPECT_THROW(drape_geometrically(kGrid, std::vector<HeldVertex>{{0, {0, 0, 0}}, {0, {0, 0, 0}}}),
               std::invalid_argument);
  EXPECT_THROW(
      drape_geometrically(kGrid, std::vector<HeldVertex>{{0, {0, 0, 0}}, {441, {0, 0, 0}}}),
      std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::geometric_drape_test
