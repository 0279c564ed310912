// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/force_sum.h>

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge {

/// A quadratic coupling of at most four particles that enters the implicit solve beside the
/// forces: A(i,j) += weight_i·weight_j·matrix, b(i) += weight_i·rhs for the particles >= 0. This is
/// how contacts and friction become forces of the step; matrix is symmetric positive semidefinite.
struct ImplicitTerm {
  std::array<std::int32_t, 4> particle;  ///< -1: not a particle (a body vertex)
  std::array<double, 4> weight;
  Mat3 matrix;  ///< kg
  Vec3 rhs;     ///< kg·m/s
};

struct SolveReport {
  int iterations = 0;
  double residual = 0.0;  ///< relative, in the preconditioner's norm
  bool converged = true;
};

struct ImplicitConfig {
  double tolerance = 1e-4;  ///< relative residual at which the conjugate gradients stop
  int max_iterations = 2000;
};

/// What an integrator can be told. Each heeds what its family needs.
struct IntegratorConfig {
  ImplicitConfig solve;  ///< of those that solve a system
  /// `rkf45`: error of position that one inner step may make, m, > 0; of velocity it may be
  /// `error_rate` times as large, 1/s. Less takes more inner steps.
  double error = 1e-6;
  double error_rate = 100.0;
  int max_inner_steps = 100000;  ///< of one step of `rkf45`; what needs more is refused
  double drag = 0.5;    ///< 1/s, γ of `damped_verlet`, >= 0: velocities decay as exp(-γ t)
  int max_newton = 20;  ///< iterations of `implicit_newton` in one solve, >= 1
};

/// What an integrator says of itself.
struct IntegratorTraits {
  std::string_view promise;  ///< what holds whatever the cloth is
  std::string_view source;   ///< author, title, year
  int order = 1;             ///< of convergence of a smooth motion without contact
  bool any_step = false;     ///< stable at any step
  bool is_implicit = false;  ///< solves a system that takes contacts as `ImplicitTerm`s
  /// The velocity at the end is the mean velocity of the step, so that contacts which change the
  /// one change the other.
  bool ends_with_mean = false;
};

/// Where a step starts.
struct StepStart {
  const Particles& particles;
  double time;           ///< s
  double h;              ///< s
  bool touched = false;  ///< contacts will act on the step
};

/// Where it ends, n particles each.
struct StepEnd {
  /// (x⁺ - x)/h, m/s. In: what held particles do, which is kept, and a guess of the others.
  std::span<Vec3> mean;
  std::span<Vec3> v;  ///< at the end, m/s; not written where traits().ends_with_mean
};

/// One method of advancing the cloth by a step of h. Explicit ones have the end of the step after
/// `begin`; implicit ones assemble there and have it after every `solve`. What contacts change of
/// the end is up to the caller. A memory of former steps changes in `accept` alone, so that a step
/// may be tried again, and shorter.
class Integrator {
 public:
  Integrator(std::vector<std::unique_ptr<Force>> forces, std::size_t particles);
  virtual ~Integrator();

  virtual IntegratorTraits traits() const = 0;
  /// The longest step, s, at most `wanted`, up to which a mode x'' = -omega² x - rate x' does not
  /// grow; 0 where it grows in any. `wanted` where traits().any_step.
  virtual double stable_step(const ModeBound& mode, double wanted) const;
  /// The same of a cloth, by Gershgorin's bounds.
  double stable_step(const Particles& particles, double time, double wanted);

  virtual void begin(const StepStart& start, StepEnd end) = 0;
  /// The end with these contacts. A solve whose answer only shows which terms the next one needs
  /// may have a tolerance `looser` times as large, >= 1. A particle whose forces are not finite
  /// gets a velocity that is not a number, and the residual is none either. Explicit methods leave
  /// the end as it is.
  virtual SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser);
  /// The step from the last `begin` was accepted and ended in `state`.
  void accept(const ForceState& state);

  /// Appends what integrator and forces remember; nothing where none does.
  void save_memory(std::vector<double>& memory) const;
  /// The same read back. Throws std::invalid_argument where it does not fit.
  void restore_memory(std::span<const double> memory);

  const ForceSum& forces() const { return forces_; }

 protected:
  virtual void remember() {}
  virtual void save_history(std::vector<double>& memory) const;
  /// Returns what is left of it.
  virtual std::span<const double> restore_history(std::span<const double> memory);

  ForceSum forces_;
};

/// Names and factories.
using IntegratorRegistry =
    std::map<std::string, std::function<std::unique_ptr<Integrator>(
                              std::vector<std::unique_ptr<Force>> forces, std::size_t particles,
                              const IntegratorConfig& config)>>;
IntegratorRegistry integrators();

// Members; each file names its paper. `corrected`: rigid motion is given back what the constant or
// truncated system takes from it.
std::unique_ptr<Integrator> make_forward_euler(std::vector<std::unique_ptr<Force>>, std::size_t);
std::unique_ptr<Integrator> make_symplectic_euler(std::vector<std::unique_ptr<Force>>, std::size_t);
std::unique_ptr<Integrator> make_midpoint(std::vector<std::unique_ptr<Force>>, std::size_t);
std::unique_ptr<Integrator> make_runge_kutta_4(std::vector<std::unique_ptr<Force>>, std::size_t);
std::unique_ptr<Integrator> make_rkf45(std::vector<std::unique_ptr<Force>>, std::size_t,
                                       const IntegratorConfig&);
std::unique_ptr<Integrator> make_verlet(std::vector<std::unique_ptr<Force>>, std::size_t);
std::unique_ptr<Integrator> make_damped_verlet(std::vector<std::unique_ptr<Force>>, std::size_t,
                                               const IntegratorConfig&);
std::unique_ptr<Integrator> make_imex(std::vector<std::unique_ptr<Force>>, std::size_t,
                                      const IntegratorConfig&);
std::unique_ptr<Integrator> make_implicit_euler(std::vector<std::unique_ptr<Force>>, std::size_t,
                                                const IntegratorConfig&);
std::unique_ptr<Integrator> make_implicit_exact(std::vector<std::unique_ptr<Force>>, std::size_t,
                                                const IntegratorConfig&);
std::unique_ptr<Integrator> make_implicit_newton(std::vector<std::unique_ptr<Force>>, std::size_t,
                                                 const IntegratorConfig&);
std::unique_ptr<Integrator> make_bdf2(std::vector<std::unique_ptr<Force>>, std::size_t,
                                      const IntegratorConfig&);
std::unique_ptr<Integrator> make_implicit_desbrun(std::vector<std::unique_ptr<Force>>, std::size_t,
                                                  bool corrected);
std::unique_ptr<Integrator> make_implicit_kang(std::vector<std::unique_ptr<Force>>, std::size_t,
                                               bool corrected);

}  // namespace selvedge
