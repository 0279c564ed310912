// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/swept_box.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace selvedge::detail {

/// A monotone, piecewise linear map whose pieces contain about the same number of samples each. If
/// floats relative to one origin cannot distinguish the small part of a surface from a point,
/// floats of mapped numbers can: a part with half of the vertices gets half of the range, however
/// small it is. The map is monotone, so no overlap of intervals is lost (see FloatDop).
class QuantileMap {
 public:
  /// Takes any number of finite samples in any order; with fewer than two different ones the map
  /// only shifts.
  explicit QuantileMap(std::vector<double> samples = {});

  double operator()(double s) const {
    std::size_t i = 0;
    for (std::size_t half = kPieces / 2; half > 0; half /= 2)
      if (pieces_[i + half].anchor <= s) i += half;
    const Piece& p = pieces_[i];
    // A rounded difference, product and sum are each monotone; the bounds keep pieces in order.
    return std::clamp(p.base + (s - p.anchor) * p.slope, p.low, p.high);
  }

 private:
  static constexpr std::size_t kPieces = 128;  // a power of two
  struct Piece {
    double anchor, slope, base, low, high;
  };
  std::array<Piece, kPieces> pieces_;
};

/// The boxes of a few triangles (edges, if there are none), evenly chosen.
std::vector<DoubleBox> sample_boxes(const SurfaceView& surface);
/// Appends a few boxes of `list`, chosen in the same way, to `sample`.
void add_sample(std::span<const DoubleBox> list, std::vector<DoubleBox>& sample);

/// Number of boxes whose extents under the map (axis, coordinate) are at most `finest`, or so few
/// steps of a float that they can hardly be distinguished from points.
template <class Map>
int count_unresolved(std::span<const DoubleBox> sample, const Map& map, double finest = 0.0) {
  // Sixteen steps of a float: rounding enlarges boxes by an eighth.
  constexpr double kFewSteps = 0x1p-19;
  int count = 0;
  for (const DoubleBox& box : sample) {
    double extent = 0.0, mapped = 0.0, far = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double lo = map(k, box.lo[k]), hi = map(k, box.hi[k]);
      extent = std::max(extent, box.hi[k] - box.lo[k]);
      mapped = std::max(mapped, hi - lo);
      far = std::max({far, std::abs(lo), std::abs(hi)});
    }
    count += extent > 0.0 && mapped < std::max(finest, kFewSteps * far);
  }
  return count;
}
/// This many unresolved boxes of the sample justify another map. Fewer, all in one place, cost
/// little.
inline constexpr int kWorthAnotherMap = 2;

/// A map for each of the `directions`, from a sample of the vertices of one or two surfaces.
std::vector<QuantileMap> quantile_maps(std::span<const std::array<int, 3>> directions,
                                       std::span<const Vec3> a, std::span<const Vec3> b);
/// The same along the axes, from the lower corners of boxes.
std::vector<QuantileMap> quantile_maps(std::span<const std::vector<DoubleBox>* const> lists);

}  // namespace selvedge::detail
