// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/triangle_crossing.h>
#include <selvedge/core/base/internal/orientation.h>

#include <algorithm>
#include <limits>

namespace selvedge::detail {

namespace {

// An axis along which the triangle projects to one with area, or -1 if there is none. The
// projection preserves all incidences of coplanar figures.
int projection_axis(const Corners& t) {
  for (int axis = 0; axis < 3; ++axis)
    if (orientation(t[0], t[1], t[2], axis) != 0) return axis;
  return -1;
}

bool same_side(int a, int b, int c) {
  return (a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0);
}
bool on_both_sides(int a, int b, int c) {
  return std::min({a, b, c}) < 0 && std::max({a, b, c}) > 0;
}

// True if p is on segment ab; the three points must be collinear in the projection.
bool within_box(const Vec3& p, const Vec3& a, const Vec3& b, int axis) {
  for (const int k : {(axis + 1) % 3, (axis + 2) % 3})
    if (p[k] < std::min(a[k], b[k]) || p[k] > std::max(a[k], b[k])) return false;
  return true;
}

bool segments_meet(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, int axis) {
  const int ap = orientation(a, b, p, axis), aq = orientation(a, b, q, axis);
  const int pa = orientation(p, q, a, axis), pb = orientation(p, q, b, axis);
  if (ap * aq < 0 && pa * pb < 0) return true;
  return (ap == 0 && within_box(p, a, b, axis)) || (aq == 0 && within_box(q, a, b, axis)) ||
         (pa == 0 && within_box(a, p, q, axis)) || (pb == 0 && within_box(b, p, q, axis));
}

bool contains(const Corners& t, const Vec3& p, int axis) {
  return !on_both_sides(orientation(t[0], t[1], p, axis), orientation(t[1], t[2], p, axis),
                        orientation(t[2], t[0], p, axis));
}

// Segment and triangle in a common plane.
bool coplanar_meet(const Vec3& p, const Vec3& q, const Corners& t, int axis) {
  if (contains(t, p, axis)) return true;
  for (int k = 0; k < 3; ++k)
    if (segments_meet(p, q, t[k], t[(k + 1) % 3], axis)) return true;
  return false;
}

// Segment pq against triangle t, which has area. side_p, side_q: sides of its ends relative to the
// plane of t.
bool segment_meets(const Vec3& p, const Vec3& q, int side_p, int side_q, const Corners& t,
                   int axis) {
  if (side_p * side_q > 0) return false;
  if (side_p == 0 && side_q == 0) return coplanar_meet(p, q, t, axis);
  return !on_both_sides(orientation(p, q, t[0], t[1]), orientation(p, q, t[1], t[2]),
                        orientation(p, q, t[2], t[0]));
}

// True if an edge of a meets b.
bool edges_meet(const Corners& a, const std::array<int, 3>& side, const Corners& b, int axis) {
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    if (segment_meets(a[k], a[next], side[k], side[next], b, axis)) return true;
  }
  return false;
}

std::array<int, 3> sides(const Corners& a, const Corners& b) {
  return {orientation(b[0], b[1], b[2], a[0]), orientation(b[0], b[1], b[2], a[1]),
          orientation(b[0], b[1], b[2], a[2])};
}

// Rounding of a difference, of three products and of their sum, with room to spare, relative to the
// sum of the absolute products.
constexpr double kRoundingShare = 16.0 * std::numeric_limits<double>::epsilon();

// Whether the points from `corner` to t[1] and t[2] are certainly on the side of `direction`.
bool ahead(const Vec3& corner, const Corners& t, const Vec3& direction) {
  for (const int k : {1, 2}) {
    const Vec3 u = t[k] - corner;
    if (!(direction.dot(u) > kRoundingShare * direction.cwiseAbs().dot(u.cwiseAbs()))) return false;
  }
  return true;
}

// Whether a plane through the common corner certainly has the triangles on different sides, as with
// neighbours of a smooth surface: no exact arithmetic is needed then.
bool corner_separates(const Corners& a, const Corners& b) {
  const Vec3 to_a = (a[1] - a[0]).normalized() + (a[2] - a[0]).normalized();
  const Vec3 to_b = (b[1] - b[0]).normalized() + (b[2] - b[0]).normalized();
  const Vec3 direction = to_a.normalized() - to_b.normalized();
  return ahead(a[0], a, direction) && ahead(a[0], b, -direction);
}

}  // namespace

bool has_no_area(const Corners& t) { return projection_axis(t) < 0; }

bool triangles_meet(const Corners& a, const Corners& b) {
  const std::array<int, 3> side_a = sides(a, b);
  if (same_side(side_a[0], side_a[1], side_a[2])) return false;
  const std::array<int, 3> side_b = sides(b, a);
  if (same_side(side_b[0], side_b[1], side_b[2])) return false;
  const int axis_a = projection_axis(a), axis_b = projection_axis(b);
  // Two triangles meet if and only if an edge of one meets the other.
  return (axis_b >= 0 && edges_meet(a, side_a, b, axis_b)) ||
         (axis_a >= 0 && edges_meet(b, side_b, a, axis_a));
}

// Beyond the common corner they meet if and only if the edge opposite the corner in one triangle
// meets the other one: their common segment starts at the corner and ends where the first triangle
// ends.
bool wedges_meet(const Corners& a, const Corners& b) {
  if (corner_separates(a, b)) return false;
  const std::array<int, 3> side_a = sides(a, b);
  if (side_a[1] * side_a[2] > 0) return false;
  const std::array<int, 3> side_b = sides(b, a);
  if (side_b[1] * side_b[2] > 0) return false;
  const int axis_a = projection_axis(a), axis_b = projection_axis(b);
  if (axis_a < 0 || axis_b < 0) return false;
  return segment_meets(a[1], a[2], side_a[1], side_a[2], b, axis_b) ||
         segment_meets(b[1], b[2], side_b[1], side_b[2], a, axis_a);
}

bool leaves_overlap(const Corners& a, const Corners& b) {
  const int axis = projection_axis(a);
  return axis >= 0 && orientation(a[0], a[1], a[2], b[2]) == 0 &&
         orientation(a[0], a[1], a[2], axis) * orientation(a[0], a[1], b[2], axis) > 0;
}

}  // namespace selvedge::detail
