// SPDX-License-Identifier: MIT
#include <selvedge/core/integrator.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge {

SymplecticEuler::SymplecticEuler(std::vector<std::unique_ptr<Force>> forces, std::size_t particles)
    : forces_(std::move(forces)), f_(particles) {}

double SymplecticEuler::stable_step(const Particles& particles) const {
  const ForceState state{particles.x, particles.v, particles.mass, 0.0};
  std::vector<double> stiffness(particles.size(), 0.0), damping(particles.size(), 0.0);
  for (const auto& force : forces_) force->add_stiffness_bound(state, stiffness, damping);
  double omega_squared = 0.0, rate = 0.0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    omega_squared = std::max(omega_squared, stiffness[i] * particles.inv_mass[i]);
    rate = std::max(rate, damping[i] * particles.inv_mass[i]);
  }
  // A mode x'' = -ω² x - c x' has the amplification polynomial μ² - (2 - hc - h²ω²) μ + 1 - hc. Its
  // roots leave the unit circle where h²ω² + 2hc = 4, that is at h = 4/(c + sqrt(c² + 4ω²)).
  const double denominator = rate + std::sqrt(rate * rate + 4.0 * omega_squared);
  return denominator > 0.0 ? 4.0 / denominator : std::numeric_limits<double>::infinity();
}

void SymplecticEuler::step(const Particles& particles, double time, double h, std::span<Vec3> v) {
  std::fill(f_.begin(), f_.end(), Vec3::Zero());
  const ForceState state{particles.x, particles.v, particles.mass, time};
  for (const auto& force : forces_) force->add_force(state, f_);
  for (std::size_t i = 0; i < particles.size(); ++i)
    if (particles.inv_mass[i] > 0.0) v[i] = particles.v[i] + (h * particles.inv_mass[i]) * f_[i];
}

void SymplecticEuler::accept(const ForceState& state) {
  for (const auto& force : forces_) force->accept(state);
}

}  // namespace selvedge
