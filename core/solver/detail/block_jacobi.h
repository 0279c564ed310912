// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/force.h>
#include <selvedge/core/solver/detail/implicit_terms.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// The inverse of the diagonal blocks of A + T on the free particles, in double precision: a
/// preconditioner that is positive definite whatever the stiffnesses.
class BlockJacobi {
 public:
  /// `free[i]` is 0 for a held particle.
  void set(const BlockMatrix& a, const TermOperator& terms, std::span<const char> free);
  /// z = P r; z is zero at held particles.
  void apply(std::span<const Vec3> r, std::span<Vec3> z) const;

 private:
  std::vector<Mat3> inverse_;
};

}  // namespace selvedge::detail
