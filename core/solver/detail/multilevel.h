// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/detail/lane_matrix.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/solver/detail/aggregation.h>
#include <selvedge/core/solver/integrator.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace selvedge::detail {

/// The matrix A + T of a solve in single precision, and one multigrid cycle over a hierarchy of
/// aggregates of particles as a preconditioner P of it. The cycle visits levels that are too large
/// to be factored twice (a W-cycle). Rows of held particles are those of the identity.
///
/// Aggregation of the coupling graph: P. Vaněk, J. Mandel, M. Brezina, "Algebraic multigrid by
/// smoothed aggregation for second and fourth order elliptic problems", Computing 1996. Deviation:
/// the piecewise constant prolongation is smoothed with the graph Laplacian instead of the matrix.
/// Its weights are scalars, equal for x, y and z, and do not depend on the positions. Weights and
/// patterns are computed once. The products of the levels are computed once per step; the terms of
/// each solve are added on every level.
class Multilevel {
 public:
  Multilevel();
  ~Multilevel();
  /// Call when A has new values. The arguments are viewed until the next call. `free[i]` is 0 for
  /// a held particle. `x`: positions of the particles, m; with them the cycle turns with the cloth.
  /// Empty: unknown.
  void set_matrix(const BlockMatrix& a, std::span<const char> free, std::span<const Vec3> x = {});
  /// Call when T has new values. The terms are viewed until the next call. `followers` as in
  /// TermOperator::reset.
  void set_terms(std::span<const ImplicitTerm> terms, const Followers* followers = nullptr);
  /// y = (A + T) x; returns x·y. x must be zero at held particles; y is zero there too.
  double multiply(const LaneVector& x, LaneVector& y);
  /// z = P r; returns r·z. r must be zero at held particles; z is zero there too.
  double apply(const LaneVector& r, LaneVector& z);
  /// Bytes that one multiplication and one cycle read and write.
  std::size_t multiply_bytes() const;
  std::size_t cycle_bytes() const;

 private:
  /// The terms as one level sees them: term t couples the rows (row, weight) from begin[t] on, in
  /// ascending order of the rows.
  struct LevelTerms {
    std::vector<std::size_t> begin;
    std::vector<std::pair<std::int32_t, double>> rows;
    void clear();
    void begin_term() { begin.push_back(rows.size()); }
    void add(std::int32_t row, double weight);
    /// Ends the term that was begun last.
    void sort();
    std::span<const std::pair<std::int32_t, double>> of(std::size_t t) const {
      return std::span(rows).subspan(begin[t], begin[t + 1] - begin[t]);
    }
  };
  /// The terms of a level that couple rows without a common block: applied after the matrix.
  struct LooseTerms {
    struct Entry {
      std::int32_t row;
      std::uint32_t term;  // position in `term`
      float weight;
    };
    std::vector<std::uint32_t> term;
    std::vector<std::array<float, 9>> matrix;
    std::vector<Entry> entries;  // by row
    std::vector<std::uint32_t> row_begin;
    std::vector<Point4> moment;
    LaneVector product;  // (these terms) x
    bool empty() const { return term.empty(); }
  };
  struct Level {
    BlockRows own;  // pattern and values without terms; empty in the first level, which views A
    std::span<const std::int32_t> begin, column;
    std::span<const Mat3> value;
    std::vector<std::int32_t> diagonal;
    std::vector<std::int32_t> particle;  // of each row: itself, or one of those that it stands for
    Prolongation p;                      // to the next level
    LaneParents parents;                 // of the rows, with the weights of p
    std::vector<float> restriction;      // weights of p by parent
    GalerkinProduct product;
    LaneMatrix matrix;
    double lambda = 1.0;                 // largest eigenvalue of D⁻¹A
    std::vector<float> base_step, step;  // S without and with terms
    std::vector<std::int32_t> touched;   // rows with terms
    std::vector<Mat3> bound;             // of the diagonal of their terms
    std::vector<std::int32_t> place;     // per row: its place in `touched`; -1: none
    std::vector<std::size_t> changed;    // blocks with terms
    std::vector<char> is_changed;        // per block
    std::vector<std::int64_t> between;   // scratch: blocks between the rows of a term, -1 for none
    LevelTerms terms;
    LooseTerms loose;
    LaneVector b, x, y;
    LaneVector rest, change;  // of the second visit; empty if there is only one
    std::vector<Point4> points;
    std::size_t size() const { return begin.empty() ? 0 : begin.size() - 1; }
  };
  void build(const BlockMatrix& a);
  bool add_level();
  void set_pattern(Level& level);
  bool is_last(const Level& level) const { return &level == &levels_.back(); }
  bool is_held(const Level& level, std::int32_t row) const {
    return &level == &levels_.front() && !free_[row];
  }
  void set_weights(Level& level);
  void set_values(Level& level);
  void set_smoother(Level& level);
  void set_start(const Level& level, LaneVector& out) const;
  double largest_eigenvalue(Level& level) const;
  void find_rows(std::span<const ImplicitTerm> terms, const Followers* followers);
  void join_rows(std::size_t l);
  void set_fine_rows(std::span<const ImplicitTerm> terms, const Followers* followers,
                     LevelTerms& out) const;
  static void set_coarse_rows(const LevelTerms& fine, const Prolongation& p, LevelTerms& out);
  void clear_terms(Level& level);
  void set_level_terms(Level& level, std::span<const ImplicitTerm> terms);
  void add_term(Level& level, std::size_t t, const Mat3& matrix);
  static std::int64_t find_block(const Level& level, std::int32_t i, std::int32_t j);
  static void set_loose(Level& level, std::span<const ImplicitTerm> terms);
  /// Data of T x for the loose terms, or null if there are none.
  static const float* extra(Level& level, const LaneVector& x);
  void factor_last(std::span<const ImplicitTerm> terms);
  /// As apply(), on level l.
  double cycle(std::size_t l, const LaneVector& b, LaneVector& z);
  void solve_coarse(std::size_t l);
  int visits(std::size_t l) const;
  void solve_last(const LaneVector& b, LaneVector& z);
  /// True if the last level is small enough for a factorisation; isolated particles do not
  /// aggregate.
  bool dense() const;

  std::span<const char> free_;
  std::span<const Vec3> x_;     // m
  std::vector<char> weighted_;  // free_ as the weights of the first level know it
  std::vector<Level> levels_;
  std::vector<std::vector<LevelTerms>> rows_of_terms_;  // scratch: per range of terms and level
  struct Factor;
  std::unique_ptr<Factor> factor_;  // of the last level
};

}  // namespace selvedge::detail
