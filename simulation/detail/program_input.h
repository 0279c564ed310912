// SPDX-License-Identifier: MIT
//
// What a program sets between the steps of a simulation: forces, and particles that it holds.
#pragma once

#include <selvedge/core/cloth/force.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace selvedge::detail {

/// A particle that moves on a straight line from `from` at t0 to `to` at t1, and rests there.
struct HeldByProgram {
  std::int32_t particle = 0;
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  ///< m
  double t0 = 0.0, t1 = 0.0;                    ///< s, t0 < t1

  Vec3 at(double time) const {
    if (time >= t1) return to;
    return time <= t0 ? from : Vec3(from + (time - t0) / (t1 - t0) * (to - from));
  }
};

/// The input that a program has set. It acts until it is set again.
struct ProgramInput {
  std::vector<Vec3> force;          ///< N per particle; empty: none
  std::vector<HeldByProgram> held;  ///< sorted by particle

  /// N, of all particles.
  Vec3 total_force() const;
  /// Holds one more particle, or replaces how it is held.
  void hold(const HeldByProgram& particle);
  void release(std::int32_t particle);
};

/// The force f = input.force. During a step it is constant, with the potential -Σ f·x, so that the
/// energy balance of the step stays closed. `input` must outlive it.
std::unique_ptr<Force> make_program_force(const ProgramInput& input);

}  // namespace selvedge::detail
