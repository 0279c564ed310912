// SPDX-License-Identifier: MIT
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/strain_stage.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace selvedge::detail {
namespace {

/// Rounds of a limiter that moves single particles and of restoring that followers follow.
constexpr int kFollowerRounds = 10;

/// A strain within this of its target is held there: sweeps begin above their tolerance, and one
/// may shorten what another has brought to its target.
constexpr double kHeldStrain = kStrainTolerance;

/// Distance that a parted pair keeps, and the part of it that may be missing, as shares of its rest
/// gap; a pair that the fail-safe left nearer keeps its distance.
constexpr double kPartedGap = 0.1;
constexpr double kPartedSlack = 0.001;

std::size_t count(const BuiltScene& built) { return built.cloth.surface.vertices.size(); }

/// Weight of piece p per width, N/m, if it hangs by one end of its longest extent.
double hanging_weight(const Scene& scene, const BuiltScene& built, std::size_t p) {
  const auto begin = static_cast<std::size_t>(built.piece_begin[p]);
  const auto end = static_cast<std::size_t>(built.piece_begin[p + 1]);
  if (begin == end) return 0.0;  // all of its vertices are those of seams now
  Vec3 low = built.cloth.surface.vertices[begin], high = low;
  for (std::size_t i = begin; i < end; ++i) {
    low = low.cwiseMin(built.cloth.surface.vertices[i]);
    high = high.cwiseMax(built.cloth.surface.vertices[i]);
  }
  const Material& material = scene.materials.at(scene.cloths[p].material);
  return material.density * scene.gravity.norm() * (high - low).maxCoeff();
}

/// The method of the scene; none if the scene has no limiter that changes the ends of steps.
StrainLimit limit_of(const Scene& scene, const BuiltScene& built,
                     const StrainLimiterRegistry& limiters) {
  if (limiter_kind(scene, limiters) != LimiterKind::method) return {};
  return make_method(limiters, scene.solver.limiter, "solver.strain_limiter",
                     scene.solver.limiter_options, built.cloth.springs,
                     limiter_targets(built.cloth.strain_limit), count(built));
}

/// None if the method measures.
std::optional<StrainLimiter> own_measures(const BuiltScene& built,
                                          const StrainLimitMethod* method) {
  if (method != nullptr && method->limiter() != nullptr) return std::nullopt;
  return StrainLimiter(built.cloth.springs, limiter_targets(built.cloth.strain_limit),
                       count(built));
}

}  // namespace

std::vector<double> limiter_targets(const std::vector<double>& limits) {
  std::vector<double> targets = limits;
  for (double& limit : targets) limit = std::max(limit - kStrainTolerance, 0.5 * limit);
  return targets;
}

LimiterKind limiter_kind(const Scene& scene, const StrainLimiterRegistry& limiters) {
  if (!scene.solver.strain_limiter) return LimiterKind::none;
  if (const std::string fault = limiters.fault(scene.solver.limiter); !fault.empty())
    throw std::invalid_argument("solver.strain_limiter: " + fault);
  return limiters.at(scene.solver.limiter).traits().kind;
}

StrainStage::StrainStage(const Scene& scene, const BuiltScene& built,
                         const StrainLimiterRegistry& limiters)
    : StrainStage(scene.plan.proofs, built, limit_of(scene, built, limiters)) {}

StrainStage::StrainStage(bool proofs, const BuiltScene& built, StrainLimit limit)
    : method_(std::move(limit.method)),
      max_sweeps_(limit.max_sweeps),
      own_(own_measures(built, method_.get())),
      reach_(proofs, measures()),
      before_(count(built)),
      shift_(count(built), Vec3::Zero()) {
  if (!method_) return;
  traits_ = method_->traits();
  method_->set_directions(built.cloth.surface.triangles, built.rest);
}

void StrainStage::begin() {
  if (std::exchange(moved_, false)) std::fill(shift_.begin(), shift_.end(), Vec3::Zero());
}

int StrainStage::limit(const LimitStep& step, std::span<Vec3> x_t1, KeepFollowers keep,
                       PhaseClock& clock) {
  {
    const auto scope = clock.measure("plan");
    if (reach_.keeps_limits(x_t1, traits_.limits)) return 0;
  }
  const auto scope = clock.measure("strain");
  const PhaseClock::Scope busy(reach_.busy());
  std::copy(x_t1.begin(), x_t1.end(), before_.begin());
  LimitStep own = step;
  own.tolerance = kStrainTolerance;
  own.max_sweeps = max_sweeps_;
  int sweeps = 0;
  for (int round = 0; round < kFollowerRounds; ++round) {
    const StrainReport report = method_->limit_ends(own, x_t1);
    sweeps += report.sweeps;
    if (report.sweeps == 0 || !keep(x_t1)) break;
  }
  if (sweeps == 0) return 0;
  moved_ = true;
  for (std::size_t i = 0; i < shift_.size(); ++i) shift_[i] += x_t1[i] - before_[i];
  return sweeps;
}

// One sweep over the pairs. Returns the largest distance by which one was too near, as a share of
// its rest gap.
double StrainStage::push_apart(const PartedPairs& parted, std::span<Vec3> x_t1) {
  double worst = 0.0;
  for (std::size_t p = 0; p < parted.pairs.size(); ++p) {
    const ContactPoint& c = parted.pairs[p];
    const double nearer = least_[p] - c.normal.dot(relative(c, x_t1));
    const double yielding = compliance(c, parted.inv_mass);
    if (!(nearer > 0.0 && yielding > 0.0)) continue;
    worst = std::max(worst, nearer / c.rest_gap);
    for (int k = 0; k < 4; ++k) {
      const std::int32_t i = c.vertex[k];
      const Vec3 move = (c.weight[k] * parted.inv_mass[i] * nearer / yielding) * c.normal;
      if (parted.inv_mass[i] <= 0.0) continue;
      x_t1[i] += move;
      pushed_[i] += move;
    }
  }
  return worst;
}

int StrainStage::limit_beside(const LimitStep& step, const PartedPairs& parted,
                              std::span<Vec3> x_t1, KeepFollowers keep, PhaseClock& clock) {
  const auto scope = clock.measure("strain");
  const PhaseClock::Scope busy(reach_.busy());
  const std::span<Vec3> ends = x_t1.first(before_.size());
  std::copy(ends.begin(), ends.end(), before_.begin());
  pushed_.assign(ends.size(), Vec3::Zero());
  least_.clear();
  for (const ContactPoint& c : parted.pairs)
    least_.push_back(std::min(c.normal.dot(relative(c, x_t1)), kPartedGap * c.rest_gap));
  LimitStep own = step;
  own.tolerance = kStrainTolerance;
  own.max_sweeps = 1;
  int sweeps = 0;
  while (sweeps < max_sweeps_) {
    const StrainReport report = method_->limit_ends(own, ends);
    const double nearer = push_apart(parted, x_t1);
    keep(ends);
    if (report.sweeps == 0 && nearer <= kPartedSlack) break;
    ++sweeps;
  }
  moved_ = true;
  for (std::size_t i = 0; i < shift_.size(); ++i) shift_[i] += ends[i] - before_[i] - pushed_[i];
  return sweeps;
}

bool StrainStage::is_tolerated(std::span<const Vec3> x) {
  if (acts())
    if (const auto own = method_->worst(x)) return own->strain - own->limit <= kStrainTolerance;
  constexpr double kAny = std::numeric_limits<double>::infinity();
  return reach_.keeps_below(x, kAny, kStrainTolerance) ||
         measures().measure(x).residual <= kStrainTolerance;
}

std::vector<HeldStrain> StrainStage::held(std::span<const Vec3> x) const {
  std::vector<HeldStrain> held;
  if (acts()) method_->find_held(x, kHeldStrain, held);
  return held;
}

double StrainStage::overshoot(std::span<const Vec3> x) {
  if (is_tolerated(x)) return 0.0;
  if (acts())
    if (const auto own = method_->worst(x))
      return own->strain / (own->limit + kStrainTolerance) - 1.0;
  const std::span<const Spring> springs = measures().springs();
  const std::span<const double> targets = measures().limits();
  double worst = 0.0;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const double length = (x[springs[s].b] - x[springs[s].a]).norm();
    const double limit = targets[s] + kStrainTolerance;
    worst = std::max(worst, (length / springs[s].rest_length - 1.0) / limit - 1.0);
  }
  return worst;
}

std::optional<StrainReport> StrainStage::measure(std::span<const Vec3> x, double max_strain,
                                                 PhaseClock& clock) {
  {
    const auto scope = clock.measure("plan");
    if (reach_.keeps_below(x, max_strain, kStrainTolerance)) return std::nullopt;
  }
  return reach_.measure(measures(), x);
}

void StrainStage::finish(const LimitStep& step, std::span<const double> mass,
                         std::span<const Vec3> x, std::span<Vec3> v) {
  if (!acts() || !moved_) return;
  // From here on `before_` holds the velocities without the limiter.
  for (std::size_t i = 0; i < shift_.size(); ++i) before_[i] = v[i] - shift_[i] / step.h;
  if (traits_.keeps_velocity) std::copy(before_.begin(), before_.end(), v.begin());
  LimitStep own = step;
  own.tolerance = kStrainTolerance;
  own.max_sweeps = max_sweeps_;
  method_->limit_velocities(own, x, v);
  Vec3 given = Vec3::Zero();
  double moved = 0.0, energy = 0.0;
  for (std::size_t i = 0; i < shift_.size(); ++i) {
    if (step.inv_mass[i] <= 0.0) continue;
    const Vec3 change = mass[i] * (v[i] - before_[i]);
    given += change;
    moved += change.norm();
    energy += 0.5 * mass[i] * (v[i].squaredNorm() - before_[i].squaredNorm());
  }
  ++steps_;
  momentum_ += given;
  if (moved > 0.0) momentum_error_ = std::max(momentum_error_, given.norm() / moved);
  energy_ += energy;
}

void StrainStage::continue_from(const std::map<std::string, double>& figures) {
  if (figures.empty()) return;
  steps_ = static_cast<int>(figures.at("steps"));
  momentum_ = {figures.at("momentum_x"), figures.at("momentum_y"), figures.at("momentum_z")};
  momentum_error_ = figures.at("max_momentum_error");
  energy_ = figures.at("energy_kinetic_J");
}

std::map<std::string, double> StrainStage::figures() const {
  return {{"steps", steps_},
          {"momentum_x", momentum_.x()},
          {"momentum_y", momentum_.y()},
          {"momentum_z", momentum_.z()},
          {"max_momentum_error", momentum_error_},
          {"energy_kinetic_J", energy_}};
}

BuiltScene with_policy(Scene& scene, BuiltScene built, const StrainLimiterRegistry& limiters) {
  if (limiter_kind(scene, limiters) != LimiterKind::stiffens) return built;
  StiffnessPolicy policy;
  for (std::size_t p = 0; p < scene.cloths.size(); ++p) {
    const Material& material = scene.materials.at(scene.cloths[p].material);
    const double softer = std::min(material.stretch_stiffness, stretch_along_weft(material));
    const StiffnessPolicy own =
        chittaro_policy(hanging_weight(scene, built, p), softer, material.strain_limit);
    if (own.stiffness > policy.stiffness) policy = own;
  }
  for (Spring& spring : built.cloth.springs) spring.stiffness *= policy.stiffness;
  for (MembraneTriangle& t : built.cloth.membranes)
    for (double* constant : {&t.c11, &t.c22, &t.c12, &t.c33}) *constant *= policy.stiffness;
  for (YarnTriangle& t : built.cloth.yarns)
    for (double* constant : {&t.warp, &t.weft, &t.shear}) *constant *= policy.stiffness;
  scene.time.steps_per_frame =
      static_cast<int>(std::ceil(scene.time.steps_per_frame / policy.step));
  return built;
}

}  // namespace selvedge::detail
