// SPDX-License-Identifier: MIT
#include <selvedge/core/detail/force_checks.h>
#include <selvedge/core/integrator.h>

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

void Integrator::accept(const ForceState& state) {
  forces_.accept(state);
  remember();
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

IntegratorRegistry integrators() {
  using Forces = std::vector<std::unique_ptr<Force>>;
  using Config = IntegratorConfig;
  const auto plain = [](auto make) {
    return [make](Forces f, std::size_t n, const Config&) { return make(std::move(f), n); };
  };
  return {
      {"forward_euler", plain(make_forward_euler)},
      {"symplectic_euler", plain(make_symplectic_euler)},
      {"midpoint", plain(make_midpoint)},
      {"runge_kutta_4", plain(make_runge_kutta_4)},
      {"rkf45", make_rkf45},
      {"verlet", plain(make_verlet)},
      {"damped_verlet", make_damped_verlet},
      {"imex", make_imex},
      {"implicit_euler", make_implicit_euler},
      {"implicit_exact", make_implicit_exact},
      {"implicit_newton", make_implicit_newton},
      {"bdf2", make_bdf2},
      {"implicit_desbrun",
       [](Forces f, std::size_t n, const Config&) {
         return make_implicit_desbrun(std::move(f), n, true);
       }},
      {"implicit_desbrun_uncorrected",
       [](Forces f, std::size_t n, const Config&) {
         return make_implicit_desbrun(std::move(f), n, false);
       }},
      {"implicit_kang", [](Forces f, std::size_t n,
                           const Config&) { return make_implicit_kang(std::move(f), n, true); }},
      {"implicit_kang_as_printed",
       [](Forces f, std::size_t n, const Config&) {
         return make_implicit_kang(std::move(f), n, false);
       }},
  };
}

}  // namespace selvedge
