// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/unit_size.h>

#include <algorithm>
#include <cmath>

namespace selvedge::detail {
namespace {

using Points = std::array<Vec3, 4>;

/// Largest difference in a coordinate among x[begin..end).
double size_of(const Points& x, int begin, int end) {
  double size = 0.0;
  for (int i = begin; i < end; ++i)
    for (int j = i + 1; j < end; ++j) size = std::max(size, (x[i] - x[j]).cwiseAbs().maxCoeff());
  return size;
}

double primitives_size(const Points& x, int first) {
  return std::max(size_of(x, 0, first), size_of(x, first, 4));
}

/// Divides by the power of two at or below `size`.
void scale_down(double size, Points& x_t0, Points& x_t1) {
  if (size <= 0.0) return;
  const int exponent = std::ilogb(size);
  for (Points* x : {&x_t0, &x_t1})
    for (Vec3& v : *x)
      for (double& coordinate : v) coordinate = std::ldexp(coordinate, -exponent);
}

double largest_coordinate(const Points& x) {
  double most = 0.0;
  for (const Vec3& v : x) most = std::max(most, v.cwiseAbs().maxCoeff());
  return most;
}

}  // namespace

UnitSizePaths to_unit_size(const Query& query) {
  UnitSizePaths paths{query.x_t0, query.x_t1};
  // First to coordinates of about one, so that no difference overflows.
  scale_down(std::max(largest_coordinate(paths.y_t0), largest_coordinate(paths.y_t1)), paths.y_t0,
             paths.y_t1);
  for (Points* y : {&paths.y_t0, &paths.y_t1}) {
    const Vec3 last = (*y)[3];
    for (Vec3& v : *y) v -= last;
  }
  const int first = first_count(query.kind);
  double size = std::max(primitives_size(paths.y_t0, first), primitives_size(paths.y_t1, first));
  if (size == 0.0) size = std::max(largest_coordinate(paths.y_t0), largest_coordinate(paths.y_t1));
  scale_down(size, paths.y_t0, paths.y_t1);
  for (int k = 0; k < 4; ++k)
    paths.motion = std::max(paths.motion, (paths.y_t1[k] - paths.y_t0[k]).cwiseAbs().maxCoeff());
  return paths;
}

}  // namespace selvedge::detail
