// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/force.h>
#include <selvedge/response/response.h>
#include <selvedge/scene/build.h>

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Input of the energy balance: an attempt of a step; views.
struct BalanceStep {
  std::span<const Vec3> x_t0, x_t1;   ///< m, particles, then body vertices
  std::span<const Vec3> v_t0, v_t1;   ///< m/s, particles, at the start and at the end
  std::span<const double> inv_mass;   ///< 1/kg, as x_t0; 0: held, or of a body
  std::span<const double> mass;       ///< kg, particles
  double time = 0.0, h = 0.0;         ///< s
  Vec3 program_force = Vec3::Zero();  ///< N, sum of the forces that the program has set
  /// J, what the bodies and held particles did to the cloth, which is asked for where they do not
  /// move as one; nullopt: not known.
  std::function<std::optional<double>()> anchor_work = {};
};

/// Verifies that a step creates no energy. The gain of a step is the energy of the cloth (kinetic,
/// elastic, weight) at its end less that at its start and less what bodies and held particles gave.
/// Friction, damping and impacts only dissipate, so a gain is an error of the method: of the single
/// linear solve of a step, or of a response that moves particles after it and stretches springs.
///
/// The gain is known only if no wind, no water and no volume without an energy acts, contacts are
/// no springs, and either all bodies and held particles have the same displacement or their work is
/// known. In the first case they give nothing in the frame that moves with them: the balance of a
/// scene that moves as a whole equals that of the scene at rest.
class EnergyBalance {
 public:
  EnergyBalance(const Scene& scene, const BuiltScene& built, const ResponseTraits& response);

  /// Call before the first attempt of a step.
  void begin();
  /// Whether the balance of this step is known; if so, sets `gain` and `bound` for this attempt.
  bool weigh(const ForceSum& forces, const BalanceStep& step);
  double gain() const { return gain_; }    ///< J, of the last weighed attempt; negative: lost
  double bound() const { return bound_; }  ///< J, a smaller gain is not worth another attempt
  /// Subtracts energy, J, that contacts had stored and returned.
  void stored(double work) { gain_ -= work; }
  /// Whether an attempt of half the length is worth it: the gain is above the bound, and the last
  /// halving, if there was one, reduced it.
  bool wants_shorter();
  /// Call when the state or a force changed between steps.
  void forget() { carried_.reset(); }
  /// Call when the last attempt is accepted.
  void accept();

  /// Goes on adding to the figures of an earlier part of the run; empty: there was none.
  void continue_from(const std::map<std::string, double>& figures);

  /// steps that were weighed, gained_steps that were accepted with a gain above the bound, retries,
  /// energy_gained_J by those steps and max_gain_J of one.
  std::map<std::string, double> figures() const;

 private:
  bool common_shift(const BalanceStep& step, Vec3& shift) const;
  double start_energy(const ForceSum& forces, const BalanceStep& step);

  bool closed_ = false;   // nothing from outside acts on the cloth
  bool rooted_ = false;   // springs to places in space, guides, forces on solids
  Vec3 gravity_;          // m/s²
  double slow_ = 0.0;     // m/s
  bool guards_ = true;    // asks for shorter steps
  bool weighed_ = false;  // the last attempt
  double gain_ = 0.0, bound_ = 0.0, last_gain_ = -1.0;
  std::optional<double> start_;  // J, potential energy at the start of the step
  double end_ = 0.0;             // J, potential energy at the end of the last weighed attempt
  std::optional<double>
      carried_;  // J, that of the accepted state, unless a weighed attempt left it
  std::optional<bool> remembers_;  // forces have a memory, which a step changes
  int steps_ = 0, gained_steps_ = 0, retries_ = 0;
  double gained_ = 0.0, max_gain_ = 0.0;
};

}  // namespace selvedge::detail
