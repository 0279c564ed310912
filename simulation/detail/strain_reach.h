// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/simulation/contacts/detail/idle_proofs.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Proves that springs are within their limits without visiting them: since the last measure, the
/// length of a spring can have changed at most by the relative displacement of its ends.
///
/// After a measure at positions y, let D be the diagonal of the box of the displacements x − y of
/// all particles. Two displacements differ by at most |D|, so no spring is longer or shorter by
/// more, and no strain is larger or smaller by more than |D| over the shortest rest length. The box
/// of the particles takes a quarter of the time of measuring their springs. A sheet that falls, is
/// carried or rests is proved for many steps.
///
/// The energy bound ½ K ε² A ≤ energy is no alternative: it does not hold for steps of finite
/// length, because the linear solve of an implicit step can gain energy.
class StrainReach {
 public:
  /// `on`: if false, nothing is proved. `measure` has the springs in question.
  StrainReach(bool on, const StrainLimiter& measure);

  /// Measures at x; later bounds start from there.
  StrainReport measure(const StrainLimiter& measure, std::span<const Vec3> x);
  /// Whether no spring at x exceeds a limit of this kind; counted.
  bool keeps_limits(std::span<const Vec3> x, LimitedStrain limits);
  /// Whether no strain at x is above `max_strain`, nor over its limit by more than `excess`.
  bool keeps_below(std::span<const Vec3> x, double max_strain, double excess);

  const IdleCount& count() const { return count_; }
  double& busy() { return count_.busy_s; }

 private:
  double change(std::span<const Vec3> x) const;

  bool on_;
  double shortest_ = 0.0;           // rest length, m
  std::vector<Vec3> measured_;      // m; empty: never
  StrainReport report_;             // at measured_
  ProofBackoff limits_, measures_;  // each has its own failures
  IdleCount count_;
};

}  // namespace selvedge::detail
