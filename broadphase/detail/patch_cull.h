// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/bvh.h>
#include <selvedge/broadphase/detail/patches.h>

#include <cstdint>
#include <vector>

namespace selvedge::detail {

/// A cull that decides for each piece of surface below a node of the tree, from the root down,
/// whether it cannot meet itself. The pieces below one that cannot are not asked.
class PatchCull : public SelfCull {
 public:
  void mark(const BoundingVolumeTree& tree, const SurfaceView& surface, SelfSkip& skip) final;
  std::size_t bytes() const override { return patches_.bytes(); }

 protected:
  const Patches& patches() const { return patches_; }

 private:
  /// Before the patches of one call are asked.
  virtual void begin(const SurfaceView& surface) = 0;
  /// Called by several threads.
  virtual bool cannot_meet_itself(const SurfaceView& surface,
                                  const Patches::Patch& patch) const = 0;
  void descend(const BoundingVolumeTree& tree, SelfSkip& skip);

  Patches patches_;
  const BoundingVolumeTree* tree_ = nullptr;
  std::uint64_t version_ = 0;
  std::vector<std::int32_t> tested_, children_;
  std::vector<std::uint8_t> passed_;
};

}  // namespace selvedge::detail
