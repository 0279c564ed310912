// SPDX-License-Identifier: MIT
//
// Nodes that follow others exactly: hanging nodes, in forces, integrators and contacts.
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "adaptive_grids.h"
#include "dense_force.h"

namespace selvedge::followers_test {
namespace {

using adaptive_grids::kGrid;
using adaptive_grids::momentum;
using adaptive_grids::ragged;
using adaptive_grids::sum;

std::unique_ptr<Integrator> make_constrained(const ClothMesh& cloth,
                                             std::vector<std::unique_ptr<Force>> forces,
                                             const std::string& name, double tolerance) {
  return make_following(Followers(cloth), std::move(forces), [&](auto inner, std::size_t n) {
    return integrators().at(name)(std::move(inner), n, ImplicitConfig{tolerance, 5000});
  });
}

double off_the_middle(const ClothMesh& cloth, const Vectors& x) {
  double off = 0.0;
  for (const HangingNode& node : cloth.hanging)
    off = std::max(off, (x[node.v[0]] - 0.5 * (x[node.v[1]] + x[node.v[2]])).norm());
  return off;
}

/// Newton's equilibrium under a uniform strain of the border, by implicit steps with friction.
TEST(Followers, OfAGridUnderUniformStrainAreInEquilibrium) {
  Material material;
  material.bending_stiffness = 0.0;
  constexpr double strain = 0.01;
  const AdaptiveGrid adaptive = ragged(kGrid, material, 3, 2);
  const ClothMesh cloth = adaptive.cloth();
  const Vectors& rest = cloth.surface.vertices;
  const std::size_t n = rest.size();
  const auto solver = make_constrained(cloth, make_internal_forces(cloth), "implicit_euler", 1e-10);
  Particles p{rest, Vectors(n, Vec3::Zero()), cloth.mass, std::vector<double>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    p.x[i].x() *= 1.0 + strain;
    const bool border = std::abs(std::abs(rest[i].x()) - 0.5 * kGrid.size_x) < 1e-9 ||
                        std::abs(std::abs(rest[i].y()) - 0.5 * kGrid.size_y) < 1e-9;
    p.inv_mass[i] = border ? 0.0 : 1.0 / cloth.mass[i];
  }
  const Vectors uniform = p.x;
  // It comes back from a push, and stays.
  const Vectors push = random_vectors(n, 0.002, 5);
  for (std::size_t i = 0; i < n; ++i)
    if (p.inv_mass[i] > 0.0) p.x[i] += push[i];
  Followers(cloth).place(p.x);
  constexpr double h = 0.1;
  for (int step = 0; step < 60; ++step) {
    p.v.assign(n, Vec3::Zero());
    solver->begin({p, 0.0, h}, {});
    solver->solve({}, {p.v, {}}, 1.0);
    for (std::size_t i = 0; i < n; ++i) p.x[i] += h * p.v[i];
    EXPECT_LT(off_the_middle(cloth, p.x), 1e-15);
  }
  double off = 0.0;
  for (std::size_t i = 0; i < n; ++i) off = std::max(off, (p.x[i] - uniform[i]).norm());
  EXPECT_LT(off, 1e-9 * strain);
}

TEST(Followers, FollowChainsWithForcesOfTheSameSumAndMoment) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    ClothMesh cloth = ragged(kGrid, Material{}, seed).cloth();
    // Cells that differ by one level have no chains: other nodes hang on hanging ones.
    const std::int32_t m = cloth.hanging[0].v[0];
    for (const std::int32_t i : {20, 21, 22})
      if (Followers(cloth).shares(i).size() == 1) cloth.hanging.push_back({{i, m, i - 12}});
    const Followers followers(cloth);
    const std::size_t n = cloth.mass.size();
    EXPECT_EQ(followers.particles(), n);
    EXPECT_EQ(followers.nodes().size(), cloth.hanging.size());
    EXPECT_EQ(followers.leaders().size() + followers.nodes().size(), n);
    std::size_t chained = 0;
    for (const std::int32_t i : followers.nodes()) {
      double weights = 0.0;
      for (const Followers::Share& s : followers.shares(i)) weights += s.weight;
      EXPECT_EQ(weights, 1.0);
      chained += followers.shares(i).size() > 2 ? 1 : 0;
    }
    EXPECT_GT(chained, 0u);
    Vectors x = random_vectors(n, 1.0, seed);
    followers.place(x);
    EXPECT_LT(off_the_middle(cloth, x), 4e-16);
    const Vectors f = random_vectors(n, 1.0, seed + 9), y = followers.select(x);
    Vectors g(y.size(), Vec3::Zero());
    followers.gather(std::span<const Vec3>(f), std::span(g));
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (std::size_t i = 0; i < n; ++i) sum += f[i], moment += x[i].cross(f[i]);
    for (std::size_t l = 0; l < y.size(); ++l) sum -= g[l], moment -= y[l].cross(g[l]);
    EXPECT_LT(sum.norm() + moment.norm(), 1e-12);
  }
}

TEST(Followers, HandOverTheMomentumOfWhatMovedThem) {
  const ClothMesh cloth = ragged(kGrid, Material{}, 2).cloth();
  const Followers followers(cloth);
  std::vector<double> inv_mass;
  for (const double m : cloth.mass) inv_mass.push_back(1.0 / m);
  Vectors x = random_vectors(cloth.mass.size(), 1.0, 1);
  const Vec3 before = momentum(cloth.mass, x);
  followers.hand_over(cloth.mass, inv_mass, x);
  EXPECT_LT((momentum(cloth.mass, x) - before).norm(), 1e-14);
  EXPECT_LT(off_the_middle(cloth, x), 4e-16);
  const Vectors kept = x;  // what follows already stays
  followers.hand_over(cloth.mass, inv_mass, x);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT((x[i] - kept[i]).norm(), 1e-15);
  inv_mass[cloth.hanging[0].v[1]] = 0.0;  // a held leader does not move
  x = random_vectors(cloth.mass.size(), 1.0, 2);
  const Vec3 held = x[cloth.hanging[0].v[1]];
  followers.hand_over(cloth.mass, inv_mass, x);
  EXPECT_EQ(x[cloth.hanging[0].v[1]], held);
}

TEST(Followers, ANodeThatHangsOnItselfIsRefused) {
  ClothMesh cloth = make_rectangular(kGrid, Material{});
  cloth.hanging = {{{0, 1, 2}}, {{1, 0, 2}}};
  EXPECT_THROW(Followers{cloth}, std::invalid_argument);
}

/// A contact on a hanging node, in the solve: (M + w wᵀ K) v = w K u, nothing else acting.
TEST(Followers, AContactOfAHangingNodeMovesItsLeadersByTheirWeights) {
  for (const char* name : {"implicit_euler", "implicit_newton", "bdf2", "implicit_exact"}) {
    const ClothMesh cloth = ragged(kGrid, Material{}, 4).cloth();
    const Followers followers(cloth);
    const std::size_t n = cloth.mass.size();
    std::vector<std::unique_ptr<Force>> none;
    none.push_back(make_gravity(Vec3::Zero()));
    const auto solver = make_constrained(cloth, std::move(none), name, 1e-13);
    Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
    for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
    std::vector<double> lumped(followers.leaders().size(), 0.0);
    followers.gather(std::span<const double>(cloth.mass), std::span(lumped));
    const auto node = static_cast<std::size_t>(cloth.hanging.back().v[0]);
    constexpr double k = 0.3;
    const Vec3 u(1.0, -2.0, 0.5);
    const ImplicitTerm term{{static_cast<std::int32_t>(node), -1, -1, -1},
                            {1.0, 0.0, 0.0, 0.0},
                            k * Mat3::Identity(),
                            k * u};
    Vectors mean(n, Vec3::Zero()), end(mean);
    const std::vector<std::int32_t> touched{static_cast<std::int32_t>(node)};
    solver->begin({p, 0.0, 0.01, true, touched}, {mean, end});
    EXPECT_TRUE(solver->solve(std::vector{term}, {mean, end}, 1.0).converged) << name;
    double mobility = 0.0;  // wᵀ M⁻¹ w
    for (const Followers::Share& s : followers.shares(node))
      mobility += s.weight * s.weight / lumped[s.leader];
    const Vec3 impulse = k * u / (1.0 + k * mobility);
    EXPECT_LT((mean[node] - mobility * impulse).norm(), 1e-9) << name;
    for (const Followers::Share& s : followers.shares(node))
      EXPECT_LT(
          (mean[followers.leaders()[s.leader]] - s.weight / lumped[s.leader] * impulse).norm(),
          1e-9)
          << name;
    EXPECT_LT((momentum(cloth.mass, mean) - impulse).norm(), 1e-12) << name;
  }
}

/// P as a dense matrix.
Eigen::MatrixXd dense_rows(const Followers& followers) {
  const auto n = static_cast<Eigen::Index>(followers.particles());
  const auto m = static_cast<Eigen::Index>(followers.leaders().size());
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(3 * n, 3 * m);
  for (Eigen::Index i = 0; i < n; ++i)
    for (const Followers::Share& s : followers.shares(static_cast<std::size_t>(i)))
      for (int k = 0; k < 3; ++k) p(3 * i + k, 3 * s.leader + k) = s.weight;
  return p;
}

/// An undamped step away from equilibrium: (M + Pᵀ J P) y' = M y + h Pᵀ f, where M has the row sums
/// of Pᵀ M P and J = -h² ∂f/∂x.
TEST(Followers, AnImplicitStepSolvesTheReducedSystem) {
  Material material;
  material.spring_damping = material.bending_damping = 0.0;
  const ClothMesh cloth = ragged(kGrid, material, 5).cloth();
  const Followers followers(cloth);
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, random_vectors(n, 0.05, 3), cloth.mass, {}};
  const Vectors noise = random_vectors(n, 1e-3, 4);
  for (std::size_t i = 0; i < n; ++i)
    p.x[i] += noise[i] + 0.02 * std::sin(9.0 * p.x[i].x()) * Vec3::UnitZ();
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  followers.place(p.x);
  followers.place(p.v);
  constexpr double h = 0.005;
  const ForceState state{p.x, p.v, p.mass, 0.0};
  const auto size = static_cast<Eigen::Index>(3 * n);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(size);
  Eigen::MatrixXd j = Eigen::MatrixXd::Zero(size, size);
  for (const auto& force : make_internal_forces(cloth)) {
    f += flat(force_at(*force, state));
    j += assembled(*force, state, h);
  }
  const auto solver = make_constrained(cloth, make_internal_forces(cloth), "implicit_euler", 1e-13);
  Vectors mean = p.v, end = p.v;
  solver->begin({p, 0.0, h}, {mean, end});
  ASSERT_TRUE(solver->solve({}, {mean, end}, 1.0).converged);
  std::vector<double> mass(followers.leaders().size(), 0.0);
  followers.gather(std::span<const double>(cloth.mass), std::span(mass));
  const Eigen::MatrixXd rows = dense_rows(followers);
  const Vectors before = followers.select(p.v), after = followers.select(mean);
  Eigen::VectorXd left = rows.transpose() * (j * (rows * flat(after)));
  for (std::size_t l = 0; l < mass.size(); ++l)
    left.segment<3>(static_cast<Eigen::Index>(3 * l)) += mass[l] * (after[l] - before[l]);
  const Eigen::VectorXd right = h * (rows.transpose() * f);
  EXPECT_LT((left - right).norm(), 1e-8 * right.norm());
}

TEST(Followers, EveryIntegratorKeepsThemInTheMiddleAndTheWeightOfAll) {
  const ClothMesh cloth = ragged(kGrid, Material{}, 7).cloth();
  const Vec3 g(0.0, 0.0, -9.81);
  const double total = sum(cloth.mass);
  const IntegratorRegistry all = integrators();
  for (const auto* entry : all.in_order()) {
    const std::string name(entry->name());
    auto forces = make_internal_forces(cloth);
    forces.push_back(make_gravity(g));
    const auto solver = make_constrained(cloth, std::move(forces), name, 1e-10);
    const std::size_t n = cloth.mass.size();
    Particles p{cloth.surface.vertices, random_vectors(n, 0.05, 3), cloth.mass, {}};
    for (Vec3& x : p.x) x.z() = 0.02 * std::sin(9.0 * x.x());
    for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
    Followers(cloth).place(p.x);
    Followers(cloth).place(p.v);
    const Vec3 before = momentum(cloth.mass, p.v);
    const double h = 0.5 * std::min(1e-3, solver->stable_step(p, 0.0, 1e-3));
    ASSERT_GT(h, 0.0) << name;
    Vectors mean = p.v, end = p.v;
    solver->begin({p, 0.0, h}, {mean, end});
    solver->solve({}, {mean, end}, 1.0);
    EXPECT_LT(off_the_middle(cloth, mean), 1e-14) << name;
    const Vectors& v = solver->traits().ends_with_mean ? mean : end;
    EXPECT_LT(off_the_middle(cloth, v), 1e-14) << name;
    if (name.find("printed") != std::string::npos || name == "damped_verlet") continue;
    EXPECT_LT((momentum(cloth.mass, v) - before - total * h * g).norm(), 2e-6 * total) << name;
  }
}

/// Waving cloth with hanging nodes, stepped by one integrator.
struct Waving {
  explicit Waving(const std::string& name)
      : cloth(ragged(kGrid, Material{}, 7).cloth()),
        solver(make_constrained(cloth, make_internal_forces(cloth), name, 1e-12)) {
    const std::size_t n = cloth.mass.size();
    p = {cloth.surface.vertices, random_vectors(n, 0.05, 3), cloth.mass, {}};
    for (Vec3& x : p.x) x.z() = 0.02 * std::sin(9.0 * x.x());
    for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
    Followers(cloth).place(p.x);
    Followers(cloth).place(p.v);
  }
  void step(std::span<const std::int32_t> touched = {}) {
    Vectors mean = p.v, end = p.v;
    solver->begin({p, time, kStep, !touched.empty(), touched}, {mean, end});
    EXPECT_TRUE(solver->solve({}, {mean, end}, 1.0).converged);
    for (std::size_t i = 0; i < p.x.size(); ++i) p.x[i] += kStep * mean[i];
    p.v = solver->traits().ends_with_mean ? mean : end;
    solver->accept({p.x, p.v, p.mass, time});
    time += kStep;
  }

  static constexpr double kStep = 2e-3;  // s
  ClothMesh cloth;
  std::unique_ptr<Integrator> solver;
  Particles p;
  double time = 0.0;
};

TEST(Followers, AnIntegratorOfSeveralStepsContinuesFromItsSavedMemory) {
  Waving whole("bdf2"), resumed("bdf2"), anew("bdf2");
  for (int i = 0; i < 3; ++i) whole.step();
  std::vector<double> memory;
  whole.solver->save_memory(memory);
  for (Waving* other : {&resumed, &anew}) other->p = whole.p, other->time = whole.time;
  resumed.solver->restore_memory(memory);
  for (Waving* one : {&whole, &resumed, &anew}) one->step();
  EXPECT_EQ(resumed.p.x, whole.p.x);
  EXPECT_EQ(resumed.p.v, whole.p.v);
  EXPECT_NE(anew.p.v, whole.p.v);  // its first step is one of implicit Euler
  memory.resize(memory.size() / 2);
  EXPECT_THROW(resumed.solver->restore_memory(memory), std::invalid_argument);
}

TEST(Followers, AHangingNodeInContactPutsItsPieceIntoContact) {
  Waving touched("bdf2"), euler("implicit_euler"), free("bdf2");
  for (int i = 0; i < 3; ++i) touched.step(), free.step();
  euler.p = touched.p;
  euler.time = touched.time;
  const std::vector<std::int32_t> node{touched.cloth.hanging.front().v[0]};
  touched.step(node);
  euler.step(node);
  free.step();
  double to_euler = 0.0, to_free = 0.0;
  for (std::size_t i = 0; i < euler.p.v.size(); ++i) {
    to_euler = std::max(to_euler, (touched.p.v[i] - euler.p.v[i]).norm());
    to_free = std::max(to_free, (touched.p.v[i] - free.p.v[i]).norm());
  }
  EXPECT_LT(to_euler, 1e-9);
  EXPECT_GT(to_free, 1e-5);
}

/// A force of one newton per particle that only acts after a time.
class LateForce final : public Force {
 public:
  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    for (Vec3& g : f) g.x() += state.time > 1.0 ? 1.0 : 0.0;
  }
  double energy(const ForceState&) const override { return 0.0; }
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const ForceState&, double, BlockMatrix&) const override {}
  void add_stiffness_bound(const ForceState&, std::span<double>, std::span<double>) const override {
  }
};

TEST(Followers, ForcesOfTheLeadersKnowTheTime) {
  const ClothMesh cloth = ragged(kGrid, Material{}, 7).cloth();
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  for (const double time : {0.0, 2.0}) {
    std::vector<std::unique_ptr<Force>> late;
    late.push_back(std::make_unique<LateForce>());
    const auto solver = make_constrained(cloth, std::move(late), "implicit_euler", 1e-12);
    Vectors mean = p.v, end = p.v;
    solver->begin({p, time, 0.01}, {mean, end});
    solver->solve({}, {mean, end}, 1.0);
    const double expected = time > 1.0 ? 0.01 * static_cast<double>(n) : 0.0;
    EXPECT_NEAR(momentum(cloth.mass, mean).x(), expected, 1e-9);
  }
}

}  // namespace
}  // namespace selvedge::followers_test
