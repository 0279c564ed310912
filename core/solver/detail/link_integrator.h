// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/detail/link_constants.h>
#include <selvedge/core/solver/integrator.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// An integrator whose system has one constant for each link. `corrected`: it restores the rigid
/// motion that this system removes.
class LinkIntegrator : public Integrator {
 protected:
  LinkIntegrator(ForceList forces, std::size_t n, bool corrected)
      : Integrator(std::move(forces), n),
        corrected_(corrected),
        links_(forces_, n),
        rigid_(links_),
        f_(n),
        rhs_(n) {}

  /// The weight of a link in the system, h (h K + D), kg.
  double weight(std::size_t link, double h) const {
    return h * h * links_.stiffness()[link] + h * links_.damping()[link];
  }
  void save_history(std::vector<double>& memory) const override { links_.save(memory); }
  std::span<const double> restore_history(std::span<const double> memory) override {
    return links_.restore(memory);
  }

  const bool corrected_;
  LinkConstants links_;
  RigidCorrection rigid_;
  std::vector<Vec3> f_, rhs_;  // N; kg·m/s
};

/// Adds a link integrator under two names: corrected, and without the correction.
template <class Method>
void add_link_integrator(IntegratorRegistry& registry, const std::string& corrected,
                         const std::string& uncorrected) {
  for (const bool correct : {true, false})
    registry.add(correct ? corrected : uncorrected, {},
                 [correct](const MethodOptions&, ForceList forces, std::size_t particles,
                           const ImplicitConfig&) {
                   return std::make_unique<Method>(std::move(forces), particles, correct);
                 });
}

}  // namespace selvedge::detail
