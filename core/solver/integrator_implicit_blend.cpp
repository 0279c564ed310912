// SPDX-License-Identifier: MIT
//
// A blend of the implicit midpoint rule and implicit Euler. With the mean velocity u = (x⁺ - x)/h
// and weights α, β in [½, 1],
//   M (u - v)/α = h F(x + β h u, u),  v⁺ = v + (u - v)/α.
// α = β = ½ is the midpoint rule, α = β = 1 implicit Euler. Slow motion with angular frequency ω
// loses the share (α + β - 1) (h ω)² of its energy in a step; the fastest modes shrink to
// |1 - 1/α| and |1 - 1/β|. One linear solve: F is linearised not at x, as by [BaraffWitkin1998],
// but where the particles would be if they moved as in the last step, x + β h u⁻. The parts of
// ∂F/∂x that the forces drop so that the system is positive definite then act on u - u⁻ and not on
// u. They damp by O(h²) instead of O(h): of a swinging sheet they cost more than implicit Euler
// itself. u⁻ and not v: v carries what is left of the fastest modes.
//
// A particle that contacts touch has α = 1, so that its end velocity is u and a contact that stops
// it stops its velocity; the others keep theirs. A contact that is found during the step changes
// the rows of its particles alone. Where the caller wants all motion damped, and where contacts
// touch nearly all particles, the step is implicit Euler.
//
// The weight follows the energy as in D. Dinev, T. Liu, L. Kavan, "Stabilizing integrators for
// real-time physics", 2018 [DinevLiuKavan2018]: the caller takes as much of v⁺ - u away as the step
// gains energy. Deviation: where that does not suffice, and after any rejected attempt, the same
// step is implicit Euler linearised at x, bit for bit as `implicit_euler`; so are the next few
// steps, and those after one in which the cloth rings: what is too fast for the steps shrinks
// unless contacts feed it. Another rejection soon after doubles their number. Guarantee: stable for
// any step length as implicit Euler is; first order with a small constant.
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/detail/implicit_blend.h>

#include <algorithm>
#include <utility>

namespace selvedge {
namespace detail {
namespace {

// α and β. With a sum of 1.4, a flag in wind keeps less than 0.8 of its motion. With smaller ones
// the fastest modes ring longer, and more steps gain energy.
constexpr double kVelocityWeight = 0.6, kForceWeight = 0.7;

// Steps of implicit Euler after one at which the blend failed. They double with each further
// failure, up to the most, and shrink by this factor with each step of the blend.
constexpr double kPause = 2.0, kMostPause = 64.0, kForgets = 0.9;

// The share of the particles that contacts must leave alone: cloth that lies has no motion to keep.
constexpr double kLeastFree = 0.1;

// The cloth rings where its velocities turn back, twice running, by this share of what they changed
// in the step before. Free motion that is too fast for the steps does so by |1 - 1/α|.
constexpr double kRings = 0.8;

// The most by which the last change of the mean velocity counts for the next step. A step after
// much shorter ones would otherwise be expected far off.
constexpr double kMostRatio = 2.0;

}  // namespace

ImplicitBlend::ImplicitBlend(ForceList forces, std::size_t n, const ImplicitConfig& config)
    : Integrator(std::move(forces), n),
      system_(forces_.members(), n, config),
      alpha_(n, 1.0),
      x_(n),
      guess_(n),
      v_(n, Vec3::Zero()),
      lead_(n, Vec3::Zero()),
      lag_(n, Vec3::Zero()) {}

IntegratorTraits ImplicitBlend::traits() const {
  return {.promise = "stable at any step of the scene; loses little energy",
          .source = "Dinev, Liu, Kavan, Stabilizing integrators for real-time physics, 2018",
          .any_step = true,
          .is_implicit = true,
          .follows_energy = true,
          .share_of_euler_error = kVelocityWeight + kForceWeight - 1.0};
}

// The mean velocity changes as from the step before to the last one; at first, as by the weight.
// It is that at the share α of a step in which the velocity changes evenly. Particles that contacts
// touched (their lead is 0) are left to their weight, which presses them on.
bool ImplicitBlend::expect(double h, std::span<const Vec3> v, std::span<Vec3> mean) {
  constexpr double a = kVelocityWeight;
  const double between = (1.0 - a) * last_h_ + a * h;  // s, from mean to mean
  const double before = (1.0 - a) * former_h_ + a * last_h_;
  const double ratio = std::min(between / before, kMostRatio);
  for (std::size_t i = 0; i < mean.size(); ++i) {
    if (!(former_h_ > 0.0))
      mean[i] = v[i] + lead_[i] + between / h * (mean[i] - v[i]);
    else if (!lead_[i].isZero(0.0))
      mean[i] = v[i] + lead_[i] + ratio * (lead_[i] - lag_[i]);
  }
  return true;
}

/// Whether contacts leave enough particles alone for their motion to matter.
bool ImplicitBlend::moves_freely(const StepStart& start) {
  if (start.touched && start.touched_particles.empty()) return false;
  const Particles& p = start.particles;
  std::fill(alpha_.begin(), alpha_.end(), kVelocityWeight);
  for (const std::int32_t i : start.touched_particles) alpha_[i] = 1.0;
  std::size_t free = 0, untouched = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p.inv_mass[i] == 0.0) continue;
    ++free;
    untouched += alpha_[i] < 1.0 ? 1 : 0;
  }
  return static_cast<double>(untouched) > kLeastFree * static_cast<double>(free);
}

bool ImplicitBlend::turns_back(const Particles& p) const {
  double turned = 0.0, changed = 0.0, changes = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p.inv_mass[i] == 0.0) continue;
    // (1 - α) times the changes of the velocity in the last two steps, times -1.
    const Vec3 last = lead_[i], before = lag_[i] - lead_[i] / (1.0 - kVelocityWeight);
    turned -= p.mass[i] * last.dot(before);
    changed += p.mass[i] * before.squaredNorm();
    changes += p.mass[i] * last.squaredNorm();
  }
  constexpr double round_off = 1e-9;  // of what did not change
  return turned > kRings * changed && changed > round_off * changes;
}

void ImplicitBlend::begin(const StepStart& start, StepEnd end) {
  start_ = &start.particles;
  h_ = start.h;
  v_ = start.particles.v;
  if (attempts_ == 0) {
    const bool before = std::exchange(turned_, pause_ < 1.0 && turns_back(start.particles));
    rings_ = before && turned_;
  }
  blends_ = attempts_++ == 0 && pause_ < 1.0 && !rings_ && moves_freely(start);
  if (blends_)
    begin_blend(start, end.mean);
  else
    begin_euler(start);
}

void ImplicitBlend::remember(const ForceState& end) {
  if (attempts_ == 0) {  // the cloth slept
    std::fill(lead_.begin(), lead_.end(), Vec3::Zero());
    std::fill(lag_.begin(), lag_.end(), Vec3::Zero());
    return;
  }
  remember_motion(end);
  remember_method();
  attempts_ = 0;
}

// What contacts and limits did to the end velocity counts for the mean one, too.
void ImplicitBlend::remember_motion(const ForceState& end) {
  for (std::size_t i = 0; i < v_.size(); ++i) {
    lag_[i] = v_[i] + lead_[i] - end.v[i];
    lead_[i] = (1.0 - alpha_[i]) * (v_[i] - end.v[i]);
  }
  former_h_ = std::exchange(last_h_, h_);
}

void ImplicitBlend::remember_method() {
  if (attempts_ > 1 || rings_) {
    pause_ = next_pause_;
    next_pause_ = std::min(2.0 * next_pause_, kMostPause);
  } else if (blends_) {
    next_pause_ = std::max(kForgets * next_pause_, kPause);
  } else {
    pause_ = std::max(pause_ - 1.0, 0.0);
  }
  euler_steps_ += blends_ ? 0 : 1;
}

void ImplicitBlend::save_history(std::vector<double>& memory) const {
  memory.insert(memory.end(), {pause_, next_pause_, last_h_, former_h_, turned_ ? 1.0 : 0.0});
  for (const auto* part : {&lead_, &lag_})
    for (const Vec3& u : *part) memory.insert(memory.end(), u.data(), u.data() + 3);
}

std::span<const double> ImplicitBlend::restore_history(std::span<const double> memory) {
  constexpr std::size_t numbers = 5;
  const std::size_t n = lead_.size(), size = numbers + 6 * n;
  require_memory("implicit_blend", memory.size(), size);
  pause_ = memory[0];
  next_pause_ = memory[1];
  last_h_ = memory[2];
  former_h_ = memory[3];
  turned_ = memory[4] != 0.0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lead_[i][static_cast<Eigen::Index>(axis)] = memory[numbers + 3 * i + axis];
      lag_[i][static_cast<Eigen::Index>(axis)] = memory[numbers + 3 * (n + i) + axis];
    }
  attempts_ = 0;
  return memory.subspan(size);
}

void ImplicitBlend::begin_euler(const StepStart& start) {
  const Particles& p = start.particles;
  std::fill(alpha_.begin(), alpha_.end(), 1.0);
  system_.hold(p);
  system_.assemble({{p.x, system_.zeros(), p.mass, start.time}, start.h, p.v, start.h});
}

/// Finds the pieces that are rigid bodies. They have α = 1, and their forces are taken where they
/// are at the start: then their springs do not change their angular momentum.
void ImplicitBlend::find_rigid(const Particles& p) {
  rigid_.clear();
  if (p.followers == nullptr || !p.followers->has_rigid()) return;
  rigid_.assign(p.size(), 0);
  for (const std::int32_t i : p.followers->nodes())
    for (const Followers::Share& s : p.followers->shares(i)) rigid_[s.leader] = 1;
  // A body that seams tie to cloth is one piece with it.
  const std::span<const std::int32_t> piece = system_.pieces().of_particles();
  std::vector<char> whole(system_.pieces().count(), 1);
  for (std::size_t i = 0; i < rigid_.size(); ++i)
    if (rigid_[i] == 0) whole[piece[i]] = 0;
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    rigid_[i] = whole[piece[i]];
    if (rigid_[i] != 0) alpha_[i] = 1.0;
  }
}

void ImplicitBlend::begin_blend(const StepStart& start, std::span<const Vec3> mean) {
  const Particles& p = start.particles;
  const double to = kForceWeight * start.h;
  find_rigid(p);
  heavy_ = p;
  for (std::size_t i = 0; i < p.size(); ++i) {
    heavy_.mass[i] /= alpha_[i];
    guess_[i] = p.inv_mass[i] > 0.0 || mean.empty() ? Vec3(p.v[i] + lead_[i]) : mean[i];
    if (!rigid_.empty() && rigid_[i] != 0) guess_[i].setZero();
    x_[i] = p.x[i] + to * guess_[i];
  }
  system_.hold(heavy_);
  system_.assemble(
      {{x_, guess_, p.mass, start.time + to}, start.h, p.v, to, 1.0, 1.0 / kForceWeight, rigid_});
  system_.add_jacobian_times(guess_);
}

bool ImplicitBlend::force_impulses(std::span<const Vec3> mean, ForceImpulses& out) {
  system_.force_impulses(mean, blends_ ? std::span<const Vec3>(guess_) : system_.zeros(), out);
  return true;
}

bool ImplicitBlend::net_impulses(std::span<const Vec3> mean, std::vector<Vec3>& out) {
  system_.net_impulses(mean, out);
  return true;
}

// The fastest modes of v pull at the contacts with forces that the step does not keep. Those of u⁻
// do not: the forces are taken at u⁻, and what leads from v to u⁻ counts as an impulse.
std::span<const Vec3> ImplicitBlend::unbalanced(std::span<const Vec3> mean) {
  if (!blends_) return system_.unbalanced(mean);
  const std::span<const Vec3> rest = system_.unbalanced_at(guess_);
  kept_.resize(rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i)
    kept_[i] = system_.is_free(i) ? Vec3(rest[i] + start_->mass[i] * (guess_[i] - v_[i]))
                                  : Vec3(Vec3::Zero());
  return kept_;
}

/// Sets α = 1 at the particles of contacts that were found during the step.
void ImplicitBlend::stop_met(std::span<const ImplicitTerm> terms) {
  met_.clear();
  for (const ImplicitTerm& term : terms)
    for (int k = 0; k < 4; ++k)
      for_each_row(term, k, start_->followers, [&](std::int32_t i, double) {
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
    end.v[i] = alpha_[i] == 1.0 ? end.mean[i] : Vec3(v_[i] + (end.mean[i] - v_[i]) / alpha_[i]);
  return report;
}

}  // namespace detail

void register_implicit_blend(IntegratorRegistry& registry) {
  registry.add("implicit_blend", {},
               [](const MethodOptions&, ForceList forces, std::size_t particles,
                  const ImplicitConfig& solve) {
                 return std::make_unique<detail::ImplicitBlend>(std::move(forces), particles,
                                                                solve);
               });
}

}  // namespace selvedge
