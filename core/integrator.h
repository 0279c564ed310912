// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/force.h>

#include <memory>
#include <span>
#include <string>
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

/// Linearly implicit Euler [BaraffWitkin1998; survey eq. 38 mended]:
/// (M − h ∂F/∂v − h² ∂F/∂x) v⁺ = M v + h (F(x, 0)),  x⁺ = x + h v⁺.
/// Forces are linear in v by contract; solving for v⁺ makes the damping part exact.
class ImplicitEuler {
 public:
  ImplicitEuler(std::vector<std::unique_ptr<Force>> forces, std::size_t particles,
                const ImplicitConfig& config);
  ~ImplicitEuler();
  ImplicitEuler(ImplicitEuler&&) noexcept;

  /// Assembles the system of one step of h seconds at time `time`. Constant until the next call.
  void assemble(const Particles& particles, double time, double h);
  /// Solves for the end-of-step velocities. In: `v` holds the guess, and for particles with
  /// inv_mass 0 the prescribed velocity, which is kept. May be called several times per assemble;
  /// a solve whose answer only shows which terms the next one needs may have a tolerance `looser`
  /// times as large, >= 1. A particle whose forces are not finite gets a velocity that is not a
  /// number, and the residual is none either.
  SolveReport solve(std::span<const ImplicitTerm> terms, std::span<Vec3> v, double looser = 1.0);
  /// Tells the forces that a step ended in `state`, for those with a memory.
  void accept(const ForceState& state);

 private:
  struct System;
  std::unique_ptr<System> system_;
};

/// Symplectic (semi-implicit) Euler: v⁺ = v + h a(x, v), x⁺ = x + h v⁺ [survey eq. 14].
/// Stable for h·ω < 2. `stable_step` is the bound 2/sqrt(λ_max) by Gershgorin, damping included.
class SymplecticEuler {
 public:
  explicit SymplecticEuler(std::vector<std::unique_ptr<Force>> forces, std::size_t particles);

  /// Largest safe step in seconds for these particles.
  double stable_step(const Particles& particles) const;
  /// End-of-step velocities; those with inv_mass 0 keep what `v` holds. `v` in: anything.
  void step(const Particles& particles, double time, double h, std::span<Vec3> v);
  /// Tells the forces that a step ended in `state`, for those with a memory.
  void accept(const ForceState& state);

 private:
  std::vector<std::unique_ptr<Force>> forces_;
  std::vector<Vec3> f_;
};

}  // namespace selvedge
