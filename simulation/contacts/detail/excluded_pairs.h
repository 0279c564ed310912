// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/detection/internal/joint_surface.h>

#include <array>
#include <cstdint>
#include <vector>

namespace selvedge::detail {

/// Pairs of primitives that the collision test ignores because their sheets are being untangled:
/// one primitive lies in the first region of a tangle, the other in the second. A listed triangle
/// is in a region; an edge or a vertex is in it if all of its triangles are.
class ExcludedPairs {
 public:
  ExcludedPairs() = default;
  /// None yet.
  explicit ExcludedPairs(const JointSurface& surface);
  /// Adds those of a tangle, unless one of its sides is empty. `side`: joint triangles, sorted.
  void add(const JointSurface& surface, const std::array<std::vector<std::int32_t>, 2>& side);

  bool empty() const { return masks_.empty(); }
  bool excludes_triangles(std::int32_t a, std::int32_t b) const;
  /// Removes the excluded pairs from those of the cloth with itself, or with the bodies.
  void drop_from_self(CandidatePairs& pairs) const { drop(pairs, 0, 0, 0); }
  void drop_from_body(CandidatePairs& pairs) const {
    drop(pairs, cloth_vertices_, cloth_edges_, cloth_triangles_);
  }
  /// The triangles of one side of any tangle, as flags by joint triangle.
  std::vector<char> triangles_of_side(int side) const;

 private:
  using Mask = std::vector<std::uint8_t>;  // bit 0: in the first region, bit 1: in the second
  struct Masks {
    Mask vertex, edge, triangle;
  };
  template <class Member>
  bool excluded(Member a_kind, std::size_t a, Member b_kind, std::size_t b) const;
  /// The offsets map indices of the second surface to joint indices.
  void drop(CandidatePairs& pairs, std::size_t vertices, std::size_t edges,
            std::size_t triangles) const;

  std::size_t cloth_vertices_ = 0, cloth_edges_ = 0, cloth_triangles_ = 0;
  std::vector<Masks> masks_;  // one for each tangle
};

}  // namespace selvedge::detail
