// SPDX-License-Identifier: MIT
//
// A blend of the implicit midpoint rule and implicit Euler. With the mean velocity u = (x⁺ - x)/h
// and weights α, β in [½, 1],
//   M (u - v)/α = h F(x + β h u, u),  v⁺ = v + (u - v)/α.
// α = β = ½ is the midpoint rule, α = β = 1 implicit Euler. Slow motion with angular frequency ω
// loses the share (α + β - 1) (h ω)² of its energy in a step; the fastest modes shrink to
// |1 - 1/α| and |1 - 1/β|. One linear solve: F is linearised not at x, as by [BaraffWitkin1998],
// but where the particles would be with their present velocity, x + β h v. The parts of ∂F/∂x that
// the forces drop so that the system is positive definite then act on u - v and not on u. They
// damp by O(h²) instead of O(h): of a swinging sheet they cost more than implicit Euler itself.
//
// A particle that contacts touch has α = 1, so that its end velocity is u and a contact that stops
// it stops its velocity; the others keep theirs. A contact that is found during the step changes
// the rows of its particles alone.
//
// The weight follows the energy as in D. Dinev, T. Liu, L. Kavan, "Stabilizing integrators for
// real-time physics", 2018 [DinevLiuKavan2018]: the caller takes as much of v⁺ - u away as the step
// gains energy. Deviation: where that does not suffice, and after any rejected attempt, the same
// step is implicit Euler linearised at x, bit for bit as `implicit_euler`; so are the next few
// steps. Another rejection soon after doubles their number. Guarantee: stable for any step length
// as implicit Euler is; first order with a small constant.
#include <selvedge/core/detail/force_checks.h>
#include <selvedge/core/detail/implicit_system.h>
#include <selvedge/core/integrator.h>

#include <algorithm>

namespace selvedge {
namespace {

// α and β. With smaller ones the fastest modes ring longer, and more steps gain energy: with 0.55
// each, cloth held by two corners has to shorten one step in six.
constexpr double kVelocityWeight = 0.6, kForceWeight = 0.8;

// Steps of implicit Euler after one at which the blend failed. They double with each further
// failure, up to the most, and shrink by this factor with each step of the blend.
constexpr double kPause = 2.0, kMostPause = 64.0, kForgets = 0.9;

class ImplicitBlend final : public Integrator {
 public:
  ImplicitBlend(std::vector<std::unique_ptr<Force>> forces, std::size_t n,
                const ImplicitConfig& config)
      : Integrator(std::move(forces), n),
        system_(forces_.members(), n, config),
        alpha_(n, 1.0),
        x_(n),
        guess_(n) {}

  IntegratorTraits traits() const override {
    return {.promise = "stable at any step of the scene; loses little energy",
            .source = "Dinev, Liu, Kavan, Stabilizing integrators for real-time physics, 2018",
            .any_step = true,
            .is_implicit = true,
            .follows_energy = true,
            .share_of_euler_error = kVelocityWeight + kForceWeight - 1.0};
  }

  void begin(const StepStart& start, StepEnd end) override;
  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) override;
  std::span<const Vec3> unbalanced(std::span<const Vec3> mean) override {
    return system_.unbalanced(mean);
  }

 private:
  void begin_euler(const StepStart& start);
  void begin_blend(const StepStart& start, std::span<const Vec3> mean);
  void stop_met(std::span<const ImplicitTerm> terms);
  void remember() override;
  std::map<std::string, double> counters() const override {
    return {{"substituted_implicit_blend_by_implicit_euler", static_cast<double>(euler_steps_)}};
  }
  void save_history(std::vector<double>& memory) const override {
    memory.insert(memory.end(), {pause_, next_pause_});
  }
  std::span<const double> restore_history(std::span<const double> memory) override {
    detail::require_memory("implicit_blend", memory.size(), 2);
    pause_ = memory[0];
    next_pause_ = memory[1];
    attempts_ = 0;
    return memory.subspan(2);
  }

  detail::ImplicitSystem system_;
  std::vector<double> alpha_;
  std::vector<Vec3> x_, guess_;  // x + β h v, and v
  Particles heavy_;              // the particles with masses M/α
  std::vector<std::int32_t> met_;
  const Particles* start_ = nullptr;
  double pause_ = 0.0;          // steps of implicit Euler that are left
  double next_pause_ = kPause;  // after the next failure
  bool blends_ = false;         // the last attempt
  int attempts_ = 0;            // since the last accepted step
  std::size_t euler_steps_ = 0;
};

void ImplicitBlend::begin(const StepStart& start, StepEnd end) {
  start_ = &start.particles;
  const bool all_touched = start.touched && start.touched_particles.empty();
  blends_ = attempts_++ == 0 && !all_touched && pause_ < 1.0;
  if (blends_)
    begin_blend(start, end.mean);
  else
    begin_euler(start);
}

void ImplicitBlend::remember() {
  if (attempts_ == 0) return;  // the cloth slept
  if (attempts_ > 1) {
    pause_ = next_pause_;
    next_pause_ = std::min(2.0 * next_pause_, kMostPause);
  } else if (blends_) {
    next_pause_ = std::max(kForgets * next_pause_, kPause);
  } else {
    pause_ = std::max(pause_ - 1.0, 0.0);
  }
  euler_steps_ += blends_ ? 0 : 1;
  attempts_ = 0;
}

void ImplicitBlend::begin_euler(const StepStart& start) {
  const Particles& p = start.particles;
  std::fill(alpha_.begin(), alpha_.end(), 1.0);
  system_.hold(p);
  system_.assemble({{p.x, system_.zeros(), p.mass, start.time}, start.h, p.v, start.h});
}

void ImplicitBlend::begin_blend(const StepStart& start, std::span<const Vec3> mean) {
  const Particles& p = start.particles;
  const double to = kForceWeight * start.h;
  std::fill(alpha_.begin(), alpha_.end(), kVelocityWeight);
  for (const std::int32_t i : start.touched_particles) alpha_[i] = 1.0;
  heavy_ = p;
  for (std::size_t i = 0; i < p.size(); ++i) {
    heavy_.mass[i] /= alpha_[i];
    guess_[i] = p.inv_mass[i] > 0.0 || mean.empty() ? p.v[i] : mean[i];
    x_[i] = p.x[i] + to * guess_[i];
  }
  system_.hold(heavy_);
  system_.assemble(
      {{x_, guess_, p.mass, start.time + to}, start.h, p.v, to, 1.0, 1.0 / kForceWeight});
  system_.add_jacobian_times(guess_);
}

/// Sets α = 1 at the particles of contacts that were found during the step.
void ImplicitBlend::stop_met(std::span<const ImplicitTerm> terms) {
  met_.clear();
  for (const ImplicitTerm& term : terms)
    for (int k = 0; k < 4; ++k)
      detail::for_each_row(term, k, start_->followers, [&](std::int32_t i, double) {
        if (alpha_[i] == 1.0) return;
        alpha_[i] = 1.0;
        met_.push_back(i);
      });
  if (!met_.empty()) system_.set_mass(met_, start_->mass, start_->v);
}

SolveReport ImplicitBlend::solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) {
  if (blends_) stop_met(terms);
  const SolveReport report = system_.solve(terms, end.mean, looser * system_.config().tolerance);
  for (std::size_t i = 0; i < end.mean.size(); ++i)
    end.v[i] = alpha_[i] == 1.0 ? end.mean[i]
                                : Vec3(start_->v[i] + (end.mean[i] - start_->v[i]) / alpha_[i]);
  return report;
}

}  // namespace

std::unique_ptr<Integrator> make_implicit_blend(std::vector<std::unique_ptr<Force>> forces,
                                                std::size_t particles,
                                                const IntegratorConfig& config) {
  return std::make_unique<ImplicitBlend>(std::move(forces), particles, config.solve);
}

void register_implicit_blend(IntegratorRegistry& registry) {
  registry.add("implicit_blend", {},
               [](const MethodOptions&, std::vector<std::unique_ptr<Force>> forces,
                  std::size_t particles, const ImplicitConfig& solve) {
                 return make_implicit_blend(std::move(forces), particles, {.solve = solve});
               });
}

}  // namespace selvedge
