// SPDX-License-Identifier: MIT
//
// Sewing, virtual and support springs, volume, water.
#include <selvedge/core/cloth/wetting.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "dense_force.h"

namespace selvedge::survey_force_test {
namespace {

constexpr double pi = std::numbers::pi;

ForceStateOwner at(Vectors x) {
  const std::size_t n = x.size();
  return {std::move(x), Vectors(n, Vec3::Zero()), std::vector<double>(n, 1.0)};
}

void expect_gradient_of_energy(const Force& force, ForceStateOwner state, const std::string& name) {
  constexpr double step = 1e-6;
  const Vectors f = force_at(force, state);
  double scale = 0.0;
  for (const Vec3& fi : f) scale = std::max(scale, fi.norm());
  for (std::size_t k = 0; k < 3 * state.x.size(); ++k) {
    double& u = state.x[k / 3][k % 3];
    const double old = u;
    u = old + step;
    const double up = force.energy(state.view());
    u = old - step;
    const double down = force.energy(state.view());
    u = old;
    EXPECT_NEAR(f[k / 3][k % 3], (down - up) / (2.0 * step), 1e-7 * scale) << name;
  }
}

/// Both, relative to the sum of the sizes of the forces.
std::pair<double, double> sum_and_moment(const Vectors& f, const Vectors& x) {
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  double size = 0.0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    sum += f[i];
    moment += x[i].cross(f[i]);
    size += f[i].norm();
  }
  return {sum.norm() / size, moment.norm() / size};
}

const std::vector<Edge> seam{{0, 1}};

double pull(const SewingConfig& config, double d) {
  return force_at(*make_sewing_force(seam, config, 2), at({{0, 0, 0}, {d, 0, 0}}))[0].x();
}

/// The force at the end of two beams of length `l` with the rigidity EI that turn by `angle`.
Vec3 end_force(double l, double rigidity, double angle) {
  const std::vector<Beam> beams{{{0, 1, 2}, {l, l}, rigidity}};
  const ForceStateOwner s{{{-l, 0, 0}, {0, 0, 0}, {l * std::cos(angle), l * std::sin(angle), 0}},
                          Vectors(3, Vec3::Zero()),
                          std::vector<double>(3, 1.0)};
  return force_at(*make_beam_force(beams, 3), s)[2];
}

// Survey eq. 4, F = EI α/l², with the chord 2 sin(α/2) for the angle: α l is a displacement.
TEST(Beam, ItsEndFeelsTheForceOfEquationFour) {
  constexpr double l = 0.05, rigidity = 3e-6;
  for (const double angle : {1e-4, 0.1, 1.0, 2.5}) {
    const double chord = 2.0 * std::sin(0.5 * angle);
    EXPECT_NEAR(end_force(l, rigidity, angle).norm(), rigidity * chord / (l * l),
                1e-12 * rigidity / (l * l));
  }
  EXPECT_NEAR(end_force(l, rigidity, 1e-4).norm() / (rigidity * 1e-4 / (l * l)), 1.0, 1e-8);
  EXPECT_NEAR(end_force(2.0 * l, rigidity, 0.1).norm() / end_force(l, rigidity, 0.1).norm(), 0.25,
              1e-12);
}

TEST(Beam, IsLinearInThePositions) {
  const std::vector<Beam> beams{{{0, 1, 2}, {0.1, 0.04}, 2e-6, 0.0}};
  const auto force = make_beam_force(beams, 3);
  const Vectors still(3, Vec3::Zero());
  const ForceStateOwner a{random_vectors(3, 1.0, 1), still, {1.0, 1.0, 1.0}};
  const ForceStateOwner b{random_vectors(3, 1.0, 2), still, {1.0, 1.0, 1.0}};
  ForceStateOwner sum = a;
  for (int i = 0; i < 3; ++i) sum.x[i] = 2.0 * a.x[i] - 3.0 * b.x[i];
  const Vectors fa = force_at(*force, a), fb = force_at(*force, b), f = force_at(*force, sum);
  for (int i = 0; i < 3; ++i)
    EXPECT_LT((f[i] - 2.0 * fa[i] + 3.0 * fb[i]).norm(), 1e-12 * f[i].norm());
}

TEST(Beam, OfUnequalLengthsHasNoMoment) {
  const std::vector<Beam> beams{{{0, 1, 2}, {0.1, 0.04}, 2e-6, 0.0}};
  const ForceStateOwner s{random_vectors(3, 0.1, 4), Vectors(3, Vec3::Zero()), {1.0, 1.0, 1.0}};
  const Vectors f = force_at(*make_beam_force(beams, 3), s);
  Vec3 moment = Vec3::Zero();
  for (int i = 0; i < 3; ++i) moment += s.x[i].cross(f[i]);
  EXPECT_LT(moment.norm(), 1e-12 * s.x[0].norm() * f[0].norm());
}

TEST(Sewing, PullsInProportionFarAwayAndEvenlyNear) {
  const SewingConfig config{50.0, 0.004, 0.0};
  EXPECT_NEAR(pull(config, 0.2), 10.0, 1e-12);
  EXPECT_NEAR(pull(config, 0.004), 0.2, 1e-12);
  EXPECT_NEAR(pull(config, 0.001), 0.2, 1e-12);
  EXPECT_NEAR(pull(config, 0.00002), 0.1, 1e-12);
  EXPECT_EQ(pull(config, 0.0), 0.0);  // the printed formula is 0/0 here
}

TEST(Sewing, DoesNotSlowAGarmentThatMovesAsAWhole) {
  const auto force = make_sewing_force(seam, {50.0, 0.004, 3.0}, 2);
  ForceStateOwner s = at({{0, 0, 0}, {0.2, 0, 0}});
  s.v = {{5, 1, 2}, {5, 1, 2}};
  EXPECT_NEAR(force_at(*force, s)[0].x(), 10.0, 1e-12);
  s.v[1].x() = 4.0;  // the seam closes at 1 m/s
  EXPECT_NEAR(force_at(*force, s)[0].x(), 7.0, 1e-12);
}

// The relative acceleration of a pair is that of the distance, ε d (1/m_i + 1/m_j), and ΔA besides,
// whatever the masses; the pair keeps its momentum.
TEST(Sewing, TheAccelerationIsThatOfThePairWhateverItsMasses) {
  const std::vector<double> mass{0.003, 0.001};
  const auto approach = [&](double acceleration, double d) {
    const SewingConfig config{2.0, 0.01, 0.0, acceleration};
    const auto force = make_sewing_force(seam, config, 2, mass);
    const auto f = force_at(*force, at({{0, 0, 0}, {d, 0, 0}}));
    EXPECT_NEAR(f[0].x() + f[1].x(), 0.0, 1e-18);
    return f[0].x() / mass[0] - f[1].x() / mass[1];
  };
  for (const double d : {0.3, 0.02, 0.009, 0.002})
    EXPECT_NEAR(approach(5.0, d) - approach(0.0, d), 5.0, 1e-11) << d;
  EXPECT_EQ(approach(5.0, 0.0), 0.0) << "a closed seam is at rest";
  EXPECT_THROW(make_sewing_force(seam, {1.0, 0.01, 0.0, 5.0}, 2), std::invalid_argument);
}

TEST(Sewing, BadNumbersAreRefused) {
  EXPECT_THROW(make_sewing_force(seam, {0.0, 0.004, 0.0}, 2), std::invalid_argument);
  EXPECT_THROW(make_sewing_force(seam, {1.0, 0.0, 0.0}, 2), std::invalid_argument);
  EXPECT_THROW(make_sewing_force(seam, {1.0, 0.004, 0.0}, 1), std::invalid_argument);
}

TEST(VirtualSprings, AreTheGradientOfTheirEnergyFixedOrFollowing) {
  const Vectors rest = random_vectors(12, 0.5, 1);
  std::vector<double> k;
  for (int i = 0; i < 12; ++i) k.push_back(1.0 + i % 4);
  for (const bool follow : {false, true}) {
    const auto force = make_virtual_springs(rest, k, follow);
    for (unsigned seed = 5; seed < 8; ++seed) {
      Vectors x = random_vectors(12, 0.2, seed);
      for (std::size_t i = 0; i < 12; ++i) x[i] += rest[i];
      expect_gradient_of_energy(*force, at(x), follow ? "following" : "fixed");
    }
  }
}

TEST(VirtualSprings, FollowACarriedShapeAndHoldNothingElse) {
  // Flat shapes too, where the third axis of the matching is free.
  for (const bool flat : {false, true}) {
    Vectors rest = random_vectors(12, 0.5, 1);
    if (flat)
      for (Vec3& q : rest) q.z() = 0.0;
    const std::vector<double> k(12, 3.0);
    const auto following = make_virtual_springs(rest, k, true);
    const auto fixed = make_virtual_springs(rest, k, false);
    const Mat3 q = Eigen::AngleAxisd(2.5, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    Vectors x = rest;
    for (Vec3& p : x) p = q * p + Vec3(3, 1, 2);
    for (const Vec3& f : force_at(*following, at(x))) EXPECT_LT(f.norm(), 1e-12);
    EXPECT_GT(force_at(*fixed, at(x))[0].norm(), 1.0);  // what the survey's springs do
    const Vectors noise = random_vectors(12, 0.1, 4);
    for (std::size_t i = 0; i < 12; ++i) x[i] += noise[i];
    const auto [sum, moment] = sum_and_moment(force_at(*following, at(x)), x);
    EXPECT_LT(sum, 1e-12);
    EXPECT_LT(moment, 1e-12);
  }
}

TEST(VirtualSprings, BadOnesAreRefused) {
  const Vectors rest(2, Vec3::Zero());
  const std::vector<double> none{0.0, 0.0}, negative{1.0, -1.0}, one{1.0};
  EXPECT_THROW(make_virtual_springs(rest, none, true), std::invalid_argument);
  EXPECT_THROW(make_virtual_springs(rest, negative, true), std::invalid_argument);
  EXPECT_THROW(make_virtual_springs(rest, one, true), std::invalid_argument);
}

/// An octahedron split `times` times, on the unit sphere.
TriangleMesh sphere(int times) {
  TriangleMesh mesh{
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int k = 0; k < times; ++k) {
    const std::vector<Edge> edges = unique_edges(mesh.triangles);
    const auto n = static_cast<std::int32_t>(mesh.vertices.size());
    for (const Edge& e : edges)
      mesh.vertices.push_back((mesh.vertices[e[0]] + mesh.vertices[e[1]]).normalized());
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      const Edge key{std::min(a, b), std::max(a, b)};
      return n + static_cast<std::int32_t>(std::lower_bound(edges.begin(), edges.end(), key) -
                                           edges.begin());
    };
    std::vector<Triangle> split;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      split.insert(split.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = split;
  }
  return mesh;
}

TEST(SupportSprings, JoinEveryVertexToTheCentre) {
  const TriangleMesh closed = sphere(2);
  const ClothMesh cloth = make_supported(closed, {}, Material{});
  const std::size_t n = closed.vertices.size();
  EXPECT_EQ(cloth.springs.size(), 3 * n - 6 + n);
  EXPECT_EQ(cloth.surface.vertices.size(), n + 1);
  EXPECT_EQ(cloth.strain_limit.size(), cloth.springs.size());
  for (const Triangle& t : cloth.surface.triangles)
    for (const std::int32_t v : t) EXPECT_LT(v, static_cast<std::int32_t>(n));
  EXPECT_THROW(make_supported(closed, {50.0, 1.0}, Material{}), std::invalid_argument);
}

TEST(VolumeForce, ASqueezedBallPushesOutAndItsCentreTakesTheReaction) {
  const ClothMesh cloth = make_supported(sphere(2), {}, Material{});
  const auto centre = static_cast<std::int32_t>(cloth.mass.size()) - 1;
  const auto force =
      make_volume_force(50.0, centre, cloth.surface.triangles, cloth.surface.vertices);
  for (const Vec3& f : force_at(*force, at(cloth.surface.vertices))) EXPECT_LT(f.norm(), 1e-12);
  Vectors x = cloth.surface.vertices;
  for (Vec3& p : x) p = 0.9 * p + Vec3(4, 5, 6);
  const Vectors f = force_at(*force, at(x));
  double volume = 0.0, area = 0.0;
  for (const auto& [a, b, c] : cloth.surface.triangles) {
    const Vectors& r = cloth.surface.vertices;
    volume += r[a].dot(r[b].cross(r[c])) / 6.0;
    area += 0.5 * (r[b] - r[a]).cross(r[c] - r[a]).norm();
  }
  EXPECT_NEAR(volume, 4.0 / 3.0 * pi, 0.4);  // the ball has flat facets
  const double expected = 50.0 * volume * (1.0 - 0.729) / area;
  for (std::int32_t i = 0; i < centre; ++i)
    EXPECT_LT((f[i] - expected * cloth.surface.vertices[i].normalized()).norm(), 1e-10);
  const Vectors noise = random_vectors(x.size(), 0.2, 3);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += noise[i];
  const auto [sum, moment] = sum_and_moment(force_at(*force, at(x)), x);
  EXPECT_LT(sum, 1e-12);
  EXPECT_LT(moment, 1e-12);
}

/// Volume of a ball that starts squeezed to 0.729 of it, after implicit steps of h.
double volume_after(double h, int steps, double stiffness) {
  const ClothMesh cloth = make_supported(sphere(1), {}, Material{});
  const std::size_t n = cloth.mass.size();
  std::vector<std::unique_ptr<Force>> forces;
  forces.push_back(make_volume_force(stiffness, static_cast<std::int32_t>(n) - 1,
                                     cloth.surface.triangles, cloth.surface.vertices));
  const auto solver = integrators().at("implicit_euler")(std::move(forces), n, ImplicitConfig{});
  Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  for (Vec3& x : p.x) x *= 0.9;
  for (int k = 0; k < steps; ++k) {
    solver->begin({p, 0.0, h}, {});
    solver->solve({}, {p.v, {}}, 1.0);
    for (std::size_t i = 0; i < n; ++i) p.x[i] += h * p.v[i];
  }
  double volume = 0.0, rest = 0.0;
  for (const auto& [a, b, c] : cloth.surface.triangles) {
    const Vectors& r = cloth.surface.vertices;
    volume += (p.x[a] - p.x[n - 1]).dot((p.x[b] - p.x[n - 1]).cross(p.x[c] - p.x[n - 1]));
    rest += r[a].dot(r[b].cross(r[c]));
  }
  return volume / rest;
}

TEST(VolumeForce, ImplicitStepsBeyondTheExplicitBoundComeToRest) {
  // sqrt(m/K) of a vertex is about 0.7 ms here: the step is a hundred times as long.
  EXPECT_NEAR(volume_after(0.07, 200, 1e5), 1.0, 1e-3);
}

TEST(VolumeForce, AnOpenSurfaceIsRefusedWithItsEdge) {
  ClothMesh cloth = make_supported(sphere(1), {}, Material{});
  cloth.surface.triangles.pop_back();
  try {
    make_volume_force(1.0, static_cast<std::int32_t>(cloth.mass.size()) - 1,
                      cloth.surface.triangles, cloth.surface.vertices);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("is open"), std::string::npos);
  }
}

/// A strip of n × 2 cells of d metres with its water, all particles at rest.
struct Strip {
  ClothMesh cloth;
  Wetting wetting;
  Vectors v;
  Strip(int n, double d, const WettingConfig& config)
      : cloth(make_rectangular({n * d, 2 * d, n, 2}, Material{})),
        wetting(config, cloth.surface, cloth.mass),
        v(cloth.mass.size(), Vec3::Zero()) {}
  double water() const {
    double sum = 0.0;
    for (const double w : wetting.water()) sum += w;
    return sum;
  }
  Vec3 momentum() const {
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < v.size(); ++i) p += wetting.mass()[i] * v[i];
    return p;
  }
};

/// Decay rate of cos(2πx/λ), λ = 0.1 m = the length of the strip, D = 1e-6 m²/s, over 60 s.
double decay_rate(int cells) {
  Strip strip(cells, 0.1 / cells, {1e-6, 1e3});
  const auto amplitude = [&] {
    double sum = 0.0;
    for (std::size_t i = 0; i < strip.v.size(); ++i)
      sum += strip.wetting.water()[i] *
             std::cos(2 * pi * (strip.cloth.surface.vertices[i].x() + 0.05) / 0.1);
    return sum;
  };
  for (std::size_t i = 0; i < strip.v.size(); ++i) {
    const double x = strip.cloth.surface.vertices[i].x() + 0.05;
    strip.wetting.add_water(static_cast<std::int32_t>(i),
                            strip.cloth.mass[i] * (1.0 + 0.5 * std::cos(2 * pi * x / 0.1)),
                            Vec3::Zero(), strip.v[i]);
  }
  const double start = amplitude();
  for (int k = 0; k < 600; ++k) strip.wetting.advance(0.1, strip.v);
  return std::log(start / amplitude()) / 60.0;
}

TEST(Wetting, ACosineOfWaterDecaysAtTheRateOfTheLattice) {
  // D k² = 3.9478e-3 1/s; on 5 mm cells × 0.99182.
  EXPECT_NEAR(decay_rate(20) / (3.9478e-3 * 0.99182), 1.0, 5e-4);
}

TEST(Wetting, ConvergesWithTheSquareOfTheCell) {
  const double exact = 1e-6 * std::pow(2 * pi / 0.1, 2);
  const double coarse = exact - decay_rate(10), fine = exact - decay_rate(20);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.1);
}

TEST(Wetting, TheStableStepIsThatOfTheSquareGrid) {
  EXPECT_NEAR(Strip(20, 0.005, {1e-6, 1.0}).wetting.stable_step(), 6.25, 1e-9);
}

TEST(Wetting, NoWaterAndNoMomentumIsLostUntilItDrips) {
  Strip strip(20, 0.005, {1e-5, 1e6});
  strip.v = random_vectors(strip.v.size(), 1.0, 2);
  strip.wetting.add_water(30, 0.01, Vec3(0, 0, -3), strip.v[30]);
  const double before = strip.water();
  const Vec3 momentum = strip.momentum();
  for (int k = 0; k < 50; ++k) EXPECT_EQ(strip.wetting.advance(3.0, strip.v), 0.0);
  EXPECT_NEAR(strip.water(), before, 1e-12 * before);
  EXPECT_LT((strip.momentum() - momentum).norm(), 1e-12);
  for (const double w : strip.wetting.water()) EXPECT_GT(w, 0.0);
}

TEST(Wetting, WhatAVertexCannotHoldDrips) {
  Strip strip(20, 0.005, {1e-6, 2.0});
  strip.wetting.add_water(31, 0.01, Vec3::Zero(), strip.v[31]);
  const double dripped = strip.wetting.advance(0.0, strip.v);
  EXPECT_NEAR(dripped, 0.01 - 2.0 * strip.cloth.mass[31], 1e-15);
  EXPECT_NEAR(strip.wetting.mass()[31], 3.0 * strip.cloth.mass[31], 1e-15);
}

TEST(Wetting, WaterThatFallsOntoClothBringsItsMomentum) {
  Strip strip(4, 0.005, {1e-6, 1e3});
  const double m = strip.cloth.mass[7];
  strip.v[7] = {1, 0, 0};
  strip.wetting.add_water(7, m, Vec3(0, 0, -4), strip.v[7]);
  EXPECT_LT((strip.v[7] - Vec3(0.5, 0, -2)).norm(), 1e-14);
}

TEST(Wetting, BadNumbersAreRefused) {
  EXPECT_THROW(Strip(2, 0.1, {-1.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(Strip(2, 0.1, {1e-6, 0.0}), std::invalid_argument);
  Strip strip(2, 0.1, {1e-6, 1.0});
  EXPECT_THROW(strip.wetting.add_water(99, 1.0, Vec3::Zero(), strip.v[0]), std::invalid_argument);
  EXPECT_THROW(strip.wetting.add_water(0, -1.0, Vec3::Zero(), strip.v[0]), std::invalid_argument);
  EXPECT_THROW(strip.wetting.advance(1e30, strip.v), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::survey_force_test
