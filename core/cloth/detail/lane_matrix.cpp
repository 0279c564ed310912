// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/detail/lane_matrix.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace selvedge::detail {
namespace {

// A group is stored by distances from the diagonal if that takes at most this share more slots than
// its longest row has blocks.
constexpr double kMostPadding = 0.3;

// Blocks of kRowLanes numbers per task.
constexpr std::size_t kNumberGrain = 1024;

}  // namespace

void LaneVector::resize(std::size_t n) {
  size_ = n;
  padded_ = (n + kRowLanes - 1) / kRowLanes * kRowLanes;
  values_.assign(3 * padded_, 0.0f);
}

void LaneVector::set_zero() { std::fill(values_.begin(), values_.end(), 0.0f); }

double dot(const LaneVector& a, const LaneVector& b) {
  return parallel_sum(3 * a.groups(), kNumberGrain, [&](std::size_t first, std::size_t last) {
    return lane_matrix_kernel().dot(a.data(), b.data(), first, last);
  });
}

void add_step(float factor, const LaneVector& p, const LaneVector& ap, LaneVector& x,
              LaneVector& r) {
  const LaneStep step{p.data(), ap.data(), x.data(), r.data()};
  parallel_for(3 * x.groups(), kNumberGrain, [&](std::size_t first, std::size_t last) {
    lane_matrix_kernel().add_step(factor, step, first, last);
  });
}

void scale_and_add(float factor, const LaneVector& x, LaneVector& y) {
  parallel_for(3 * x.groups(), kNumberGrain, [&](std::size_t first, std::size_t last) {
    lane_matrix_kernel().add_to_scaled(factor, x.data(), y.data(), first, last);
  });
}

void LaneMatrix::set_pattern(std::span<const std::int32_t> begin,
                             std::span<const std::int32_t> column) {
  size_ = begin.size() - 1;
  padded_ = (size_ + kRowLanes - 1) / kRowLanes * kRowLanes;
  where_.resize(column.size());
  slot_begin_.assign(1, 0);
  std::vector<std::int32_t> distances;
  for (std::size_t first = 0; first < size_; first += kRowLanes) {
    const std::size_t last = std::min(first + kRowLanes, size_);
    distances.clear();
    std::size_t longest = 0;
    for (std::size_t i = first; i < last; ++i) {
      longest = std::max<std::size_t>(longest, begin[i + 1] - begin[i]);
      for (std::int32_t k = begin[i]; k < begin[i + 1]; ++k)
        distances.push_back(column[k] - static_cast<std::int32_t>(i));
    }
    std::sort(distances.begin(), distances.end());
    distances.erase(std::unique(distances.begin(), distances.end()), distances.end());
    if (static_cast<double>(distances.size()) <=
        (1.0 + kMostPadding) * static_cast<double>(longest))
      add_distance_slots(first, begin, column, distances);
    else
      add_packed_slots(first, longest, begin, column);
    slot_begin_.push_back(static_cast<std::uint32_t>(run_.size()));
  }
  for (auto* list : {&run_, &column_}) list->shrink_to_fit();
  value_.assign(kSlotNumbers * run_.size(), 0.0f);
}

void LaneMatrix::add_distance_slots(std::size_t first, std::span<const std::int32_t> begin,
                                    std::span<const std::int32_t> column,
                                    std::span<const std::int32_t> distances) {
  const auto n = static_cast<std::int32_t>(size_);
  for (const std::int32_t distance : distances) {
    std::array<std::int32_t, kRowLanes> columns;
    for (std::size_t l = 0; l < kRowLanes; ++l) {
      const auto i = static_cast<std::int32_t>(first + l);
      columns[l] = i + distance;
      // Where the row has no such block, the value is 0, and any column will do.
      if (columns[l] < 0 || columns[l] >= n) columns[l] = std::min(i, n - 1);
      if (i >= n) continue;
      const auto row = column.subspan(begin[i], begin[i + 1] - begin[i]);
      if (const auto found = std::lower_bound(row.begin(), row.end(), i + distance);
          found != row.end() && *found == i + distance)
        where_[begin[i] + (found - row.begin())] =
            static_cast<std::uint32_t>(kRowLanes * run_.size() + l);
    }
    const std::int32_t base = static_cast<std::int32_t>(first) + distance;
    const bool inside = base >= 0 && base + kRowLanes <= padded_;
    if (inside)
      for (std::size_t l = 0; l < kRowLanes; ++l) columns[l] = base + static_cast<std::int32_t>(l);
    add_slot(columns);
  }
}

void LaneMatrix::add_packed_slots(std::size_t first, std::size_t longest,
                                  std::span<const std::int32_t> begin,
                                  std::span<const std::int32_t> column) {
  for (std::size_t s = 0; s < longest; ++s) {
    std::array<std::int32_t, kRowLanes> columns;
    for (std::size_t l = 0; l < kRowLanes; ++l) {
      const std::size_t i = std::min(first + l, size_ - 1);
      columns[l] = static_cast<std::int32_t>(i);
      if (first + l >= size_ || begin[i] + static_cast<std::int32_t>(s) >= begin[i + 1]) continue;
      const std::size_t k = begin[i] + s;
      columns[l] = column[k];
      where_[k] = static_cast<std::uint32_t>(kRowLanes * run_.size() + l);
    }
    add_slot(columns);
  }
}

void LaneMatrix::add_slot(std::span<const std::int32_t, kRowLanes> columns) {
  bool consecutive = columns[0] + kRowLanes <= padded_;
  for (std::size_t l = 1; l < kRowLanes; ++l)
    consecutive = consecutive && columns[l] == columns[l - 1] + 1;
  run_.push_back(consecutive ? columns[0] : -1);
  gathered_ += consecutive ? 0 : 1;
  column_.insert(column_.end(), columns.begin(), columns.end());
}

void LaneParents::set_pattern(std::span<const std::int32_t> begin,
                              std::span<const std::int32_t> parent) {
  const std::size_t n = begin.size() - 1;
  slot_begin_.assign(1, 0);
  parent_.clear();
  for (std::size_t first = 0; first < n; first += kRowLanes) {
    const std::size_t last = std::min(first + kRowLanes, n);
    std::int32_t most = 0;
    for (std::size_t i = first; i < last; ++i) most = std::max(most, begin[i + 1] - begin[i]);
    for (std::int32_t k = 0; k < most; ++k)
      for (std::size_t i = first; i < first + kRowLanes; ++i)
        parent_.push_back(i < last && k < begin[i + 1] - begin[i] ? parent[begin[i] + k] : 0);
    slot_begin_.push_back(static_cast<std::uint32_t>(parent_.size() / kRowLanes));
  }
  parent_.shrink_to_fit();
  weight_.assign(parent_.size(), 0.0f);
}

void LaneParents::set_weight(std::size_t i, std::size_t k, float weight) {
  weight_[kRowLanes * (slot_begin_[i / kRowLanes] + k) + i % kRowLanes] = weight;
}

std::size_t LaneParents::bytes() const {
  return (sizeof(float) + sizeof(std::int32_t)) * parent_.size();
}

LaneRows LaneMatrix::rows(std::span<const float> step) const {
  return {slot_begin_.data(), run_.data(), column_.data(), value_.data(), step.data(), padded_};
}

std::size_t LaneMatrix::bytes() const {
  return sizeof(float) * value_.size() +
         sizeof(std::int32_t) * (run_.size() + kRowLanes * gathered_);
}

void set_step(std::span<float> step, std::size_t i, const Mat3& block) {
  float* to = step.data() + i / kRowLanes * kStepNumbers + i % kRowLanes;
  int e = 0;
  for (int r = 0; r < 3; ++r)
    for (int c = r; c < 3; ++c) to[kRowLanes * e++] = static_cast<float>(block(r, c));
}

}  // namespace selvedge::detail
