// SPDX-License-Identifier: MIT
// Symplectic Euler whose velocities decay: v⁺ = exp(-drag h) (v + h a(x, v)), x⁺ = x + h v⁺.
#include "additions.h"

#include <algorithm>
#include <cmath>

namespace adding {
namespace {

using namespace selvedge;

class DraggedEuler final : public Integrator {
 public:
  DraggedEuler(ForceList forces, std::size_t particles, double drag)
      : Integrator(std::move(forces), particles), drag_(drag), f_(particles) {}

  IntegratorTraits traits() const override {
    return {.promise = "stable where symplectic Euler is; loses energy",
            .source = "docs/adding.md",
            .ends_with_mean = true};
  }

  // h²ω² + 2hc <= 4, the bound without drag, which drag only widens.
  double stable_step(const ModeBound& mode, double wanted) const override {
    const double sum = mode.rate + std::hypot(mode.rate, 2.0 * mode.omega);
    return sum > 0.0 ? std::min(wanted, 4.0 / sum) : wanted;
  }

  void begin(const StepStart& start, StepEnd end) override {
    const Particles& p = start.particles;
    forces_.evaluate({p.x, p.v, p.mass, start.time}, f_);
    const double kept = std::exp(-drag_ * start.h);
    for (std::size_t i = 0; i < p.size(); ++i)
      if (p.inv_mass[i] > 0.0) end.mean[i] = kept * (p.v[i] + (start.h * p.inv_mass[i]) * f_[i]);
  }

 private:
  double drag_;
  std::vector<Vec3> f_;  // N
};

}  // namespace

void register_dragged_euler(IntegratorRegistry& registry) {
  registry.add("dragged_euler",
               {{.name = "drag",
                 .initial = 0.5,
                 .unit = "1/s",
                 .least = 0.0,
                 .meaning = "rate at which velocities decay; more comes to rest sooner"}},
               [](const MethodOptions& o, ForceList forces, std::size_t particles,
                  const ImplicitConfig&) -> std::unique_ptr<Integrator> {
                 return std::make_unique<DraggedEuler>(std::move(forces), particles, o["drag"]);
               });
}

}  // namespace adding
