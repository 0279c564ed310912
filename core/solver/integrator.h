// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/registry.h>
#include <selvedge/core/cloth/force.h>

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge {

/// A quadratic coupling of at most four particles, added to the implicit system: A(i,j) +=
/// weight_i·weight_j·matrix and b(i) += weight_i·rhs for particles >= 0. Contacts and friction
/// enter the step in this way. `matrix` is symmetric positive semidefinite.
struct ImplicitTerm {
  std::array<std::int32_t, 4> particle;  ///< -1: not a particle (a vertex of a body)
  std::array<double, 4> weight;
  Mat3 matrix;  ///< kg
  Vec3 rhs;     ///< kg·m/s
};

/// Outcome of a linear or nonlinear solve.
struct SolveReport {
  int iterations = 0;
  double residual = 0.0;  ///< relative, in the norm of the preconditioner
  bool converged = true;
  std::size_t bytes = 0;  ///< that the solver read and wrote, in vectors and matrices
};

/// Settings of the conjugate gradient solver of implicit integrators.
struct ImplicitConfig {
  double tolerance = 1e-4;  ///< relative residual at which the iteration stops
  int max_iterations = 2000;
  /// After a solve to this tolerance, the residual of what nothing holds or touches from outside
  /// has no momentum: the particles that springs and contacts join get the same velocity more.
  bool exact_momentum = false;
};

/// Properties of an integrator.
struct IntegratorTraits {
  std::string_view promise;  ///< guarantee for any cloth
  std::string_view source;   ///< author, title, year
  int order = 1;             ///< order of convergence for smooth motion without contacts
  bool any_step = false;     ///< stable for any step length
  bool is_implicit = false;  ///< solves a system that includes contacts as `ImplicitTerm`s
  /// The end velocity equals the mean velocity of the step, so contacts that change one change the
  /// other.
  bool ends_with_mean = false;
  /// After a rejected attempt of a step, the next one is by a method that gains less energy.
  bool follows_energy = false;
  /// Error of a step as a share of that of implicit Euler, for methods of first order.
  double share_of_euler_error = 1.0;
};

/// State at the start of a step.
struct StepStart {
  const Particles& particles;
  double time;           ///< s
  double h;              ///< s
  bool touched = false;  ///< contacts will act on the step
  /// The particles that they act on, in any order, some more than once; empty: any.
  std::span<const std::int32_t> touched_particles{};
};

/// State at the end of a step, n particles each.
struct StepEnd {
  /// (x⁺ - x)/h, m/s. On input: the prescribed motion of held particles, which is kept, and an
  /// initial guess for the others.
  std::span<Vec3> mean;
  std::span<Vec3> v;  ///< velocity at the end, m/s; not written if traits().ends_with_mean
};

/// Impulses that forces other than contacts gave to each particle in a step, N·s, held particles
/// among them.
struct ForceImpulses {
  std::vector<Vec3> all;
  std::vector<Vec3> external;  ///< of Force::is_external
};

/// A method that advances the cloth by one step of length h. Explicit methods compute the end of
/// the step in `begin`; implicit methods assemble their system there and compute the end in every
/// `solve`. The caller applies the effect of contacts to the end. Only `accept` changes the memory
/// of former steps, so a rejected step can be attempted again with a shorter length.
class Integrator {
 public:
  Integrator(std::vector<std::unique_ptr<Force>> forces, std::size_t particles);
  virtual ~Integrator();

  virtual IntegratorTraits traits() const = 0;
  /// The longest stable step, s, at most `wanted`: up to it a mode x'' = -omega² x - rate x' does
  /// not grow. 0 if the mode grows at every step length; `wanted` if traits().any_step.
  virtual double stable_step(const ModeBound& mode, double wanted) const;
  /// The longest stable step for a cloth, by Gershgorin's bounds.
  virtual double stable_step(const Particles& particles, double time, double wanted);

  /// Before `begin`: improves the mean velocities that the particles are expected to have in a step
  /// of h s, m/s, from the accepted velocities `v` and those at the end of the step under their
  /// weight alone, which `mean` holds. Those of held particles mean nothing. Returns false if
  /// nothing has changed.
  virtual bool expect(double /*h*/, std::span<const Vec3> /*v*/, std::span<Vec3> /*mean*/) {
    return false;
  }
  /// Starts a step. Explicit methods write `end`.
  virtual void begin(const StepStart& start, StepEnd end) = 0;
  /// Computes the end of the step with these contact terms. A solve that only finds out which terms
  /// the next solve needs may use a tolerance `looser` times as large, >= 1. A particle with
  /// non-finite forces gets NaN velocities, and the reported residual is NaN. Explicit methods
  /// leave `end` unchanged.
  virtual SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser);
  /// After `begin`: the impulses that all forces but contacts still exert if free particles keep
  /// their velocities over the step and held ones have those of `mean`, N·s. Contacts that balance
  /// them keep the velocities. Empty: this method does not know them before it solves. Valid until
  /// the next call.
  virtual std::span<const Vec3> unbalanced(std::span<const Vec3> mean);
  /// After the last solve of a step and before `accept`: the impulses of the forces as the solve
  /// has them at these mean velocities. Returns false where the method does not keep them.
  virtual bool force_impulses(std::span<const Vec3> /*mean*/, ForceImpulses& /*out*/) {
    return false;
  }
  /// The same, of all forces together, N·s by particle: ForceImpulses::all.
  virtual bool net_impulses(std::span<const Vec3> /*mean*/, std::vector<Vec3>& /*out*/) {
    return false;
  }
  /// Tells integrator and forces that the step from the last `begin` was accepted and ended in
  /// `state`.
  void accept(const ForceState& state);

  /// Appends the memory of integrator and forces; appends nothing if they have none.
  void save_memory(std::vector<double>& memory) const;
  /// Restores that memory. Throws std::invalid_argument if its size does not match.
  void restore_memory(std::span<const double> memory);

  /// Counts of the accepted steps so far, by the names that result.json has.
  virtual std::map<std::string, double> counters() const { return {}; }

  const ForceSum& forces() const { return forces_; }

 protected:
  virtual void remember(const ForceState& /*end*/) {}
  virtual void save_history(std::vector<double>& memory) const;
  /// Returns the unread rest of `memory`.
  virtual std::span<const double> restore_history(std::span<const double> memory);

  ForceSum forces_;
};

/// The integrators by name. Arguments: the forces, the number of particles, and the settings of the
/// linear solve, which explicit integrators ignore.
using IntegratorRegistry =
    Registry<std::unique_ptr<Integrator>, IntegratorTraits, std::vector<std::unique_ptr<Force>>,
             std::size_t, const ImplicitConfig&>;
IntegratorRegistry integrators();

/// Makes an integrator of this number of particles.
using MakeIntegrator =
    std::function<std::unique_ptr<Integrator>(std::vector<std::unique_ptr<Force>>, std::size_t)>;
/// An integrator of all particles of which some follow others. The one that `make` makes steps the
/// leaders alone: with the forces Pᵀ f(P y), the Jacobian Pᵀ J P, the row sums of Pᵀ M P as masses,
/// and contacts of followers on their leaders. The followers are then placed by x = P y.
std::unique_ptr<Integrator> make_following(const Followers& followers,
                                           std::vector<std::unique_ptr<Force>> forces,
                                           const MakeIntegrator& make);

/// An integrator of a cloth of two layers. `make` makes that of the leaders, the sparse layer, on
/// which `forces` act as in make_following. The dense layer follows, and relaxes under `local`
/// forces alone, by one local iteration per step.
std::unique_ptr<Integrator> make_layered(const Followers& layers,
                                         std::vector<std::unique_ptr<Force>> forces,
                                         std::vector<std::unique_ptr<Force>> local,
                                         const MakeIntegrator& make);

}  // namespace selvedge
