// SPDX-License-Identifier: MIT
//
// Measured curves: the interpolant, the figures that a laboratory reads from it, and cloth that
// follows it in tension, shear and bending. Shear on triangles by the angle of warp and weft, the
// bending spring of Zhang 2012, and shear from the tensile test at 45°.
#include <selvedge/core/cloth/detail/chord_link.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/fabric_file.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>

namespace selvedge::measured_test {
namespace {

namespace fs = std::filesystem;
using Vectors = std::vector<Vec3>;
using Mat32 = Eigen::Matrix<double, 3, 2>;

constexpr double pi = std::numbers::pi;

std::string refusal_of(const std::function<void()>& make) {
  try {
    make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "was accepted";
}

#define EXPECT_HAS(sentence, part) \
  EXPECT_NE((sentence).find(part), std::string::npos) << "the sentence is: " << (sentence)

// -- the interpolant ------------------------------------------------------------------------------

/// Rising points whose secants differ up to a thousandfold.
MonotoneCurve steep_curve(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> exponent(-1.5, 1.5), step(0.1, 1.0);
  std::vector<double> x{0.0}, y{0.0};
  for (int i = 0; i < 12; ++i) {
    const double h = step(random);
    x.push_back(x.back() + h);
    y.push_back(y.back() + h * std::pow(10.0, exponent(random)));
  }
  return {x, y};
}

TEST(MonotoneCurve, PassesThroughItsPointsAndRisesEverywhere) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const MonotoneCurve curve = steep_curve(seed);
    for (std::size_t i = 0; i < curve.x().size(); ++i)
      EXPECT_NEAR(curve.value(curve.x()[i]), curve.y()[i], 1e-13 * curve.y().back());
    const double end = 1.2 * curve.x().back();
    for (int k = 0; k <= 5000; ++k)
      ASSERT_GT(curve.slope(end * k / 5000), 0.0) << "seed " << seed << ", sample " << k;
  }
}

TEST(MonotoneCurve, HasAContinuousSlopeAndTheExactIntegral) {
  const MonotoneCurve curve = steep_curve(5);
  for (const double knot : curve.x()) {
    const double off = 1e-9;
    EXPECT_NEAR(curve.slope(knot + off), curve.slope(knot - off), 1e-5 * curve.slope(knot));
  }
  // Simpson's rule is exact for a cubic, and the slope of the integral is the value.
  for (std::size_t i = 1; i < curve.x().size(); ++i) {
    const double a = curve.x()[i - 1], b = curve.x()[i], m = 0.5 * (a + b);
    const double simpson = (b - a) / 6.0 * (curve.value(a) + 4.0 * curve.value(m) + curve.value(b));
    EXPECT_NEAR(curve.work(b) - curve.work(a), simpson, 1e-12 * curve.work(b));
    const double h = 1e-6;
    EXPECT_NEAR((curve.value(m + h) - curve.value(m - h)) / (2.0 * h), curve.slope(m),
                1e-6 * curve.y().back());
  }
}

TEST(MonotoneCurve, IsOddAndStraightBeyondItsEnd) {
  const MonotoneCurve curve({0.0, 1.0, 2.0}, {0.0, 1.0, 5.0});
  EXPECT_EQ(curve.value(-1.3), -curve.value(1.3));
  EXPECT_EQ(curve.slope(-1.3), curve.slope(1.3));
  EXPECT_EQ(curve.work(-1.3), curve.work(1.3));
  EXPECT_NEAR(curve.value(3.0), 5.0 + curve.slope(2.0), 1e-14);
  EXPECT_EQ(curve.slope(7.0), curve.slope(2.0));
  EXPECT_NEAR(curve.work(3.0) - curve.work(2.0), 5.0 + 0.5 * curve.slope(2.0), 1e-14);
}

TEST(MonotoneCurve, RefusesPointsThatDoNotRise) {
  const auto refusal = [](std::vector<double> x, std::vector<double> y) {
    return refusal_of([&] { MonotoneCurve(x, y); });
  };
  EXPECT_HAS(refusal({0, 1, 2}, {0, 3, 3}), "point 2");
  EXPECT_HAS(refusal({0, 1, 1}, {0, 3, 4}), "point 2");
  EXPECT_HAS(refusal({0, 1}, {0.5, 3}), "begin at (0, 0)");
  EXPECT_HAS(refusal({0, 1}, {0, 3, 4}), "3 for 2");
  EXPECT_HAS(refusal({0}, {0}), "two points");
}

// -- figures of a test ----------------------------------------------------------------------------

TEST(TensionFigures, AreThoseOfTheCurve) {
  // f = F (α s + (1-α) s³) has LT = (1 + α)/2 and WT = LT F EMT/2.
  constexpr double emt = 0.05, f_end = 490.0, alpha = 0.4;
  std::vector<double> x, y;
  for (int i = 0; i <= 100; ++i) {
    const double s = i / 100.0;
    x.push_back(emt * s);
    y.push_back(f_end * (alpha * s + (1.0 - alpha) * s * s * s));
  }
  const TensionFigures figures = figures_of({x, y});
  EXPECT_EQ(figures.extension, emt);
  EXPECT_NEAR(figures.linearity, 0.7, 1e-4);
  EXPECT_NEAR(figures.work, 0.7 * 0.5 * f_end * emt, 1e-4 * f_end * emt);
  EXPECT_NEAR(figures_of({{0.0, 0.02, 0.05}, {0.0, 2.0, 5.0}}).linearity, 1.0, 1e-14);
}

TEST(TensionFigures, TheResilienceIsTheShareOfTheWorkThatComesBack) {
  // Pulled along s, released along s², with the work 1/2 and 1/3.
  const MonotoneCurve pull({0.0, 0.5, 1.0}, {0.0, 0.5, 1.0});
  TensionCurve release;
  for (int i = 0; i <= 200; ++i) {
    release.strain.push_back(i / 200.0);
    release.force.push_back(release.strain.back() * release.strain.back());
  }
  EXPECT_NEAR(resilience(pull, release), 2.0 / 3.0, 1e-4);
  // A residual strain: the return is straight from 0.4.
  EXPECT_NEAR(resilience(pull, {{0.4, 0.7, 1.0}, {0.0, 0.5, 1.0}}), 0.6, 1e-14);
  EXPECT_HAS(refusal_of([&] { resilience(pull, {{0.0, 0.8}, {0.0, 1.0}}); }), "end");
  EXPECT_HAS(refusal_of([&] { resilience(pull, {{0.0, 0.1, 1.0}, {0.0, 0.9, 1.0}}); }), "above");
}

// -- cloth ----------------------------------------------------------------------------------------

const MonotoneCurve warp_curve({0.0, 0.01, 0.03, 0.06}, {0.0, 2.0, 14.0, 80.0});
const MonotoneCurve weft_curve({0.0, 0.02, 0.04, 0.09}, {0.0, 6.0, 14.0, 44.0});
const MonotoneCurve angle_curve({0.0, 0.02, 0.06, 0.14}, {0.0, 1.5, 3.0, 6.0});
const MonotoneCurve moment_warp({0.0, 2.0, 6.0, 20.0}, {0.0, 6e-4, 1.2e-3, 2.4e-3});
const MonotoneCurve moment_weft({0.0, 2.0, 6.0, 20.0}, {0.0, 2e-4, 7e-4, 3e-3});

Material measured(const std::string& shear) {
  Material m;
  m.tension_curve = warp_curve;
  m.tension_weft = weft_curve;
  if (shear == "angle") m.shear_curve = angle_curve;
  m.shear_law = shear;
  m.bending_stiffness = 0.0;
  m.shear_stiffness = 40.0;
  set_curves(m);
  return m;
}

/// A grid of triangles whose inner vertices are moved at random.
TriangleMesh irregular() {
  TriangleMesh mesh = make_rectangular({0.6, 0.5, 6, 5}, {}).surface;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> move(-0.03, 0.03);
  for (Vec3& x : mesh.vertices)
    if (std::abs(x.x()) < 0.29 && std::abs(x.y()) < 0.24)
      x += Vec3(move(random), move(random), 0.0);
  return mesh;
}

std::vector<std::pair<std::string, ClothMesh>> meshes(const Material& m) {
  return {{"rectangular", make_rectangular({0.6, 0.5, 4, 3}, m)},
          {"triangular", make_triangular({0.6, 0.5, 4, 4}, m)},
          {"checkerboard", make_simplified({0.6, 0.5, 4, 3}, m, true)},
          {"arc", make_arc({0.3, 4, 12}, m)},
          {"woven disc", make_woven_disc(0.3, 10, m)},
          {"irregular", make_from_mesh(irregular(), irregular(), m)},
          {"garment", make_from_pattern(irregular(), irregular(), m)}};
}

double energy_of(const ClothMesh& cloth, const Vectors& x) {
  const Vectors still(x.size(), Vec3::Zero());
  double sum = 0.0;
  for (const auto& force : make_internal_forces(cloth))
    sum += force->energy({x, still, cloth.mass, 0.0});
  return sum;
}

double area_of(const ClothMesh& cloth) {
  return surface_area(cloth.surface.vertices, cloth.surface.triangles);
}

/// Energy per area if the flat cloth is mapped by F.
double density(const ClothMesh& cloth, const Mat32& f) {
  Vectors x = cloth.surface.vertices;
  for (Vec3& p : x) p = f * p.head<2>();
  return energy_of(cloth, x) / area_of(cloth);
}

TEST(MeasuredTension, WarpAndWeftOfAGridFollowTheirOwnCurves) {
  const ClothMesh cloth = make_rectangular({0.6, 0.5, 4, 3}, measured("twisting"));
  for (const double strain : {0.005, 0.02, 0.05, 0.1}) {
    Mat32 f = Mat32::Identity();
    f(0, 0) += strain;
    EXPECT_NEAR(density(cloth, f), warp_curve.work(strain), 1e-12);
    f = Mat32::Identity();
    f(1, 1) += strain;
    EXPECT_NEAR(density(cloth, f), weft_curve.work(strain), 1e-12);
    // Slack yarns keep the stiffness that they have at rest.
    f(1, 1) = 1.0 - strain;
    EXPECT_NEAR(density(cloth, f), 0.5 * weft_curve.slope_at_rest() * strain * strain, 1e-12);
  }
}

TEST(AngleShear, TrianglesOfAnyMeshStoreTheWorkOfTheThreeTests) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> part(-0.08, 0.08);
  for (const auto& [name, cloth] : meshes(measured("angle")))
    for (int i = 0; i < 5; ++i) {
      Mat32 f = Mat32::Identity();
      for (int k = 0; k < 6; ++k) f(k % 3, k / 3) += part(random);
      const double warp = f.col(0).norm() - 1.0, weft = f.col(1).norm() - 1.0;
      const double shear = std::acos(f.col(0).normalized().dot(f.col(1).normalized())) - 0.5 * pi;
      const auto tension = [](const MonotoneCurve& curve, double strain) {
        return strain > 0.0 ? curve.work(strain) : 0.5 * curve.slope_at_rest() * strain * strain;
      };
      EXPECT_NEAR(density(cloth, f),
                  tension(warp_curve, warp) + tension(weft_curve, weft) + angle_curve.work(shear),
                  1e-12)
          << name;
    }
}

// With the springs of edges, the shear stiffness is 3/8 of that of stretch whatever the material
// says.
TEST(AngleShear, ServesTheShearStiffnessOnTriangles) {
  Material m;
  m.shear_law = "angle";
  m.bending_stiffness = 0.0;
  constexpr double angle = 0.05;
  Mat32 f = Mat32::Identity();
  f(0, 1) = std::sin(angle);
  f(1, 1) = std::cos(angle);  // sides keep their length
  for (const double shear : {10.0, 40.0, 400.0})
    for (const double stretch : {100.0, 1000.0}) {
      m.shear_stiffness = shear;
      m.stretch_stiffness = stretch;
      for (const auto& [name, cloth] : meshes(m))
        EXPECT_NEAR(density(cloth, f), 0.5 * shear * angle * angle, 1e-12 * shear) << name;
    }
}

TEST(AngleShear, EqualsTheTwistingSpringsOfAGrid) {
  Material m;
  m.bending_stiffness = 0.0;
  m.stretch_weft = 300.0;
  const auto made = [&](const std::string& law) {
    m.shear_law = law;
    return make_rectangular({0.6, 0.5, 4, 3}, m);
  };
  std::mt19937 random(2);
  std::uniform_real_distribution<double> part(-0.2, 0.2);
  for (int i = 0; i < 5; ++i) {
    Mat32 f = Mat32::Identity();
    for (int k = 0; k < 6; ++k) f(k % 3, k / 3) += part(random);
    const double twisting = density(made("twisting"), f);
    EXPECT_NEAR(density(made("angle"), f), twisting, 1e-12 * twisting);
  }
}

/// The work of one cycle of shear from -angle to angle and back, with sides that keep their length.
double work_of_cycle(const ClothMesh& cloth, double angle) {
  const auto forces = make_internal_forces(cloth);
  const Vectors still(cloth.mass.size(), Vec3::Zero());
  const auto sheared = [&](double phi) {
    Vectors x = cloth.surface.vertices;
    for (Vec3& p : x) p = Vec3(p.x() + std::sin(phi) * p.y(), std::cos(phi) * p.y(), 0.0);
    return x;
  };
  const auto forces_at = [&](const Vectors& x) {
    Vectors f(x.size(), Vec3::Zero());
    for (const auto& force : forces) force->add_force({x, still, cloth.mass, 0.0}, f);
    return f;
  };
  constexpr int steps = 400;
  double work = 0.0;
  Vectors x = sheared(angle);
  for (const auto& force : forces) force->accept({x, still, cloth.mass, 0.0});
  for (int k = 1; k <= 2 * steps; ++k) {
    // The first cycle meets the loop, the second one is it.
    const Vectors next = sheared(angle * std::cos(4.0 * pi * k / (2 * steps)));
    const Vectors before = forces_at(x), after = forces_at(next);
    for (std::size_t i = 0; k > steps && i < x.size(); ++i)
      work -= 0.5 * (before[i] + after[i]).dot(next[i] - x[i]);
    x = next;
    for (const auto& force : forces) force->accept({x, still, cloth.mass, 0.0});
  }
  return work;
}

TEST(AngleShear, AGarmentLosesTheAreaOfTheShearLoop) {
  Material m = measured("angle");
  m.shear_friction = 0.5;
  const ClothMesh cloth = make_from_pattern(irregular(), irregular(), m);
  constexpr double angle = 0.14, yield = 0.0087;  // half a degree
  const double loop = 4.0 * m.shear_friction * (angle - yield) * area_of(cloth);
  EXPECT_NEAR(work_of_cycle(cloth, angle) / loop, 1.0, 0.01);
  m.shear_friction = 0.0;
  EXPECT_NEAR(work_of_cycle(make_from_pattern(irregular(), irregular(), m), angle) / loop, 0.0,
              1e-3);
}

TEST(AngleShear, AMeshWithoutWarpIsRefusedWithTheRemedy) {
  TriangleMesh bent = irregular();
  for (Vec3& x : bent.vertices) x.z() = x.x() * x.x();
  Material m;
  m.shear_law = "angle";
  const std::string refusal = refusal_of([&] { make_from_mesh(bent, bent, m); });
  EXPECT_HAS(refusal, "warp and weft");
  EXPECT_HAS(refusal, "rest_mesh");
  EXPECT_NO_THROW(make_from_mesh(bent, irregular(), m));
  m.stretch_law = "corotated";
  EXPECT_HAS(refusal_of([&] { make_from_mesh(bent, irregular(), m); }), "finite elements");
}

TEST(AngleShear, ACutLeavesOutTheTrianglesThatAreLost) {
  const ClothMesh cloth = make_rectangular({1, 1, 4, 4}, measured("angle"));
  const std::vector<Triangle> inside(cloth.surface.triangles.begin() + 3,
                                     cloth.surface.triangles.end());
  EXPECT_EQ(cut(cloth, inside).yarns.size(), inside.size());
}

TEST(MeasuredLaws, ForcesAreMinusTheGradientOfTheirEnergy) {
  Material m = measured("angle");
  m.bending_curve = moment_warp;
  m.bending_curve_weft = moment_weft;
  m.kawabata_rt = 0.6;
  m.shear_friction = 0.5;
  set_curves(m);
  for (const ClothMesh& cloth :
       {make_from_mesh(irregular(), irregular(), m), make_rectangular({0.6, 0.5, 4, 3}, m)}) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> move(-0.01, 0.01);
    Vectors x = cloth.surface.vertices;
    const Vectors still(x.size(), Vec3::Zero());
    for (Vec3& p : x) p += Vec3(move(random), move(random), move(random));
    for (const auto& force : make_internal_forces(cloth)) {
      Vectors f(x.size(), Vec3::Zero());
      force->add_force({x, still, cloth.mass, 0.0}, f);
      double scale = 0.0;
      for (const Vec3& v : f) scale = std::max(scale, v.norm());
      for (std::size_t i = 0; i < x.size(); i += 3)
        for (int k = 0; k < 3; ++k) {
          const double at = x[i][k], h = 1e-7;
          x[i][k] = at + h;
          const double above = force->energy({x, still, cloth.mass, 0.0});
          x[i][k] = at - h;
          const double below = force->energy({x, still, cloth.mass, 0.0});
          x[i][k] = at;
          EXPECT_NEAR(f[i][k], -(above - below) / (2.0 * h), 2e-6 * scale + 1e-9);
        }
    }
  }
}

TEST(MeasuredLaws, RefuseElementsWithoutTheirCurve) {
  YarnTriangle t{{0, 1, 2}, {{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}}, 10.0, 10.0, 5.0};
  const std::vector<SpringCurve> hooke(1);
  const auto stretch = [&] { make_yarn_stretch(std::vector{t}, hooke, 3); };
  const auto shear = [&] { make_yarn_shear(std::vector{t}, hooke, 3); };
  EXPECT_NO_THROW(stretch());
  EXPECT_NO_THROW(shear());
  t.shear_curve = 0;
  EXPECT_HAS(refusal_of(shear), "yarn triangle 0 names curve 0, which has no points");
  t.curve[1] = 1;
  EXPECT_HAS(refusal_of(stretch), "names curve 1, which the cloth does not have");
  t.rest[2] = {2.0, 0.0};
  EXPECT_HAS(refusal_of([&] { make_yarn_friction(std::vector{t}, 3); }), "area");
  const std::vector<detail::ChordLink> links{{0, 1, 1.0, 1.0, 1.0, 100.0, 0.0, 0}};
  EXPECT_HAS(refusal_of([&] { detail::make_chord_force(links, hooke, 2); }),
             "chord 0 names curve 0");
  const std::vector<detail::ChordLink> soft{{0, 1, 1.0, 1.0, 1.0, 0.1}};
  EXPECT_HAS(refusal_of([&] { detail::make_chord_force(soft, {}, 2); }), "onset");
}

// -- bending --------------------------------------------------------------------------------------

/// The cloth bent to a parabola along x or y, so flat that its curvature is κ everywhere.
Vectors bent_along(const ClothMesh& cloth, int axis, double kappa) {
  Vectors x = cloth.surface.vertices;
  for (Vec3& p : x) p.z() = 0.5 * kappa * p[axis] * p[axis];
  return x;
}

TEST(MeasuredBending, ACylinderStoresTheWorkOfTheCurveOfItsYarn) {
  constexpr double size = 2e-3;  // m: slopes up to 0.02
  Material m;
  m.stretch_stiffness = 1e-9;  // the parabola stretches
  m.shear_law = "angle";
  m.shear_stiffness = 0.0;
  m.bending_curve = moment_warp;
  m.bending_curve_weft = moment_weft;
  set_curves(m);
  Material linear = m;
  linear.bending_curve = linear.bending_curve_weft = {};
  TriangleMesh free = irregular();
  for (Vec3& x : free.vertices) x *= size / 0.6;
  const auto made = [&](const Material& material, bool grid) {
    return grid ? make_rectangular({size, size, 8, 8}, material)
                : make_from_mesh(free, free, material);
  };
  for (const bool grid : {true, false})
    for (const int axis : {0, 1}) {
      const MonotoneCurve& curve = axis == 0 ? moment_warp : moment_weft;
      for (const double kappa : {1.0, 4.0, 15.0}) {
        const Vectors x = bent_along(made(m, grid), axis, kappa);
        // The linear plate tells the area that is bent: borders turn freely.
        const double area =
            energy_of(made(linear, grid), x) / (0.5 * curve.slope_at_rest() * kappa * kappa);
        EXPECT_NEAR(energy_of(made(m, grid), x) / (area * curve.work(kappa)), 1.0, 2e-3)
            << (grid ? "grid, " : "free mesh, ") << "axis " << axis << ", curvature " << kappa;
      }
    }
}

// F at the distance of the ends r = 2d cos(θ/2), with the lever d sin(θ/2) about the middle.
TEST(ChordLink, TheForceHasTheMomentOfTheTestAboutTheMiddleParticle) {
  constexpr double d = 0.01, w = 0.02, b = 1e-5;
  const std::vector<SpringCurve> curves{{.law = "measured", .measured = moment_warp}};
  for (const std::int32_t curve : {-1, 0}) {
    const double rigidity = curve < 0 ? b : moment_warp.slope_at_rest();
    const std::vector<detail::ChordLink> links{{0, 1, d, w, rigidity, 1e4, 0.0, curve}};
    const auto force = detail::make_chord_force(links, curves, 2);
    const std::vector<double> mass(2, 1.0);
    const Vectors still(2, Vec3::Zero());
    for (const double theta : {0.1, 0.5, 1.0, 2.0, 3.0}) {
      const double kappa = theta / d, r = 2.0 * d * std::cos(0.5 * theta);
      const double moment = curve < 0 ? b * kappa : moment_warp.value(kappa);
      Vectors x{Vec3::Zero(), Vec3(r, 0.0, 0.0)}, f(2, Vec3::Zero());
      force->add_force({x, still, mass, 0.0}, f);
      EXPECT_NEAR(f[1].x() * d * std::sin(0.5 * theta) / (moment * w), 1.0, 1e-9) << theta;
      EXPECT_EQ((f[0] + f[1]).norm(), 0.0);
    }
  }
}

TEST(ChordLink, AStraightStripBearsTwiceItsRigidityOverTheSquaredCell) {
  constexpr double d = 0.01, w = 0.02, b = 1e-5;
  const std::vector<detail::ChordLink> links{{0, 1, d, w, b, 1e9, 0.0, -1}};
  const auto force = detail::make_chord_force(links, {}, 2);
  const std::vector<double> mass(2, 1.0);
  const Vectors still(2, Vec3::Zero());
  Vectors x{Vec3::Zero(), Vec3(2.0 * d * (1.0 - 1e-9), 0.0, 0.0)}, f(2, Vec3::Zero());
  force->add_force({x, still, mass, 0.0}, f);
  EXPECT_NEAR(f[1].x() / (2.0 * b * w / (d * d)), 1.0, 1e-6);
  x[1].x() = 2.0 * d * 1.01;  // slack under tension
  f.assign(2, Vec3::Zero());
  force->add_force({x, still, mass, 0.0}, f);
  EXPECT_EQ(f[1].norm(), 0.0);
}

TEST(ChordLink, ARolledGridStoresTheWorkOfTheCurve) {
  constexpr int cells = 10;
  constexpr double cell = 2e-3;
  Material m;
  m.bending_law = "chord";
  m.bending_curve = moment_warp;
  m.bending_curve_weft = moment_weft;
  m.stretch_stiffness = 1e7;  // the onset ends early
  set_curves(m);
  const ClothMesh cloth = make_rectangular({cells * cell, cells * cell, cells, cells}, m);
  const auto rolled = [&](double kappa) {
    Vectors x = cloth.surface.vertices;
    const double step = kappa * cell, radius = 0.5 * cell / std::sin(0.5 * step);
    for (Vec3& p : x) {
      const double s = p.x() / cell * step;
      p = Vec3(radius * std::sin(s), p.y(), radius * (1.0 - std::cos(s)));
    }
    return energy_of(cloth, x);
  };
  const double area = (cells - 1) * cell * cells * cell;
  EXPECT_NEAR((rolled(150.0) - rolled(60.0)) / area,
              moment_warp.work(150.0) - moment_warp.work(60.0), 1e-6 * moment_warp.work(150.0));
}

// -- shear at 45 degrees --------------------------------------------------------------------------

/// Force per width of a sheet pulled at 45° to strain ε, free to narrow, and the shear angle.
struct BiasPull {
  double force, angle;
};
BiasPull pull_at_45(const ClothMesh& cloth, double strain) {
  const Mat32 bias = (Mat32() << 1.0, 1.0, -1.0, 1.0, 0.0, 0.0).finished() / std::numbers::sqrt2;
  const auto energy = [&](double along, double across) {
    Mat3 stretch = Mat3::Identity();
    stretch(0, 0) = along;
    stretch(1, 1) = across;
    return density(cloth, stretch * bias);
  };
  double low = 0.3, high = 1.2;
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  for (int i = 0; i < 100; ++i) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    (energy(1.0 + strain, a) < energy(1.0 + strain, b) ? high : low) =
        energy(1.0 + strain, a) < energy(1.0 + strain, b) ? b : a;
  }
  const double across = 0.5 * (low + high), h = 1e-6;
  const double force =
      (energy(1.0 + strain + h, across) - energy(1.0 + strain - h, across)) / (2.0 * h);
  return {force, 0.5 * pi - 2.0 * std::atan2(across, 1.0 + strain)};
}

TEST(BiasTest, TheCompliancesOfYarnsAndShearAddUp) {
  EXPECT_NEAR(shear_of_bias(4.0 / (1.0 / 500.0 + 1.0 / 300.0 + 1.0 / 40.0), {500.0, 300.0}), 40.0,
              1e-12);
  Material m;
  m.shear_law = "angle";
  m.bending_stiffness = 0.0;
  m.stretch_stiffness = 500.0;
  m.shear_stiffness = 40.0;
  const ClothMesh cloth = make_from_mesh(irregular(), irregular(), m);
  constexpr double strain = 1e-4;
  const double modulus = pull_at_45(cloth, strain).force / strain;
  EXPECT_NEAR(shear_of_bias(modulus, {500.0, 500.0}), 40.0, 0.05);
  EXPECT_HAS(refusal_of([] { shear_of_bias(1000.0, {500.0, 300.0}); }), "45 degrees");
}

TEST(BiasTest, RecoversTheShearCurveOfTheCloth) {
  Material m;
  m.shear_curve = angle_curve;
  m.bending_stiffness = 0.0;
  m.stretch_stiffness = 5e3;
  set_curves(m);
  const ClothMesh cloth = make_from_mesh(irregular(), irregular(), m);
  TensionCurve bias{{0.0}, {0.0}};
  for (const double strain : {0.01, 0.02, 0.04, 0.06}) {
    bias.strain.push_back(strain);
    bias.force.push_back(pull_at_45(cloth, strain).force);
  }
  const MonotoneCurve shear = shear_of_bias(bias, {5e3, 5e3});
  for (std::size_t i = 1; i < bias.strain.size(); ++i) {
    const double angle = pull_at_45(cloth, bias.strain[i]).angle;
    EXPECT_NEAR(shear.x()[i], angle, 3e-3 * angle);
    EXPECT_NEAR(shear.y()[i], angle_curve.value(angle), 5e-3 * shear.y()[i]);
  }
}

// -- scenes and fabric files ----------------------------------------------------------------------

class MeasuredScene : public ::testing::Test {
 protected:
  MeasuredScene()
      : folder_(fs::temp_directory_path() / ("measured_test_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~MeasuredScene() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  Scene scene(const std::string& piece, const std::string& material) const {
    write("scene.json", R"({"geometry": [{"material": "m", )" + piece +
                            R"(}], "materials": {"m": )" + material + "}}");
    return read_scene(folder_ / "scene.json");
  }
  std::string refusal(const std::string& piece, const std::string& material) const {
    return refusal_of([&] { build_scene(scene(piece, material)); });
  }

  const std::string grid_ = R"("cells": [4, 4])";
  const std::string triangles_ = R"("cells": [4, 4], "pattern": "triangular")";
  // A roof, whose rest shape has no warp.
  const std::string roof_ =
      R"("mesh": {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]],
         "triangles": [[0, 1, 2], [1, 3, 2]]})";
  fs::path folder_;
};

TEST_F(MeasuredScene, CurvesWithUnitsAndInCsvFilesReachTheCloth) {
  write("weft.csv", "strain in %, force in gf/cm\n# second reading\n0, 0\n2, 100\n6, 500\n");
  const Scene s = scene(grid_, R"json({"fabric": {"source": "us",
    "measured_tension": {
      "warp": {"strain": [0, 1, 3], "strain_unit": "%", "force": [0, 50, 400], "force_unit": "gf/cm",
               "return": {"strain": [0.5, 2, 3], "force": [0, 100, 400]}},
      "weft": {"file": "weft.csv", "strain_unit": "%", "force_unit": "gf/cm"}},
    "measured_shear": {"angle": [0, 4, 8], "angle_unit": "deg", "force": [0, 3, 7], "force_unit": "gf/cm"},
    "measured_bending": {"curvature": [0, 1, 2.5], "curvature_unit": "1/cm",
                         "moment": [0, 0.1, 0.2], "moment_unit": "gf*cm/cm"}}})json");
  const Material& m = s.materials.at("m");
  constexpr double gf_per_cm = 0.980665;
  EXPECT_EQ(m.stretch_law, "measured");
  EXPECT_EQ(m.shear_law, "angle");
  EXPECT_NEAR(m.tension_curve.value(0.03), 400 * gf_per_cm, 1e-9);
  EXPECT_NEAR(m.tension_weft.value(0.02), 100 * gf_per_cm, 1e-9);
  EXPECT_NEAR(m.shear_curve.value(8 * pi / 180), 7 * gf_per_cm, 1e-9);
  EXPECT_NEAR(m.bending_curve.value(250.0), 0.2 * 9.80665e-3, 1e-12);
  EXPECT_EQ(m.stretch_stiffness, m.tension_curve.slope_at_rest());
  EXPECT_EQ(stretch_along_weft(m), m.tension_weft.slope_at_rest());
  EXPECT_EQ(m.bending_stiffness, m.bending_curve.slope_at_rest());
  EXPECT_GT(m.kawabata_rt, 0.5);
  EXPECT_LT(m.kawabata_rt, 0.9);
  const ClothMesh cloth = build_scene(s).cloth;
  EXPECT_EQ(cloth.yarns.size(), 32u);
  EXPECT_FALSE(cloth.curvature_curves.empty());
}

TEST_F(MeasuredScene, TheCompletedSceneIsReadAgainWithTheSameCurves) {
  const std::string material = R"({"stretch_law": "measured", "shear_law": "angle",
    "tension_curve": [[0, 0], [0.01, 2], [0.03, 11]],
    "shear_curve": [[0, 0], [0.1, 3], [0.2, 5]],
    "bending_curve": [[0, 0], [100, 0.001], [250, 0.002]]})";
  const Scene first = scene(triangles_, material);
  write("again.json", first.json);
  const Scene second = read_scene(folder_ / "again.json");
  EXPECT_EQ(second.json, first.json);
  const Material &a = first.materials.at("m"), &b = second.materials.at("m");
  EXPECT_EQ(a.tension_curve, b.tension_curve);
  EXPECT_EQ(a.shear_stiffness, b.shear_stiffness);
  EXPECT_EQ(build_scene(first).warnings.size(), build_scene(second).warnings.size());
}

TEST_F(MeasuredScene, ShearThatTheSpringsOfTrianglesCannotServeIsNamed) {
  const auto warnings = [&](const std::string& piece, const std::string& material) {
    std::string all;
    for (const std::string& w : build_scene(scene(piece, material)).warnings) all += w + "\n";
    return all;
  };
  const std::string named = R"({"shear_stiffness": 12})";
  EXPECT_HAS(warnings(triangles_, named), "shear_stiffness 12 N/m has no effect");
  EXPECT_EQ(warnings(triangles_, "{}").find("shear_stiffness"), std::string::npos);
  EXPECT_EQ(warnings(grid_, named).find("shear_stiffness"), std::string::npos);
  for (const char* served : {R"({"shear_stiffness": 12, "shear_law": "angle"})",
                             R"({"shear_stiffness": 12, "stretch_law": "corotated"})"})
    EXPECT_EQ(warnings(triangles_, served).find("shear_stiffness"), std::string::npos);
}

TEST_F(MeasuredScene, RefusesWhatItCannotServeWithPlaceAndRemedy) {
  const std::string curve = R"("tension_curve": [[0, 0], [0.1, 5]])";
  EXPECT_HAS(refusal(roof_, R"({"shear_law": "angle"})"), "geometry[0]");
  EXPECT_HAS(refusal(roof_, R"({"shear_law": "angle"})"), "rest_mesh");
  EXPECT_HAS(refusal(grid_, "{" + curve + "}"), "stretch_law \"measured\"");
  EXPECT_HAS(refusal(grid_, R"({"stretch_law": "measured"})"), "tension_curve");
  EXPECT_HAS(refusal(triangles_, R"({"stretch_law": "measured", )" + curve + "}"), "\"angle\"");
  EXPECT_HAS(
      refusal(grid_, R"({"stretch_law": "measured", "stretch_stiffness": 7, )" + curve + "}"),
      "materials.m.stretch_stiffness: is the slope at rest of tension_curve, 50");
  EXPECT_HAS(refusal(grid_, R"({"shear_curve": [[0, 0], [0.1, 5]]})"), "angle");
  EXPECT_HAS(refusal(grid_, R"({"stretch_law": "measured",
                                "tension_curve": [[0, 0], [0.2, 5], [0.1, 6]]})"),
             "materials.m.tension_curve: a measured curve must rise");
  EXPECT_HAS(refusal(triangles_, R"({"bending_law": "chord"})"), "rows of particles");
  const std::string split = grid_ + R"(, "refine": {"when": "curved"})";
  EXPECT_HAS(refusal(split, R"({"shear_law": "angle", "shear_friction": 1})"), "refine");
  EXPECT_EQ(refusal(split, R"({"shear_law": "angle"})"), "was accepted");
}

TEST_F(MeasuredScene, TheTestAt45DegreesGivesTheShearOfAFabric) {
  const Fabric f = parse_fabric(R"json({"source": "us", "stretch": {"value": 5000, "unit": "N/m"},
    "bias_tension": {"strain": [0, 1, 2], "strain_unit": "%", "force": [0, 1.6, 3.0],
                     "force_unit": "N/m"}})json",
                                "sheet");
  EXPECT_EQ(f.material.shear_law, "angle");
  // 4/E45 = 2/5000 + 1/G at 1 % of strain, 160 N/m.
  EXPECT_NEAR(f.material.shear_stiffness, 1.0 / (4.0 / 160.0 - 2.0 / 5000.0), 1.0);
}

}  // namespace
}  // namespace selvedge::measured_test
