// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/detail/implicit_system.h>
#include <selvedge/core/solver/integrator.h>

namespace selvedge::detail {

/// An integrator that solves one linear system in a step, for the velocity with which it ends.
class LinearIntegrator : public Integrator {
 public:
  LinearIntegrator(ForceList forces, std::size_t particles, const ImplicitConfig& config)
      : Integrator(std::move(forces), particles), system_(forces_.members(), particles, config) {}

  void begin(const StepStart& start, StepEnd) final {
    system_.hold(start.particles);
    system_.assemble(system_of(start, system_.zeros()));
  }
  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) final {
    return system_.solve(terms, end.mean, looser * system_.config().tolerance);
  }
  std::span<const Vec3> unbalanced(std::span<const Vec3> mean) final {
    return system_.unbalanced(mean);
  }
  bool force_impulses(std::span<const Vec3> mean, ForceImpulses& out) final {
    system_.force_impulses(mean, system_.zeros(), out);
    return true;
  }
  bool net_impulses(std::span<const Vec3> mean, std::vector<Vec3>& out) final {
    system_.net_impulses(mean, out);
    return true;
  }

 private:
  /// The system of the step; `zeros` are velocities.
  virtual SystemAt system_of(const StepStart& start, std::span<const Vec3> zeros) const = 0;

  ImplicitSystem system_;
};

}  // namespace selvedge::detail
