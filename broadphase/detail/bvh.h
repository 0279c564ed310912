// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/traverse.h>

namespace selvedge::detail {

/// Culls self-pairs on top of a tree; used once per call of find_self_pairs.
class SelfCull {
 public:
  virtual ~SelfCull() = default;

  /// Marks the subtrees that need no test against themselves; all marks of `skip` are 0 on entry.
  /// The tree is fitted to `surface`. Its shape has changed since the last call if it is another
  /// tree or its version has changed.
  virtual void mark(const BoundingVolumeTree& tree, const SurfaceView& surface, SelfSkip& skip) = 0;
  virtual BroadPhaseTraits traits() const = 0;
  /// Memory kept between calls, in bytes.
  virtual std::size_t bytes() const { return 0; }
};

/// The tree of axis-aligned boxes with a cull of self-pairs: reports the pairs of make_bvh_aabb
/// without those that the cull lets it skip. The time of the cull counts as query time.
std::unique_ptr<BroadPhase> make_bvh_aabb(const BvhConfig& config, std::unique_ptr<SelfCull> cull);

}  // namespace selvedge::detail
