// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/offscreen.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Which tiles of a picture a window meets, ends excluded. Empty while begin >= end.
struct TileWindow {
  int x_begin = 0, x_end = 0, y_begin = 0, y_end = 0;
};

/// From where to where something reaches, m.
struct Interval {
  double lo, hi;
};

/// The triangles that an index buffer shows, gathered by tiles of kSide x kSide texels, each of a
/// tile once. A window then costs its different triangles and not its texels, and a tile whose
/// triangles all lie elsewhere in depth costs one comparison.
class IndexTiles {
 public:
  static constexpr int kSide = 8;

  /// `depths`: of each triangle, in any frame.
  void gather(const MapFrame& frame, const Layer& layer, std::span<const Interval> depths);

  /// The tiles within a texel of the box from (u_lo, v_lo) to (u_hi, v_hi), in texels. A triangle
  /// is drawn where it covers a texel's middle, which may lie up to a texel beside what it touches.
  TileWindow window(double u_lo, double u_hi, double v_lo, double v_hi) const;
  /// For how many triangles `visit` would call f, were they at every depth.
  std::size_t count(const TileWindow& w) const;
  /// Calls f(triangle) for those in the window, for some more than once, but not for tiles whose
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
  std::vector<std::uint32_t> begin_;  ///< of each tile, and the end
  std::vector<Interval> depths_;      ///< of all triangles of each tile; lo > hi if there are none
  std::vector<std::int32_t> triangles_;
};

}  // namespace selvedge::detail
