// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/detail/implicit_terms.h>
#include <selvedge/core/detail/piece_momentum.h>
#include <selvedge/core/detail/preconditioner.h>
#include <selvedge/core/integrator.h>

#include <memory>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The linear system of one step: (share·M + gain·J) v = M·momentum + h F(at), where
/// J = -τ ∂F/∂v - τ² ∂F/∂x of the forces at the same state.
struct SystemAt {
  ForceState at;                   ///< where forces and their Jacobians are taken
  double h;                        ///< s
  std::span<const Vec3> momentum;  ///< m/s
  double tau;                      ///< s
  double share = 1.0;              ///< > 0
  double gain = 1.0;               ///< > 0
};

/// With `tau` and `gain` from these, J is its damping part h D or its elastic part h² K alone, each
/// but for a 1e-6 of the other: what is left of positive semidefinite parts is so too.
inline constexpr double part_ratio = 1e6;
inline double damping_tau(double h) { return h / part_ratio; }
inline constexpr double damping_gain = part_ratio;
inline double elastic_tau(double h) { return h * part_ratio; }
inline constexpr double elastic_gain = 1.0 / (part_ratio * part_ratio);

/// Assembles that system and solves it with contacts by preconditioned conjugate gradients.
class ImplicitSystem {
 public:
  ImplicitSystem(std::span<const std::unique_ptr<Force>> forces, std::size_t particles,
                 const ImplicitConfig& config);

  /// A step begins: which particles are free, and the velocities that are kept if nothing acts.
  void hold(const Particles& particles);
  void assemble(const SystemAt& system);
  /// b += gain·J v, of the system assembled last: shifts the velocity at which it was linearised.
  void add_jacobian_times(std::span<const Vec3> v);
  /// |b - (A + T) v| of the free particles, each by the root of its mass; and the same of what the
  /// forces from outside would do alone, or of the share of all forces that rounding leaves.
  double misfit(std::span<const ImplicitTerm> terms, std::span<const Vec3> v);
  double misfit_scale() const;
  /// As Integrator::solve, to this tolerance.
  SolveReport solve(std::span<const ImplicitTerm> terms, std::span<Vec3> v, double tolerance);

  std::span<const Vec3> zeros() const { return zeros_; }
  bool is_free(std::size_t i) const { return free_[i] != 0; }
  const ImplicitConfig& config() const { return config_; }

 private:
  void add_forces(const ForceState& state, double h);
  SolveReport solve(std::span<Vec3> v, double tolerance);
  void residual(std::span<const Vec3> v, std::span<Vec3> out);
  void lose_what_is_not_finite(std::span<Vec3> v) const;
  SolveReport iterate(Preconditioner& by, std::span<Vec3> v, double tolerance);
  void start(Preconditioner& by, std::span<Vec3> v, double& rz);
  bool keeps_velocities(std::span<const Vec3> v) const;
  double squared(Preconditioner& by, std::span<const Vec3> x, std::span<Vec3> scratch);
  double dot_free(std::span<const Vec3> x, std::span<const Vec3> y) const;
  void multiply(std::span<const Vec3> x, std::span<Vec3> y);
  bool is_enough(double rz, double target, std::span<const Vec3> v);

  std::span<const std::unique_ptr<Force>> forces_;
  ImplicitConfig config_;
  BlockMatrix a_;
  PieceMomentum pieces_;
  std::vector<Vec3> b_;          // right-hand side
  std::vector<Vec3> applied_;    // h Σ |F_k| of the forces from outside, per coordinate
  std::vector<Vec3> magnitude_;  // the same of all forces: what is rounded
  std::vector<char> outside_;    // of each force: it couples no particles
  std::vector<Vec3> v_old_, zeros_;
  std::vector<double> mass_;
  double share_ = 1.0;
  std::vector<char> free_;  // 0: held
  TermOperator terms_;
  std::unique_ptr<Preconditioner> preconditioner_ = make_multilevel();
  std::unique_ptr<Preconditioner> fallback_;   // made when first needed
  const Preconditioner* scaled_by_ = nullptr;  // whose norm `scale_` is in; null: not yet
  double scale_ = 0.0;
  std::vector<Vec3> r_, z_, p_, ap_, r_old_, z_old_;  // scratch of the conjugate gradients
};

}  // namespace selvedge::detail
