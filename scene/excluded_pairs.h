// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>
#include <selvedge/scene/joint_surface.h>

#include <array>
#include <cstdint>
#include <vector>

namespace selvedge {

/// A tangle that is being undone: its two sheets, as far as they may pass through one another, as
/// joint triangles, sorted; and how the search for a way out stands.
struct Tangle {
  std::array<std::vector<std::int32_t>, 2> side;
  int way = 0;    ///< which way is being tried
  int best = 0;   ///< fewest crossings so far
  int since = 0;  ///< accepted steps since then, or since the way was changed
  bool is_over() const { return side[0].empty() || side[1].empty(); }
};

/// All that is being undone.
struct Tangles {
  std::vector<Tangle> list;
  /// For each connected part of the joint surface the vertex of what the rest is brought back to.
  std::vector<std::int32_t> kept;
};

/// Pairs of primitives that the collision test leaves alone because their sheets are being
/// untangled: one in the first region of a tangle, the other in its second. A triangle is in a
/// region if it is listed, an edge or a vertex if all of its triangles are.
class ExcludedPairs {
 public:
  ExcludedPairs() = default;
  ExcludedPairs(const JointSurface& surface, std::span<const Tangle> tangles);

  bool empty() const { return masks_.empty(); }
  bool excludes_triangles(std::int32_t a, std::int32_t b) const;
  /// Takes the excluded ones out of the pairs of the cloth with itself, or with the bodies.
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
  /// Offsets lead from indices of the second surface to joint ones.
  void drop(CandidatePairs& pairs, std::size_t vertices, std::size_t edges,
            std::size_t triangles) const;

  std::size_t cloth_vertices_ = 0, cloth_edges_ = 0, cloth_triangles_ = 0;
  std::vector<Masks> masks_;  // one for each tangle
};

}  // namespace selvedge
