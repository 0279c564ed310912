// SPDX-License-Identifier: MIT
//
// Every internal force in every kind of state: no sum, no moment, never a NaN; minus the gradient
// of its energy, and the Jacobian its second derivative, by hyper-dual numbers on energies that are
// written down here once more (force_cases.cpp).
#include <selvedge/tests/dense_algebra.h>
#include <selvedge/tests/force_cases.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include <selvedge/tests/dense_force.h>

namespace selvedge::testing::internal_force_test {
namespace {

constexpr double kRelative = 1e-12;

/// -∂F/∂x and -∂F/∂v as assembled: A(h) = h D + h² K at h = 1 and 2.
struct Assembled {
  Eigen::MatrixXd stiffness, damping;
};
Assembled parts(Force& force, const ForceStateOwner& state) {
  const Eigen::MatrixXd one = assembled(force, state, 1.0), two = assembled(force, state, 2.0);
  return {0.5 * (two - 2.0 * one), 0.5 * (4.0 * one - two)};
}

/// Value, gradient and second derivative of an energy.
struct Expansion {
  double value = 0.0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};
Expansion expand(const EnergyOracle& energy, const Vectors& x) {
  const auto n = static_cast<Eigen::Index>(3 * x.size());
  Expansion e{0.0, Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  std::vector<HyperVec> h(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) h[i] = {x[i][0], x[i][1], x[i][2]};
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = 0; b < n; ++b) {
      h[a / 3][a % 3].da = 1.0;
      h[b / 3][b % 3].db = 1.0;
      const HyperDual u = energy(h);
      h[a / 3][a % 3].da = 0.0;
      h[b / 3][b % 3].db = 0.0;
      e.value = u.value;
      e.gradient[a] = u.da;
      e.hessian(a, b) = u.dab;
    }
  return e;
}

class EveryInternalForce : public ::testing::TestWithParam<std::size_t> {
 protected:
  std::vector<ForceCase> cases_ = internal_force_cases();
  ForceCase& c_ = cases_[GetParam()];
};

TEST_P(EveryInternalForce, HasNoSumAndNoMomentInTenThousandStates) {
  std::mt19937 random(2024);
  Balance worst;
  constexpr int states = 10000;
  for (int i = 0; i < states; ++i) {
    const auto shape = static_cast<Shape>(i % kShapes);
    const Balance b = balance_of(c_, random_state(c_, shape, random));
    worst = {std::max(worst.sum, b.sum), std::max(worst.moment, b.moment)};
    ASSERT_LE(b.sum, kRelative) << c_.name << ", shape " << i % kShapes << ", state " << i;
    ASSERT_LE(b.moment, kRelative) << c_.name << ", shape " << i % kShapes << ", state " << i;
  }
  RecordProperty("worst_sum", std::to_string(worst.sum));
  RecordProperty("worst_moment", std::to_string(worst.moment));
}

TEST_P(EveryInternalForce, IsMinusTheGradientOfItsEnergy) {
  if (!c_.energy) return;
  std::mt19937 random(7);
  constexpr int states = 60;
  for (int i = 0; i < states; ++i) {
    ForceStateOwner s = random_state(c_, i % 2 == 0 ? Shape::near_rest : Shape::anywhere, random);
    if (i % 2 == 1)  // of size 1
      for (Vec3& x : s.x) x /= flat(s.x).cwiseAbs().maxCoeff();
    s.v.assign(s.v.size(), Vec3::Zero());
    const Expansion e = expand(c_.energy, s.x);
    const Vectors f = force_at(*c_.force, s);
    const double scale = std::max(flat(f).norm(), e.hessian.norm());  // per metre
    EXPECT_LE((flat(f) + e.gradient).norm(), kRelative * scale) << c_.name << ", state " << i;
    EXPECT_NEAR(c_.force->energy(s.view()), e.value, kRelative * scale) << c_.name;
  }
}

TEST_P(EveryInternalForce, HasTheSecondDerivativeAsItsJacobianWhereNothingIsDropped) {
  if (c_.exact_jacobian.empty()) return;
  const ForceStateOwner s{c_.exact_jacobian, Vectors(c_.rest.size(), Vec3::Zero()), c_.mass};
  const Expansion e = expand(c_.energy, s.x);
  const Eigen::MatrixXd k = parts(*c_.force, s).stiffness;
  EXPECT_GT(e.hessian.norm(), 0.0);
  EXPECT_LE((k - e.hessian).norm(), kRelative * e.hessian.norm()) << c_.name;
}

TEST_P(EveryInternalForce, HasItsSlopeInTheVelocitiesAsJacobian) {
  std::mt19937 random(11);
  for (int i = 0; i < 20; ++i) {
    const ForceStateOwner s = random_state(c_, Shape::near_rest, random);
    const Eigen::MatrixXd d = parts(*c_.force, s).damping;
    // Forces are affine in the velocities: differences of any length are exact.
    for (std::size_t k = 0; k < 3 * s.v.size(); ++k) {
      ForceStateOwner faster = s;
      faster.v[k / 3][k % 3] += 1.0;
      const Vectors f = force_at(*c_.force, s), g = force_at(*c_.force, faster);
      EXPECT_LE((flat(g) - flat(f) + d.col(static_cast<Eigen::Index>(k))).norm(),
                1e-10 * (d.norm() + flat(f).norm()))
          << c_.name;
    }
  }
}

TEST_P(EveryInternalForce, AssemblesAFiniteSymmetricMatrixWithoutNegativeEigenvalues) {
  std::mt19937 random(13);
  constexpr int states = 400;
  for (int i = 0; i < states; ++i) {
    const auto shape = static_cast<Shape>(i % kShapes);
    const Eigen::MatrixXd a = assembled(*c_.force, random_state(c_, shape, random), 0.01);
    ASSERT_TRUE(a.allFinite()) << c_.name << ", shape " << i % kShapes;
    EXPECT_LE((a - a.transpose()).norm(), 1e-13 * a.norm()) << c_.name;
    EXPECT_GE(symmetric_eigenvalues(a).minCoeff(), -1e-12 * a.norm()) << c_.name;
  }
}

TEST_P(EveryInternalForce, BoundsItsEigenvalues) {
  if (!c_.energy) return;
  std::mt19937 random(17);
  for (int i = 0; i < 50; ++i) {
    const ForceStateOwner s = random_state(c_, Shape::near_rest, random);
    const Expansion e = expand(c_.energy, s.x);
    std::vector<double> stiffness(s.x.size(), 0.0), damping(s.x.size(), 0.0);
    c_.force->add_stiffness_bound(s.view(), stiffness, damping);
    EXPECT_LE(symmetric_eigenvalues(e.hessian).maxCoeff(),
              *std::max_element(stiffness.begin(), stiffness.end()) * (1.0 + 1e-9))
        << c_.name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryInternalForce,
                         ::testing::Range<std::size_t>(0, internal_force_cases().size()),
                         [](const auto& info) { return internal_force_cases()[info.param].name; });

}  // namespace
}  // namespace selvedge::testing::internal_force_test
