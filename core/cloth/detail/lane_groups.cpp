// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/detail/lane_groups.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

/// Groups the elements of one chunk after another.
class Grouping {
 public:
  Grouping(std::span<const std::int32_t> particle_of, std::size_t arity)
      : particle_of_(particle_of), arity_(arity) {}

  void add_chunk(std::span<std::int32_t> chunk) {
    std::sort(chunk.begin(), chunk.end(), [&](auto e, auto d) { return before(e, d); });
    sorted_.clear();
    rest_.clear();
    std::size_t i = 0;
    while (i < chunk.size()) {
      if (is_run(chunk.subspan(i))) {
        add_run(chunk.subspan(i, kGroupLanes));
        i += kGroupLanes;
      } else {
        rest_.push_back(chunk[i++]);
      }
    }
    // Restored to the original order, which accesses memory better than the order by shape.
    std::sort(rest_.begin(), rest_.end());
    for (std::size_t r = 0; r < rest_.size(); r += kGroupLanes)
      add_mixed(std::span(rest_).subspan(r, std::min(kGroupLanes, rest_.size() - r)));
    std::copy(sorted_.begin(), sorted_.end(), chunk.begin());
  }

  LaneGroups take() { return std::move(result_); }

 private:
  std::int32_t corner(std::int32_t e, std::size_t k) const { return particle_of_[e * arity_ + k]; }
  /// Particle of corner k relative to that of corner 0.
  std::int32_t offset(std::int32_t e, std::size_t k) const { return corner(e, k) - corner(e, 0); }

  /// Sorts elements of one shape together, and adjacent elements one after another.
  bool before(std::int32_t e, std::int32_t d) const {
    for (std::size_t k = 1; k < arity_; ++k)
      if (offset(e, k) != offset(d, k)) return offset(e, k) < offset(d, k);
    return corner(e, 0) != corner(d, 0) ? corner(e, 0) < corner(d, 0) : e < d;
  }

  bool is_run(std::span<const std::int32_t> from) const {
    if (from.size() < kGroupLanes) return false;
    for (std::size_t l = 1; l < kGroupLanes; ++l)
      for (std::size_t k = 0; k < arity_; ++k)
        if (corner(from[l], k) != corner(from[0], k) + static_cast<std::int32_t>(l)) return false;
    return true;
  }

  void begin_group(std::size_t count, bool run) {
    result_.groups.push_back({elements_, static_cast<std::uint32_t>(result_.particles.size()),
                              static_cast<std::int16_t>(count), run});
    elements_ += static_cast<std::uint32_t>(count);
  }

  void add_run(std::span<const std::int32_t> elements) {
    begin_group(kGroupLanes, true);
    for (std::size_t k = 0; k < arity_; ++k) result_.particles.push_back(corner(elements[0], k));
    sorted_.insert(sorted_.end(), elements.begin(), elements.end());
  }

  void add_mixed(std::span<const std::int32_t> elements) {
    begin_group(elements.size(), false);
    for (std::size_t k = 0; k < arity_; ++k)
      for (std::size_t l = 0; l < kGroupLanes; ++l)
        result_.particles.push_back(corner(elements[std::min(l, elements.size() - 1)], k));
    sorted_.insert(sorted_.end(), elements.begin(), elements.end());
  }

  std::span<const std::int32_t> particle_of_;
  std::size_t arity_;
  std::vector<std::int32_t> sorted_, rest_;
  std::uint32_t elements_ = 0;
  LaneGroups result_;
};

}  // namespace

LaneGroups make_lane_groups(std::span<const std::int32_t> particle_of, std::size_t arity,
                            Coloring& coloring) {
  Grouping grouping(particle_of, arity);
  const std::span<std::int32_t> order = coloring.order;
  for (std::size_t c = 0; c + 1 < coloring.color_begin.size(); ++c)
    for (std::size_t b = coloring.color_begin[c]; b < coloring.color_begin[c + 1]; b += kColorChunk)
      grouping.add_chunk(order.subspan(b, std::min(kColorChunk, coloring.color_begin[c + 1] - b)));
  return grouping.take();
}

}  // namespace selvedge::detail
