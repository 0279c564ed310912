// SPDX-License-Identifier: MIT
#include "ccd_queries.h"

#include <selvedge/judge/judge.h>
#include <selvedge/narrowphase/detail/rational.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

namespace selvedge::ccd_queries {

int integer(Random& r, int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(r); }

double real(Random& r, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(r);
}

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

bool chance(Random& r, int one_in) { return integer(r, 1, one_in) == 1; }
double sign(Random& r) { return chance(r, 2) ? 1.0 : -1.0; }

Vec3 integers(Random& r, int size) {
  return Vec3(integer(r, -size, size), integer(r, -size, size), integer(r, -size, size));
}

Vec3 reals(Random& r, double size) {
  return Vec3(real(r, -size, size), real(r, -size, size), real(r, -size, size));
}

template <class Change>
void change_all(Query& q, const Change& change) {
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x) change(v);
}

void scale(Query& q, int exponent) {
  change_all(q, [&](Vec3& v) {
    for (int i = 0; i < 3; ++i) v[i] = std::ldexp(v[i], exponent);
  });
}

// -------------------------------------------------------------------------------------------------
// Building blocks

/// Makes the primitives touch in x: weights in eighths, so that integers stay exact when x are
/// multiples of 8.
void make_touch(Random& r, ContactKind kind, std::array<Vec3, 4>& x) {
  for (Vec3& v : x) v *= 64.0;
  if (kind == ContactKind::point_triangle) {
    const int a = integer(r, 0, 8), b = integer(r, 0, 8 - a);
    x[0] = (a * x[1] + b * x[2] + (8 - a - b) * x[3]) / 8.0;
  } else {
    const int s = integer(r, 0, 8), t = integer(r, 0, 8);
    const Vec3 place = ((8 - s) * x[0] + s * x[1]) / 8.0;
    const Vec3 v = x[3] - x[2];
    x[2] = place - t * v / 8.0;
    x[3] = x[2] + v;
  }
}

/// All vertices in one plane that does not move, not parallel to an axis.
void flatten(Random& r, Query& q) {
  const int a = integer(r, -2, 2), b = integer(r, -2, 2);
  change_all(q, [&](Vec3& v) { v.z() = a * v.x() + b * v.y(); });
}

void degenerate(Random& r, Query& q) {
  const bool edges = q.kind == ContactKind::edge_edge;
  const int from = edges ? 0 : integer(r, 1, 2);
  const int to = edges ? 1 : 3;
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    if (edges || chance(r, 2)) {
      (*x)[to] = (*x)[from];
    } else {
      (*x)[3] = 2.0 * (*x)[2] - (*x)[1];
    }
  }
}

/// A vector at the start and at the end of the step.
using Moving = std::array<Vec3, 2>;

Moving at_rest(const Vec3& v) { return {v, v}; }

/// Two sides X, Y and a gap Z at both ends. The primitives touch when Z = s X + r Y, where s and r
/// are the weights: s, r, 1 - s - r >= 0 for a point and a triangle, 0 <= s, r <= 1 for edges.
struct Frame {
  Moving base{Vec3(0, 0, 0), Vec3(0, 0, 0)}, X, Y, Z;
};

Query assemble(ContactKind kind, const Frame& f) {
  Query q;
  q.kind = kind;
  for (int e = 0; e < 2; ++e) {
    auto& x = e == 0 ? q.x_t0 : q.x_t1;
    const Vec3& base = f.base[e];
    if (kind == ContactKind::point_triangle) {
      x = {base + f.Z[e], base, base + f.X[e], base + f.Y[e]};
    } else {
      x = {base, base + f.X[e], base + f.Z[e], base + f.Z[e] - f.Y[e]};
    }
  }
  return q;
}

/// Weights of a contact in eighths; every second time at the rim of a primitive, now and then
/// beyond it.
std::array<int, 2> weights(Random& r, ContactKind kind) {
  std::array<int, 2> w{integer(r, 0, 8), integer(r, 0, 8)};
  if (kind == ContactKind::point_triangle) w[1] = integer(r, 0, 8 - w[0]);
  if (chance(r, 2)) w[integer(r, 0, 1)] = 0;
  if (chance(r, 4)) w[0] = 8 - (kind == ContactKind::point_triangle ? w[1] : 0);
  if (chance(r, 16)) w[integer(r, 0, 1)] -= 9;
  return w;
}

/// Other names and axes: nothing is rounded.
void relabel(Random& r, Query& q) {
  std::array<int, 4> order{0, 1, 2, 3};
  if (q.kind == ContactKind::point_triangle) {
    std::shuffle(order.begin() + 1, order.end(), r);
  } else {
    if (chance(r, 2)) std::swap(order[0], order[1]);
    if (chance(r, 2)) std::swap(order[2], order[3]);
    if (chance(r, 2)) order = {order[2], order[3], order[0], order[1]};
  }
  std::array<int, 3> axis{0, 1, 2};
  std::shuffle(axis.begin(), axis.end(), r);
  const Vec3 flip(sign(r), sign(r), sign(r));
  const Query old = q;
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < 3; ++i) {
      q.x_t0[k][i] = flip[i] * old.x_t0[order[k]][axis[i]];
      q.x_t1[k][i] = flip[i] * old.x_t1[order[k]][axis[i]];
    }
}

/// Besides, integer shears and shifts: exact for integers that leave some bits.
Query disguised(Random& r, Query q) {
  relabel(r, q);
  for (int i = 0; i < 2; ++i) {
    const int to = integer(r, 0, 2), from = (to + integer(r, 1, 2)) % 3, a = integer(r, -2, 2);
    change_all(q, [&](Vec3& v) { v[to] += a * v[from]; });
  }
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    const Vec3 shift = integers(r, 20);
    for (Vec3& v : *x) v += shift;
  }
  return q;
}

Query nudged(Random& r, Query q) {
  nudge(r, q);
  return q;
}

Query relabelled(Random& r, Query q) {
  relabel(r, q);
  return q;
}

/// Rigid shift by a vector with many digits: every coordinate is rounded.
Query shifted(Random& r, Query q, double size) {
  const Vec3 shift = reals(r, size);
  change_all(q, [&](Vec3& v) { v += shift; });
  return q;
}

// -------------------------------------------------------------------------------------------------
// Basic families: small integers

Query small_grid(Random& r, ContactKind kind) { return grid(r, kind, integer(r, 1, 4)); }

Query resting(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  q.x_t1 = q.x_t0;
  return q;
}

Query touch_at_start(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  make_touch(r, kind, q.x_t0);
  for (Vec3& v : q.x_t1) v *= 64.0;
  return q;
}

Query touch_at_end(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  make_touch(r, kind, q.x_t1);
  for (Vec3& v : q.x_t0) v *= 64.0;
  return q;
}

Query touch_between(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  std::array<Vec3, 4> middle = q.x_t0;
  make_touch(r, kind, middle);
  const int left = integer(r, 1, 4), right = integer(r, 1, 4);
  for (int k = 0; k < 4; ++k) {
    const Vec3 v = q.x_t1[k] * integer(r, 0, 8);
    q.x_t0[k] = middle[k] - left * v, q.x_t1[k] = middle[k] + right * v;
  }
  return q;
}

Query touch_between_nudged(Random& r, ContactKind kind) {
  return nudged(r, touch_between(r, kind));
}

Query in_fixed_plane(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  flatten(r, q);
  return q;
}

Query degenerate_shape(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  degenerate(r, q);
  return q;
}

Query degenerate_in_plane(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  degenerate(r, q);
  flatten(r, q);
  return q;
}

Query flattened_by_scaling(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  change_all(q, [&](Vec3& v) { v.z() = std::ldexp(v.z(), -integer(r, 20, 60)); });
  return q;
}

Query far_by_1e6(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  change_all(q, [&](Vec3& v) { v = v * real(r, 0.001, 0.002) + Vec3(1e6, -1e6, 1e6 / 3); });
  return q;
}

Query shared_vertex(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  const int shared = kind == ContactKind::point_triangle ? integer(r, 1, 3) : integer(r, 2, 3);
  if (chance(r, 2)) q = uniform(r, kind, 1.0);
  q.x_t0[shared] = q.x_t0[0], q.x_t1[shared] = q.x_t1[0];
  if (chance(r, 2)) nudge(r, q);
  return q;
}

Query moved_as_one(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  for (int k = 0; k < 4; ++k) q.x_t1[k] = q.x_t0[k] + Vec3(3, 1, 2);
  return q;
}

Query unit_uniform(Random& r, ContactKind kind) { return uniform(r, kind, 1.0); }

Query tenths(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  change_all(q, [](Vec3& v) { v *= 0.1; });
  return q;
}

Query nearly_in_plane(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  flatten(r, q);
  nudge(r, q);
  return q;
}

// -------------------------------------------------------------------------------------------------
// Pairs as a cloth simulation asks them: centimetres at metres, steps of millimetres

Frame cloth_frame(Random& r) {
  constexpr double kSide = 0.01, kStep = 0.005;
  Frame f;
  const Vec3 place = reals(r, 1.0), step = reals(r, 2 * kStep);
  const Vec3 X = reals(r, kSide), Y = reals(r, kSide);
  const Vec3 Z = real(r, -0.2, 1.0) * X + real(r, -0.2, 1.0) * Y + reals(r, 0.3 * kStep);
  f.base = {place, Vec3(place + step)};
  f.X = {X, Vec3(X + reals(r, 0.1 * kStep))};
  f.Y = {Y, Vec3(Y + reals(r, 0.1 * kStep))};
  f.Z = {Z, Vec3(Z + reals(r, kStep))};
  return f;
}

Query cloth(Random& r, ContactKind kind) { return assemble(kind, cloth_frame(r)); }

Query cloth_in_floats(Random& r, ContactKind kind) {
  Query q = cloth(r, kind);
  change_all(q, [](Vec3& v) { v = v.cast<float>().cast<double>(); });
  return q;
}

Query cloth_far_away(Random& r, ContactKind kind) {
  return shifted(r, cloth(r, kind), chance(r, 2) ? 1e6 : 1e3);
}

// -------------------------------------------------------------------------------------------------
// Multiple and close roots

/// X = (L, 0, a L t), Y = (0, L, b L t), Z = (x, y, z) has n = L² (-a t, -b t, 1), so that the
/// coplanarity cubic is L² (z - t (a x + b y)); x, y and z are chosen to make it
/// L² (s (q t - p)² + e). At t = p/q the weights are x/L and y/L.
Frame grazing_frame(Random& r, int e_size) {
  const int q = integer(r, 1, 8), p = integer(r, 0, q), s = chance(r, 2) ? 1 : -1;
  const int a = integer(r, -2, 2), b = chance(r, 2) ? 1 : -1, L = 4 * q * q;
  const int x0 = integer(r, 0, L / 2), y0 = integer(r, 0, L / 2), x1 = integer(r, -4, 4);
  const int y1 = -b * (s * q * q + a * x1);
  const int z0 = s * p * p + integer(r, -e_size, e_size), z1 = a * x0 + b * y0 - 2 * p * q * s;
  Frame f;
  f.X = {Vec3(L, 0, 0), Vec3(L, 0, a * L)};
  f.Y = {Vec3(0, L, 0), Vec3(0, L, b * L)};
  f.Z = {Vec3(x0, y0, z0), Vec3(x0 + x1, y0 + y1, z0 + z1)};
  return f;
}

Query grazing(Random& r, ContactKind kind) {
  return disguised(r, assemble(kind, grazing_frame(r, 1)));
}

Query grazing_nudged(Random& r, ContactKind kind) {
  return nudged(r, disguised(r, assemble(kind, grazing_frame(r, 0))));
}

/// The two roots of a graze, 2^-20 to 2^-1 apart: e is small against the rest.
Query close_roots(Random& r, ContactKind kind) {
  Frame f = grazing_frame(r, 0);
  const double enlarged = std::ldexp(1.0, integer(r, 2, 36));
  for (Moving* m : {&f.X, &f.Y, &f.Z})
    for (Vec3& v : *m) v *= enlarged;
  const int e = integer(r, -3, 3);
  f.Z[0].z() += e, f.Z[1].z() += e;
  return disguised(r, assemble(kind, f));
}

/// As grazing_frame, with the cubic L² s (q1 t - p1) (q2 t - p2): the roots k / (2 k + 1) and
/// (k + 1) / (2 k + 3) lie 2^-36 to 2^-6 apart, and at one of them the weight x/L is exactly 0,
/// while it changes fast.
Query close_roots_on_rim(Random& r, ContactKind kind) {
  const double k = std::floor(std::ldexp(real(r, 1.0, 2.0), integer(r, 2, 16)));
  std::array<double, 2> p{k, k + 1}, q{2 * k + 1, 2 * k + 3};
  if (chance(r, 2)) std::swap(p[0], p[1]), std::swap(q[0], q[1]);
  const double s = sign(r), a = integer(r, -2, 2), b = sign(r), L = 8 * q[0] * q[1];
  const double speed = sign(r) * std::floor(L / (4 * q[0]));
  const double x0 = -speed * p[0], x1 = speed * q[0], y0 = std::floor(L * real(r, 0.25, 0.5));
  const double y1 = -b * (s * q[0] * q[1] + a * x1);
  const double z0 = s * p[0] * p[1], z1 = a * x0 + b * y0 - s * (p[0] * q[1] + p[1] * q[0]);
  Frame f;
  f.X = {Vec3(L, 0, 0), Vec3(L, 0, a * L)};
  f.Y = {Vec3(0, L, 0), Vec3(0, L, b * L)};
  f.Z = {Vec3(x0, y0, z0), Vec3(x0 + x1, y0 + y1, z0 + z1)};
  return disguised(r, assemble(kind, f));
}

/// X = (L, 0, L t), Y = (L t, L, 0), Z = (x, y, z): n = L² (-t, t², 1), and the coplanarity cubic
/// is L² (z - t x + t² y), here L² (q1 t - p1) (q2 t - p2) (q3 t - p3) with the roots k / (2 k +
/// 1), (k + 1) / (2 k + 3) and (k + 2) / (2 k + 5). The weights there are y/L and (x - t y)/L.
Query three_close_roots(Random& r, ContactKind kind) {
  const double k = std::floor(std::ldexp(real(r, 1.0, 2.0), integer(r, 1, 12)));
  const std::array<double, 3> p{k, k + 1, k + 2}, q{2 * k + 1, 2 * k + 3, 2 * k + 5};
  const double c3 = q[0] * q[1] * q[2], L = 16 * c3, c0 = -p[0] * p[1] * p[2];
  const double c1 = p[0] * p[1] * q[2] + p[0] * q[1] * p[2] + q[0] * p[1] * p[2];
  const double c2 = -(p[0] * q[1] * q[2] + q[0] * p[1] * q[2] + q[0] * q[1] * p[2]);
  const double x0 = std::floor(L * real(r, -0.1, 0.5)), y0 = std::floor(L * real(r, -0.2, 0.4));
  const double x1 = y0 - c2, y1 = c3, z0 = c0, z1 = c1 + x0;
  Frame f;
  f.X = {Vec3(L, 0, 0), Vec3(L, 0, L)};
  f.Y = {Vec3(0, L, 0), Vec3(L, L, 0)};
  f.Z = {Vec3(x0, y0, z0), Vec3(x0 + x1, y0 + y1, z0 + z1)};
  const Query query = relabelled(r, assemble(kind, f));
  return chance(r, 4) ? nudged(r, query) : query;
}

/// All four vertices meet in one point at t = p/q: a triple root at which nothing is left of the
/// primitives.
Query triple_root(Random& r, ContactKind kind) {
  const int q = integer(r, 1, 9), p = integer(r, 0, q);
  Query query;
  query.kind = kind;
  for (int k = 0; k < 4; ++k) {
    const Vec3 v = integers(r, 6);
    query.x_t0[k] = -p * v, query.x_t1[k] = (q - p) * v;
  }
  query = disguised(r, query);
  return chance(r, 2) ? nudged(r, query) : query;
}

/// X = (L, L t, 0) and Z = (x, y, 0): Z is on the line of X when the quadratic L (y - t x) is zero,
/// at an irrational time for most integers. Y leaves the plane, so that the cubic is that quadratic
/// times a linear factor: its root and that of a constraint are the same irrational number.
Query irrational_time_on_rim(Random& r, ContactKind kind) {
  constexpr int L = 32;
  const int x0 = integer(r, 0, L), x1 = integer(r, -9, 9), y0 = integer(r, -12, 12);
  const int y1 = x0 + integer(r, -16, 16);
  Frame f;
  f.X = {Vec3(L, 0, 0), Vec3(L, L, 0)};
  f.Y = {integers(r, 12), integers(r, 12)};
  if (chance(r, 4)) f.Y[0].z() = f.Y[1].z() = 0.0;
  f.Z = {Vec3(x0, y0, 0), Vec3(x0 + x1, y0 + y1, 0)};
  return disguised(r, assemble(kind, f));
}

Query irrational_time_on_rim_nudged(Random& r, ContactKind kind) {
  return nudged(r, irrational_time_on_rim(r, kind));
}

// -------------------------------------------------------------------------------------------------
// Contact at a given place and time

/// Z = s X + r Y at t = p/q: `gap` there, and a velocity.
Moving passing(const Vec3& gap, const Vec3& v, int p, int q) {
  return {Vec3(gap - p * v), Vec3(gap + (q - p) * v)};
}

Vec3 at_fraction(const Moving& m, int p, int q) { return ((q - p) * m[0] + p * m[1]) / q; }

Query rational_time(Random& r, ContactKind kind) {
  constexpr std::array<int, 8> denominators{2, 3, 5, 6, 7, 9, 11, 13};
  const int q = denominators[integer(r, 0, 7)], p = integer(r, 0, q);
  const auto [s, w] = weights(r, kind);
  Frame f;
  for (Moving* m : {&f.X, &f.Y}) *m = {8 * q * integers(r, 5), 8 * q * integers(r, 5)};
  const Vec3 gap = (s * at_fraction(f.X, p, q) + w * at_fraction(f.Y, p, q)) / 8.0;
  f.Z = passing(gap, integers(r, 9), p, q);
  return disguised(r, assemble(kind, f));
}

Query rational_time_nudged(Random& r, ContactKind kind) {
  return nudged(r, rational_time(r, kind));
}

/// At t = k / 2^m for m up to 40, all exact.
Query dyadic_time(Random& r, ContactKind kind) {
  const int m = integer(r, 1, 40);
  const double t = std::floor(real(r, 0.0, std::ldexp(1.0, m) + 1.0)) * std::ldexp(1.0, -m);
  const auto [s, w] = weights(r, kind);
  Frame f;
  f.X = at_rest(8 * integers(r, 9)), f.Y = at_rest(8 * integers(r, 9));
  const Vec3 v = integers(r, 9), gap = (s * f.X[0] + w * f.Y[0]) / 8.0;
  f.Z = {Vec3(gap - t * v), Vec3(gap + (1.0 - t) * v)};
  return disguised(r, assemble(kind, f));
}

/// An axis-parallel frame at rest, and a gap that goes straight from height z0 to z1: the contact
/// is at t = z0 / (z0 - z1).
Query falling_gap(Random& r, ContactKind kind, double z0, double z1) {
  const auto [s, w] = weights(r, kind);
  const double side = std::ldexp(8.0, integer(r, -3, 3));
  Frame f;
  f.X = at_rest(Vec3(side, 0, 0)), f.Y = at_rest(Vec3(0, side, 0));
  const double x = s * side / 8.0, y = w * side / 8.0;
  f.Z = {Vec3(x, y, z0), Vec3(x, y, z1)};
  return relabelled(r, assemble(kind, f));
}

/// At a small fraction of an ulp before or after 1.
Query at_the_last_instant(Random& r, ContactKind kind) {
  const double z = real(r, 0.5, 2.0);
  return falling_gap(r, kind, z, z * real(r, -1.0, 1.0) * std::ldexp(1.0, -integer(r, 51, 60)));
}

/// At t up to a small fraction of an ulp beside a double t in (1/2, 1): 1 - t is exact there and
/// has smaller ulps than t.
Query beside_a_double(Random& r, ContactKind kind) {
  const double t = chance(r, 4) ? integer(r, 9, 15) / 16.0 : real(r, 0.5, 1.0);
  double rest = 1.0 - t;
  for (int n = integer(r, 0, 3); n > 0; --n) rest = std::nextafter(rest, 2.0);
  for (int n = integer(r, 0, 3); n > 0; --n) rest = std::nextafter(rest, -1.0);
  return falling_gap(r, kind, t, -rest);
}

/// At times from 2^-1074 to 2^-10, or as little before 0.
Query at_the_first_instant(Random& r, ContactKind kind) {
  const double z = std::ldexp(real(r, 0.5, 1.0), -integer(r, 10, chance(r, 4) ? 1073 : 80));
  return falling_gap(r, kind, chance(r, 4) ? -z : z,
                     -std::ldexp(real(r, 1.0, 2.0), integer(r, 0, 12)));
}

/// The primitives meet at t = 1/2 in two vertices, whose coordinates have all their digits; the
/// other ones move anyhow.
Query vertex_on_vertex(Random& r, ContactKind kind) {
  Query q = uniform(r, kind, 1.0);
  const int other = kind == ContactKind::point_triangle ? integer(r, 1, 3) : integer(r, 2, 3);
  for (const int k : {0, other}) q.x_t1[k] = -q.x_t0[k];
  return chance(r, 2) ? nudged(r, q) : q;
}

/// The same with a vertex in the middle of an edge that turns about the origin.
Query vertex_on_turning_edge(Random& r, ContactKind kind) {
  Query q = uniform(r, kind, 1.0);
  const bool edges = kind == ContactKind::edge_edge;
  const int from = edges ? 0 : 1, to = edges ? 1 : 2, vertex = edges ? 2 : 0;
  q.x_t0[to] = -q.x_t0[from], q.x_t1[to] = -q.x_t1[from];
  q.x_t1[vertex] = -q.x_t0[vertex];
  q = relabelled(r, q);
  return chance(r, 2) ? nudged(r, q) : q;
}

/// At any time and place of primitives in motion, as well as rounding allows; every second time at
/// the rim.
Query rounded_touch(Random& r, ContactKind kind, double size) {
  Frame f;
  for (Moving* m : {&f.X, &f.Y}) *m = {reals(r, size), reals(r, size)};
  const double t = real(r, 0.0, 1.0);
  const double s = chance(r, 2) ? integer(r, 0, 1) : real(r, 0.0, 1.0);
  const double w = (kind == ContactKind::point_triangle ? 1.0 - s : 1.0) * real(r, 0.0, 1.0);
  const Vec3 X = (1.0 - t) * f.X[0] + t * f.X[1], Y = (1.0 - t) * f.Y[0] + t * f.Y[1];
  const Vec3 v = reals(r, size), gap = s * X + w * Y;
  f.Z = {Vec3(gap - t * v), Vec3(gap + (1.0 - t) * v)};
  return relabelled(r, assemble(kind, f));
}

Query rim_as_rounded(Random& r, ContactKind kind) { return rounded_touch(r, kind, 1.0); }

Query rim_as_rounded_far(Random& r, ContactKind kind) {
  return shifted(r, rounded_touch(r, kind, 1.0), std::ldexp(1.0, integer(r, 0, 45)));
}

/// Coplanar all the time but for rounding: the weights stay what they are.
Query coplanar_as_rounded(Random& r, ContactKind kind) {
  Frame f;
  for (Moving* m : {&f.X, &f.Y}) *m = {reals(r, 1.0), reals(r, 1.0)};
  const double s = real(r, -0.5, 1.0), w = real(r, -0.5, 1.0);
  f.Z = {Vec3(s * f.X[0] + w * f.Y[0]), Vec3(s * f.X[1] + w * f.Y[1])};
  Query q = relabelled(r, assemble(kind, f));
  return chance(r, 2) ? shifted(r, q, std::ldexp(1.0, integer(r, 0, 30))) : q;
}

// -------------------------------------------------------------------------------------------------
// Degenerate shapes and motions

/// On one line that may move: a problem in one dimension.
Query in_a_line(Random& r, ContactKind kind) {
  Query q;
  q.kind = kind;
  const Vec3 d0 = integers(r, 3), d1 = chance(r, 2) ? d0 : integers(r, 3);
  for (int k = 0; k < 4; ++k)
    q.x_t0[k] = integer(r, -9, 9) * d0, q.x_t1[k] = integer(r, -9, 9) * d1;
  q = disguised(r, q);
  return chance(r, 3) ? nudged(r, q) : q;
}

/// All vertices in one point at one end of the step or at both.
Query in_a_point(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  const int ends = integer(r, 1, 3);
  if ((ends & 1) != 0) q.x_t0.fill(q.x_t0[0]);
  if ((ends & 2) != 0) q.x_t1.fill(q.x_t1[0]);
  q = disguised(r, q);
  return chance(r, 2) ? nudged(r, q) : q;
}

/// Y is a multiple of X, all the time or only at the time t = p/q of the contact: a triangle
/// without area, parallel edges; now and then nearly so.
Query parallel_sides(Random& r, ContactKind kind) {
  const int q = integer(r, 1, 7), p = integer(r, 0, q);
  Frame f;
  f.X = {8 * q * integers(r, 4), 8 * q * integers(r, 4)};
  const int multiple = integer(r, -2, 2);
  f.Y = {multiple * f.X[0], multiple * f.X[1]};
  if (chance(r, 2)) {
    const Vec3 turn = integers(r, 5);
    f.Y[0] -= p * turn, f.Y[1] += (q - p) * turn;
  }
  f.Z = passing(integer(r, -1, 9) * at_fraction(f.X, p, q) / 8.0, integers(r, 9), p, q);
  Query query = disguised(r, assemble(kind, f));
  return chance(r, 3) ? nudged(r, query) : query;
}

/// Y = X but for 2^-8 to 2^-40 of it.
Query sliver(Random& r, ContactKind kind) {
  const double thin = std::ldexp(1.0, integer(r, 8, 40));
  const auto [s, w] = weights(r, kind);
  Frame f;
  f.X = at_rest(8 * thin * integers(r, 3)), f.Y = at_rest(f.X[0] + 8 * integers(r, 3));
  const Vec3 v = std::ldexp(1.0, integer(r, 0, 40)) * integers(r, 3);
  f.Z = passing((s * f.X[0] + w * f.Y[0]) / 8.0, v, 1, 2);
  const Query q = relabelled(r, assemble(kind, f));
  return chance(r, 2) ? nudged(r, q) : q;
}

/// In a plane z = α x + β y with α, β linear in time, places in x, y kept: the cubic is zero.
Query in_turning_plane(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  if (chance(r, 2)) make_touch(r, kind, q.x_t0);
  for (int k = 0; k < 4; ++k) q.x_t1[k] = q.x_t0[k];
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    const int a = integer(r, -3, 3), b = integer(r, -3, 3);
    for (Vec3& v : *x) v.z() = a * v.x() + b * v.y();
  }
  q = disguised(r, q);
  return chance(r, 2) ? nudged(r, q) : q;
}

Query static_overlap(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  make_touch(r, kind, q.x_t0);
  q.x_t1 = q.x_t0;
  return q;
}

Query static_near_miss(Random& r, ContactKind kind) {
  Query q = static_overlap(r, kind);
  nudge(r, q);
  const Vec3 step = chance(r, 2) ? Vec3(0, 0, 0) : integers(r, 4);
  for (int k = 0; k < 4; ++k) q.x_t1[k] = q.x_t0[k] + step;
  return q;
}

/// Real coordinates, all moved by one vector: relative motion is rounding.
Query moved_as_one_in_reals(Random& r, ContactKind kind) {
  Frame f;
  f.X = at_rest(reals(r, 1.0)), f.Y = at_rest(reals(r, 1.0));
  const auto [s, w] = weights(r, kind);
  f.Z = at_rest((s * f.X[0] + w * f.Y[0]) / 8.0);
  f.base[1] = reals(r, chance(r, 2) ? 1.0 : 1e5);
  return relabelled(r, assemble(kind, f));
}

/// Far motions past small primitives.
Query fast(Random& r, ContactKind kind) {
  Query q = rational_time(r, kind);
  const double far = std::ldexp(1.0, integer(r, 10, 30));
  const Vec3 v = far * integers(r, 4);
  const int first = kind == ContactKind::edge_edge ? 2 : 1;
  // Through the place of the middle of the step.
  for (int k = 0; k < first; ++k) q.x_t0[k] -= v, q.x_t1[k] += v;
  return q;
}

// -------------------------------------------------------------------------------------------------
// Scales and places

Query far_by_1e8(Random& r, ContactKind kind) {
  Query q = chance(r, 2) ? touch_between(r, kind) : rounded_touch(r, kind, 1.0);
  const Vec3 place(1e8, -1e8 / 3, 1e8 / 7);
  change_all(q, [&](Vec3& v) { v += place; });
  return q;
}

/// Shifted by a large integer: nothing is rounded.
Query far_but_exact(Random& r, ContactKind kind) {
  Query q = chance(r, 2) ? rational_time(r, kind) : grazing(r, kind);
  const Vec3 place = std::ldexp(1.0, integer(r, 20, 40)) * integers(r, 4);
  change_all(q, [&](Vec3& v) { v += place; });
  return chance(r, 2) ? nudged(r, q) : q;
}

Query any_basic(Random& r, ContactKind kind) {
  return families()[integer(r, 0, kBasicFamilies - 1)].make(r, kind);
}

/// Coordinates multiplied by powers of two of their own, from 1e-298 to 1e298.
Query tiny_and_huge(Random& r, ContactKind kind) {
  Query q = any_basic(r, kind);
  const int range = chance(r, 3) ? 990 : 60;
  change_all(q, [&](Vec3& v) {
    for (int i = 0; i < 3; ++i)
      if (chance(r, 8)) v[i] = std::ldexp(v[i], integer(r, -range, range));
  });
  return q;
}

/// As small integer multiples of the smallest double and of numbers not much larger.
Query denormal(Random& r, ContactKind kind) {
  Query q = chance(r, 2) ? rational_time(r, kind) : touch_between(r, kind);
  scale(q, -integer(r, 1060, 1074));
  return q;
}

/// Differences overflow.
Query near_overflow(Random& r, ContactKind kind) {
  Query q = small_grid(r, kind);
  scale(q, 1021);
  return q;
}

/// As a whole, about where the products of three coordinates leave the range of doubles.
Query scaled(Random& r, ContactKind kind) {
  constexpr std::array<Query (*)(Random&, ContactKind), 5> sources{
      rational_time_nudged, rim_as_rounded, coplanar_as_rounded, grazing_nudged, sliver};
  Query q = sources[integer(r, 0, 4)](r, kind);
  scale(q, (chance(r, 2) ? 1 : -1) * integer(r, 200, 400));
  return q;
}

/// As a whole, so that the product of three coordinates has a few bits left or just overflows.
Query products_at_the_range(Random& r, ContactKind kind) {
  constexpr std::array<Query (*)(Random&, ContactKind), 5> sources{
      rim_as_rounded, coplanar_as_rounded, vertex_on_vertex, shared_vertex, moved_as_one_in_reals};
  Query q = sources[integer(r, 0, 4)](r, kind);
  scale(q, chance(r, 2) ? -integer(r, 335, 362) : integer(r, 336, 343));
  return q;
}

/// Sides of sizes 2^0 and 2^40, motions of any size between.
Query mixed_scales(Random& r, ContactKind kind) {
  const auto [s, w] = weights(r, kind);
  const auto side = [&](int bits) { return Vec3(std::ldexp(8.0, bits) * integers(r, 9)); };
  Frame f;
  f.X = at_rest(side(0)), f.Y = at_rest(side(integer(r, 0, 40)));
  const Vec3 v = std::ldexp(1.0, integer(r, 0, 40)) * integers(r, 9);
  f.Z = passing((s * f.X[0] + w * f.Y[0]) / 8.0, v, 1, 2);
  const Query q = relabelled(r, assemble(kind, f));
  return chance(r, 2) ? nudged(r, q) : q;
}

constexpr std::array kFamilies{
    Family{"grid", small_grid},
    Family{"resting", resting},
    Family{"touch_at_start", touch_at_start},
    Family{"touch_at_end", touch_at_end},
    Family{"touch_between", touch_between},
    Family{"touch_between_nudged", touch_between_nudged},
    Family{"in_fixed_plane", in_fixed_plane},
    Family{"degenerate_shape", degenerate_shape},
    Family{"degenerate_in_plane", degenerate_in_plane},
    Family{"flattened_by_scaling", flattened_by_scaling},
    Family{"far_by_1e6", far_by_1e6},
    Family{"shared_vertex", shared_vertex},
    Family{"moved_as_one", moved_as_one},
    Family{"uniform", unit_uniform},
    Family{"tenths", tenths},
    Family{"nearly_in_plane", nearly_in_plane},
    Family{"cloth", cloth},
    Family{"cloth_in_floats", cloth_in_floats},
    Family{"cloth_far_away", cloth_far_away},
    Family{"grazing", grazing},
    Family{"grazing_nudged", grazing_nudged},
    Family{"close_roots", close_roots},
    Family{"close_roots_on_rim", close_roots_on_rim},
    Family{"three_close_roots", three_close_roots},
    Family{"triple_root", triple_root},
    Family{"irrational_time_on_rim", irrational_time_on_rim},
    Family{"irrational_time_on_rim_nudged", irrational_time_on_rim_nudged},
    Family{"rational_time", rational_time},
    Family{"rational_time_nudged", rational_time_nudged},
    Family{"dyadic_time", dyadic_time},
    Family{"at_the_last_instant", at_the_last_instant},
    Family{"beside_a_double", beside_a_double},
    Family{"at_the_first_instant", at_the_first_instant},
    Family{"vertex_on_vertex", vertex_on_vertex},
    Family{"vertex_on_turning_edge", vertex_on_turning_edge},
    Family{"rim_as_rounded", rim_as_rounded},
    Family{"rim_as_rounded_far", rim_as_rounded_far},
    Family{"coplanar_as_rounded", coplanar_as_rounded},
    Family{"in_a_line", in_a_line},
    Family{"in_a_point", in_a_point},
    Family{"parallel_sides", parallel_sides},
    Family{"sliver", sliver},
    Family{"in_turning_plane", in_turning_plane},
    Family{"static_overlap", static_overlap},
    Family{"static_near_miss", static_near_miss},
    Family{"moved_as_one_in_reals", moved_as_one_in_reals},
    Family{"fast", fast},
    Family{"far_by_1e8", far_by_1e8},
    Family{"far_but_exact", far_but_exact},
    Family{"tiny_and_huge", tiny_and_huge},
    Family{"denormal", denormal},
    Family{"near_overflow", near_overflow},
    Family{"scaled", scaled},
    Family{"products_at_the_range", products_at_the_range},
    Family{"mixed_scales", mixed_scales},
};

}  // namespace

Query grid(Random& r, ContactKind kind, int size) {
  Query q;
  q.kind = kind;
  change_all(q, [&](Vec3& v) {
    for (int i = 0; i < 3; ++i) v[i] = integer(r, -size, size);
  });
  return q;
}

Query uniform(Random& r, ContactKind kind, double size) {
  Query q;
  q.kind = kind;
  change_all(q, [&](Vec3& v) {
    for (int i = 0; i < 3; ++i) v[i] = real(r, -size, size);
  });
  return q;
}

void nudge(Random& r, Query& q) {
  for (int n = integer(r, 1, 3); n-- > 0;) {
    auto& x = chance(r, 2) ? q.x_t0 : q.x_t1;
    double& c = x[integer(r, 0, 3)][integer(r, 0, 2)];
    const double towards = sign(r) * kInf;
    c = c == 0.0 ? std::copysign(0x1p-60, towards) : std::nextafter(c, towards);
  }
}

std::span<const Family> families() { return kFamilies; }

Query falling_point(double from, double to) {
  Query q;
  q.kind = ContactKind::point_triangle;
  q.x_t0 = {Vec3(0.25, 0.25, from), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  q.x_t1 = q.x_t0;
  q.x_t1[0].z() = to;
  return q;
}

Truth truth_of(const Query& q) {
  std::array<Vec3, 8> points;
  for (int k = 0; k < 4; ++k) points[k] = q.x_t0[k], points[k + 4] = q.x_t1[k];
  const auto touch = first_touch(
      q.kind == ContactKind::edge_edge ? PathKind::edge_edge : PathKind::point_triangle, points);
  return touch ? Truth{true, touch->lo, touch->hi} : Truth{};
}

namespace {

/// Appends vertices `from` to `to` of the query; returns the index of the first.
std::int32_t add(Scene::Surface& surface, const Query& q, int from, int to) {
  const auto first = static_cast<std::int32_t>(surface.x_t0.size());
  for (int k = from; k < to; ++k) {
    surface.x_t0.push_back(q.x_t0[k]);
    surface.x_t1.push_back(q.x_t1[k]);
  }
  return first;
}

std::int32_t add_triangle(Scene::Surface& surface, const Query& q) {
  const std::int32_t v = add(surface, q, 1, 4);
  surface.triangles.push_back({v, v + 1, v + 2});
  return static_cast<std::int32_t>(surface.triangles.size()) - 1;
}

std::int32_t add_edge(Scene::Surface& surface, const Query& q, int from) {
  const std::int32_t v = add(surface, q, from, from + 2);
  surface.edges.push_back({v, v + 1});
  return static_cast<std::int32_t>(surface.edges.size()) - 1;
}

}  // namespace

Scene scene_of(std::span<const Query> queries) {
  Scene s;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Query& q = queries[i];
    if (q.kind == ContactKind::edge_edge) {
      s.pairs.edge_edge.push_back({add_edge(s.a, q, 0), add_edge(s.b, q, 2)});
      s.edge_edge.push_back(i);
    } else if (i % 3 == 0) {
      s.pairs.triangle_point.push_back({add(s.b, q, 0, 1), add_triangle(s.a, q)});
      s.triangle_point.push_back(i);
    } else {
      s.pairs.point_triangle.push_back({add(s.a, q, 0, 1), add_triangle(s.b, q)});
      s.point_triangle.push_back(i);
    }
  }
  return s;
}

std::string hex_text(const Query& q) {
  std::ostringstream out;
  out << std::hexfloat << (q.kind == ContactKind::edge_edge ? "edge_edge" : "point_triangle");
  for (const auto* x : {&q.x_t0, &q.x_t1})
    for (const Vec3& v : *x) out << "\n" << v.x() << ", " << v.y() << ", " << v.z();
  return out.str();
}

std::string file_rows(const Query& q, bool touches) {
  std::string rows;
  for (const auto* x : {&q.x_t0, &q.x_t1})
    for (const Vec3& v : *x) {
      for (int i = 0; i < 3; ++i) {
        detail::append_rational(v[i], rows);
        rows += ',';
      }
      rows += touches ? "1\n" : "0\n";
    }
  return rows;
}

}  // namespace selvedge::ccd_queries
