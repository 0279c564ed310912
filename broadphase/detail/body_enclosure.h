// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/box_scan.h>
#include <selvedge/broadphase/detail/frustum.h>
#include <selvedge/broadphase/internal/minimal_enclosure.h>

#include <array>
#include <cstdint>
#include <vector>

namespace selvedge::detail {

/// Boxes of one kind of primitives of a body, by slabs.
struct SlabBoxes {
  /// Number of consecutive boxes that one test of a box around them may save.
  static constexpr std::size_t kGroup = 16;

  const std::vector<DoubleBox>* boxes = nullptr;
  std::vector<PackedBox> packed;     ///< by slab, in each in the order of the mesh
  std::vector<PackedBox> groups;     ///< around each kGroup of `packed`; the id is their number
  std::vector<std::uint32_t> begin;  ///< of each slab in `packed`, and the end

  std::size_t bytes() const {
    return (packed.capacity() + groups.capacity()) * sizeof(PackedBox) +
           begin.capacity() * sizeof(std::uint32_t);
  }
};

/// The enclosure of a body's swept and inflated boxes. The body is cut across its longest extent
/// into slabs of equal height, in turn one for a column and one for a cone. The box of each point,
/// edge and triangle is inside the column or cone of the slab that contains its middle.
class BodyEnclosure {
 public:
  /// The boxes must stay where they are until the next call.
  void fit(const SurfaceBoxes& boxes, int loops);

  const DoubleBox& box() const { return box_; }                   ///< around the body
  const std::vector<Frustum>& frusta() const { return frusta_; }  ///< one per slab
  const Vec3& origin() const { return origin_; }                  ///< of the frusta
  const Vec3& axis() const { return axis_; }                      ///< of the frusta
  const SlabBoxes& points() const { return kinds_[0]; }
  const SlabBoxes& edges() const { return kinds_[1]; }
  const SlabBoxes& triangles() const { return kinds_[2]; }
  const FloatMap& map() const { return map_; }  ///< the map of all packed boxes
  Enclosure enclosure() const;
  std::size_t bytes() const;

 private:
  void place(const std::vector<DoubleBox>& points);
  void sort(SlabBoxes& kind, std::size_t slabs) const;
  std::size_t slab_of(const DoubleBox& box, std::size_t slabs) const;
  Frustum column_around(std::size_t slab) const;
  void tilt_cone(std::size_t slab);
  void fit_radius(std::size_t slab, Frustum& f) const;
  bool is_empty(std::size_t slab) const;
  /// Calls visit(box) for every box of a slab, relative to the origin.
  template <class Visit>
  void each_box(std::size_t slab, Visit visit) const;

  DoubleBox box_{};
  Vec3 origin_ = Vec3::Zero(), axis_ = Vec3::UnitX();
  double far_ = 0.0;            ///< bound of the distance of the boxes from the origin
  double lo_ = 0.0, hi_ = 0.0;  ///< range of the middles of the points along the axis
  std::vector<Frustum> frusta_;
  std::array<SlabBoxes, 3> kinds_;
  FloatMap map_;
};

}  // namespace selvedge::detail
