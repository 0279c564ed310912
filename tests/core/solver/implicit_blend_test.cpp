// SPDX-License-Identifier: MIT
//
// The blend of implicit midpoint and implicit Euler: what it keeps, how it meets contacts, and what
// it falls back to.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace selvedge::implicit_blend_test {
namespace {

using Vectors = std::vector<Vec3>;

/// A sheet of 0.5 m in the plane z = 0 that gravity moves.
struct Sheet {
  ClothMesh cloth = make_rectangular({0.5, 0.5, 10, 10}, Material{});
  std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
  std::unique_ptr<Integrator> method;
  double time = 0.0;

  explicit Sheet(const std::string& name, double tolerance = 1e-3, Vec3 g = {0, 0, -9.81}) {
    for (const double m : p.mass) p.inv_mass.push_back(1.0 / m);
    ForceList forces = make_internal_forces(cloth);
    forces.push_back(make_gravity(g));
    method = integrators().at(name)({}, std::move(forces), n, {.tolerance = tolerance});
  }
  void hold_an_edge() {
    for (std::size_t i = 0; i < n; ++i)
      if (p.x[i].y() > 0.249) p.inv_mass[i] = 0.0;
  }
  void shake(std::uint32_t seed) {
    std::mt19937 draw(seed);
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    for (Vec3& v : p.v) v = Vec3(number(draw), number(draw), number(draw));
  }
  /// An attempt; it is not accepted. Gives mean and end velocities.
  std::pair<Vectors, Vectors> attempt(double h, std::span<const std::int32_t> touched = {},
                                      std::span<const ImplicitTerm> terms = {}) {
    Vectors mean = p.v, v = p.v;
    method->begin({p, time, h, !touched.empty(), touched}, {mean, v});
    EXPECT_TRUE(method->solve(terms, {mean, v}, 1.0).converged);
    return {mean, method->traits().ends_with_mean ? mean : v};
  }
  void accept(double h, const std::pair<Vectors, Vectors>& end) {
    for (std::size_t i = 0; i < n; ++i) p.x[i] += h * end.first[i];
    p.v = end.second;
    time += h;
    method->accept({p.x, p.v, p.mass, time});
  }
  double kinetic() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) sum += 0.5 * p.mass[i] * p.v[i].squaredNorm();
    return sum;
  }
};

/// What a sheet that is held by an edge keeps of its first swing in the fourth half second.
double kept_swing(const std::string& name, int steps_per_frame) {
  Sheet sheet(name);
  sheet.hold_an_edge();
  const double h = 1.0 / (60.0 * steps_per_frame);
  double first = 0.0, fourth = 0.0;
  for (int step = 0; step < 120 * steps_per_frame; ++step) {
    sheet.accept(h, sheet.attempt(h));
    if (sheet.time < 0.5) first = std::max(first, sheet.kinetic());
    if (sheet.time > 1.5) fourth = std::max(fourth, sheet.kinetic());
  }
  return fourth / first;
}

TEST(ImplicitBlend, KeepsTheSwingOfASheetAtTwoStepsAFrame) {
  const double fine = kept_swing("implicit_euler", 16);
  EXPECT_GT(kept_swing("implicit_blend", 2), 0.85 * fine);
  EXPECT_LT(kept_swing("implicit_euler", 2), 0.6 * fine);
}

TEST(ImplicitBlend, ExpectsTheMotionOfAFreeFallWhateverTheSteps) {
  const Vec3 g(0.0, 0.0, -9.81);
  Sheet sheet("implicit_blend", 1e-12, g);
  for (const double h : {0.01, 0.01, 0.005, 0.008, 0.016, 0.016, 0.01}) {
    Vectors mean = sheet.p.v;
    for (Vec3& u : mean) u += h * g;
    ASSERT_TRUE(sheet.method->expect(h, sheet.p.v, mean));
    const auto end = sheet.attempt(h);
    for (std::size_t i = 0; i < sheet.n; ++i)
      EXPECT_LT((mean[i] - end.first[i]).norm(), 1e-9) << h << ", " << i;
    sheet.accept(h, end);
  }
}

Vec3 momentum(const Sheet& sheet, std::span<const Vec3> v) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < sheet.n; ++i) sum += sheet.p.mass[i] * v[i];
  return sum;
}

// The terms of contacts act on the mean velocity, and their impulses change the end velocity.
TEST(ImplicitBlend, ContactsStopTheEndVelocityAndTheirImpulsesChangeTheMomentum) {
  for (const bool known : {true, false})
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed << " known before the step " << known);
      const std::vector<std::int32_t> touched{static_cast<std::int32_t>(seed), 40, 77};
      std::vector<ImplicitTerm> terms;
      for (const std::int32_t i : touched)
        terms.push_back({{i, -1, -1, -1}, {1.0, 0, 0, 0}, Mat3::Identity(), Vec3(0, 0, 1e-3)});
      Sheet own("implicit_blend", 1e-9, Vec3::Zero());
      own.shake(seed);
      Vectors mean = own.p.v, v = own.p.v;
      own.method->begin({own.p, 0.0, 0.01, known, known ? touched : std::vector<std::int32_t>{}},
                        {mean, v});
      if (!known) own.method->solve({}, {mean, v}, 1.0);
      EXPECT_TRUE(own.method->solve(terms, {mean, v}, 1.0).converged);
      Vec3 impulse = Vec3::Zero();
      for (const ImplicitTerm& t : terms) {
        EXPECT_EQ(v[t.particle[0]], mean[t.particle[0]]);
        impulse += t.rhs - t.matrix * mean[t.particle[0]];
      }
      EXPECT_LT((momentum(own, v) - momentum(own, own.p.v) - impulse).norm(),
                1e-6 * impulse.norm());
      EXPECT_NE(v[0], mean[0]);
    }
}

TEST(ImplicitBlend, TakesARejectedStepAgainAsImplicitEuler) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    Sheet blend("implicit_blend"), euler("implicit_euler");
    for (Sheet* each : {&blend, &euler}) each->shake(seed);
    EXPECT_NE(blend.attempt(0.01).first, euler.attempt(0.01).first) << seed;
    const auto again = blend.attempt(0.01);
    EXPECT_EQ(again.first, euler.attempt(0.01).first) << seed;
    EXPECT_EQ(again.second, again.first) << seed;
    blend.accept(0.01, again);
    euler.accept(0.01, again);
    EXPECT_EQ(blend.attempt(0.01).first, euler.attempt(0.01).first) << seed << ", in the pause";
  }
}

TEST(ImplicitBlend, PausesLongerWhereItFailsAgain) {
  Sheet sheet("implicit_blend");
  sheet.hold_an_edge();
  std::vector<int> pauses;
  for (int failure = 0; failure < 3; ++failure) {
    sheet.attempt(0.01);
    sheet.accept(0.01, sheet.attempt(0.01));  // a rejected attempt before it
    pauses.push_back(0);
    for (;; ++pauses.back()) {
      const auto end = sheet.attempt(0.01);
      if (end.first != end.second) {
        sheet.accept(0.01, end);
        break;
      }
      sheet.accept(0.01, end);
    }
  }
  EXPECT_EQ(pauses[0], 2);
  EXPECT_GT(pauses[1], pauses[0]);
  EXPECT_GT(pauses[2], pauses[1]);
}

}  // namespace
}  // namespace selvedge::implicit_blend_test
