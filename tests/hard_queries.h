// SPDX-License-Identifier: MIT
#pragma once

// Queries that are hard to decide, by category and seed, and distances in long double as an oracle
// that shares no code with the methods.

#include <selvedge/narrowphase/narrow_phase.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>
#include <string>

namespace selvedge::hard_queries {

using Random = std::mt19937_64;

inline int integer(Random& r, int lo, int hi) {
  return std::uniform_int_distribution<int>(lo, hi)(r);
}
inline double real(Random& r, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(r);
}

inline std::string text(const Query& q) {
  std::ostringstream out;
  out << std::hexfloat << (q.kind == ContactKind::edge_edge ? "edge_edge" : "point_triangle");
  for (const auto* x : {&q.x_t0, &q.x_t1})
    for (const Vec3& v : *x) out << "\n" << v.x() << ", " << v.y() << ", " << v.z();
  return out.str();
}

template <class Change>
inline void for_each_coordinate(Query& q, Change change) {
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x)
      for (int i = 0; i < 3; ++i) v[i] = change(v[i]);
}

// ---------------------------------------------------------------------------------------------
// Queries

inline ContactKind kind_of(int i) {
  return i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge;
}

inline Query integers(Random& r, ContactKind kind, int size) {
  Query q;
  q.kind = kind;
  for_each_coordinate(q, [&](double) { return integer(r, -size, size); });
  return q;
}

inline Query reals(Random& r, ContactKind kind) {
  Query q;
  q.kind = kind;
  for_each_coordinate(q, [&](double) { return real(r, -1.0, 1.0); });
  return q;
}

/// Moves the first primitive so that the primitives share a point exactly: weights are eighths and
/// coordinates are multiples of 64.
inline void make_touch(Random& r, ContactKind kind, std::array<Vec3, 4>& x) {
  for (Vec3& v : x) v *= 64.0;
  const int a = integer(r, 0, 8);
  if (kind == ContactKind::point_triangle) {
    const int b = integer(r, 0, 8 - a);
    x[0] = (a * x[1] + b * x[2] + (8 - a - b) * x[3]) / 8.0;
    return;
  }
  const int b = integer(r, 0, 8);
  const Vec3 shift = ((8 - b) * x[2] + b * x[3]) / 8.0 - ((8 - a) * x[0] + a * x[1]) / 8.0;
  x[0] += shift, x[1] += shift;
}

inline void nudge(Random& r, Query& q) {
  auto& x = integer(r, 0, 1) != 0 ? q.x_t0 : q.x_t1;
  double& c = x[integer(r, 0, 3)][integer(r, 0, 2)];
  c = c == 0.0 ? 0x1p-60 : std::nextafter(c, integer(r, 0, 1) != 0 ? 1e300 : -1e300);
}

inline void flatten(Random& r, Query& q) {
  const int a = integer(r, -2, 2), b = integer(r, -2, 2);
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x) v.z() = a * v.x() + b * v.y();
}

/// Zero length, zero area, or a triangle that degenerates to a segment.
inline void degenerate(Random& r, Query& q) {
  const int how = integer(r, 0, 2);
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    if (how == 0) (*x)[3] = (*x)[2];
    if (how == 1 && q.kind == ContactKind::edge_edge) (*x)[1] = (*x)[0];
    if (how == 1) (*x)[3] = (*x)[2];
    if (how == 2) (*x)[3] = 2.0 * (*x)[2] - (*x)[1];
  }
}

/// Edges that stay parallel to each other; for a point and a triangle, two parallel sides.
inline void parallel(Query& q) {
  for (auto* x : {&q.x_t0, &q.x_t1}) (*x)[3] = (*x)[2] + ((*x)[1] - (*x)[0]);
}

inline void touch_inside_step(Random& r, Query& q) {
  std::array<Vec3, 4> middle = q.x_t0;
  make_touch(r, q.kind, middle);
  const int before = integer(r, 1, 4), after = integer(r, 1, 4);
  for (int k = 0; k < 4; ++k) {
    const Vec3 v = q.x_t1[k] * integer(r, 0, 8);
    q.x_t0[k] = middle[k] - before * v, q.x_t1[k] = middle[k] + after * v;
  }
}

constexpr int kCategories = 14;

inline Query hard(Random& r, int category, ContactKind kind) {
  Query q = integers(r, kind, integer(r, 1, 4));
  switch (category) {
    case 0:
      return q;
    case 1:
      make_touch(r, kind, q.x_t0);
      for (Vec3& v : q.x_t1) v *= 64.0;
      return q;
    case 2:
      make_touch(r, kind, q.x_t1);
      for (Vec3& v : q.x_t0) v *= 64.0;
      return q;
    case 3:
      touch_inside_step(r, q);
      return q;
    case 4:
      touch_inside_step(r, q);
      nudge(r, q);
      return q;
    case 5:
      flatten(r, q);
      return q;
    case 6:
      degenerate(r, q);
      return q;
    case 7:
      degenerate(r, q);
      flatten(r, q);
      return q;
    case 8:  // slivers
      for (auto* x : {&q.x_t0, &q.x_t1})
        for (Vec3& v : *x) v.z() = std::ldexp(v.z(), -integer(r, 20, 60));
      return q;
    case 9:  // small and far from the origin
      for_each_coordinate(q, [&](double c) { return c * real(r, 0.001, 0.002) + 1e6; });
      return q;
    case 10:  // at rest, or in common translation
      for (int k = 0, far = integer(r, 0, 1); k < 4; ++k)
        q.x_t1[k] = q.x_t0[k] + far * Vec3(3, 1, 2);
      return q;
    case 11:
      parallel(q);
      return q;
    case 12:  // nearly coplanar
      flatten(r, q);
      nudge(r, q);
      return q;
    default:
      return reals(r, kind);
  }
}

/// Rescales a query by a power of two from 1e-100 to 1e100, which preserves the verdict.
inline Query rescaled(Random& r, Query q) {
  const double factor = std::ldexp(1.0, integer(r, -332, 332));
  for_each_coordinate(q, [&](double c) { return c * factor; });
  return q;
}

inline double time_of(const NarrowPhase& method, const Query& q) {
  double toi = 0.0;
  return method.collides(q, toi) ? toi : kNoCollision;
}

// ---------------------------------------------------------------------------------------------
// Distances

using Real = long double;
using Place = Eigen::Matrix<Real, 3, 1>;
using Places = std::array<Place, 4>;

inline Real square_to_segment(const Place& p, const Place& a, const Place& b) {
  const Place d = b - a;
  const Real dd = d.squaredNorm();
  const Real s = dd > 0 ? std::clamp<Real>((p - a).dot(d) / dd, 0, 1) : 0;
  return (p - a - s * d).squaredNorm();
}

/// Skips the candidate of the interior if it lies outside. Every candidate is a distance between
/// points of the primitives.
inline Real point_triangle_square(const Places& x) {
  Real best = square_to_segment(x[0], x[1], x[2]);
  best = std::min(best, square_to_segment(x[0], x[2], x[3]));
  best = std::min(best, square_to_segment(x[0], x[3], x[1]));
  const Place a = x[2] - x[1], b = x[3] - x[1], p = x[0] - x[1], n = a.cross(b);
  const Real nn = n.squaredNorm();
  if (!(nn > 0)) return best;
  const Real u = p.cross(b).dot(n) / nn, v = a.cross(p).dot(n) / nn;
  if (u < 0 || v < 0 || u + v > 1) return best;
  return std::min(best, (p - u * a - v * b).squaredNorm());
}

inline Real edge_edge_square(const Places& x) {
  Real best = std::min(square_to_segment(x[0], x[2], x[3]), square_to_segment(x[1], x[2], x[3]));
  best = std::min(best, square_to_segment(x[2], x[0], x[1]));
  best = std::min(best, square_to_segment(x[3], x[0], x[1]));
  const Place a = x[1] - x[0], b = x[3] - x[2], w = x[2] - x[0], n = a.cross(b);
  const Real nn = n.squaredNorm();
  if (!(nn > 0)) return best;
  const Real s = w.cross(b).dot(n) / nn, t = w.cross(a).dot(n) / nn;
  if (s < 0 || s > 1 || t < 0 || t > 1) return best;
  return std::min(best, (s * a - w - t * b).squaredNorm());
}

inline Real distance_at(const Query& q, Real t) {
  Places x;
  const Place origin = q.x_t0[0].cast<Real>();
  for (int k = 0; k < 4; ++k)
    x[k] = (1 - t) * (q.x_t0[k].cast<Real>() - origin) + t * (q.x_t1[k].cast<Real>() - origin);
  const bool edges = q.kind == ContactKind::edge_edge;
  return std::sqrt(edges ? edge_edge_square(x) : point_triangle_square(x));
}

/// The smallest distance found in [0, end], by sampling and golden-section search around the
/// minimum.
inline Real least_distance(const Query& q, Real end) {
  constexpr int kSamples = 48;
  Real least = std::numeric_limits<Real>::infinity();
  int at = 0;
  for (int i = 0; i <= kSamples; ++i) {
    const Real d = distance_at(q, end * i / kSamples);
    if (d < least) least = d, at = i;
  }
  Real lo = end * std::max(at - 1, 0) / kSamples, hi = end * std::min(at + 1, kSamples) / kSamples;
  for (int i = 0; i < 40; ++i) {
    const Real a = lo + 0.382L * (hi - lo), b = lo + 0.618L * (hi - lo);
    const Real da = distance_at(q, a), db = distance_at(q, b);
    least = std::min({least, da, db});
    (da < db ? hi : lo) = da < db ? b : a;
  }
  return least;
}

}  // namespace selvedge::hard_queries
