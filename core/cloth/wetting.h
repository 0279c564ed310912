// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

namespace selvedge {

/// Constants of water transport in cloth.
struct WettingConfig {
  double diffusivity = 1e-6;  ///< m²/s, of water in the cloth, >= 0
  /// kg of water that a kg of dry cloth holds, > 0; the excess drips off.
  double saturation = 2.0;
};

/// Water that spreads in cloth by Fick's law, ∂w/∂t = D ∇²w, and adds to its mass
/// [ChenThalmannAllen2012; survey 3.2.6]. Linear finite elements with lumped areas (cotangents) and
/// as many explicit steps as stability requires.
class Wetting {
 public:
  /// `rest` is the flat shape, which defines areas and angles; `dry_mass` in kg per vertex, > 0. No
  /// water reaches a vertex without a triangle. Throws std::invalid_argument naming the bad value.
  Wetting(const WettingConfig& config, const TriangleMesh& rest, std::span<const double> dry_mass);

  /// Adds kg >= 0 of water that moves with `velocity_of_water` (m/s) to a vertex. Changes the
  /// velocity `v` of the vertex so that momentum is conserved.
  void add_water(std::int32_t vertex, double kg, const Vec3& velocity_of_water, Vec3& v);
  /// Lets the water spread for `seconds`. Water carries the velocity of the vertex it leaves; `v`
  /// changes so that momentum is conserved. Water above the saturation of a vertex drips off at the
  /// velocity of the vertex. Returns the kilograms that dripped.
  double advance(double seconds, std::span<Vec3> v);

  std::span<const double> water() const { return water_; }  ///< kg per vertex
  std::span<const double> mass() const { return mass_; }    ///< kg per vertex, dry and water
  /// Longest stable explicit step, s; infinite if no water can spread.
  double stable_step() const { return stable_step_; }

 private:
  /// Flow between two vertices: kg/s per difference of kg/m².
  struct Channel {
    Edge ends;
    double conductance;
  };

  void spread(double seconds, std::span<Vec3> v);
  double drip();

  WettingConfig config_;
  std::vector<double> area_, dry_, water_, mass_, change_;
  std::vector<Vec3> momentum_;
  std::vector<Channel> channels_;
  double stable_step_;
};

}  // namespace selvedge
