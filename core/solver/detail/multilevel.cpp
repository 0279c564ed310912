// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/detail/even_grain.h>
#include <selvedge/core/solver/detail/dense_cholesky.h>
#include <selvedge/core/solver/detail/implicit_terms.h>
#include <selvedge/core/solver/detail/lane_ranges.h>
#include <selvedge/core/solver/detail/multilevel.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace selvedge::detail {
namespace {

// Least number of rows and of coarse rows per task.
constexpr std::size_t kRows = 512, kCoarseRows = 64;
constexpr std::size_t kTermsTogether = 256;  // terms per task
// Factoring 3·96 dense unknowns costs about 8 Mflop, less than another level.
constexpr std::size_t kCoarsestSize = 96, kLargestFactored = 2 * kCoarsestSize;
// A level that is larger than this fraction of its parent level is not worth its cost.
constexpr double kLeastCoarsening = 0.75;
// The smoother x += ω/λ D⁻¹ r keeps the cycle positive definite for ω/λ < 2/λmax(D⁻¹A). The Lanczos
// method approaches λmax from below, to about 10 % in four steps; ω = 1.5 leaves a margin of a
// fifth.
constexpr double kSmootherStep = 1.5;

/// Calls body(first, last) on ranges of n rows.
template <class Body>
void by_rows(std::size_t n, const Body& body) {
  parallel_for(n, even_grain(n, kRows), body);
}

void copy_points(const LaneVector& x, std::span<Point4> points) {
  const float* from = x.data();
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {{from[i], from[x.stride() + i], from[2 * x.stride() + i], 0.0f}};
}

}  // namespace

struct Multilevel::Factor {
  DenseCholesky matrix;
  std::vector<double> x;
};

Multilevel::Multilevel() : factor_(std::make_unique<Factor>()) {}
Multilevel::~Multilevel() = default;

void Multilevel::set_matrix(const BlockMatrix& a, std::span<const char> free,
                            std::span<const Vec3> x) {
  free_ = free;
  x_ = x;
  if (levels_.empty()) build(a);
  levels_[0].value = a.values();
  if (!std::equal(free.begin(), free.end(), weighted_.begin(), weighted_.end())) {
    weighted_.assign(free.begin(), free.end());
    if (levels_.size() > 1) set_weights(levels_[0]);
  }
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    Level& level = levels_[l];
    if (l > 0) {
      Level& finer = levels_[l - 1];
      finer.product.compute(finer.value, finer.p, l == 1 ? free : std::span<const char>{},
                            level.own);
      for (const std::int32_t d : level.diagonal)
        if (!(level.own.value[d].trace() > 0.0)) level.own.value[d].setIdentity();  // all held
    }
    set_values(level);
    if (!is_last(level) || !dense()) set_smoother(level);
  }
}

void Multilevel::build(const BlockMatrix& a) {
  levels_.emplace_back();
  levels_[0].begin = a.row_begin();
  levels_[0].column = a.columns();
  set_pattern(levels_[0]);
  levels_[0].particle.resize(levels_[0].size());
  std::iota(levels_[0].particle.begin(), levels_[0].particle.end(), 0);
  while ((levels_.size() == 1 || levels_.back().size() > kCoarsestSize) && add_level()) {
  }
  for (std::size_t l = 1; l < levels_.size(); ++l) {  // views into levels that no longer move
    Level& level = levels_[l];
    if (visits(l) > 1)
      for (LaneVector* v : {&level.rest, &level.change}) v->resize(level.size());
    level.begin = level.own.begin;
    level.column = level.own.column;
    level.value = level.own.value;
  }
}

bool Multilevel::add_level() {
  Level& last = levels_.back();
  Prolongation p = make_prolongation(last.begin, last.column);
  if (levels_.size() > 1 &&
      static_cast<double>(p.parents()) > kLeastCoarsening * static_cast<double>(last.size()))
    return false;
  last.parents.set_pattern(p.begin, p.parent);
  last.restriction.resize(p.child_entry.size());
  Level next;
  last.product.set_pattern(last.begin, last.column, p, next.own);
  last.p = std::move(p);
  set_weights(last);
  next.particle.reserve(last.p.parents());
  for (std::size_t k = 0; k < last.p.parents(); ++k)
    next.particle.push_back(last.particle[last.p.child[last.p.child_begin[k]]]);
  levels_.push_back(std::move(next));
  Level& level = levels_.back();
  level.begin = level.own.begin;
  level.column = level.own.column;
  set_pattern(level);
  return true;
}

void Multilevel::set_pattern(Level& level) {
  const std::size_t n = level.size();
  level.matrix.set_pattern(level.begin, level.column);
  level.diagonal.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = level.column.subspan(level.begin[i], level.begin[i + 1] - level.begin[i]);
    const auto own = std::lower_bound(row.begin(), row.end(), static_cast<std::int32_t>(i));
    level.diagonal.push_back(level.begin[i] + static_cast<std::int32_t>(own - row.begin()));
  }
  for (LaneVector* v : {&level.b, &level.x, &level.y, &level.loose.product}) v->resize(n);
  for (auto* step : {&level.base_step, &level.step})
    step->assign(kStepNumbers * level.x.groups(), 0.0f);
  level.points.resize(kRowLanes * level.x.groups());
  level.place.assign(n, -1);
  level.is_changed.assign(level.column.size(), 0);
}

/// Held particles take no part in the coarser levels.
void Multilevel::set_weights(Level& level) {
  const Prolongation& p = level.p;
  const auto weight = [&](std::size_t i, std::int32_t e) {
    return is_held(level, static_cast<std::int32_t>(i)) ? 0.0f : static_cast<float>(p.weight[e]);
  };
  for (std::size_t i = 0; i < level.size(); ++i)
    for (std::int32_t e = p.begin[i]; e < p.begin[i + 1]; ++e)
      level.parents.set_weight(i, static_cast<std::size_t>(e - p.begin[i]), weight(i, e));
  for (std::size_t c = 0; c < p.child_entry.size(); ++c)
    level.restriction[c] = weight(p.child[c], p.child_entry[c]);
}

void Multilevel::set_values(Level& level) {
  for (const std::int32_t i : level.touched) level.place[i] = -1;
  for (const std::size_t k : level.changed) level.is_changed[k] = 0;
  level.touched.clear();
  level.bound.clear();
  level.changed.clear();
  const bool any_held = &level == &levels_.front() && std::ranges::find(free_, 0) != free_.end();
  by_rows(level.size(), [&](std::size_t first, std::size_t last) {
    if (!any_held) {
      for (std::int32_t k = level.begin[first]; k < level.begin[last]; ++k)
        level.matrix.set(k, level.value[k]);
      return;
    }
    for (std::size_t i = first; i < last; ++i)
      for (std::int32_t k = level.begin[i]; k < level.begin[i + 1]; ++k) {
        const auto row = static_cast<std::int32_t>(i);
        if (is_held(level, row) || is_held(level, level.column[k]))
          level.matrix.set(k, level.column[k] == row ? Mat3(Mat3::Identity()) : Mat3(Mat3::Zero()));
        else
          level.matrix.set(k, level.value[k]);
      }
  });
}

/// λ and S = ω/λ D⁻¹ of the matrix without terms.
void Multilevel::set_smoother(Level& level) {
  const auto set_inverse = [&](double factor) {
    by_rows(level.size(), [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i)
        set_step(level.base_step, i,
                 is_held(level, static_cast<std::int32_t>(i))
                     ? Mat3(factor * Mat3::Identity())
                     : Mat3(factor * level.value[level.diagonal[i]].inverse()));
    });
  };
  set_inverse(1.0);
  level.lambda = largest_eigenvalue(level);
  const auto factor = static_cast<float>(kSmootherStep / level.lambda);
  for (float& s : level.base_step) s *= factor;
  level.step = level.base_step;
}

void Multilevel::set_terms(std::span<const ImplicitTerm> terms, const Followers* followers) {
  find_rows(terms, followers);
  parallel_for(levels_.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t l = first; l < last; ++l) {
      join_rows(l);
      if (is_last(levels_[l]) && dense())
        factor_last(terms);
      else
        set_level_terms(levels_[l], terms);
    }
  });
}

void Multilevel::LevelTerms::clear() {
  begin.clear();
  rows.clear();
}

void Multilevel::LevelTerms::add(std::int32_t row, double weight) {
  const auto first = rows.begin() + static_cast<std::ptrdiff_t>(begin.back());
  const auto same = std::find_if(first, rows.end(), [&](const auto& q) { return q.first == row; });
  if (same == rows.end())
    rows.emplace_back(row, weight);
  else
    same->second += weight;
}

void Multilevel::LevelTerms::sort() {
  std::sort(rows.begin() + static_cast<std::ptrdiff_t>(begin.back()), rows.end());
}

/// The rows of the terms on all levels, range by range.
void Multilevel::find_rows(std::span<const ImplicitTerm> terms, const Followers* followers) {
  const std::size_t ranges = (terms.size() + kTermsTogether - 1) / kTermsTogether;
  if (rows_of_terms_.size() < ranges) rows_of_terms_.resize(ranges);
  for (std::vector<LevelTerms>& unused : std::span(rows_of_terms_).subspan(ranges))
    for (LevelTerms& level : unused) level.clear();
  parallel_for(terms.size(), kTermsTogether, [&](std::size_t first, std::size_t last) {
    std::vector<LevelTerms>& rows = rows_of_terms_[first / kTermsTogether];
    rows.resize(levels_.size());
    set_fine_rows(terms.subspan(first, last - first), followers, rows[0]);
    for (std::size_t l = 1; l < rows.size(); ++l)
      set_coarse_rows(rows[l - 1], levels_[l - 1].p, rows[l]);
  });
}

/// Joins the ranges of a level.
void Multilevel::join_rows(std::size_t l) {
  LevelTerms& all = levels_[l].terms;
  all.clear();
  for (const std::vector<LevelTerms>& part : rows_of_terms_) {
    for (std::size_t t = 0; t + 1 < part[l].begin.size(); ++t)
      all.begin.push_back(all.rows.size() + part[l].begin[t]);
    all.rows.insert(all.rows.end(), part[l].rows.begin(), part[l].rows.end());
  }
  all.begin_term();
}

void Multilevel::set_fine_rows(std::span<const ImplicitTerm> terms, const Followers* followers,
                               LevelTerms& out) const {
  out.clear();
  for (const ImplicitTerm& t : terms) {
    out.begin_term();
    for (int k = 0; k < 4; ++k)
      for_each_row(t, k, followers, [&](std::int32_t i, double weight) {
        if (free_[i]) out.add(i, weight);
      });
    out.sort();
  }
  out.begin_term();
}

/// The terms on the next coarser level: every row passes its weight to its parents.
void Multilevel::set_coarse_rows(const LevelTerms& fine, const Prolongation& p, LevelTerms& out) {
  out.clear();
  for (std::size_t t = 0; t + 1 < fine.begin.size(); ++t) {
    out.begin_term();
    for (const auto& [row, weight] : fine.of(t))
      for (std::int32_t e = p.begin[row]; e < p.begin[row + 1]; ++e)
        out.add(p.parent[e], weight * p.weight[e]);
    out.sort();
  }
  out.begin_term();
}

void Multilevel::clear_terms(Level& level) {
  for (const std::size_t k : level.changed) {
    level.matrix.set(k, level.value[k]);
    level.is_changed[k] = 0;
  }
  for (const std::int32_t i : level.touched) {
    level.place[i] = -1;
    const std::size_t at = i / kRowLanes * kStepNumbers + i % kRowLanes;
    for (std::size_t e = at; e < at + kStepNumbers; e += kRowLanes)
      level.step[e] = level.base_step[e];
  }
  level.changed.clear();
  level.touched.clear();
  level.bound.clear();
}

/// Adds the terms to the matrix and the smoother of a level. The smoother is
/// S = ω (λ D + Σ_t B_t)⁻¹, where B_t = |w_i| Σ_j |w_j| M at row i bounds term t by Gershgorin's
/// theorem.
void Multilevel::set_level_terms(Level& level, std::span<const ImplicitTerm> terms) {
  clear_terms(level);
  level.loose.term.clear();
  for (std::size_t t = 0; t < terms.size(); ++t) add_term(level, t, terms[t].matrix);
  by_rows(level.touched.size(), [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const std::int32_t i = level.touched[k];
      const Mat3& d = level.value[level.diagonal[i]];
      set_step(level.step, i, kSmootherStep * (level.lambda * d + level.bound[k]).inverse());
    }
  });
  set_loose(level, terms);
}

void Multilevel::add_term(Level& level, std::size_t t, const Mat3& matrix) {
  const auto rows = level.terms.of(t);
  double sum = 0.0;
  for (const auto& [i, w] : rows) sum += std::abs(w);
  for (const auto& [i, w] : rows) {
    std::int32_t& place = level.place[i];
    if (place < 0) {
      place = static_cast<std::int32_t>(level.touched.size());
      level.touched.push_back(i);
      level.bound.emplace_back(Mat3::Zero());
    }
    level.bound[place] += (std::abs(w) * sum) * matrix;
  }
  level.between.clear();
  for (const auto& [i, wi] : rows)
    for (const auto& [j, wj] : rows) level.between.push_back(find_block(level, i, j));
  if (std::count(level.between.begin(), level.between.end(), -1) > 0) {
    level.loose.term.push_back(static_cast<std::uint32_t>(t));
    return;
  }
  auto found = level.between.begin();
  for (const auto& [i, wi] : rows)
    for (const auto& [j, wj] : rows) {
      const auto block = static_cast<std::size_t>(*found++);
      level.matrix.add(block, (wi * wj) * matrix);
      if (std::exchange(level.is_changed[block], 1) == 0) level.changed.push_back(block);
    }
}

/// The block of row i and column j, or -1.
std::int64_t Multilevel::find_block(const Level& level, std::int32_t i, std::int32_t j) {
  if (i == j) return level.diagonal[i];
  const auto row = level.column.subspan(level.begin[i], level.begin[i + 1] - level.begin[i]);
  const auto found = std::lower_bound(row.begin(), row.end(), j);
  return found != row.end() && *found == j ? level.begin[i] + (found - row.begin()) : -1;
}

void Multilevel::set_loose(Level& level, std::span<const ImplicitTerm> terms) {
  LooseTerms& loose = level.loose;
  for (const LooseTerms::Entry& e : loose.entries) loose.product.set(e.row, Vec3::Zero());
  loose.entries.clear();
  loose.matrix.resize(loose.term.size());
  loose.moment.resize(loose.term.size());
  for (std::uint32_t q = 0; q < loose.term.size(); ++q) {
    const Mat3& matrix = terms[loose.term[q]].matrix;
    for (int e = 0; e < 9; ++e) loose.matrix[q][e] = static_cast<float>(matrix.data()[e]);
    for (const auto& [i, w] : level.terms.of(loose.term[q]))
      loose.entries.push_back({i, q, static_cast<float>(w)});
  }
  std::sort(loose.entries.begin(), loose.entries.end(), [](const auto& a, const auto& b) {
    return std::tie(a.row, a.term) < std::tie(b.row, b.term);
  });
  loose.row_begin.clear();
  for (std::uint32_t e = 0; e < loose.entries.size(); ++e)
    if (e == 0 || loose.entries[e].row != loose.entries[e - 1].row) loose.row_begin.push_back(e);
  loose.row_begin.push_back(static_cast<std::uint32_t>(loose.entries.size()));
}

const float* Multilevel::extra(Level& level, const LaneVector& x) {
  LooseTerms& loose = level.loose;
  if (loose.empty()) return nullptr;
  const std::size_t stride = x.stride();
  const float* from = x.data();
  by_rows(loose.term.size(), [&](std::size_t first, std::size_t last) {
    for (std::size_t q = first; q < last; ++q) {
      float sum[3] = {};
      for (const auto& [i, w] : level.terms.of(loose.term[q]))
        for (int k = 0; k < 3; ++k) sum[k] += static_cast<float>(w) * from[k * stride + i];
      const std::array<float, 9>& m = loose.matrix[q];
      for (int k = 0; k < 3; ++k)
        loose.moment[q].at[k] = m[k] * sum[0] + m[3 + k] * sum[1] + m[6 + k] * sum[2];
    }
  });
  float* to = loose.product.data();
  by_rows(loose.row_begin.size() - 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t r = first; r < last; ++r) {
      Point4 sum{};
      for (std::uint32_t e = loose.row_begin[r]; e < loose.row_begin[r + 1]; ++e)
        for (int k = 0; k < 3; ++k)
          sum.at[k] += loose.entries[e].weight * loose.moment[loose.entries[e].term].at[k];
      const std::int32_t i = loose.entries[loose.row_begin[r]].row;
      for (int k = 0; k < 3; ++k) to[k * stride + i] = sum.at[k];
    }
  });
  return to;
}

double Multilevel::multiply(const LaneVector& x, LaneVector& y) {
  Level& level = levels_[0];
  const LaneRows rows = level.matrix.rows(level.step);
  const float* more = extra(level, x);
  return sum_by_groups(x, [&](std::size_t first, std::size_t last) {
    return lane_matrix_kernel().multiply(rows, x.data(), more, y.data(), first, last);
  });
}

double Multilevel::apply(const LaneVector& r, LaneVector& z) { return cycle(0, r, z); }

double Multilevel::cycle(std::size_t l, const LaneVector& b, LaneVector& z) {
  Level& level = levels_[l];
  if (is_last(level) && dense()) {
    solve_last(b, z);
    return dot(b, z);
  }
  const LaneMatrixKernel& kernel = lane_matrix_kernel();
  const LaneRows rows = level.matrix.rows(level.step);
  LaneVector& x = is_last(level) ? z : level.x;
  by_groups(b, [&](std::size_t first, std::size_t last) {
    kernel.start(rows, b.data(), x.data(), first, last);
  });
  if (is_last(level)) return dot(b, z);
  const float* more = extra(level, x);
  by_groups(b, [&](std::size_t first, std::size_t last) {
    kernel.residual(rows, b.data(), x.data(), more, level.points.data(), first, last);
  });
  Level& coarse = levels_[l + 1];
  parallel_for(coarse.size(), even_grain(coarse.size(), kCoarseRows),
               [&](std::size_t first, std::size_t last) {
                 kernel.restrict_to(level.p.child_begin.data(), level.p.child.data(),
                                    level.restriction.data(), level.points.data(), coarse.b.data(),
                                    coarse.b.stride(), first, last);
               });
  solve_coarse(l + 1);
  copy_points(coarse.y, coarse.points);
  const LaneParentRows parents(level.parents);
  by_groups(b, [&](std::size_t first, std::size_t last) {
    kernel.prolong(parents, coarse.points.data(), x.data(), x.stride(), first, last);
  });
  more = extra(level, x);
  return sum_by_groups(b, [&](std::size_t first, std::size_t last) {
    return kernel.relax(rows, b.data(), x.data(), more, z.data(), first, last);
  });
}

/// Level l.y ≈ A⁻¹ b of level l. Its error is I - PA after one visit, and (I - PA)² after two. The
/// eigenvalues of I - PA lie between 0 and 1 if every level has all terms of the next finer one;
/// below -1, a second visit would amplify errors.
void Multilevel::solve_coarse(std::size_t l) {
  Level& level = levels_[l];
  cycle(l, level.b, level.y);
  if (visits(l) == 1) return;
  const LaneRows rows = level.matrix.rows(level.step);
  LaneVector& rest = level.rest;
  const float* more = extra(level, level.y);
  by_groups(rest, [&](std::size_t first, std::size_t last) {
    lane_matrix_kernel().multiply(rows, level.y.data(), more, rest.data(), first, last);
  });
  scale_and_add(-1.0f, level.b, rest);
  cycle(l, rest, level.change);
  scale_and_add(1.0f, level.change, level.y);
}

/// How often the next finer level solves with level l: twice if it is too large to be factored. One
/// cycle over several levels reduces long waves too little.
int Multilevel::visits(std::size_t l) const {
  return l > 0 && !is_last(levels_[l]) && levels_[l].size() > kLargestFactored ? 2 : 1;
}

bool Multilevel::dense() const { return levels_.back().size() <= kLargestFactored; }

void Multilevel::factor_last(std::span<const ImplicitTerm> terms) {
  const Level& level = levels_.back();
  DenseCholesky& matrix = factor_->matrix;
  matrix.set_zero(3 * level.size());
  const auto add = [&](std::size_t i, std::size_t j, const Mat3& block) {
    if (i < j) return;  // the upper half
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t r = 0; r < 3; ++r) matrix(3 * i + r, 3 * j + c) += block(r, c);
  };
  for (std::size_t i = 0; i < level.size(); ++i)
    for (std::int32_t k = level.begin[i]; k < level.begin[i + 1]; ++k)
      add(i, level.column[k], level.value[k]);
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (const auto& [i, wi] : level.terms.of(t))
      for (const auto& [j, wj] : level.terms.of(t)) add(i, j, (wi * wj) * terms[t].matrix);
  matrix.factor();
}

void Multilevel::solve_last(const LaneVector& b, LaneVector& z) {
  std::vector<double>& x = factor_->x;
  x.resize(3 * b.size());
  for (std::size_t i = 0; i < b.size(); ++i) {
    const Vec3 v = b[i];
    for (std::size_t k = 0; k < 3; ++k) x[3 * i + k] = v[k];
  }
  factor_->matrix.solve(x.data());
  for (std::size_t i = 0; i < b.size(); ++i) z.set(i, Vec3(x[3 * i], x[3 * i + 1], x[3 * i + 2]));
}

std::size_t Multilevel::multiply_bytes() const {
  const Level& level = levels_[0];
  return level.matrix.bytes() + 2 * level.x.bytes();
}

std::size_t Multilevel::cycle_bytes() const {
  std::size_t sum = 0, times = 1;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const Level& level = levels_[l];
    const std::size_t vector = level.x.bytes();
    if (is_last(level)) {
      sum += times * (dense() ? factor_->matrix.bytes() : 2 * vector);
      continue;
    }
    // Between two visits: A, y, rest, b, rest twice; change, y twice.
    if (visits(l) > 1) sum += times * (level.matrix.bytes() + 8 * vector);
    times *= static_cast<std::size_t>(visits(l));
    // Start: S, b, x. Residual: A, b, x, points. Prolongation: weights, points, x twice.
    // Relaxation: A, S, b, x, y. Restriction: weights, points.
    sum += times * (2 * level.matrix.bytes() + 2 * sizeof(float) * level.step.size() + 9 * vector +
                    2 * sizeof(Point4) * level.points.size() + level.parents.bytes() +
                    (sizeof(float) + sizeof(std::int32_t)) * level.p.parent.size());
  }
  return sum;
}

}  // namespace selvedge::detail
