// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/core/solver/detail/dense_cholesky.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace selvedge::detail {
namespace {

/// Numbers in [-1, 1) that are the same everywhere.
class Numbers {
 public:
  double operator()() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) * 0x1p-52 - 1.0;
  }

 private:
  std::uint64_t state_ = 1;
};

/// B Bᵀ + n/2, by rows.
std::vector<double> positive_definite(std::size_t n, Numbers& number) {
  std::vector<double> b(n * n), a(n * n, 0.0);
  for (double& x : b) x = number();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k < n; ++k) a[n * i + j] += b[n * i + k] * b[n * j + k];
    a[n * i + i] += 0.5 * static_cast<double>(n);
  }
  return a;
}

void set(DenseCholesky& matrix, std::size_t n, const std::vector<double>& a) {
  matrix.set_zero(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) matrix(i, j) = a[n * i + j];
}

TEST(DenseCholesky, SolvesSystemsOfEverySize) {
  Numbers number;
  DenseCholesky matrix;
  for (const std::size_t n : {1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 15, 33, 100}) {
    const std::vector<double> a = positive_definite(n, number);
    std::vector<double> x(n), b(n, 0.0);
    for (double& v : x) v = number();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) b[i] += a[n * i + j] * x[j];
    set(matrix, n, a);
    matrix.factor();
    matrix.solve(b.data());
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(b[i], x[i], 1e-12) << n << " " << i;
  }
}

TEST(DenseCholesky, LeavesOutUnknownsWithoutAPositivePivot) {
  // unknowns 1 and 5 have no row of their own; the others are those of a diagonal matrix
  DenseCholesky matrix;
  matrix.set_zero(6);
  for (const std::size_t i : {0, 2, 3, 4}) matrix(i, i) = 4.0;
  matrix(5, 5) = -1.0;
  matrix.factor();
  std::vector<double> b{4.0, 7.0, 8.0, 12.0, 16.0, 3.0};
  matrix.solve(b.data());
  EXPECT_EQ(b, (std::vector<double>{1.0, 0.0, 2.0, 3.0, 4.0, 0.0}));
}

// Bits that every compiler, vector width and processor must give.
TEST(DenseCholesky, HasTheSameBitsEverywhere) {
  for (const CholeskyKernel kernel : cholesky_kernels()) {
    Numbers number;
    DenseCholesky matrix(kernel);
    std::uint64_t hash = 14695981039346656037u;
    for (const std::size_t n : {5, 24, 67}) {
      set(matrix, n, positive_definite(n, number));
      matrix.factor();
      std::vector<double> b(n);
      for (double& v : b) v = number();
      matrix.solve(b.data());
      for (const double v : b) hash = (hash ^ std::bit_cast<std::uint64_t>(v)) * 1099511628211u;
    }
    EXPECT_EQ(hash, 18119471919232012059u);
  }
}

}  // namespace
}  // namespace selvedge::detail
