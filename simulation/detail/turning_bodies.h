// SPDX-License-Identifier: MIT
//
// The longest step in which a rotating body follows its true path closely enough.
#pragma once

#include <selvedge/scene/build.h>

#include <cstddef>
#include <vector>

namespace selvedge::detail {

/// The bodies that turn along keyframes. A step moves every vertex on the chord of its arc, and is
/// clean on chords. It is so short that no point of a chord is farther from the true path than a
/// quarter of the smallest rest gap between the body and a piece: too little to pass the cloth,
/// which lies at least half a rest gap away.
class TurningBodies {
 public:
  TurningBodies(const Scene& scene, const BuiltScene& built);

  /// The longest step from `time`, s, at most h. It ends where a turn begins, ends or changes.
  double longest_step(const BuiltScene& built, double time, double h) const;

 private:
  /// Between two keyframes.
  struct Turn {
    double begin, end;  // s
    double longest;     // s, longest step; infinite if the body does not turn
    bool turns() const;
  };
  struct TurningBody {
    std::size_t index;  // in BuiltScene::bodies
    std::vector<Turn> turns;
  };

  static double longest_step(const std::vector<Turn>& turns, double time, double h);

  std::vector<TurningBody> bodies_;
};

}  // namespace selvedge::detail
