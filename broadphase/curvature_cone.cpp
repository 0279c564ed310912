// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/patch_cull.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

// Curvature cone with contour test after P. Volino, N. Magnenat-Thalmann, Efficient self-collision
// detection on smoothly discretized surface animations using geometrical shape regularity, 1994,
// over the whole step as in M. Tang, S. Curtis, S.-E. Yoon, D. Manocha, ICCD: interactive
// continuous collision detection between deformable models using connectivity-based culling, 2009.
// [survey] (after Provot 1997) tests only the normals. That is not sufficient: a ramp that winds
// twice about an axis has all its normals in a narrow cone and collides with itself. Hence the
// contour test.
//
// Let a patch be a connected surface of triangles with consistent orientation and one contour that
// visits no vertex twice, and project it along a direction. If at a time t
//   (1) every projected triangle has positive area,
//   (2) the projected contour does not cross itself,
// the projection is one to one: at each inner point it is locally of degree at least 1, and its
// degree at a point of the plane is the winding number of the contour, which is at most 1. If also
//   (3) every altitude of every projected triangle exceeds d, and
//   (4) in the plane no vertex of the contour comes within d of an edge of it that does not end
//       there,
// then primitives without a common vertex are farther apart than d. Proof: in the plane, the
// distance of two disjoint primitives of a triangulation is that of a vertex v and an edge e or a
// triangle. Walk from v straight to the nearest point of the other. Before the walk leaves the
// triangles around v it has covered an altitude, more than d (3). If it leaves the patch earlier,
// it leaves from v itself (a contour edge opposite to v is an altitude away), so v is on the
// contour, and it re-enters through a contour edge that does not end in v (edges are straight),
// more than d away (4). Distances in space are not less than in the plane.
//
// (1) and (3) are one condition on polynomials of degree 2 in t in Bernstein form: twice the area
// exceeds d times the longest side. (2) and (4) hold during the step if any two contour edges
// without a common vertex are separated by more than d along some direction at both ends of the
// step, and likewise the outer end of each of two neighbouring edges from the other edge.

namespace selvedge {
namespace {

using detail::Patches;
using Vec2 = Eigen::Vector2d;

constexpr double kRoundoff = 0x1p-53;
/// Rounding of a projected coordinate in units of u times the largest coordinate difference: for
/// each of three terms a difference, a product and two sums, plus a reserve.
constexpr double kProjectionError = 16.0;
/// The two directions of a projection are orthonormal except for some roundings, by which the plane
/// may stretch distances.
constexpr double kStretch = 1.0 + 16.0 * kRoundoff;

/// The vertices of a patch relative to its first one, projected along `along`.
class Projection {
 public:
  Projection(const SurfaceView& surface, std::int32_t reference, const Vec3& along)
      : surface_(surface), origin_(surface.x_t0[reference]) {
    const Vec3 unit = along.normalized();
    int least = 0;
    unit.cwiseAbs().minCoeff(&least);
    e1_ = unit.cross(Vec3::Unit(least)).normalized();
    e2_ = unit.cross(e1_);
  }

  Vec2 at_t0(std::int32_t v) const { return project(surface_.x_t0[v]); }
  Vec2 at_t1(std::int32_t v) const { return project(surface_.x_t1[v]); }
  /// Largest coordinate difference in the projection of v.
  double reach(std::int32_t v) const {
    return std::max((surface_.x_t0[v] - origin_).lpNorm<Eigen::Infinity>(),
                    (surface_.x_t1[v] - origin_).lpNorm<Eigen::Infinity>());
  }

 private:
  Vec2 project(const Vec3& x) const {
    const Vec3 r = x - origin_;
    return {r.dot(e1_), r.dot(e2_)};
  }

  const SurfaceView& surface_;
  Vec3 origin_, e1_, e2_;
};

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A point or an edge of the contour over the step.
struct Mover {
  Vec2 a0, b0, a1, b1;  ///< two ends (equal for a point), at t = 0 and t = 1
  Vec2 lo, hi;          ///< box over the step

  Mover(const Vec2& p0, const Vec2& q0, const Vec2& p1, const Vec2& q1)
      : a0(p0), b0(q0), a1(p1), b1(q1) {
    lo = p0.cwiseMin(q0).cwiseMin(p1).cwiseMin(q1);
    hi = p0.cwiseMax(q0).cwiseMax(p1).cwiseMax(q1);
  }
};

/// The shortest vector from the segment (a, b) to the segment (c, d), which do not cross.
Vec2 shortest_way(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  Vec2 best = c - a;
  const auto try_point = [&](const Vec2& p, const Vec2& q, const Vec2& r, double sign) {
    const Vec2 qr = r - q;
    const double length = qr.squaredNorm();
    const double s = length > 0.0 ? std::clamp((p - q).dot(qr) / length, 0.0, 1.0) : 0.0;
    const Vec2 way = sign * (q + s * qr - p);
    if (way.squaredNorm() < best.squaredNorm()) best = way;
  };
  try_point(a, c, d, 1.0);
  try_point(b, c, d, 1.0);
  try_point(c, a, b, -1.0);
  try_point(d, a, b, -1.0);
  return best;
}

/// Whether the two are more than `distance` apart along one direction during the whole step; tests
/// one guessed direction. `error` bounds the rounding of the coordinates.
bool are_apart(const Mover& p, const Mover& q, double distance, double error) {
  const Vec2 way = shortest_way(0.5 * (p.a0 + p.a1), 0.5 * (p.b0 + p.b1), 0.5 * (q.a0 + q.a1),
                                0.5 * (q.b0 + q.b1));
  const double length = way.norm();
  if (!(length > 0.0)) return false;
  const Vec2 u = way / length;
  const double start = std::min(q.a0.dot(u), q.b0.dot(u)) - std::max(p.a0.dot(u), p.b0.dot(u));
  const double end = std::min(q.a1.dot(u), q.b1.dot(u)) - std::max(p.a1.dot(u), p.b1.dot(u));
  // Covers two coordinates on each side and their sums.
  constexpr double kReserve = 8.0;
  return std::min(start, end) > distance + kReserve * error;
}

class CurvatureCone final : public detail::PatchCull {
 public:
  BroadPhaseTraits traits() const override {
    return {.pairs = PairSet::culled,
            .source =
                "P. Volino, N. Magnenat-Thalmann, Efficient self-collision detection on "
                "smoothly discretized surface animations using geometrical shape regularity, "
                "1994; over the step after M. Tang and others, 2009"};
  }

  std::size_t bytes() const override {
    return PatchCull::bytes() + normals_.capacity() * sizeof(Vec3);
  }

 private:
  /// Prefix sums of the area normals at half time, so that the sum below any node is a difference.
  void begin(const SurfaceView& surface) override {
    const auto order = patches().order();
    normals_.resize(order.size() + 1);
    normals_[0] = Vec3::Zero();
    for (std::size_t p = 0; p < order.size(); ++p) {
      const Triangle& t = surface.triangles[order[p]];
      const auto middle = [&](int k) {
        return Vec3(0.5 * surface.x_t0[t[k]] + 0.5 * surface.x_t1[t[k]]);
      };
      const Vec3 a = middle(0);
      normals_[p + 1] = normals_[p] + (middle(1) - a).cross(middle(2) - a);
    }
  }

  bool cannot_meet_itself(const SurfaceView& surface, const Patches::Patch& patch) const override {
    if (!patch.is_disc_like) return false;
    const Vec3 along = normals_[patch.end] - normals_[patch.begin];
    // Also rejects values that overflow.
    if (!(along.squaredNorm() > 0.0 && std::isfinite(along.squaredNorm()))) return false;
    const std::int32_t reference = patches().contour(patch).front();
    const Projection projection(surface, reference, along);
    const double distance = kStretch * (2.0 * surface.thickness);
    double error = 0.0;
    return all_altitudes_exceed(surface, patch, projection, distance, error) &&
           contour_keeps_apart(patch, projection, distance, error);
  }

  /// (1) and (3); sets the error of projected coordinates.
  bool all_altitudes_exceed(const SurfaceView& surface, const Patches::Patch& patch,
                            const Projection& projection, double distance, double& error) const {
    double largest = 0.0;
    for (std::uint32_t i = patch.begin; i < patch.end; ++i) {
      const Triangle& t = surface.triangles[patches().order()[i]];
      std::array<Vec2, 3> x, y;
      for (int k = 0; k < 3; ++k) {
        x[k] = projection.at_t0(t[k]), y[k] = projection.at_t1(t[k]);
        largest = std::max(largest, projection.reach(t[k]));
      }
      // The error grows during the loop: it covers the triangles so far, at the end all of them.
      error = kProjectionError * kRoundoff * largest;
      if (!altitudes_exceed(x, y, distance, error)) return false;
    }
    return std::isfinite(largest);
  }

  static bool altitudes_exceed(const std::array<Vec2, 3>& x, const std::array<Vec2, 3>& y,
                               double distance, double error) {
    const Vec2 a0 = x[1] - x[0], b0 = x[2] - x[0], a1 = y[1] - y[0], b1 = y[2] - y[0];
    const double area =
        std::min({cross(a0, b0), cross(a1, b1), 0.5 * (cross(a0, b1) + cross(a1, b0))});
    const double side = std::max(
        {a0.norm(), b0.norm(), (x[2] - x[1]).norm(), a1.norm(), b1.norm(), (y[2] - y[1]).norm()});
    // Each factor of an area is off by 2 errors and is at most a side; the products round as well.
    constexpr double kReserve = 16.0;
    return area > (distance + kReserve * (error + kRoundoff * side)) * (side + 2.0 * error);
  }

  /// (2) and (4).
  bool contour_keeps_apart(const Patches::Patch& patch, const Projection& projection,
                           double distance, double error) const {
    const auto contour = patches().contour(patch);
    const std::size_t n = contour.size();
    std::vector<Mover> edges;
    edges.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::int32_t v = contour[i], w = contour[(i + 1) % n];
      edges.emplace_back(projection.at_t0(v), projection.at_t0(w), projection.at_t1(v),
                         projection.at_t1(w));
    }
    return neighbours_keep_apart(edges, distance, error) &&
           others_keep_apart(edges, distance, error);
  }

  /// The outer end of each of two neighbouring edges against the other edge.
  static bool neighbours_keep_apart(const std::vector<Mover>& edges, double distance,
                                    double error) {
    const std::size_t n = edges.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Mover &e = edges[i], &f = edges[(i + 1) % n];
      if (!are_apart({e.a0, e.a0, e.a1, e.a1}, f, distance, error) ||
          !are_apart({f.b0, f.b0, f.b1, f.b1}, e, distance, error))
        return false;
    }
    return true;
  }

  /// Edges without a common vertex, by a sweep along x.
  static bool others_keep_apart(const std::vector<Mover>& edges, double distance, double error) {
    const std::size_t n = edges.size();
    const double reach = distance + 2.0 * error;
    std::vector<std::uint32_t> order(n);
    for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<std::uint32_t>(i);
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
      return std::pair(edges[i].lo.x(), i) < std::pair(edges[j].lo.x(), j);
    });
    for (std::size_t i = 0; i < n; ++i) {
      const Mover& e = edges[order[i]];
      for (std::size_t j = i + 1; j < n && edges[order[j]].lo.x() <= e.hi.x() + reach; ++j) {
        const Mover& f = edges[order[j]];
        const std::size_t steps = (order[i] + n - order[j]) % n;
        const bool are_neighbours = steps <= 1 || steps == n - 1;
        if (are_neighbours || f.lo.y() > e.hi.y() + reach || e.lo.y() > f.hi.y() + reach) continue;
        if (!are_apart(e, f, distance, error)) return false;
      }
    }
    return true;
  }

  std::vector<Vec3> normals_;
};

}  // namespace

std::unique_ptr<BroadPhase> make_curvature_cone(const BvhConfig& config) {
  return detail::make_bvh_aabb(config, std::make_unique<CurvatureCone>());
}

void register_curvature_cone(BroadPhaseRegistry& registry) {
  registry.add("curvature_cone", {}, [](const MethodOptions&) { return make_curvature_cone(); });
}

}  // namespace selvedge
