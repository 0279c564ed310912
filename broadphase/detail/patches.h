// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/bounding_volume_tree.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The triangles below each node and leaf of a tree as pieces of surface, with the contour of each
/// piece. Depends only on the topology and the shape of the tree.
class Patches {
 public:
  /// The triangles in an order in which those below any node are contiguous.
  std::span<const std::int32_t> order() const { return order_; }

  struct Patch {
    std::uint32_t begin = 0, end = 0;                  ///< in order()
    std::uint32_t contour_begin = 0, contour_end = 0;  ///< vertices of the contour, in its sense
    /// True if the triangles are connected by edges and consistently oriented, two meet at each
    /// inner edge, one contour visits no vertex twice, and every primitive below the node belongs
    /// to a triangle.
    bool is_disc_like = false;
  };
  const Patch& of_node(std::int32_t node) const { return nodes_[node]; }
  const Patch& of_leaf(std::int32_t leaf) const { return leaves_[leaf]; }
  /// `child` as in TreeNode: a node, or the complement of a leaf.
  const Patch& of(std::int32_t child) const { return child < 0 ? leaves_[~child] : nodes_[child]; }
  std::span<const std::int32_t> contour(const Patch& patch) const {
    return std::span(contours_).subspan(patch.contour_begin,
                                        patch.contour_end - patch.contour_begin);
  }

  void build(const BoundingVolumeTree& tree, std::span<const Triangle> triangles,
             std::size_t vertices);
  std::size_t bytes() const;

 private:
  void number_triangles(const BoundingVolumeTree& tree, std::int32_t child);
  void find_neighbours(std::span<const Triangle> triangles);
  void trace(Patch& patch, std::span<const Triangle> triangles);
  bool is_connected(const Patch& patch);

  std::vector<std::int32_t> order_;  ///< triangle at each place
  std::vector<std::int32_t> place_;  ///< of each triangle
  /// For each side of the triangle at each place: the place of the triangle across it; -1 if there
  /// is none or it is ambiguous.
  std::vector<std::array<std::int32_t, 3>> beyond_;
  std::vector<std::uint8_t> faulty_;  ///< by place: more than two triangles meet, or two are
                                      ///< inconsistently oriented
  std::vector<Patch> nodes_, leaves_;
  std::vector<std::int32_t> contours_;
  std::vector<std::int32_t> next_;     ///< scratch, by vertex: the next one along a contour, or -1
  std::vector<std::int32_t> stack_;    ///< scratch
  std::vector<std::uint8_t> reached_;  ///< scratch, by place
};

}  // namespace selvedge::detail
