// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/strain_limiter.h>
#include <selvedge/scene/scene.h>

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Strain above the limit that the limiter may leave.
inline constexpr double strain_tolerance = 1e-3;

/// Limits that a limiter aims at, so that with what it may leave the limits themselves hold.
std::vector<double> limiter_targets(const std::vector<double>& limits);

/// The strain limiter of a scene in its steps, and what it gives and takes.
class StrainStage {
 public:
  StrainStage(const Scene& scene, const BuiltScene& built, const StrainLimiterRegistry& limiters);

  /// Whether there is one that acts on the ends of steps.
  bool acts() const { return method_ != nullptr; }
  /// Whether it goes on until the limits hold.
  bool bounds_strain() const { return acts() && traits_.bounds_strain; }

  /// The ends of the particles are set anew.
  void begin();
  StrainReport limit(const LimitStep& step, std::span<Vec3> x_t1);
  /// The step was accepted; changes its velocities, m/s, where the limiter does.
  void finish(const LimitStep& step, std::span<const double> mass, std::span<const Vec3> x,
              std::span<Vec3> v);

  /// steps, momentum_{x,y,z} given to free particles (N·s), max_momentum_error of a step, as a
  /// share of the momenta moved, and energy_kinetic_J.
  std::map<std::string, double> figures() const;

 private:
  std::unique_ptr<StrainLimitMethod> method_;
  LimiterTraits traits_;
  std::vector<Vec3> before_, shift_;  // m, what it has moved since begin
  bool moved_ = false;
  int steps_ = 0;
  Vec3 momentum_ = Vec3::Zero();
  double momentum_error_ = 0.0, energy_ = 0.0;
};

/// Springs made stiffer and the steps of `scene` shortened, where its limiter is Chittaro's policy
/// and a piece would hang too long; otherwise `built` as it is.
BuiltScene with_policy(Scene& scene, BuiltScene built);

}  // namespace selvedge::detail
