// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/image_space/detail/index_tiles.h>

#include <algorithm>
#include <limits>

namespace selvedge::detail {
namespace {

/// Appends the triangles that the texels of one tile show, row by row.
void append_tile(const MapFrame& frame, const Layer& layer, int tile_x, int tile_y,
                 std::vector<std::int32_t>& out) {
  const int x_end = std::min(frame.width, (tile_x + 1) * IndexTiles::kSide);
  const int y_end = std::min(frame.height, (tile_y + 1) * IndexTiles::kSide);
  for (int y = tile_y * IndexTiles::kSide; y < y_end; ++y)
    for (int x = tile_x * IndexTiles::kSide; x < x_end; ++x) {
      const std::int32_t t =
          layer.triangle[static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.width) +
                         static_cast<std::size_t>(x)];
      if (t >= 0 && (out.empty() || out.back() != t)) out.push_back(t);
    }
}

/// The first tile that reaches `texel`, between 0 and `tiles`; NaN counts as 0.
int tile_of(double texel, int tiles) {
  if (!(texel > 0.0)) return 0;
  return static_cast<int>(std::min(texel / IndexTiles::kSide, static_cast<double>(tiles)));
}

}  // namespace

void IndexTiles::gather(const MapFrame& frame, const Layer& layer,
                        std::span<const Interval> depths) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  columns_ = (frame.width + kSide - 1) / kSide;
  rows_ = (frame.height + kSide - 1) / kSide;
  begin_.clear();
  depths_.clear();
  triangles_.clear();
  std::vector<std::int32_t> tile;
  for (int y = 0; y < rows_; ++y)
    for (int x = 0; x < columns_; ++x) {
      tile.clear();
      append_tile(frame, layer, x, y, tile);
      std::sort(tile.begin(), tile.end());
      tile.erase(std::unique(tile.begin(), tile.end()), tile.end());
      begin_.push_back(static_cast<std::uint32_t>(triangles_.size()));
      triangles_.insert(triangles_.end(), tile.begin(), tile.end());
      Interval& all = depths_.emplace_back(Interval{infinity, -infinity});
      for (const std::int32_t t : tile)
        all = {std::min(all.lo, depths[t].lo), std::max(all.hi, depths[t].hi)};
    }
  begin_.push_back(static_cast<std::uint32_t>(triangles_.size()));
}

TileWindow IndexTiles::window(double u_lo, double u_hi, double v_lo, double v_hi) const {
  if (!(u_hi >= -1.0 && v_hi >= -1.0)) return {};
  return {tile_of(u_lo - 1.0, columns_), std::min(tile_of(u_hi + 1.0, columns_) + 1, columns_),
          tile_of(v_lo - 1.0, rows_), std::min(tile_of(v_hi + 1.0, rows_) + 1, rows_)};
}

std::size_t IndexTiles::count(const TileWindow& w) const {
  if (w.x_begin >= w.x_end) return 0;
  std::size_t total = 0;
  for (int y = w.y_begin; y < w.y_end; ++y) {
    // The tiles of a row are contiguous.
    total += begin_[at(w.x_end, y)] - begin_[at(w.x_begin, y)];
  }
  return total;
}

std::size_t IndexTiles::bytes() const {
  return begin_.capacity() * sizeof(std::uint32_t) + depths_.capacity() * sizeof(Interval) +
         triangles_.capacity() * sizeof(std::int32_t);
}

}  // namespace selvedge::detail
