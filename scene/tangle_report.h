// SPDX-License-Identifier: MIT
#pragma once

namespace selvedge {

/// What a run says of the tangles it started with; all 0 for one that started clean.
struct TangleReport {
  int start_pairs = 0;     ///< triangle pairs that crossed at the start
  int pairs = 0;           ///< that still do
  int elsewhere = 0;       ///< most pairs at one time that crossed outside of the tangles
  double until_s = 0.0;    ///< time at which the last one was free; -1: one is not
  double max_speed = 0.0;  ///< m/s, fastest particle at any accepted state until then
  bool given_up = false;   ///< no way led on
};

}  // namespace selvedge
