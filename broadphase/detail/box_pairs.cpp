// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/box_pairs.h>
#include <selvedge/core/base/parallel.h>

namespace selvedge::detail {
namespace {

/// The boxes of edges or triangles, from those of their vertices (see swept_box).
template <class Primitive>
void unite(std::span<const Primitive> primitives, const std::vector<DoubleBox>& points,
           std::vector<DoubleBox>& out) {
  out.resize(primitives.size());
  parallel_for(primitives.size(), kBoxGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      DoubleBox box = points[primitives[i][0]];
      for (std::size_t corner = 1; corner < primitives[i].size(); ++corner)
        box = united(box, points[primitives[i][corner]]);
      out[i] = box;
    }
  });
}

std::array<std::size_t, 3> counts_of(const SurfaceView& s) {
  return {s.x_t0.size(), s.edges.size(), s.triangles.size()};
}

}  // namespace

void SurfaceBoxes::fit(const SurfaceView& surface) {
  points.resize(surface.x_t0.size());
  parallel_for(points.size(), kBoxGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      points[i] = swept_box(surface, static_cast<std::int32_t>(i));
  });
  unite(surface.edges, points, edges);
  unite(surface.triangles, points, triangles);
}

bool KeptBoxes::fit(const SurfaceView& surface, const char* name) {
  check_shape(surface, name);
  if (is_same_static(surface)) return false;
  forget();
  check_indices(surface, name);
  check_finite(surface, name);
  boxes.fit(surface);
  return true;
}

bool KeptBoxes::is_same_static(const SurfaceView& surface) const {
  return surface.static_id != 0 && surface.static_id == static_id_ &&
         surface.thickness == thickness_ && counts_of(surface) == counts_;
}

void KeptBoxes::keep(const SurfaceView& surface) {
  static_id_ = surface.static_id;
  thickness_ = surface.thickness;
  counts_ = counts_of(surface);
}

}  // namespace selvedge::detail
