// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/force.h>

#include <algorithm>
#include <cmath>

namespace selvedge {
namespace {

constexpr std::size_t kAddGrain = 4096;

}  // namespace

ForceSum::ForceSum(std::vector<std::unique_ptr<Force>> forces, std::size_t particles)
    : forces_(std::move(forces)), stiffness_(particles), damping_(particles) {}

void ForceSum::evaluate(const ForceState& state, std::span<Vec3> f) const {
  std::fill(f.begin(), f.end(), Vec3::Zero());
  for (const auto& force : forces_) force->add_force(state, f);
}

void ForceSum::accelerate(const ForceState& state, std::span<const double> inv_mass,
                          std::span<Vec3> a) const {
  evaluate(state, a);
  parallel_for(a.size(), kAddGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (inv_mass[i] > 0.0)
        a[i] *= inv_mass[i];
      else
        a[i].setZero();  // not inv_mass·f: forces on held particles may be infinite
    }
  });
}

double ForceSum::energy(const ForceState& state) const {
  double sum = 0.0;
  for (const auto& force : forces_) sum += force->energy(state);
  return sum;
}

ModeBound ForceSum::bound(const Particles& particles, double time) {
  const ForceState state{particles.x, particles.v, particles.mass, time};
  std::fill(stiffness_.begin(), stiffness_.end(), 0.0);
  std::fill(damping_.begin(), damping_.end(), 0.0);
  for (const auto& force : forces_) force->add_stiffness_bound(state, stiffness_, damping_);
  ModeBound bound;
  double omega_squared = 0.0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    omega_squared = std::max(omega_squared, stiffness_[i] * particles.inv_mass[i]);
    bound.rate = std::max(bound.rate, damping_[i] * particles.inv_mass[i]);
  }
  bound.omega = std::sqrt(omega_squared);
  return bound;
}

void ForceSum::accept(const ForceState& state) {
  for (const auto& force : forces_) force->accept(state);
}

void ForceSum::save_memory(std::vector<double>& memory) const {
  for (const auto& force : forces_) force->save_memory(memory);
}

std::span<const double> ForceSum::restore_memory(std::span<const double> memory) {
  for (const auto& force : forces_) memory = force->restore_memory(memory);
  return memory;
}

}  // namespace selvedge
