// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/integrator.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Calls body(i, weight) for each particle of the system that corner k of a term moves: itself or,
/// if it is one of `followers`, its leaders.
template <class Body>
void for_each_row(const ImplicitTerm& term, int k, const Followers* followers, const Body& body) {
  if (term.particle[k] < 0) return;
  if (followers == nullptr) return body(term.particle[k], term.weight[k]);
  for (const Followers::Share& s : followers->shares(term.particle[k]))
    body(s.leader, term.weight[k] * s.weight);
}

/// The sum of all terms as an unassembled operator, T = Σ_t Σ_kl w_k w_l M_t at (particle_k,
/// particle_l). One pass goes over the terms, a second one over the particles, which gather their
/// terms in order, so the result does not depend on the number of threads.
class TermOperator {
 public:
  /// Keeps a view of `terms`, which must outlive its use. Throws std::invalid_argument for a
  /// particle >= n.
  /// With `followers`, the terms name particles of these, and T acts on their leaders.
  void reset(std::span<const ImplicitTerm> terms, std::size_t particles,
             const Followers* followers = nullptr);
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

  struct Corner {
    std::int32_t particle;
    double weight;
  };
  struct Incidence {
    std::int32_t term;
    double weight;
  };
  std::span<const Corner> corners_of(std::size_t t) const {
    return std::span(corners_).subspan(corner_begin_[t], corner_begin_[t + 1] - corner_begin_[t]);
  }
  std::span<const ImplicitTerm> terms_;
  std::vector<Corner> corners_;            // of each term in turn
  std::vector<std::size_t> corner_begin_;  // start of each term in corners_
  std::vector<std::int32_t> touched_;      // particles that occur in a term
  std::vector<std::int32_t> row_begin_;    // start of each touched particle in incidence_
  std::vector<Incidence> incidence_;
  std::vector<Vec3> moment_;         // M_t Σ_l w_l x_l, or the right-hand side less that
  std::vector<std::int32_t> count_;  // scratch per particle
};

}  // namespace selvedge::detail
