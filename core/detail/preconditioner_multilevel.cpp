// SPDX-License-Identifier: MIT
//
// Multigrid by aggregation of the coupling graph: P. Vaněk, J. Mandel, M. Brezina, "Algebraic
// multigrid by smoothed aggregation for second and fourth order elliptic problems", Computing 1996.
// Deviation: the piecewise constant prolongation is smoothed with the graph Laplacian instead of
// the matrix. Its weights are scalars, equal for x, y and z, and do not depend on the positions.
// Weights and patterns are computed once; a new matrix only costs the products.
#include <selvedge/core/detail/aggregation.h>
#include <selvedge/core/detail/preconditioner.h>
#include <selvedge/core/parallel.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace selvedge::detail {
namespace {

constexpr std::size_t kLevelGrain = 1024;
// Factoring 3·96 dense unknowns costs about 8 Mflop, less than another level.
constexpr std::size_t kCoarsestSize = 96;
// A level that is larger than this fraction of its parent level is not worth its cost.
constexpr double kLeastCoarsening = 0.75;
// The smoother x += ω/λ D⁻¹ r keeps the cycle positive definite for ω/λ < 2/λmax(D⁻¹A). Power
// iterations approach λmax from below, to about 20 % after ten; ω = 1.5 leaves a margin of a third.
constexpr double kSmootherStep = 1.5;
constexpr int kPowerIterations = 10;

/// Four lanes of single precision; a 3-vector uses three of them.
using Lanes = Eigen::Array4f;

/// A matrix in single precision, which suffices for the smoother and halves the memory traffic.
class SmootherMatrix {
 public:
  void resize(std::size_t rows, std::size_t blocks) {
    x_.resize(rows);
    // The last column of a block is loaded together with the next float, so the last block needs
    // one more.
    value_.assign(9 * blocks + 1, 0.0f);
  }

  void set(std::span<const Mat3> values) {
    parallel_for(values.size(), 16 * kLevelGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k)
        Eigen::Map<Eigen::Matrix3f>(value_.data() + 9 * k) = values[k].cast<float>();
    });
  }

  /// y = A x with the pattern of `a`.
  void multiply(const BlockMatrix& a, std::span<const Vec3> x, std::span<Vec3> y) {
    parallel_for(x.size(), kLevelGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i)
        x_[i] = Lanes(static_cast<float>(x[i].x()), static_cast<float>(x[i].y()),
                      static_cast<float>(x[i].z()), 0.0f);
    });
    const auto begin = a.row_begin(), column = a.columns();
    parallel_for(y.size(), kLevelGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        Lanes sum = Lanes::Zero();
        for (std::int32_t k = begin[i]; k < begin[i + 1]; ++k) {
          const float* m = value_.data() + 9 * static_cast<std::size_t>(k);  // column-major
          const Lanes& p = x_[column[k]];
          sum += Eigen::Map<const Lanes>(m) * p[0] + Eigen::Map<const Lanes>(m + 3) * p[1] +
                 Eigen::Map<const Lanes>(m + 6) * p[2];
        }
        y[i] = Vec3(sum[0], sum[1], sum[2]);
      }
    });
  }

 private:
  std::vector<Lanes> x_;
  std::vector<float> value_;
};

/// y = A x.
void multiply(const BlockRows& a, std::span<const Vec3> x, std::span<Vec3> y) {
  parallel_for(y.size(), kLevelGrain / 8, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      Vec3 sum = Vec3::Zero();
      for (std::int32_t k = a.begin[i]; k < a.begin[i + 1]; ++k)
        sum.noalias() += a.value[k] * x[a.column[k]];
      y[i] = sum;
    }
  });
}

/// One level of the cycle: the smoother's blocks ω/λ D⁻¹ and vectors.
struct Smoother {
  std::vector<Mat3> step;
  std::vector<Vec3> scratch;

  /// x = S b.
  void start(std::span<const Vec3> b, std::span<Vec3> x) const {
    parallel_for(x.size(), kLevelGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) x[i].noalias() = step[i] * b[i];
    });
  }
  /// x += S (b - ax).
  void correct(std::span<const Vec3> b, std::span<const Vec3> ax, std::span<Vec3> x) const {
    parallel_for(x.size(), kLevelGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) x[i] += step[i] * (b[i] - ax[i]);
    });
  }
};

/// r = b - r, and 0 at held particles.
void subtract_from(std::span<const Vec3> b, std::span<const char> free, std::span<Vec3> r) {
  parallel_for(r.size(), kLevelGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      r[i] = free.empty() || free[i] ? Vec3(b[i] - r[i]) : Vec3::Zero();
  });
}

/// Lower estimate of the largest eigenvalue of D⁻¹A, by power iterations from a fixed start.
template <class Multiply>
double largest_eigenvalue(std::span<const Mat3> inverse, Multiply&& multiply, std::span<Vec3> x,
                          std::span<Vec3> y) {
  // A linear congruential generator gives a start without symmetries.
  std::uint32_t state = 12345;
  for (Vec3& v : x)
    for (int k = 0; k < 3; ++k) {
      state = state * 1664525u + 1013904223u;
      v[k] = state / 4294967296.0 - 0.5;
    }
  double ratio = 0.0;
  for (int it = 0; it < kPowerIterations; ++it) {
    multiply(x, y);
    const double before = parallel_sum(x.size(), kLevelGrain, [&](std::size_t b, std::size_t e) {
      double sum = 0.0;
      for (std::size_t i = b; i < e; ++i) sum += x[i].squaredNorm();
      return sum;
    });
    const double after = parallel_sum(x.size(), kLevelGrain, [&](std::size_t b, std::size_t e) {
      double sum = 0.0;
      for (std::size_t i = b; i < e; ++i) {
        x[i].noalias() = inverse[i] * y[i];
        sum += x[i].squaredNorm();
      }
      return sum;
    });
    ratio = before > 0.0 ? std::sqrt(after / before) : 0.0;
  }
  // At least the mean eigenvalue, 1. This also handles matrices that are zero or NaN.
  return ratio > 1.0 ? ratio : 1.0;
}

/// A level coarser than the particles.
struct Level {
  BlockRows a;
  Prolongation p;  // to the next level; unused in the last level
  Smoother smoother;
  std::vector<Vec3> x, b;
};

class Multilevel final : public Preconditioner {
 public:
  void set_matrix(const BlockMatrix& a, std::span<const char> free) override {
    a_ = &a;
    free_ = free;
    if (levels_.empty()) build(a);
    fine_.set(a.values());
    products_[0].compute(a.row_begin(), a.columns(), a.values(), p_, free, levels_[0].a);
    base_ = levels_[0].a.value;
    estimate_fine();
  }

  void set_terms(TermOperator& terms) override {
    terms_ = &terms;
    set_fine_smoother();
    levels_[0].a.value = base_;
    for (const ImplicitTerm& term : terms.terms()) add_term(term);
    for (std::size_t l = 0; l < levels_.size(); ++l) set_level(l);
  }

  void apply(std::span<const Vec3> r, std::span<Vec3> z) override {
    const std::span<Vec3> scratch = smoother_.scratch;
    smoother_.start(r, z);
    multiply_fine(z, scratch);
    subtract_from(r, free_, scratch);
    restrict_to(p_, scratch, levels_[0].b);
    cycle(0);
    prolong_add(p_, levels_[0].x, free_, z);
    multiply_fine(z, scratch);
    smoother_.correct(r, scratch, z);
  }

 private:
  void build(const BlockMatrix& a) {
    fine_.resize(a.size(), a.values().size());
    inverse_.resize(a.size());
    smoother_.step.resize(a.size());
    smoother_.scratch.resize(a.size());
    p_ = make_prolongation(a.row_begin(), a.columns());
    levels_.emplace_back();
    products_.emplace_back().set_pattern(a.row_begin(), a.columns(), p_, levels_[0].a);
    while (levels_.back().a.size() > kCoarsestSize && add_level()) {
    }
    for (Level& level : levels_)
      for (auto* v : {&level.x, &level.b, &level.smoother.scratch}) v->resize(level.a.size());
  }

  bool add_level() {
    Level& level = levels_.back();
    Prolongation p = make_prolongation(level.a.begin, level.a.column);
    if (p.parents() > kLeastCoarsening * level.a.size()) return false;
    level.p = std::move(p);
    Level next;
    products_.emplace_back().set_pattern(level.a.begin, level.a.column, level.p, next.a);
    levels_.push_back(std::move(next));
    return true;
  }

  /// λ of the matrix without terms.
  void estimate_fine() {
    const std::size_t n = a_->size();
    parallel_for(n, kLevelGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i)
        inverse_[i] = free_[i] ? Mat3(a_->diagonal(i).inverse()) : Mat3::Zero();
    });
    power_.resize(n);
    lambda_ = largest_eigenvalue(
        inverse_,
        [&](std::span<const Vec3> from, std::span<Vec3> to) { fine_.multiply(*a_, from, to); },
        power_, smoother_.scratch);
  }

  /// S = ω (λ D + Σ_t n_t D_t)⁻¹: a term with n_t particles is at most n_t times its own diagonal
  /// blocks, so this bounds the matrix with terms of any size.
  void set_fine_smoother() {
    const std::size_t n = a_->size();
    if (terms_->empty()) {
      for (std::size_t i = 0; i < n; ++i)
        smoother_.step[i] = (kSmootherStep / lambda_) * inverse_[i];
      return;
    }
    std::vector<Mat3>& d = diagonal_;
    d.assign(n, Mat3::Zero());
    for (const ImplicitTerm& t : terms_->terms()) {
      const auto count = std::count_if(t.particle.begin(), t.particle.end(),
                                       [](std::int32_t p) { return p >= 0; });
      for (int k = 0; k < 4; ++k)
        if (t.particle[k] >= 0)
          d[t.particle[k]] += (static_cast<double>(count) * t.weight[k] * t.weight[k]) * t.matrix;
    }
    parallel_for(n, kLevelGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i)
        smoother_.step[i] = free_[i]
                                ? Mat3(kSmootherStep * (lambda_ * a_->diagonal(i) + d[i]).inverse())
                                : Mat3::Zero();
    });
  }

  /// Adds a term, with the weights of its particles transferred to their parents.
  void add_term(const ImplicitTerm& t) {
    parents_.clear();
    for (int k = 0; k < 4; ++k) {
      const std::int32_t i = t.particle[k];
      if (i < 0 || !free_[i]) continue;
      for (std::int32_t e = p_.begin[i]; e < p_.begin[i + 1]; ++e) {
        const auto found = std::find_if(parents_.begin(), parents_.end(),
                                        [&](const auto& q) { return q.first == p_.parent[e]; });
        const double w = t.weight[k] * p_.weight[e];
        if (found == parents_.end())
          parents_.emplace_back(p_.parent[e], w);
        else
          found->second += w;
      }
    }
    for (const auto& [i, wi] : parents_)
      for (const auto& [j, wj] : parents_) add_coarse(i, j, wi * wj, t.matrix);
  }

  void add_coarse(std::int32_t i, std::int32_t j, double weight, const Mat3& matrix) {
    BlockRows& a = levels_[0].a;
    const auto first = a.column.begin() + a.begin[i], last = a.column.begin() + a.begin[i + 1];
    const auto found = std::lower_bound(first, last, j);
    if (found != last && *found == j)
      a.value[found - a.column.begin()] += weight * matrix;
    else
      // The pattern has no block for this pair; its absolute value on the diagonal is an upper
      // bound.
      a.value[a.diagonal[i]] += std::abs(weight) * matrix;
  }

  void set_level(std::size_t l) {
    Level& level = levels_[l];
    for (const std::int32_t d : level.a.diagonal)
      if (!(level.a.value[d].trace() > 0.0)) level.a.value[d].setIdentity();  // all children held
    if (l + 1 == levels_.size() && dense()) {
      factor(level.a);
      return;
    }
    std::vector<Mat3>& step = level.smoother.step;
    step.resize(level.a.size());
    for (std::size_t i = 0; i < step.size(); ++i)
      step[i] = level.a.value[level.a.diagonal[i]].inverse();
    const double lambda = largest_eigenvalue(
        step, [&](auto from, auto to) { multiply(level.a, from, to); }, level.x,
        level.smoother.scratch);
    for (Mat3& s : step) s *= kSmootherStep / lambda;
    if (l + 1 < levels_.size())
      products_[l + 1].compute(level.a.begin, level.a.column, level.a.value, level.p, {},
                               levels_[l + 1].a);
  }

  /// True if the last level is small enough for a factorisation; isolated particles do not
  /// aggregate.
  bool dense() const { return levels_.back().a.size() <= 2 * kCoarsestSize; }

  void factor(const BlockRows& a) {
    const auto n = static_cast<Eigen::Index>(3 * a.size());
    full_.setZero(n, n);
    for (std::size_t i = 0; i < a.size(); ++i)
      for (std::int32_t k = a.begin[i]; k < a.begin[i + 1]; ++k)
        full_.block<3, 3>(static_cast<Eigen::Index>(3 * i), 3 * a.column[k]) = a.value[k];
    factor_.compute(full_);
  }

  void cycle(std::size_t l) {
    Level& level = levels_[l];
    if (l + 1 == levels_.size()) {
      solve_last(level);
      return;
    }
    const std::span<Vec3> scratch = level.smoother.scratch;
    level.smoother.start(level.b, level.x);
    multiply(level.a, level.x, scratch);
    subtract_from(level.b, {}, scratch);
    restrict_to(level.p, scratch, levels_[l + 1].b);
    cycle(l + 1);
    prolong_add(level.p, levels_[l + 1].x, {}, level.x);
    multiply(level.a, level.x, scratch);
    level.smoother.correct(level.b, scratch, level.x);
  }

  void solve_last(Level& level) {
    if (!dense()) {
      level.smoother.start(level.b, level.x);
      return;
    }
    const auto n = static_cast<Eigen::Index>(3 * level.x.size());
    Eigen::Map<Eigen::VectorXd>(level.x.data()->data(), n) =
        factor_.solve(Eigen::Map<const Eigen::VectorXd>(level.b.data()->data(), n));
  }

  void multiply_fine(std::span<const Vec3> x, std::span<Vec3> y) {
    fine_.multiply(*a_, x, y);
    if (!terms_->empty()) terms_->add_multiply(x, y);
  }

  const BlockMatrix* a_ = nullptr;
  TermOperator* terms_ = nullptr;
  std::span<const char> free_;
  SmootherMatrix fine_;
  std::vector<Mat3> inverse_;   // of its diagonal blocks
  std::vector<Mat3> diagonal_;  // of the terms
  std::vector<Vec3> power_;     // scratch of the power iterations
  double lambda_ = 1.0;
  Smoother smoother_;
  Prolongation p_;
  std::vector<GalerkinProduct> products_;
  std::vector<Level> levels_;
  std::vector<Mat3> base_;  // the first level without terms
  std::vector<std::pair<std::int32_t, double>> parents_;
  Eigen::MatrixXd full_;  // the last level
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace

std::unique_ptr<Preconditioner> make_multilevel() { return std::make_unique<Multilevel>(); }

}  // namespace selvedge::detail
