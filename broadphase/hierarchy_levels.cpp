// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/bounding_volume_tree.h>
#include <selvedge/broadphase/detail/surface_check.h>

#include <algorithm>

namespace selvedge {
namespace {

using detail::BoundingVolumeTree;

/// Nodes by their index, leaves by its complement.
bool is_leaf(std::int32_t id) { return id < 0; }

/// The children of every node, and the leaves again.
std::vector<std::int32_t> next_level(const BoundingVolumeTree& tree,
                                     const std::vector<std::int32_t>& level) {
  std::vector<std::int32_t> next;
  for (const std::int32_t id : level) {
    if (is_leaf(id)) {
      next.push_back(id);
      continue;
    }
    for (const std::int32_t child : tree.node(id).child)
      if (child != detail::kNoChild) next.push_back(child);
  }
  return next;
}

std::vector<LevelBox> boxes_of(const BoundingVolumeTree& tree,
                               const std::vector<std::int32_t>& level, const Vec3& origin) {
  std::vector<LevelBox> boxes;
  for (const std::int32_t id : level) {
    const auto& box = is_leaf(id) ? tree.leaf(~id).box : tree.node(id).box;
    LevelBox& out = boxes.emplace_back();
    for (int k = 0; k < 3; ++k) {
      out.lo[k] = origin[k] + static_cast<double>(box.lo[k]);
      out.hi[k] = origin[k] + static_cast<double>(box.hi[k]);
    }
  }
  return boxes;
}

}  // namespace

std::vector<std::vector<LevelBox>> hierarchy_levels(const SurfaceView& surface) {
  detail::check_shape(surface, "surface");
  detail::check_indices(surface, "surface");
  const detail::Bounds bounds = detail::check_finite(surface, "surface");
  if (surface.x_t0.empty()) return {};
  const Vec3 origin = 0.5 * bounds.lo + 0.5 * bounds.hi;
  BoundingVolumeTree tree;
  BoundingVolumeTree::Scratch scratch;
  tree.set_topology(surface);
  tree.build(surface, {.origin = origin}, scratch);
  if (tree.empty()) return {};
  std::vector<std::vector<LevelBox>> levels;
  for (std::vector<std::int32_t> level = {tree.root()};; level = next_level(tree, level)) {
    levels.push_back(boxes_of(tree, level, origin));
    if (std::all_of(level.begin(), level.end(), is_leaf)) return levels;
  }
}

}  // namespace selvedge
