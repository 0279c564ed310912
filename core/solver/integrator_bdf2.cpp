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
// This is decided for each connected piece of cloth, since no spring couples it to the others; a
// contact makes only the pieces that it touches take implicit Euler. The counters of result.json
// say how often.
// Guarantee: second order for pieces without contact while no part of the Jacobian is dropped (no
// compressed spring, no buckling link, no damped spring that turns), otherwise first order; stable
// for any step length; loses much less energy than implicit Euler.
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/detail/implicit_system.h>
#include <selvedge/core/solver/integrator.h>

#include <algorithm>
#include <cmath>

namespace selvedge {
namespace {

// Step lengths are equal if they differ only by the rounding of sums.
constexpr double kSameStep = 1e-9;

class Bdf2 final : public Integrator {
 public:
  Bdf2(ForceList forces, std::size_t n, const ImplicitConfig& config)
      : Integrator(std::move(forces), n),
        system_(forces_.members(), n, config),
        lead_(n, Vec3::Zero()),
        lag_(n, Vec3::Zero()),
        next_lead_(n, Vec3::Zero()),
        next_lag_(n, Vec3::Zero()),
        momentum_(n),
        half_(n),
        plain_(n),
        h_(system_.pieces().count(), 0.0),
        next_h_(h_),
        two_steps_(h_.size(), 0),
        met_(h_.size(), 0) {}

  IntegratorTraits traits() const override {
    return {.promise = "stable at any step, second order; implicit Euler for pieces in contact",
            .source = "Choi, Ko, Stable but responsive cloth, 2002",
            .order = 2,
            .any_step = true,
            .is_implicit = true};
  }

  void begin(const StepStart& start, StepEnd) override;
  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) override;
  std::span<const Vec3> unbalanced(std::span<const Vec3> mean) override {
    return system_.unbalanced(mean);
  }

 private:
  void remember(const ForceState&) override {
    std::swap(lead_, next_lead_);
    std::swap(lag_, next_lag_);
    h_ = next_h_;
    piece_steps_ += h_.size();
    for (std::size_t k = 0; k < h_.size(); ++k) euler_steps_ += two_steps_[k] && !met_[k] ? 0 : 1;
  }
  std::map<std::string, double> counters() const override {
    return {{"bdf2_steps_of_pieces", static_cast<double>(piece_steps_)},
            {"substituted_bdf2_by_implicit_euler", static_cast<double>(euler_steps_)}};
  }
  void choose_method(const StepStart& start);
  void save_history(std::vector<double>& memory) const override;
  std::span<const double> restore_history(std::span<const double> memory) override;

  detail::ImplicitSystem system_;
  std::vector<Vec3> lead_, lag_;  // m/s, d - v and v⁻ - v
  std::vector<Vec3> next_lead_, next_lag_;
  std::vector<Vec3> momentum_, half_;  // ¾ d + 2 v - ½ v⁻, and -½ d
  std::vector<char> plain_;            // per particle: its piece takes implicit Euler
  const Particles* start_ = nullptr;
  // By piece:
  std::vector<double> h_, next_h_;  // s, length of the last step; 0: no former step
  std::vector<char> two_steps_;     // the current step is a BDF2 step
  std::vector<char> met_;           // a contact was found during the step
  std::size_t piece_steps_ = 0, euler_steps_ = 0;
};

void Bdf2::choose_method(const StepStart& start) {
  const std::span<const std::int32_t> piece = system_.pieces().of_particles();
  std::fill(met_.begin(), met_.end(), 0);
  std::fill(next_h_.begin(), next_h_.end(), start.h);
  if (start.touched && start.touched_particles.empty())
    std::fill(next_h_.begin(), next_h_.end(), 0.0);
  if (start.touched)
    for (const std::int32_t i : start.touched_particles) next_h_[piece[i]] = 0.0;
  for (std::size_t k = 0; k < h_.size(); ++k)
    two_steps_[k] = next_h_[k] > 0.0 && std::abs(start.h - h_[k]) <= kSameStep * start.h;
  for (std::size_t i = 0; i < plain_.size(); ++i) plain_[i] = two_steps_[piece[i]] ? 0 : 1;
}

void Bdf2::begin(const StepStart& start, StepEnd) {
  const Particles& p = start.particles;
  const double h = start.h;
  start_ = &p;
  choose_method(start);
  system_.hold(p);
  if (std::find(two_steps_.begin(), two_steps_.end(), 1) == two_steps_.end()) {
    system_.assemble({{p.x, system_.zeros(), p.mass, start.time}, h, p.v, h});
    return;
  }
  for (std::size_t i = 0; i < p.size(); ++i) {
    half_[i] = plain_[i] ? Vec3(Vec3::Zero()) : Vec3(-0.5 * (p.v[i] + lead_[i]));
    momentum_[i] = plain_[i] ? p.v[i] : Vec3(2.25 * p.v[i] + 0.75 * lead_[i] - 0.5 * lag_[i]);
  }
  const bool mixed = std::find(plain_.begin(), plain_.end(), 1) != plain_.end();
  constexpr double share = 9.0 / 4.0;
  system_.assemble({{p.x, half_, p.mass, start.time},
                    h,
                    momentum_,
                    h / 1.5,
                    share,
                    share,
                    mixed ? std::span<const char>(plain_) : std::span<const char>()});
}

SolveReport Bdf2::solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) {
  const SolveReport report = system_.solve(terms, end.mean, looser * system_.config().tolerance);
  const std::span<const std::int32_t> piece = system_.pieces().of_particles();
  std::fill(met_.begin(), met_.end(), 0);
  for (const ImplicitTerm& term : terms)
    for (int k = 0; k < 4; ++k)
      detail::for_each_row(term, k, start_->followers, [&](std::int32_t i, double) {
        met_[piece[i]] = 1;
        next_h_[piece[i]] = 0.0;
      });
  for (std::size_t i = 0; i < end.mean.size(); ++i) {
    const bool two = two_steps_[piece[i]] && !met_[piece[i]];
    end.v[i] = two ? Vec3(1.5 * end.mean[i] + half_[i]) : end.mean[i];
    next_lead_[i] = end.mean[i] - end.v[i];
    next_lag_[i] = start_->v[i] - end.v[i];
  }
  return report;
}

void Bdf2::save_history(std::vector<double>& memory) const {
  memory.insert(memory.end(), h_.begin(), h_.end());
  for (const auto* part : {&lead_, &lag_})
    for (const Vec3& u : *part) memory.insert(memory.end(), u.data(), u.data() + 3);
}

std::span<const double> Bdf2::restore_history(std::span<const double> memory) {
  const std::size_t n = lead_.size(), pieces = h_.size(), size = pieces + 6 * n;
  detail::require_memory("bdf2", memory.size(), size);
  std::copy_n(memory.begin(), pieces, h_.begin());
  for (std::size_t i = 0; i < n; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      lead_[i][axis] = memory[pieces + 3 * i + static_cast<std::size_t>(axis)];
      lag_[i][axis] = memory[pieces + 3 * (n + i) + static_cast<std::size_t>(axis)];
    }
  return memory.subspan(size);
}

}  // namespace

void register_bdf2(IntegratorRegistry& registry) {
  registry.add("bdf2", {},
               [](const MethodOptions&, ForceList forces, std::size_t particles,
                  const ImplicitConfig& solve) {
                 return std::make_unique<Bdf2>(std::move(forces), particles, solve);
               });
}

}  // namespace selvedge
