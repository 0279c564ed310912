// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/force.h>

#include <vector>

namespace selvedge::detail {

/// Velocity of the air as a field of position and time: the wind, gusts that the wind carries along
/// [Kraichnan1970], and jets [Pope2000]. The cloth and the bodies do not change it.
class AirFlow {
 public:
  /// Throws std::invalid_argument if a number is not finite, out of range, or a direction is zero.
  explicit AirFlow(const AirConfig& config);

  /// m/s at `x` (m) and `time` (s).
  Vec3 velocity(const Vec3& x, double time) const;
  /// Whether it is the wind alone, everywhere and at any time.
  bool is_uniform() const { return modes_.empty() && jets_.empty(); }

 private:
  /// One wave of the gusts: cosine cos(k·y + rate t) + sine sin(k·y + rate t), y moving with the
  /// wind. Both amplitudes are perpendicular to k, so that the field has no divergence.
  struct Mode {
    Vec3 wave;          // k, 1/m
    double rate = 0.0;  // 1/s
    Vec3 cosine, sine;  // m/s
  };

  Vec3 wind_;
  std::vector<Mode> modes_;
  std::vector<AirJet> jets_;  // directions have length 1
};

}  // namespace selvedge::detail
