// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/fabric.h>
#include <selvedge/core/types.h>

#include <array>
#include <cstdint>
#include <limits>
#include <span>
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

/// A link between two particles two cells apart, which pushes with the force of a bending moment:
/// the two cells turn by θ = κ d, their ends are r = 2d cos(θ/2) apart, and the moment M(κ) of the
/// strip exerts M w/(d sin(θ/2)) along the chord [Zhang2012]. Slack under tension.
struct ChordLink {
  std::int32_t a, b;
  double spacing;           ///< m, d: the length of a cell, > 0
  double width;             ///< m, w: of the strip that the link represents, > 0
  double rigidity;          ///< N·m, M'(0), > 0
  double onset;             ///< N/m, stiffness before the strip bends; see make_chord_force
  double damping = 0.0;     ///< s, damping force per stiffness and rate of length change, >= 0
  std::int32_t curve = -1;  ///< the shape of M(κ), among the curves; -1: linear

  bool remap(const auto& to) {
    if (curve >= 0) to.template element<SpringCurve>(curve);
    return to.vertex(a) && to.vertex(b);
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
/// append, cut and sewing then carry it. A set may refer to sets before it only.
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
  ElementSet<Tie<4>> layers;  ///< ties from the particles of a dense layer to a sparse one
  /// Ties from the nodes of the surface of a weave to the two yarns that cross there.
  ElementSet<Tie<2>> yarn_ties;
  ElementSet<MembraneTriangle> membranes;  ///< finite elements; springs then only measure strain
  ElementSet<Beam> beams;
  ElementSet<YarnTriangle> yarns;  ///< stretch and shear; springs then only measure strain
  ElementSet<CurvatureCurve> curvature_curves;
  ElementSet<ChordLink> chords;
  ElementSet<Crossing> crossings;
};

namespace detail {
// The compiler refuses this function if it does not name every member of ClothElements.
template <class Elements>
auto tie_sets(Elements& elements) {
  auto& [springs, strain_limit, curves, curve_of_spring, hinges, couples, links, twists,
         hinge_frictions, curvature_frictions, corner_frictions, hanging, layers, yarn_ties,
         membranes, beams, yarns, curvature_curves, chords, crossings] = elements;
  return std::tie(springs, strain_limit, curves, curve_of_spring, hinges, couples, links, twists,
                  hinge_frictions, curvature_frictions, corner_frictions, hanging, layers,
                  yarn_ties, membranes, beams, yarns, curvature_curves, chords, crossings);
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

/// A piece of cloth at rest: the surface that collides, masses, and the elements (springs, hinges,
/// …) that hold it together.
struct ClothMesh : ClothElements {
  TriangleMesh surface;      ///< initial shape
  std::vector<Edge> edges;   ///< unique_edges(surface.triangles)
  std::vector<double> mass;  ///< kg per vertex
};

/// Appends the elements of `from` to those of `to`. Vertex i of `from` is vertex `vertices[i]` of
/// `to`; several may be the same. -1 leaves a vertex out, and with it the elements that have it or
/// refer to such an element. The order of the elements stays. Throws std::invalid_argument unless
/// there is one index for each vertex of `from`.
void add_elements(ClothMesh& to, const ClothMesh& from, std::span<const std::int32_t> vertices);

/// A cloth of layers in parts, all with its vertices: the elements that carry, and those of the
/// dense layers with their ties.
struct LayerParts {
  ClothMesh carrying, local;
};
LayerParts split_layers(const ClothMesh& cloth);

/// Appends `piece` to `all` and returns the index of its first vertex.
std::int32_t append(ClothMesh& all, const ClothMesh& piece);

/// The part of `cloth` with the triangles `inside`, which are triangles of `cloth`, and their
/// vertices, whose order stays. A spring along a new border keeps half its stiffness. A spring that
/// is not a side of a triangle stays if both its ends do. Particles get the mass of their remaining
/// triangles.
ClothMesh cut(const ClothMesh& cloth, std::span<const Triangle> inside);

/// `cloth` with merged vertices: vertex i becomes vertex `number[i]`, of any number of others, and
/// vertex j of the result has the place of vertex `kept[j]`. Masses add up. Springs that come to
/// lie between the same two vertices become one, with the sum of their stiffnesses and the mean
/// rest length at which the two would balance, unless they follow different curves. Elements that
/// would name a vertex twice are left out, and no hinge is added, so that a seam folds freely, as
/// in make_from_pattern. Throws std::invalid_argument if a triangle would name a vertex twice.
ClothMesh merge_vertices(const ClothMesh& cloth, std::span<const std::int32_t> number,
                         std::span<const std::int32_t> kept);

/// The springs that follow `curves[curve]`; -1: those that follow Hooke's law.
std::vector<Spring> springs_of_curve(const ClothMesh& cloth, std::int32_t curve);

/// Particles that follow others, x_i = Σ weight·x_leader, and the leaders, which move by
/// themselves: x = P y, where y are the positions of the leaders. A hanging node follows the two
/// ends of its side; if these hang as well, it follows their leaders.
class Followers {
 public:
  struct Share {
    std::int32_t leader;  ///< number among the leaders
    double weight;        ///< > 0; those of a follower sum to 1
  };

  Followers() = default;
  /// The hanging nodes of a cloth. Throws std::invalid_argument if a node hangs on itself.
  explicit Followers(const ClothMesh& cloth);
  /// The particles of its dense layers, which follow the sparse ones.
  static Followers of_layers(const ClothMesh& cloth);

  bool empty() const { return nodes_.empty(); }
  std::size_t particles() const { return begin_.size() - 1; }
  /// The particles that lead and those that follow, both ascending.
  std::span<const std::int32_t> leaders() const { return leaders_; }
  std::span<const std::int32_t> nodes() const { return nodes_; }
  /// Row i of P; a leader has itself.
  std::span<const Share> shares(std::size_t i) const {
    return std::span(shares_).subspan(begin_[i], begin_[i + 1] - begin_[i]);
  }

  /// y of x.
  std::vector<Vec3> select(std::span<const Vec3> x) const;
  /// x = P y.
  void spread(std::span<const Vec3> y, std::span<Vec3> x) const;
  /// Sets the followers in x from the leaders in x.
  void place(std::span<Vec3> x) const;
  /// to += Pᵀ from, for Vec3 and double.
  template <class T>
  void gather(std::span<const T> from, std::span<T> to) const {
    for (std::size_t i = 0; i < from.size(); ++i)
      for (const Share& s : shares(i)) to[s.leader] += s.weight * from[i];
  }
  /// Restores x = P y after a method has moved single particles. A follower returns to P y, and its
  /// free leaders move so that Σ mass·x, and thus the momentum, is conserved unless a leader is
  /// held. `mass` and `inv_mass` (0: held) of all particles.
  void hand_over(std::span<const double> mass, std::span<const double> inv_mass,
                 std::span<Vec3> x) const;
  /// The same for followers that keep an offset d from P y. A method has moved them from P y + d by
  /// `off`: they stay there, and their leaders in `v` receive the momentum Σ mass·off.
  void push_leaders(std::span<const double> mass, std::span<const double> inv_mass,
                    std::span<const Vec3> off, std::span<Vec3> v) const;

 private:
  void set_rows(std::span<const std::vector<std::pair<std::int32_t, double>>> rows);

  std::vector<std::int32_t> leaders_, nodes_;
  std::vector<std::size_t> begin_{0};
  std::vector<Share> shares_;
};

/// A rectangle in the xy-plane, centred at the origin, of cells_x × cells_y cells. Vertex (i,j) has
/// index j·(cells_x+1)+i.
struct GridConfig {
  double size_x = 1.0, size_y = 1.0;        ///< m, > 0
  std::int32_t cells_x = 50, cells_y = 50;  ///< >= 1
};

/// Rectangular mesh [Provot1995] with structural springs, both diagonals of each cell as shear
/// springs, and hinges for bending. Throws std::invalid_argument naming the bad field and its
/// value.
ClothMesh make_rectangular(const GridConfig& grid, const Material& material);
/// Mesh of nearly equilateral triangles whose edges are springs [VanGelder1998]; hinges resist
/// bending.
ClothMesh make_triangular(const GridConfig& grid, const Material& material);
/// Rectangular mesh with one diagonal spring per cell [Huang2014; survey 2.7]. The diagonals run in
/// the same direction or, if `alternating`, alternate like the fields of a chessboard.
ClothMesh make_simplified(const GridConfig& grid, const Material& material, bool alternating);
/// Structural and shear springs that resist tension only, and links that buckle [ChoiKo2002].
ClothMesh make_responsive(const GridConfig& grid, const Material& material);

/// A disc in the xy-plane, centred at the origin: a central particle and `rings` concentric rings
/// of `spokes` particles. Particle k of ring j has index 1 + (j-1)·spokes + k, j from 1.
struct DiscConfig {
  double radius = 0.15;      ///< m, > 0
  std::int32_t rings = 15;   ///< >= 1
  std::int32_t spokes = 48;  ///< >= 3
};
/// Arc mesh [RusinkoSwan2012; survey 2.10]: ring, radial and diagonal springs.
ClothMesh make_arc(const DiscConfig& disc, const Material& material);
/// An arc mesh with rings of these radii in m, ascending, numbered as in make_arc.
ClothMesh make_rings(const std::vector<double>& radii, std::int32_t spokes,
                     const Material& material);

/// The grid meshes of the survey as their authors define them, each spring with its own constant.
enum class SpringNet { rectangular, simplified, alternating, responsive };
/// Spring constants of a net, N/m, >= 0. Springs with constant 0 are omitted.
struct NetConstants {
  double structural = 0.0, shear = 0.0;
  double flexion = 0.0;     ///< springs across two cells, along rows and columns
  bool half_border = true;  ///< springs on the border represent half a cell
};
/// A net of Hooke springs without hinges. Only density, damping and strain limit are taken from
/// `material`.
ClothMesh make_spring_net(SpringNet net, const GridConfig& grid, const NetConstants& constants,
                          const Material& material);

/// The two layers of a bilayered cloth.
struct LayerConfig {
  std::int32_t ratio = 4;  ///< cells of the dense layer per cell side of the sparse layer, >= 2
  double share = 0.2;      ///< fraction of mass and stiffness of the dense layer, in (0, 1)
  /// N/m³, force per area and distance with which the dense layer returns to the sparse one, > 0. A
  /// smaller value gives longer wrinkles, 2π (share·B/hold)^¼.
  double hold = 2000.0;
};
/// Bilayered mesh [KangCho2002; survey 2.4]: a sparse rectangular net carries; a dense net is
/// visible, collides and wrinkles, and follows the bilinear surface of the sparse one. `grid`
/// describes the dense layer, whose vertices come first; the vertices of the sparse layer follow
/// and belong to no triangle. The sparse layer has the continuum constants of the fabric, and both
/// together have its mass.
ClothMesh make_bilayered(const GridConfig& grid, const LayerConfig& layers,
                         const Material& material);

/// A yarn as an elastic rod of round section.
struct YarnConfig {
  double tex = 20.0;            ///< g/km, > 0
  double density = 909.0;       ///< kg/m³ with the air inside, > 0; 1/1.1 g/cm³ [Peirce1937]
  double modulus = 3.6e9;       ///< Pa, Young's modulus of the section with its air, > 0
  double bending_share = 0.05;  ///< bending rigidity relative to a solid rod, in (0, 1]

  double diameter() const;  ///< m
  double stretch() const;   ///< N, EA
  double bending() const;   ///< N·m², EI
};

/// A weave and its yarns. Warp j floats over the weft yarns i with (i + step·j) mod (over + under)
/// < over: plain 1, 1, 1; twill 2/1 2, 1, 1; satin of 5 4, 1, 2.
struct WeaveConfig {
  std::int32_t over = 1, under = 1;  ///< >= 1
  std::int32_t step = 1;             ///< >= 1, without a common divisor with over + under
  YarnConfig warp, weft;
  double crimp_share = 0.5;  ///< share of the warp in the sum of both crimp heights, in (0, 1)
  double contact = 5000.0;   ///< N/m, stiffness of a crossing against compression, > 0
  double rotation = 5e-6;    ///< N·m per rad, moment that turns one yarn on another, >= 0
  std::int32_t links = 2;    ///< of a yarn between two crossings, even, >= 2

  bool warp_over(std::int32_t i, std::int32_t j) const;
  double warp_crimp() const;  ///< m, height between crest and trough [Peirce1937]
  double weft_crimp() const;  ///< m; both crimps add up to the sum of the diameters
};

/// The particles of a woven swatch. Yarns go on by half a cell beyond their last crossings.
struct WeaveLayout {
  std::int32_t wefts, warps, links;

  WeaveLayout(const GridConfig& grid, const WeaveConfig& weave)
      : wefts(grid.cells_x + 1), warps(grid.cells_y + 1), links(weave.links) {}
  /// Particle of the surface between warp j and weft i.
  std::int32_t middle(std::int32_t i, std::int32_t j) const { return j * wefts + i; }
  /// Particle k of a yarn; particle links/2 + links·i of warp j lies on weft i.
  std::int32_t warp(std::int32_t j, std::int32_t k) const {
    return wefts * warps + j * on_warp() + k;
  }
  std::int32_t weft(std::int32_t i, std::int32_t k) const {
    return wefts * warps + warps * on_warp() + i * on_weft() + k;
  }
  std::int32_t at(std::int32_t crossing) const { return links / 2 + links * crossing; }
  std::int32_t on_warp() const { return links * wefts + 1; }  ///< particles of a warp yarn
  std::int32_t on_weft() const { return links * warps + 1; }
};
/// Particles along the yarns of a weave [Kawabata1973; survey 7.1.3], with a crossing at each
/// vertex of `grid`; warp along x. The surface lies between warp and weft, and its vertices come
/// first, row by row as in make_rectangular; the particles of the yarns belong to no triangle. Of
/// `material` only damping and strain limit are taken. Throws std::invalid_argument also if the
/// yarns are too thick for the cells.
ClothMesh make_weave(const GridConfig& grid, const WeaveConfig& weave, const Material& material);

/// A plain weft knit (jersey) and its yarn.
struct KnitConfig {
  YarnConfig yarn;
  double contact = 5000.0;  ///< N/m, stiffness of an interlock against compression, > 0
  double sliding = 500.0;   ///< N/m, the same against sliding of one yarn on the other, > 0
  double rotation = 1e-5;   ///< N·m per rad, moment that turns one yarn on the other, >= 0
  /// Rigidity against twist over that against bending, > 0. A solid rod has 0.8; fibres that slide
  /// lower the bending more.
  double twist = 5.0;
  std::int32_t links = 2;  ///< of a leg between two interlocks, even, >= 2
};

/// The loop of a plain knit, in plan [Peirce1947]: two arcs of three eighths of the wale spacing
/// about the centre of the head and that of the sinker, which lie half of the course spacing above
/// and below the middle of the loop, and straight legs between them. Lengths along the yarn count
/// from the top of the head, in plan. With the spacings 4 d and 2√3 d of a yarn of diameter d, all
/// yarns touch, and the loop has the length 16.66 d.
struct KnitLoop {
  double wale = 0.0, course = 0.0;  ///< m, spacings across and along the wales
  double radius = 0.0;              ///< m, of the arcs
  double arc = 0.0;                 ///< rad, from the top of the head to the leg
  double leg = 0.0;                 ///< m, straight part of a leg
  /// m, crossings of the head and of the leg with the loop of the next course.
  double head_crossing = 0.0, leg_crossing = 0.0;
  double height = 0.0;  ///< m, from the heads at the back to the legs at the front

  /// Throws std::invalid_argument if a yarn of this diameter (m) does not fit.
  KnitLoop(double wale, double course, double diameter);
  double length() const { return 4.0 * radius * arc + 2.0 * leg; }  ///< m, of a whole loop
  /// Place on the half of the loop from the head down to the right, m from the middle of the loop;
  /// `along` in [0, length()/2]. The legs have z = 0 at the front, heads and sinkers z = -height.
  Vec3 place(double along) const;
};

/// The particles of a knitted swatch: course by course, from the lowest up, and along each from
/// left to right.
struct KnitLayout {
  std::int32_t wales, courses, links;

  KnitLayout(const GridConfig& grid, const KnitConfig& knit)
      : wales(grid.cells_x + 1), courses(grid.cells_y + 1), links(knit.links) {}
  /// Particle of the surface in the middle of a loop.
  std::int32_t middle(std::int32_t wale, std::int32_t course) const {
    return course * wales + wale;
  }
  /// Particle k of a loop: 0 and on_loop() lie at the bottoms of its sinkers, on_loop()/2 on top of
  /// its head.
  std::int32_t on(std::int32_t wale, std::int32_t course, std::int32_t k) const {
    return wales * courses + course * on_course() + wale * on_loop() + k;
  }
  std::int32_t on_loop() const { return 8 * links; }  ///< links of a loop
  std::int32_t on_course() const { return on_loop() * wales + 1; }
};
/// Particles along the loops of a plain knit [Peirce1947; survey 7.1.3], with a loop at each vertex
/// of `grid`; courses along x. The front shows the legs and has the surface, whose vertices come
/// first, row by row as in make_rectangular; the particles of the yarn belong to no triangle. The
/// yarn is set, so the swatch is at rest. Of `material` only damping and strain limit are taken.
/// Throws std::invalid_argument also if the yarn is too thick for the loops.
ClothMesh make_knit(const GridConfig& grid, const KnitConfig& knit, const Material& material);

/// Cloth from any triangle mesh. `rest` (same topology) gives the rest lengths and angles,
/// `surface` the initial positions. Non-manifold edges get no hinge.
ClothMesh make_from_mesh(const TriangleMesh& surface, const TriangleMesh& rest,
                         const Material& material);

/// A plate of isotropic material.
struct PlateConstants {
  double stretch = 500.0;      ///< N/m, Young's modulus times thickness, > 0
  double poisson = 1.0 / 3.0;  ///< in (-1, 1)
  double thickness = 5e-4;     ///< m, > 0; bending by D = stretch·thickness²/(12 (1-poisson²))
};
/// Plate model [WangDevarajan2008; survey 3.1]: springs on the edges of a flat mesh, fitted to a
/// plate, and the residual of the fit.
struct PlateMesh {
  ClothMesh cloth;
  double residual = 0.0;  ///< area-weighted rms of |C_net - C|/|C| of the triangles
  double worst = 0.0;     ///< largest residual of a triangle
};
/// `rest` lies in a plane of constant z. Only density, damping and strain limit are taken from
/// `material`.
PlateMesh make_plate(const TriangleMesh& rest, const PlateConstants& plate,
                     const Material& material);

/// The constants K and C of [survey eq. 3].
struct SupportConstants {
  double stiffness = 50.0;  ///< N/m, > 0; also the stiffness of make_volume_force
  double share = 0.5;       ///< fraction of `stiffness` that the support springs take, in (0, 1)
};
/// A closed surface with a support spring from every vertex to a central particle [survey 2.9]. The
/// central particle is the last one and belongs to no triangle.
ClothMesh make_supported(const TriangleMesh& closed, const SupportConstants& support,
                         const Material& material);

/// Cloth of a garment: `surface` is the sewn shape and `pattern` the flat pieces, in m. Triangle i
/// of the pattern is triangle i of the surface. Springs and hinges are those of the flat pieces.
/// Along a seam each side has its own springs, and the seam folds without resistance. Throws
/// std::invalid_argument if surface and pattern do not match.
ClothMesh make_from_pattern(const TriangleMesh& surface, const TriangleMesh& pattern,
                            const Material& material);

/// A disc of woven cloth with its yarns along x and y, `cells` cells across: the cells of a
/// rectangular mesh whose triangles lie in the disc, with the rim vertices moved onto the circle.
/// `radius` in m. Throws std::invalid_argument under the conditions of make_rectangular and for
/// fewer than 8 cells.
ClothMesh make_woven_disc(double radius, std::int32_t cells, const Material& material);

}  // namespace selvedge
