// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/detail/block_jacobi.h>

#include <Eigen/LU>

namespace selvedge::detail {
namespace {

constexpr std::size_t kBlockGrain = 2048;

}  // namespace

void BlockJacobi::set(const BlockMatrix& a, const TermOperator& terms, std::span<const char> free) {
  inverse_.resize(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) inverse_[i] = a.diagonal(i);
  terms.add_diagonal(inverse_);
  for (std::size_t i = 0; i < a.size(); ++i)
    inverse_[i] = free[i] ? Mat3(inverse_[i].inverse()) : Mat3::Zero();
}

void BlockJacobi::apply(std::span<const Vec3> r, std::span<Vec3> z) const {
  parallel_for(r.size(), kBlockGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) z[i].noalias() = inverse_[i] * r[i];
  });
}

}  // namespace selvedge::detail
