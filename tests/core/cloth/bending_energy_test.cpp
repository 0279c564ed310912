// SPDX-License-Identifier: MIT
//
// The discrete bending energies against closed forms on five surfaces: which of them converge, and
// with which order (docs/lab/validation.md).
#include <selvedge/core/cloth/force.h>
#include <selvedge/tests/bent_surfaces.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace selvedge::testing::bending_energy_test {
namespace {

double inner_error(const BentSurface& surface, BendingModel model, Pattern pattern, int cells) {
  return energy_ratio(surface, divide(surface, pattern, cells), model).inner - 1.0;
}

double whole_error(const BentSurface& surface, BendingModel model, Pattern pattern, int cells) {
  return energy_ratio(surface, divide(surface, pattern, cells), model).whole - 1.0;
}

/// Those whose curvature does not jump.
std::vector<BentSurface> smooth_surfaces() {
  std::vector<BentSurface> surfaces = bent_surfaces();
  surfaces.pop_back();
  return surfaces;
}

/// ∫ (κ1² + κ2²) dA by the midpoint rule.
double integrate(const BentSurface& s) {
  constexpr int n = 400;
  constexpr double nudge = 1e-6;
  double sum = 0.0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double u = (i + 0.5) * s.size_u / n, v = (j + 0.5) * s.size_v / n;
      const Vec3 along = (s.at(u + nudge, v) - s.at(u - nudge, v)) / (2.0 * nudge);
      const Vec3 across = (s.at(u, v + nudge) - s.at(u, v - nudge)) / (2.0 * nudge);
      sum += s.squares(u, v) * along.cross(across).norm();
    }
  return sum * s.size_u * s.size_v / n / n;
}

TEST(BentSurfaces, TheClosedFormsAreTheIntegralsOfTheCurvatures) {
  for (const BentSurface& surface : smooth_surfaces())
    EXPECT_NEAR(integrate(surface) / surface.integral, 1.0, 1e-4) << surface.name;
  // Where the curvature jumps, the rule is of first order.
  const BentSurface crease = bent_surfaces().back();
  EXPECT_NEAR(integrate(crease) / crease.integral, 1.0, 1e-2);
}

TEST(BentSurfaces, TheEnergiesOfHingesAreThoseOfTheForces) {
  for (const BentSurface& surface : bent_surfaces()) {
    const BentMesh bent = divide(surface, Pattern::irregular, 8);
    const std::vector<Vec3>& x = bent.mesh.vertices;
    const std::vector<Vec3> still(x.size(), Vec3::Zero());
    const ClothMesh plain = flat_hinged(bent, BendingModel::hinge);
    const ClothMesh sine = flat_hinged(bent, BendingModel::bridson);
    const ForceState state{x, still, plain.mass, 0.0};
    EXPECT_NEAR(energy_of(bent, BendingModel::hinge) /
                    make_bending_force(plain.hinges, x.size())->energy(state),
                1.0, 1e-12);
    EXPECT_NEAR(energy_of(bent, BendingModel::bridson) /
                    make_bridson_force(sine.hinges, x.size())->energy(state),
                1.0, 1e-12);
  }
}

TEST(BendingEnergy, OfTheShapeOperatorConvergesWithOrderTwoOnGrids) {
  for (const BentSurface& surface : smooth_surfaces()) {
    const auto error = [&](int cells) {
      return std::abs(
          inner_error(surface, BendingModel::shape_operator, Pattern::alternating, cells));
    };
    EXPECT_LT(error(32), 0.005) << surface.name;
    EXPECT_LT(error(32), error(16) / 3.5) << surface.name;
  }
}

TEST(BendingEnergy, OfTheShapeOperatorStaysWithinThreePercentOnIrregularMeshes) {
  for (const BentSurface& surface : smooth_surfaces())
    for (const int cells : {16, 32})
      EXPECT_NEAR(inner_error(surface, BendingModel::shape_operator, Pattern::irregular, cells),
                  0.0, 0.03)
          << surface.name << ", " << cells;
}

TEST(BendingEnergy, OfMorleysElementsConvergesWithOrderTwoOnAnyMesh) {
  for (const BentSurface& surface : smooth_surfaces())
    for (const Pattern pattern : {Pattern::alternating, Pattern::irregular}) {
      const auto error = [&](int cells) {
        return std::abs(inner_error(surface, BendingModel::morley, pattern, cells));
      };
      EXPECT_LT(error(32), 0.005) << surface.name;
      EXPECT_LT(error(32), error(16) / 3.3) << surface.name;
    }
}

TEST(BendingEnergy, OfHingesHasAnotherLimitOnEachMesh) {
  const std::vector<BentSurface> surfaces = bent_surfaces();
  const BentSurface &cylinder = surfaces[0], &helicoid = surfaces[2];
  for (const BendingModel model : {BendingModel::hinge, BendingModel::bridson}) {
    EXPECT_NEAR(inner_error(cylinder, model, Pattern::one_way, 32), -1.0 / 3.0, 0.003);
    EXPECT_NEAR(inner_error(cylinder, model, Pattern::alternating, 32), -1.0 / 9.0, 0.003);
    EXPECT_NEAR(inner_error(helicoid, model, Pattern::one_way, 32), 1.0, 0.005);
    EXPECT_NEAR(inner_error(helicoid, model, Pattern::alternating, 32), 1.0 / 3.0, 0.005);
  }
}

TEST(BendingEnergy, AtAFreeBorderIsOfFirstOrder) {
  const BentSurface cylinder = bent_surfaces().front();
  for (const BendingModel model : {BendingModel::shape_operator, BendingModel::morley}) {
    const double coarse = whole_error(cylinder, model, Pattern::alternating, 16);
    const double fine = whole_error(cylinder, model, Pattern::alternating, 32);
    EXPECT_LT(coarse, 0.0);
    EXPECT_NEAR(coarse / fine, 2.0, 0.1);
  }
}

TEST(BendingEnergy, OfASharpCreaseGrowsWithTheNumberOfCells) {
  const BentSurface crease{
      .name = "sharp crease",
      .size_u = 2.0,
      .size_v = 2.0,
      .integral = 1.0,
      .at = [](double u,
               double v) { return u < 1.0 ? Vec3(u - 1.0, v, 0.0) : Vec3(0.0, v, u - 1.0); },
      .squares = [](double, double) { return 0.0; }};
  for (const BendingModel model :
       {BendingModel::hinge, BendingModel::bridson, BendingModel::shape_operator}) {
    const double coarse = energy_of(divide(crease, Pattern::alternating, 16), model);
    const double fine = energy_of(divide(crease, Pattern::alternating, 32), model);
    EXPECT_NEAR(fine / coarse, 2.0, 0.1) << name_of(model);
  }
}

}  // namespace
}  // namespace selvedge::testing::bending_energy_test
