// SPDX-License-Identifier: MIT
//
// The internal forces beside Hooke and the hinge: whole meshes of them, closed forms. What holds
// for each of them in any state is in internal_force_test.
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/core/cloth/fabric.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "dense_force.h"

namespace selvedge::force_test {
namespace {

constexpr double pi = std::numbers::pi;

/// Central differences of fourth order: error (step/size)⁴ and rounding 1e-16·size/step.
template <class F>
auto derivative(double& u, double step, const F& f) {
  const double old = u;
  u = old + step;
  const auto p1 = f();
  u = old - step;
  const auto m1 = f();
  u = old + 2.0 * step;
  const auto p2 = f();
  u = old - 2.0 * step;
  const auto m2 = f();
  u = old;
  using Value = std::decay_t<decltype(p1)>;
  return Value((8.0 * (p1 - m1) - (p2 - m2)) / (12.0 * step));
}

Eigen::MatrixXd differences(const Force& force, ForceStateOwner state, bool velocity, double step) {
  const std::size_t n = state.x.size();
  Eigen::MatrixXd dense(3 * n, 3 * n);
  Vectors& u = velocity ? state.v : state.x;
  for (std::size_t k = 0; k < 3 * n; ++k)
    dense.col(k) = derivative(u[k / 3][k % 3], step, [&] {
      const Vectors f = force_at(force, state);
      return Eigen::VectorXd(flat(f));
    });
  return dense;
}

struct Case {
  std::string name;
  Material material;
};

/// One material for each law, all of it in the mesh that make_rectangular makes.
std::vector<Case> cases() {
  std::vector<Case> all;
  const auto add = [&](const char* name, auto set) {
    Material m;
    m.bending_stiffness = 1e-3;
    m.spring_damping = 0.02;
    set(m);
    all.push_back({name, m});
  };
  add("tension only", [](Material& m) { m.stretch_law = "tension_only"; });
  add("biphasic", [](Material& m) { m.stretch_law = "biphasic"; });
  add("kawabata", [](Material& m) { m.stretch_law = "kawabata"; });
  add("bridson", [](Material& m) { m.bending_law = "bridson"; });
  add("buckling", [](Material& m) { m.bending_law = "buckling"; });
  add("twisting bend", [](Material& m) { m.bending_law = "twisting"; });
  add("twisting shear", [](Material& m) { m.shear_law = "twisting"; });
  add("hysteresis", [](Material& m) {
    m.shear_law = "twisting";
    m.shear_friction = 1.0;
    m.bending_friction = 0.01;
  });
  return all;
}

struct Crumple : ForceStateOwner {
  ClothMesh cloth;
  std::vector<std::unique_ptr<Force>> forces;
  Crumple(const Material& material, double noise, unsigned seed)
      : cloth(make_rectangular({0.5, 0.4, 5, 4}, material)), forces(make_internal_forces(cloth)) {
    mass = cloth.mass;
    x = random_vectors(mass.size(), noise, seed);
    v = random_vectors(mass.size(), 1.0, seed + 1);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += cloth.surface.vertices[i];
  }
};

TEST(InternalForces, OfAWholeMeshAreTheNegativeGradientOfTheirEnergy) {
  for (const auto& [name, material] : cases())
    for (unsigned seed = 1; seed <= 3; ++seed) {
      Crumple c(material, 0.03, seed);
      c.v.assign(c.v.size(), Vec3::Zero());
      for (const auto& force : c.forces) {
        const Vectors f = force_at(*force, c);
        const double scale = flat(f).cwiseAbs().maxCoeff();
        for (std::size_t k = 0; k < 3 * c.x.size(); ++k) {
          const double slope =
              derivative(c.x[k / 3][k % 3], 1e-6, [&] { return force->energy(c.view()); });
          EXPECT_NEAR(f[k / 3][k % 3], -slope, 2e-7 * scale) << name << ", seed " << seed;
        }
      }
    }
}

/// A state whose springs are all stretched: nothing is dropped from the Jacobian.
TEST(CurveSprings, TheJacobianOfStretchedSpringsIsExact) {
  for (const auto& [name, material] : cases()) {
    if (material.stretch_law == "hooke") continue;
    Crumple c(material, 0.004, 5);
    c.v.assign(c.v.size(), Vec3::Zero());
    for (Vec3& x : c.x) x *= 1.3;
    const Eigen::MatrixXd exact = differences(*c.forces[0], c, false, 1e-6);
    Material undamped = material;
    undamped.spring_damping = 0.0;
    const auto forces = make_internal_forces(make_rectangular({0.5, 0.4, 5, 4}, undamped));
    EXPECT_LT((assembled(*forces[0], c, 1.0) + exact).norm(), 1e-6 * exact.norm()) << name;
  }
}

/// Tension of one spring of rest length 1 and stiffness 100 at length L.
double tension(const SpringCurve& curve, double length) {
  const std::vector<Spring> spring{{0, 1, 1.0, 100.0}};
  const auto force = make_curve_force(spring, curve, 2);
  const ForceStateOwner s{{{0, 0, 0}, {length, 0, 0}}, {Vec3::Zero(), Vec3::Zero()}, {1.0, 1.0}};
  return force_at(*force, s)[0].x();
}

TEST(CurveSprings, TensionOnlyGivesWayUnderCompression) {
  EXPECT_NEAR(tension({"tension_only"}, 1.2), 20.0, 1e-12);
  EXPECT_EQ(tension({"tension_only"}, 0.8), 0.0);
}

TEST(CurveSprings, BiphasicGrowsInProportionToTheStretchBeyondItsThreshold) {
  const SpringCurve curve{"biphasic", 0.05, 10.0};
  EXPECT_NEAR(tension(curve, 1.04), 4.0, 1e-12);
  EXPECT_NEAR(tension(curve, 1.15), 100.0 * 0.15 * (1.0 + 10.0 * 0.10), 1e-12);
  EXPECT_NEAR(tension(curve, 0.9), -10.0, 1e-12);
}

TEST(CurveSprings, TheKawabataCurveHasItsLinearityAndExtension) {
  constexpr double lt = 0.65, emt = 0.06;
  const SpringCurve curve{"kawabata", emt, lt};
  const double end = tension(curve, 1.0 + emt);
  constexpr int n = 2000;
  double work = 0.0;
  for (int i = 0; i < n; ++i) work += tension(curve, 1.0 + emt * (i + 0.5) / n) * emt / n;
  EXPECT_NEAR(work / (0.5 * end * emt), lt, 1e-6);  // LT = WT/(½ F EMT)
  EXPECT_NEAR(end, 100.0 * emt / (2.0 * lt - 1.0), 1e-10);
  // Beyond the test it goes on with the slope it ended with.
  const double slope = (end - tension(curve, 1.0 + emt - 1e-7)) / 1e-7;
  EXPECT_NEAR(tension(curve, 1.0 + 2.0 * emt), end + slope * emt, 1e-3 * end);
}

TEST(CurveSprings, ALinearKawabataCurveIsHooke) {
  const SpringCurve curve{"kawabata", 0.05, 1.0};
  for (const double length : {0.9, 1.01, 1.05, 1.2})
    EXPECT_NEAR(tension(curve, length), 100.0 * (length - 1.0), 1e-12);
}

TEST(CurveSprings, BadCurvesAreRefused) {
  const std::vector<Spring> spring{{0, 1, 1.0, 100.0}}, loop{{1, 1, 1.0, 1.0}};
  EXPECT_THROW(make_curve_force(spring, {"kawabata", 0.05, 0.5}, 2), std::invalid_argument);
  EXPECT_THROW(make_curve_force(spring, {"kawabata", 0.0, 0.7}, 2), std::invalid_argument);
  EXPECT_THROW(make_curve_force(spring, {"biphasic", 0.1, -1.0}, 2), std::invalid_argument);
  EXPECT_THROW(make_curve_force(loop, {"biphasic", 0.1, 1.0}, 2), std::invalid_argument);
}

/// Force that pulls the ends of a link of length 1 and rigidity 1 together, at distance r.
struct OneLink {
  std::unique_ptr<Force> force;
  explicit OneLink(double onset) {
    const std::vector<BucklingLink> link{{0, 1, 1.0, 1.0, onset}};
    force = make_buckling_force(link, 2);
  }
  ForceStateOwner at(double r) const {
    return {{{0, 0, 0}, {r, 0, 0}}, {Vec3::Zero(), Vec3::Zero()}, {1.0, 1.0}};
  }
  double push(double r) const { return -force_at(*force, at(r))[0].x(); }
  double energy(double r) const { return force->energy(at(r).view()); }
};

TEST(BucklingLinks, CarryTwelveTimesTheirRigidityWhenTheyBuckle) {
  // -12 k/L², 21.6 % above Euler's load π² k/L².
  const OneLink link(1e9);
  EXPECT_NEAR(link.push(1.0 - 1e-7), 12.0, 1e-5);
  EXPECT_NEAR(link.push(1.0 - 1e-7) / (pi * pi), 1.216, 5e-4);
  EXPECT_EQ(link.push(1.001), 0.0);
}

TEST(BucklingLinks, BendToAnArcOfTheirLength) {
  const OneLink link(1e9);
  for (const double u : {0.02, 0.029, 0.031, 0.3, 1.0, pi / 2, 2.5, 3.1}) {
    const double r = std::sin(u) / u, kappa = 2.0 * u;
    EXPECT_NEAR(link.push(r), kappa * kappa / (r - std::cos(u)), 1e-8 * link.push(r)) << u;
    EXPECT_NEAR(link.energy(r), 0.5 * kappa * kappa, 1e-6) << u;
  }
  EXPECT_NEAR(link.push(1e-9), 4.0 * pi * pi, 1e-6);  // a closed ring
}

TEST(BucklingLinks, TheForceHasNoJumpAndTheMatrixItsSlope) {
  OneLink link(2000.0);
  double before = link.push(1.0);
  constexpr int n = 4000;
  for (int i = 1; i <= n; ++i) {
    const double now = link.push(1.0 - 0.05 * i / n);
    EXPECT_LE(std::abs(now - before), 2000.0 * 0.05 / n + 1e-9);
    before = now;
  }
  for (const double r : {0.999, 0.9, 0.5, 0.1}) {
    ForceStateOwner s = link.at(r);
    const double slope =
        derivative(s.x[1].x(), 1e-6, [&] { return force_at(*link.force, s)[1].x(); });
    EXPECT_NEAR(assembled(*link.force, s, 1.0)(3, 3), -slope, 1e-6 * std::abs(slope)) << r;
  }
}

TEST(BucklingLinks, AnOnsetTooSoftToMeetTheArcIsRefused) {
  const std::vector<BucklingLink> soft{{0, 1, 1.0, 1.0, 39.0}}, loop{{1, 1, 1.0, 1.0, 100.0}};
  EXPECT_THROW(make_buckling_force(soft, 2), std::invalid_argument);
  EXPECT_THROW(make_buckling_force(loop, 2), std::invalid_argument);
}

TEST(TwistSprings, BendAsABeamUnderAnEndCouple) {
  // Links of 0.2 and 0.5 m turned by α: M = k α, F = M/l across each link.
  constexpr double alpha = 0.3, k = 2.0;
  const std::vector<TwistSpring> springs{{{0, 1, 2}, 0.0, k}};
  const auto force = make_twist_force(springs, 3);
  const ForceStateOwner s{
      {{-0.2, 0, 0}, {0, 0, 0}, {0.5 * std::cos(alpha), 0.5 * std::sin(alpha), 0}},
      {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()},
      {1, 1, 1}};
  const Vectors f = force_at(*force, s);
  EXPECT_NEAR((f[0] - Vec3(0, -k * alpha / 0.2, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((f[2] - k * alpha / 0.5 * Vec3(std::sin(alpha), -std::cos(alpha), 0)).norm(), 0.0,
              1e-12);
  EXPECT_NEAR(force->energy(s.view()), 0.5 * k * alpha * alpha, 1e-14);
}

TEST(TwistSprings, TheJacobianIsExactOnALineAndAtRest) {
  const ForceStateOwner straight{{{-0.2, 0, 0}, {0, 0, 0}, {0.5, 0, 0}},
                                 {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()},
                                 {1, 1, 1}};
  ForceStateOwner corner = straight;
  corner.x[2] = {0.01, 0.3, 0.02};
  const double angle = std::acos(corner.x[2].normalized().x());
  for (const auto& [state, rest] : {std::pair{straight, 0.0}, std::pair{corner, angle}}) {
    const std::vector<TwistSpring> springs{{{0, 1, 2}, rest, 2.0}};
    const auto force = make_twist_force(springs, 3);
    const Eigen::MatrixXd exact = differences(*force, state, false, 1e-5);
    EXPECT_LT((assembled(*force, state, 1.0) + exact).norm(), 1e-7 * exact.norm()) << rest;
  }
}

TEST(TwistSprings, BadOnesAreRefused) {
  const auto make = [](const TwistSpring& spring) {
    const std::vector<TwistSpring> springs{spring};
    make_twist_force(springs, 3);
  };
  EXPECT_THROW(make({{0, 1, 3}, 0.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(make({{0, 1, 0}, 0.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(make({{0, 1, 2}, 4.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(make({{0, 1, 2}, 0.0, -1.0}), std::invalid_argument);
}

/// A hinge whose angle is `angle`.
ForceStateOwner folded(double angle) {
  return {{{0, -1, 0}, {0, std::cos(angle), -std::sin(angle)}, {-1, 0, 0}, {1, 0, 0}},
          Vectors(4, Vec3::Zero()),
          {1, 1, 1, 1}};
}

/// Moment of a force on the hinge, positive when it folds it further.
double moment_of(const Force& force, double angle) {
  const ForceStateOwner s = folded(angle);
  const detail::Dihedral d = detail::dihedral(s.x, {0, 1, 2, 3});
  return force_at(force, s)[0].dot(d.gradient[0]) / d.gradient[0].squaredNorm();
}

TEST(Hysteresis, ALoopIsTwiceTheFrictionWideAndLosesItsArea) {
  constexpr double friction = 0.5, yield = 0.01, most = 0.4;
  const std::vector<HingeFriction> slider{{{0, 1, 2, 3}, 0.0, friction, yield}};
  const auto force = make_hinge_friction(slider, 4);
  std::vector<double> way;  // to most, back to -most, and to most
  constexpr int steps = 400;
  for (int i = 0; i <= steps; ++i) way.push_back(most * i / steps);
  for (int i = 0; i <= 2 * steps; ++i) way.push_back(most - 2 * most * i / (2.0 * steps));
  for (int i = 0; i <= 2 * steps; ++i) way.push_back(-most + 2 * most * i / (2.0 * steps));
  double lost = 0.0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const double before = moment_of(*force, way[i - 1]);
    force->accept(folded(way[i]).view());
    const double after = moment_of(*force, way[i]);
    if (i > steps) lost -= 0.5 * (before + after) * (way[i] - way[i - 1]);
    if (std::abs(way[i]) < 0.5 * most && i > steps) {
      EXPECT_NEAR(after, way[i] > way[i - 1] ? -friction : friction, 1e-12);
    }
  }
  EXPECT_NEAR(lost, 2.0 * friction * 2.0 * (most - yield), 0.01);
}

TEST(Hysteresis, NothingIsForgottenUntilAStepIsAccepted) {
  const std::vector<HingeFriction> slider{{{0, 1, 2, 3}, 0.0, 0.5, 0.01}};
  const auto force = make_hinge_friction(slider, 4);
  const double there = moment_of(*force, 0.3);
  EXPECT_EQ(moment_of(*force, 0.0), 0.0);
  EXPECT_EQ(moment_of(*force, 0.3), there);
  force->accept(folded(0.3).view());
  EXPECT_NEAR(moment_of(*force, 0.0), 0.5, 1e-12);  // it would now be bent back by force only
}

TEST(Hysteresis, IntegratorsTellTheForcesWhereAStepEnded) {
  const std::vector<HingeFriction> slider{{{0, 1, 2, 3}, 0.0, 0.5, 0.01}};
  const ForceStateOwner flat_state = folded(0.0);
  const Particles particles{flat_state.x, flat_state.v, flat_state.mass, {1, 1, 1, 1}};
  const auto speed_after_a_step = [&](auto& integrator, const auto& step) {
    integrator.accept(folded(0.3).view());
    Vectors v(4, Vec3::Zero());
    step(v);
    return v[0].norm();
  };
  std::vector<std::unique_ptr<Force>> one, other;
  one.push_back(make_hinge_friction(slider, 4));
  other.push_back(make_hinge_friction(slider, 4));
  const auto symplectic = integrators().at("symplectic_euler")(std::move(one), 4, ImplicitConfig{});
  EXPECT_GT(speed_after_a_step(*symplectic,
                               [&](Vectors& v) {
                                 symplectic->begin({particles, 0.0, 0.01}, {v, {}});
                               }),
            1e-3);
  const auto implicit = integrators().at("implicit_euler")(std::move(other), 4, ImplicitConfig{});
  EXPECT_GT(speed_after_a_step(*implicit,
                               [&](Vectors& v) {
                                 implicit->begin({particles, 0.0, 0.01}, {});
                                 implicit->solve({}, {v, {}}, 1.0);
                               }),
            1e-3);
}

TEST(Hysteresis, UnloadedClothKeepsTheCurvatureHBOverB) {
  // Matsudaira's cotton broad: B = 0.118 gf cm²/cm, 2HB = 0.124 gf cm/cm, 52.5 1/m.
  KesSheet sheet;
  sheet.bending = 0.118;
  sheet.bending_hysteresis = 0.124;
  const Material m = material_of(sheet);
  EXPECT_NEAR(m.bending_stiffness, 1.157e-5, 1e-8);
  EXPECT_NEAR(m.bending_friction / m.bending_stiffness, 52.5, 0.05);
  // A strip of cells of 2 mm rolled to 150 1/m and let go to κ: all hinges along y balance at HB/B.
  constexpr double cell = 0.002;
  ClothMesh cloth = make_rectangular({8 * cell, 4 * cell, 8, 4}, m);
  cloth.springs.clear();
  cloth.twists.clear();
  cloth.corner_frictions.clear();
  const auto forces = make_internal_forces(cloth);
  ForceStateOwner s{cloth.surface.vertices, Vectors(cloth.mass.size(), Vec3::Zero()), cloth.mass};
  const auto roll = [&](double kappa) {
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      const Vec3& q = cloth.surface.vertices[i];
      // Chords of an arc, so that every row turns by κ d exactly.
      const double a = kappa * q.x(), r = 0.5 * cell / std::sin(0.5 * kappa * cell);
      s.x[i] = Vec3(r * std::sin(a), q.y(), r * (1.0 - std::cos(a)));
    }
  };
  const auto size = [&] {
    double sum = 0.0;
    Vectors f(s.x.size(), Vec3::Zero());
    for (const auto& force : forces) force->add_force(s.view(), f);
    for (const Vec3& fi : f) sum += fi.norm();
    return sum;
  };
  for (int i = 1; i <= 150; ++i) {
    roll(i);
    for (const auto& force : forces) force->accept(s.view());
  }
  roll(150.0);
  const double bent = size();
  for (double kappa = 150.0; kappa > 52.6; kappa -= 0.5) {
    roll(kappa);
    for (const auto& force : forces) force->accept(s.view());
  }
  roll(m.bending_friction / m.bending_stiffness);
  EXPECT_LT(size(), 1e-3 * bent);
}

TEST(KesSheets, AreConvertedToSI) {
  KesSheet sheet;
  sheet.weight = 20.0;
  sheet.shear = 1.0;
  sheet.shear_hysteresis = 2.0;
  sheet.lt = 0.6;
  sheet.emt = 4.0;
  const Material m = material_of(sheet);
  EXPECT_NEAR(m.density, 0.2, 1e-15);
  EXPECT_NEAR(m.shear_stiffness, 56.19, 0.005);
  EXPECT_NEAR(m.shear_friction, 0.980665, 1e-12);
  // The curve ends at 500 gf/cm = 490.3 N/m when stretched by EMT.
  const std::vector<Spring> spring{{0, 1, 1.0, m.stretch_stiffness}};
  const auto force = make_curve_force(spring, {"kawabata", m.kawabata_strain, m.kawabata_lt}, 2);
  const ForceStateOwner s{{{0, 0, 0}, {1.04, 0, 0}}, {Vec3::Zero(), Vec3::Zero()}, {1, 1}};
  EXPECT_NEAR(force_at(*force, s)[0].x(), 490.3325, 1e-9);
  EXPECT_NO_THROW(make_rectangular({0.1, 0.1, 4, 4}, m));
}

TEST(KesSheets, ABadValueIsNamedWithItsUnit) {
  KesSheet sheet;
  sheet.bending = -1.0;
  try {
    material_of(sheet);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("B in gf cm2/cm"), std::string::npos);
  }
}

TEST(BridsonHinges, FollowTheSineOfHalfTheAngle) {
  const Vectors x{{0, -1, 0}, {0, std::cos(1.0), std::sin(1.0)}, {-1, 0, 0}, {1, 0, 0}};
  const detail::Dihedral d = detail::dihedral(x, {0, 1, 2, 3});
  const std::vector<Hinge> hinge{{{0, 1, 2, 3}, 0.3, 5.0, 0.1, true}};
  const auto force = make_bridson_force(hinge, 4);
  ForceStateOwner s{x, Vectors(4, Vec3::Zero()), {1, 1, 1, 1}};
  const double moment = 2.0 * 5.0 * (std::sin(0.5 * d.angle) - std::sin(0.15));
  Vectors f = force_at(*force, s);
  for (int k = 0; k < 4; ++k) EXPECT_LT((f[k] + moment * d.gradient[k]).norm(), 1e-12);
  s.v[0] = {0, 0, 2};
  const double rate = 2.0 * d.gradient[0].z();
  f = force_at(*force, s);
  for (int k = 0; k < 4; ++k)
    EXPECT_LT((f[k] + (moment + 5.0 * 0.1 * rate) * d.gradient[k]).norm(), 1e-12);
}

}  // namespace
}  // namespace selvedge::force_test
