// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/force_sum.h>
#include <selvedge/response/response.h>
#include <selvedge/scene/scene.h>

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// A try of a step as the balance sees it; views.
struct BalanceStep {
  std::span<const Vec3> x_t0, x_t1;  ///< m, particles, then body vertices
  std::span<const Vec3> v_t0, v_t1;  ///< m/s, particles, at the start and at the end
  std::span<const double> inv_mass;  ///< 1/kg, as x_t0; 0: held, or of a body
  std::span<const double> mass;      ///< kg, particles
  double time = 0.0, h = 0.0;        ///< s
};

/// The energy that a step gains from nowhere: that of the cloth (kinetic, elastic, weight) at its
/// end less that at its start, as who stands on the bodies and held particles sees it. Friction,
/// damping and impacts only take, so that a gain is an error of the method: of the one linear solve
/// of a step, or of a response that moves particles after it and stretches springs.
///
/// Asked only where the answer is sure: no wind, water or volume that has no energy of its own, no
/// contacts that are springs, and all that is held or a body moves on by the same. The balance of a
/// scene that moves as a whole is that of the scene at rest.
class EnergyBalance {
 public:
  EnergyBalance(const Scene& scene, const BuiltScene& built, const ResponseTraits& response);

  /// A step from a new start begins.
  void begin();
  /// Whether the balance of this step is known; if so `gain` and `bound` are those of this try.
  bool weigh(const ForceSum& forces, const BalanceStep& step);
  double gain() const { return gain_; }    ///< J, of the last weighed try; negative: taken
  double bound() const { return bound_; }  ///< J, a gain below it is not worth another try
  /// Contacts give back `work`, J, that they had stored.
  void stored(double work) { gain_ -= work; }
  /// Whether a try half as long is worth it: the gain is above the bound, and the last halving, if
  /// there was one, has lessened it.
  bool wants_shorter();
  /// The last try is accepted.
  void accept();

  /// steps that were weighed, gained_steps that gained more than the bound and were accepted all
  /// the same, retries, energy_gained_J by those steps and max_gain_J of one.
  std::map<std::string, double> figures() const;

 private:
  bool common_shift(const BalanceStep& step, Vec3& shift) const;

  bool closed_ = false;   // nothing from outside acts on the cloth
  bool rooted_ = false;   // springs to places in space
  Vec3 gravity_;          // m/s²
  double slow_ = 0.0;     // m/s
  bool weighed_ = false;  // the last try
  double gain_ = 0.0, bound_ = 0.0, last_gain_ = -1.0;
  std::optional<double> start_;  // J, potential energy; not the last end, as forces have memory
  int steps_ = 0, gained_steps_ = 0, retries_ = 0;
  double gained_ = 0.0, max_gain_ = 0.0;
};

}  // namespace selvedge::detail
