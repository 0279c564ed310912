// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/tests/dense_algebra.h>

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <set>

#include "crumple.h"

namespace selvedge::core_test {
namespace {

TEST(Forces, AreTheNegativeGradientOfTheirEnergy) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Crumple c(0.03, seed);
    c.v.assign(c.v.size(), Vec3::Zero());
    std::vector<NamedForce> forces = internal_forces(c, 0.02);
    forces.push_back({"gravity", make_gravity({1.0, 2.0, -9.81})});
    for (const auto& [name, force] : forces) {
      const Vectors f = force_at(*force, c.state());
      const double scale = flat(f).cwiseAbs().maxCoeff();
      for (std::size_t k = 0; k < 3 * c.x.size(); ++k) {
        constexpr double step = 1e-6;
        double& u = c.x[k / 3][k % 3];
        const double old = u;
        u = old + step;
        const double up = force->energy(c.state());
        u = old - step;
        const double down = force->energy(c.state());
        u = old;
        EXPECT_NEAR(f[k / 3][k % 3], (down - up) / (2.0 * step), 1e-6 * scale)
            << name << ", seed " << seed;
      }
    }
  }
}

TEST(Forces, AreAffineInTheVelocity) {
  const Crumple c(0.03);
  for (const auto& [name, force] : all_forces(c, 0.02)) {
    Crumple zero = c, twice = c;
    for (std::size_t i = 0; i < c.v.size(); ++i) {
      zero.v[i].setZero();
      twice.v[i] *= 2.0;
    }
    const Vectors f0 = force_at(*force, zero.state()), f1 = force_at(*force, c.state()),
                  f2 = force_at(*force, twice.state());
    const Eigen::VectorXd bend = flat(f2) - 2.0 * flat(f1) + flat(f0);
    EXPECT_LT(bend.norm(), 1e-12 * (1.0 + flat(f2).norm())) << name;
  }
}

TEST(Forces, TheVelocityJacobianIsExact) {
  const Crumple c(0.03);
  for (const auto& [name, force] : all_forces(c, 0.02)) {
    // -h D - h² K at h and 2h give D alone: D = (4 J(h) - J(2h)) / (-2h).
    constexpr double h = 0.01;
    const Eigen::MatrixXd d =
        (4.0 * assembled(*force, c.state(), h) - assembled(*force, c.state(), 2.0 * h)) /
        (-2.0 * h);
    const Eigen::MatrixXd exact = difference_jacobian(*force, c, true);
    EXPECT_LT((d - exact).norm(), 1e-7 * (exact.norm() + 1e-12)) << name;
  }
}

TEST(Forces, TheStretchedSpringJacobianIsExact) {
  Crumple c(0.01);
  c.v.assign(c.v.size(), Vec3::Zero());
  for (Vec3& x : c.x) x *= 1.5;  // every spring longer than at rest: nothing is dropped
  const auto force = make_hooke_force(with_damping(c.cloth, 0.0).springs, c.x.size());
  const Eigen::MatrixXd exact = difference_jacobian(*force, c, false);
  EXPECT_LT((assembled(*force, c.state(), 1.0) + exact).norm(), 1e-7 * exact.norm());
}

TEST(Forces, TheBendingJacobianIsExactAtTheRestAngle) {
  // At θ = θ0 the dropped curvature term is multiplied by zero.
  Crumple c(0.02);
  c.v.assign(c.v.size(), Vec3::Zero());
  for (Hinge& hinge : c.cloth.hinges) hinge.rest_angle = detail::dihedral(c.x, hinge.v).angle;
  const auto force = make_bending_force(with_damping(c.cloth, 0.0).hinges, c.x.size());
  const Eigen::MatrixXd exact = difference_jacobian(*force, c, false);
  EXPECT_LT((assembled(*force, c.state(), 1.0) + exact).norm(), 1e-6 * exact.norm());
}

TEST(Forces, TheAssembledMatrixIsSymmetricAndPositiveSemidefinite) {
  for (const double noise : {0.0, 0.01, 0.05, 0.2}) {
    const Crumple c(noise);
    for (const auto& [name, force] : all_forces(c, 0.02)) {
      const Eigen::MatrixXd a = assembled(*force, c.state(), 0.01);
      EXPECT_LE((a - a.transpose()).norm(), 1e-13 * a.norm()) << name;
      EXPECT_GE(selvedge::testing::symmetric_eigenvalues(a).minCoeff(), -1e-12 * a.norm())
          << name << " " << noise;
    }
  }
}

TEST(Forces, InternalForcesHaveNoSumAndNoMoment) {
  const Crumple c(0.05);
  for (const auto& [name, force] : internal_forces(c, 0.02)) {
    const Vectors f = force_at(*force, c.state());
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    double size = 0.0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      sum += f[i];
      moment += c.x[i].cross(f[i]);
      size += f[i].norm();
    }
    EXPECT_LT(sum.norm(), 1e-12 * size) << name;
    EXPECT_LT(moment.norm(), 1e-12 * size) << name;
  }
}

TEST(Forces, TurnWithTheScene) {
  const Crumple c(0.05);
  const Mat3 q = Eigen::AngleAxisd(1.1, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  Crumple turned = c;
  for (std::size_t i = 0; i < c.x.size(); ++i) {
    turned.x[i] = q * c.x[i] + Vec3(3.0, -1.0, 2.0);
    turned.v[i] = q * c.v[i];
  }
  const AirConfig air{{1.0, 2.0, 3.0}, 0.5, 0.2}, turned_air{q * air.wind, 0.5, 0.2};
  auto forces = internal_forces(c, 0.02), turned_forces = internal_forces(c, 0.02);
  forces.push_back({"air", make_air_force(air, c.cloth.surface.triangles, c.areas(), c.x.size())});
  turned_forces.push_back(
      {"air", make_air_force(turned_air, c.cloth.surface.triangles, c.areas(), c.x.size())});
  for (std::size_t k = 0; k < forces.size(); ++k) {
    const Vectors f = force_at(*forces[k].force, c.state());
    const Vectors g = force_at(*turned_forces[k].force, turned.state());
    double error = 0.0;
    for (std::size_t i = 0; i < f.size(); ++i) error = std::max(error, (q * f[i] - g[i]).norm());
    EXPECT_LT(error, 1e-12 * flat(f).norm()) << forces[k].name;
  }
}

TEST(Forces, RigidMotionIsNotDamped) {
  Crumple c(0.05);
  const Vec3 spin(0.3, -2.0, 1.0);
  const ClothMesh cloth = with_damping(c.cloth, 1.0);
  for (std::size_t i = 0; i < c.x.size(); ++i) c.v[i] = Vec3(5.0, 1.0, 2.0) + spin.cross(c.x[i]);
  const Vectors moving = force_at(*make_hooke_force(cloth.springs, c.x.size()), c.state());
  const Vectors bent = force_at(*make_bending_force(cloth.hinges, c.x.size()), c.state());
  c.v.assign(c.v.size(), Vec3::Zero());
  const Vectors still = force_at(*make_hooke_force(cloth.springs, c.x.size()), c.state());
  const Vectors flat_bent = force_at(*make_bending_force(cloth.hinges, c.x.size()), c.state());
  EXPECT_LT((flat(moving) - flat(still)).norm(), 1e-11 * flat(still).norm());
  EXPECT_LT((flat(bent) - flat(flat_bent)).norm(), 1e-11 * flat(flat_bent).norm());
}

TEST(Forces, WindPushesAlongItselfAndNotAClothThatMovesWithIt) {
  Crumple c(0.02);
  const Vec3 wind(0.0, 0.0, 4.0);
  const auto force =
      make_air_force({wind, 0.5, 0.1}, c.cloth.surface.triangles, c.areas(), c.x.size());
  c.v.assign(c.v.size(), Vec3::Zero());
  Vec3 sum = Vec3::Zero();
  for (const Vec3& f : force_at(*force, c.state())) sum += f;
  EXPECT_GT(sum.z(), 0.0);
  c.v.assign(c.v.size(), wind);
  EXPECT_LT(flat(force_at(*force, c.state())).norm(), 1e-14);
}

TEST(Forces, DegenerateShapesGiveFiniteForces) {
  Crumple c(0.0);
  c.x.assign(c.x.size(), Vec3(1.0, 2.0, 3.0));
  for (const auto& [name, force] : all_forces(c, 0.02)) {
    EXPECT_TRUE(flat(force_at(*force, c.state())).allFinite()) << name;
    EXPECT_TRUE(assembled(*force, c.state(), 0.01).allFinite()) << name;
  }
}

TEST(Forces, BadInputIsRefusedWithItsValue) {
  const std::vector<Spring> outside{{0, 9, 1.0, 1.0}}, no_length{{0, 1, 0.0, 1.0}},
      not_a_number{{0, 1, 1.0, std::nan("")}};
  EXPECT_THROW(make_hooke_force(outside, 2), std::invalid_argument);
  EXPECT_THROW(make_hooke_force(no_length, 2), std::invalid_argument);
  EXPECT_THROW(make_hooke_force(not_a_number, 2), std::invalid_argument);
  const std::vector<Hinge> twice{{{0, 1, 2, 2}, 0.0, 1.0}};
  EXPECT_THROW(make_bending_force(twice, 4), std::invalid_argument);
  EXPECT_THROW(make_gravity({0.0, std::nan(""), 0.0}), std::invalid_argument);
  EXPECT_THROW(make_air_force({Vec3::Zero(), -1.0, 0.0}, {}, {}, 0), std::invalid_argument);
}

template <class Make>
std::string refusal(const Make& make) {
  try {
    make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Forces, BadDampingIsRefusedWithTheIndexOfItsElement) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {-1.0, inf, -inf, std::nan("")}) {
    const std::vector<Spring> springs{{0, 1, 1.0, 1.0}, {1, 2, 1.0, 1.0, bad}};
    const std::string of_spring = refusal([&] { make_hooke_force(springs, 3); });
    EXPECT_EQ(of_spring.find("damping of spring 1 must be finite and at least 0, not "), 0u)
        << of_spring;
    const std::vector<Hinge> hinges{{{0, 1, 2, 3}, 0.0, 1.0}, {{1, 4, 2, 3}, 0.0, 1.0, bad}};
    const std::string of_hinge = refusal([&] { make_bending_force(hinges, 5); });
    EXPECT_EQ(of_hinge.find("damping of hinge 1 must be finite and at least 0, not "), 0u)
        << of_hinge;
  }
}

TEST(Forces, EverySpringIsDampedByItsOwn) {
  // Two springs at rest length, pulled apart at 2 m/s: only damping acts, k·damping·dL/dt.
  const std::vector<Spring> springs{{0, 1, 1.0, 10.0, 0.1}, {2, 3, 1.0, 10.0, 0.3}};
  const auto force = make_hooke_force(springs, 4);
  const Vectors x{{0, 0, 0}, {1, 0, 0}, {0, 5, 0}, {1, 5, 0}};
  const Vectors v{{0, 0, 0}, {2, 0, 0}, {0, 0, 0}, {2, 0, 0}};
  const std::vector<double> mass(4, 1.0);
  const ForceState state{x, v, mass, 0.0};
  const Vectors f = force_at(*force, state);
  EXPECT_NEAR(f[0].x(), 2.0, 1e-14);
  EXPECT_NEAR(f[2].x(), 6.0, 1e-14);
  std::vector<double> stiffness(4, 0.0), damping(4, 0.0);
  force->add_stiffness_bound(state, stiffness, damping);
  EXPECT_NEAR(damping[1], 2.0, 1e-14);
  EXPECT_NEAR(damping[3], 6.0, 1e-14);
}

TEST(Forces, EveryHingeIsDampedByItsOwn) {
  // A folded hinge and a copy of it far away, both folding at the same rate.
  Vectors x{{0, -1, 0.2}, {0, 1, 0.3}, {-1, 0, 0}, {1, 0, 0}}, v(8, Vec3::Zero());
  for (int k = 0; k < 4; ++k) x.push_back(x[k] + Vec3(0, 0, 16));
  v[0] = v[4] = {0, 0, 1};
  const double angle = detail::dihedral(x, {0, 1, 2, 3}).angle;
  const std::vector<Hinge> hinges{{{0, 1, 2, 3}, angle, 10.0, 0.1},
                                  {{4, 5, 6, 7}, angle, 10.0, 0.3}};
  const auto force = make_bending_force(hinges, 8);
  const std::vector<double> mass(8, 1.0);
  const ForceState state{x, v, mass, 0.0};
  const Vectors f = force_at(*force, state);
  std::vector<double> stiffness(8, 0.0), damping(8, 0.0);
  force->add_stiffness_bound(state, stiffness, damping);
  for (int k = 0; k < 4; ++k) {
    EXPECT_GT(f[k].norm(), 0.1);
    EXPECT_LT((f[k + 4] - 3.0 * f[k]).norm(), 1e-12) << k;
    EXPECT_NEAR(damping[k], 0.1 * stiffness[k], 1e-12) << k;
    EXPECT_NEAR(damping[k + 4], 0.3 * stiffness[k], 1e-12) << k;
  }
}

TEST(Colorings, NoTwoChunksOfAColorShareAParticle) {
  const ClothMesh cloth = make_rectangular({1, 1, 40, 33}, Material{});
  std::vector<std::int32_t> corners;
  for (const Hinge& hinge : cloth.hinges)
    corners.insert(corners.end(), hinge.v.begin(), hinge.v.end());
  const detail::Coloring coloring = detail::color_elements(corners, 4, cloth.mass.size());
  EXPECT_EQ(std::set<std::int32_t>(coloring.order.begin(), coloring.order.end()).size(),
            cloth.hinges.size());
  EXPECT_EQ(coloring.order.size(), cloth.hinges.size());
  EXPECT_GT(cloth.hinges.size(), 5 * detail::kColorChunk);
  for (std::size_t c = 0; c + 1 < coloring.color_begin.size(); ++c) {
    std::vector<std::size_t> owner(cloth.mass.size(), SIZE_MAX);
    for (std::size_t i = coloring.color_begin[c]; i < coloring.color_begin[c + 1]; ++i)
      for (int k = 0; k < 4; ++k) {
        const std::size_t chunk = (i - coloring.color_begin[c]) / detail::kColorChunk;
        std::size_t& of = owner[corners[4 * coloring.order[i] + k]];
        EXPECT_TRUE(of == SIZE_MAX || of == chunk);
        of = chunk;
      }
  }
}

TEST(BlockMatrices, MultiplyAsTheDenseMatrixDoes) {
  BlockMatrix a(4, {{2, 0}, {0, 2}, {1, 3}});
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(12, 12);
  int count = 0;
  for (const auto& [i, j] :
       std::vector<Edge>{{0, 0}, {0, 2}, {1, 1}, {1, 3}, {2, 0}, {2, 2}, {3, 1}, {3, 3}}) {
    const Mat3 block = Mat3::Constant(++count) + Mat3(Vec3(1, 2, 3).asDiagonal()) * count;
    a.values()[a.slot(i, j)] = block;
    dense.block<3, 3>(3 * i, 3 * j) = block;
  }
  EXPECT_EQ(a.values().size(), 8u);
  EXPECT_THROW(a.slot(0, 1), std::out_of_range);
  EXPECT_THROW(a.slot(4, 0), std::out_of_range);
  EXPECT_THROW(BlockMatrix(2, {{0, 2}}), std::invalid_argument);
  const Vectors x = random_vectors(4, 1.0, 3);
  Vectors y(4);
  a.multiply(x, y);
  EXPECT_LT((dense * flat(x) - flat(y)).norm(), 1e-13);
}

TEST(BlockMatrices, SetSomeRowsToZero) {
  BlockMatrix a(4, {{2, 0}, {1, 3}});
  for (Mat3& block : a.values()) block.setOnes();
  a.set_zero(1, 3);
  for (const auto& [i, j] :
       std::vector<Edge>{{0, 0}, {0, 2}, {1, 1}, {1, 3}, {2, 0}, {2, 2}, {3, 1}, {3, 3}})
    EXPECT_EQ(a.values()[a.slot(i, j)], Mat3::Constant(i == 1 || i == 2 ? 0.0 : 1.0)) << i << j;
}

/// Springs, hinges and the friction of curvatures of a crumpled sheet.
std::vector<std::unique_ptr<Force>> forces_with_rows(const ClothMesh& cloth) {
  const std::size_t n = cloth.mass.size();
  std::vector<CurvatureFriction> frictions;
  for (std::int32_t k = 0; k + 2 < static_cast<std::int32_t>(cloth.hinges.size()); k += 3)
    frictions.push_back(
        {{{k, {1.0, 0.2, -0.3}}, {k + 1, {0.1, 0.8, 0.4}}, {k + 2, {0.3, -0.2, 0.9}}}, 2.0, 0.3});
  std::vector<std::unique_ptr<Force>> forces;
  forces.push_back(make_hooke_force(cloth.springs, n));
  forces.push_back(make_bending_force(cloth.hinges, n));
  forces.push_back(make_curvature_friction(cloth.hinges, frictions, n));
  return forces;
}

TEST(JacobianRows, AddWhatTheWholeJacobianAddsToThemAndNothingElse) {
  Material material;
  material.spring_damping = 0.02;
  const ClothMesh cloth = make_rectangular({0.5, 0.4, 11, 9}, material);
  const std::size_t n = cloth.mass.size();
  ForceStateOwner state{random_vectors(n, 0.02, 7), random_vectors(n, 1.0, 8), cloth.mass};
  for (std::size_t i = 0; i < n; ++i) state.x[i] += cloth.surface.vertices[i];
  for (const auto& force : forces_with_rows(cloth)) {
    std::vector<Edge> links;
    force->add_links(links);
    BlockMatrix whole(n, links), rows(n, links);
    force->bind(whole);
    force->add_jacobian(state, 0.01, whole);
    const std::vector<Mat3> expected(whole.values().begin(), whole.values().end());
    // Ranges of 1, 2, 3 … rows, the last ones first.
    const JacobianRows* jacobian = force->jacobian_rows(state, 0.01);
    ASSERT_NE(jacobian, nullptr);
    for (std::size_t last = n, count = 1; last > 0; ++count) {
      const std::size_t first = last - std::min(last, count);
      jacobian->add_rows(first, last, rows);
      const auto begin = static_cast<std::size_t>(rows.row_begin()[first]);
      for (std::size_t k = 0; k < expected.size(); ++k)
        ASSERT_EQ(rows.values()[k], k < begin ? Mat3(Mat3::Zero()) : expected[k]) << first;
      last = first;
    }
    EXPECT_GT(rows.values()[0].norm(), 0.0);
  }
}

// -- texts ----------------------------------------------------------------------------------------

TEST(Text, WhatActsOnADisplayIsEscapedAndOrdinaryLettersAreNot) {
  EXPECT_EQ(printable("a\x1b[31mb"), "a\\x1b[31mb");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m")
      << "CSI of UTF-8";
  EXPECT_EQ(printable("\x9b"
                      "31m"),
            "\\x9b31m")
      << "CSI of 8-bit terminals";
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "cba"),
            "\\xe2\\x80\\xae"
            "cba")
      << "right to left";
  EXPECT_EQ(printable("\xe2\x81\xa6"), "\\xe2\\x81\\xa6");
  EXPECT_EQ(printable("\xe0\x80\x9b"), "\\xe0\\x80\\x9b") << "overlong";
  // Their last bytes lie between 0x80 and 0x9f.
  for (const char* letters :
       {"\u00df\u011b", "\u4e00\u0e1b", "\U0001f41b", "\u05d0\u200f", "\xff", ""})
    EXPECT_EQ(printable(letters), letters);
  EXPECT_EQ(printable_lines("a\tb\nc\r"), "a\tb\nc\\x0d");
  EXPECT_EQ(printable_json("\"\x7f\xc2\x9b\xe2\x80\xae\""), "\"\\u007f\\u009b\\u202e\"");
  EXPECT_TRUE(has_control_character("a\x9b"));
  EXPECT_FALSE(has_control_character("\u011b\u202e\U0001f41b"));
}

}  // namespace
}  // namespace selvedge::core_test
