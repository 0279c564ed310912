// SPDX-License-Identifier: MIT
#include <selvedge/core/detail/piece_momentum.h>

#include <algorithm>
#include <numeric>

namespace selvedge::detail {
namespace {

// Fraction of the momentum exchanged in a step that a piece may lose. Friction between sheets that
// land on each other then follows Coulomb's law to about 5 %.
constexpr double kOfMoved = 0.02;
// The same for the momentum from external forces. A smaller value would slow every drape for an
// error that is visible only in impacts.
constexpr double kOfOutside = 1.0;

}  // namespace

PieceMomentum::PieceMomentum(std::span<const Edge> links, std::size_t n) : piece_(n) {
  std::iota(piece_.begin(), piece_.end(), 0);
  const auto root = [&](std::int32_t i) {
    while (piece_[i] != i) i = piece_[i] = piece_[piece_[i]];
    return i;
  };
  for (const Edge& link : links) {
    const std::int32_t a = root(link[0]), b = root(link[1]);
    piece_[std::max(a, b)] = std::min(a, b);
  }
  // A root precedes all other particles of its piece.
  std::int32_t pieces = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto self = static_cast<std::int32_t>(i);
    piece_[i] = piece_[i] == self ? pieces++ : piece_[piece_[i]];
  }
  left_.resize(static_cast<std::size_t>(pieces));
  moved_.resize(left_.size());
  outside_.resize(left_.size());
}

bool PieceMomentum::kept(const Solve& s) {
  std::fill(left_.begin(), left_.end(), Vec3::Zero());
  std::fill(moved_.begin(), moved_.end(), 0.0);
  std::fill(outside_.begin(), outside_.end(), 0.0);
  for (std::size_t i = 0; i < piece_.size(); ++i) {
    if (!s.free[i]) continue;
    const auto k = static_cast<std::size_t>(piece_[i]);
    left_[k] += s.residual[i];
    moved_[k] += s.mass[i] * (s.v[i] - s.v_old[i]).norm();
    outside_[k] += s.outside[i].norm();
  }
  for (std::size_t k = 0; k < left_.size(); ++k)
    if (left_[k].norm() > std::max(kOfMoved * moved_[k], kOfOutside * outside_[k])) return false;
  return true;
}

}  // namespace selvedge::detail
