// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/detail/piece_momentum.h>

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

// Particles per range of a sum, and up to how many pieces ranges have sums of their own.
constexpr std::size_t kMomentumGrain = 1024, kFewPieces = 16;

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
  count_ = static_cast<std::size_t>(pieces);
}

bool PieceMomentum::kept(const Solve& s) {
  const std::size_t n = piece_.size(), grain = count_ <= kFewPieces ? kMomentumGrain : n;
  sums_.assign(count_ * ((n + grain - 1) / grain), Sums{});
  parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
    Sums* const own = sums_.data() + count_ * (begin / grain);
    for (std::size_t i = begin; i < end; ++i) {
      if (!s.free[i]) continue;
      Sums& sums = own[piece_[i]];
      sums.left += s.residual[i];
      sums.moved += s.mass[i] * (s.v[i] - s.v_old[i]).norm();
      sums.outside += s.outside[i].norm();
    }
  });
  for (std::size_t k = 0; k < count_; ++k) {
    Sums all;
    for (std::size_t i = k; i < sums_.size(); i += count_) {
      all.left += sums_[i].left;
      all.moved += sums_[i].moved;
      all.outside += sums_[i].outside;
    }
    if (all.left.norm() > std::max(kOfMoved * all.moved, kOfOutside * all.outside)) return false;
  }
  return true;
}

}  // namespace selvedge::detail
