// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/exact_predicates.h>

#include <selvedge/judge/detail/dyadic.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace selvedge::judging {
namespace {

// Half the distance from 1 to the next double. It bounds the relative error of one rounded
// operation, as long as nothing underflows.
constexpr double unit_roundoff = 0x1p-53;
// [Shewchuk1997] stage A of ORIENT3D and ORIENT2D: bounds relative to the permanent.
constexpr double orient3d_bound = (7.0 + 56.0 * unit_roundoff) * unit_roundoff;
constexpr double orient2d_bound = (3.0 + 16.0 * unit_roundoff) * unit_roundoff;
// Shewchuk excludes underflow. A product that underflows adds an error of at most 2^-1075. In 3D,
// each of three terms multiplies two such products by a difference of at most `largest_height` =
// 2^300 and forms one more product: 3 (2·2^-1075·2^300 + 2^-1075) < 2^-770. In 2D, two products are
// formed: 2^-1074. Overflow yields infinities or NaNs, for which the comparisons below leave the
// case undecided.
constexpr double largest_height = 0x1p300;
constexpr double orient3d_underflow = 0x1p-770;
constexpr double orient2d_underflow = 0x1p-1070;

int sign_of(const mpz_class& value) { return sgn(value); }
int sign_of(double value) { return (value > 0.0) - (value < 0.0); }

int orient3d_exactly(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<Vec3, 4> points{a, b, c, d};
  auto p = to_integers(points);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) p[i][k] -= p[3][k];
  const mpz_class det = p[0][2] * (p[1][0] * p[2][1] - p[2][0] * p[1][1]) +
                        p[1][2] * (p[2][0] * p[0][1] - p[0][0] * p[2][1]) +
                        p[2][2] * (p[0][0] * p[1][1] - p[1][0] * p[0][1]);
  return sign_of(det);
}

int orient2d_exactly(const Vec3& a, const Vec3& b, const Vec3& c, int dropped) {
  const std::array<Vec3, 3> points{a, b, c};
  const auto p = to_integers(points);
  const int u = (dropped + 1) % 3, v = (dropped + 2) % 3;
  const mpz_class det =
      (p[0][u] - p[2][u]) * (p[1][v] - p[2][v]) - (p[0][v] - p[2][v]) * (p[1][u] - p[2][u]);
  return sign_of(det);
}

// Range of the values of a linear function, widened by the rounding error of its computation.
struct Range {
  double low, high;
  bool finite;
};

// Each term d_k (x_k - o_k) is rounded twice and passes through at most two additions; the result
// passes through two more operations (val ± err). The error is therefore at most (1+u)^6 - 1 < 8 u
// times the sum of the terms' magnitudes. That sum is itself accurate to a few u, for which the
// factor 8 leaves room. Underflow adds at most 3·2^-1075.
constexpr double projection_bound = 8.0 * unit_roundoff;
constexpr double projection_underflow = 0x1p-1070;

Range project(const Vec3& direction, const Vec3& origin, std::span<const Vec3> points) {
  Range range{INFINITY, -INFINITY, true};
  double total = 0.0;
  for (const Vec3& x : points) {
    const double t0 = direction[0] * (x[0] - origin[0]);
    const double t1 = direction[1] * (x[1] - origin[1]);
    const double t2 = direction[2] * (x[2] - origin[2]);
    const double size = std::abs(t0) + std::abs(t1) + std::abs(t2);
    const double value = t0 + t1 + t2;
    const double error = projection_bound * size + projection_underflow;
    range.low = std::min(range.low, value - error);
    range.high = std::max(range.high, value + error);
    total += size;
  }
  range.finite = std::isfinite(total);
  return range;
}

// The first coordinate that can be dropped without making the projected corners collinear, or -1 if
// the corners themselves are collinear.
int droppable(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int k = 0; k < 3; ++k)
    if (orient2d(a, b, c, k) != 0) return k;
  return -1;
}

// True if the closed boxes of the two segments overlap or touch.
bool boxes_meet(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  for (int k = 0; k < 3; ++k)
    if (std::max(p[k], q[k]) < std::min(r[k], s[k]) || std::max(r[k], s[k]) < std::min(p[k], q[k]))
      return false;
  return true;
}

// For coplanar segments whose boxes meet; dropping coordinate `k` must not collapse their plane to
// a line. Each segment must straddle or touch the line of the other. For four collinear points, the
// box test has already decided.
bool coplanar_segments_meet(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s, int k) {
  return orient2d(p, q, r, k) * orient2d(p, q, s, k) <= 0 &&
         orient2d(r, s, p, k) * orient2d(r, s, q, k) <= 0;
}

bool coplanar_point_in_triangle(const Vec3& p, const TrianglePoints& t, int k) {
  const int s0 = orient2d(t[0], t[1], p, k);
  const int s1 = orient2d(t[1], t[2], p, k);
  const int s2 = orient2d(t[2], t[0], p, k);
  return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
}

bool segment_meets_an_edge(const Vec3& p, const Vec3& q, const TrianglePoints& t) {
  return segments_meet(p, q, t[0], t[1]) || segments_meet(p, q, t[1], t[2]) ||
         segments_meet(p, q, t[2], t[0]);
}

// p_side and q_side are the signs of orient3d of the triangle with p and with q.
bool segment_meets_triangle(const Vec3& p, const Vec3& q, const TrianglePoints& t, int p_side,
                            int q_side) {
  if (p_side * q_side > 0) return false;
  if (p_side == 0 && q_side == 0) {
    const int k = droppable(t[0], t[1], t[2]);
    if (k >= 0 && coplanar_point_in_triangle(p, t, k)) return true;
    return segment_meets_an_edge(p, q, t);
  }
  // The line p q crosses the plane in one point, which lies in the segment. The volumes that p q
  // spans with the three edges are the barycentric coordinates of this point up to a common factor.
  const int s0 = orient3d(p, q, t[0], t[1]);
  const int s1 = orient3d(p, q, t[1], t[2]);
  const int s2 = orient3d(p, q, t[2], t[0]);
  return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
}

bool any_edge_meets(const TrianglePoints& edges, const TrianglePoints& t,
                    const std::array<int, 3>& side) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (segment_meets_triangle(edges[i], edges[j], t, side[i], side[j])) return true;
  }
  return false;
}

bool strictly_on_one_side(const std::array<int, 3>& side) {
  return (side[0] > 0 && side[1] > 0 && side[2] > 0) || (side[0] < 0 && side[1] < 0 && side[2] < 0);
}

bool separated_either_way(const Vec3& direction, const TrianglePoints& a, const TrianglePoints& b) {
  return separated_along(direction, a, b) || separated_along(direction, b, a);
}

// Cheap test that proves almost all disjoint triangles disjoint. It tries the normals of both
// triangles as separating directions and then, for (nearly) coplanar triangles, the in-plane
// normals of the six edges.
bool evidently_apart(const TrianglePoints& a, const TrianglePoints& b) {
  const std::array<const TrianglePoints*, 2> both{&a, &b};
  std::array<Vec3, 2> normal;
  for (int i = 0; i < 2; ++i) {
    const TrianglePoints& t = *both[i];
    normal[i] = (t[1] - t[0]).cross(t[2] - t[0]);
    if (separated_either_way(normal[i], a, b)) return true;
  }
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 3; ++k) {
      const Vec3 edge = (*both[i])[(k + 1) % 3] - (*both[i])[k];
      if (separated_either_way(normal[i].cross(edge), a, b)) return true;
    }
  return false;
}

}  // namespace

// J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", Discrete & Computational Geometry 18, 1997.
int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double adx = a[0] - d[0], ady = a[1] - d[1], adz = a[2] - d[2];
  const double bdx = b[0] - d[0], bdy = b[1] - d[1], bdz = b[2] - d[2];
  const double cdx = c[0] - d[0], cdy = c[1] - d[1], cdz = c[2] - d[2];
  const double bc = bdx * cdy, cb = cdx * bdy;
  const double ca = cdx * ady, ac = adx * cdy;
  const double ab = adx * bdy, ba = bdx * ady;
  const double det = adz * (bc - cb) + bdz * (ca - ac) + cdz * (ab - ba);
  const double height_a = std::abs(adz), height_b = std::abs(bdz), height_c = std::abs(cdz);
  const double permanent = (std::abs(bc) + std::abs(cb)) * height_a +
                           (std::abs(ca) + std::abs(ac)) * height_b +
                           (std::abs(ab) + std::abs(ba)) * height_c;
  const double bound = orient3d_bound * permanent + orient3d_underflow;
  if (height_a <= largest_height && height_b <= largest_height && height_c <= largest_height &&
      (det > bound || -det > bound))
    return sign_of(det);
  // A floating-point difference is 0 only if the numbers are equal. Two points are then the same,
  // or all four lie in a plane perpendicular to an axis.
  const auto is_zero = [](double x, double y, double z) {
    return x == 0.0 && y == 0.0 && z == 0.0;
  };
  if (is_zero(adx, ady, adz) || is_zero(bdx, bdy, bdz) || is_zero(cdx, cdy, cdz)) return 0;
  if ((adx == 0.0 && bdx == 0.0 && cdx == 0.0) || (ady == 0.0 && bdy == 0.0 && cdy == 0.0) ||
      (adz == 0.0 && bdz == 0.0 && cdz == 0.0))
    return 0;
  return orient3d_exactly(a, b, c, d);
}

int orient2d(const Vec3& a, const Vec3& b, const Vec3& c, int dropped) {
  const int u = (dropped + 1) % 3, v = (dropped + 2) % 3;
  const double acu = a[u] - c[u], acv = a[v] - c[v], bcu = b[u] - c[u], bcv = b[v] - c[v];
  const double left = acu * bcv, right = acv * bcu;
  const double det = left - right;
  const double bound = orient2d_bound * (std::abs(left) + std::abs(right)) + orient2d_underflow;
  if (det > bound || -det > bound) return sign_of(det);
  if ((acu == 0.0 || bcv == 0.0) && (acv == 0.0 || bcu == 0.0)) return 0;
  return orient2d_exactly(a, b, c, dropped);
}

bool segments_meet(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  if (!boxes_meet(p, q, r, s) || orient3d(p, q, r, s) != 0) return false;
  const std::array<std::array<const Vec3*, 3>, 4> triples{
      {{&p, &q, &r}, {&p, &q, &s}, {&p, &r, &s}, {&q, &r, &s}}};
  for (const auto& t : triples)
    if (const int k = droppable(*t[0], *t[1], *t[2]); k >= 0)
      return coplanar_segments_meet(p, q, r, s, k);
  // All four points are collinear. Every coordinate is monotone along the line, so the box test has
  // already decided.
  return true;
}

bool separated_along(const Vec3& direction, std::span<const Vec3> below,
                     std::span<const Vec3> above) {
  const Range low = project(direction, below[0], below);
  const Range high = project(direction, below[0], above);
  return low.finite && high.finite && high.low > low.high;
}

bool segment_meets_triangle(const Vec3& p, const Vec3& q, const TrianglePoints& t) {
  return segment_meets_triangle(p, q, t, orient3d(t[0], t[1], t[2], p),
                                orient3d(t[0], t[1], t[2], q));
}

bool triangles_meet(const TrianglePoints& a, const TrianglePoints& b) {
  if (evidently_apart(a, b)) return false;
  std::array<int, 3> b_side, a_side;
  for (int i = 0; i < 3; ++i) b_side[i] = orient3d(a[0], a[1], a[2], b[i]);
  if (strictly_on_one_side(b_side)) return false;
  for (int i = 0; i < 3; ++i) a_side[i] = orient3d(b[0], b[1], b[2], a[i]);
  if (strictly_on_one_side(a_side)) return false;
  // Two triangles meet if and only if an edge of one meets the other triangle. This includes a
  // triangle that lies inside another one in the same plane.
  return any_edge_meets(b, a, b_side) || any_edge_meets(a, b, a_side);
}

}  // namespace selvedge::judging
