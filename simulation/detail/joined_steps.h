// SPDX-License-Identifier: MIT
//
// Which steps of a frame are taken as one.
#pragma once

#include <selvedge/core/solver/integrator.h>
#include <selvedge/scene/build.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Joins two steps of a frame where the motion is so even that a longer step loses little
/// (`time.step_error`). In a step h, implicit Euler moves a particle by h v⁺, the trapezoidal rule
/// by h (v + v⁺)/2. Half the difference of the velocities times h, h² a/2, estimates the error. It
/// is compared with the size of the piece, which makes the rule the same at every scale. The bound
/// shrinks with the square of the steps per frame, so that twice as many still halve every step.
class JoinedSteps {
 public:
  /// No step is joined unless the integrator is of first order and stable at any step: methods of
  /// higher order need equal steps, and explicit ones short steps.
  JoinedSteps(const Scene& scene, const BuiltScene& built, const IntegratorTraits& traits);

  /// Steps that are taken as one after `done` steps of the run, 1 or 2; they end at most with the
  /// frame. `acceleration`: of the last step, 1/s²; negative: unknown, and nothing is joined.
  int span(std::int64_t done, double acceleration) const;

  /// The root mean square acceleration of a piece, by its size, 1/s²: the largest of the pieces.
  /// `before` and `after`: velocities at both ends of a step of `h` s, m/s. Negative if nothing is
  /// ever joined, or if it is not finite: a checkpoint holds only finite numbers.
  double acceleration(std::span<const Vec3> before, std::span<const Vec3> after, double h) const;

 private:
  double bound_;  // of the error of a step, by the size of a piece; 0: never joins
  int steps_per_frame_;
  double h_;                               // s, of a nominal step
  std::vector<std::int32_t> piece_begin_;  // first vertex of each piece, and the total
  std::vector<double> size_;               // m, of each piece: root of its area
};

}  // namespace selvedge::detail
