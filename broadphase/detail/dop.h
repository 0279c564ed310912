// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/rigid_frame.h>
#include <selvedge/core/base/collision_types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace selvedge::detail {

/// Number of volumes that are tested together.
inline constexpr int kLanes = 8;

/// Discrete orientation polytopes [Klosowski1998]: the slabs of a body along fixed directions.
/// These are the coordinate axes (k = 6: an axis-aligned box) and additionally the diagonals of the
/// cube's corners (k = 14), of its edges (k = 18) or both (k = 26).
template <int axes>
constexpr auto dop_directions() {
  static_assert(axes == 3 || axes == 7 || axes == 9 || axes == 13);
  constexpr std::array<std::array<int, 3>, 3> coordinates{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  constexpr std::array<std::array<int, 3>, 4> corners{
      {{1, 1, 1}, {1, -1, 1}, {1, 1, -1}, {1, -1, -1}}};
  constexpr std::array<std::array<int, 3>, 6> edges{
      {{1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, -1, 0}, {1, 0, -1}, {0, 1, -1}}};
  std::array<std::array<int, 3>, axes> all{};
  int n = 0;
  for (const auto& d : coordinates) all[n++] = d;
  if constexpr (axes == 7 || axes == 13)
    for (const auto& d : corners) all[n++] = d;
  if constexpr (axes == 9 || axes == 13)
    for (const auto& d : edges) all[n++] = d;
  return all;
}

/// A closed polytope in double precision.
template <int axes>
struct SweptDop {
  std::array<double, axes> lo, hi;
};

template <int axes>
bool overlap(const SweptDop<axes>& a, const SweptDop<axes>& b) {
  bool all = true;
  for (int k = 0; k < axes; ++k) all &= (a.lo[k] <= b.hi[k]) & (b.lo[k] <= a.hi[k]);
  return all;
}

/// The slabs of all points within `path.reach` of the segment y_t0 y_t1.
///
/// Along a coordinate axis this is exactly the box of swept_box.h, whose rounding is part of the
/// definition of the pair set. Along d = (d0, d1, d2) with two or three entries ±1, the product of
/// d with a point within r of the segment lies between the smallest product of the ends minus |d|·r
/// and the largest plus |d|·r. The computed product of an end y is off by at most 2u(1 + u)·|y|₁,
/// the computed |d|·r by 2u·|d|·r, and the last difference by u of its size, u = 2⁻⁵³, in total
/// less than 8u(|y|₁ + |d|·r). This is added outwards, so that the computed slab contains the true
/// one.
template <int axes>
SweptDop<axes> swept_dop(const VertexPath& path) {
  constexpr auto directions = dop_directions<axes>();
  constexpr double kRounding = 8.0 * 0x1p-53;
  constexpr double kLengths[] = {0.0, 1.0, 1.4142135623730951, 1.7320508075688774};  // rounded up
  const Vec3 &y0 = path.y_t0, &y1 = path.y_t1;
  SweptDop<axes> dop;
  for (int k = 0; k < 3; ++k) {
    dop.lo[k] = std::min(y0[k], y1[k]) - path.reach;
    dop.hi[k] = std::max(y0[k], y1[k]) + path.reach;
  }
  if constexpr (axes > 3) {
    const double size = std::max(y0.cwiseAbs().sum(), y1.cwiseAbs().sum());
    for (int k = 3; k < axes; ++k) {
      const auto& d = directions[k];
      const double s0 = (d[0] * y0[0] + d[1] * y0[1]) + d[2] * y0[2];
      const double s1 = (d[0] * y1[0] + d[1] * y1[1]) + d[2] * y1[2];
      const double reach = kLengths[d[0] * d[0] + d[1] * d[1] + d[2] * d[2]] * path.reach;
      const double margin = reach + kRounding * (size + reach);
      dop.lo[k] = std::min(s0, s1) - margin;
      dop.hi[k] = std::max(s0, s1) + margin;
    }
  }
  return dop;
}

/// The slabs of an edge or a triangle.
template <int axes, std::size_t n>
SweptDop<axes> swept_dop(const SurfaceView& surface, const std::array<std::int32_t, n>& vertices) {
  SweptDop<axes> dop = swept_dop<axes>(path_of(surface, vertices[0]));
  for (std::size_t i = 1; i < n; ++i) {
    const SweptDop<axes> other = swept_dop<axes>(path_of(surface, vertices[i]));
    for (int k = 0; k < axes; ++k) {
      dop.lo[k] = std::min(dop.lo[k], other.lo[k]);
      dop.hi[k] = std::max(dop.hi[k], other.hi[k]);
    }
  }
  return dop;
}

/// A polytope in float, with unused numbers at the end of each array.
///
/// Why float loses nothing: along each direction d every number s of a double polytope, lower or
/// upper, goes through the same map m(s) = clamp(float(s - d·origin)), whose roundings are monotone
/// for any subtrahend, or clamp(float(q(s))) with a monotone QuantileMap q. So lo(a) <= hi(b) in
/// double implies m(lo(a)) <= m(hi(b)): no pair is lost. And m(lo(a)) < m(hi(b)) implies lo(a) <
/// hi(b): a pair whose float polytopes overlap strictly is certain, and only a pair that is equal
/// in some slab must be tested again in double.
template <int axes>
struct alignas(16) FloatDop {
  static constexpr int kNumbers = (axes + 4) / 4 * 4;
  std::array<float, kNumbers> lo, hi;
};
/// The last number of a box is unused.
using FloatBox = FloatDop<3>;

/// Eight polytopes, by direction. Unused lanes are NaN, so that they overlap nothing.
template <int axes>
struct alignas(32) DopBlock {
  float lo[axes][kLanes];
  float hi[axes][kLanes];
};

template <int axes>
constexpr FloatDop<axes> empty_dop() {
  FloatDop<axes> dop{};
  for (int k = 0; k < axes; ++k) {
    dop.lo[k] = std::numeric_limits<float>::infinity();
    dop.hi[k] = -std::numeric_limits<float>::infinity();
  }
  return dop;
}

/// Coordinates are clamped to a million kilometres so that areas stay finite in float.
inline constexpr double kFarthest = 1e12;

/// The map m.
inline float to_float(double relative) {
  return static_cast<float>(std::min(std::max(relative, -kFarthest), kFarthest));
}

/// The subtrahends of m.
template <int axes>
std::array<double, axes> along_directions(const Vec3& origin) {
  constexpr auto directions = dop_directions<axes>();
  std::array<double, axes> products;
  for (int k = 0; k < axes; ++k)
    products[k] =
        directions[k][0] * origin[0] + directions[k][1] * origin[1] + directions[k][2] * origin[2];
  return products;
}

template <int axes>
FloatDop<axes> to_float(const SweptDop<axes>& dop,
                        const std::array<double, std::size_t{axes}>& origin) {
  FloatDop<axes> out{};
  for (int k = 0; k < axes; ++k) {
    out.lo[k] = to_float(dop.lo[k] - origin[k]);
    out.hi[k] = to_float(dop.hi[k] - origin[k]);
  }
  return out;
}

/// `maps` contains one map per direction.
template <int axes>
FloatDop<axes> to_float(const SweptDop<axes>& dop, const QuantileMap* maps) {
  FloatDop<axes> out{};
  for (int k = 0; k < axes; ++k) {
    out.lo[k] = to_float(maps[k](dop.lo[k]));
    out.hi[k] = to_float(maps[k](dop.hi[k]));
  }
  return out;
}

/// The same as to_float(swept_dop<3>(path_of(surface, v)), origin): the same operations, on two
/// coordinates at a time with SSE2.
inline FloatBox float_box(const SurfaceView& surface, std::int32_t v,
                          const std::array<double, 3>& origin) {
#ifdef __SSE2__
  const double *y0 = surface.x_t0[v].data(), *y1 = surface.x_t1[v].data();
  const __m128d reach = _mm_set1_pd(surface.thickness);
  const __m128d a = _mm_loadu_pd(y0), b = _mm_loadu_pd(y1);
  const __m128d a2 = _mm_load_sd(y0 + 2), b2 = _mm_load_sd(y1 + 2);
  const __m128d lo2 = _mm_sub_pd(_mm_min_pd(a2, b2), reach);
  const __m128d hi2 = _mm_add_pd(_mm_max_pd(a2, b2), reach);
  const auto to_floats = [](__m128d relative) {
    const __m128d far = _mm_set1_pd(kFarthest);
    return _mm_cvtpd_ps(_mm_min_pd(_mm_max_pd(relative, _mm_sub_pd(_mm_setzero_pd(), far)), far));
  };
  const __m128d shift = _mm_loadu_pd(origin.data());
  const __m128 lo = to_floats(_mm_sub_pd(_mm_sub_pd(_mm_min_pd(a, b), reach), shift));
  const __m128 hi = to_floats(_mm_sub_pd(_mm_add_pd(_mm_max_pd(a, b), reach), shift));
  const __m128 last =
      to_floats(_mm_sub_pd(_mm_unpacklo_pd(lo2, hi2), _mm_set1_pd(origin[2])));  // lo, hi, 0, 0
  FloatBox box;
  _mm_store_ps(box.lo.data(), _mm_shuffle_ps(lo, last, _MM_SHUFFLE(2, 0, 1, 0)));
  _mm_store_ps(box.hi.data(), _mm_shuffle_ps(hi, last, _MM_SHUFFLE(2, 1, 1, 0)));
  return box;
#else
  return to_float(swept_dop<3>(path_of(surface, v)), origin);
#endif
}

template <int axes>
void grow(FloatDop<axes>& dop, const FloatDop<axes>& other) {
#ifdef __SSE2__
  for (int k = 0; k < FloatDop<axes>::kNumbers; k += 4) {
    float *lo = dop.lo.data() + k, *hi = dop.hi.data() + k;
    _mm_store_ps(lo, _mm_min_ps(_mm_load_ps(lo), _mm_load_ps(other.lo.data() + k)));
    _mm_store_ps(hi, _mm_max_ps(_mm_load_ps(hi), _mm_load_ps(other.hi.data() + k)));
  }
#else
  for (int k = 0; k < axes; ++k) {
    dop.lo[k] = std::min(dop.lo[k], other.lo[k]);
    dop.hi[k] = std::max(dop.hi[k], other.hi[k]);
  }
#endif
}

/// Half the surface area of the polytope's axis-aligned box.
template <int axes>
float half_area(const FloatDop<axes>& dop) {
  const float x = dop.hi[0] - dop.lo[0], y = dop.hi[1] - dop.lo[1], z = dop.hi[2] - dop.lo[2];
  return x * y + y * z + z * x;
}

template <int axes>
void set_lane(DopBlock<axes>& block, int lane, const FloatDop<axes>& dop) {
  for (int k = 0; k < axes; ++k) {
    block.lo[k][lane] = dop.lo[k];
    block.hi[k][lane] = dop.hi[k];
  }
}

/// Lanes 0 to n - 1 by box(lane), the others unused.
template <int axes, class Box>
void set_lanes(DopBlock<axes>& block, int n, Box box) {
#ifdef __SSE2__
  if constexpr (axes == 3) {
    const __m128 unused = _mm_set1_ps(std::numeric_limits<float>::quiet_NaN());
    for (int first = 0; first < kLanes; first += 4) {
      __m128 lo[4] = {unused, unused, unused, unused}, hi[4] = {unused, unused, unused, unused};
      for (int i = 0; i < 4 && first + i < n; ++i) {
        const FloatDop<axes> b = box(first + i);
        lo[i] = _mm_load_ps(b.lo.data());
        hi[i] = _mm_load_ps(b.hi.data());
      }
      _MM_TRANSPOSE4_PS(lo[0], lo[1], lo[2], lo[3]);
      _MM_TRANSPOSE4_PS(hi[0], hi[1], hi[2], hi[3]);
      for (int k = 0; k < 3; ++k) {
        _mm_store_ps(block.lo[k] + first, lo[k]);
        _mm_store_ps(block.hi[k] + first, hi[k]);
      }
    }
    return;
  }
#endif
  for (int lane = 0; lane < n; ++lane) set_lane(block, lane, box(lane));
}

template <int axes>
void clear_lanes(DopBlock<axes>& block) {
  for (int k = 0; k < axes; ++k)
    for (int lane = 0; lane < kLanes; ++lane)
      block.lo[k][lane] = block.hi[k][lane] = std::numeric_limits<float>::quiet_NaN();
}

/// The box of one lane.
template <int axes>
FloatBox lane_box(const DopBlock<axes>& block, int lane) {
  return {{block.lo[0][lane], block.lo[1][lane], block.lo[2][lane], 0.0f},
          {block.hi[0][lane], block.hi[1][lane], block.hi[2][lane], 0.0f}};
}

}  // namespace selvedge::detail
