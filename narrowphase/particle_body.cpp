// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/narrowphase/internal/particle_body.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string>

// A straight path against analytic bodies. Convex bodies are intersections of slabs, discs and a
// cone, and the path is inside each of these during one interval of time. A capsule is the union of
// two balls and a cylinder. The torus gives a quartic in t.
//
// The path is first clipped to a ball around the body, so that all numbers have the size of the
// body, no matter how far away the particle starts.

namespace selvedge {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr double kInf = std::numeric_limits<double>::infinity();
/// Unit roundoff of double.
constexpr double kUnitRoundoff = 0x1p-53;
/// A path that passes a curved face at a distance below this multiple of the radius (cone: of the
/// size) touches it: the closest point of the path has an error of about 8 units.
constexpr double kTouching = 16.0 * kUnitRoundoff;

// ---------------------------------------------------------------- spans of time

/// The path x(t) = start + t d, t in [0, 1].
struct Path {
  Vec3 start, end, d = end - start;
  Vec3 at(double t) const { return t == 1.0 ? end : Vec3(start + t * d); }
};

/// Interval of time during which the path is in a set; empty if in > out.
struct Span {
  double in = -kInf, out = kInf;
};
constexpr Span kNever{kInf, -kInf};

Span operator&(const Span& a, const Span& b) {
  return {std::max(a.in, b.in), std::min(a.out, b.out)};
}

/// First time in [0, 1], for a path that starts outside.
double first_time(const Span& s) {
  const Span step = s & Span{0.0, 1.0};
  return step.in <= step.out ? step.in : kInf;
}

/// |x + t d| <= half.
Span slab(double x, double d, double half) {
  if (d == 0.0) return std::abs(x) <= half ? Span{} : kNever;
  const double a = (-half - x) / d, b = (half - x) / d;
  return {std::min(a, b), std::max(a, b)};
}

/// x + t d| <= radius, in two or three dimensions. Uses half a chord to each side of the point of
/// the path closest to the centre: cancellation only occurs for grazing paths.
template <class Vec>
Span ball(const Vec& x, const Vec& d, double radius) {
  const double dd = d.squaredNorm();
  if (dd == 0.0) return x.norm() <= radius ? Span{} : kNever;
  const double middle = -x.dot(d) / dd;
  const double nearest = Vec(x + middle * d).norm();
  if (nearest > radius * (1.0 + kTouching)) return kNever;
  const double half = std::sqrt(std::max(0.0, (radius - nearest) * (radius + nearest)) / dd);
  return {middle - half, middle + half};
}

/// a t^2 + 2 b t + c <= 0. For a < 0 this holds on two rays; returns the one with t -> +infinity if
/// `later`.
Span quadratic(double a, double b, double c, bool later) {
  if (a == 0.0 && b == 0.0) return c <= 0.0 ? Span{} : kNever;
  const double discriminant = b * b - a * c;
  if (a > 0.0 && discriminant < 0.0) return kNever;
  const double q = -(b + std::copysign(std::sqrt(std::max(discriminant, 0.0)), b));
  const double r = q == 0.0 ? 0.0 : c / q;
  if (a == 0.0) return b > 0.0 ? Span{-kInf, r} : Span{r, kInf};
  const double s = q / a, lo = std::min(r, s), hi = std::max(r, s);
  if (a > 0.0) return {lo, hi};
  return later ? Span{hi, kInf} : Span{-kInf, lo};
}

/// rho^2 <= w^2 on the path rho + t d, w + t dw: a double cone. A path steeper than the slant is
/// inside on two rays; returns the one with w -> +infinity. Near the vertex of the parabola rho^2 -
/// w^2, its value is computed from rho and w, so that cancellation only occurs for grazing paths;
/// `size` is that of the body.
Span double_cone(const Vec2& rho, const Vec2& d, double w, double dw, double size) {
  const double a = (d.norm() - std::abs(dw)) * (d.norm() + std::abs(dw));
  const double b = rho.dot(d) - w * dw, middle = -b / a;
  if (!(std::abs(middle) <= 2.0))
    return quadratic(a, b, (rho.norm() - w) * (rho.norm() + w), dw > 0.0);
  const double at_rho = Vec2(rho + middle * d).norm(), at_w = std::abs(w + middle * dw);
  if (a > 0.0 && at_rho > at_w + kTouching * size) return kNever;
  const double half = std::sqrt(std::max(0.0, (at_w - at_rho) * (at_w + at_rho) / a));
  if (a > 0.0) return {middle - half, middle + half};
  return dw > 0.0 ? Span{middle + half, kInf} : Span{-kInf, middle - half};
}

// ---------------------------------------------------------------- the torus

/// Coefficients in Bernstein form on an interval of time.
using Quartic = std::array<double, 5>;

/// An interval of 2^-kDeepestInterval of the clipped path that may contain a root counts as a root:
/// the path is little longer than twice the body's size, which leaves half of kParticleAccuracy.
constexpr int kDeepestInterval = 46;
/// Bound of the rounding errors of the coefficients, relative to the fourth power of the clipped
/// path's distance from the centre (at least R): g^2 and 4 R^2 h are at most four times that, with
/// at most 16 roundings each.
constexpr double kQuarticError = (4.0 + 4.0) * 16.0 * kUnitRoundoff;

/// (|x|^2 + R^2 - r^2)^2 - 4 R^2 (x_1^2 + x_2^2), not positive inside, on the path from a to b.
Quartic torus_quartic(const Torus& torus, const Vec3& a, const Vec3& b) {
  const double rr = torus.radius * torus.radius;
  const double k = (torus.radius - torus.tube) * (torus.radius + torus.tube);
  const double g0 = a.squaredNorm() + k, g1 = a.dot(b) + k, g2 = b.squaredNorm() + k;
  const double h0 = a.head<2>().squaredNorm(), h1 = a.head<2>().dot(b.head<2>());
  const double h2 = b.head<2>().squaredNorm();
  return {g0 * g0 - 4.0 * rr * h0, g0 * g1 - 2.0 * rr * (h0 + h1),
          (g0 * g2 + 2.0 * g1 * g1) / 3.0 - 4.0 * rr * ((h0 + h2) / 6.0 + 2.0 * h1 / 3.0),
          g1 * g2 - 2.0 * rr * (h1 + h2), g2 * g2 - 4.0 * rr * h2};
}

/// De Casteljau's subdivision: c becomes the left half; returns the right half.
Quartic halve(Quartic& c) {
  Quartic right;
  Quartic row = c;
  for (int i = 0; i < 5; ++i) {
    c[i] = row[0], right[4 - i] = row[4 - i];
    for (int j = 0; j + 1 < 5 - i; ++j) row[j] = 0.5 * (row[j] + row[j + 1]);
  }
  return right;
}

/// The first time in [lo, lo + 2^-depth] at which the quartic may be at most `slack`, or kInf. A
/// polynomial lies between its Bernstein coefficients.
double first_root(Quartic c, double lo, int depth, double slack) {
  if (*std::min_element(c.begin(), c.end()) > slack) return kInf;
  if (c[0] <= slack || depth == kDeepestInterval) return lo;
  const Quartic right = halve(c);
  const double left = first_root(c, lo, depth + 1, slack);
  if (left != kInf) return left;
  return first_root(right, lo + std::ldexp(1.0, -depth - 1), depth + 1, slack);
}

// ---------------------------------------------------------------- first contact

double bounding_radius(const Box& box) { return 0.5 * box.size.norm(); }
double bounding_radius(const Sphere& sphere) { return sphere.radius; }
double bounding_radius(const Capsule& capsule) { return 0.5 * capsule.length + capsule.radius; }
double bounding_radius(const Cylinder& c) { return elementary::hypot(c.radius, 0.5 * c.height); }
double bounding_radius(const Cone& cone) {
  return elementary::hypot(cone.radius, 0.5 * cone.height);
}
double bounding_radius(const Torus& torus) { return torus.radius + torus.tube; }

double entry(const Box& box, const Path& p) {
  Span inside;
  for (int i = 0; i < 3; ++i) inside = inside & slab(p.start[i], p.d[i], 0.5 * box.size[i]);
  return first_time(inside);
}

double entry(const Sphere& sphere, const Path& p) {
  return first_time(ball(p.start, p.d, sphere.radius));
}

Span cylinder_span(double radius, double height, const Path& p) {
  return ball(Vec2(p.start.head<2>()), Vec2(p.d.head<2>()), radius) &
         slab(p.start.z(), p.d.z(), 0.5 * height);
}

double entry(const Cylinder& c, const Path& p) {
  return first_time(cylinder_span(c.radius, c.height, p));
}

double entry(const Capsule& c, const Path& p) {
  const Vec3 end(0.0, 0.0, 0.5 * c.length);
  return std::min({first_time(cylinder_span(c.radius, c.length, p)),
                   first_time(ball(Vec3(p.start - end), p.d, c.radius)),
                   first_time(ball(Vec3(p.start + end), p.d, c.radius))});
}

/// rho <= (R/H) times the depth below the tip; the slab leaves its lower half.
double entry(const Cone& cone, const Path& p) {
  const double k = cone.radius / cone.height;
  const double w = k * (0.5 * cone.height - p.start.z()), dw = -k * p.d.z();
  return first_time(double_cone(p.start.head<2>(), p.d.head<2>(), w, dw, bounding_radius(cone)) &
                    slab(p.start.z(), p.d.z(), 0.5 * cone.height));
}

double entry(const Torus& torus, const Path& p) {
  const double size = std::max({bounding_radius(torus), p.start.norm(), p.end.norm()});
  const double slack = kQuarticError * (size * size) * (size * size);
  return first_root(torus_quartic(torus, p.start, p.end), 0.0, 0, slack);
}

/// Relative enlargement of the ball to which a path is clipped, so that touching contacts are not
/// lost.
constexpr double kRoomAround = 1.0 + 0x1p-10;

/// First time in [0, 1] of a path that starts outside.
template <class Shape>
double first_contact(const Shape& shape, const Path& path) {
  const double room = kRoomAround * bounding_radius(shape);
  const Span step = ball(path.start, path.d, room) & Span{0.0, 1.0};
  if (!(step.in <= step.out)) return kInf;
  const double s = entry(shape, Path{path.at(step.in), path.at(step.out)});
  return s == kInf ? kInf : step.in + s * (step.out - step.in);
}

/// z falls from above 0 to z_1 <= 0 or does not: the end decides without rounding. Rounding is
/// monotonic, so d_z <= -z_0 and t <= 1 then.
double first_contact(const Plane&, const Path& path) {
  return path.end.z() <= 0.0 ? -path.start.z() / path.d.z() : kInf;
}

// ---------------------------------------------------------------- normals

/// x / |x| for x of any size, or `otherwise` at the origin.
template <class Vec>
Vec direction(const Vec& x, const Vec& otherwise) {
  const double largest = x.cwiseAbs().maxCoeff();
  return largest > 0.0 ? (x / largest).normalized() : otherwise;
}

/// Unit vector away from the axis; on it the x-axis.
Vec3 radial(const Vec3& x) {
  const Vec2 n = direction<Vec2>(x.head<2>(), Vec2::UnitX());
  return {n.x(), n.y(), 0.0};
}

double sign_of(double x) { return x < 0.0 ? -1.0 : 1.0; }

/// Gradient of the distance to a box, from the parts of |x_i| beyond the half sizes.
template <class Vec>
Vec box_gradient(const Vec& beyond) {
  int axis = 0;
  beyond.maxCoeff(&axis);
  return direction(Vec(beyond.cwiseMax(0.0)), Vec(Vec::Unit(axis)));
}

Vec3 normal_of(const Plane&, const Vec3&) { return Vec3::UnitZ(); }

Vec3 normal_of(const Box& box, const Vec3& x) {
  Vec3 n = box_gradient(Vec3(x.cwiseAbs() - 0.5 * box.size));
  for (int i = 0; i < 3; ++i) n[i] *= sign_of(x[i]);
  return n;
}

Vec3 normal_of(const Sphere&, const Vec3& x) { return direction<Vec3>(x, Vec3::UnitZ()); }

Vec3 normal_of(const Capsule& c, const Vec3& x) {
  const double z = std::clamp(x.z(), -0.5 * c.length, 0.5 * c.length);
  return direction<Vec3>(Vec3(x.x(), x.y(), x.z() - z), Vec3::UnitX());
}

Vec3 normal_of(const Cylinder& c, const Vec3& x) {
  const Vec2 n = box_gradient(
      Vec2(elementary::hypot(x.x(), x.y()) - c.radius, std::abs(x.z()) - 0.5 * c.height));
  return n.x() * radial(x) + n.y() * sign_of(x.z()) * Vec3::UnitZ();
}

/// Closest point of the segment (a, b) to p, with the face's normal n unless it is an end point.
struct Face {
  double distance;
  Vec2 normal;
};

Face nearest_face(const Vec2& p, const Vec2& a, const Vec2& b, const Vec2& n) {
  const double s = (p - a).dot(b - a) / (b - a).squaredNorm();
  const Vec2 way = p - (a + std::clamp(s, 0.0, 1.0) * (b - a));
  const bool at_an_end = !(s > 0.0 && s < 1.0);
  return {elementary::hypot(way.x(), way.y()), at_an_end ? direction(way, n) : n};
}

Vec3 normal_of(const Cone& cone, const Vec3& x) {
  const Vec2 p(elementary::hypot(x.x(), x.y()), x.z());
  const Vec2 centre(0.0, -0.5 * cone.height), rim(cone.radius, -0.5 * cone.height);
  const Vec2 tip(0.0, 0.5 * cone.height);
  const Face base = nearest_face(p, centre, rim, Vec2(0.0, -1.0));
  const Face slant = nearest_face(
      p, rim, tip, Vec2(cone.height, cone.radius) / elementary::hypot(cone.height, cone.radius));
  const Vec2 n = base.distance < slant.distance ? base.normal : slant.normal;
  return n.x() * radial(x) + n.y() * Vec3::UnitZ();
}

Vec3 normal_of(const Torus& torus, const Vec3& x) {
  return direction<Vec3>(x - torus.radius * radial(x), Vec3::UnitZ());
}

// ---------------------------------------------------------------- sizes

void scale(Plane&, double) {}
void scale(Box& box, double k) { box.size *= k; }
void scale(Sphere& sphere, double k) { sphere.radius *= k; }
void scale(Capsule& c, double k) { c.radius *= k, c.length *= k; }
void scale(Cylinder& c, double k) { c.radius *= k, c.height *= k; }
void scale(Cone& cone, double k) { cone.radius *= k, cone.height *= k; }
void scale(Torus& torus, double k) { torus.radius *= k, torus.tube *= k; }

std::array<double, 3> sizes(const Plane& plane) { return {plane.size, plane.size, plane.size}; }
std::array<double, 3> sizes(const Box& box) { return {box.size.x(), box.size.y(), box.size.z()}; }
std::array<double, 3> sizes(const Sphere& s) { return {s.radius, s.radius, s.radius}; }
std::array<double, 3> sizes(const Capsule& c) { return {c.radius, c.length, c.length}; }
std::array<double, 3> sizes(const Cylinder& c) { return {c.radius, c.height, c.height}; }
std::array<double, 3> sizes(const Cone& c) { return {c.radius, c.height, c.height}; }
std::array<double, 3> sizes(const Torus& t) { return {t.radius, t.tube, t.tube}; }

std::array<double, 3> checked_sizes(const AnalyticShape& shape) {
  const std::array<double, 3> s = std::visit([](const auto& b) { return sizes(b); }, shape);
  for (const double size : s)
    if (!(size > 0.0) || !std::isfinite(size))
      throw std::invalid_argument("particle against body: a size of the body is " +
                                  std::to_string(size) + " m, but must be positive and finite");
  return s;
}

void require_finite(const Vec3& x, const char* when) {
  if (!x.allFinite())
    throw std::invalid_argument(std::string("particle against body: the particle's place at ") +
                                when + " has a coordinate that is not a finite number");
}

/// Sizes and coordinates between these bounds have fourth powers that are normal doubles.
constexpr double kLeast = 0x1p-240, kLargest = 0x1p240;

/// Exponent of the power of two that brings the largest size or coordinate to about 1, if one is
/// out of bounds.
int out_of_bounds_exponent(const std::array<double, 3>& s, const Vec3& a, const Vec3& b) {
  const auto [least, most] = std::minmax_element(s.begin(), s.end());
  const double largest = std::max(*most, a.cwiseAbs().cwiseMax(b.cwiseAbs()).maxCoeff());
  if (*least > kLeast && largest < kLargest) return 0;
  int exponent = 0;
  std::frexp(largest, &exponent);
  return exponent;
}

ShapeContact contact_in_bounds(const AnalyticShape& shape, const Vec3& a, const Vec3& b) {
  ShapeContact c;
  c.distance_t0 = signed_distance(shape, a), c.distance_t1 = signed_distance(shape, b);
  const Path path{a, b};
  double t = 0.0;
  if (!(c.distance_t0 <= 0.0)) {
    t = std::visit([&](const auto& s) { return first_contact(s, path); }, shape);
    if (!(t >= 0.0 && t <= 1.0)) t = c.distance_t1 <= 0.0 ? 1.0 : kInf;
  }
  if (t == kInf) return c;
  c.toi = t;
  c.point = path.at(t);
  c.normal = outward_normal(shape, c.point);
  return c;
}

}  // namespace

Vec3 outward_normal(const AnalyticShape& shape, const Vec3& x) {
  return std::visit([&](const auto& s) { return normal_of(s, x); }, shape);
}

ShapeContact particle_body_contact(const AnalyticShape& shape, const Vec3& x_t0, const Vec3& x_t1) {
  require_finite(x_t0, "t = 0");
  require_finite(x_t1, "t = 1");
  const int e = out_of_bounds_exponent(checked_sizes(shape), x_t0, x_t1);
  if (e == 0) return contact_in_bounds(shape, x_t0, x_t1);
  const auto scaled = [](Vec3 x, int by) {
    for (int i = 0; i < 3; ++i) x[i] = std::ldexp(x[i], by);
    return x;
  };
  AnalyticShape near_1 = shape;
  // Applies half the exponent twice: 2^-e itself may not be a normal double.
  for (const int part : {-(e / 2), -(e - e / 2)})
    std::visit([&](auto& s) { scale(s, std::ldexp(1.0, part)); }, near_1);
  ShapeContact c = contact_in_bounds(near_1, scaled(x_t0, -e), scaled(x_t1, -e));
  c.point = scaled(c.point, e);
  c.distance_t0 = std::ldexp(c.distance_t0, e), c.distance_t1 = std::ldexp(c.distance_t1, e);
  return c;
}

}  // namespace selvedge
