// SPDX-License-Identifier: MIT
#include <selvedge/core/detail/aggregation.h>
#include <selvedge/core/parallel.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::size_t kRowGrain = 1024, kCoarseGrain = 128;
// Fraction of a child's weight that goes to the aggregates of its neighbours: a damped Jacobi step
// of 2/3 on the graph Laplacian.
constexpr double kSmoothing = 2.0 / 3.0;

bool held(std::span<const char> free, std::int32_t i) { return !free.empty() && !free[i]; }

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

Block4 in_single_precision(const Mat3& block) {
  Block4 out{};
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) out.at[4 * c + r] = static_cast<float>(block(r, c));
  return out;
}

Mat3 in_double_precision(const Block4& block) {
  Mat3 out;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) out(r, c) = block.at[4 * c + r];
  return out;
}

void add_weighted(double weight, const Block4& block, Block4& sum) {
  const auto w = static_cast<float>(weight);
  for (int e = 0; e < 12; ++e) sum.at[e] += w * block.at[e];
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
  find_children(count, p);
  return p;
}

void GalerkinProduct::set_pattern(std::span<const std::int32_t> begin,
                                  std::span<const std::int32_t> column, const Prolongation& p,
                                  BlockRows& coarse) {
  RowPattern row(p.parents());
  half_begin_.assign(1, 0);
  for (std::size_t i = 0; i + 1 < begin.size(); ++i) {
    const auto products = [&](auto&& body) {
      for (std::int32_t k = begin[i]; k < begin[i + 1]; ++k)
        for (std::int32_t e = p.begin[column[k]]; e < p.begin[column[k] + 1]; ++e)
          body(p.parent[e]);
    };
    products([&](std::int32_t b) { row.add(b); });
    row.number(half_begin_.back());
    half_slot_begin_.push_back(half_slot_.size());
    products([&](std::int32_t b) { half_slot_.push_back(row.place(b)); });
    half_column_.insert(half_column_.end(), row.columns().begin(), row.columns().end());
    half_begin_.push_back(static_cast<std::int32_t>(half_column_.size()));
    row.clear();
  }
  half_.assign(half_column_.size(), Block4{});
  set_coarse_pattern(p, coarse);
}

void GalerkinProduct::set_coarse_pattern(const Prolongation& p, BlockRows& coarse) {
  RowPattern row(p.parents());
  coarse.begin.assign(1, 0);
  for (std::size_t a = 0; a < p.parents(); ++a) {
    const auto products = [&](auto&& body) {
      for (std::int32_t c = p.child_begin[a]; c < p.child_begin[a + 1]; ++c)
        for (std::int32_t q = half_begin_[p.child[c]]; q < half_begin_[p.child[c] + 1]; ++q)
          body(half_column_[q]);
    };
    products([&](std::int32_t b) { row.add(b); });
    row.number(coarse.begin.back());
    coarse_slot_begin_.push_back(coarse_slot_.size());
    products([&](std::int32_t b) { coarse_slot_.push_back(row.place(b)); });
    coarse.diagonal.push_back(row.place(static_cast<std::int32_t>(a)));
    coarse.column.insert(coarse.column.end(), row.columns().begin(), row.columns().end());
    coarse.begin.push_back(static_cast<std::int32_t>(coarse.column.size()));
    row.clear();
  }
  coarse.value.assign(coarse.column.size(), Mat3::Zero());
  sum_.assign(coarse.column.size(), Block4{});
}

void GalerkinProduct::compute(std::span<const std::int32_t> begin,
                              std::span<const std::int32_t> column, std::span<const Mat3> value,
                              const Prolongation& p, std::span<const char> free,
                              BlockRows& coarse) {
  multiply_right(begin, column, value, p, free);
  multiply_left(p, free, coarse);
}

void GalerkinProduct::multiply_right(std::span<const std::int32_t> begin,
                                     std::span<const std::int32_t> column,
                                     std::span<const Mat3> value, const Prolongation& p,
                                     std::span<const char> free) {
  parallel_for(begin.size() - 1, kRowGrain, [&](std::size_t first, std::size_t last) {
    std::size_t slot = half_slot_begin_[first];
    for (std::size_t i = first; i < last; ++i) {
      std::fill(half_.begin() + half_begin_[i], half_.begin() + half_begin_[i + 1], Block4{});
      for (std::int32_t k = begin[i]; k < begin[i + 1]; ++k) {
        const std::int32_t j = column[k];
        const bool skip = held(free, j);
        const Block4 block = in_single_precision(value[k]);
        for (std::int32_t e = p.begin[j]; e < p.begin[j + 1]; ++e, ++slot)
          if (!skip) add_weighted(p.weight[e], block, half_[half_slot_[slot]]);
      }
    }
  });
}

void GalerkinProduct::multiply_left(const Prolongation& p, std::span<const char> free,
                                    BlockRows& coarse) {
  parallel_for(p.parents(), kCoarseGrain, [&](std::size_t first, std::size_t last) {
    std::size_t slot = coarse_slot_begin_[first];
    for (std::size_t a = first; a < last; ++a) {
      std::fill(sum_.begin() + coarse.begin[a], sum_.begin() + coarse.begin[a + 1], Block4{});
      for (std::int32_t c = p.child_begin[a]; c < p.child_begin[a + 1]; ++c) {
        const std::int32_t i = p.child[c];
        const double w = held(free, i) ? 0.0 : p.weight[p.child_entry[c]];
        for (std::int32_t q = half_begin_[i]; q < half_begin_[i + 1]; ++q, ++slot)
          add_weighted(w, half_[q], sum_[coarse_slot_[slot]]);
      }
      for (std::int32_t q = coarse.begin[a]; q < coarse.begin[a + 1]; ++q)
        coarse.value[q] = in_double_precision(sum_[q]);
    }
  });
}

}  // namespace selvedge::detail
