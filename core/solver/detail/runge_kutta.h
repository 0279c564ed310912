// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/integrator.h>

#include <array>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Largest number of stages of a tableau.
inline constexpr int kMostStages = 6;

/// An explicit Runge-Kutta method. Stage i is evaluated at t + c_i h and y + h Σ_j a_ij k_j; the
/// step ends at y + h Σ_i b_i k_i.
struct Tableau {
  int stages;
  std::array<std::array<double, kMostStages>, kMostStages> a;
  std::array<double, kMostStages> b, c;
};

/// The stages of a step as arrays over the particles, y = (x, v) and k = (v, a).
class RungeKuttaStages {
 public:
  RungeKuttaStages(const Tableau& tableau, std::size_t particles);

  /// Evaluates all stages from (x, v). Held particles keep their velocity.
  void evaluate(const ForceSum& forces, const Particles& particles, std::span<const Vec3> x,
                std::span<const Vec3> v, double time, double h);
  /// dx = Σ w_i k_i of the positions, dv of the velocities, both per second.
  void combine(std::span<const double> weights, std::span<Vec3> dx, std::span<Vec3> dv) const;
  const Tableau& tableau() const { return tableau_; }

 private:
  Tableau tableau_;
  std::array<std::vector<Vec3>, kMostStages> kx_, kv_;
  std::vector<Vec3> x_;
};

/// Amplification matrix of a method with these coefficients, acting on (x, h x') of a mode.
Eigen::Matrix2d amplification_of(const Tableau& tableau, double theta, double delta);

/// A Runge-Kutta method with a fixed step.
class RungeKutta final : public Integrator {
 public:
  RungeKutta(ForceList forces, std::size_t particles, const Tableau& tableau,
             const IntegratorTraits& traits);
  IntegratorTraits traits() const override { return traits_; }
  double stable_step(const ModeBound& mode, double wanted) const override;
  void begin(const StepStart& start, StepEnd end) override;

 private:
  IntegratorTraits traits_;
  RungeKuttaStages stages_;
  std::vector<Vec3> v_;
};

/// Adds the method with these coefficients.
void add_runge_kutta(IntegratorRegistry& registry, const std::string& name, const Tableau& tableau,
                     const IntegratorTraits& traits);

}  // namespace selvedge::detail
