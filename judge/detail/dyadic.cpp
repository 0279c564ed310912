// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/dyadic.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace selvedge::judging {
namespace {

constexpr int mantissa_bits = std::numeric_limits<double>::digits;

struct Dyadic {
  std::int64_t mantissa = 0;  // odd, or 0
  int exponent = 0;
};

Dyadic split(double value) {
  if (value == 0.0) return {};
  int exponent = 0;
  const double fraction = std::frexp(value, &exponent);
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(fraction, mantissa_bits));
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
  return {mantissa / (std::int64_t{1} << zeros), exponent - mantissa_bits + zeros};
}

}  // namespace

std::vector<IntegerPoint> to_integers(std::span<const Vec3> points) {
  std::vector<std::array<Dyadic, 3>> parts(points.size());
  int lowest = std::numeric_limits<int>::max();
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      parts[i][k] = split(points[i][k]);
      if (parts[i][k].mantissa != 0) lowest = std::min(lowest, parts[i][k].exponent);
    }
  std::vector<IntegerPoint> integers(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      if (parts[i][k].mantissa == 0) continue;
      integers[i][k] = static_cast<double>(parts[i][k].mantissa);  // long may have 32 bits only
      integers[i][k] <<= static_cast<unsigned>(parts[i][k].exponent - lowest);
    }
  return integers;
}

}  // namespace selvedge::judging
