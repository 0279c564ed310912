// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/separating_direction.h>

#include <Eigen/Geometry>

namespace selvedge::detail {
namespace {

/// Unit vector along v, or zero.
Vec3 unit(Vec3 v) {
  const double m = v.cwiseAbs().maxCoeff();
  if (!(m > 0.0)) return Vec3::Zero();
  v /= m;
  return v / v.norm();
}

/// The part of v perpendicular to the unit vector e. Subtracts twice: the component along e that
/// the first subtraction leaves is a rounding error of v, which may exceed the perpendicular part.
Vec3 across(Vec3 v, const Vec3& e) {
  v -= v.dot(e) * e;
  return v - v.dot(e) * e;
}

/// Candidates for the separating direction.
class Candidates {
 public:
  Candidates(bool edges, const std::array<Vec3, 4>& x, const VertexDifferences& w)
      : edges_(edges), x_(x), w_(w) {}

  void offer(const Vec3& n) {
    const double gap = least_along(n, w_) - kGapError;
    if (gap > best_.distance && n.squaredNorm() > 0.5) best_ = {n, gap};
  }

  /// The normal of the plane parallel to both edges, or of the triangle, made perpendicular to the
  /// longer of its edges, along which a tilt would cost most.
  void offer_normals() {
    const Vec3 a = edges_ ? x_[1] - x_[0] : x_[2] - x_[1];
    const Vec3 b = x_[3] - x_[edges_ ? 2 : 1];
    const Vec3& longer = a.squaredNorm() >= b.squaredNorm() ? a : b;
    const Vec3 n = unit(across(unit(unit(a).cross(unit(b))), unit(longer)));
    offer(n);
    offer(-n);
  }

  /// The direction from the edge (tail, head) to the vertex, perpendicular to the edge.
  void offer_vertex_edge(int vertex, int tail, int head, double sign) {
    const Vec3 e = unit(x_[head] - x_[tail]);
    const Vec3 from_tail = x_[vertex] - x_[tail], from_head = x_[vertex] - x_[head];
    // The nearer end gives the smaller rounding error.
    const bool near_tail = from_tail.squaredNorm() <= from_head.squaredNorm();
    offer(sign * unit(across(near_tail ? from_tail : from_head, e)));
  }

  void offer_features() {
    offer_normals();
    if (edges_) {
      offer_vertex_edge(0, 2, 3, 1.0);
      offer_vertex_edge(1, 2, 3, 1.0);
      offer_vertex_edge(2, 0, 1, -1.0);
      offer_vertex_edge(3, 0, 1, -1.0);
    } else {
      offer_vertex_edge(0, 1, 2, 1.0);
      offer_vertex_edge(0, 2, 3, 1.0);
      offer_vertex_edge(0, 3, 1, 1.0);
    }
    for (const Vec3& w : w_) offer(unit(w));
  }

  const SeparatingDirection& best() const { return best_; }

 private:
  bool edges_;
  const std::array<Vec3, 4>& x_;
  const VertexDifferences& w_;
  SeparatingDirection best_;
};

}  // namespace

VertexDifferences vertex_differences(bool edges, const std::array<Vec3, 4>& x) {
  if (edges) return {x[0] - x[2], x[0] - x[3], x[1] - x[2], x[1] - x[3]};
  return {x[0] - x[1], x[0] - x[2], x[0] - x[3], x[0] - x[3]};
}

SeparatingDirection separating_direction(bool edges, const std::array<Vec3, 4>& x,
                                         const VertexDifferences& w) {
  /// A direction that loses less than this fraction of the distance needs no alternative.
  constexpr double kGood = 1.0 - 0x1p-12;
  const ClosestPoints near = edges ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                   : point_triangle_closest(x[0], x[1], x[2], x[3]);
  Candidates candidates(edges, x, w);
  candidates.offer(unit(near.separation));
  if (!(candidates.best().distance >= kGood * near.distance)) candidates.offer_features();
  return candidates.best();
}

}  // namespace selvedge::detail
