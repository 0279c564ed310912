// SPDX-License-Identifier: MIT
// The matrix of a solve in single precision against the same matrix in double precision, and the
// multigrid cycle as a preconditioner: symmetric, positive, exact where one level suffices.
#include <gtest/gtest.h>
#include <selvedge/core/cloth/detail/even_grain.h>
#include <selvedge/core/cloth/detail/lane_matrix.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/solver/detail/aggregation.h>
#include <selvedge/core/solver/detail/implicit_terms.h>
#include <selvedge/core/solver/detail/multilevel.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace selvedge::lane_matrix_test {
namespace {

using namespace selvedge::detail;
using Vectors = std::vector<Vec3>;

/// Springs of a grid of `side` particles a side, its particles numbered row by row or shuffled.
BlockMatrix grid_matrix(std::int32_t side, bool shuffled, double stiffness) {
  std::mt19937 random(3);
  const std::size_t n = static_cast<std::size_t>(side) * side;
  std::vector<std::int32_t> to(n);
  std::iota(to.begin(), to.end(), 0);
  if (shuffled) std::shuffle(to.begin(), to.end(), random);
  std::vector<Edge> links;
  for (std::int32_t y = 0; y < side; ++y)
    for (std::int32_t x = 0; x < side; ++x)
      for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {2, 0}, {0, 2}})
        if (x + dx >= 0 && x + dx < side && y + dy < side)
          links.push_back({to[y * side + x], to[(y + dy) * side + x + dx]});
  BlockMatrix a(n, links);
  a.set_zero();
  std::uniform_real_distribution<double> some(-1.0, 1.0);
  for (std::size_t i = 0; i < n; ++i) a.diagonal(i) = (1.0 + 0.2 * some(random)) * Mat3::Identity();
  for (const auto& [i, j] : links) {
    const Vec3 d = Vec3::NullaryExpr([&] { return some(random); }).normalized();
    const Mat3 block = stiffness * (0.1 * Mat3::Identity() + d * d.transpose());
    a.diagonal(i) += block;
    a.diagonal(j) += block;
    a.values()[a.slot(i, j)] -= block;
    a.values()[a.slot(j, i)] -= block;
  }
  return a;
}

Vectors some_vectors(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> some(-1.0, 1.0);
  Vectors x(n);
  for (Vec3& v : x) v = Vec3::NullaryExpr([&] { return some(random); });
  return x;
}

LaneVector lanes_of(const Vectors& x) {
  LaneVector out;
  out.resize(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) out.set(i, x[i]);
  return out;
}

double dot_of(const LaneVector& a, const LaneVector& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

void expect_near(const LaneVector& a, const Vectors& b, double tolerance) {
  for (std::size_t i = 0; i < b.size(); ++i)
    for (int k = 0; k < 3; ++k) ASSERT_NEAR(a[i][k], b[i][k], tolerance) << i;
}

/// Contacts: with a body, along an edge of the grid, and between distant particles.
std::vector<ImplicitTerm> some_terms(std::int32_t side) {
  const Vec3 normal = Vec3(1, 2, 3).normalized();
  const Mat3 matrix = 50.0 * normal * normal.transpose();
  const std::int32_t last = side * side - 1;
  std::vector<ImplicitTerm> terms;
  for (const auto& [particle, weight] :
       {std::pair<std::array<std::int32_t, 4>, std::array<double, 4>>{{-1, 5, -1, -1},
                                                                      {-1, 1, 0, 0}},
        {{3, 4, -1, -1}, {0.4, 0.6, -0.5, -0.5}},
        {{2, last, last - 1, 1}, {1, -0.2, -0.3, -0.5}},
        {{2, last, last - 2, 0}, {1, -0.2, -0.3, -0.5}}}) {
    ImplicitTerm term;
    for (int k = 0; k < 4; ++k) {
      term.particle[k] = particle[k];
      term.weight[k] = weight[k];
    }
    term.matrix = matrix;
    term.rhs = Vec3::Zero();
    terms.push_back(term);
  }
  return terms;
}

struct Case {
  std::int32_t side;
  bool shuffled;
};

class LaneMatrixOf : public ::testing::TestWithParam<Case> {};

TEST_P(LaneMatrixOf, MultipliesAsDoublePrecisionDoes) {
  const auto [side, shuffled] = GetParam();
  const BlockMatrix a = grid_matrix(side, shuffled, 40.0);
  Multilevel multilevel;
  std::vector<char> free(a.size(), 1);
  free[1] = 0;
  multilevel.set_matrix(a, free);
  const std::vector<ImplicitTerm> terms = some_terms(side);
  Vectors x = some_vectors(a.size(), 5);
  x[1].setZero();
  for (const std::span<const ImplicitTerm> of : {std::span(terms), std::span(terms).first(0)}) {
    multilevel.set_terms(of);
    TermOperator reference;
    reference.reset(of, a.size());
    Vectors expected(a.size());
    a.multiply(x, expected);
    if (!reference.empty()) reference.add_multiply(x, expected);
    expected[1].setZero();
    const LaneVector lanes = lanes_of(x);
    LaneVector y = lanes;
    const double product = multilevel.multiply(lanes, y);
    expect_near(y, expected, 1e-3);
    EXPECT_NEAR(product, dot_of(lanes, y), 1e-6 * std::abs(product));
  }
}

TEST_P(LaneMatrixOf, PreconditionsSymmetricallyAndPositively) {
  const auto [side, shuffled] = GetParam();
  const BlockMatrix a = grid_matrix(side, shuffled, 1000.0);
  Multilevel multilevel;
  std::vector<char> free(a.size(), 1);
  free[0] = 0;
  multilevel.set_matrix(a, free);
  const std::vector<ImplicitTerm> terms = some_terms(side);
  multilevel.set_terms(terms);
  for (unsigned seed = 1; seed < 6; ++seed) {
    Vectors x = some_vectors(a.size(), seed), y = some_vectors(a.size(), seed + 10);
    x[0].setZero();
    y[0].setZero();
    const LaneVector p = lanes_of(x), q = lanes_of(y);
    LaneVector pp = p, pq = q;
    multilevel.apply(p, pp);
    multilevel.apply(q, pq);
    EXPECT_GT(dot_of(p, pp), 0.0);
    const double size = std::sqrt(dot_of(p, pp) * dot_of(q, pq));
    EXPECT_NEAR(dot_of(p, pq), dot_of(pp, q), 1e-5 * size);
    EXPECT_EQ(pp[0], Vec3::Zero());
  }
}

/// `chains` chains of n particles each, with springs of this stiffness between neighbours.
BlockMatrix chain_matrix(std::int32_t chains, std::int32_t n, double stiffness) {
  std::vector<Edge> links;
  for (std::int32_t i = 1; i < chains * n; ++i)
    if (i % n != 0) links.push_back({i - 1, i});
  BlockMatrix a(static_cast<std::size_t>(chains * n), links);
  a.set_zero();
  for (std::size_t i = 0; i < a.size(); ++i) a.diagonal(i) = Mat3::Identity();
  const Mat3 block = stiffness * Mat3::Identity();
  for (const auto& [i, j] : links) {
    a.diagonal(i) += block;
    a.diagonal(j) += block;
    a.values()[a.slot(i, j)] -= block;
    a.values()[a.slot(j, i)] -= block;
  }
  return a;
}

/// The energy that is left of `x` after one cycle, as a share of its energy.
double energy_left(const BlockMatrix& a, std::span<const ImplicitTerm> terms, const Vectors& x) {
  const std::vector<char> free(a.size(), 1);
  Multilevel multilevel;
  multilevel.set_matrix(a, free);
  multilevel.set_terms(terms);
  TermOperator with_terms;
  with_terms.reset(terms, a.size());
  const auto force_of = [&](const Vectors& of) {
    Vectors force(of.size());
    a.multiply(of, force);
    if (!with_terms.empty()) with_terms.add_multiply(of, force);
    return force;
  };
  const Vectors force = force_of(x);
  const LaneVector r = lanes_of(force);
  LaneVector z = r;
  multilevel.apply(r, z);
  Vectors left(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) left[i] = x[i] - z[i];
  const Vectors of_left = force_of(left);
  double before = 0.0, after = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    before += x[i].dot(force[i]);
    after += left[i].dot(of_left[i]);
  }
  return after / before;
}

/// Long waves that all chains of n particles share.
Vectors waves(std::int32_t chains, std::int32_t n) {
  Vectors x;
  for (std::int32_t i = 0; i < chains * n; ++i)
    x.emplace_back(std::sin(0.02 * (i % n)), std::cos(0.05 * (i % n)), std::sin(0.1 * (i % n)));
  return x;
}

// A chain of 3000 particles has five levels. Of long waves, a cycle leaves 9 % of the energy if it
// visits each level once.
TEST(LaneMatrix, ReducesLongWavesOverManyLevels) {
  EXPECT_LT(energy_left(chain_matrix(1, 3000, 1e6), {}, waves(1, 3000)), 0.01);
}

// Contacts between two chains do not resist waves that both share. If a coarse level replaced them
// by their bound on the diagonal, as if they held the particles in place, the cycle would amplify
// the energy of these waves by 10⁸.
TEST(LaneMatrix, ContactsOfDistantParticlesHoldNoParticleInPlace) {
  const std::int32_t n = 2000;
  std::vector<ImplicitTerm> contacts;
  for (std::int32_t i = 0; i < n; i += 3) {
    ImplicitTerm& term = contacts.emplace_back();
    term.particle = {i, n + i, -1, -1};
    term.weight = {1.0, -1.0, 0.0, 0.0};
    term.matrix = 1e5 * Mat3::Identity();
    term.rhs = Vec3::Zero();
  }
  EXPECT_LT(energy_left(chain_matrix(2, n, 1e6), contacts, waves(2, n)), 0.2);
}

TEST_P(LaneMatrixOf, IsTheSameAfterTermsHaveComeAndGone) {
  const auto [side, shuffled] = GetParam();
  const BlockMatrix a = grid_matrix(side, shuffled, 100.0);
  const std::vector<char> free(a.size(), 1);
  const std::vector<ImplicitTerm> terms = some_terms(side);
  const LaneVector r = lanes_of(some_vectors(a.size(), 8));
  LaneVector before = r, after = r;
  Multilevel multilevel;
  multilevel.set_matrix(a, free);
  multilevel.set_terms({});
  multilevel.apply(r, before);
  multilevel.set_terms(terms);
  multilevel.apply(r, after);
  EXPECT_NE(before[5], after[5]);
  multilevel.set_terms({});
  multilevel.apply(r, after);
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(before[i], after[i]) << i;
}

/// Contacts between random particles.
std::vector<ImplicitTerm> random_terms(std::size_t particles, std::size_t count) {
  std::mt19937 random(7);
  std::uniform_int_distribution<std::int32_t> any(0, static_cast<std::int32_t>(particles) - 5);
  std::vector<ImplicitTerm> terms(count);
  for (ImplicitTerm& term : terms) {
    const std::int32_t first = any(random);
    term.particle = {first, first + 1, first + 2, first + 4};
    term.weight = {1.0, -0.2, -0.3, -0.5};
    term.rhs = Vec3::Zero();
    const Vec3 normal = Vec3::NullaryExpr([&] { return any(random) - 0.5 * particles; });
    term.matrix = 20.0 / normal.squaredNorm() * normal * normal.transpose();
  }
  return terms;
}

// Hundreds of terms are taken in ranges. A range that is no longer needed must not leave a trace.
TEST_P(LaneMatrixOf, KnowsItsTermsWhateverTheirNumberWasBefore) {
  const auto [side, shuffled] = GetParam();
  const BlockMatrix a = grid_matrix(side, shuffled, 40.0);
  const std::vector<char> free(a.size(), 1);
  const std::vector<ImplicitTerm> all = random_terms(a.size(), 700);
  const Vectors x = some_vectors(a.size(), 5);
  const LaneVector lanes = lanes_of(x);
  Multilevel multilevel;
  multilevel.set_matrix(a, free);
  for (const std::size_t count : {700, 10, 300, 0, 513}) {
    const auto terms = std::span(all).first(count);
    multilevel.set_terms(terms);
    TermOperator reference;
    reference.reset(terms, a.size());
    Vectors expected(a.size());
    a.multiply(x, expected);
    if (!reference.empty()) reference.add_multiply(x, expected);
    LaneVector y = lanes, z = lanes;
    multilevel.multiply(lanes, y);
    expect_near(y, expected, 1e-2);
    Multilevel fresh;
    fresh.set_matrix(a, free);
    fresh.set_terms(terms);
    multilevel.apply(lanes, y);
    fresh.apply(lanes, z);
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(y[i], z[i]) << count << " terms, " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Grids, LaneMatrixOf,
                         ::testing::Values(Case{5, false}, Case{16, false}, Case{37, false},
                                           Case{37, true}));

TEST(EvenGrain, DividesIntoAPowerOfTwoOfRangesThatAreLargeEnough) {
  for (std::size_t n = 0; n < 5000; ++n)
    for (const std::size_t least : {1u, 7u, 64u, 1024u}) {
      const std::size_t grain = detail::even_grain(n, least);
      ASSERT_GE(grain, 1u);
      ASSERT_TRUE(grain >= least || grain >= n) << n << ", " << least;
      const std::size_t ranges = (n + grain - 1) / grain;
      ASSERT_LE(ranges, std::bit_ceil(std::max<std::size_t>(n / least, 1)));
      // As many as the largest power of two allows, unless rounding up the grain saves the last.
      ASSERT_GE(2 * ranges, std::bit_floor(n / least)) << n << ", " << least;
    }
  EXPECT_EQ(detail::even_grain(2500, 1024), 1250u);
  EXPECT_EQ(detail::even_grain(313, 64), 79u);
  EXPECT_EQ(detail::even_grain(100, 1024), 100u);
}

TEST(LaneMatrix, EveryWidthGivesTheSameBits) {
  for (const bool shuffled : {false, true}) {
    const BlockMatrix a = grid_matrix(19, shuffled, 30.0);
    LaneMatrix matrix;
    matrix.set_pattern(a.row_begin(), a.columns());
    for (std::size_t k = 0; k < a.values().size(); ++k) matrix.set(k, a.values()[k]);
    const LaneVector x = lanes_of(some_vectors(a.size(), 1)),
                     b = lanes_of(some_vectors(a.size(), 2));
    std::vector<float> step(kStepNumbers * x.groups());
    for (std::size_t i = 0; i < a.size(); ++i) set_step(step, i, a.diagonal(i));
    const LaneRows rows = matrix.rows(step);
    const Vectors p = some_vectors(a.size(), 3);
    struct Results {
      LaneVector product, relaxed, started, stepped, reduced, scaled;
      std::vector<Point4> residual;
      double dot, xy, by;
      Vectors blocks;
    };
    std::vector<Results> all;
    for (const LaneMatrixKernel& kernel : lane_matrix_kernels()) {
      Results out{
          x, x, x, x, x, x, std::vector<Point4>(8 * x.groups()), 0.0, 0.0, 0.0, Vectors(a.size())};
      const std::size_t groups = x.groups();
      out.xy = kernel.multiply(rows, x.data(), b.data(), out.product.data(), 0, groups);
      out.by = kernel.relax(rows, b.data(), x.data(), nullptr, out.relaxed.data(), 0, groups);
      kernel.start(rows, b.data(), out.started.data(), 0, groups);
      kernel.residual(rows, b.data(), x.data(), nullptr, out.residual.data(), 0, groups);
      out.dot = kernel.dot(x.data(), b.data(), 0, 3 * groups);
      kernel.add_step(0.3f, {b.data(), out.product.data(), out.stepped.data(), out.reduced.data()},
                      0, 3 * groups);
      kernel.add_to_scaled(0.3f, b.data(), out.scaled.data(), 0, 3 * groups);
      kernel.multiply_blocks(a.row_begin().data(), a.columns().data(), a.values()[0].data(),
                             p[0].data(), out.blocks[0].data(), 0, a.size());
      all.push_back(std::move(out));
    }
    for (const Results& r : all) {
      EXPECT_EQ(r.dot, all[0].dot);
      EXPECT_EQ(r.xy, all[0].xy);
      EXPECT_EQ(r.by, all[0].by);
      EXPECT_NEAR(r.by, dot_of(b, r.relaxed), 1e-6 * std::abs(r.by));
      for (std::size_t i = 0; i < a.size(); ++i) {
        ASSERT_EQ(r.product[i], all[0].product[i]);
        ASSERT_EQ(r.relaxed[i], all[0].relaxed[i]);
        ASSERT_EQ(r.started[i], all[0].started[i]);
        ASSERT_EQ(r.stepped[i], all[0].stepped[i]);
        ASSERT_EQ(r.reduced[i], all[0].reduced[i]);
        ASSERT_NEAR((r.stepped[i] - (x[i] + 0.3 * b[i])).norm(), 0.0, 1e-6);
        ASSERT_NEAR((r.reduced[i] - (x[i] - 0.3 * r.product[i])).norm(), 0.0,
                    1e-6 * (1.0 + r.product[i].norm()));
        ASSERT_EQ(r.scaled[i], all[0].scaled[i]);
        ASSERT_EQ(r.blocks[i], all[0].blocks[i]);
        for (int k = 0; k < 3; ++k) ASSERT_EQ(r.residual[i].at[k], all[0].residual[i].at[k]);
      }
    }
  }
}

TEST(LaneMatrix, CarriesPointsBetweenLevelsAsScalarsDo) {
  const BlockMatrix a = grid_matrix(21, true, 1.0);
  const Prolongation p = make_prolongation(a.row_begin(), a.columns());
  LaneParents parents;
  parents.set_pattern(p.begin, p.parent);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::int32_t e = p.begin[i]; e < p.begin[i + 1]; ++e)
      parents.set_weight(i, e - p.begin[i], static_cast<float>(p.weight[e]));
  std::vector<float> by_child;
  for (const std::int32_t e : p.child_entry) by_child.push_back(static_cast<float>(p.weight[e]));
  const Vectors coarse = some_vectors(p.parents(), 6), r = some_vectors(a.size(), 7);
  const auto points = [](const Vectors& x) {
    std::vector<Point4> out(x.size());
    for (std::size_t i = 0; i < x.size(); ++i)
      for (int k = 0; k < 3; ++k) out[i].at[k] = static_cast<float>(x[i][k]);
    return out;
  };
  Vectors expected = some_vectors(a.size(), 8), restricted(p.parents(), Vec3::Zero());
  const LaneVector start = lanes_of(expected);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::int32_t e = p.begin[i]; e < p.begin[i + 1]; ++e) {
      expected[i] += p.weight[e] * coarse[p.parent[e]];
      restricted[p.parent[e]] += p.weight[e] * r[i];
    }
  for (const LaneMatrixKernel& kernel : lane_matrix_kernels()) {
    LaneVector x = start, b;
    b.resize(p.parents());
    kernel.prolong(LaneParentRows(parents), points(coarse).data(), x.data(), x.stride(), 0,
                   x.groups());
    kernel.restrict_to(p.child_begin.data(), p.child.data(), by_child.data(), points(r).data(),
                       b.data(), b.stride(), 0, b.size());
    expect_near(x, expected, 1e-6);
    expect_near(b, restricted, 1e-5);
  }
}

TEST(LaneMatrix, TheCoarseMatrixIsTheProductOfTheLevels) {
  const BlockMatrix a = grid_matrix(17, false, 5.0);
  const Prolongation p = make_prolongation(a.row_begin(), a.columns());
  std::vector<char> free(a.size(), 1);
  free[3] = 0;
  BlockRows coarse;
  GalerkinProduct product;
  product.set_pattern(a.row_begin(), a.columns(), p, coarse);
  product.compute(a.values(), p, free, coarse);
  const auto n = static_cast<Eigen::Index>(a.size()), m = static_cast<Eigen::Index>(p.parents());
  Eigen::MatrixXd weight = Eigen::MatrixXd::Zero(n, m), expected(3 * m, 3 * m);
  for (Eigen::Index i = 0; i < n; ++i)
    for (std::int32_t e = p.begin[i]; e < p.begin[i + 1]; ++e)
      weight(i, p.parent[e]) = free[i] ? p.weight[e] : 0.0;
  expected.setZero();
  for (Eigen::Index i = 0; i < n; ++i)
    for (std::int32_t k = a.row_begin()[i]; k < a.row_begin()[i + 1]; ++k)
      for (Eigen::Index c = 0; c < m; ++c)
        for (Eigen::Index d = 0; d < m; ++d)
          expected.block<3, 3>(3 * c, 3 * d) +=
              weight(i, c) * weight(a.columns()[k], d) * a.values()[k];
  for (Eigen::Index c = 0; c < m; ++c)
    for (std::int32_t q = coarse.begin[c]; q < coarse.begin[c + 1]; ++q) {
      const auto block = expected.block<3, 3>(3 * c, 3 * coarse.column[q]);
      ASSERT_LT((coarse.value[q] - block).norm(), 1e-5 * expected.norm()) << c << ' ' << q;
      expected.block<3, 3>(3 * c, 3 * coarse.column[q]).setZero();
    }
  EXPECT_LT(expected.norm(), 1e-12);
}

TEST(LaneMatrix, MultipliesBlocksInDoublePrecision) {
  const BlockMatrix a = grid_matrix(9, true, 2.0);
  const Vectors x = some_vectors(a.size(), 1);
  Vectors y(a.size());
  a.multiply(x, y);
  for (std::size_t i = 0; i < a.size(); ++i) {
    Vec3 sum = Vec3::Zero();
    for (std::int32_t k = a.row_begin()[i]; k < a.row_begin()[i + 1]; ++k)
      sum += a.values()[k] * x[a.columns()[k]];
    ASSERT_NEAR((y[i] - sum).norm(), 0.0, 1e-14);
  }
}

TEST(LaneMatrix, GridsNeedNoGather) {
  const BlockMatrix grid = grid_matrix(40, false, 1.0), shuffled = grid_matrix(40, true, 1.0);
  LaneMatrix a, b;
  a.set_pattern(grid.row_begin(), grid.columns());
  b.set_pattern(shuffled.row_begin(), shuffled.columns());
  EXPECT_LT(static_cast<double>(a.bytes()),
            1.15 * 36.0 * static_cast<double>(grid.values().size()));
  EXPECT_GT(b.bytes(), a.bytes());
}

TEST(Multilevel, ConjugateGradientsReachTheSolutionInFewIterations) {
  const BlockMatrix a = grid_matrix(40, false, 1e4);
  const std::vector<char> free(a.size(), 1);
  Multilevel multilevel;
  multilevel.set_matrix(a, free);
  multilevel.set_terms({});
  const Vectors solution = some_vectors(a.size(), 4);
  Vectors b(a.size());
  a.multiply(solution, b);
  LaneVector r = lanes_of(b), z = r, ap = r, x = r;
  x.set_zero();
  double rz = multilevel.apply(r, z);
  LaneVector p = z;
  const double first = rz;
  int iterations = 0;
  for (; iterations < 40 && rz > 1e-8 * first; ++iterations) {
    const double pap = multilevel.multiply(p, ap);
    add_step(static_cast<float>(rz / pap), p, ap, x, r);
    const double next = multilevel.apply(r, z);
    scale_and_add(static_cast<float>(next / rz), z, p);
    rz = next;
  }
  EXPECT_LE(iterations, 25);
  expect_near(x, solution, 1e-2);
}

}  // namespace

}  // namespace selvedge::lane_matrix_test
