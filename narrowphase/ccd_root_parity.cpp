// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/error_bounds.h>
#include <selvedge/narrowphase/detail/expansion.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/per_query.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

// [Brochu2012] T. Brochu, E. Edwards, R. Bridson, "Efficient geometrically exact continuous
// collision detection", 2012. F maps the parameters (two on the primitives, and time) to the
// difference of the two points; a contact is F = 0. For a smooth map the number of roots inside a
// domain is, modulo 2, the number of crossings of a ray from 0 with the image of the domain's
// boundary. That image consists of
//   point-triangle  two triangles (t = 0 and t = 1) and three bilinear patches (edge x time),
//   edge-edge       six bilinear patches: (s, w) at t = 0 and t = 1, (w, t) at both ends of the
//                   first edge, (s, t) at both ends of the second.
// An odd number is a collision; so is 0 on the image of the boundary.
//
// A patch through x00, x01, x10, x11 lies in their tetrahedron and splits it in two: the
// barycentric coordinates of 0 satisfy b00 b11 > b01 b10 on the side of the diagonal x00 x11, and
// equality on the patch. The ray's crossings with the patch have the parity of its crossings with
// the two triangles of the tetrahedron on the side that does not contain 0. (Deviation: the paper's
// implicit function of the patch is a difference of two products of plane distances; b is the same
// up to a positive factor.)
//
// Exactness: every sign (degrees 3 and 6 in differences of coordinates) comes from a filtered
// double or, where its error bound does not decide, from an expansion. The ray's direction is taken
// from a fixed list; if it meets an edge or vertex, the next one is used.
//
// Misses by construction, even in exact arithmetic: an even number of contacts in the step, away
// from its ends and the primitives' boundaries: a point that passes a triangle and returns, or
// touches the plane and turns back (a double root); edges that cross twice. Parity does not give
// the time of the contact: the time of a collision is 0.
//
// False alarms in degenerate queries: 0 in the plane of a flat patch counts as a collision if it is
// in the hull of the patch's corners (in-plane motion). Queries whose coordinates differ in size by
// more than 2^106 are reported undecided as collisions, because expansions of them would underflow.

namespace selvedge {
namespace {

using detail::Expansion;

constexpr double kRoundoff = detail::kRoundoff;

/// Error of a determinant of three differences in units of u * the product of their largest
/// coordinates: 6 products, each with 3 roundings of differences, 1 of the cross product's
/// products, 1 of its difference, 1 of the dot product's products and 2 of its sums: 6 * 8, and a
/// reserve.
constexpr double kDeterminantError = 64.0 * kRoundoff;
/// Scaled to at most 1, coordinates above this have no bit below 2^-159. Products of six
/// differences then have none below 2^-954, and expansions of them are exact.
constexpr double kLeastCoordinate = 0x1p-106;

/// head - tail, exactly and rounded.
struct Difference {
  Vec3 head, tail, rounded;
  double largest;

  Difference() = default;
  Difference(const Vec3& h, const Vec3& t)
      : head(h), tail(t), rounded(h - t), largest(rounded.cwiseAbs().maxCoeff()) {}
  Expansion exact(int i) const { return {head[i], tail[i]}; }
};

/// det(a, b, c), with an error bound.
struct Determinant {
  const Difference &a, &b, &c;
  double rounded, error;

  Determinant(const Difference& p, const Difference& q, const Difference& r)
      : a(p),
        b(q),
        c(r),
        rounded(p.rounded.cross(q.rounded).dot(r.rounded)),
        error(kDeterminantError * (p.largest * q.largest * r.largest)) {}

  Expansion exact() const {
    Expansion sum;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      sum = sum + (a.exact(j) * b.exact(k) - a.exact(k) * b.exact(j)) * c.exact(i);
    }
    return sum;
  }
  int sign() const {
    if (rounded > error) return 1;
    if (rounded < -error) return -1;
    return exact().sign();
  }
};

/// Sign of p q - r s, where each of the four determinants has a sign that is known exactly.
int sign_of_products(const Determinant& p, const Determinant& q, const Determinant& r,
                     const Determinant& s) {
  const auto bound = [](const Determinant& x, const Determinant& y) {
    return std::abs(x.rounded) * y.error + std::abs(y.rounded) * x.error + x.error * y.error;
  };
  const double pq = p.rounded * q.rounded, rs = r.rounded * s.rounded;
  // Factor 2 for the roundings of the products, their difference and the bound itself.
  const double error =
      2.0 * (bound(p, q) + bound(r, s)) + 4.0 * kRoundoff * (std::abs(pq) + std::abs(rs));
  if (pq - rs > error) return 1;
  if (pq - rs < -error) return -1;
  return (p.exact() * q.exact() - r.exact() * s.exact()).sign();
}

int sign_of_dot(const Difference& a, const Difference& b) {
  Expansion sum;
  for (int i = 0; i < 3; ++i) sum = sum + a.exact(i) * b.exact(i);
  return sum.sign();
}

/// What a ray from 0 meets on a face.
enum class Crossing : std::uint8_t {
  even,
  odd,
  touching,   ///< 0 itself is on the face
  ambiguous,  ///< the ray meets an edge or vertex: use another ray
};

Crossing operator^(Crossing a, Crossing b) {
  if (a == Crossing::ambiguous || b == Crossing::ambiguous) return Crossing::ambiguous;
  return a == b ? Crossing::even : Crossing::odd;
}

struct Signs {
  int least = 1, most = -1;
  void add(int sign) { least = std::min(least, sign), most = std::max(most, sign); }
  bool mixed() const { return least < 0 && most > 0; }
  bool zero() const { return least == 0 && most == 0; }
  bool any_zero() const { return least * most == 0; }
};

class Ray {
 public:
  explicit Ray(const Vec3& direction) : d_(direction, Vec3::Zero()) {}

  /// Crossing with a triangle that does not contain 0.
  Crossing triangle(const Difference& a, const Difference& b, const Difference& c) const {
    const Signs side = sides(a, b, c);
    if (side.mixed()) return Crossing::even;
    if (side.any_zero()) return Crossing::ambiguous;
    // The line meets the triangle; the ray meets it if 0 lies on the side where the ray comes from.
    return Determinant(a, b, c).sign() == side.most ? Crossing::odd : Crossing::even;
  }

  /// Crossing with a triangle of the boundary.
  Crossing closed_triangle(const Difference& a, const Difference& b, const Difference& c) const {
    if (Determinant(a, b, c).sign() != 0) return triangle(a, b, c);
    return planar(a, b, c);
  }

  /// Crossing with the bilinear patch through the corners x[2 i + j] = x_ij.
  Crossing patch(const std::array<const Difference*, 4>& x) const {
    const Difference &x00 = *x[0], &x01 = *x[1], &x10 = *x[2], &x11 = *x[3];
    // Barycentric coordinates of 0, times the volume.
    const Determinant b00(x01, x10, x11), b01(x00, x11, x10), b10(x00, x01, x11),
        b11(x00, x10, x01);
    Signs b;
    for (const Determinant* v : {&b00, &b01, &b10, &b11}) b.add(v->sign());
    if (b.zero()) return flat(x00, x01, x10, x11);
    const int side = b.mixed() ? -1 : sign_of_products(b00, b11, b01, b10);
    if (side == 0) return Crossing::touching;
    if (side > 0) return triangle(x01, x10, x00) ^ triangle(x01, x10, x11);
    return triangle(x00, x11, x01) ^ triangle(x00, x11, x10);
  }

 private:
  Signs sides(const Difference& a, const Difference& b, const Difference& c) const {
    Signs side;
    side.add(Determinant(d_, a, b).sign());
    if (!side.mixed()) side.add(Determinant(d_, b, c).sign());
    if (!side.mixed()) side.add(Determinant(d_, c, a).sign());
    return side;
  }

  /// Crossing with a triangle whose plane contains 0: it touches 0 or does not.
  Crossing planar(const Difference& a, const Difference& b, const Difference& c) const {
    const Signs side = sides(a, b, c);
    if (side.mixed()) return Crossing::even;
    if (!side.zero()) return Crossing::touching;
    // Either the corners lie on one line through 0, or the ray lies in their plane.
    if (ray_is_in_plane(a, b, c)) return Crossing::ambiguous;
    const bool around = sign_of_dot(a, b) <= 0 || sign_of_dot(b, c) <= 0 || sign_of_dot(c, a) <= 0;
    return around ? Crossing::touching : Crossing::even;
  }

  /// Whether two of the vectors span a plane that contains the ray.
  bool ray_is_in_plane(const Difference& a, const Difference& b, const Difference& c) const {
    const std::array<std::array<const Difference*, 2>, 3> pairs{{{&a, &b}, {&b, &c}, {&c, &a}}};
    return std::any_of(pairs.begin(), pairs.end(), [&](const auto& p) {
      return Determinant(d_, *p[0], *p[1]).sign() == 0 && !parallel(*p[0], *p[1]);
    });
  }

  static bool parallel(const Difference& a, const Difference& b) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      if ((a.exact(i) * b.exact(j) - a.exact(j) * b.exact(i)).sign() != 0) return false;
    }
    return true;
  }

  /// A patch whose plane contains 0 counts as touching in the hull of its corners, which four
  /// triangles cover.
  Crossing flat(const Difference& a, const Difference& b, const Difference& c,
                const Difference& d) const {
    Crossing found = Crossing::even;
    for (const Crossing part : {planar(a, b, c), planar(a, b, d), planar(a, c, d), planar(b, c, d)})
      if (part == Crossing::touching || found == Crossing::even) found = part;
    return found;
  }

  Difference d_;
};

/// The images of the corners of the parameter domain.
class Boundary {
 public:
  explicit Boundary(const Query& q) : edges_(q.kind == ContactKind::edge_edge) {
    for (const auto* x : {&q.x_t0, &q.x_t1}) {
      for (int k = edges_ ? 2 : 1; k < 4; ++k) {
        corners_[count_++] = {(*x)[0], (*x)[k]};
        if (edges_) corners_[count_++] = {(*x)[1], (*x)[k]};
      }
    }
  }

  /// Whether all corners lie on one side of 0 along an axis: then the whole image does. The sign of
  /// a rounded difference is that of the exact one.
  bool misses_origin() const {
    Vec3 lo = corners_[0].rounded, hi = lo;
    for (int i = 1; i < count_; ++i) {
      lo = lo.cwiseMin(corners_[i].rounded);
      hi = hi.cwiseMax(corners_[i].rounded);
    }
    return lo.maxCoeff() > 0.0 || hi.minCoeff() < 0.0;
  }

  Crossing crossing(const Ray& ray) const {
    Crossing parity = Crossing::even;
    const int faces = edges_ ? 6 : 5;
    for (int i = 0; i < faces; ++i) {
      const Crossing face = edges_ ? edge_edge_face(ray, i) : point_triangle_face(ray, i);
      if (face == Crossing::touching) return face;
      parity = parity ^ face;
    }
    return parity;
  }

 private:
  /// Corners 0, 1, 2 at t = 0 and 3, 4, 5 at t = 1.
  Crossing point_triangle_face(const Ray& ray, int face) const {
    const auto& c = corners_;
    if (face < 2) return ray.closed_triangle(c[3 * face], c[3 * face + 1], c[3 * face + 2]);
    const int i = face - 2, j = (i + 1) % 3;
    return ray.patch({&c[i], &c[j], &c[3 + i], &c[3 + j]});
  }

  /// Corner 4 t + 2 w + s. Face 2 i + k is the one on which bit i is k.
  Crossing edge_edge_face(const Ray& ray, int face) const {
    const int bit = 1 << (face / 2), base = face % 2 == 0 ? 0 : bit;
    const int p = bit == 1 ? 2 : 1, q = bit == 4 ? 2 : 4;
    const auto& c = corners_;
    return ray.patch({&c[base], &c[base + p], &c[base + q], &c[base + p + q]});
  }

  bool edges_;
  int count_ = 0;
  std::array<Difference, 8> corners_;
};

/// The query divided by a power of two that brings its largest coordinate to [1/2, 1); nothing if
/// other coordinates are too small beside it, or would be rounded.
std::optional<Query> scaled_exactly(const Query& query) {
  double largest = 0.0, least = kNoCollision;
  for (const auto* x : {&query.x_t0, &query.x_t1}) {
    for (const Vec3& v : *x) {
      for (const double c : {std::abs(v.x()), std::abs(v.y()), std::abs(v.z())}) {
        largest = std::max(largest, c);
        if (c > 0.0) least = std::min(least, c);
      }
    }
  }
  if (!(largest > 0.0)) return query;
  if (least < kLeastCoordinate * largest) return std::nullopt;
  int exponent = 0;
  std::frexp(largest, &exponent);
  Query q = query;
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x)
      for (int i = 0; i < 3; ++i) v[i] = std::ldexp(v[i], -exponent);
  return q;
}

/// Arbitrary directions with few bits, which keep the expansions short.
const std::array<Vec3, 8> kDirections{{{0.7265625, 0.4453125, -0.5234375},
                                       {-0.3671875, 0.8515625, 0.3828125},
                                       {0.1484375, -0.6328125, 0.7578125},
                                       {-0.5859375, -0.2734375, -0.7734375},
                                       {0.9140625, -0.3359375, 0.2265625},
                                       {-0.1015625, 0.5703125, -0.8203125},
                                       {0.4765625, 0.6796875, 0.5546875},
                                       {-0.8671875, 0.1796875, 0.4609375}}};

class RootParityRule {
 public:
  double time(const Query& query) const { return collides(query) ? 0.0 : kNoCollision; }

  NarrowPhaseTraits traits() const {
    return {.gives_time = false,
            .source =
                "T. Brochu, E. Edwards, R. Bridson, Efficient geometrically exact continuous "
                "collision detection, 2012",
            .limits =
                "Misses an even number of contacts in one step; in-plane motion may raise false "
                "alarms; gives no time."};
  }

 private:
  static bool collides(const Query& query) {
    const std::optional<Query> scaled = scaled_exactly(query);
    const Boundary boundary(scaled.value_or(query));
    if (boundary.misses_origin()) return false;
    if (!scaled) return true;
    for (const Vec3& direction : kDirections) {
      const Crossing found = boundary.crossing(Ray(direction));
      if (found != Crossing::ambiguous) return found != Crossing::even;
    }
    return true;
  }
};

}  // namespace

std::unique_ptr<NarrowPhase> make_ccd_root_parity(const NarrowPhaseConfig& config) {
  detail::refuse_min_separation(config, "ccd_root_parity");
  return detail::per_query(RootParityRule());
}

void register_ccd_root_parity(NarrowPhaseRegistry& registry) {
  registry.add("ccd_root_parity", {}, [](const MethodOptions&) { return make_ccd_root_parity(); });
}

}  // namespace selvedge
