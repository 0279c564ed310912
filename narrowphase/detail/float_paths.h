// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/pair_screen.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Candidate pairs of two surfaces. Views.
struct SurfacePairs {
  const SurfaceView &a, &b;
  const CandidatePairs& pairs;
};

/// Consecutive pairs of one kind.
struct PairBlock {
  std::array<PairVertices, kScreenBlock> pairs;
  PathBlock paths;  ///< padded with copies of the last pair
  std::size_t size = 0;

  bool edges() const { return pairs[0].kind == ContactKind::edge_edge; }
};

/// The paths of the vertices of two surfaces in single precision. A cheap test rules out most pairs
/// before the test in double precision. Only what it proves is used, so results do not depend on
/// it. Let M be the largest coordinate. A float differs from its double by at most M 2^-24, a
/// difference or sum of two floats from the exact one by at most M 2^-22, and a difference of two
/// such sums by at most M 2^-20: that is the slack.
class FloatPaths {
 public:
  /// Throws as require_finite. `a` and `b` may be one object.
  FloatPaths(const SurfaceView& a, const SurfaceView& b);

  /// Pairs of these surfaces from `begin` on, at least one, and none from `end` on.
  void take_block(const SurfacePairs& in, std::size_t begin, std::size_t end,
                  PairBlock& block) const;
  /// A mask of the pairs that share no point during the step.
  std::uint32_t never_meet(const PairBlock& block) const {
    return screen_.never_meet(block.paths, block.edges(), slack_);
  }
  /// Limits of a screen: pairs are far if their distance at t = 0 is more than `reach_at_start`, or
  /// more than `reach` and the largest relative displacement of two vertices together; in metres.
  ScreenLimits limits(double reach, double reach_at_start) const;
  /// A mask of the pairs that are far, and the clearance of each; see Screen::compare.
  std::uint32_t compare(const PairBlock& block, const ScreenLimits& limits,
                        std::span<float, kScreenBlock> room) const {
    return screen_.compare(block.paths, block.edges(), limits, room);
  }

 private:
  struct alignas(32) Path {
    std::array<float, 8> numbers;  ///< x, y, z, 0 at t = 0, and the same at t = 1
  };

  static double largest_coordinate(const SurfaceView& view, const char* name);
  static std::unique_ptr<Path[]> convert(const SurfaceView& view, bool proves);

  const Screen& screen_ = screens().back();
  std::unique_ptr<Path[]> own_a_, own_b_;
  std::array<const Path*, 2> paths_;  ///< of a and b
  float slack_ = 0.0F;                ///< m, of the difference of two coordinates
};

}  // namespace selvedge::detail
