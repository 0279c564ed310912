// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/registry.h>
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/followers.h>

#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge {

/// Square sparse matrix of 3×3 blocks in compressed sparse row form with a fixed pattern; the
/// diagonal blocks are always present. Both triangles are stored so that y = A x runs in parallel
/// by rows.
class BlockMatrix {
 public:
  BlockMatrix() = default;
  /// `links` lists the index pairs (i, j), i != j, for which blocks (i,j) and (j,i) exist.
  BlockMatrix(std::size_t n, std::vector<Edge> links);

  std::size_t size() const { return row_begin_.empty() ? 0 : row_begin_.size() - 1; }
  void set_zero();
  /// Sets the rows [first, last) to zero.
  void set_zero(std::size_t first, std::size_t last);
  /// Position of block (i, j) in the value array. Throws std::out_of_range if the block is absent.
  /// Intended for set-up, not for inner loops.
  std::int32_t slot(std::int32_t i, std::int32_t j) const;
  std::span<Mat3> values() { return values_; }
  std::span<const Mat3> values() const { return values_; }
  const Mat3& diagonal(std::size_t i) const { return values_[diagonal_[i]]; }
  Mat3& diagonal(std::size_t i) { return values_[diagonal_[i]]; }
  /// The pattern: row i has the blocks [row_begin[i], row_begin[i+1]), with ascending columns.
  std::span<const std::int32_t> row_begin() const { return row_begin_; }
  std::span<const std::int32_t> columns() const { return column_; }
  /// y = A x. Multi-threaded; deterministic.
  void multiply(std::span<const Vec3> x, std::span<Vec3> y) const;

 private:
  std::vector<std::int32_t> row_begin_, column_, diagonal_;
  std::vector<Mat3> values_;
};

/// State of the cloth as a structure of arrays, n particles each.
struct Particles {
  std::vector<Vec3> x;           ///< positions, m
  std::vector<Vec3> v;           ///< velocities, m/s
  std::vector<double> mass;      ///< kg, > 0
  std::vector<double> inv_mass;  ///< 1/kg; 0 for a held particle, which moves only as prescribed
  /// The map from these particles to all particles of the cloth if some of those follow others
  /// (hanging nodes, dense layers): these are the leaders, and contact terms use the indices of all
  /// particles. Null if no particle follows others.
  const Followers* followers = nullptr;

  std::size_t size() const { return x.size(); }
};

/// Positions and velocities at which forces are evaluated: x in m, v in m/s, mass in kg.
struct ForceState {
  std::span<const Vec3> x, v;
  std::span<const double> mass;
  double time = 0.0;  ///< s
};

/// A Jacobian that can be added to some rows at a time.
class JacobianRows {
 public:
  virtual ~JacobianRows() = default;
  /// Adds the Jacobian to the rows [first, last). Threads may add to different rows.
  virtual void add_rows(std::size_t first, std::size_t last, BlockMatrix& a) const = 0;
};

/// A force on particles. Deterministic for any number of threads.
class Force {
 public:
  virtual ~Force() = default;

  /// f += force in newtons at (x, v).
  virtual void add_force(const ForceState& state, std::span<Vec3> f) const = 0;
  /// Potential energy in joules; 0 for a force without an energy.
  virtual double energy(const ForceState& state) const = 0;
  /// The pairs (i, j), i != j, whose Jacobian blocks are not always zero.
  virtual void add_links(std::vector<Edge>& links) const = 0;
  /// Stores where the force's blocks lie in `matrix`. Call it once before add_jacobian.
  virtual void bind(const BlockMatrix& matrix) = 0;
  /// a += -h ∂f/∂v - h² ∂f/∂x. The indefinite part of ∂f/∂x is dropped so that the sum stays
  /// positive semidefinite.
  virtual void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const = 0;
  /// What add_jacobian adds, row by row, so that several forces can add to a row while it is in the
  /// cache. Valid until the force computes another Jacobian. Null: the force has only add_jacobian.
  virtual const JacobianRows* jacobian_rows(const ForceState& /*state*/, double /*h*/) const {
    return nullptr;
  }
  /// Whether something outside the cloth takes the reaction (weight, air, springs to places in
  /// space). All other forces keep the momentum of the cloth.
  virtual bool is_external() const { return false; }
  /// Called when a step was accepted and ended in `state`. A force with a memory (hysteresis)
  /// updates it; other forces do nothing.
  virtual void accept(const ForceState& /*state*/) {}
  /// Appends the force's memory; a force without a memory appends nothing.
  virtual void save_memory(std::vector<double>& /*memory*/) const {}
  /// Restores the memory from the front of `memory` and returns the rest. Throws
  /// std::invalid_argument if `memory` is too short.
  virtual std::span<const double> restore_memory(std::span<const double> memory) { return memory; }
  /// Adds to each particle the row sums of the block norms of -∂f/∂x (N/m) and -∂f/∂v (N·s/m) at
  /// `state`. Their maximum divided by the mass bounds the eigenvalues (Gershgorin) and hence the
  /// step of explicit integrators.
  virtual void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                                   std::span<double> damping) const = 0;
  /// The same of the stiffness that ties particles to places in space, as guides do.
  virtual void add_ties(const ForceState& state, std::span<double> stiffness) const {
    if (!is_external()) return;
    std::vector<double> damping(stiffness.size(), 0.0);
    add_stiffness_bound(state, stiffness, damping);
  }
};

/// Stretch and shear springs that follow Hooke's law, with damping of the relative velocity along
/// the spring. f_a = (k (L-L0) + k·damping·dL/dt) (x_b - x_a)/L. [survey eq. 2, 8]
std::unique_ptr<Force> make_hooke_force(std::span<const Spring> springs, std::size_t particles);
/// Bending between two triangles after [Bridson2003], with stiffness at zero curvature: energy ½ k
/// (θ-θ0)², force -k (θ-θ0 + damping·dθ/dt) ∂θ/∂x, where θ is the angle between the normals.
std::unique_ptr<Force> make_bending_force(std::span<const Hinge> hinges, std::size_t particles);
/// Bending of a triangle mesh as a plate after [OnateZarate2000]: coupled hinges with the energy ½
/// (θ-θ0)ᵀ W (θ-θ0). W must be positive semidefinite. Coupled hinges must have the same damping.
std::unique_ptr<Force> make_shape_operator_force(std::span<const Hinge> hinges,
                                                 std::span<const HingeCouple> couples,
                                                 std::size_t particles);
/// Springs with a law other than Hooke's: tension only, biphasic, a KES tension curve or a measured
/// one. A curve with a loop has a memory.
std::unique_ptr<Force> make_curve_force(std::span<const Spring> springs, const SpringCurve& curve,
                                        std::size_t particles);
/// Stretch and shear of triangles as a sheet, by finite elements of constant strain. The strain of
/// the triangles themselves is ignored.
std::unique_ptr<Force> make_membrane_force(std::span<const MembraneTriangle> triangles,
                                           MembraneStrain strain, std::size_t particles);
/// Shear of woven triangles by the angle of warp and weft, and stretch along each of them; a force
/// for each of the laws `curves` that they follow.
std::unique_ptr<Force> make_yarn_shear(std::span<const YarnTriangle> triangles,
                                       std::span<const SpringCurve> curves, std::size_t particles);
std::vector<std::unique_ptr<Force>> make_yarn_stretch(std::span<const YarnTriangle> triangles,
                                                      std::span<const SpringCurve> curves,
                                                      std::size_t particles);
/// Bending between two triangles after [Bridson2003] as printed: with sin(θ/2) instead of θ.
std::unique_ptr<Force> make_bridson_force(std::span<const Hinge> hinges, std::size_t particles);
/// Links that buckle into an arc [ChoiKo2002; survey eq. 5 corrected] and are slack under tension.
std::unique_ptr<Force> make_buckling_force(std::span<const BucklingLink> links,
                                           std::size_t particles);
/// The deviation of measured bending curves from the plate, for the curvature_curves of `cloth`.
std::unique_ptr<Force> make_bending_curves(const ClothMesh& cloth);
/// Torsional springs between two links at a particle [Dai2003].
std::unique_ptr<Force> make_twist_force(std::span<const TwistSpring> springs,
                                        std::size_t particles);
/// Beams along rows of particles [VillardBorouchaki2005; survey eq. 4 corrected]. Linear in the
/// positions.
std::unique_ptr<Force> make_beam_force(std::span<const Beam> beams, std::size_t particles);
/// Yarns that cross at a right angle and resist turning [Kawabata1973].
std::unique_ptr<Force> make_crossing_force(std::span<const Crossing> crossings,
                                           std::size_t particles);
/// Hysteresis of bending and shear: the term ±HB of M = B κ ± HB. Has a memory; see Force::accept.
std::unique_ptr<Force> make_hinge_friction(std::span<const HingeFriction> frictions,
                                           std::size_t particles);
std::unique_ptr<Force> make_curvature_friction(std::span<const Hinge> hinges,
                                               std::span<const CurvatureFriction> frictions,
                                               std::size_t particles);
std::unique_ptr<Force> make_corner_friction(std::span<const CornerFriction> frictions,
                                            std::size_t particles);
std::unique_ptr<Force> make_yarn_friction(std::span<const YarnTriangle> triangles,
                                          std::size_t particles);
/// Ties particles to weighted means of others: dense layers [KangCho2002], and the surface of a
/// weave.
std::unique_ptr<Force> make_tie_force(std::span<const Tie<2>> ties, std::size_t particles);
std::unique_ptr<Force> make_tie_force(std::span<const Tie<4>> ties, std::size_t particles);
/// Parameters of the force that closes a seam.
struct SewingConfig {
  double pull = 50.0;         ///< N/m, ε: force per distance of two particles of a seam, > 0
  double tolerance = 0.005;   ///< m, δ: below this distance the pull is constant, > 0
  double damping = 0.05;      ///< N·s/m, damping of the rate of the distance, >= 0
  double acceleration = 0.0;  ///< m/s², ΔA: relative acceleration of the particles of a seam, >= 0
};
/// Pulls the two particles of each seam together [ZhongXu2009; survey eq. 10 corrected]. `mass` in
/// kg per particle; only needed if `config` has an acceleration.
std::unique_ptr<Force> make_sewing_force(std::span<const Edge> seams, const SewingConfig& config,
                                         std::size_t particles, std::span<const double> mass = {});
/// Springs of zero rest length from each particle to its position in the rest shape, with
/// `stiffness` in N/m per particle [survey 2.8]. The rest shape is fixed in space or, with
/// `follow`, moves rigidly with the cloth. Throws std::invalid_argument unless at least one
/// stiffness is positive.
std::unique_ptr<Force> make_virtual_springs(std::span<const Vec3> rest,
                                            std::span<const double> stiffness, bool follow);
/// Pushes the particles of a closed surface away from particle `centre` when its volume shrinks:
/// f_i = -stiffness ΔV/A u_i; the centre takes the reaction [survey eq. 3 corrected]. `rest` is the
/// shape whose volume is kept. Has no energy.
std::unique_ptr<Force> make_volume_force(double stiffness, std::int32_t centre,
                                         std::span<const Triangle> triangles,
                                         std::span<const Vec3> rest);

/// A particle that something outside guides and pushes: f = push - stiffness (x - place).
struct Guide {
  std::int32_t particle = 0;
  Vec3 place = Vec3::Zero();      ///< m
  Mat3 stiffness = Mat3::Zero();  ///< N/m, symmetric, positive semidefinite
  Vec3 push = Vec3::Zero();       ///< N
};
/// The force of all guides.
std::unique_ptr<Force> make_guides(std::vector<Guide> guides);

/// f = m·g. [survey eq. 6]
std::unique_ptr<Force> make_gravity(const Vec3& acceleration);

/// Turbulence that the wind carries along.
struct AirGusts {
  double speed = 0.0;      ///< m/s, root mean square of each component; 0: none
  double length = 1.0;     ///< m, length over which gusts are correlated along their velocity, > 0
  std::uint64_t seed = 1;  ///< selects the gusts
};
/// A round turbulent jet of air, as from a fan.
struct AirJet {
  Vec3 position = Vec3::Zero();    ///< m, centre of the nozzle
  Vec3 direction = Vec3::UnitX();  ///< of any length but 0
  double speed = 0.0;              ///< m/s, at the nozzle, in the middle
  double diameter = 0.1;           ///< m, of the nozzle, > 0
};
/// Parameters of air drag and of the motion of the air, which is the sum of wind, gusts and jets.
struct AirConfig {
  Vec3 wind = Vec3::Zero();  ///< m/s, uniform velocity
  /// N·s/m³ per area: f = C A [n·(u - v)] n per triangle, u: mean velocity of the air at its
  /// corners [survey eq. 9, sign corrected]
  double normal_drag = 0.0;
  double viscous_drag = 0.0;  ///< N·s/m³ per area: f = C A (u - v) per vertex [survey eq. 7]
  AirGusts gusts = {};
  std::vector<AirJet> jets = {};

  /// Whether the air moves anywhere.
  bool moves() const { return !wind.isZero(0.0) || gusts.speed > 0.0 || !jets.empty(); }
};
/// Drag on the triangles of the surface by the air. The Jacobian leaves out how the velocity of the
/// air changes in space. Throws std::invalid_argument if a parameter is out of its range.
std::unique_ptr<Force> make_air_force(const AirConfig& config, std::span<const Triangle> triangles,
                                      std::span<const double> rest_areas, std::size_t particles);

using ForceList = std::vector<std::unique_ptr<Force>>;

/// Properties of a force law.
struct ForceLawTraits {
  std::string_view promise;  ///< properties of the force
  std::string_view source;   ///< author, title, year
  /// The part of the energy in the results to which the force adds; empty if to none.
  std::string_view energy{};
};
/// The force laws by name. Each makes the forces of the elements of a cloth that follow it; no
/// forces if there are no such elements. Forces that a scene makes from keys of its own, such as
/// gravity, are noted by add_keyed.
using ForceLawRegistry = Registry<ForceList, ForceLawTraits, const ClothMesh&>;
ForceLawRegistry force_laws();

/// Options of force laws by the name of the law. Options that are left out have their defaults.
using ForceLawOptions = std::map<std::string, MethodOptions>;
/// The forces of one law on `cloth`, with those of `options` that are for this law.
ForceList make_forces_of(const ForceLawRegistry::Entry& law, const ClothMesh& cloth,
                         const ForceLawOptions& options);
/// All internal forces of `cloth`, in the order in which the laws were added. They add up in this
/// order. Throws std::invalid_argument if `options` name a law that `laws` does not have, or an
/// option that the law does not have.
ForceList make_internal_forces(const ClothMesh& cloth, const ForceLawRegistry& laws = force_laws(),
                               const ForceLawOptions& options = {});

/// Upper bounds of the modes of the forces on a cloth, x'' = -omega² x - rate x'.
struct ModeBound {
  double omega = 0.0;  ///< rad/s, no mode has a higher frequency
  double rate = 0.0;   ///< 1/s, no mode has a higher damping rate
};

/// The sum of all forces on one cloth, in the form that integrators evaluate.
class ForceSum {
 public:
  ForceSum(std::vector<std::unique_ptr<Force>> forces, std::size_t particles);

  std::size_t particles() const { return stiffness_.size(); }
  std::span<const std::unique_ptr<Force>> members() const { return forces_; }

  /// f = sum of all forces, N.
  void evaluate(const ForceState& state, std::span<Vec3> f) const;
  /// a = f·inv_mass, m/s²; 0 for held particles.
  void accelerate(const ForceState& state, std::span<const double> inv_mass,
                  std::span<Vec3> a) const;
  /// Sum of the potential energies, J.
  double energy(const ForceState& state) const;
  /// Gershgorin's bounds at the current positions, with the held particles at rest.
  ModeBound bound(const Particles& particles, double time);

  /// Tells all forces that a step was accepted and ended in `state`.
  void accept(const ForceState& state);
  /// Appends the memory of all forces.
  void save_memory(std::vector<double>& memory) const;
  /// Restores that memory and returns the rest. Throws std::invalid_argument if `memory` is too
  /// short.
  std::span<const double> restore_memory(std::span<const double> memory);

 private:
  std::vector<std::unique_ptr<Force>> forces_;
  std::vector<double> stiffness_, damping_;  // scratch of `bound`
};

}  // namespace selvedge
