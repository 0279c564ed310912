// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/integrator.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// The sum of all terms as an unassembled operator, T = Σ_t Σ_kl w_k w_l M_t at (particle_k,
/// particle_l). One pass goes over the terms, a second one over the particles, which gather their
/// terms in order, so the result does not depend on the number of threads.
class TermOperator {
 public:
  /// Keeps a view of `terms`, which must outlive its use. Throws std::invalid_argument for a
  /// particle >= n.
  void reset(std::span<const ImplicitTerm> terms, std::size_t particles);
  bool empty() const { return terms_.empty(); }

  /// y += T x.
  void add_multiply(std::span<const Vec3> x, std::span<Vec3> y);
  /// Diagonal blocks of T.
  void add_diagonal(std::span<Mat3> diagonal) const;
  /// y += rhs - T x.
  void add_residual(std::span<const Vec3> x, std::span<Vec3> y);
  std::span<const ImplicitTerm> terms() const { return terms_; }

 private:
  template <class Body>
  void for_each_sum(std::span<const Vec3> x, const Body& body) const;
  void add_moments(std::span<Vec3> y) const;

  struct Incidence {
    std::int32_t term, corner;
  };
  std::span<const ImplicitTerm> terms_;
  std::vector<std::int32_t> touched_;    // particles that occur in a term
  std::vector<std::int32_t> row_begin_;  // start of each touched particle in incidence_
  std::vector<Incidence> incidence_;
  std::vector<Vec3> moment_;         // M_t Σ_l w_l x_l, or the right-hand side less that
  std::vector<std::int32_t> count_;  // scratch per particle
};

}  // namespace selvedge::detail
