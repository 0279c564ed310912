// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/energy_balance.h>

#include <algorithm>
#include <cmath>

namespace selvedge::detail {
namespace {

// Share of the kinetic energy that a step may gain without another attempt. A hundredth of the
// energy is a two hundredth of the speed, which is invisible.
constexpr double kGain = 0.01;

// Halving stops if it leaves more than this share of the gain: two steps of half the length gain no
// less together, as under a strain limiter that lifts hanging cloth.
constexpr double kHelps = 0.5;

// Anchors move as one if their displacements differ by less than this share: rounding.
constexpr double kSameWay = 1e-9;

constexpr std::size_t kBalanceGrain = 2048;  // particles or anchors per task

double kinetic(const BalanceStep& step, std::span<const Vec3> v, const Vec3& frame) {
  return parallel_sum(v.size(), kBalanceGrain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      if (step.inv_mass[i] > 0.0) sum += 0.5 * step.mass[i] * (v[i] - frame).squaredNorm();
    return sum;
  });
}

double total(std::span<const double> mass) {
  double sum = 0.0;
  for (const double m : mass) sum += m;
  return sum;
}

}  // namespace

EnergyBalance::EnergyBalance(const Scene& scene, const BuiltScene& built,
                             const ResponseTraits& response)
    : gravity_(scene.gravity),
      slow_(scene.contact.rest_gap * scene.time.fps),
      guards_(scene.time.energy_guard) {
  const auto follows = [](const BuiltVirtualSprings& s) { return s.follow; };
  const auto& springs = built.virtual_springs;
  closed_ = !response.stores_energy && !scene.air.moves() && !scene.water &&
            built.volumes.empty() && std::none_of(springs.begin(), springs.end(), follows);
  rooted_ = !springs.empty() ||
            std::any_of(built.solids.begin(), built.solids.end(), [&](const BuiltSolid& solid) {
              const SolidSpec& spec = *solid_of(scene.cloths[solid.piece]);
              return spec.slides() || spec.turns() || !spec.force.isZero(0.0);
            });
}

void EnergyBalance::begin() {
  last_gain_ = -1.0;
  start_.reset();
  weighed_ = false;
}

// The displacement of all anchors in the step; without anchors, that of the centre of mass.
bool EnergyBalance::common_shift(const BalanceStep& step, Vec3& shift) const {
  const std::size_t all = step.x_t0.size();
  std::size_t first = 0;
  while (first < all && step.inv_mass[first] > 0.0) ++first;
  const bool anchored = rooted_ || first < all;
  shift.setZero();
  if (!rooted_ && first < all) shift = step.x_t1[first] - step.x_t0[first];
  const double most = kSameWay * shift.norm();
  const double others =
      parallel_sum(all - first, kBalanceGrain, [&](std::size_t begin, std::size_t end) {
        double count = 0.0;
        for (std::size_t i = first + begin; i < first + end; ++i)
          if (!(step.inv_mass[i] > 0.0) &&
              (step.x_t1[i] - step.x_t0[i] - shift).squaredNorm() > most * most)
            count += 1.0;
        return count;
      });
  if (others > 0.0) return false;
  if (anchored) return true;
  for (std::size_t i = 0; i < step.mass.size(); ++i) shift += step.h * step.mass[i] * step.v_t0[i];
  shift /= total(step.mass);
  return true;
}

// A step that starts where the last one ended starts with its energy, unless forces have updated
// their memory since.
double EnergyBalance::start_energy(const ForceSum& forces, const BalanceStep& step) {
  if (!remembers_) {
    std::vector<double> memory;
    forces.save_memory(memory);
    remembers_ = !memory.empty();
  }
  if (!*remembers_ && carried_) return *carried_;
  return forces.energy({step.x_t0.first(step.mass.size()), step.v_t0, step.mass, step.time});
}

bool EnergyBalance::weigh(const ForceSum& forces, const BalanceStep& step) {
  Vec3 shift;
  const std::size_t n = step.mass.size();
  weighed_ = closed_ && n > 0;
  double work = 0.0;
  if (weighed_ && !common_shift(step, shift)) {
    shift.setZero();
    const std::optional<double> known = step.anchor_work ? step.anchor_work() : std::nullopt;
    weighed_ = known.has_value();
    work = known.value_or(0.0);
  }
  if (!weighed_) return false;
  const Vec3 frame = shift / step.h;
  const double mass = total(step.mass);
  if (!start_) start_ = start_energy(forces, step);
  const std::span<const Vec3> x_end = step.x_t1.first(n);
  end_ = forces.energy({x_end, step.v_t1, step.mass, step.time + step.h});
  carried_.reset();
  const double before = kinetic(step, step.v_t0, frame), after = kinetic(step, step.v_t1, frame);
  // In the frame that moves by `shift`, the cloth is lower by as much.
  gain_ = after - before + end_ - *start_ + mass * gravity_.dot(shift) +
          step.program_force.dot(shift) - work;
  // Cloth at rest is not tested to its last digits: less than a rest gap per frame is slow.
  bound_ = kGain * (std::max(before, after) + 0.5 * mass * slow_ * slow_);
  return true;
}

bool EnergyBalance::wants_shorter() {
  if (!guards_ || !weighed_ || gain_ <= bound_) return false;
  if (last_gain_ >= 0.0 && gain_ > kHelps * last_gain_) return false;
  last_gain_ = gain_;
  ++retries_;
  return true;
}

void EnergyBalance::accept() {
  carried_ = weighed_ ? std::optional(end_) : std::nullopt;
  if (!weighed_) return;
  ++steps_;
  if (gain_ <= bound_) return;
  ++gained_steps_;
  gained_ += gain_;
  max_gain_ = std::max(max_gain_, gain_);
}

void EnergyBalance::continue_from(const std::map<std::string, double>& figures) {
  if (figures.empty()) return;
  steps_ = static_cast<int>(figures.at("steps"));
  gained_steps_ = static_cast<int>(figures.at("gained_steps"));
  retries_ = static_cast<int>(figures.at("retries"));
  gained_ = figures.at("energy_gained_J");
  max_gain_ = figures.at("max_gain_J");
}

std::map<std::string, double> EnergyBalance::figures() const {
  return {{"steps", steps_},
          {"gained_steps", gained_steps_},
          {"retries", retries_},
          {"energy_gained_J", gained_},
          {"max_gain_J", max_gain_}};
}

}  // namespace selvedge::detail
