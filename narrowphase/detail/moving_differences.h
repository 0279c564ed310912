// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace selvedge::detail {

/// Difference vectors of four vertices, from which their common translation cancels. Point p and
/// triangle (a, b, c): x = b - a, y = c - a, z = p - a. Edges (a0, a1) and (b0, b1): x = a1 - a0, y
/// = b1 - b0, z = b0 - a0. The vertices are coplanar where (x cross y) . z = 0.
struct Differences {
  Vec3 x, y, z;

  /// The vertices in the order of Contact::vertex, with a or a0 at the origin.
  std::array<Vec3, 4> vertices(ContactKind kind) const {
    if (kind == ContactKind::edge_edge) return {Vec3::Zero(), x, z, z + y};
    return {z, Vec3::Zero(), x, y};
  }
  double largest() const {
    return x.cwiseAbs().cwiseMax(y.cwiseAbs()).cwiseMax(z.cwiseAbs()).maxCoeff();
  }
};

inline Differences differences(ContactKind kind, const std::array<Vec3, 4>& v) {
  if (kind == ContactKind::edge_edge) return {v[1] - v[0], v[3] - v[2], v[2] - v[0]};
  return {v[2] - v[1], v[3] - v[1], v[0] - v[1]};
}

/// The same over the step: start + t rate.
struct MovingDifferences {
  Differences start, rate;

  explicit MovingDifferences(const Query& q)
      : start(differences(q.kind, q.x_t0)), rate(differences(q.kind, q.x_t1)) {
    rate.x -= start.x, rate.y -= start.y, rate.z -= start.z;
  }
  Differences at(double t) const {
    return {start.x + t * rate.x, start.y + t * rate.y, start.z + t * rate.z};
  }
};

/// Coefficients of (x cross y) . z, powers of t ascending. [Provot1997], survey eq. (40).
inline std::array<double, 4> coplanarity_coefficients(const MovingDifferences& d) {
  const Vec3 n0 = d.start.x.cross(d.start.y), n2 = d.rate.x.cross(d.rate.y);
  const Vec3 n1 = d.start.x.cross(d.rate.y) + d.rate.x.cross(d.start.y);
  return {n0.dot(d.start.z), n1.dot(d.start.z) + n0.dot(d.rate.z),
          n2.dot(d.start.z) + n1.dot(d.rate.z), n2.dot(d.rate.z)};
}

/// Bound of the rounding errors of the cubic's value in [0, 1], relative to |x| |y| |z| (largest
/// coordinates at the ends of the step; the rates are at most twice those). The coefficients are
/// sums of 6, 36, 72 and 48 such products, each with at most 12 roundings of 2^-53.
constexpr double kCoplanarityError = 162.0 * 12.0 * 0x1p-53;

inline double coplanarity_error(const MovingDifferences& d) {
  const Differences end = d.at(1.0);
  const auto largest = [](const Vec3& a, const Vec3& b) {
    return a.cwiseAbs().cwiseMax(b.cwiseAbs()).maxCoeff();
  };
  return kCoplanarityError * largest(d.start.x, end.x) * largest(d.start.y, end.y) *
         largest(d.start.z, end.z);
}

/// Whether the coplanar primitives meet, with barycentric coordinates (edges: parameters) in
/// [-tolerance, 1 + tolerance]. Solves z = v x + w y, or s x - r y = z, with n = x cross y: v nn =
/// s nn = n . (z cross y), w nn = -r nn = n . (x cross z). Triangles without area and parallel
/// edges, nn = 0, do not meet.
inline bool meet(ContactKind kind, const Differences& d, double tolerance) {
  const Vec3 n = d.x.cross(d.y);
  const double nn = n.squaredNorm(), slack = tolerance * nn;
  const double v = n.dot(d.z.cross(d.y)), w = n.dot(d.x.cross(d.z));
  if (!(nn > 0.0 && v >= -slack)) return false;
  if (kind == ContactKind::edge_edge) return v <= nn + slack && -w >= -slack && -w <= nn + slack;
  return w >= -slack && v + w <= nn + slack;
}

/// Whether the primitives are at most `reach` apart. Compares their boxes first: the distance of
/// the boxes along an axis, with one rounding each, exceeds the true distance by at most that
/// rounding.
inline bool nearer(ContactKind kind, const Differences& d, double reach) {
  const std::array<Vec3, 4> v = d.vertices(kind);
  const bool edges = kind == ContactKind::edge_edge;
  Vec3 lo_a = v[0], hi_a = v[0], lo_b = v[2].cwiseMin(v[3]), hi_b = v[2].cwiseMax(v[3]);
  (edges ? lo_a : lo_b) = (edges ? lo_a : lo_b).cwiseMin(v[1]);
  (edges ? hi_a : hi_b) = (edges ? hi_a : hi_b).cwiseMax(v[1]);
  if ((lo_b - hi_a).cwiseMax(lo_a - hi_b).maxCoeff() > reach) return false;
  return closest_points(kind, v).distance <= reach;
}

/// If differences are within these bounds, products of six of them are normal doubles or 0.
constexpr double kLeastExtent = 0x1p-160, kLargestExtent = 0x1p160;

/// The largest difference during the step.
inline double extent(const MovingDifferences& d) {
  return std::max(d.start.largest(), d.at(1.0).largest());
}

/// The query's differences, scaled by 2^-exponent to size about 1 if they are out of range.
inline MovingDifferences differences_in_range(const Query& query, int& exponent) {
  exponent = 0;
  const MovingDifferences d(query);
  const double e = extent(d);
  if (e > kLeastExtent && e < kLargestExtent) return d;
  return MovingDifferences(scaled_query(query, exponent));
}

}  // namespace selvedge::detail
