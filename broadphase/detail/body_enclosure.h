// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/box_pairs.h>
#include <selvedge/broadphase/detail/frustum.h>
#include <selvedge/broadphase/detail/packed_boxes.h>
#include <selvedge/broadphase/minimal_enclosure.h>

#include <array>
#include <cstdint>
#include <vector>

namespace selvedge::detail {

/// A range [begin, end).
struct IndexRange {
  std::uint32_t begin = 0, end = 0;
};

/// One limb: 2l - 1 consecutive slabs, each with its column or cone.
struct Limb {
  DoubleBox box{};  ///< around all boxes of the limb
  Vec3 origin = Vec3::Zero(), axis = Vec3::UnitX();
  double far = 0.0;  ///< bound of the distance of its boxes from the origin
  std::uint32_t first_slab = 0, slabs = 0;
  /// Largest s up to a slab, and smallest s from it on. They make the slabs that a box may meet
  /// contiguous.
  std::vector<double> highest, lowest;

  /// The slabs that may contain anything with s within a box; relative to first_slab.
  IndexRange slabs_near(const CenteredBox& box) const;
};

/// Boxes of one kind of primitives of the body, by slabs, and within each slab by small groups of
/// neighbouring boxes.
struct SlabBoxes {
  /// Number of boxes per group, which one test of the group's own box may save.
  static constexpr std::uint32_t kGroup = 16;

  std::vector<std::int32_t> order;  ///< indices of the boxes, by slab and group
  std::vector<std::uint32_t> slab_begin, slab_group_begin;  ///< of each slab, and the end
  std::vector<PackedBox> packed;                            ///< in that order
  std::vector<PackedBox> groups;  ///< around each group; its id is the start of the group

  std::uint32_t group_end(std::uint32_t group, std::uint32_t slab) const {
    return std::min(static_cast<std::uint32_t>(groups[group].id) + kGroup, slab_begin[slab + 1]);
  }
  std::size_t bytes() const;
};

/// Indices by slab.
struct SlabIndices {
  std::vector<std::int32_t> order;
  std::vector<std::uint32_t> slab_begin;
};

/// The enclosure of a body's swept and inflated boxes. Each point, edge and triangle belongs to one
/// slab of one limb, and its whole box is inside the column or cone of that slab. The choice of the
/// slab affects only how tight the enclosure is.
class BodyEnclosure {
 public:
  /// Cuts the body into limbs and slabs from scratch.
  void cut(const SurfaceView& surface, const SurfaceBoxes& boxes,
           const MinimalEnclosureConfig& config);
  /// Keeps limbs and slabs, and fits columns and cones to these boxes, which must be those of a
  /// surface with the same edges and triangles.
  void refit(const SurfaceBoxes& boxes);
  /// Whether the last cut was of a surface with these edges and triangles.
  bool has_topology_of(const SurfaceView& surface) const;

  /// Total volume of columns and cones relative to that just after the cut; infinity instead of
  /// NaN.
  double volume_ratio() const;
  const DoubleBox& box() const { return box_; }  ///< around all limbs
  const std::vector<Limb>& limbs() const { return limbs_; }
  const std::vector<Frustum>& frusta() const { return frusta_; }  ///< one per slab
  const SlabBoxes& points() const { return kinds_[0]; }
  const SlabBoxes& edges() const { return kinds_[1]; }
  const SlabBoxes& triangles() const { return kinds_[2]; }
  const FloatMap& map() const { return map_; }  ///< the map of all packed boxes
  Enclosure enclosure() const;
  std::size_t bytes() const;

 private:
  using Lists = std::array<const std::vector<DoubleBox>*, 3>;

  void lay_out_limbs(const SurfaceView& surface);
  void sort_boxes(const SurfaceView& surface, const Lists& lists);
  std::vector<std::uint32_t> slabs_of(const SurfaceView& surface,
                                      const std::vector<DoubleBox>& boxes, int kind) const;
  void sort_kind(const std::vector<DoubleBox>& boxes, const std::vector<std::uint32_t>& slab_of,
                 SlabBoxes& out) const;
  void note_loose(const std::vector<std::int32_t>& owner, int kind);
  void group_slab(const std::vector<DoubleBox>& boxes, std::uint32_t slab, SlabBoxes& out) const;
  void lay_out_groups(SlabBoxes& kind) const;
  void fit(const Lists& lists);
  void place_limb(const Lists& lists, Limb& limb) const;
  void turn_axis(const std::vector<DoubleBox>& points, Limb& limb) const;
  Frustum column_around(const Lists& lists, std::uint32_t slab) const;
  void tilt_cone(const Lists& lists, std::uint32_t slab, Frustum& f) const;
  void fit_radius(const Lists& lists, std::uint32_t slab, Frustum& f) const;
  void note_slabs(Limb& limb) const;
  bool is_empty(std::uint32_t slab) const;
  const Limb& limb_of(std::uint32_t slab) const { return limbs_[limb_of_slab_[slab]]; }
  void pack(const Lists& lists);
  double volume() const;
  /// Calls visit(box) for every box of the slabs [begin, end) that is not contained in another.
  template <class Visit>
  void each_box(const Lists& lists, std::uint32_t begin, std::uint32_t end, Visit visit) const;

  MinimalEnclosureConfig config_;
  std::vector<std::int32_t> limb_of_vertex_;
  std::vector<Limb> limbs_;
  std::vector<std::uint32_t> limb_of_slab_;
  DoubleBox box_{};
  std::vector<Frustum> frusta_;
  std::vector<std::pair<double, double>> range_;  ///< of s along each limb, at the time of the cut
  std::array<SlabBoxes, 3> kinds_;
  std::array<SlabIndices, 2> loose_;  ///< points and edges without a triangle
  std::size_t vertex_count_ = 0;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
  FloatMap map_;
  double cut_volume_ = 0.0;
};

}  // namespace selvedge::detail
