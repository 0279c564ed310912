// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/image_space/detail/offscreen.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The tiles of a picture that a window meets, ends excluded. Empty if begin >= end.
struct TileWindow {
  int x_begin = 0, x_end = 0, y_begin = 0, y_end = 0;
};

/// A range of depths, m.
struct Interval {
  double lo, hi;
};

/// The triangles in an index buffer, gathered by tiles of kSide x kSide texels, each tile listing a
/// triangle once. The cost of a window depends on its different triangles, not on its texels, and a
/// tile whose triangles all lie at other depths costs one comparison.
class IndexTiles {
 public:
  static constexpr int kSide = 8;

  /// `depths`: the range of depths of each triangle, in any frame.
  void gather(const MapFrame& frame, const Layer& layer, std::span<const Interval> depths);

  /// The tiles within a texel of the box from (u_lo, v_lo) to (u_hi, v_hi), in texels. A triangle
  /// is drawn where it covers the middle of a texel, up to one texel away from its edges.
  TileWindow window(double u_lo, double u_hi, double v_lo, double v_hi) const;
  /// Number of calls of f that `visit` would make if it ignored depths.
  std::size_t count(const TileWindow& w) const;
  /// Calls f(triangle) for the triangles in the window, some more than once, but skips tiles whose
  /// triangles lie outside `depth`.
  template <class F>
  void visit(const TileWindow& w, const Interval& depth, F f) const {
    for (int y = w.y_begin; y < w.y_end; ++y)
      for (int x = w.x_begin; x < w.x_end; ++x) {
        const std::size_t tile = at(x, y);
        if (depths_[tile].hi < depth.lo || depth.hi < depths_[tile].lo) continue;
        for (std::uint32_t i = begin_[tile]; i < begin_[tile + 1]; ++i) f(triangles_[i]);
      }
  }
  std::span<const std::int32_t> triangles() const { return triangles_; }
  std::size_t bytes() const;

 private:
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(x);
  }

  int columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> begin_;  ///< start of each tile, and the end
  std::vector<Interval> depths_;  ///< range over all triangles of each tile; lo > hi if there are
                                  ///< none
  std::vector<std::int32_t> triangles_;
};

}  // namespace selvedge::detail
