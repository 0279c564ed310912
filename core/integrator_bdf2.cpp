// SPDX-License-Identifier: MIT
//
// Second-order backward difference of K.-J. Choi and H.-S. Ko, "Stable but responsive cloth", 2002
// [ChoiKo2002; survey eq. 37-38, whose second derivative is printed ∂P for ∂v]:
//   (3 v⁺ - 4 v + v⁻)/2 = h M⁻¹ F(x⁺, v⁺),  (3 x⁺ - 4 x + x⁻)/2 = h v⁺,
// with one linearisation at x. It is written for the mean velocity u = (x⁺ - x)/h, so contacts act
// on positions as in implicit Euler. With d = (x - x⁻)/h, v⁺ = (3 u - d)/2 and
//   (9/4 M - 3/2 h ∂F/∂v - h² ∂F/∂x) u = M (¾ d + 2 v - ½ v⁻) + h F(x, -½ d),
// that is, 9/4 (M + J(2h/3)).
//
// The former step is stored relative to the velocity v, so a change of v (by a fail-safe or a
// strain limiter) shifts it as a whole; an impulse does not become a lasting acceleration. Implicit
// Euler replaces a step whose length differs from the former one, a step with contacts, and the
// step after it: two steps from before and after an impact combined would throw the cloth back.
// Guarantee: second order while no part of the Jacobian is dropped (no compressed spring, no
// buckling link), otherwise first order; stable for any step length; loses much less energy than
// implicit Euler.
#include <selvedge/core/detail/force_checks.h>
#include <selvedge/core/detail/implicit_system.h>
#include <selvedge/core/integrator.h>

#include <algorithm>
#include <cmath>

namespace selvedge {
namespace {

// Step lengths are equal if they differ only by the rounding of sums.
constexpr double kSameStep = 1e-9;

class Bdf2 final : public Integrator {
 public:
  Bdf2(std::vector<std::unique_ptr<Force>> forces, std::size_t n, const ImplicitConfig& config)
      : Integrator(std::move(forces), n),
        system_(forces_.members(), n, config),
        lead_(n, Vec3::Zero()),
        lag_(n, Vec3::Zero()),
        next_lead_(n, Vec3::Zero()),
        next_lag_(n, Vec3::Zero()),
        momentum_(n),
        half_(n) {}

  IntegratorTraits traits() const override {
    return {"stable at any step, second order; implicit Euler where contacts act",
            "Choi, Ko, Stable but responsive cloth, 2002", 2, true, true};
  }

  void begin(const StepStart& start, StepEnd) override;
  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) override;

 private:
  void remember() override {
    std::swap(lead_, next_lead_);
    std::swap(lag_, next_lag_);
    h_ = next_h_;
  }
  void save_history(std::vector<double>& memory) const override;
  std::span<const double> restore_history(std::span<const double> memory) override;

  detail::ImplicitSystem system_;
  std::vector<Vec3> lead_, lag_;  // m/s, d - v and v⁻ - v
  std::vector<Vec3> next_lead_, next_lag_;
  std::vector<Vec3> momentum_, half_;  // ¾ d + 2 v - ½ v⁻, and -½ d
  const Particles* start_ = nullptr;
  double h_ = 0.0, next_h_ = 0.0;  // s, length of the last step; 0: no former step
  bool two_steps_ = false;         // the current step is a BDF2 step
};

void Bdf2::begin(const StepStart& start, StepEnd) {
  const Particles& p = start.particles;
  const double h = start.h;
  start_ = &p;
  two_steps_ = !start.touched && std::abs(h - h_) <= kSameStep * h;
  next_h_ = start.touched ? 0.0 : h;
  system_.hold(p);
  if (!two_steps_) {
    system_.assemble({{p.x, system_.zeros(), p.mass, start.time}, h, p.v, h});
    return;
  }
  for (std::size_t i = 0; i < p.size(); ++i) {
    half_[i] = -0.5 * (p.v[i] + lead_[i]);
    momentum_[i] = 2.25 * p.v[i] + 0.75 * lead_[i] - 0.5 * lag_[i];
  }
  constexpr double share = 9.0 / 4.0;
  system_.assemble({{p.x, half_, p.mass, start.time}, h, momentum_, h / 1.5, share, share});
}

SolveReport Bdf2::solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) {
  const SolveReport report = system_.solve(terms, end.mean, looser * system_.config().tolerance);
  const bool two = two_steps_ && terms.empty();
  if (!terms.empty()) next_h_ = 0.0;
  for (std::size_t i = 0; i < end.mean.size(); ++i) {
    end.v[i] = two ? Vec3(1.5 * end.mean[i] + half_[i]) : end.mean[i];
    next_lead_[i] = end.mean[i] - end.v[i];
    next_lag_[i] = start_->v[i] - end.v[i];
  }
  return report;
}

void Bdf2::save_history(std::vector<double>& memory) const {
  memory.push_back(h_);
  for (const auto* part : {&lead_, &lag_})
    for (const Vec3& u : *part) memory.insert(memory.end(), u.data(), u.data() + 3);
}

std::span<const double> Bdf2::restore_history(std::span<const double> memory) {
  const std::size_t n = lead_.size(), size = 1 + 6 * n;
  detail::require_memory("bdf2", memory.size(), size);
  h_ = memory[0];
  for (std::size_t i = 0; i < n; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      lead_[i][axis] = memory[1 + 3 * i + static_cast<std::size_t>(axis)];
      lag_[i][axis] = memory[1 + 3 * (n + i) + static_cast<std::size_t>(axis)];
    }
  return memory.subspan(size);
}

}  // namespace

std::unique_ptr<Integrator> make_bdf2(std::vector<std::unique_ptr<Force>> forces,
                                      std::size_t particles, const IntegratorConfig& config) {
  return std::make_unique<Bdf2>(std::move(forces), particles, config.solve);
}

void register_bdf2(IntegratorRegistry& registry) {
  registry.add("bdf2", {},
               [](const MethodOptions&, std::vector<std::unique_ptr<Force>> forces,
                  std::size_t particles, const ImplicitConfig& solve) {
                 return make_bdf2(std::move(forces), particles, {.solve = solve});
               });
}

}  // namespace selvedge
