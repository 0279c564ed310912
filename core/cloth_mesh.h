// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/material.h>
#include <selvedge/core/triangle_mesh.h>

#include <vector>

namespace selvedge {

/// A spring between two particles.
struct Spring {
  std::int32_t a, b;
  double rest_length;    ///< m, > 0
  double stiffness;      ///< N/m, force per length change, > 0
  double damping = 0.0;  ///< s, damping force per stiffness and rate of length, >= 0
};

/// Two triangles that share an edge: the edge v[2]-v[3], the opposite vertices v[0] and v[1]. They
/// need not be triangles of the surface.
struct Hinge {
  std::array<std::int32_t, 4> v;
  double rest_angle;     ///< rad, 0 where the rest shape is flat
  double stiffness;      ///< N·m, energy ½·stiffness·(angle - rest_angle)²
  double damping = 0.0;  ///< s, damping moment per stiffness and rate of angle, >= 0
  bool sine = false;     ///< moment 2 stiffness (sin θ/2 - sin θ0/2) instead [Bridson2003]
};

/// Two hinges of a plate, by index: energy stiffness·(angle_a - rest_a)·(angle_b - rest_b) on top
/// of their own. N·m, of either sign.
struct HingeCouple {
  std::int32_t a, b;
  double stiffness;
};

/// A link between two particles two cells apart that buckles when it is compressed and is slack
/// when it is stretched [ChoiKo2002, type 2].
struct BucklingLink {
  std::int32_t a, b;
  double rest_length;    ///< m, > 0
  double rigidity;       ///< N·m², bending stiffness of the strip it stands for, > 0
  double onset;          ///< N/m, stiffness before it buckles, above 4π² rigidity/rest_length³
  double damping = 0.0;  ///< s, damping force per stiffness and rate of length, >= 0
};

/// A torsional spring at particle v[1] between its links to v[0] and v[2]: `rest_angle` is how much
/// the way v[0] -> v[1] -> v[2] turns, 0 where it is straight, π/2 between warp and weft.
struct TwistSpring {
  std::array<std::int32_t, 3> v;
  double rest_angle;     ///< rad, in [0, π)
  double stiffness;      ///< N·m per rad
  double damping = 0.0;  ///< s, damping moment per stiffness and rate of angle, >= 0
};

/// Hysteresis at a hinge: a moment against its turning that grows to `moment` over `yield`.
struct HingeFriction {
  std::array<std::int32_t, 4> v;  ///< as in Hinge
  double rest_angle;              ///< rad, where it sticks at first
  double moment;                  ///< N·m, >= 0
  double yield;                   ///< rad, > 0
};
/// Hysteresis of the curvature of a triangle of a plate, which is linear in the angles of hinges: a
/// moment against its change that grows to `moment` over `yield`.
struct CurvatureFriction {
  struct Term {
    std::int32_t hinge;  ///< by index
    Vec3 curvature;      ///< 1/m per radian beyond its rest_angle: (11, 22, √2 12)
  };
  std::vector<Term> terms;
  double moment;  ///< N·m², work per change of curvature: HB times the area, >= 0
  double yield;   ///< 1/m, > 0
};
/// That of HingeFriction at the corner of a twisting spring.
struct CornerFriction {
  std::array<std::int32_t, 3> v;  ///< as in TwistSpring
  double rest_angle, moment, yield;
};

/// A particle v[0] tied to the weighted mean of N others: a spring of no length to
/// Σ weight[k]·x(v[k+1]).
template <int N>
struct Tie {
  std::array<std::int32_t, N + 1> v;
  std::array<double, N> weight;  ///< sum 1
  double stiffness;              ///< N/m, > 0
  double damping = 0.0;          ///< s, damping force per stiffness and rate of distance, >= 0
};

/// What springs do that do not follow Hooke.
struct SpringCurve {
  StretchLaw law = StretchLaw::hooke;
  double strain = 0.0;      ///< biphasic: where it stiffens; kawabata: EMT/100
  double shape = 0.0;       ///< biphasic: growth of the stiffness per strain; kawabata: LT
  double resilience = 1.0;  ///< kawabata: RT/100, share of the work that comes back, in (0, 1]
  bool operator==(const SpringCurve&) const = default;
};

/// A piece of cloth at rest: the surface that collides and the springs and hinges that hold it.
/// Several pieces are joined into one by `append`.
struct ClothMesh {
  TriangleMesh surface;     ///< initial shape
  std::vector<Edge> edges;  ///< unique_edges(surface.triangles)
  std::vector<Spring> springs;
  std::vector<Hinge> hinges;
  std::vector<HingeCouple> couples;  ///< of hinges, where these alone are no plate
  std::vector<double> mass;          ///< kg per vertex
  std::vector<double> strain_limit;  ///< per spring, largest (L-L0)/L0
  std::vector<BucklingLink> links;
  std::vector<TwistSpring> twists;
  std::vector<HingeFriction> hinge_frictions;
  std::vector<CurvatureFriction> curvature_frictions;
  std::vector<CornerFriction> corner_frictions;
  std::vector<Tie<2>> hanging;      ///< nodes in the middle of an edge of a coarser cell
  std::vector<Tie<4>> layers;       ///< particles of a dense layer, tied to a sparse one
  std::vector<SpringCurve> curves;  ///< laws of springs other than Hooke's, each once
  std::vector<std::int32_t>
      curve_of_spring;  ///< per spring an index into `curves`, -1: Hooke; empty: all Hooke
};

/// A rectangle in the xy-plane, centred at the origin, cells_x × cells_y cells, vertex (i,j) at
/// index j·(cells_x+1)+i.
struct GridConfig {
  double size_x = 1.0, size_y = 1.0;        ///< m, > 0
  std::int32_t cells_x = 50, cells_y = 50;  ///< >= 1
};

/// Rectangular mesh [Provot1995]: structural and both shear springs; bending by hinges.
/// Throws std::invalid_argument naming the bad field and its value.
ClothMesh make_rectangular(const GridConfig& grid, const Material& material);
/// Near-equilateral triangles: edges are springs [VanGelder1998]; bending by hinges.
ClothMesh make_triangular(const GridConfig& grid, const Material& material);
/// One diagonal spring per cell [Huang2014; survey 2.7]; all alike, or alternating like a
/// chessboard.
ClothMesh make_simplified(const GridConfig& grid, const Material& material, bool alternating);
/// Structural and shear springs that resist tension only, and links that buckle [ChoiKo2002].
ClothMesh make_responsive(const GridConfig& grid, const Material& material);

/// A disc in the xy-plane, centred at the origin: `rings` concentric rings of `spokes` particles
/// around one in the middle; particle k of ring j at index 1 + (j-1)·spokes + k.
struct DiscConfig {
  double radius = 0.15;      ///< m, > 0
  std::int32_t rings = 15;   ///< >= 1
  std::int32_t spokes = 48;  ///< >= 3
};
/// Arc mesh [RusinkoSwan2012; survey 2.10]: ring, radial and diagonal springs.
ClothMesh make_arc(const DiscConfig& disc, const Material& material);

/// The grid meshes of the survey as their authors have them, each spring with its own constant.
enum class SpringNet { rectangular, simplified, alternating, responsive };
/// Constants of the springs of a net, N/m, >= 0; those of 0 are left out.
struct NetConstants {
  double structural = 0.0, shear = 0.0;
  double flexion = 0.0;     ///< over two cells, along rows and columns
  bool half_border = true;  ///< springs along the border stand for half a cell
};
/// Hooke springs only, no hinges. Of `material` it takes density, damping and strain limit.
ClothMesh make_spring_net(SpringNet net, const GridConfig& grid, const NetConstants& constants,
                          const Material& material);

/// Two layers of one cloth.
struct LayerConfig {
  std::int32_t ratio = 4;  ///< cells of the dense layer per cell of the sparse one and side, >= 2
  double share = 0.2;      ///< of mass and stiffness that the dense layer has, in (0, 1)
  /// N/m³, force per area and distance of the layers, > 0: the smaller, the longer the wrinkles,
  /// 2π (share·B/hold)^¼, and the farther the weight pulls the layers apart.
  double hold = 2000.0;
};
/// Bilayered mesh [KangCho2002; survey 2.4]: a sparse rectangular net, which is most of the cloth,
/// and a dense one, which is seen, collides and wrinkles, tied to the bilinear surface of the
/// first. `grid` is the dense layer, its vertices come first, then those of the sparse one, which
/// belong to no triangle. Together they have the mass and the continuum constants of the fabric.
ClothMesh make_bilayered(const GridConfig& grid, const LayerConfig& layers,
                         const Material& material);

/// Any triangle mesh; `rest` (same topology) gives the rest lengths and angles, `surface` the
/// start. Non-manifold edges get no hinge.
ClothMesh make_from_mesh(const TriangleMesh& surface, const TriangleMesh& rest,
                         const Material& material);

/// A plate of isotropic material.
struct PlateConstants {
  double stretch = 500.0;      ///< N/m, Young's modulus times thickness, > 0
  double poisson = 1.0 / 3.0;  ///< in (-1, 1)
  double thickness = 5e-4;     ///< m, > 0; bending by D = stretch·thickness²/(12 (1-poisson²))
};
/// Plate theory [WangDevarajan2008; survey 3.1]: springs on the edges of a flat mesh fitted
/// to a plate, and what they cannot fit.
struct PlateMesh {
  ClothMesh cloth;
  double residual = 0.0;  ///< area-weighted rms of |C_net - C|/|C| of the triangles
  double worst = 0.0;     ///< the largest of them
};
/// `rest` lies in a plane of constant z. Of `material` it takes density, damping and strain limit.
PlateMesh make_plate(const TriangleMesh& rest, const PlateConstants& plate,
                     const Material& material);

/// K and C of [survey eq. 3].
struct SupportConstants {
  double stiffness = 50.0;  ///< N/m, > 0; also that of make_volume_force
  double share = 0.5;       ///< of it that the support springs have, in (0, 1)
};
/// A closed surface with a spring from every vertex to a particle in the middle, the last one,
/// which belongs to no triangle [survey 2.9].
ClothMesh make_supported(const TriangleMesh& closed, const SupportConstants& support,
                         const Material& material);

/// Adds `piece` to `all`; returns the index of its first vertex.
std::int32_t append(ClothMesh& all, const ClothMesh& piece);

}  // namespace selvedge
