// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/simulation.h>

#include <optional>

namespace selvedge::detail {

/// The water of a scene in time.
class Water {
 public:
  /// Throws std::invalid_argument for a source of a piece that there is not, and for a cloth in
  /// which water cannot spread.
  Water(const Scene& scene, const BuiltScene& built);

  /// What dropped and spread while the step from t0 on took h seconds: velocities, `water` (kg per
  /// vertex, empty at first) and masses at its end.
  void advance(double t0, double h, SimulationState& state, std::vector<double>& mass);
  /// Goes on from a state that was saved.
  void restore(const SimulationState& state, std::vector<double>& mass);
  double dripped() const { return dripped_; }  ///< kg so far, in this part of the run

 private:
  struct Drop {
    std::int32_t vertex;
    double rate, begin, end;  ///< kg/s, s
    Vec3 velocity;
  };
  void note(SimulationState& state, std::vector<double>& mass) const;

  WettingConfig config_;
  TriangleMesh shape_;
  std::vector<double> dry_;
  std::optional<Wetting> wetting_;
  std::vector<Drop> drops_;
  double dripped_ = 0.0;
};

}  // namespace selvedge::detail
