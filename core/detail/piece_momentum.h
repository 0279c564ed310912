// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Whether a solve has left the momentum of any piece of cloth wrong. Conjugate gradients measure
/// what is left in the norm of their preconditioner, in which a force that would shift a whole
/// piece counts next to nothing if stiff contacts couple the piece to others: four sheets that land
/// on each other lose or keep metres a second so. The sum over each piece shows it.
class PieceMomentum {
 public:
  PieceMomentum() = default;
  /// Pieces are what `links` connect of n particles.
  PieceMomentum(std::span<const Edge> links, std::size_t n);

  /// A solve as it stands: what is left of its equations, kg·m/s per particle, zero at held ones.
  struct Solve {
    std::span<const Vec3> residual, v, v_old;  ///< kg·m/s, m/s, m/s
    std::span<const double> mass;              ///< kg
    std::span<const Vec3> outside;             ///< kg·m/s in each coordinate, of outer forces
    std::span<const char> free;                ///< 0: held
  };
  /// True if what is left over all of each piece is a small share of the momentum that the step
  /// moves about in it, or of what outer forces give it.
  bool kept(const Solve& solve);

 private:
  std::vector<std::int32_t> piece_;  // of each particle
  std::vector<Vec3> left_;           // of each piece
  std::vector<double> moved_, outside_;
};

}  // namespace selvedge::detail
