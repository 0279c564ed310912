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

/// The triangles that an index buffer shows, gathered by tiles of kSide x kSide texels, each of a
/// tile once. A window then costs its different triangles and not its texels.
class IndexTiles {
 public:
  static constexpr int kSide = 8;

  void gather(const MapFrame& frame, std::span<const Layer> layers);

  /// The tiles within a texel of the box from (u_lo, v_lo) to (u_hi, v_hi), in texels. A triangle
  /// is drawn where it covers a texel's middle, which may lie up to a texel beside what it touches.
  TileWindow window(double u_lo, double u_hi, double v_lo, double v_hi) const;
  /// How many triangles `visit` would be called for.
  std::size_t count(const TileWindow& w) const;
  /// Calls f(triangle) for those in the window, for some more than once.
  template <class F>
  void visit(const TileWindow& w, F f) const {
    for (int y = w.y_begin; y < w.y_end; ++y)
      for (std::uint32_t i = row(y, w.x_begin), end = row(y, w.x_end); i < end; ++i)
        f(triangles_[i]);
  }
  std::span<const std::int32_t> triangles() const { return triangles_; }
  std::size_t bytes() const;

 private:
  /// Where the triangles of tile x of tile row y begin.
  std::uint32_t row(int y, int x) const {
    return begin_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(x)];
  }

  int columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> begin_;
  std::vector<std::int32_t> triangles_;
};

}  // namespace selvedge::detail
