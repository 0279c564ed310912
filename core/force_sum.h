// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/force.h>

#include <memory>
#include <span>
#include <vector>

namespace selvedge {

/// Bounds of what the forces on a cloth do in time.
struct ModeBound {
  double omega = 0.0;  ///< rad/s, no mode is faster
  double rate = 0.0;   ///< 1/s, no mode is damped more: x'' = -omega² x - rate x'
};

/// All forces on one cloth together, as integrators evaluate them.
class ForceSum {
 public:
  ForceSum(std::vector<std::unique_ptr<Force>> forces, std::size_t particles);

  std::size_t particles() const { return stiffness_.size(); }
  std::span<const std::unique_ptr<Force>> members() const { return forces_; }

  /// f = all forces, N.
  void evaluate(const ForceState& state, std::span<Vec3> f) const;
  /// a = f·inv_mass, m/s²; 0 for held particles.
  void accelerate(const ForceState& state, std::span<const double> inv_mass,
                  std::span<Vec3> a) const;
  /// Sum of the potential energies, J.
  double energy(const ForceState& state) const;
  /// Gershgorin's bounds at the present positions, held particles standing still.
  ModeBound bound(const Particles& particles, double time);

  /// The step ended in `state`.
  void accept(const ForceState& state);
  /// Appends what the forces remember.
  void save_memory(std::vector<double>& memory) const;
  /// The same read back; returns what is left. Throws std::invalid_argument where it is too short.
  std::span<const double> restore_memory(std::span<const double> memory);

 private:
  std::vector<std::unique_ptr<Force>> forces_;
  std::vector<double> stiffness_, damping_;  // scratch of `bound`
};

}  // namespace selvedge
