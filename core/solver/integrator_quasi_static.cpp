// SPDX-License-Identifier: MIT
//
// From motion to equilibrium. As long as the cloth moves, the steps are those of `implicit_blend`,
// so that impacts, swings and friction select the equilibrium as they do in a dynamic run. Once the
// kinetic energy has stayed below a thousandth of its peak, inertia fades out: dynamic relaxation
// [Barnes1999] with implicit steps. The masses are divided by the square of a scale that grows with
// every accepted step, drag and damping are left out, and the end velocities are zero:
//   (M/s² + h² K) (u - w) = h F(x + h w),  x⁺ = x + h u.
// The way h w goes on as in the last step, by the share k/(k + 3) of Nesterov's method after k
// steps. Where a step is shorter than the one before, w begins again at zero: the kinetic energy
// has passed a peak, and is removed there [SuBoydCandes2016]. A rejected attempt, or one that gains
// energy, is repeated without w and with half of the scale. Guarantee: as implicit Euler for the
// single step; the order of equilibria is that of the energy, which accepted steps do not raise.
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/detail/implicit_blend.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge {
namespace {

// Inertia fades once the kinetic energy was below this share of its peak for this time, s. At the
// turning point of a swing it is so for a hundredth of the period.
constexpr double kDied = 1e-3, kDiedFor = 0.1;

// Growth of the scale, and its largest value: 8 and 128 changed the number of steps little.
constexpr double kScaleGrowth = 1.5, kLargestScale = 32.0;

// A step that moves the cloth by more than this share of its extent is too long: root mean square.
constexpr double kFar = 0.02;

class QuasiStatic final : public detail::ImplicitBlend {
 public:
  QuasiStatic(ForceList forces, std::size_t n, const ImplicitConfig& config)
      : ImplicitBlend(std::move(forces), n, config),
        before_(n, Vec3::Zero()),
        way_(n, Vec3::Zero()),
        guess_(n, Vec3::Zero()),
        x_(n, Vec3::Zero()),
        momentum_(n, Vec3::Zero()) {}

  IntegratorTraits traits() const override {
    IntegratorTraits traits = ImplicitBlend::traits();
    traits.promise = "seeks the equilibrium: without inertia once the motion has died";
    traits.source =
        "Barnes, Form finding and analysis of tension structures by dynamic relaxation, 1999";
    return traits;
  }

  bool expect(double h, std::span<const Vec3> v, std::span<Vec3> mean) override;
  void begin(const StepStart& start, StepEnd end) override;
  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) override;
  std::span<const Vec3> unbalanced(std::span<const Vec3> mean) override;
  // Without inertia, the impulses of a step are no account of momentum.
  bool force_impulses(std::span<const Vec3> mean, ForceImpulses& out) override {
    return !fading_ && ImplicitBlend::force_impulses(mean, out);
  }
  bool net_impulses(std::span<const Vec3> mean, std::vector<Vec3>& out) override {
    return !fading_ && ImplicitBlend::net_impulses(mean, out);
  }

 private:
  void look_at_motion(const StepStart& start);
  void look_at_way(const Particles& p);
  void begin_static(const StepStart& start, std::span<const Vec3> mean);
  void remember(const ForceState& end) override;
  std::map<std::string, double> counters() const override {
    return {{"quasi_static_steps", static_cast<double>(steps_)}};
  }
  void save_history(std::vector<double>& memory) const override;
  std::span<const double> restore_history(std::span<const double> memory) override;

  std::vector<Vec3> before_;  // m, positions at the start of the last step
  std::vector<Vec3> way_;     // m, of the last step
  std::vector<Vec3> guess_;   // w, m/s
  std::vector<Vec3> x_, momentum_;
  bool fading_ = false;      // inertia is left out
  bool knows_way_ = false;   // before_ is known
  double peak_ = 0.0;        // J, twice the largest kinetic energy
  double died_ = 0.0;        // s, since the kinetic energy is low
  double scale_ = 1.0;       // s
  double length_ = 0.0;      // kg·m², of the last way
  double kept_steps_ = 0.0;  // k
  bool too_far_ = false;
  int tries_ = 0;  // attempts since the last accepted step
  std::size_t steps_ = 0;
};

/// Whether the motion has died.
void QuasiStatic::look_at_motion(const StepStart& start) {
  const Particles& p = start.particles;
  double kinetic = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (p.inv_mass[i] > 0.0) kinetic += p.mass[i] * p.v[i].squaredNorm();
  peak_ = std::max(peak_, kinetic);
  died_ = kinetic < kDied * peak_ ? died_ + start.h : 0.0;
  fading_ = died_ > kDiedFor;
}

/// What the last step did: how far it went, and whether it passed a peak of the kinetic energy.
void QuasiStatic::look_at_way(const Particles& p) {
  double length = 0.0, mass = 0.0;
  Vec3 low = p.x[0], high = p.x[0];
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool moves = knows_way_ && p.inv_mass[i] > 0.0;
    way_[i] = moves ? Vec3(p.x[i] - before_[i]) : Vec3(Vec3::Zero());
    length += p.mass[i] * way_[i].squaredNorm();
    mass += p.mass[i];
    low = low.cwiseMin(p.x[i]);
    high = high.cwiseMax(p.x[i]);
    before_[i] = p.x[i];
  }
  kept_steps_ = length < length_ ? 0.0 : kept_steps_ + 1.0;
  too_far_ = std::sqrt(length / mass) > kFar * (high - low).norm();
  length_ = length;
  knows_way_ = true;
}

bool QuasiStatic::expect(double h, std::span<const Vec3> v, std::span<Vec3> mean) {
  if (!fading_) return ImplicitBlend::expect(h, v, mean);
  std::fill(mean.begin(), mean.end(), Vec3::Zero());
  return true;
}

void QuasiStatic::begin(const StepStart& start, StepEnd end) {
  if (tries_++ == 0 && start.particles.size() > 0) {
    if (!fading_) look_at_motion(start);
    if (fading_) look_at_way(start.particles);
  }
  if (fading_)
    begin_static(start, end.mean);
  else
    ImplicitBlend::begin(start, end);
}

void QuasiStatic::begin_static(const StepStart& start, std::span<const Vec3> mean) {
  const Particles& p = start.particles;
  const double scale = std::max(1.0, std::ldexp(scale_, 1 - tries_)), share = 1.0 / (scale * scale);
  const double kept = tries_ == 1 ? kept_steps_ / (kept_steps_ + 3.0) : 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool moves = p.inv_mass[i] > 0.0 || mean.empty();
    guess_[i] = moves ? Vec3(kept / start.h * way_[i]) : mean[i];
    x_[i] = p.x[i] + start.h * guess_[i];
    momentum_[i] = share * guess_[i];
  }
  system_.hold(p);
  system_.assemble({{x_, system_.zeros(), p.mass, start.time},
                    start.h,
                    momentum_,
                    detail::elastic_tau(start.h),
                    share,
                    detail::kElasticGain});
  system_.add_jacobian_times(guess_);
}

// The forces that contacts have to balance are those at the guess.
std::span<const Vec3> QuasiStatic::unbalanced(std::span<const Vec3> mean) {
  return fading_ ? system_.unbalanced_at(guess_) : ImplicitBlend::unbalanced(mean);
}

SolveReport QuasiStatic::solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) {
  if (!fading_) return ImplicitBlend::solve(terms, end, looser);
  std::fill(end.v.begin(), end.v.end(), Vec3::Zero());
  return system_.solve(terms, end.mean, looser * system_.config().tolerance);
}

void QuasiStatic::remember(const ForceState& end) {
  ImplicitBlend::remember(end);
  if (fading_ && tries_ > 0) {
    const bool shorter = tries_ > 1 || too_far_;
    scale_ = shorter ? std::max(1.0, std::ldexp(scale_, tries_ > 1 ? 1 - tries_ : -1))
                     : std::min(kScaleGrowth * scale_, kLargestScale);
    ++steps_;
  }
  tries_ = 0;
}

void QuasiStatic::save_history(std::vector<double>& memory) const {
  ImplicitBlend::save_history(memory);
  memory.insert(memory.end(), {fading_ ? 1.0 : 0.0, knows_way_ ? 1.0 : 0.0, peak_, died_, scale_,
                               length_, kept_steps_});
  for (const Vec3& x : before_) memory.insert(memory.end(), x.data(), x.data() + 3);
}

std::span<const double> QuasiStatic::restore_history(std::span<const double> memory) {
  memory = ImplicitBlend::restore_history(memory);
  constexpr std::size_t numbers = 7;
  const std::size_t size = numbers + 3 * before_.size();
  detail::require_memory("quasi_static", memory.size(), size);
  fading_ = memory[0] != 0.0;
  knows_way_ = memory[1] != 0.0;
  peak_ = memory[2];
  died_ = memory[3];
  scale_ = memory[4];
  length_ = memory[5];
  kept_steps_ = memory[6];
  for (std::size_t i = 0; i < before_.size(); ++i)
    before_[i] = Eigen::Map<const Vec3>(memory.data() + numbers + 3 * i);
  tries_ = 0;
  return memory.subspan(size);
}

}  // namespace

void register_quasi_static(IntegratorRegistry& registry) {
  registry.add("quasi_static", {},
               [](const MethodOptions&, ForceList forces, std::size_t particles,
                  const ImplicitConfig& solve) {
                 return std::make_unique<QuasiStatic>(std::move(forces), particles, solve);
               });
}

}  // namespace selvedge
