// SPDX-License-Identifier: MIT
//
// Weaves at the level of their yarns: their geometry, and the tests of swatches against the closed
// forms of Leaf and Kandil 1980 and of Leaf and Sheta 1984.
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/lab/fabric_drape.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge::swatch_test {
namespace {

constexpr GridConfig kSwatch{0.01, 0.008, 20, 15};

struct NamedWeave {
  const char* name;
  std::int32_t over, under, step;
  std::vector<std::string> matrix;  ///< rows are warp yarns; X: the warp lies above
};

const std::vector<NamedWeave> kWeaves = {
    {"plain", 1, 1, 1, {"X.", ".X"}},
    {"twill 2/1", 2, 1, 1, {"XX.", "X.X", ".XX"}},
    {"twill 2/2", 2, 2, 1, {"XX..", "X..X", "..XX", ".XX."}},
    {"satin of five", 4, 1, 2, {"XXXX.", "XX.XX", ".XXXX", "XXX.X", "X.XXX"}}};

WeaveConfig weave_of(const NamedWeave& weave) {
  return {.over = weave.over, .under = weave.under, .step = weave.step, .warp = {}, .weft = {}};
}

double total(const std::vector<double>& mass) {
  return std::accumulate(mass.begin(), mass.end(), 0.0);
}

TEST(Weave, YarnsLieAboveEachOtherAsTheWeaveMatrixHasThem) {
  for (const NamedWeave& named : kWeaves) {
    const WeaveConfig weave = weave_of(named);
    const ClothMesh cloth = make_weave(kSwatch, weave, Material{});
    const WeaveLayout at(kSwatch, weave);
    const std::vector<Vec3>& x = cloth.surface.vertices;
    const auto repeat = static_cast<std::int32_t>(named.matrix.size());
    for (std::int32_t j = 0; j < at.warps; ++j)
      for (std::int32_t i = 0; i < at.wefts; ++i) {
        const Vec3 warp = x[at.warp(j, at.at(i))], weft = x[at.weft(i, at.at(j))];
        const bool over = named.matrix[j % repeat][i % repeat] == 'X';
        EXPECT_EQ(warp.z() > weft.z(), over) << named.name << " at " << i << ", " << j;
        // Both lie above the vertex of the surface, as far apart as their radii.
        const Vec3 middle = x[at.middle(i, j)];
        EXPECT_NEAR((warp - middle).head<2>().norm(), 0.0, 1e-12);
        EXPECT_NEAR((weft - middle).head<2>().norm(), 0.0, 1e-12);
        EXPECT_NEAR(std::abs(warp.z() - weft.z()),
                    0.5 * (weave.warp.diameter() + weave.weft.diameter()), 1e-12);
      }
  }
}

TEST(Weave, CrimpHeightsAddUpToTheDiameters) {
  WeaveConfig weave{.warp = {.tex = 30.0}, .weft = {.tex = 15.0}, .crimp_share = 0.3};
  const ClothMesh cloth = make_weave(kSwatch, weave, Material{});
  const WeaveLayout at(kSwatch, weave);
  const auto height = [&](auto particle, std::int32_t count) {
    double low = 1.0, high = -1.0;
    for (std::int32_t k = 0; k < count; ++k) {
      low = std::min(low, cloth.surface.vertices[particle(k)].z());
      high = std::max(high, cloth.surface.vertices[particle(k)].z());
    }
    return high - low;
  };
  const double h1 = height([&](auto k) { return at.warp(3, k); }, at.on_warp());
  const double h2 = height([&](auto k) { return at.weft(4, k); }, at.on_weft());
  EXPECT_NEAR(h1 + h2, weave.warp.diameter() + weave.weft.diameter(), 1e-12);
  EXPECT_NEAR(h1, 0.3 * (h1 + h2), 1e-12);
  // Peirce 1937: d = 1/(28 √N) inches of a yarn of count N, which has 590.5/N tex.
  constexpr double inch = 0.0254, printed = 0.003;
  const double peirce = inch / (28.0 * std::sqrt(590.5 / 30.0));
  EXPECT_NEAR(weave.warp.diameter(), peirce, printed * peirce);
}

TEST(Weave, HasTheMassOfItsYarnsAndTheirLength) {
  for (const NamedWeave& named : kWeaves) {
    WeaveConfig weave = weave_of(named);
    weave.warp.tex = 40.0;
    const ClothMesh cloth = make_weave(kSwatch, weave, Material{});
    const WeaveLayout at(kSwatch, weave);
    double warps = 0.0, wefts = 0.0;
    for (const Spring& s : cloth.springs) {
      if (s.b != s.a + 1) continue;  // a contact
      (s.a < at.weft(0, 0) ? warps : wefts) += s.rest_length;
      EXPECT_NEAR((cloth.surface.vertices[s.b] - cloth.surface.vertices[s.a]).norm(), s.rest_length,
                  1e-15);
    }
    EXPECT_NEAR(total(cloth.mass), 40e-6 * warps + 20e-6 * wefts, 1e-12 * total(cloth.mass));
    // In whole repeats of the weave.
    const SwatchTrial trial{.weave = weave, .ends = 1875.0, .picks = 2000.0};
    if (at.wefts % (named.over + named.under) != 0) continue;
    const double straight = at.wefts / trial.picks;
    EXPECT_NEAR(warps / (at.warps * straight), 1.0 + trial.crimp().warp, 1e-9) << named.name;
  }
}

TEST(Weave, IsAtRest) {
  for (const NamedWeave& named : kWeaves) {
    WeaveConfig weave = weave_of(named);
    weave.crimp_share = 0.3;
    const ClothMesh cloth = make_weave(kSwatch, weave, Material{});
    const std::vector<Vec3> still(cloth.mass.size(), Vec3::Zero());
    std::vector<Vec3> f(cloth.mass.size());
    ForceSum forces(make_internal_forces(cloth), cloth.mass.size());
    forces.evaluate({cloth.surface.vertices, still, cloth.mass, 0.0}, f);
    double largest = 0.0;
    for (const Vec3& force : f) largest = std::max(largest, force.norm());
    EXPECT_LT(largest, 1e-8) << named.name;  // N; EA is 80 N
  }
}

TEST(Weave, RefusesYarnsThatDoNotFitAndWeavesThatDoNotHold) {
  const auto fault = [](const GridConfig& grid, const WeaveConfig& weave) -> std::string {
    try {
      make_weave(grid, weave, Material{});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const WeaveConfig plain{.warp = {}, .weft = {}};
  EXPECT_EQ(fault(kSwatch, plain), "");
  EXPECT_NE(fault({0.01, 0.002, 20, 15}, plain).find("warp yarns of 0.167"), std::string::npos);
  WeaveConfig weave = plain;
  weave.over = 3;
  weave.step = 2;
  EXPECT_NE(fault(kSwatch, weave).find("common divisor"), std::string::npos);
  weave = plain;
  weave.links = 3;
  EXPECT_NE(fault(kSwatch, weave).find("even"), std::string::npos);
}

TEST(Weave, IsAPatternOfScenesThatTakesNoLawOfASheet) {
  const auto weave = cloth_patterns().at("weave");
  const ClothMesh cloth = weave({{"over", 2.0}, {"warp_tex", 30.0}}, kSwatch, Material{});
  WeaveConfig twill{.over = 2, .warp = {.tex = 30.0}, .weft = {}};
  const ClothMesh same = make_weave(kSwatch, twill, Material{});
  EXPECT_EQ(cloth.mass, same.mass);
  EXPECT_EQ(cloth.surface.vertices, same.surface.vertices);
  Material sheet;
  sheet.bending_law = "hinge";
  EXPECT_THROW(weave(kSwatch, sheet), std::invalid_argument);
}

// -- tests of swatches ----------------------------------------------------------------------------

SwatchTrial small_strains() {
  SwatchTrial trial;
  trial.strain = 2e-4;
  trial.points = 2;
  return trial;
}

double tested(const SwatchTrial& trial, SwatchPull pull) {
  return initial_modulus(pull_swatch(trial, pull));
}

TEST(Swatch, OfPlainWeaveHasTheInitialModulusInClosedForm) {
  for (const std::int32_t links : {2, 4})
    for (const double share : {0.3, 0.5}) {
      SwatchTrial trial = small_strains();
      trial.picks = 2100.0;
      trial.weave.links = links;
      trial.weave.crimp_share = share;
      trial.weave.weft.tex = 25.0;
      const WarpWeft closed = trial.plain_modulus();
      EXPECT_NEAR(tested(trial, SwatchPull::warp), closed.warp, 3e-3 * closed.warp)
          << links << " links, share " << share;
      EXPECT_NEAR(tested(trial, SwatchPull::weft), closed.weft, 3e-3 * closed.weft)
          << links << " links, share " << share;
    }
}

TEST(Swatch, ApproachesTheFormulaOfLeafAndKandil) {
  SwatchTrial trial;
  trial.weave.weft.tex = 30.0;
  trial.weave.links = 1000;
  trial.weave.contact = 1e12;
  trial.weave.warp.modulus = trial.weave.weft.modulus = 3.6e13;
  trial.weave.warp.bending_share = trial.weave.weft.bending_share = 0.05e-4;
  const double p1 = 1.0 / trial.picks, p2 = 1.0 / trial.ends;  // along warp and weft
  const double l1 = std::hypot(p1, trial.weave.warp_crimp());
  const double l2 = std::hypot(p2, trial.weave.weft_crimp());
  const double b1 = trial.weave.warp.bending(), b2 = trial.weave.weft.bending();
  const double printed = 12.0 * b1 * p1 / (p2 * std::pow(l1, 3) * (1.0 - std::pow(p1 / l1, 2))) *
                         (1.0 + b2 * std::pow(l1, 3) * std::pow(p1 / l1, 2) /
                                    (b1 * std::pow(l2, 3) * std::pow(p2 / l2, 2)));
  EXPECT_NEAR(trial.plain_modulus().warp, printed, 1e-3 * printed);
}

TEST(Swatch, IsSoftAtFirstAndThenStiff) {
  SwatchTrial trial;
  trial.strain = 0.09;
  trial.points = 9;
  const std::vector<SwatchPoint> curve = pull_swatch(trial, SwatchPull::warp);
  for (std::size_t k = 2; k < curve.size(); ++k) {
    const auto slope = [&](std::size_t i) {
      return (curve[i].force - curve[i - 1].force) / (curve[i].strain - curve[i - 1].strain);
    };
    EXPECT_GT(slope(k), slope(k - 1)) << k;
  }
  // The weft takes over the crimp of the warp, and contracts.
  EXPECT_GT(curve.back().contraction, 0.3 * curve.back().strain);
  // In the end the yarns would bear the load alone.
  const double yarns = trial.ends * trial.weave.warp.stretch();
  const double last = (curve[9].force - curve[8].force) / (curve[9].strain - curve[8].strain);
  EXPECT_GT(last, 5.0 * initial_modulus(curve));
  EXPECT_LT(last, yarns);
}

TEST(Swatch, IsTheSameWithWarpAndWeftExchanged) {
  SwatchTrial trial = small_strains(), other = trial;
  trial.weave.warp.tex = other.weave.weft.tex = 28.0;
  trial.weave.crimp_share = 0.4;
  other.weave.crimp_share = 0.6;
  trial.ends = other.picks = 2000.0;
  const double a = tested(trial, SwatchPull::warp), b = tested(other, SwatchPull::weft);
  EXPECT_NEAR(a, b, 1e-5 * a);
  EXPECT_GT(std::abs(tested(trial, SwatchPull::weft) - a), 0.05 * a);
}

TEST(Swatch, OfATwillDiffersFromPlainAndHasNoClosedForm) {
  SwatchTrial trial = small_strains();
  const double plain = tested(trial, SwatchPull::warp);
  trial.weave.over = 2;
  const double twill = tested(trial, SwatchPull::warp);
  EXPECT_GT(std::abs(twill - plain), 0.02 * plain);
  EXPECT_THROW(trial.plain_modulus(), std::invalid_argument);
  trial.weave.over = 4;
  trial.weave.step = 2;
  EXPECT_GT(tested(trial, SwatchPull::warp), 1.2 * plain);  // the longer floats, the less crimp
}

TEST(Swatch, ShearsAsItsCrossingsAndYarnsInARow) {
  SwatchTrial trial = small_strains();
  trial.weave.links = 2;
  const double turning = trial.weave.rotation * trial.ends * trial.picks;
  EXPECT_NEAR(trial.shear_modulus(), turning, 1e-9 * turning);
  EXPECT_NEAR(tested(trial, SwatchPull::shear), turning, 1e-3 * turning);
  trial.weave.links = 4;
  trial.weave.rotation = 5e-5;  // so that the yarns bend
  const double closed = trial.shear_modulus();
  EXPECT_LT(closed, 0.9 * trial.weave.rotation * trial.ends * trial.picks);
  // The frame holds the ends of the yarns, which makes a narrow swatch stiffer.
  const double narrow = tested(trial, SwatchPull::shear);
  trial.crossings = 24;
  const double wide = tested(trial, SwatchPull::shear);
  EXPECT_NEAR(2.0 * wide - narrow, closed, 0.02 * closed);
}

TEST(Swatch, HandsItsCurvesToAnOrdinaryMesh) {
  SwatchTrial trial;
  trial.strain = 0.04;
  trial.points = 4;
  const auto warp = pull_swatch(trial, SwatchPull::warp);
  const auto weft = pull_swatch(trial, SwatchPull::weft);
  const auto shear = pull_swatch(trial, SwatchPull::shear);
  const Material m = material_of(trial, warp, weft, shear);
  EXPECT_NEAR(m.tension_curve.value(warp[2].strain), warp[2].force, 1e-9 * warp[2].force);
  EXPECT_NEAR(m.shear_curve.value(shear[3].strain), shear[3].force, 1e-9 * shear[3].force);
  EXPECT_NEAR(m.shear_stiffness, trial.shear_modulus(), 0.05 * trial.shear_modulus());
  const ClothMesh sheet = make_rectangular({0.2, 0.2, 8, 8}, m);
  EXPECT_NEAR(total(sheet.mass), 0.04 * trial.density(), 1e-12);
  EXPECT_FALSE(make_internal_forces(sheet).empty());
}

}  // namespace
}  // namespace selvedge::swatch_test
