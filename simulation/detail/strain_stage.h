// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/response/response.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/contacts/detail/phase_clock.h>
#include <selvedge/simulation/detail/strain_reach.h>

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Strain above the limit that the limiter may leave.
inline constexpr double kStrainTolerance = 1e-3;

/// Limits that a limiter aims at: lower by the tolerance, so that the limits themselves hold.
std::vector<double> limiter_targets(const std::vector<double>& limits);

/// Restores that followers follow; false if no particle does.
using KeepFollowers = FunctionRef<bool(std::span<Vec3>)>;

/// Pairs that a fail-safe has parted in a step; views.
struct PartedPairs {
  std::span<const ContactPoint> pairs;
  std::span<const double> inv_mass;  ///< 1/kg, joint
};

/// The strain of a scene's springs: measures it, limits it at the ends of steps, and keeps account
/// of the momentum and energy that the limiter exchanges. Leaves out measures and limits that
/// provably change nothing (StrainReach).
class StrainStage {
 public:
  StrainStage(const Scene& scene, const BuiltScene& built, const StrainLimiterRegistry& limiters);

  /// Whether a limiter acts on the ends of steps.
  bool acts() const { return method_ != nullptr; }
  /// Whether the limiter continues until the limits hold.
  bool bounds_strain() const { return acts() && traits_.bounds_strain; }

  /// The springs and the limits that are aimed at.
  const StrainLimiter& measures() const { return own_ ? *own_ : *method_->limiter(); }

  /// Call when the ends of the particles are set anew.
  void begin();
  /// Moves the ends of the particles, m, until the limits hold or the sweeps are used up; returns
  /// the number of sweeps. Requires acts(). Followers stay followers: limiter and `keep` alternate.
  int limit(const LimitStep& step, std::span<Vec3> x_t1, KeepFollowers keep, PhaseClock& clock);
  /// The same beside collisions: the limiter must not close what the fail-safe has parted. `x_t1`
  /// and `inv_mass`: joint. Each sweep of the limiter is followed by one over the collisions.
  int limit_beside(const LimitStep& step, const PartedPairs& parted, std::span<Vec3> x_t1,
                   KeepFollowers keep, PhaseClock& clock);
  /// Whether nothing that the limiter bounds exceeds its limit at x by more than the tolerance.
  bool is_tolerated(std::span<const Vec3> x);
  /// Whether it has moved a particle since `begin`.
  bool has_moved() const { return moved_; }
  /// The strains at x that the limiter holds; none if it does not act.
  std::vector<HeldStrain> held(std::span<const Vec3> x) const;
  /// Changes the velocities of an accepted step, m/s, if the limiter does.
  void finish(const LimitStep& step, std::span<const double> mass, std::span<const Vec3> x,
              std::span<Vec3> v);
  /// Largest strain at x above its limit, as a share of the limit; 0 if all are tolerated.
  double overshoot(std::span<const Vec3> x);
  /// Measures the strain of a state; none if it provably exceeds neither `max_strain` nor its
  /// limits.
  std::optional<StrainReport> measure(std::span<const Vec3> x, double max_strain,
                                      PhaseClock& clock);

  /// Goes on adding to the figures of an earlier part of the run; empty: there was none.
  void continue_from(const std::map<std::string, double>& figures);

  /// steps, momentum_{x,y,z} given to free particles (N·s), max_momentum_error of a step, as a
  /// share of the momenta moved, and energy_kinetic_J.
  std::map<std::string, double> figures() const;
  /// How often limits were due and how often they were left out.
  const IdleCount& idle_count() const { return reach_.count(); }

 private:
  StrainStage(bool proofs, const BuiltScene& built, StrainLimit limit);

  std::unique_ptr<StrainLimitMethod> method_;  // null: the scene limits no strain
  int max_sweeps_ = 0;
  std::optional<StrainLimiter> own_;  // if the method has none
  StrainReach reach_;
  LimiterTraits traits_;
  double push_apart(const PartedPairs& parted, std::span<Vec3> x_t1);

  std::vector<Vec3> before_, shift_;  // m, displacement since begin
  std::vector<Vec3> pushed_;          // m, by the pairs of limit_beside
  std::vector<double> least_;         // m, distance that such a pair keeps
  bool moved_ = false;
  int steps_ = 0;
  Vec3 momentum_ = Vec3::Zero();
  double momentum_error_ = 0.0, energy_ = 0.0;
};

/// How the limiter of a scene acts; LimiterKind::none if it is off. Throws std::invalid_argument
/// for an unknown name.
LimiterKind limiter_kind(const Scene& scene, const StrainLimiterRegistry& limiters);

/// Applies Chittaro's policy if it is the scene's limiter: where a piece would hang too long, makes
/// the springs stiffer and shortens the steps of `scene`. Returns other scenes unchanged.
BuiltScene with_policy(Scene& scene, BuiltScene built, const StrainLimiterRegistry& limiters);

}  // namespace selvedge::detail
