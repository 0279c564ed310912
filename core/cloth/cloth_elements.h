// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/core/cloth/fabric.h>

#include <array>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

namespace selvedge {

/// Changes every index of `v` to the new index of that vertex. False if one of them is left out.
template <std::size_t N>
bool remap_vertices(std::array<std::int32_t, N>& v, const auto& to) {
  bool all = true;
  for (std::int32_t& i : v) all = to.vertex(i) && all;
  return all;
}

// Every element has a member `remap`, which changes its indices to new ones. `to` has the functions
// `vertex(i)`, for the index of a vertex, and `element<T>(i)`, for the index of an element of type
// T. Both change i and return false if there is no new index; so does `remap` if the element does
// not survive. See `add_elements`.

/// A spring between two particles.
struct Spring {
  std::int32_t a, b;
  double rest_length;    ///< m, > 0
  double stiffness;      ///< N/m, force per length change, > 0
  double damping = 0.0;  ///< s, damping force per stiffness and rate of length change, >= 0

  bool remap(const auto& to) { return to.vertex(a) && to.vertex(b); }
};

/// Two triangles that share the edge v[2]-v[3]; v[0] and v[1] are the opposite vertices. The
/// triangles need not belong to the surface.
struct Hinge {
  std::array<std::int32_t, 4> v;
  double rest_angle;     ///< rad, 0 if the rest shape is flat
  double stiffness;      ///< N·m, energy ½·stiffness·(angle - rest_angle)²
  double damping = 0.0;  ///< s, damping moment per stiffness and rate of angle, >= 0
  bool sine = false;  ///< use the moment 2 stiffness (sin θ/2 - sin θ0/2) instead [Bridson2003]

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// Couples two hinges of a plate, given by index. Adds to their own energies the energy
/// stiffness·(angle_a - rest_a)·(angle_b - rest_b), N·m, of either sign.
struct HingeCouple {
  std::int32_t a, b;
  double stiffness;

  bool remap(const auto& to) {
    return to.template element<Hinge>(a) && to.template element<Hinge>(b);
  }
};

/// A link between two particles two cells apart. It buckles under compression and is slack under
/// tension [ChoiKo2002, type 2].
struct BucklingLink {
  std::int32_t a, b;
  double rest_length;    ///< m, > 0
  double rigidity;       ///< N·m², bending stiffness of the strip that the link represents, > 0
  double onset;          ///< N/m, stiffness before buckling, above 4π² rigidity/rest_length³
  double damping = 0.0;  ///< s, damping force per stiffness and rate of length change, >= 0

  bool remap(const auto& to) { return to.vertex(a) && to.vertex(b); }
};

/// A torsional spring at particle v[1] between its links to v[0] and v[2]. `rest_angle` is the
/// turning angle of the path v[0] -> v[1] -> v[2]: 0 if it is straight, π/2 between warp and weft.
struct TwistSpring {
  std::array<std::int32_t, 3> v;
  double rest_angle;     ///< rad, in [0, π)
  double stiffness;      ///< N·m per rad
  double damping = 0.0;  ///< s, damping moment per stiffness and rate of angle, >= 0

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// Two beams in a row, v[0] -> v[1] and v[1] -> v[2], straight at rest. The displacement of the end
/// of one from the straight continuation of the other bends both [VillardBorouchaki2005].
struct Beam {
  std::array<std::int32_t, 3> v;
  std::array<double, 2> length;  ///< m, of the two beams at rest, > 0
  double rigidity;               ///< N·m², EI of the strip that they represent, > 0
  double damping = 0.0;  ///< s, damping force per stiffness and rate of the displacement, >= 0

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// Hysteresis of a hinge: a moment that opposes rotation and grows to `moment` over the angle
/// `yield`.
struct HingeFriction {
  std::array<std::int32_t, 4> v;  ///< as in Hinge
  double rest_angle;              ///< rad, angle at which the friction sticks initially
  double moment;                  ///< N·m, >= 0
  double yield;                   ///< rad, > 0

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// Hysteresis of the curvature of one triangle of a plate: a moment that opposes a change of
/// curvature and grows to `moment` over the curvature change `yield`. The curvature is linear in
/// the angles of hinges.
struct CurvatureFriction {
  struct Term {
    std::int32_t hinge;  ///< index of the hinge
    Vec3 curvature;      ///< 1/m per radian of angle beyond the rest angle: (11, 22, √2 12)
  };
  std::vector<Term> terms;
  double moment;  ///< N·m², work per change of curvature: HB times the area, >= 0
  double yield;   ///< 1/m, > 0

  /// Drops the terms of hinges that are left out. False if no term remains.
  bool remap(const auto& to) {
    if (terms.empty()) return true;
    auto end = terms.begin();
    for (Term& term : terms)
      if (to.template element<Hinge>(term.hinge)) *end++ = term;
    terms.erase(end, terms.end());
    return !terms.empty();
  }
};

/// Hysteresis of a torsional spring; the fields mean the same as in HingeFriction.
struct CornerFriction {
  std::array<std::int32_t, 3> v;  ///< as in TwistSpring
  double rest_angle, moment, yield;

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// A node v[0] in the middle of the side v[1]-v[2] of a coarser cell: x(v[0]) = ½ (x(v[1]) +
/// x(v[2])), a constraint of every step (see Followers).
struct HangingNode {
  std::array<std::int32_t, 3> v;

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// A vertex v[0] of a rigid body: x(v[0]) = Σ weight[k]·x(v[k+1]), a constraint of every step (see
/// Followers). Those of weight 0 are not looked at.
struct RigidVertex {
  std::array<std::int32_t, 5> v;
  std::array<double, 4> weight;  ///< of either sign; they sum to 1

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// Ties particle v[0] to the weighted mean of N others by a spring of zero rest length to
/// Σ weight[k]·x(v[k+1]).
template <int N>
struct Tie {
  std::array<std::int32_t, N + 1> v;
  std::array<double, N> weight;  ///< the weights sum to 1
  double stiffness;              ///< N/m, > 0
  double damping = 0.0;          ///< s, damping force per stiffness and rate of distance, >= 0

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// Parameters of a spring law other than Hooke's.
struct SpringCurve {
  std::string law = "hooke";  ///< name of the stretch law
  double strain = 0.0;        ///< biphasic: strain at which the spring stiffens; kawabata: EMT/100
  double shape = 0.0;         ///< biphasic: growth of the stiffness per strain; kawabata: LT
  double resilience = 1.0;    ///< kawabata: RT/100, recovered fraction of the work, in (0, 1]
  MonotoneCurve measured{};   ///< measured: gives the shape, the spring its stiffness at rest
  bool idle = false;          ///< triangles follow the law, and the springs only measure strain
  bool operator==(const SpringCurve&) const = default;

  /// A cloth has each curve once, however many pieces it is made of.
  static constexpr bool kUnique = true;
  bool remap(const auto&) { return true; }
};

/// The strain of a MembraneTriangle: Green's, or linear in the frame of the triangle.
enum class MembraneStrain : std::uint8_t { green, corotated };

/// A triangle of constant strain that carries stretch and shear as a sheet.
struct MembraneTriangle {
  std::array<std::int32_t, 3> v;
  std::array<std::array<double, 2>, 3> rest;  ///< m, vertices along warp and weft
  double c11, c22, c12, c33;                  ///< N/m, constants as in ContinuumConstants
  double damping = 0.0;                       ///< s, damping stress per stiffness and strain rate
  MembraneStrain strain = MembraneStrain::corotated;

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// A triangle of woven cloth. Its deformation gradient gives the lengths of warp and weft, each of
/// which resists stretch, and the angle between them, which resists shear.
struct YarnTriangle {
  std::array<std::int32_t, 3> v;
  std::array<std::array<double, 2>, 3> rest;  ///< m, vertices along warp and weft
  double warp, weft;                          ///< N/m, stiffness of stretch at rest, > 0
  double shear;                               ///< N/m per rad, stiffness of shear at rest, >= 0
  double friction = 0.0;                      ///< N/m, HG: half the width of the shear loop, >= 0
  double damping = 0.0;  ///< s, damping stress per stiffness and rate of strain or angle, >= 0
  std::array<std::int32_t, 2> curve{0, 0};  ///< the laws of warp and weft, among the curves
  std::int32_t shear_curve = -1;            ///< the curve of shear; -1: linear

  bool remap(const auto& to) {
    for (std::int32_t& c : curve) to.template element<SpringCurve>(c);
    if (shear_curve >= 0) to.template element<SpringCurve>(shear_curve);
    return remap_vertices(v, to);
  }
};

/// Bending along warp and weft by measured curves, on one triangle of a plate or at one hinge of a
/// grid: the energy area·Σ(Ψ(κ) - ½ Ψ''(0) κ²) over both, beside that of the plate, where Ψ' is
/// M(κ).
struct CurvatureCurve {
  std::vector<CurvatureFriction::Term> terms;
  double area;                              ///< m²
  std::array<double, 2> rigidity;           ///< N·m, along warp and weft: Ψ''(0)
  std::array<std::int32_t, 2> curve{0, 0};  ///< the shapes of M(κ), among the curves

  bool remap(const auto& to) {
    for (std::int32_t& c : curve) to.template element<SpringCurve>(c);
    CurvatureFriction friction{terms, 0.0, 0.0};
    const bool stays = friction.remap(to);
    terms = std::move(friction.terms);
    return stays;
  }
};

/// Two links of four particles, v[0] -> v[1] and v[2] -> v[3], which are nearly perpendicular at
/// rest: two yarns that cross, or a yarn and the link to the yarn that it crosses.
struct Crossing {
  std::array<std::int32_t, 4> v;
  double rest_angle;     ///< rad, by which the angle between the links is less than a right one
  double stiffness;      ///< N·m per rad, >= 0
  double damping = 0.0;  ///< s, damping moment per stiffness and rate of angle, >= 0

  bool remap(const auto& to) { return remap_vertices(v, to); }
};

/// Largest strain of a spring, (L-L0)/L0.
struct StrainLimitOfSpring {
  using Element = Spring;
  using Value = double;
  static constexpr Value kDefault = std::numeric_limits<double>::max();
  static void remap(Value&, const auto&) {}
};
/// Index of the curve that a spring follows; -1 for Hooke's law.
struct CurveOfSpring {
  using Element = Spring;
  using Value = std::int32_t;
  static constexpr Value kDefault = -1;
  static void remap(Value& curve, const auto& to) {
    if (curve >= 0) to.template element<SpringCurve>(curve);
  }
};

/// The elements of one kind.
template <class Element>
using ElementSet = std::vector<Element>;

/// One value for each element of another set, in the same order. If empty, every element has the
/// default.
template <class Kind>
struct ElementColumn : std::vector<typename Kind::Value> {
  using std::vector<typename Kind::Value>::vector;
  using std::vector<typename Kind::Value>::operator=;
};

/// The element sets of a cloth. To add a kind of element, add a set here and in `tie_sets` below;
/// append, cut and sewing then carry it. A kind that only
/// one law knows needs neither (detail/law_elements.h). A set may refer to sets before it only.
struct ClothElements {
  ElementSet<Spring> springs;
  ElementColumn<StrainLimitOfSpring> strain_limit;
  ElementSet<SpringCurve> curves;  ///< distinct spring laws other than Hooke's
  ElementColumn<CurveOfSpring> curve_of_spring;
  ElementSet<Hinge> hinges;
  ElementSet<HingeCouple> couples;  ///< empty if the hinges alone model the plate
  ElementSet<BucklingLink> links;
  ElementSet<TwistSpring> twists;
  ElementSet<HingeFriction> hinge_frictions;
  ElementSet<CurvatureFriction> curvature_frictions;
  ElementSet<CornerFriction> corner_frictions;
  ElementSet<HangingNode> hanging;
  ElementSet<RigidVertex> rigid;
  ElementSet<Tie<4>> layers;  ///< ties from the particles of a dense layer to a sparse one
  /// Ties from the nodes of the surface of a weave to the two yarns that cross there.
  ElementSet<Tie<2>> yarn_ties;
  ElementSet<MembraneTriangle> membranes;  ///< finite elements; springs then only measure strain
  ElementSet<Beam> beams;
  ElementSet<YarnTriangle> yarns;  ///< stretch and shear; springs then only measure strain
  ElementSet<CurvatureCurve> curvature_curves;
  ElementSet<Crossing> crossings;
};

namespace detail {
// The compiler refuses this function if it does not name every member of ClothElements.
template <class Elements>
auto tie_sets(Elements& elements) {
  auto& [springs, strain_limit, curves, curve_of_spring, hinges, couples, links, twists,
         hinge_frictions, curvature_frictions, corner_frictions, hanging, rigid, layers, yarn_ties,
         membranes, beams, yarns, curvature_curves, crossings] = elements;
  return std::tie(springs, strain_limit, curves, curve_of_spring, hinges, couples, links, twists,
                  hinge_frictions, curvature_frictions, corner_frictions, hanging, rigid, layers,
                  yarn_ties, membranes, beams, yarns, curvature_curves, crossings);
}
}  // namespace detail

/// References to all element sets, as a tuple.
inline auto element_sets(ClothElements& elements) { return detail::tie_sets(elements); }
inline auto element_sets(const ClothElements& elements) { return detail::tie_sets(elements); }

/// Calls `visit(set)` for each element set in order. `Elements` is a (const) ClothMesh.
template <class Elements>
void for_each_element_set(Elements& elements, auto&& visit) {
  std::apply([&](auto&... set) { (visit(set), ...); }, element_sets(elements));
}

}  // namespace selvedge
