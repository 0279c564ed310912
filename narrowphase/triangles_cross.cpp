// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/orientation.h>
#include <selvedge/narrowphase/internal/triangles_cross.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge {
namespace {

using Corners = std::array<Vec3, 3>;
using Sides = std::array<int, 3>;  // of the corners of a triangle, relative to a plane

Sides sides_of_plane(const Corners& t, const Corners& plane) {
  Sides side;
  for (int i = 0; i < 3; ++i) side[i] = orientation(plane[0], plane[1], plane[2], t[i]);
  return side;
}

bool passes_through(const Sides& side) {
  return *std::min_element(side.begin(), side.end()) < 0 &&
         *std::max_element(side.begin(), side.end()) > 0;
}

/// Whether the line of an edge of `a` has the inside of `b` on the other side than that of `a`.
bool an_edge_separates(const Corners& a, const Corners& b, int axis) {
  const int inside = orientation(a[0], a[1], a[2], axis);
  for (int i = 0; i < 3; ++i) {
    const Vec3 &p = a[i], &q = a[(i + 1) % 3];
    if (std::all_of(b.begin(), b.end(),
                    [&](const Vec3& x) { return orientation(p, q, x, axis) * inside <= 0; }))
      return true;
  }
  return false;
}

/// Convex figures of one plane have disjoint insides if and only if the line of an edge separates
/// them.
bool coplanar_insides_meet(const Corners& a, const Corners& b) {
  int axis = 0;
  while (orientation(a[0], a[1], a[2], axis) == 0) ++axis;
  return !an_edge_separates(a, b, axis) && !an_edge_separates(b, a, axis);
}

/// Turns the triangle so that its first corner is alone on its side; the others are on the other
/// side or in the plane. Returns that side.
int put_lone_corner_first(Corners& t, Sides side) {
  for (int turn = 0; turn < 3; ++turn) {
    if (side[0] != 0 && side[0] * side[1] <= 0 && side[0] * side[2] <= 0) break;
    std::rotate(t.begin(), t.begin() + 1, t.end());
    std::rotate(side.begin(), side.begin() + 1, side.end());
  }
  return side[0];
}

/// Both insides cut the common line of the planes in open ranges. The ends of a range lie on the
/// edges at the lone corner, so orientations of pairs of edges order the ends.
/// P. Guigue, O. Devillers, "Fast and robust triangle-triangle overlap test using orientation
/// predicates", Journal of Graphics Tools 8(1), 2003; here with open ranges, so that strict signs
/// replace theirs.
bool insides_meet_on_line(Corners a, const Sides& side_a, Corners b, const Sides& side_b) {
  const int lone_a = put_lone_corner_first(a, side_a), lone_b = put_lone_corner_first(b, side_b);
  if (lone_a < 0) std::swap(b[1], b[2]);
  if (lone_b < 0) std::swap(a[1], a[2]);
  return orientation(a[0], a[1], b[0], b[1]) < 0 && orientation(a[0], a[2], b[2], b[0]) < 0;
}

bool segment_passes_through(const Corners& segment, const Corners& t) {
  const Sides side = sides_of_plane(segment, t);
  if (!passes_through(side)) return false;
  const Vec3& p = segment[std::min_element(side.begin(), side.end()) - side.begin()];
  const Vec3& q = segment[std::max_element(side.begin(), side.end()) - side.begin()];
  const int turn = orientation(p, q, t[0], t[1]);
  return turn != 0 && orientation(p, q, t[1], t[2]) == turn &&
         orientation(p, q, t[2], t[0]) == turn;
}

}  // namespace

bool has_area(const std::array<Vec3, 3>& t) {
  for (int axis = 0; axis < 3; ++axis)
    if (orientation(t[0], t[1], t[2], axis) != 0) return true;
  return false;
}

bool triangles_cross(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  const bool flat_a = !has_area(a), flat_b = !has_area(b);
  if (flat_a) return !flat_b && segment_passes_through(a, b);
  if (flat_b) return segment_passes_through(b, a);
  const Sides side_b = sides_of_plane(b, a);
  if (side_b == Sides{0, 0, 0}) return coplanar_insides_meet(a, b);
  if (!passes_through(side_b)) return false;
  const Sides side_a = sides_of_plane(a, b);
  return passes_through(side_a) && insides_meet_on_line(a, side_a, b, side_b);
}

int side_of_leaf(const std::array<Vec3, 3>& t, const Vec3& v, const Vec3& w, const Vec3& apex) {
  if (orientation(t[0], t[1], t[2], v) != 0 || orientation(t[0], t[1], t[2], w) != 0) return 0;
  const int side = orientation(t[0], t[1], t[2], apex);
  if (side == 0) return 0;
  int axis = 0;
  while (orientation(t[0], t[1], t[2], axis) == 0) ++axis;
  // In one plane: the insides of an edge and a triangle are disjoint if and only if the line of the
  // edge or of one of the triangle's separates them.
  if (!passes_through({orientation(v, w, t[0], axis), orientation(v, w, t[1], axis),
                       orientation(v, w, t[2], axis)}))
    return 0;
  const int inside = orientation(t[0], t[1], t[2], axis);
  for (int i = 0; i < 3; ++i) {
    const Vec3 &p = t[i], &q = t[(i + 1) % 3];
    if (orientation(p, q, v, axis) * inside <= 0 && orientation(p, q, w, axis) * inside <= 0)
      return 0;
  }
  return side;
}

// The corners a and b are on different sides of the edge in a projection along an axis. The
// triangles then lie on different sides of the plane through the edge along this axis, and have no
// other point in it.
bool evidently_open_at_edge(const Vec3& v, const Vec3& w, const Vec3& a, const Vec3& b) {
  // [Shewchuk1997] stage A of the orientation in the plane, and products that underflow.
  constexpr double kBound = 4.0 * 0x1p-53, kUnderflow = 0x1p-1070;
  const Vec3 edge = w - v, to_a = a - v, to_b = b - v;
  int axis = 0;
  edge.cross(to_a).cwiseAbs().maxCoeff(&axis);
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const double la = edge[i] * to_a[j], ra = edge[j] * to_a[i];
  const double lb = edge[i] * to_b[j], rb = edge[j] * to_b[i];
  const double da = la - ra, db = lb - rb;
  const double error_a = kBound * (std::abs(la) + std::abs(ra)) + kUnderflow;
  const double error_b = kBound * (std::abs(lb) + std::abs(rb)) + kUnderflow;
  return (da > error_a && -db > error_b) || (-da > error_a && db > error_b);
}

}  // namespace selvedge
