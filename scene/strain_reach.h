// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/strain_limiter.h>
#include <selvedge/scene/idle_proofs.h>

#include <span>
#include <vector>

namespace selvedge {

/// Proves that springs are within their limits without looking at them: since they were measured,
/// none can have got longer than its ends were moved apart.
///
/// After a measure at positions y, let D be the diagonal of the box of the displacements x − y of
/// all particles. Two of them differ by at most |D|, so that no spring is longer by more, and no
/// strain larger by more than |D| over the shortest rest length. A box of particles is a quarter of
/// the work of their springs. A sheet that falls, is carried or rests is proved for many steps.
///
/// The survey of such bounds would have ½ K ε² A ≤ energy instead. That is none for a step of
/// finite length: one linear solve of an implicit step can gain energy.
class StrainReach {
 public:
  /// `on`: false proves nothing. Springs of `measure` are those that are asked for.
  StrainReach(bool on, const StrainLimiter& measure);

  /// Measures at x, which later bounds start from.
  StrainReport measure(const StrainLimiter& measure, std::span<const Vec3> x);
  /// Whether no spring at x exceeds its limit; counted.
  bool keeps_limits(std::span<const Vec3> x);
  /// Whether no strain at x is above `max_strain`, nor over its limit by more than `excess`.
  bool keeps_below(std::span<const Vec3> x, double max_strain, double excess);

  const IdleCount& count() const { return count_; }
  double& busy() { return count_.busy_s; }

 private:
  double growth(std::span<const Vec3> x) const;

  bool on_;
  double shortest_ = 0.0;           // rest length, m
  std::vector<Vec3> measured_;      // m; empty: never
  StrainReport report_;             // there
  ProofBackoff limits_, measures_;  // each has its own failures
  IdleCount count_;
};

}  // namespace selvedge
