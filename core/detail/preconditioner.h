// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/block_matrix.h>
#include <selvedge/core/detail/implicit_terms.h>

#include <memory>
#include <span>

namespace selvedge::detail {

/// A symmetric positive definite approximation P of (A + T)⁻¹ on the free particles.
class Preconditioner {
 public:
  virtual ~Preconditioner() = default;
  /// Call when A has new values. `free[i]` is 0 for a held particle.
  virtual void set_matrix(const BlockMatrix& a, std::span<const char> free) = 0;
  /// Call when T has new values.
  virtual void set_terms(TermOperator& terms) = 0;
  /// z = P r. r must be zero at held particles; z is zero there too.
  virtual void apply(std::span<const Vec3> r, std::span<Vec3> z) = 0;
};

/// Block Jacobi: the inverse of the diagonal blocks.
std::unique_ptr<Preconditioner> make_block_jacobi();
/// One multigrid V-cycle over a hierarchy of aggregates of particles.
std::unique_ptr<Preconditioner> make_multilevel();

}  // namespace selvedge::detail
