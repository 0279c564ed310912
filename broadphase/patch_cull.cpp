// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/patch_cull.h>
#include <selvedge/core/base/parallel.h>

namespace selvedge::detail {
namespace {

/// Number of subtrees that one task tests.
constexpr std::size_t kGrain = 16;

}  // namespace

void PatchCull::mark(const BoundingVolumeTree& tree, const SurfaceView& surface, SelfSkip& skip) {
  if (tree_ != &tree || version_ != tree.version()) {
    patches_.build(tree, surface.triangles, surface.x_t0.size());
    tree_ = &tree;
    version_ = tree.version();
  }
  begin(surface);
  tested_.assign(1, tree.root());
  while (!tested_.empty()) {
    passed_.assign(tested_.size(), 0);
    parallel_for(tested_.size(), kGrain, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i)
        passed_[i] = cannot_meet_itself(surface, patches_.of(tested_[i])) ? 1 : 0;
    });
    descend(tree, skip);
  }
}

/// Marks the subtrees that passed; the children of the others are tested next.
void PatchCull::descend(const BoundingVolumeTree& tree, SelfSkip& skip) {
  children_.clear();
  for (std::size_t i = 0; i < tested_.size(); ++i) {
    const std::int32_t child = tested_[i];
    if (passed_[i]) {
      (child < 0 ? skip.leaves[~child] : skip.nodes[child]) = 1;
    } else if (child >= 0) {
      for (const std::int32_t c : tree.node(child).child) {
        if (c == kNoChild) break;
        children_.push_back(c);
      }
    }
  }
  tested_.swap(children_);
}

}  // namespace selvedge::detail
