// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/triangle_meetings.h>

#include <gmpxx.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace selvedge::judging {
namespace {

// ---- Crossing: rational arithmetic throughout. Only pairs that meet get here.

using RationalPoint = std::array<mpq_class, 3>;
using RationalTriangle = std::array<RationalPoint, 3>;

RationalPoint operator-(const RationalPoint& a, const RationalPoint& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

RationalPoint cross(const RationalPoint& a, const RationalPoint& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

mpq_class dot(const RationalPoint& a, const RationalPoint& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

bool is_zero(const RationalPoint& a) { return a[0] == 0 && a[1] == 0 && a[2] == 0; }

RationalTriangle rational(const TrianglePoints& t) {
  RationalTriangle r;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) r[i][k] = mpq_class(t[i][k]);
  return r;
}

RationalPoint normal_of(const RationalTriangle& t) { return cross(t[1] - t[0], t[2] - t[0]); }

/// An open range of numbers; empty if it has no low end below its high end.
struct OpenRange {
  mpq_class low, high;
};

OpenRange range_of(const std::vector<mpq_class>& values) {
  return {*std::min_element(values.begin(), values.end()),
          *std::max_element(values.begin(), values.end())};
}

bool overlap(const OpenRange& a, const OpenRange& b) { return a.low < b.high && b.low < a.high; }

/// Projections of both triangles to `direction`.
bool overlap_along(const RationalPoint& direction, const RationalTriangle& a,
                   const RationalTriangle& b) {
  std::vector<mpq_class> of_a, of_b;
  for (int i = 0; i < 3; ++i) {
    of_a.push_back(dot(direction, a[i]));
    of_b.push_back(dot(direction, b[i]));
  }
  return overlap(range_of(of_a), range_of(of_b));
}

/// Convex polygons of one plane have disjoint insides if and only if the line of an edge separates
/// them.
bool coplanar_insides_meet(const RationalTriangle& a, const RationalTriangle& b,
                           const RationalPoint& normal) {
  for (const RationalTriangle* t : {&a, &b})
    for (int i = 0; i < 3; ++i)
      if (!overlap_along(cross(normal, (*t)[(i + 1) % 3] - (*t)[i]), a, b)) return false;
  return true;
}

/// The part of the inside of t in the plane through `at`, along `direction`, which spans the common
/// line of both planes. Empty if the plane does not pass through the inside.
std::optional<OpenRange> cut(const RationalTriangle& t, const RationalPoint& normal,
                             const RationalPoint& at, const RationalPoint& direction) {
  std::array<mpq_class, 3> height;
  for (int i = 0; i < 3; ++i) height[i] = dot(normal, t[i] - at);
  if (*std::min_element(height.begin(), height.end()) >= 0 ||
      *std::max_element(height.begin(), height.end()) <= 0)
    return std::nullopt;
  std::vector<mpq_class> ends;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const mpq_class here = dot(direction, t[i]), there = dot(direction, t[j]);
    if (height[i] == 0) ends.push_back(here);
    if (sgn(height[i]) * sgn(height[j]) < 0)
      ends.push_back(here + (there - here) * height[i] / (height[i] - height[j]));
  }
  return range_of(ends);
}

bool insides_meet(const RationalTriangle& a, const RationalPoint& normal_a,
                  const RationalTriangle& b, const RationalPoint& normal_b) {
  const RationalPoint direction = cross(normal_a, normal_b);
  if (is_zero(direction))
    return dot(normal_a, b[0] - a[0]) == 0 && coplanar_insides_meet(a, b, normal_a);
  const auto in_a = cut(a, normal_b, b[0], direction), in_b = cut(b, normal_a, a[0], direction);
  return in_a && in_b && overlap(*in_a, *in_b);
}

/// Whether the inside of a segment passes through the inside of a triangle, from one side of it to
/// the other. The segment is the hull of three points on a line.
bool segment_passes(const RationalTriangle& segment, const RationalTriangle& t,
                    const RationalPoint& normal) {
  std::array<mpq_class, 3> height;
  for (int i = 0; i < 3; ++i) height[i] = dot(normal, segment[i] - t[0]);
  const auto low = std::min_element(height.begin(), height.end()) - height.begin();
  const auto high = std::max_element(height.begin(), height.end()) - height.begin();
  if (height[low] >= 0 || height[high] <= 0) return false;
  const mpq_class s = height[low] / (height[low] - height[high]);
  RationalPoint p;
  for (int k = 0; k < 3; ++k) p[k] = segment[low][k] + s * (segment[high][k] - segment[low][k]);
  for (int i = 0; i < 3; ++i)
    if (dot(cross(normal, t[(i + 1) % 3] - t[i]), p - t[i]) <= 0) return false;
  return true;
}

// ---- Signs that show that triangles which meet do not cross

/// The first coordinate that can be dropped without making the corners collinear, or -1.
int projection_of(const TrianglePoints& t) {
  for (int k = 0; k < 3; ++k)
    if (orient2d(t[0], t[1], t[2], k) != 0) return k;
  return -1;
}

/// In one plane, without coordinate k: whether all points are beyond the line of an edge of t, or
/// on it.
bool an_edge_has_beyond(const TrianglePoints& t, std::span<const Vec3> points, int k) {
  const int inside = orient2d(t[0], t[1], t[2], k);
  for (int i = 0; i < 3; ++i) {
    const auto is_beyond = [&](const Vec3& x) {
      return orient2d(t[i], t[(i + 1) % 3], x, k) * inside <= 0;
    };
    if (std::all_of(points.begin(), points.end(), is_beyond)) return true;
  }
  return false;
}

/// True for triangles that only touch, with area, if one lies on one side of the other or if the
/// line of an edge separates them in one plane. False proves nothing.
bool evidently_uncrossed(const TrianglePoints& a, const TrianglePoints& b) {
  const int k = projection_of(a);
  if (k < 0 || projection_of(b) < 0) return false;
  int low = 0, high = 0;
  for (const Vec3& x : b) {
    const int side = orient3d(a[0], a[1], a[2], x);
    low = std::min(low, side);
    high = std::max(high, side);
  }
  if (low == 0 && high == 0) return an_edge_has_beyond(a, b, k) || an_edge_has_beyond(b, a, k);
  return low == 0 || high == 0;
}

// ---- Neighbours

constexpr double kUnitRoundoff = 0x1p-53;

/// How far along `direction` a corner is ahead of another one, and a bound of the rounding error:
/// each term is rounded twice and passes through two additions, so that 8 u is ample (see
/// separated_along). Underflow adds at most 3·2^-1075.
bool certainly_ahead(const Vec3& direction, const Vec3& from, const Vec3& to) {
  constexpr double kBound = 8.0 * kUnitRoundoff, kUnderflow = 0x1p-1070;
  const double t0 = direction[0] * (to[0] - from[0]);
  const double t1 = direction[1] * (to[1] - from[1]);
  const double t2 = direction[2] * (to[2] - from[2]);
  const double size = std::abs(t0) + std::abs(t1) + std::abs(t2);
  return std::isfinite(size) && t0 + t1 + t2 > kBound * size + kUnderflow;
}

/// A plane through the common corner s[0] = t[0] with one triangle on each side. Proves almost all
/// neighbours of a surface apart.
bool corner_separates(const Vec3& direction, const TrianglePoints& s, const TrianglePoints& t) {
  return certainly_ahead(direction, s[0], s[1]) && certainly_ahead(direction, s[0], s[2]) &&
         certainly_ahead(direction, t[1], t[0]) && certainly_ahead(direction, t[2], t[0]);
}

bool evidently_apart_at_corner(const TrianglePoints& s, const TrianglePoints& t) {
  if (corner_separates((s[1] + s[2]) - (t[1] + t[2]), s, t)) return true;
  const Vec3 to_s = (s[1] - s[0]).normalized() + (s[2] - s[0]).normalized();
  const Vec3 to_t = (t[1] - t[0]).normalized() + (t[2] - t[0]).normalized();
  return corner_separates(to_s.normalized() - to_t.normalized(), s, t);
}

/// The corners at the common edge s[0] = t[0], s[1] = t[1] are on different sides of it in a
/// projection along an axis. Both triangles then lie on different sides of a plane that contains
/// the edge, and meet it in the edge alone.
bool evidently_apart_at_edge(const TrianglePoints& s, const TrianglePoints& t) {
  const Vec3 normal = (s[1] - s[0]).cross(s[2] - s[0]);
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return orient2d(s[0], s[1], s[2], axis) * orient2d(s[0], s[1], t[2], axis) < 0;
}

/// Moves equal corners of both triangles to the front, in the same order. Returns their number.
template <class Corners>
int bring_equal_to_front(Corners& a, Corners& b) {
  int equal = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = equal; j < 3; ++j)
      if (a[i] == b[j]) {
        std::swap(a[i], a[equal]);
        std::swap(b[j], b[equal++]);
        break;
      }
  return equal;
}

/// For triangles whose equal corners come first: whether these are evidently all they have in
/// common. False proves nothing.
bool evidently_apart_beyond(int equal, const TrianglePoints& a, const TrianglePoints& b) {
  if (equal == 1) return evidently_apart_at_corner(a, b);
  return equal == 2 && evidently_apart_at_edge(a, b);
}

/// True for most triangles that lie beside each other in a surface whose triangles each have
/// vertices of their own. False proves nothing.
bool evidently_abut(TrianglePoints a, TrianglePoints b) {
  return evidently_apart_beyond(bring_equal_to_front(a, b), a, b);
}

bool has(const Triangle& t, std::int32_t v) { return v == t[0] || v == t[1] || v == t[2]; }

/// Whether a corner or an edge of s meets t, with which it has no common vertex.
bool primitives_meet(std::span<const Vec3> x, const Triangle& s, const Triangle& t) {
  const TrianglePoints of_t{x[t[0]], x[t[1]], x[t[2]]};
  for (int i = 0; i < 3; ++i) {
    const std::int32_t a = s[i], b = s[(i + 1) % 3];
    if (has(t, a)) continue;
    if (judging::segment_meets_triangle(x[a], x[has(t, b) ? a : b], of_t)) return true;
  }
  return false;
}

/// Whether two edges without a common vertex meet, one of each triangle.
bool edges_meet(std::span<const Vec3> x, const Triangle& s, const Triangle& t) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const std::int32_t a = s[i], b = s[(i + 1) % 3], c = t[j], d = t[(j + 1) % 3];
      if (a != c && a != d && b != c && b != d && segments_meet(x[a], x[b], x[c], x[d]))
        return true;
    }
  return false;
}

}  // namespace

bool triangles_cross(const TrianglePoints& a, const TrianglePoints& b) {
  if (evidently_uncrossed(a, b)) return false;
  const RationalTriangle of_a = rational(a), of_b = rational(b);
  const RationalPoint normal_a = normal_of(of_a), normal_b = normal_of(of_b);
  const bool flat_a = is_zero(normal_a), flat_b = is_zero(normal_b);
  if (flat_a && flat_b) return false;
  if (flat_a) return segment_passes(of_a, of_b, normal_b);
  if (flat_b) return segment_passes(of_b, of_a, normal_a);
  return insides_meet(of_a, normal_a, of_b, normal_b);
}

int leaning_side(const TrianglePoints& t, const Vec3& v, const Vec3& w, const Vec3& apex) {
  if (orient3d(t[0], t[1], t[2], v) != 0 || orient3d(t[0], t[1], t[2], w) != 0) return 0;
  const int side = orient3d(t[0], t[1], t[2], apex);
  const int k = side == 0 ? -1 : projection_of(t);
  if (k < 0) return 0;
  std::array<int, 3> of_line;
  for (int i = 0; i < 3; ++i) of_line[i] = orient2d(v, w, t[i], k);
  const auto [least, most] = std::minmax_element(of_line.begin(), of_line.end());
  if (*least >= 0 || *most <= 0) return 0;
  const std::array<Vec3, 2> edge{v, w};
  return an_edge_has_beyond(t, edge, k) ? 0 : side;
}

Meeting meeting_of(const TrianglePoints& a, const TrianglePoints& b) {
  if (evidently_abut(a, b)) return Meeting::abut;
  if (!triangles_meet(a, b)) return Meeting::apart;
  return triangles_cross(a, b) ? Meeting::cross : Meeting::touch;
}

Meeting meeting_of_neighbours(std::span<const Vec3> x, const Triangle& s, const Triangle& t) {
  Triangle a = s, b = t;
  const int common = bring_equal_to_front(a, b);
  const TrianglePoints of_a{x[a[0]], x[a[1]], x[a[2]]}, of_b{x[b[0]], x[b[1]], x[b[2]]};
  if (evidently_apart_beyond(common, of_a, of_b)) return Meeting::apart;
  // Triangles with three common vertices have no primitives without a common one.
  const bool meet = common == 3 || primitives_meet(x, s, t) || primitives_meet(x, t, s) ||
                    (common == 2 && edges_meet(x, s, t));
  if (!meet) return Meeting::apart;
  if (triangles_cross(of_a, of_b)) return Meeting::cross;
  return common == 3 ? Meeting::apart : Meeting::touch;
}

}  // namespace selvedge::judging
