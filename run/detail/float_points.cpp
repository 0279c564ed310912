// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/float_points.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace selvedge::detail {

std::vector<float> float_points(std::span<const Vec3> x, const std::filesystem::path& file) {
  std::vector<float> points;
  points.reserve(3 * x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      if (!(std::abs(x[i][axis]) <= std::numeric_limits<float>::max()))
        throw std::invalid_argument(
            fmt::format("{}: point {} is outside the range of float", file.string(), i));
      points.push_back(static_cast<float>(x[i][axis]));
    }
  return points;
}

void check_point_count(std::size_t points, std::size_t first, const std::filesystem::path& file) {
  if (points != first)
    throw std::invalid_argument(
        fmt::format("{}: a frame has {} points, but the first frame has {}; this format holds one "
                    "mesh",
                    file.string(), points, first));
  if (points > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw std::invalid_argument(
        fmt::format("{}: this format cannot hold {} points", file.string(), points));
}

}  // namespace selvedge::detail
