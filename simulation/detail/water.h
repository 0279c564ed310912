// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation_state.h>

#include <optional>

namespace selvedge::detail {

/// The water of a scene in time.
class Water {
 public:
  /// Throws std::invalid_argument for a source of an unknown piece, and for a cloth in which water
  /// cannot spread.
  Water(const Scene& scene, const BuiltScene& built);

  /// Lets water drop and spread during the step of h seconds from t0 on. Changes velocities,
  /// `water` (kg per vertex, empty at first) and masses to those at its end.
  void advance(double t0, double h, SimulationState& state, std::vector<double>& mass);
  /// Continues from a saved state.
  void restore(const SimulationState& state, std::vector<double>& mass);
  double dripped() const { return dripped_; }  ///< kg so far
  /// Goes on adding to what dripped in an earlier part of the run, kg.
  void continue_from(double dripped) { dripped_ = dripped; }

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
