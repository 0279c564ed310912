// SPDX-License-Identifier: MIT
//
// Curvature of triangles from the rotation of their edges, after E. Oñate, F. Zárate,
// "Rotation-free triangular plate and shell elements", International Journal for Numerical Methods
// in Engineering 2000 (their basic shell triangle, BST); as the shape operator of a triangle: Y.
// Gingold et al., "A discrete model for inelastic deformation of thin shells", 2004. The mean
// curvature tensor of a triangle is an integral along its border of the slope g across each edge,
//   K = (1/A) Σ_e l_e n_e ⊗ n_e (g_e - g),  g: slope of the triangle itself along n_e,
// and the energy is A/2 K:C:K. Both neighbours share g_e, so the sum of A K over the mesh depends
// only on its border, and a constant moment is in equilibrium on any mesh.
//
// Deviation: BST uses the mean of both triangles' slopes as g_e. That is exact only on some regular
// meshes: with alternating diagonals, a plate bent at 45° would store 3/2 of its energy. For a
// surface of constant curvature K the slopes of the triangles differ from that at the edge midpoint
// by (edge along t, opposite vertices at heights h1, h2 and at o1, o2 along t from the midpoint)
//   K_tt (o² - l²/4)/(2h) + K_tn o + K_nn h/2,
// where the last two terms have the sign of the side. Weighting each slope by the other height
// cancels the K_nn term. The other terms are subtracted, with K fitted to the angles of the five
// edges of both triangles:
//   g_e = (h2 g1 + h1 g2)/(h1 + h2) - (K_tt, K_tn part).
// So K is exact for any constant curvature and linear in the angles of the hinges. The energy is ½
// θᵀ W θ with a constant W that couples the hinges of a triangle and of its neighbours.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/core/cloth/detail/shape_operator.h>
#include <selvedge/core/cloth/detail/topology.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

namespace selvedge::detail {
namespace {

using Vec2 = Eigen::Vector2d;
/// A symmetric 2D tensor as (11, 22, √2 12): the dot product of two is their contraction.
using Tensor = Eigen::Vector3d;
/// Hinges and their contributions per radian.
template <class Value>
using Terms = std::vector<std::pair<std::int32_t, Value>>;

/// Added to the normal equations of the fit, relative to the trace. Six vertices on a conic leave
/// one curvature undetermined; the ridge makes it small instead of unbounded. Elsewhere it changes
/// the correction by a thousandth.
constexpr double kRidge = 1e-3;
/// Upper bound of the correction of an edge's slope, in units of the smaller height; about 1 on
/// good triangles. Slivers are not corrected in full, because they would become stiffer than any
/// neighbour.
constexpr double kLargestCorrection = 4.0;
/// Couplings weaker than this, relative to their hinges, are rounding error.
constexpr double kRounding = 1e-9;

Tensor tensor(const Vec2& a, const Vec2& b) {
  return {a.x() * b.x(), a.y() * b.y(), (a.x() * b.y() + a.y() * b.x()) / std::sqrt(2.0)};
}

/// A hinge unfolded into the plane: the edge from (0,0) to (length,0), v[0] at (s1, h1), v[1] at
/// (s2, -h2).
struct Unfolded {
  double length, s1, s2, h1, h2;
};

Unfolded unfold(const std::array<std::int32_t, 4>& v, std::span<const Vec3> rest) {
  const Vec3 edge = rest[v[3]] - rest[v[2]];
  const double length = edge.norm();
  const Vec3 e = edge / length, to_1 = rest[v[0]] - rest[v[2]], to_2 = rest[v[1]] - rest[v[2]];
  return {length, to_1.dot(e), to_2.dot(e), to_1.cross(e).norm(), to_2.cross(e).norm()};
}

/// A side of a triangle in the plane of that triangle.
struct FacetSide {
  std::int32_t hinge = -1;  ///< -1: free
  /// +1 or -1: the direction in which the hinge's angle bends the triangle's front.
  double sign = 1.0;
  double length = 0.0;
  Vec2 along, across;  ///< unit vectors: v[2] -> v[3] of the hinge, and towards its v[0]
};

struct Facet {
  double area = 0.0;
  std::array<FacetSide, 3> sides;
};

class ShapeOperator {
 public:
  ShapeOperator(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material)
      : cloth_(cloth), rest_(rest), material_(material) {
    const bool level = in_a_level(rest);
    const double mean = 0.5 * (material.bending_stiffness + bending_along_weft(material));
    const double warp = level ? material.bending_stiffness : mean;
    const double weft = level ? bending_along_weft(material) : mean;
    // [Peirce1930] √B = √B_warp c² + √B_weft s² in between. This fixes the twist rigidity, which
    // was not measured.
    rigidity_ = Tensor(warp, weft, std::sqrt(warp * weft)).asDiagonal();
    level_ = level;
  }

  void add() {
    first_ = static_cast<std::int32_t>(cloth_.hinges.size());
    for (const Triangle& t : cloth_.surface.triangles) facets_.push_back(facet(t));
    for (const InteriorEdge& edge : interior_edges(cloth_.surface.triangles)) add_hinge(edge);
    for (std::size_t e = 0; e < edges_.size(); ++e) corrections_.push_back(correction(e));
    if (!material_.bending_curve.empty()) {
      if (!level_)
        throw std::invalid_argument(
            "bending_curve needs the directions of warp and weft, which a rest shape that is not "
            "flat does not have; give a flat \"rest_mesh\" or \"rest_mesh\": \"texture\"");
      bending_shapes_ = add_bending_shapes(cloth_, material_);
    }
    for (const Facet& f : facets_) add_energy(f);
    merge();
  }

 private:
  Facet facet(const Triangle& t) const {
    const Vec3 ab = rest_[t[1]] - rest_[t[0]], ac = rest_[t[2]] - rest_[t[0]];
    const Vec3 normal = ab.cross(ac);
    const Vec3 u = level_ ? Vec3::UnitX() : Vec3(ab.normalized());
    const Vec3 w = normal.normalized().cross(u);
    Facet f;
    f.area = 0.5 * normal.norm();
    for (int k = 0; k < 3; ++k) {
      const Vec3 d = rest_[t[(k + 1) % 3]] - rest_[t[k]];
      FacetSide& side = f.sides[k];
      side.length = d.norm();
      side.along = Vec2(d.dot(u), d.dot(w)) / side.length;
      side.across = Vec2(-side.along.y(), side.along.x());  // into the triangle
    }
    return f;
  }

  void add_hinge(const InteriorEdge& edge) {
    const Dihedral d = dihedral(rest_, edge.v);
    if (!d.valid) return;
    const auto number = static_cast<std::int32_t>(edges_.size());
    edges_.push_back(edge);
    shapes_.push_back(unfold(edge.v, rest_));
    cloth_.hinges.push_back({edge.v, d.angle, 0.0, material_.bending_damping, false});
    for (const int which : {0, 1}) {
      FacetSide& side = side_of(edge, which);
      side.hinge = number;
      const Triangle& t = cloth_.surface.triangles[edge.triangle[which]];
      const auto k = std::find(t.begin(), t.end(), edge.v[2]) - t.begin();
      const bool forward = t[(k + 1) % 3] == edge.v[3];
      side.sign = forward == (which == 0) ? 1.0 : -1.0;
      if (!forward) side.along = -side.along;
      if (which == 1) side.across = -side.across;
    }
  }

  FacetSide& side_of(const InteriorEdge& edge, int which) {
    const Triangle& t = cloth_.surface.triangles[edge.triangle[which]];
    int k = 0;
    while (t[k] == edge.v[which] || t[(k + 1) % 3] == edge.v[which]) ++k;
    return facets_[edge.triangle[which]].sides[k];
  }

  /// Rotation of a hinge per curvature: ½ (P K_tt + 2 Q K_tn + R K_nn).
  Tensor turn_of(std::int32_t hinge, const Vec2& along, const Vec2& across) const {
    const auto& [l, s1, s2, h1, h2] = shapes_[hinge];
    const double p = -s1 * (l - s1) / h1 - s2 * (l - s2) / h2, q = s1 - s2, r = h1 + h2;
    return 0.5 * (p * tensor(along, along) + 2.0 * q * tensor(along, across) +
                  r * tensor(across, across));
  }

  /// The correction of the slope of edge `e` per angle of the five hinges, in the plane and on the
  /// front of its first triangle.
  Terms<double> correction(std::size_t e) {
    const InteriorEdge& edge = edges_[e];
    const FacetSide one = side_of(edge, 0), two = side_of(edge, 1);
    Eigen::Matrix2d turn = one.along * two.along.transpose() + one.across * two.across.transpose();
    Eigen::Matrix<double, 6, 3> rows = Eigen::Matrix<double, 6, 3>::Zero();
    Terms<double> scales;
    const auto add = [&](const FacetSide& side, const Eigen::Matrix2d& q, double sign) {
      if (side.hinge < 0) return;
      rows.row(static_cast<Eigen::Index>(scales.size())) =
          turn_of(side.hinge, q * side.along, q * side.across) / side.length;
      scales.emplace_back(side.hinge, sign * side.sign / side.length);
    };
    for (const FacetSide& side : facets_[edge.triangle[0]].sides)
      add(side, Eigen::Matrix2d::Identity(), 1.0);
    for (const FacetSide& side : facets_[edge.triangle[1]].sides)
      if (side.hinge != one.hinge) add(side, turn, one.sign * two.sign);
    Mat3 normal = rows.transpose() * rows;
    normal.diagonal().array() += kRidge * normal.trace();
    const Tensor off = slope_error(shapes_[e], one);
    const Tensor solved = normal.ldlt().solve(off);
    Terms<double> terms;
    for (std::size_t i = 0; i < scales.size(); ++i)
      terms.emplace_back(scales[i].first,
                         scales[i].second * rows.row(static_cast<Eigen::Index>(i)).dot(solved));
    return terms;
  }

  static Tensor slope_error(const Unfolded& u, const FacetSide& side) {
    const double o1 = u.s1 - 0.5 * u.length, o2 = u.s2 - 0.5 * u.length;
    const double quarter = 0.25 * u.length * u.length, sum = u.h1 + u.h2;
    const double tt =
        0.5 * (u.h2 / u.h1 * (o1 * o1 - quarter) - u.h1 / u.h2 * (o2 * o2 - quarter)) / sum;
    const double tn = (u.h2 * o1 + u.h1 * o2) / sum;
    const double size = elementary::hypot(tt, tn), most = kLargestCorrection * std::min(u.h1, u.h2);
    const double share = size > most ? most / size : 1.0;
    return share * (tt * tensor(side.along, side.along) + tn * tensor(side.along, side.across));
  }

  /// The energy of one triangle, ½ A K:C:K, as couples of hinges.
  void add_energy(const Facet& facet) {
    const Terms<Tensor> curvature = curvature_of(facet);
    const Mat3 c = facet.area * with_free_sides(facet, rigidity_);
    for (const auto& [a, k_a] : curvature)
      for (const auto& [b, k_b] : curvature)
        if (a <= b) entries_.push_back({a, b, k_a.dot(c * k_b)});
    if (material_.bending_friction > 0.0) add_friction(facet, curvature);
    if (!material_.bending_curve.empty()) add_curve(facet, curvature);
  }

  /// Friction against K, HB per area in every direction; free sides have none.
  void add_friction(const Facet& facet, const Terms<Tensor>& curvature) {
    CurvatureFriction friction{held_terms(facet, curvature),
                               material_.bending_friction * facet.area, kYieldCurvature};
    if (!friction.terms.empty()) cloth_.curvature_frictions.push_back(std::move(friction));
  }

  /// The deviation of the measured curves from the plate; free sides have none.
  void add_curve(const Facet& facet, const Terms<Tensor>& curvature) {
    CurvatureCurve curve{held_terms(facet, curvature),
                         facet.area,
                         {rigidity_(0, 0), rigidity_(1, 1)},
                         bending_shapes_};
    if (!curve.terms.empty()) cloth_.curvature_curves.push_back(std::move(curve));
  }

  std::vector<CurvatureFriction::Term> held_terms(const Facet& facet,
                                                  const Terms<Tensor>& curvature) const {
    const Mat3 held = with_free_sides(facet, Mat3::Identity());
    std::map<std::int32_t, Tensor> sums;
    for (const auto& [hinge, k] : curvature)
      sums.try_emplace(hinge, Tensor::Zero()).first->second += held * k;
    std::vector<CurvatureFriction::Term> terms;
    for (const auto& [hinge, k] : sums)
      if (k.norm() * std::sqrt(facet.area) > kRounding) terms.push_back({first_ + hinge, k});
    return terms;
  }

  /// K of a triangle per angle of its hinges; a hinge may occur several times.
  Terms<Tensor> curvature_of(const Facet& facet) {
    Terms<Tensor> curvature;
    for (const FacetSide& side : facet.sides) {
      if (side.hinge < 0) continue;
      const auto e = static_cast<std::size_t>(side.hinge);
      const Tensor unit = side.length / facet.area * tensor(side.across, side.across);
      const bool first = &facet == &facets_[edges_[e].triangle[0]];
      const double sum = shapes_[e].h1 + shapes_[e].h2;
      const double share = (first ? shapes_[e].h1 : shapes_[e].h2) / sum;
      curvature.emplace_back(side.hinge, side.sign * share * unit);
      const double front = first ? 1.0 : -side_of(edges_[e], 0).sign * side.sign;
      for (const auto& [hinge, slope] : corrections_[e])
        curvature.emplace_back(hinge, front * slope * unit);
    }
    return curvature;
  }

  /// C reduced by the free sides, which rotate until no moment acts across them.
  static Mat3 with_free_sides(const Facet& facet, Mat3 c) {
    const double smallest = kRounding * c.trace();
    for (const FacetSide& side : facet.sides) {
      if (side.hinge >= 0) continue;
      const Tensor n = tensor(side.across, side.across), moment = c * n;
      const double own = n.dot(moment);
      if (own > smallest) c -= moment * moment.transpose() / own;
    }
    return c;
  }

  void merge() {
    std::stable_sort(entries_.begin(), entries_.end(), [](const auto& x, const auto& y) {
      return std::tie(x.a, x.b) < std::tie(y.a, y.b);
    });
    for (std::size_t i = 0; i < entries_.size();) {
      HingeCouple sum{entries_[i].a, entries_[i].b, 0.0};
      for (; i < entries_.size() && entries_[i].a == sum.a && entries_[i].b == sum.b; ++i)
        sum.stiffness += entries_[i].stiffness;
      sum.a += first_;
      sum.b += first_;
      if (sum.a == sum.b)
        cloth_.hinges[sum.a].stiffness = sum.stiffness;
      else
        cloth_.couples.push_back(sum);
    }
    std::erase_if(cloth_.couples, [&](const HingeCouple& c) {
      const auto& h = cloth_.hinges;
      return std::abs(c.stiffness) <= kRounding * std::sqrt(h[c.a].stiffness * h[c.b].stiffness);
    });
  }

  ClothMesh& cloth_;
  std::span<const Vec3> rest_;
  const Material& material_;
  Mat3 rigidity_;
  bool level_ = false;
  std::array<std::int32_t, 2> bending_shapes_{};
  std::int32_t first_ = 0;
  std::vector<Facet> facets_;
  std::vector<InteriorEdge> edges_;
  std::vector<Unfolded> shapes_;
  std::vector<Terms<double>> corrections_;
  /// Couplings, with hinges counted from 0; a == b: a hinge itself.
  std::vector<HingeCouple> entries_;
};

}  // namespace

void add_shape_operator(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material) {
  if (material.bending_stiffness <= 0.0) return;
  ShapeOperator(cloth, rest, material).add();
}

}  // namespace selvedge::detail
