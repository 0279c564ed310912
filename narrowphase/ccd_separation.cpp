// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/relative_query.h>
#include <selvedge/narrowphase/detail/separating_direction.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

// First time at which two primitives are no farther apart than d: conservative advancement after
// Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996, with directions in place
// of distances [Mirtich1996].
//
// If n . w_ij >= d |n| for the differences w_ij of all pairs of vertices, the primitives are at
// least d apart, because both are hulls of their vertices. Between two times t0 and t1 the w_ij are
// linear in t. So a vector n that satisfies this at t0 and at t1 satisfies it in between
// ("straight"). A vector n(t) that turns with the primitives ("turning") can satisfy it too: with
// Bernstein coefficients N0, N1, N2 of n, the products are cubics with the coefficients
//   N0.w(t0),  (N0.w(t1) + 2 N1.w(t0)) / 3,  (2 N1.w(t1) + N2.w(t0)) / 3,  N2.w(t1),
// and |n(t)| <= |N0| (1-s)^2 + 2 |N1| s (1-s) + |N2| s^2. If each coefficient is at least d times
// that of this bound, so is the cubic on all of [t0, t1]. Every decision is such a comparison with
// an error bound (kGapError); how n was found does not affect the proof.
//
// Straight steps alone are slow where primitives turn around a place of near contact: about L/d
// steps. Two kinds of turning vectors help. The common normal of the features' lines or plane is
// itself a quadratic in t, and the products with it are the coplanarity cubic; it needs a few steps
// at any d. Where contact is near a boundary, n(t) through the directions at the ends and the
// middle of the interval is off by the third power of its length, which leaves about the cube root
// of L/d. Measured for primitives that turn around a place at 1.3 d during the whole step: over the
// inside, 18 steps on average at L/d = 1e4 and 32 at 1e8; beside a boundary, 28 and 390.

namespace selvedge {
namespace {

using detail::kGapError;
using detail::RelativeQuery;
using detail::VertexDifferences;

/// The method stops when the lower bound of the distance is below d (1 + kEarlyPart) + kEarlyFloor.
/// The bound is below the distance by at most a fraction of 2^-12 (and a few kGapError), so the
/// distance is below d (1 + 2^-6) + 2^-40 L, because L is at least 1/2 here.
constexpr double kEarlyPart = 0x1p-6 - 0x1p-11, kEarlyFloor = 0x1p-42;
/// Both are doubled after each kPatience steps. No query of the tests comes near this number.
constexpr int kPatience = 4096;
/// Straight steps before a turning step is attempted: it costs two directions, and most queries
/// need none.
constexpr int kStraightFirst = 3;
/// Turning normals are scaled to about 1 by at most the inverse of this value. A shorter normal
/// proves nothing; products of the others do not underflow.
constexpr double kLeastNormal = 0x1p-200;
/// Reserve for the roundings of the products of d and |n|: at most 8.
constexpr double kProductReserve = 1.0 + 16.0 * detail::kRoundoff;

class Advancement {
 public:
  Advancement(const RelativeQuery& query, double separation)
      : query_(query),
        apart_((separation + kGapError) * kProductReserve),
        separation_(separation),
        end_(detail::vertex_differences(query.edges, query.x_t1)) {}

  double time() {
    if (apart_on_an_axis()) return kNoCollision;
    Frame here = frame(0.0);
    double length = 1.0;
    for (int steps = 0; here.distance > stop(steps); ++steps) {
      const double straight = straight_until(here);
      if (straight >= 1.0) return kNoCollision;
      length = std::max(length, 2.0 * (straight - here.t));
      if (steps >= kStraightFirst && turn(here, straight, length)) {
        if (here.t >= 1.0) return kNoCollision;
        continue;
      }
      // stop() is farther from d than all roundings, so there is always a step.
      if (straight <= here.t) return here.t;
      if (steps < kStraightFirst) length = 2.0 * (straight - here.t);
      here = frame(straight);
    }
    return here.t;
  }

 private:
  /// The primitives at one time, and a direction that separates them.
  struct Frame {
    double t;
    VertexDifferences w;
    Vec3 n;
    double distance;
  };

  /// The straight proof with the axes, for which no direction has to be computed.
  bool apart_on_an_axis() const {
    const VertexDifferences start =
        detail::vertex_differences(query_.edges, detail::places(query_, 0.0));
    Vec3 least = start[0].cwiseMin(end_[0]), most = start[0].cwiseMax(end_[0]);
    for (int i = 1; i < 4; ++i) {
      least = least.cwiseMin(start[i].cwiseMin(end_[i]));
      most = most.cwiseMax(start[i].cwiseMax(end_[i]));
    }
    return least.maxCoeff() >= apart_ || most.minCoeff() <= -apart_;
  }

  double stop(int steps) const {
    return separation_ + std::ldexp(separation_ * kEarlyPart + kEarlyFloor, steps / kPatience);
  }

  Frame frame(double t) const {
    const std::array<Vec3, 4> x = detail::places(query_, t);
    const VertexDifferences w = detail::vertex_differences(query_.edges, x);
    const auto found = detail::separating_direction(query_.edges, x, w);
    return {t, w, found.n, found.distance};
  }

  /// Whether n separates the primitives at t, and hence at all times since the frame that provided
  /// it.
  bool holds(const Vec3& n, double t) const {
    const auto w = detail::vertex_differences(query_.edges, detail::places(query_, t));
    return detail::least_along(n, w) >= apart_ * n.norm();
  }

  /// A time until which the frame's direction separates the primitives: the time at which the first
  /// of the products falls to d, or slightly earlier if rounding there prevents the proof.
  double straight_until(const Frame& from) const {
    // At the time when the first of the lines falls to this value, two error bounds remain for the
    // proof.
    const double aim = apart_ + 2.0 * kGapError;
    double part = 1.0;
    for (int i = 0; i < 4; ++i) {
      const double a = from.n.dot(from.w[i]), b = from.n.dot(end_[i]);
      if (b < aim) part = std::min(part, (a - aim) / (a - b));
    }
    // Each attempt halves the step, and stops below the resolution of t.
    for (part = std::min(part, 1.0); part > detail::kRoundoff; part *= 0.5) {
      const double t = std::min(1.0, from.t + part * (1.0 - from.t));
      if (t > from.t && holds(from.n, t)) return t;
    }
    return from.t;
  }

  /// Advances `here` by `length` with a turning direction if that is farther than `straight` and
  /// proven; adapts the length.
  bool turn(Frame& here, double straight, double& length) const {
    const double t = std::min(1.0, here.t + length);
    if (!(t > straight)) return false;
    const Frame end = frame(t);
    bool proven = apart_between(here, end, turning_normal(here, end));
    if (!proven) {
      const Frame middle = frame(here.t + 0.5 * (t - here.t));
      proven = apart_between(here, end, {here.n, 2.0 * middle.n - 0.5 * (here.n + end.n), end.n});
    }
    length *= proven ? 2.0 : 0.5;
    if (proven) here = end;
    return proven;
  }

  /// The Bernstein coefficients of n(t).
  using Turning = std::array<Vec3, 3>;

  /// X x Y for the edges X, Y or two sides of the triangle, which are linear in t, pointing to the
  /// first primitive; scaled to about 1 to avoid underflow.
  Turning turning_normal(const Frame& a, const Frame& b) const {
    const auto sides = [&](const VertexDifferences& w) {
      return std::pair<Vec3, Vec3>(query_.edges ? w[2] - w[0] : w[0] - w[1],
                                   query_.edges ? w[0] - w[1] : w[0] - w[2]);
    };
    const auto [x0, y0] = sides(a.w);
    const auto [x1, y1] = sides(b.w);
    Turning n{x0.cross(y0), 0.5 * (x0.cross(y1) + x1.cross(y0)), x1.cross(y1)};
    const double size = std::max(n[0].cwiseAbs().maxCoeff(), n[2].cwiseAbs().maxCoeff());
    const double factor = (n[0].dot(a.w[0]) < 0.0 ? -1.0 : 1.0) / std::max(size, kLeastNormal);
    for (Vec3& v : n) v *= factor;
    return n;
  }

  bool apart_between(const Frame& a, const Frame& b, const Turning& n) const {
    const double d0 = apart_ * n[0].norm(), d1 = apart_ * n[1].norm(), d2 = apart_ * n[2].norm();
    const double first = d0 + 2.0 * d1, second = 2.0 * d1 + d2;
    bool apart = std::min(d0, d2) > apart_ * kLeastNormal;
    for (int i = 0; i < 4; ++i) {
      const Vec3 &v = a.w[i], &w = b.w[i];
      apart = apart && n[0].dot(v) >= d0 && n[0].dot(w) + 2.0 * n[1].dot(v) >= first &&
              2.0 * n[1].dot(w) + n[2].dot(v) >= second && n[2].dot(w) >= d2;
    }
    return apart;
  }

  const RelativeQuery& query_;
  double apart_;  ///< d plus the error bound
  double separation_;
  VertexDifferences end_;
};

/// Sets the normal to the direction from the second primitive's closest point to the first's at the
/// time of the contact. A contact whose distance is all rounding error keeps its normal.
void turn_to_closest_points(const SurfaceView& a, const SurfaceView& b, Contact& contact) {
  const bool swapped = contact.kind == ContactKind::triangle_point;
  const Query query =
      detail::query_of(a, b, {contact.kind, contact.vertex, swapped ? 1 : 0, swapped ? 0 : 1});
  const RelativeQuery relative = detail::relative_query(query);
  const auto x = detail::places(relative, contact.toi);
  const ClosestPoints near = detail::closest_points(query.kind, x);
  if (near.distance > kGapError) contact.normal = near.separation / near.distance;
}

class CcdSeparation final : public NarrowPhase {
 public:
  explicit CcdSeparation(double separation) : separation_(separation) {}

  void find_times(std::span<const Query> queries, std::span<double> toi) const override {
    for (std::size_t i = 0; i < queries.size(); ++i) {
      detail::require_finite(queries[i]);
      toi[i] = time(queries[i]);
    }
  }

  /// The primitives are apart at the time of the contact, so their closest points give the normal.
  void find_contacts(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                     std::vector<Contact>& out) const override {
    NarrowPhase::find_contacts(a, b, pairs, out);
    for (Contact& contact : out) turn_to_closest_points(a, b, contact);
  }

  NarrowPhaseTraits traits() const override {
    return {.misses_nothing = true,
            .source =
                "B. Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996; "
                "conservative advancement along proven directions",
            .limits = "Stops where the distance is at most 1/64 above the separation."};
  }

 private:
  double time(const Query& query) const {
    const RelativeQuery relative = detail::relative_query(query);
    if (relative.one_point) return 0.0;
    return Advancement(relative, detail::scaled_up(separation_, relative)).time();
  }

  double separation_;
};

}  // namespace

std::unique_ptr<NarrowPhase> make_ccd_separation(double min_separation) {
  detail::require_separation(min_separation, "ccd_separation");
  return std::make_unique<CcdSeparation>(min_separation);
}

}  // namespace selvedge
