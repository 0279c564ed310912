// SPDX-License-Identifier: MIT
//
// What each strain limiter claims, on nets of springs.
#include <selvedge/core/solver/strain_limiter.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "crumple.h"

namespace selvedge::strain_limiter_test {
namespace {

/// A square net that has been pulled out at random, in a step of h.
struct Pulled {
  static constexpr double h = 0.01, limit = 0.1;
  ClothMesh cloth;
  std::vector<double> inv_mass;
  Vectors x_t0, x_t1;

  explicit Pulled(unsigned seed, bool pinned = false) {
    const GridConfig grid{1.0, 1.0, 10, 10};
    cloth = make_rectangular(grid, Material{});
    for (const double m : cloth.mass) inv_mass.push_back(1.0 / m);
    if (pinned) inv_mass[0] = inv_mass[10] = 0.0;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    x_t0 = x_t1 = cloth.surface.vertices;
    for (std::size_t i = 0; i < x_t1.size(); ++i) {
      if (inv_mass[i] <= 0.0) continue;
      x_t1[i] *= 1.08;
      x_t1[i] += 0.03 * Vec3(unit(random), unit(random), unit(random));
    }
  }
  LimitStep step(int sweeps = 2000) const { return {x_t0, inv_mass, h, 1e-3, sweeps}; }
  std::unique_ptr<StrainLimitMethod> make(const std::string& name) const {
    const std::vector<double> limits(cloth.springs.size(), limit);
    return strain_limiters().at(name)(cloth.springs, limits, x_t0.size()).method;
  }
  StrainReport measure(std::span<const Vec3> x) const {
    return StrainLimiter(cloth.springs, std::vector<double>(cloth.springs.size(), limit), x.size())
        .measure(x);
  }
  Vec3 moment(std::span<const Vec3> x) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < x.size(); ++i) sum += cloth.mass[i] * x[i];
    return sum;
  }
};

TEST(StrainLimitMethods, BoundTheStrainWhereTheySaySo) {
  int bounding = 0;
  for (const auto& [name, entry] : strain_limiters()) {
    if (entry.traits().kind != LimiterKind::method) continue;
    const Pulled net(3, true);
    const auto method = net.make(name);
    Vectors x = net.x_t1;
    const StrainReport report = method->limit_ends(net.step(), x);
    EXPECT_EQ(x[0], net.x_t0[0]) << name << " moved what is held";
    EXPECT_DOUBLE_EQ(report.residual, net.measure(x).residual) << name;
    if (!method->traits().bounds_strain || !method->traits().of_springs) continue;
    EXPECT_LE(report.residual, 1e-3) << name;
    ++bounding;
  }
  EXPECT_EQ(bounding, 7);
}

TEST(StrainLimitMethods, KeepMomentumWhereTheySaySoAndLoseItOtherwise) {
  for (const auto& [name, entry] : strain_limiters()) {
    if (entry.traits().kind != LimiterKind::method) continue;
    const Pulled net(5);
    const auto method = net.make(name);
    Vectors x = net.x_t1;
    for (Vec3& p : x) p += Vec3(0.2, 0, 0);  // all of it flies
    const Vec3 before = net.moment(x);
    method->limit_ends(net.step(), x);
    double moved = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i)
      moved += net.cloth.mass[i] * (x[i] - net.x_t1[i] - Vec3(0.2, 0, 0)).norm();
    ASSERT_GT(moved, 0.0) << name;
    const double lost = (net.moment(x) - before).norm() / moved;
    if (method->traits().keeps_momentum) {
      EXPECT_LT(lost, 1e-12) << name;
    } else {
      EXPECT_GT(lost, 1e-4) << name;
    }
  }
}

TEST(StrainLimitMethods, LeaveASlackNetAsItIs) {
  for (const auto& [name, entry] : strain_limiters()) {
    if (entry.traits().kind != LimiterKind::method) continue;
    const Pulled net(7);
    Vectors x = net.cloth.surface.vertices;
    for (Vec3& p : x) p *= 0.97;
    const Vectors before = x;
    EXPECT_EQ(net.make(name)->limit_ends(net.step(), x).sweeps, 0) << name;
    EXPECT_EQ(x, before) << name;
  }
}

constexpr const char* kTwoSided[] = {
    "position", "position_as_printed", "ordered_position",  "ordered_position_velocity",
    "velocity", "velocity_as_printed", "position_velocity", "priority_position_velocity"};

/// The method with or without limits of compression.
std::unique_ptr<StrainLimitMethod> two_sided(const char* name, std::span<const Spring> springs,
                                             std::span<const double> limits, std::size_t particles,
                                             bool compression = true) {
  return strain_limiters()
      .at(name)({{"compression", compression ? 1.0 : 0.0}}, springs, limits, particles)
      .method;
}

TEST(LimitsOfCompression, LengthenAPairThatIsPressedTogether) {
  const std::vector<Spring> spring{{0, 1, 1.0, 100.0}};
  const std::vector<double> limit{0.1}, inv_mass{1.0, 0.5};
  const Vectors x_t0{{0, 0, 0}, {1, 0, 0}};
  for (const char* name : kTwoSided) {
    const auto method = two_sided(name, spring, limit, 2);
    EXPECT_EQ(method->traits().limits, LimitedStrain::stretch_and_compression) << name;
    Vectors x{{0.1, 0.3, 0}, {0.8, 0.3, 0}};
    const StrainReport report = method->limit_ends({x_t0, inv_mass, 0.01}, x);
    if (method->traits().keeps_momentum) {
      EXPECT_NEAR(x[1].x() - x[0].x(), 0.9, 1e-12) << name;
      EXPECT_NEAR(x[0].x() + 2.0 * x[1].x(), 1.7, 1e-12) << name << ": momentum";
      EXPECT_LE(report.residual, 1e-9) << name;
    } else {
      EXPECT_GE(x[1].x() - x[0].x(), 0.9 - 1e-12) << name;
    }
    EXPECT_EQ(x[0].y(), 0.3) << name << " moves across the spring";
    // One that is within both limits stays.
    Vectors slack{{0, 0, 0}, {0.91, 0, 0}};
    const Vectors same = slack;
    method->limit_ends({x_t0, inv_mass, 0.01}, slack);
    EXPECT_EQ(slack, same) << name;
    // So does a short one without the option.
    Vectors pressed{{0, 0, 0}, {0.7, 0, 0}};
    const Vectors short_one = pressed;
    two_sided(name, spring, limit, 2, false)->limit_ends({x_t0, inv_mass, 0.01}, pressed);
    EXPECT_EQ(pressed, short_one) << name;
  }
}

TEST(LimitsOfCompression, HoldInAPressedNetWhereTheLimiterBoundsTheStrain) {
  for (const char* name : kTwoSided) {
    const Pulled net(11);
    const std::vector<double> limits(net.cloth.springs.size(), Pulled::limit);
    const auto method = two_sided(name, net.cloth.springs, limits, net.x_t0.size());
    if (!method->traits().bounds_strain) continue;
    Vectors x = net.cloth.surface.vertices;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = 0.8 * x[i] + 0.1 * (net.x_t1[i] - x[i]);
    ASSERT_GT(net.measure(x).compression_excess, 0.05);
    method->limit_ends(net.step(), x);
    EXPECT_LE(net.measure(x).compression_excess, 1e-3) << name;
    EXPECT_LE(net.measure(x).excess, 1e-3) << name;
  }
}

TEST(LimitsOfCompression, TakeTheVelocityThatGoesOnCompressing) {
  const std::vector<Spring> spring{{0, 1, 1.0, 100.0}};
  const std::vector<double> limit{0.1}, inv_mass{1.0, 1.0};
  const Vectors x{{0, 0, 0}, {0.9, 0, 0}};
  Vectors v{{1, 2, 0}, {-1, 3, 0}}, parting{{-1, 0, 0}, {1, 0, 0}};
  const Vectors same = parting;
  const auto method = two_sided("position_velocity", spring, limit, 2);
  method->limit_velocities({x, inv_mass, 0.01}, x, v);
  EXPECT_NEAR(v[1].x() - v[0].x(), 0.0, 1e-12);
  EXPECT_EQ(v[0].y(), 2.0);
  method->limit_velocities({x, inv_mass, 0.01}, x, parting);
  EXPECT_EQ(parting, same);
}

TEST(VelocityLimiter, StopsStretchingButDoesNotShortenWhatIsOverItsLimitAlready) {
  const std::vector<Spring> spring{{0, 1, 1.0, 100.0}};
  const std::vector<double> limit{0.1};
  const std::vector<double> inv_mass{1.0, 0.5};
  const auto method = make_velocity_limiter(spring, limit, 2, false);
  const Vectors x_t0{{0, 0, 0}, {1.2, 0, 0}};
  Vectors x{{-0.05, 0, 0}, {1.3, 0, 0}};
  method->limit_ends({x_t0, inv_mass, 0.01}, x);
  EXPECT_NEAR((x[1] - x[0]).norm(), 1.2, 1e-12);
  // One below its limit may stretch up to it.
  const Vectors slack{{0, 0, 0}, {1.0, 0, 0}};
  Vectors end{{0, 0, 0}, {1.5, 0, 0}};
  method->limit_ends({slack, inv_mass, 0.01}, end);
  EXPECT_NEAR((end[1] - end[0]).norm(), 1.1, 1e-12);
  // Those that come back are left alone.
  Vectors back{{0, 0, 0}, {1.15, 0, 0}};
  const Vectors same = back;
  method->limit_ends({x_t0, inv_mass, 0.01}, back);
  EXPECT_EQ(back, same);
}

TEST(VelocityLimiter, AsPrintedTakesTheVelocityOfThePairAlongTheSpring) {
  const std::vector<Spring> spring{{0, 1, 1.0, 100.0}};
  const std::vector<double> limit{0.1};
  const std::vector<double> inv_mass{1.0, 1.0};
  const Vectors x_t0{{0, 0, 0}, {1.1, 0, 0}};
  Vectors x{{0.5, 0.2, 0}, {1.7, 0.3, 0}};
  make_velocity_limiter(spring, limit, 2, true)->limit_ends({x_t0, inv_mass, 0.1}, x);
  EXPECT_NEAR(x[0].x(), 0.0, 1e-12);
  EXPECT_NEAR(x[1].x(), 1.1, 1e-12);
  EXPECT_NEAR(x[0].y(), 0.2, 1e-12) << "across the spring nothing changes";
}

// Excess over the thresholds of one spring of length 1, limit 0.1, between a particle of mass 1 and
// one of mass 2 that ends the step at `end`, after some sweeps of the limiter "han".
struct HanSpring {
  std::vector<Spring> spring{{0, 1, 1.0, 100.0}};
  std::vector<double> limit{0.1}, inv_mass{1.0, 0.5};
  Vectors x_t0, x;

  HanSpring(double start, const Vec3& end, int sweeps, double share) {
    MethodOptions options;
    options.set("share", share);
    const StrainLimiterRegistry all = strain_limiters();
    const auto han = all.at("han")(options, spring, limit, 2).method;
    x_t0 = {{0, 0, 0}, {start, 0, 0}};
    x = {{0, 0, 0}, end};
    LimitStep step{x_t0, inv_mass, 0.01};
    step.max_sweeps = sweeps;
    han->limit_ends(step, x);
  }
  double length() const { return (x[1] - x[0]).norm(); }
};

TEST(HanLimiter, BringsStretchAndCompressionToTheirThresholdsSweepAfterSweep) {
  // A sweep takes the share of the excess: 0.2 m decrease to 0.2 (1 - σ)^k.
  for (const double share : {0.5, 0.2})
    for (const int sweeps : {1, 2, 3}) {
      const double left = 0.2 * std::pow(1.0 - share, sweeps);
      EXPECT_NEAR(HanSpring(1.0, {1.3, 0, 0}, sweeps, share).length(), 1.1 + left, 1e-12);
      EXPECT_NEAR(HanSpring(1.0, {0.7, 0, 0}, sweeps, share).length(), 0.9 - left, 1e-12);
    }
  // Springs that start beyond their threshold reach it too.
  EXPECT_NEAR(HanSpring(1.2, {1.3, 0, 0}, 100, 0.5).length(), 1.1, 1e-3);
  EXPECT_NEAR(HanSpring(0.8, {0.7, 0, 0}, 100, 0.5).length(), 0.9, 1e-3);
  EXPECT_EQ(HanSpring(1.0, {1.09, 0, 0}, 100, 0.5).length(), 1.09) << "within them";
}

TEST(HanLimiter, DecreasesTheVelocityAlongTheSpringAlone) {
  const Vec3 end(1.2, 0.3, -0.1), n = end.normalized();
  const HanSpring s(1.0, end, 1, 0.5);
  for (const Vec3& moved : {Vec3(s.x[1] - end), s.x[0]})
    EXPECT_LT((moved - moved.dot(n) * n).norm(), 1e-15);
  EXPECT_LT((s.x[0] + 2.0 * s.x[1] - 2.0 * end).norm(), 1e-15) << "momentum";
  EXPECT_LT((s.x[1] - end).dot(n), 0.0);
}

TEST(HanLimiter, TheForceOfItsSpringsIsACubicToBothSides) {
  const std::vector<Spring> spring{{0, 1, 0.5, 80.0}};
  const std::vector<double> limit{0.2};
  MethodOptions options;
  const StrainLimiterRegistry all = strain_limiters();
  const auto force = all.at("han")(options, spring, limit, 2).force;
  ASSERT_NE(force, nullptr);
  for (const double d : {-0.1, -0.04, 0.0, 0.03, 0.1}) {
    const Vectors x{{0, 0, 0}, {0.5 + d, 0, 0}}, v(2, Vec3::Zero());
    const std::vector<double> mass{1.0, 1.0};
    Vectors f(2, Vec3::Zero());
    force->add_force({x, v, mass, 0.0}, f);
    // F = K ΔL (1 + γ (ΔL/(τ L0))²) without Hooke's K ΔL; γ = 1, τ L0 = 0.1 m.
    EXPECT_NEAR(f[0].x(), 80.0 * d * (d / 0.1) * (d / 0.1), 1e-12) << d;
    EXPECT_NEAR(f[1].x(), -f[0].x(), 1e-15);
  }
}

TEST(PositionVelocityLimiter, TakesTheVelocityThatGoesOnStretching) {
  const std::vector<Spring> spring{{0, 1, 1.0, 100.0}};
  const std::vector<double> limit{0.1};
  const std::vector<double> inv_mass{1.0, 1.0};
  const Vectors x{{0, 0, 0}, {1.1, 0, 0}};
  Vectors v{{-1, 2, 0}, {1, 3, 0}};
  make_position_velocity_limiter(spring, limit, 2)->limit_velocities({x, inv_mass, 0.01}, x, v);
  EXPECT_NEAR(v[1].x() - v[0].x(), 0.0, 1e-12);
  EXPECT_NEAR(v[1].x() + v[0].x(), 0.0, 1e-12);
  EXPECT_EQ(v[0].y(), 2.0);
  Vectors approaching{{1, 0, 0}, {-1, 0, 0}};
  const Vectors same = approaching;
  make_position_velocity_limiter(spring, limit, 2)
      ->limit_velocities({x, inv_mass, 0.01}, x, approaching);
  EXPECT_EQ(approaching, same);
}

TEST(OrderedLimiter, CorrectsTheWorstSpringFirst) {
  // A chain 0-1-2: the second spring is the worse one. In one sweep it is corrected in full, then
  // the first pulls on the particle between.
  const std::vector<Spring> springs{{0, 1, 1.0, 100.0}, {1, 2, 1.0, 100.0}};
  const std::vector<double> limits{0.1, 0.1};
  const std::vector<double> inv_mass{0.0, 1.0, 1.0};
  const Vectors x_t0{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  Vectors x{{0, 0, 0}, {1.3, 0, 0}, {3.4, 0, 0}};
  LimitStep step{x_t0, inv_mass, 0.01};
  step.max_sweeps = 1;
  make_ordered_limiter(springs, limits, 3, {})->limit_ends(step, x);
  EXPECT_NEAR(x[2].x(), 3.4 - 0.5, 1e-12);  // half of the excess of 1.0
  EXPECT_NEAR(x[1].x(), 1.1, 1e-12);        // moved to 1.8, then to the limit of the first
  Vectors y{{0, 0, 0}, {1.3, 0, 0}, {3.4, 0, 0}};
  make_ordered_limiter(springs, limits, 3, {true, false})->limit_ends(step, y);
  EXPECT_NEAR(y[2].x(), 2.9, 1e-12);
  EXPECT_NEAR(y[1].x(), 1.1, 1e-12) << "with the other end held it has to do all of it";
}

double tension_at(StiffeningLaw law, double strain) {
  const std::vector<Spring> spring{{0, 1, 2.0, 50.0}};
  const std::vector<double> limit{0.1}, mass{1.0, 1.0};
  std::vector<std::unique_ptr<Force>> both;
  both.push_back(make_hooke_force(spring, 2));
  both.push_back(make_stiffening_force(spring, limit, 2, law));
  const Vectors x{{0, 0, 0}, {2.0 * (1.0 + strain), 0, 0}}, v(2, Vec3::Zero());
  Vectors f(2);
  ForceSum(std::move(both), 2).evaluate({x, v, mass, 0.0}, f);
  return f[0].x();
}

TEST(StiffeningLaws, AreTheFormulasOfTheSurveyAndTheirRepairs) {
  const double kl0 = 100.0;  // K L0
  for (const double strain : {0.0, 0.03, 0.08, 0.15}) {
    const double hooke = kl0 * strain, beyond = strain >= 0.1 ? (1.0 + strain) : 1.0;
    EXPECT_NEAR(tension_at(StiffeningLaw::bayraktar_printed, strain), hooke * beyond, 1e-10);
    EXPECT_NEAR(tension_at(StiffeningLaw::bayraktar, strain),
                hooke * (strain >= 0.1 ? (1.0 + strain) / 1.1 : 1.0), 1e-10);
    // F = K (L0/5π) atan(5π ΔL/L0) and its inverse.
    const double five = 5.0 * std::numbers::pi;
    EXPECT_NEAR(tension_at(StiffeningLaw::tangent_printed, strain),
                kl0 / five * std::atan(five * strain), 1e-10);
    if (strain < 0.09) {
      EXPECT_NEAR(tension_at(StiffeningLaw::tangent, strain), kl0 / five * std::tan(five * strain),
                  1e-10);
    }
  }
}

TEST(StiffeningLaws, OneJumpsAndOneSoftensAsPrinted) {
  constexpr double tiny = 1e-9;
  const auto jump = [&](StiffeningLaw law) {
    return tension_at(law, 0.1 + tiny) - tension_at(law, 0.1 - tiny);
  };
  EXPECT_NEAR(jump(StiffeningLaw::bayraktar_printed), 1.0, 1e-5);  // 10 % of 10 N
  EXPECT_NEAR(jump(StiffeningLaw::bayraktar), 0.0, 1e-5);
  EXPECT_LT(tension_at(StiffeningLaw::tangent_printed, 100.0), 0.1 * 100.0);
  EXPECT_LT(tension_at(StiffeningLaw::tangent_printed, 0.1), 0.65 * 10.0);
  EXPECT_GT(tension_at(StiffeningLaw::tangent, 0.1), 6.0 * 10.0);
}

TEST(StiffeningLaws, AreMinusTheGradientOfTheirEnergy) {
  const std::vector<Spring> spring{{0, 1, 2.0, 50.0}};
  const std::vector<double> limit{0.1}, mass{1.0, 1.0};
  const Vectors v(2, Vec3::Zero());
  for (const StiffeningLaw law : {StiffeningLaw::bayraktar, StiffeningLaw::bayraktar_printed,
                                  StiffeningLaw::tangent, StiffeningLaw::tangent_printed})
    for (const double strain : {-0.05, 0.02, 0.085, 0.095, 0.13}) {
      const auto force = make_stiffening_force(spring, limit, 2, law);
      constexpr double step = 1e-6;
      const auto energy = [&](double by) {
        const Vectors x{{0, 0, 0}, {2.0 * (1.0 + strain) + by, 0, 0}};
        return force->energy({x, v, mass, 0.0});
      };
      const Vectors x{{0, 0, 0}, {2.0 * (1.0 + strain), 0, 0}};
      Vectors f(2, Vec3::Zero());
      force->add_force({x, v, mass, 0.0}, f);
      EXPECT_NEAR(-(energy(step) - energy(-step)) / (2.0 * step), f[1].x(), 1e-6)
          << static_cast<int>(law) << " " << strain;
    }
}

TEST(CriticalStep, OfOneMassAndOfProvotsNetAreTheKnownOnes) {
  const double h = 0.01, m = 0.1, k = 4.0 * m / (h * h);
  const std::vector<Spring> spring{{0, 1, 1.0, k}};
  std::vector<std::unique_ptr<Force>> one;
  one.push_back(make_hooke_force(spring, 2));
  ForceSum forces(std::move(one), 2);
  Particles p{{{0, 0, 0}, {1, 0, 0}}, Vectors(2, Vec3::Zero()), {m, m}, {0.0, 1.0 / m}};
  const CriticalStep step = critical_step(forces, p, h);
  EXPECT_NEAR(step.mass_stiffness, k, 1e-9 * k);
  EXPECT_NEAR(step.provot_stiffness / step.mass_stiffness, std::numbers::pi * std::numbers::pi / 4,
              1e-12);
  EXPECT_NEAR(step.longest_step, h, 1e-6 * h);
  EXPECT_NEAR(step.stiffening, 1.0, 1e-5);

  // Structural, shear and flexion alike: h sqrt(k/m) = 0.6285 inside a large net.
  const GridConfig grid{1.0, 1.0, 30, 30};
  const ClothMesh net =
      make_spring_net(SpringNet::rectangular, grid, {500.0, 500.0, 500.0, false}, Material{});
  ForceSum all(make_internal_forces(net), net.mass.size());
  Particles q{net.surface.vertices, Vectors(net.mass.size(), Vec3::Zero()), net.mass, {}};
  double heaviest = 0.0;
  for (const double mass : net.mass) heaviest = std::max(heaviest, mass);
  q.mass.assign(q.size(), heaviest);
  q.inv_mass.assign(q.size(), 1.0 / heaviest);
  const CriticalStep whole = critical_step(all, q, h);
  EXPECT_NEAR(whole.longest_step * std::sqrt(500.0 / heaviest), 0.6285, 0.01);
  EXPECT_LE(whole.safe_step, whole.longest_step);
  EXPECT_THROW(critical_step(all, q, 0.0), std::invalid_argument);
}

TEST(ChittarosPolicy, MakesSoftClothAloneAsStiffAsItsWeightNeeds) {
  EXPECT_EQ(chittaro_policy(2.0, 500.0, 0.1).stiffness, 1.0);
  EXPECT_EQ(chittaro_policy(2.0, 500.0, 0.1).step, 1.0);
  const StiffnessPolicy soft = chittaro_policy(2.0, 5.0, 0.1);
  EXPECT_NEAR(soft.strain, 0.4, 1e-12);
  EXPECT_NEAR(soft.stiffness, 4.0, 1e-12);
  EXPECT_NEAR(soft.step, 0.5, 1e-12);
  EXPECT_THROW(chittaro_policy(2.0, 0.0, 0.1), std::invalid_argument);
}

TEST(StrainLimitMethods, RefuseLimitsThatDoNotFit) {
  const std::vector<Spring> spring{{0, 1, 1.0, 1.0}};
  const std::vector<double> none;
  for (const auto& [name, entry] : strain_limiters()) {
    const LimiterKind kind = entry.traits().kind;
    if (kind != LimiterKind::method && kind != LimiterKind::force) continue;
    EXPECT_THROW(entry(spring, none, 2), std::invalid_argument) << name;
  }
}

TEST(StrainLimiters, BringEverySpringBelowItsLimitAndKeepMomentum) {
  const ClothMesh cloth = make_rectangular({1, 1, 20, 20}, Material{});
  const StrainLimiter limiter(cloth.springs, cloth.strain_limit, cloth.mass.size());
  Vectors x = random_vectors(cloth.mass.size(), 0.02, 5);
  std::vector<double> inv_mass;
  Vec3 before = Vec3::Zero();
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] += cloth.surface.vertices[i];
    inv_mass.push_back(1.0 / cloth.mass[i]);
    before += cloth.mass[i] * x[i];
  }
  EXPECT_GT(limiter.measure(x).max_strain, 0.3);
  const StrainReport report = limiter.apply(inv_mass, 1e-3, 500, x);
  EXPECT_LE(report.residual, 1e-3);
  EXPECT_LE(limiter.measure(x).max_strain, 0.1 + 1e-3);
  EXPECT_GT(report.sweeps, 0);
  Vec3 after = Vec3::Zero();
  for (std::size_t i = 0; i < x.size(); ++i) after += cloth.mass[i] * x[i];
  EXPECT_LT((after - before).norm(), 1e-14);
}

TEST(StrainLimiters, ReportTheResidualWherePinsAreTooFarApart) {
  const std::vector<Spring> springs{{0, 1, 1.0, 1.0}, {1, 2, 1.0, 1.0}};
  const std::vector<double> limits{0.1, 0.1}, inv_mass{0.0, 1.0, 0.0};
  Vectors x{{0, 0, 0}, {1.3, 0, 0}, {2.4, 0, 0}};
  const StrainReport report = StrainLimiter(springs, limits, 3).apply(inv_mass, 1e-3, 50, x);
  EXPECT_EQ(report.sweeps, 50);
  EXPECT_GE(report.residual, 0.1 - 1e-12);
  EXPECT_TRUE(x[1].allFinite());
  EXPECT_EQ(x[0], Vec3(0, 0, 0));
  EXPECT_EQ(x[2], Vec3(2.4, 0, 0));
}

TEST(StrainLimiters, RefuseLimitsThatDoNotFit) {
  const std::vector<Spring> springs{{0, 1, 1.0, 1.0}};
  const std::vector<double> none, negative{-0.1};
  EXPECT_THROW(StrainLimiter(springs, none, 2), std::invalid_argument);
  EXPECT_THROW(StrainLimiter(springs, negative, 2), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::strain_limiter_test
