// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/detail/aggregation.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::size_t kSumGrain = 1024;
// Fraction of a child's weight that goes to the aggregates of its neighbours: a damped Jacobi step
// of 2/3 on the graph Laplacian.
constexpr double kSmoothing = 2.0 / 3.0;

/// Greedy aggregation: a node whose neighbours are all unassigned forms an aggregate with them;
/// each remaining node joins the aggregate of its last neighbour that has one. Returns the
/// aggregate of each node.
std::vector<std::int32_t> aggregate(std::span<const std::int32_t> begin,
                                    std::span<const std::int32_t> column, std::int32_t& count) {
  const std::size_t n = begin.size() - 1;
  std::vector<std::int32_t> root(n, -1);
  count = 0;
  const auto neighbours = [&](std::size_t i) {
    return column.subspan(begin[i], begin[i + 1] - begin[i]);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const auto own = neighbours(i);
    if (std::any_of(own.begin(), own.end(), [&](auto j) { return root[j] >= 0; })) continue;
    for (const std::int32_t j : own) root[j] = count;
    ++count;
  }
  std::vector<std::int32_t> joined = root;
  for (std::size_t i = 0; i < n; ++i)
    if (root[i] < 0)
      for (const std::int32_t j : neighbours(i))
        if (root[j] >= 0) joined[i] = root[j];
  return joined;
}

void find_children(std::int32_t parents, Prolongation& p) {
  p.child_begin.assign(parents + 1, 0);
  for (const std::int32_t a : p.parent) ++p.child_begin[a + 1];
  for (std::int32_t a = 0; a < parents; ++a) p.child_begin[a + 1] += p.child_begin[a];
  p.child.resize(p.parent.size());
  p.child_entry.resize(p.parent.size());
  std::vector<std::int32_t> next(p.child_begin.begin(), p.child_begin.end() - 1);
  for (std::size_t i = 0; i + 1 < p.begin.size(); ++i)
    for (std::int32_t k = p.begin[i]; k < p.begin[i + 1]; ++k) {
      const std::int32_t at = next[p.parent[k]]++;
      p.child[at] = static_cast<std::int32_t>(i);
      p.child_entry[at] = k;
    }
}

/// Collects the distinct columns of a row and numbers them in ascending order from `first`.
class RowPattern {
 public:
  explicit RowPattern(std::size_t columns) : place_(columns, -1) {}
  void add(std::int32_t column) {
    if (place_[column] >= 0) return;
    place_[column] = 0;
    columns_.push_back(column);
  }
  void number(std::int32_t first) {
    std::sort(columns_.begin(), columns_.end());
    for (std::size_t q = 0; q < columns_.size(); ++q)
      place_[columns_[q]] = first + static_cast<std::int32_t>(q);
  }
  std::int32_t place(std::int32_t column) const { return place_[column]; }
  std::span<const std::int32_t> columns() const { return columns_; }
  void clear() {
    for (const std::int32_t c : columns_) place_[c] = -1;
    columns_.clear();
  }

 private:
  std::vector<std::int32_t> place_, columns_;
};

}  // namespace

Prolongation make_prolongation(std::span<const std::int32_t> begin,
                               std::span<const std::int32_t> column) {
  std::int32_t count = 0;
  const std::vector<std::int32_t> root = aggregate(begin, column, count);
  Prolongation p;
  p.begin.push_back(0);
  std::vector<double> weight(count, 0.0);
  RowPattern row(count);
  for (std::size_t i = 0; i + 1 < begin.size(); ++i) {
    const auto add = [&](std::int32_t parent, double w) {
      row.add(parent);
      weight[parent] += w;
    };
    const std::int32_t degree = begin[i + 1] - begin[i] - 1;
    add(root[i], degree > 0 ? 1.0 - kSmoothing : 1.0);
    for (std::int32_t k = begin[i]; k < begin[i + 1]; ++k)
      if (static_cast<std::size_t>(column[k]) != i) add(root[column[k]], kSmoothing / degree);
    row.number(0);
    for (const std::int32_t parent : row.columns()) {
      p.parent.push_back(parent);
      p.weight.push_back(weight[parent]);
      weight[parent] = 0.0;
    }
    row.clear();
    p.begin.push_back(static_cast<std::int32_t>(p.parent.size()));
  }
  for (auto* list : {&p.begin, &p.parent}) list->shrink_to_fit();
  p.weight.shrink_to_fit();
  find_children(count, p);
  return p;
}

void GalerkinProduct::Sums::add(std::span<const Product> products, std::size_t last) {
  const std::size_t first = size(), before = source.size();
  begin.resize(last + 1, 0);
  for (const Product& q : products) ++begin[static_cast<std::size_t>(q.target) + 1];
  for (std::size_t b = first; b < last; ++b) begin[b + 1] += begin[b];
  source.resize(before + products.size());
  weight_of.resize(before + products.size());
  for (const Product& q : products) {
    const std::uint32_t at = begin[q.target]++;  // where the next product of this block goes
    source[at] = q.source;
    weight_of[at] = q.weight_of;
  }
  for (std::size_t b = last; b > first; --b) begin[b] = begin[b - 1];
  begin[first] = static_cast<std::uint32_t>(before);
}

void GalerkinProduct::Sums::shrink_to_fit() {
  for (auto* list : {&begin, &source, &weight_of}) list->shrink_to_fit();
}

void GalerkinProduct::set_pattern(std::span<const std::int32_t> begin,
                                  std::span<const std::int32_t> column, const Prolongation& p,
                                  BlockRows& coarse) {
  RowPattern row(p.parents());
  std::vector<Product> all;  // of one row
  half_begin_.assign(1, 0);
  for (std::size_t i = 0; i + 1 < begin.size(); ++i) {
    const auto products = [&](auto&& body) {
      for (std::int32_t k = begin[i]; k < begin[i + 1]; ++k)
        for (std::int32_t e = p.begin[column[k]]; e < p.begin[column[k] + 1]; ++e) body(k, e);
    };
    products([&](std::int32_t, std::int32_t e) { row.add(p.parent[e]); });
    row.number(half_begin_.back());
    all.clear();
    products([&](std::int32_t k, std::int32_t e) {
      all.push_back(
          {row.place(p.parent[e]), static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(e)});
    });
    half_column_.insert(half_column_.end(), row.columns().begin(), row.columns().end());
    half_begin_.push_back(static_cast<std::int32_t>(half_column_.size()));
    half_sums_.add(all, half_column_.size());
    row.clear();
  }
  half_sums_.shrink_to_fit();
  half_column_.shrink_to_fit();
  half_.assign(half_column_.size(), Mat3::Zero());
  set_coarse_pattern(p, coarse);
}

void GalerkinProduct::set_coarse_pattern(const Prolongation& p, BlockRows& coarse) {
  RowPattern row(p.parents());
  std::vector<Product> all;  // of one row
  coarse.begin.assign(1, 0);
  for (std::size_t a = 0; a < p.parents(); ++a) {
    const auto products = [&](auto&& body) {
      for (std::int32_t c = p.child_begin[a]; c < p.child_begin[a + 1]; ++c)
        for (std::int32_t q = half_begin_[p.child[c]]; q < half_begin_[p.child[c] + 1]; ++q)
          body(q, p.child_entry[c]);
    };
    products([&](std::int32_t q, std::int32_t) { row.add(half_column_[q]); });
    row.number(coarse.begin.back());
    all.clear();
    products([&](std::int32_t q, std::int32_t e) {
      all.push_back({row.place(half_column_[q]), static_cast<std::uint32_t>(q),
                     static_cast<std::uint32_t>(e)});
    });
    coarse.diagonal.push_back(row.place(static_cast<std::int32_t>(a)));
    coarse.column.insert(coarse.column.end(), row.columns().begin(), row.columns().end());
    coarse.begin.push_back(static_cast<std::int32_t>(coarse.column.size()));
    coarse_sums_.add(all, coarse.column.size());
    row.clear();
  }
  coarse_sums_.shrink_to_fit();
  for (auto* list : {&coarse.begin, &coarse.column, &coarse.diagonal}) list->shrink_to_fit();
  coarse.value.assign(coarse.column.size(), Mat3::Zero());
}

void GalerkinProduct::compute_sums(const Sums& sums, std::span<const double> weight,
                                   std::span<const Mat3> from, std::span<Mat3> to,
                                   const LaneKernel& kernel) {
  if (from.empty()) return;
  const LaneSums lanes{sums.begin.data(), sums.source.data(), sums.weight_of.data(),
                       weight.data(),     from[0].data(),     to[0].data()};
  parallel_for(sums.size(), kSumGrain,
               [&](std::size_t first, std::size_t last) { kernel.sum_blocks(lanes, first, last); });
}

void GalerkinProduct::compute(std::span<const Mat3> value, const Prolongation& p,
                              std::span<const char> free, BlockRows& coarse,
                              const LaneKernel& kernel) {
  weight_ = p.weight;
  for (std::size_t i = 0; i < free.size(); ++i)
    if (!free[i]) std::fill(weight_.begin() + p.begin[i], weight_.begin() + p.begin[i + 1], 0.0);
  compute_sums(half_sums_, weight_, value, half_, kernel);
  compute_sums(coarse_sums_, weight_, half_, coarse.value, kernel);
}

}  // namespace selvedge::detail
