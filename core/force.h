// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/block_matrix.h>
#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/particles.h>

#include <memory>
#include <span>
#include <vector>

namespace selvedge {

/// Positions and velocities at which forces are evaluated.
struct ForceState {
  std::span<const Vec3> x, v;
  std::span<const double> mass;
  double time = 0.0;  ///< s
};

/// A force on particles. Deterministic for any number of threads.
class Force {
 public:
  virtual ~Force() = default;

  /// f += force in newtons at (x, v).
  virtual void add_force(const ForceState& state, std::span<Vec3> f) const = 0;
  /// Potential energy in joules; 0 for a force that has none.
  virtual double energy(const ForceState& state) const = 0;
  /// The pairs (i, j), i != j, whose Jacobian blocks are not always zero.
  virtual void add_links(std::vector<Edge>& links) const = 0;
  /// Learns where its blocks lie in `matrix`. Called once before add_jacobian.
  virtual void bind(const BlockMatrix& matrix) = 0;
  /// a += -h ∂f/∂v - h² ∂f/∂x, where the indefinite part of ∂f/∂x is dropped so that the sum stays
  /// positive semidefinite.
  virtual void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const = 0;
  /// The step ended in `state`: a force with a memory (hysteresis) notes it. Others do nothing.
  virtual void accept(const ForceState& /*state*/) {}
  /// Appends what it remembers; a force without a memory appends nothing.
  virtual void save_memory(std::vector<double>& /*memory*/) const {}
  /// Takes back what save_memory gave and returns the rest. Throws std::invalid_argument where
  /// there is less than it needs.
  virtual std::span<const double> restore_memory(std::span<const double> memory) { return memory; }
  /// Adds to each particle the row sums of the block norms of -∂f/∂x (N/m) and -∂f/∂v (N·s/m) at
  /// `state`. Divided by the mass, their largest bound the eigenvalues (Gershgorin), for the step
  /// of explicit integrators.
  virtual void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                                   std::span<double> damping) const = 0;
};

/// Stretch and shear springs after Hooke, with damping on the relative velocity along the spring.
/// f_a = (k (L-L0) + k·damping·dL/dt) (x_b - x_a)/L. [survey eq. 2, 8]
std::unique_ptr<Force> make_hooke_force(std::span<const Spring> springs, std::size_t particles);
/// Bending between two triangles after [Bridson2003], with stiffness at zero curvature:
/// energy ½ k (θ-θ0)², force -k (θ-θ0 + damping·dθ/dt) ∂θ/∂x, θ the angle between the normals.
std::unique_ptr<Force> make_bending_force(std::span<const Hinge> hinges, std::size_t particles);
/// Bending of a triangle mesh as a plate after [OnateZarate2000]: hinges with couples between them,
/// energy ½ (θ-θ0)ᵀ W (θ-θ0), which must not be negative for any angles. Coupled hinges have the
/// same damping.
std::unique_ptr<Force> make_shape_operator_force(std::span<const Hinge> hinges,
                                                 std::span<const HingeCouple> couples,
                                                 std::size_t particles);
/// The same springs by another law than Hooke's: tension only, biphasic, or a tension curve of KES,
/// with a memory where it has a loop.
std::unique_ptr<Force> make_curve_force(std::span<const Spring> springs, const SpringCurve& curve,
                                        std::size_t particles);
/// Bending between two triangles after [Bridson2003] as printed: sin(θ/2) instead of θ.
std::unique_ptr<Force> make_bridson_force(std::span<const Hinge> hinges, std::size_t particles);
/// Links that buckle to an arc [ChoiKo2002; survey eq. 5 mended]; slack under tension.
std::unique_ptr<Force> make_buckling_force(std::span<const BucklingLink> links,
                                           std::size_t particles);
/// Torsional springs between two links at a particle [Dai2003], which are the beams of
/// [VillardBorouchaki2005; survey eq. 4 mended] too.
std::unique_ptr<Force> make_twist_force(std::span<const TwistSpring> springs,
                                        std::size_t particles);
/// Hysteresis of bending and of shear, M = B κ ± HB, the part ±. Has a memory: see Force::accept.
std::unique_ptr<Force> make_hinge_friction(std::span<const HingeFriction> frictions,
                                           std::size_t particles);
std::unique_ptr<Force> make_curvature_friction(std::span<const Hinge> hinges,
                                               std::span<const CurvatureFriction> frictions,
                                               std::size_t particles);
std::unique_ptr<Force> make_corner_friction(std::span<const CornerFriction> frictions,
                                            std::size_t particles);
/// Particles tied to means of others: hanging nodes [VillardBorouchaki2005] and dense layers
/// [KangCho2002].
std::unique_ptr<Force> make_tie_force(std::span<const Tie<2>> ties, std::size_t particles);
std::unique_ptr<Force> make_tie_force(std::span<const Tie<4>> ties, std::size_t particles);
/// How a seam is pulled together.
struct SewingConfig {
  double pull = 50.0;        ///< N/m, ε: force per distance of two particles of a seam, > 0
  double tolerance = 0.005;  ///< m, δ: nearer than this the pull is constant, > 0
  double damping = 0.05;     ///< N·s/m on the rate of the distance, >= 0
};
/// Pulls the two particles of each seam together [ZhongXu2009; survey eq. 10 mended].
std::unique_ptr<Force> make_sewing_force(std::span<const Edge> seams, const SewingConfig& config,
                                         std::size_t particles);
/// Springs of no length to the places of the rest shape, N/m per particle [survey 2.8]: fixed in
/// space, or, with `follow`, going along with the cloth. Throws unless one stiffness is positive.
std::unique_ptr<Force> make_virtual_springs(std::span<const Vec3> rest,
                                            std::span<const double> stiffness, bool follow);
/// Pushes the particles of a closed surface away from particle `centre` as its volume shrinks:
/// f_i = -stiffness ΔV/A u_i, the centre takes the reaction [survey eq. 3 mended]. `rest`: shape
/// whose volume is kept. Has no energy.
std::unique_ptr<Force> make_volume_force(double stiffness, std::int32_t centre,
                                         std::span<const Triangle> triangles,
                                         std::span<const Vec3> rest);
/// All that holds `cloth` together, each by its law; what it has not is not made.
std::vector<std::unique_ptr<Force>> make_internal_forces(const ClothMesh& cloth);

/// f = m·g. [survey eq. 6]
std::unique_ptr<Force> make_gravity(const Vec3& acceleration);

struct AirConfig {
  Vec3 wind = Vec3::Zero();  ///< m/s, air velocity
  double normal_drag =
      0.0;  ///< N·s/m³ per area: f = C A [n·(wind - v)] n per triangle [survey eq. 9, sign mended]
  double viscous_drag = 0.0;  ///< N·s/m³ per area: f = C A (wind - v) per vertex [survey eq. 7]
};
/// Air drag and wind on the triangles of the surface.
std::unique_ptr<Force> make_air_force(const AirConfig& config, std::span<const Triangle> triangles,
                                      std::span<const double> rest_areas, std::size_t particles);

}  // namespace selvedge
