// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/distance.h>
#include <selvedge/simulation/contacts/detail/clearances.h>

#include <algorithm>
#include <array>

namespace selvedge::detail {
namespace {

// A slab of this share of the rest gap is as good as a wider one.
constexpr double kWideEnough = 0.05;

}  // namespace

void SceneClearances::at_start(std::span<const ContactPoint> hits, std::vector<ContactPoint>& out) {
  const auto x_t0 = context_.motion.x_t0();
  out.assign(hits.begin(), hits.end());
  for (ContactPoint& c : out) {
    std::array<Vec3, 4> x;
    for (int k = 0; k < 4; ++k) x[k] = x_t0[c.vertex[k]];
    SeparatingSlab slab = separating_slab(c.kind, x);
    // The slab of a pair that meets far from its start often lies across the motion: it would stop
    // cloth that slides by. The slab across the impact does not; it is used if it is wide enough.
    const double width = slab_width(c.kind, x, c.normal);
    if (width > kWideEnough * std::min(slab.width, contacts_.pair_rest_gap(c)))
      slab = {c.normal, width};
    c.normal = slab.normal;
    c.gap = slab.width;
    c.weight = (c.kind == ContactKind::edge_edge ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                                 : point_triangle_closest(x[0], x[1], x[2], x[3]))
                   .weight;
  }
}

void SceneClearances::all(const Vec3& shift, std::vector<ContactPoint>& out) {
  const SceneMotion& motion = context_.motion;
  out.clear();
  std::vector<Vec3> end(motion.x_t1().begin(), motion.x_t1().end());
  for (Vec3& x : end) x -= shift;  // rounds by far less than the boxes are inflated
  const auto view = [&](SurfaceView v, std::size_t first, std::size_t count) {
    v.x_t1 = std::span<const Vec3>(end).subspan(first, count);
    v.static_id = 0;
    return v;
  };
  const double half = 0.5 * context_.rest_gap;
  const SurfaceView cloth = view(motion.cloth(half), 0, motion.particles());
  const SurfaceView body = view(motion.bodies(half), motion.particles(), motion.body_vertices());
  CandidatePairs pairs;
  const auto append = [&](const SurfaceView& other, bool self) {
    candidates_.drop_excluded(pairs, self);
    find_separations(cloth, other, pairs, found_);
    for (const Contact& contact : found_) {
      out.push_back(contacts_.joint(contact, self));
      out.back().gap = contact.gap;
    }
  };
  if (!motion.body_triangles().empty()) {
    broad_.find_pairs(cloth, body, pairs);
    append(body, false);
  }
  if (!context_.self) return;
  broad_.find_self_pairs(cloth, pairs);
  append(cloth, true);
}

}  // namespace selvedge::detail
