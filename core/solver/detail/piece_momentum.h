// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Checks whether a solve has conserved the momentum of each piece of cloth. The conjugate
/// gradients measure the residual in the norm of their preconditioner. If stiff contacts couple a
/// piece to others, a force that shifts the whole piece has almost no weight in this norm: four
/// sheets that land on each other could gain or lose metres per second. The residual summed over
/// each piece reveals it.
class PieceMomentum {
 public:
  PieceMomentum() = default;
  /// Pieces are the connected components of `links` among n particles.
  PieceMomentum(std::span<const Edge> links, std::size_t n);

  /// The piece of each particle, and how many there are.
  std::span<const std::int32_t> of_particles() const { return piece_; }
  std::size_t count() const { return count_; }

  /// State of a solve: the residual of its equations in kg·m/s per particle, zero at held
  /// particles.
  struct Solve {
    std::span<const Vec3> residual, v, v_old;  ///< kg·m/s, m/s, m/s
    std::span<const double> mass;              ///< kg
    std::span<const Vec3> outside;  ///< kg·m/s per coordinate, impulse of external forces
    std::span<const char> free;     ///< 0: held
  };
  /// True if the residual summed over each piece is a small fraction of the momentum exchanged
  /// within it in the step, or of the momentum from external forces.
  bool kept(const Solve& solve);

 private:
  /// Sums over the particles of one piece in one range.
  struct Sums {
    Vec3 left = Vec3::Zero();
    double moved = 0.0, outside = 0.0;
  };

  std::vector<std::int32_t> piece_;  // of each particle
  std::size_t count_ = 0;
  std::vector<Sums> sums_;  // scratch: of each piece, range by range
};

}  // namespace selvedge::detail
