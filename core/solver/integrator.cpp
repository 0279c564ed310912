// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/integrator.h>

namespace selvedge {

Integrator::Integrator(std::vector<std::unique_ptr<Force>> forces, std::size_t particles)
    : forces_(std::move(forces), particles) {}
Integrator::~Integrator() = default;

double Integrator::stable_step(const Particles& particles, double time, double wanted) {
  if (traits().any_step) return wanted;
  return stable_step(forces_.bound(particles, time), wanted);
}

double Integrator::stable_step(const ModeBound&, double wanted) const { return wanted; }

SolveReport Integrator::solve(std::span<const ImplicitTerm>, StepEnd, double) { return {}; }

std::span<const Vec3> Integrator::unbalanced(std::span<const Vec3>) { return {}; }

void Integrator::accept(const ForceState& state) {
  forces_.accept(state);
  remember(state);
}

void Integrator::save_history(std::vector<double>&) const {}

std::span<const double> Integrator::restore_history(std::span<const double> memory) {
  return memory;
}

void Integrator::save_memory(std::vector<double>& memory) const {
  save_history(memory);
  forces_.save_memory(memory);
}

void Integrator::restore_memory(std::span<const double> memory) {
  const std::size_t all = memory.size();
  memory = forces_.restore_memory(restore_history(memory));
  if (!memory.empty())
    throw std::invalid_argument("the memory of the integrator has " + std::to_string(all) +
                                " numbers, of which " + std::to_string(memory.size()) +
                                " are too many; it belongs to another scene");
}

// Each integrator registers itself in its own file. A new one adds its name to both lists.
void register_bdf2(IntegratorRegistry& registry);
void register_forward_euler(IntegratorRegistry& registry);
void register_imex(IntegratorRegistry& registry);
void register_implicit_blend(IntegratorRegistry& registry);
void register_implicit_desbrun(IntegratorRegistry& registry);
void register_implicit_euler(IntegratorRegistry& registry);
void register_implicit_exact(IntegratorRegistry& registry);
void register_implicit_kang(IntegratorRegistry& registry);
void register_implicit_newton(IntegratorRegistry& registry);
void register_midpoint(IntegratorRegistry& registry);
void register_quasi_static(IntegratorRegistry& registry);
void register_rkf45(IntegratorRegistry& registry);
void register_runge_kutta_4(IntegratorRegistry& registry);
void register_symplectic_euler(IntegratorRegistry& registry);
void register_verlet(IntegratorRegistry& registry);

IntegratorRegistry integrators() {
  IntegratorRegistry registry;
  for (const auto add :
       {register_bdf2, register_forward_euler, register_imex, register_implicit_blend,
        register_implicit_desbrun, register_implicit_euler, register_implicit_exact,
        register_implicit_kang, register_implicit_newton, register_midpoint, register_quasi_static,
        register_rkf45, register_runge_kutta_4, register_symplectic_euler, register_verlet})
    add(registry);
  return registry;
}

}  // namespace selvedge
