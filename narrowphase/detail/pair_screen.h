// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace selvedge::detail {

/// Number of pairs that a screen compares together.
inline constexpr int kScreenBlock = 8;
/// The paths of the four vertices of kScreenBlock pairs, in the order of Contact::vertex: x, y, z,
/// any number at t = 0 and the same at t = 1 (FloatPaths::path).
using PathBlock = std::array<std::array<const float*, kScreenBlock>, 4>;

/// Distances of a screen in metres. All are rounded up.
struct ScreenLimits {
  float slack = 0.0F;     ///< of the difference of two coordinates; see FloatPaths
  float at_start = 0.0F;  ///< a pair farther apart than this at t = 0 is far
  /// So is one that is farther apart there than this and its largest relative displacement.
  float with_motion = 0.0F;
  float lines = 0.0F;   ///< edges whose lines are farther apart than this at t = 0 are far
  float offset = 0.0F;  ///< error of a difference of two vertices, as a vector; infinite: lines
                        ///< prove nothing
};

/// Comparisons of the pairs of a block, either all of edges or none. Each returns a mask of pairs.
/// The results prove something, however they round.
struct Screen {
  /// Pairs that are far. room[j], the clearance, m: pair j does not collide while its vertices
  /// start where they do and their ends change by less than this: the largest change of a
  /// coordinate in one primitive, plus that in the other. Negative: unknown.
  std::uint32_t (*compare)(const PathBlock& block, bool edges, const ScreenLimits& limits,
                           std::span<float, kScreenBlock> room);
  /// Pairs that do not collide: along an axis, or along the sum or the difference of
  /// two, all vertices of one primitive lie below those of the other by more than the slack, in the
  /// same order at both ends. Differences are linear in t, so the order holds in between.
  std::uint32_t (*never_meet)(const PathBlock& block, bool edges, float slack);
};

/// The screens that the compiler built and the processor supports, narrowest first; never empty.
std::span<const Screen> screens();

}  // namespace selvedge::detail
