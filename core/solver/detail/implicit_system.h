// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/detail/block_jacobi.h>
#include <selvedge/core/solver/detail/implicit_terms.h>
#include <selvedge/core/solver/detail/multilevel.h>
#include <selvedge/core/solver/detail/piece_momentum.h>
#include <selvedge/core/solver/integrator.h>

#include <memory>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The linear system of one step: (share·M + gain·J) v = M·momentum + h F(at), with J = -τ ∂F/∂v -
/// τ² ∂F/∂x of the forces at the same state.
struct SystemAt {
  ForceState at;                   ///< state at which forces and Jacobians are evaluated
  double h;                        ///< s
  std::span<const Vec3> momentum;  ///< m/s
  double tau;                      ///< s
  double share = 1.0;              ///< > 0
  double gain = 1.0;               ///< > 0
  /// 1 for each particle of a piece whose equations have tau = h, share = 1 and gain = 1 instead.
  /// Empty: none.
  std::span<const char> plain{};
};

/// With these values of `tau` and `gain`, J is the damping part h D or the elastic part h² K, plus
/// 1e-6 of the other one. The part that stays is positive semidefinite if the whole is.
inline constexpr double kPartRatio = 1e6;
inline double damping_tau(double h) { return h / kPartRatio; }
inline constexpr double kDampingGain = kPartRatio;
inline double elastic_tau(double h) { return h * kPartRatio; }
inline constexpr double kElasticGain = 1.0 / (kPartRatio * kPartRatio);

/// Fraction of the single forces below which their sum is rounding error: 1e-16 of a length, and
/// the strain is about a hundredth of a length.
inline constexpr double kRoundingShare = 1e-12;

/// Assembles this system and solves it, including contacts, by conjugate gradients with a multigrid
/// cycle. Matrix, cycle and directions are in single precision; the residuals between which they
/// work are in double precision (iterative refinement: N. J. Higham, "Accuracy and stability of
/// numerical algorithms", 2002, chapter 12), so the solution is as accurate as with double
/// precision throughout. Where single precision makes no progress, conjugate gradients in double
/// precision with block Jacobi continue.
class ImplicitSystem {
 public:
  ImplicitSystem(std::span<const std::unique_ptr<Force>> forces, std::size_t particles,
                 const ImplicitConfig& config);

  /// Starts a step: stores which particles are free, and the velocities they keep without forces.
  void hold(const Particles& particles);
  void assemble(const SystemAt& system);
  /// b += gain·J v, for the system assembled last. Shifts the velocity of linearisation.
  void add_jacobian_times(std::span<const Vec3> v);
  /// Gives these particles other masses than in `hold`; `mass` and `momentum` are of all particles,
  /// in kg and m/s. For the system assembled last.
  void set_mass(std::span<const std::int32_t> particles, std::span<const double> mass,
                std::span<const Vec3> momentum);
  /// b - A v over the free particles, 0 at the others; v of free particles are the old velocities.
  /// Valid until the next call.
  std::span<const Vec3> unbalanced(std::span<const Vec3> v);
  /// The same at these velocities, whatever the old ones are.
  std::span<const Vec3> unbalanced_at(std::span<const Vec3> v);
  /// Norm of b - (A + T) v over the free particles, each divided by the square root of its mass.
  double residual_norm(std::span<const ImplicitTerm> terms, std::span<const Vec3> v);
  /// The scale for residual_norm: the same norm of the impulse of external forces, or of the
  /// rounding error of all forces if that is larger.
  double residual_scale();
  /// The impulses of the forces of the system assembled last at these velocities, contacts left
  /// out. `from`: the velocities to which add_jacobian_times has shifted its linearisation; zero if
  /// it has not. Both share and gain of the system must be those of `assemble`.
  void force_impulses(std::span<const Vec3> v, std::span<const Vec3> from, ForceImpulses& out);
  /// ForceImpulses::all of it.
  void net_impulses(std::span<const Vec3> v, std::vector<Vec3>& out);
  /// As Integrator::solve, to this tolerance.
  SolveReport solve(std::span<const ImplicitTerm> terms, std::span<Vec3> v, double tolerance);

  /// The pieces that springs connect.
  const PieceMomentum& pieces() const { return pieces_; }
  std::span<const Vec3> zeros() const { return zeros_; }
  bool is_free(std::size_t i) const { return free_[i] != 0; }
  const ImplicitConfig& config() const { return config_; }

 private:
  void set_matrix(const SystemAt& system, double tau, double share, double gain);
  void set_changed_matrix();
  void find_heavy(const Particles& particles);
  std::span<const Vec3> for_scale(std::span<const Vec3> x, std::span<Vec3> out) const;
  void add_forces(const ForceState& state, double h);
  /// A residual in single precision, divided by a power of two.
  struct LaneResidual {
    LaneVector r, z;    ///< and its product with the preconditioner
    double unit = 0.0;  ///< of r
    double rz = 0.0;    ///< r·z, in units of the residual itself
  };
  /// Whether a product may be the one that the iteration has updated in single precision.
  enum class Accuracy { any, exact };
  /// A v.
  struct Product {
    std::vector<Vec3> v, av;  // empty if A has changed
    bool exact = false;
  };
  /// The norm in which `scale_` is given.
  enum class Norm { none, multilevel, block_jacobi };

  SolveReport refine(std::span<Vec3> v, double tolerance);
  std::vector<std::int32_t> closed_groups();
  void keep_momentum(std::span<Vec3> v);
  void start(std::span<Vec3> v);
  double squared_above(double least, std::span<const Vec3> x, double share);
  void load(std::span<const Vec3> x, LaneResidual& out);
  int descend(double goal, int most);
  bool take_correction(std::span<Vec3> v, double target, bool loose);
  void set_product(std::span<const Vec3> v);
  bool verify(std::span<const Vec3> v, double target);
  SolveReport iterate(std::span<Vec3> v, double tolerance);
  double start_in_double(std::span<Vec3> v);
  void report_residual(double rz, double target, SolveReport& report) const;

  void residual(std::span<const Vec3> v, std::span<Vec3> out, Accuracy accuracy);
  void find_product(std::span<const Vec3> v, Accuracy accuracy);
  void note_begin();
  bool interpolate_product(std::span<const Vec3> v);
  void mark_non_finite(std::span<Vec3> v) const;
  void set_old_velocities(std::span<const Vec3> v, std::span<Vec3> out) const;
  double dot_free(std::span<const Vec3> x, std::span<const Vec3> y) const;
  void multiply(std::span<const Vec3> x, std::span<Vec3> y);
  bool is_enough(double rz, double target, std::span<const Vec3> v);

  std::span<const std::unique_ptr<Force>> forces_;
  ImplicitConfig config_;
  BlockMatrix a_;
  SystemAt assembled_{};                      // the system of a_
  std::vector<const JacobianRows*> by_rows_;  // scratch of set_matrix
  std::vector<Mat3> other_values_;  // of the pieces that are not plain, while a_ is assembled
  PieceMomentum pieces_;
  std::vector<Vec3> b_;          // right-hand side
  std::vector<Vec3> applied_;    // h Σ |F_k| of external forces, per coordinate
  std::vector<Vec3> magnitude_;  // the same for all forces; determines the rounding error
  std::vector<char> outside_;    // per force: 1 if it couples no particles (an external force)
  std::vector<Vec3> v_old_, zeros_;
  std::vector<double> mass_;
  double share_ = 1.0;
  double light_ = 0.0;                    // kg, harmonic mean of the free particles
  bool has_heavy_ = false;                // see for_scale
  std::vector<char> free_;                // 0: held
  const Followers* followers_ = nullptr;  // of the step; see Particles
  TermOperator terms_;
  Multilevel multilevel_;
  BlockJacobi block_jacobi_;
  Norm scaled_in_ = Norm::none;
  double scale_ = 0.0;
  double largest_ = 0.0;   // greatest r·z since the last residual in double precision
  std::size_t bytes_ = 0;  // moved in this solve
  Product begin_, end_;    // where the last solve began and ended
  LaneResidual lanes_, other_;
  LaneVector direction_, image_, correction_;  // p, (A + T) p, Σ α p
  std::vector<Vec3> r_, p_, r_old_;            // scratch
  std::vector<Vec3> z_, ap_;                   // of iterate(); empty until it runs
};

}  // namespace selvedge::detail
