// SPDX-License-Identifier: MIT
//
// Symplectic (semi-implicit) Euler, which survey eq. 14 prints under the name of explicit Euler: v⁺
// = v + h a(x, v), x⁺ = x + h v⁺; its a(t+h) must be a(t). Guarantee: first order, bounded energy;
// stable below hω = 2 without damping, and with damping c below h = 4/(c + sqrt(c² + 4ω²)).
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/solver/integrator.h>

#include <algorithm>
#include <limits>

namespace selvedge {
namespace {

// A mode x'' = -ω² x - c x' has the amplification polynomial μ² - (2 - hc - h²ω²) μ + 1 - hc. A
// root leaves the unit circle where h²ω² + 2hc = 4, that is, at h = 4/(c + sqrt(c² + 4ω²)).
double longest_step(const ModeBound& mode) {
  const double denominator = mode.rate + elementary::hypot(mode.rate, 2.0 * mode.omega);
  return denominator > 0.0 ? 4.0 / denominator : std::numeric_limits<double>::infinity();
}

class Symplectic final : public Integrator {
 public:
  Symplectic(ForceList forces, std::size_t particles)
      : Integrator(std::move(forces), particles), a_(particles) {}

  IntegratorTraits traits() const override {
    return {.promise = "bounded energy; stable below h omega = 2, which is checked",
            .source = "survey eq. 14 as printed (its explicit Euler)",
            .ends_with_mean = true};
  }
  double stable_step(const ModeBound& mode, double wanted) const override {
    return std::min(wanted, longest_step(mode));
  }
  void begin(const StepStart& start, StepEnd end) override {
    const Particles& p = start.particles;
    forces_.evaluate({p.x, p.v, p.mass, start.time}, a_);
    for (std::size_t i = 0; i < p.size(); ++i)
      if (p.inv_mass[i] > 0.0) end.mean[i] = p.v[i] + (start.h * p.inv_mass[i]) * a_[i];
  }

 private:
  std::vector<Vec3> a_;
};

}  // namespace

void register_symplectic_euler(IntegratorRegistry& registry) {
  registry.add(
      "symplectic_euler", {},
      [](const MethodOptions&, ForceList forces, std::size_t particles, const ImplicitConfig&) {
        return std::make_unique<Symplectic>(std::move(forces), particles);
      });
}

}  // namespace selvedge
