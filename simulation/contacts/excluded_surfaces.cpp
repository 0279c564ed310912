// SPDX-License-Identifier: MIT
#include <selvedge/simulation/contacts/detail/excluded_surfaces.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

/// Whether some piece can collide with one of the surfaces [begin, end).
bool any_collides(const Scene& scene, const ContactPairs& pairs, std::size_t begin,
                  std::size_t end) {
  for (std::size_t p = 0; p < scene.cloths.size(); ++p)
    for (std::size_t s = begin; s < end; ++s)
      if (pairs.collide(static_cast<std::int32_t>(p), static_cast<std::int32_t>(s))) return true;
  return false;
}

}  // namespace

bool searches_self(const Scene& scene) {
  return scene.contact.self && any_collides(scene, ContactPairs(scene), 0, scene.cloths.size());
}

ExcludedSurfaces::ExcludedSurfaces(const Scene& scene, const BuiltScene& built,
                                   const SceneMotion& motion)
    : motion_(motion), pairs_(scene), surface_(motion.particles(), 0) {
  const auto pieces = static_cast<std::int32_t>(scene.cloths.size());
  any_ = !pairs_.collide_all();
  all_bodies_ =
      any_ && !built.bodies.empty() &&
      !any_collides(scene, pairs_, scene.cloths.size(), scene.cloths.size() + scene.bodies.size());
  for (std::int32_t p = 0; p < pieces; ++p)
    for (std::int32_t i = built.piece_begin[p]; i < built.piece_begin[p + 1]; ++i) surface_[i] = p;
  for (std::size_t b = 0; b < built.bodies.size(); ++b)
    surface_.resize(motion.particles() + static_cast<std::size_t>(motion.body_begin()[b + 1]),
                    pieces + static_cast<std::int32_t>(b));
}

bool ExcludedSurfaces::excluded(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                                std::int32_t b_offset) const {
  return std::all_of(a.begin(), a.end(), [&](std::int32_t i) {
    return std::all_of(b.begin(), b.end(), [&](std::int32_t j) {
      return !pairs_.collide(surface_[i], surface_[j + b_offset]);
    });
  });
}

// Pieces come before bodies, as ContactPairs::collide needs it.
void ExcludedSurfaces::drop(CandidatePairs& pairs, bool self) const {
  if (empty()) return;
  const auto first = self ? 0 : static_cast<std::int32_t>(motion_.particles());
  const auto& edges = self ? motion_.cloth_edges() : motion_.body_edges();
  const auto& triangles = self ? motion_.cloth_triangles() : motion_.body_triangles();
  std::erase_if(pairs.point_triangle, [&](const PointTrianglePair& p) {
    return excluded({&p.point, 1}, triangles[p.triangle], first);
  });
  std::erase_if(pairs.triangle_point, [&](const PointTrianglePair& p) {
    return excluded(motion_.cloth_triangles()[p.triangle], {&p.point, 1}, first);
  });
  std::erase_if(pairs.edge_edge, [&](const EdgeEdgePair& p) {
    return excluded(motion_.cloth_edges()[p.edge_a], edges[p.edge_b], first);
  });
}

}  // namespace selvedge::detail
