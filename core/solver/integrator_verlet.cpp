// SPDX-License-Identifier: MIT
//
// L. Verlet, "Computer experiments on classical fluids", 1967 [Verlet1967]: x⁺ = 2x - x⁻ + h² a
// [survey eq. 28], and damped Verlet, x⁺ = x + D (x - x⁻) + h² a [Mongus2012; survey eq. 29, which
// its text calls 30]. The survey uses D = 0.99 for every step length, so halving the step doubles
// the damping; here D = exp(-γ h). The method starts with x⁻ = x - h v + ½ h² a; the survey does
// not say how.
//
// Instead of x⁻ the method stores the difference between the mean velocity of the last step, (x -
// x⁻)/h, and its end velocity, so contacts that change one also change the other. When the step
// length changes from h⁻ to h, the method restarts from v = (x - x⁻)/h⁻ + ½ h⁻ a, that is, (x⁺ -
// x)/h = (x - x⁻)/h⁻ + ½ (h⁻ + h) a. The end velocity is the velocity in the middle of the step
// plus half a step of the acceleration at the start: second order, without another force
// evaluation. Velocity-dependent forces use the velocity in the middle of the last step.
//
// Guarantee: second order, first order with damping; bounded energy; stable below hω = 2 without
// damping, and with damping c like symplectic Euler, whose positions it shares. [survey claim: as
// cheap as Euler]
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/detail/stability.h>
#include <selvedge/core/solver/integrator.h>

#include <algorithm>

namespace selvedge {
namespace {

class Verlet final : public Integrator {
 public:
  Verlet(ForceList forces, std::size_t n, double drag, const IntegratorTraits& traits)
      : Integrator(std::move(forces), n),
        traits_(traits),
        drag_(drag),
        lead_(n, Vec3::Zero()),
        next_lead_(n, Vec3::Zero()),
        middle_(n),
        a_(n) {}

  IntegratorTraits traits() const override { return traits_; }

  // x⁺ = x + (D - δ)(x - x⁻) - θ x: on (x, x - x⁻).
  double stable_step(const ModeBound& mode, double wanted) const override {
    return detail::stable_step_of(
        [](double theta, double delta) {
          Eigen::Matrix2d m;
          m << 1.0 - theta, 1.0 - delta, -theta, 1.0 - delta;
          return m;
        },
        mode, wanted);
  }

  void begin(const StepStart& start, StepEnd end) override;

 private:
  void remember(const ForceState&) override {
    std::swap(lead_, next_lead_);
    h_ = next_h_;
  }
  void save_history(std::vector<double>& memory) const override;
  std::span<const double> restore_history(std::span<const double> memory) override;

  IntegratorTraits traits_;
  double drag_;
  std::vector<Vec3> lead_,
      next_lead_;  // m/s, mean velocity of the last step minus its end velocity
  std::vector<Vec3> middle_, a_;
  double h_ = 0.0, next_h_ = 0.0;  // s, length of the last step; 0: there was none
};

void Verlet::begin(const StepStart& start, StepEnd end) {
  const Particles& p = start.particles;
  for (std::size_t i = 0; i < p.size(); ++i)
    middle_[i] = p.inv_mass[i] > 0.0 ? Vec3(p.v[i] + lead_[i]) : end.mean[i];
  forces_.accelerate({p.x, middle_, p.mass, start.time}, p.inv_mass, a_);
  const double h = start.h, between = 0.5 * (h_ + h), keep = elementary::exp(-drag_ * between);
  for (std::size_t i = 0; i < p.size(); ++i) {
    next_lead_[i].setZero();
    if (p.inv_mass[i] <= 0.0) continue;
    end.mean[i] = keep * middle_[i] + between * a_[i];
    // With drag, the velocity continues to decay.
    end.v[i] = end.mean[i] + (0.5 * h) * (a_[i] - drag_ * end.mean[i]);
    next_lead_[i] = end.mean[i] - end.v[i];
  }
  next_h_ = h;
}

void Verlet::save_history(std::vector<double>& memory) const {
  memory.push_back(h_);
  for (const Vec3& lead : lead_) memory.insert(memory.end(), lead.data(), lead.data() + 3);
}

std::span<const double> Verlet::restore_history(std::span<const double> memory) {
  const std::size_t size = 1 + 3 * lead_.size();
  detail::require_memory("verlet", memory.size(), size);
  h_ = memory[0];
  for (std::size_t i = 0; i < lead_.size(); ++i)
    lead_[i] = Vec3(memory[1 + 3 * i], memory[2 + 3 * i], memory[3 + 3 * i]);
  return memory.subspan(size);
}

}  // namespace

void register_verlet(IntegratorRegistry& registry) {
  registry.add(
      "verlet", {},
      [](const MethodOptions&, ForceList forces, std::size_t particles, const ImplicitConfig&) {
        return std::make_unique<Verlet>(
            std::move(forces), particles, 0.0,
            IntegratorTraits{
                .promise =
                    "second order, bounded energy; stable below h omega = 2, which is checked",
                .source = "Verlet, Computer experiments on classical fluids, 1967; survey eq. 28",
                .order = 2});
      });
  registry.add(
      "damped_verlet",
      {{.name = "drag",
        .initial = 0.5,
        .unit = "1/s",
        .least = 0.0,
        .most = 1e6,
        .meaning = "rate at which velocities decay"}},
      [](const MethodOptions& o, ForceList forces, std::size_t particles, const ImplicitConfig&) {
        return std::make_unique<Verlet>(
            std::move(forces), particles, o["drag"],
            IntegratorTraits{
                .promise = "as verlet; every velocity decays as exp(-drag t), whatever the step",
                .source =
                    "Mongus et al. 2012; survey eq. 29 corrected: D = exp(-gamma h) instead of "
                    "0.99",
                .order = 2});
      });
}

}  // namespace selvedge
