// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/contacts/detail/scene_motion.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Pairs of surfaces that the scene excludes from detection, because it states that they cannot
/// collide ("collide": false of "contact.pairs").
///
/// [Ji2006] F. Ji, R. Li, Y. Qiu, "Three-dimensional garment simulation based on a mass-spring
/// system", Textile Research Journal 2006 (survey section 6.1.3), excludes parts of the fabric that
/// cannot collide, and triangles that share a vertex. The second holds for every search. The first
/// is only as true as the scene: where excluded surfaces cross, the check of the frame reports it.
class ExcludedSurfaces {
 public:
  ExcludedSurfaces(const Scene& scene, const BuiltScene& built, const SceneMotion& motion);

  bool empty() const { return !any_; }
  /// Whether the bodies of the scene, of which there are some, are excluded for all cloth.
  bool all_bodies() const { return all_bodies_; }
  /// Removes the pairs of excluded surfaces from those of the cloth with itself, or with the
  /// bodies. A triangle of merged pieces is of each piece to which one of its vertices belongs; it
  /// is removed only if all of them are excluded.
  void drop(CandidatePairs& pairs, bool self) const;

 private:
  bool excluded(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                std::int32_t b_offset) const;

  const SceneMotion& motion_;
  ContactPairs pairs_;
  std::vector<std::int32_t> surface_;  // of each joint vertex, as ContactPairs counts them
  bool any_ = false, all_bodies_ = false;
};

/// Whether any two pieces of cloth, or parts of one piece, can collide in a scene.
bool searches_self(const Scene& scene);

}  // namespace selvedge::detail
