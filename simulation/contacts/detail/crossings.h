// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/detection/find.h>
#include <selvedge/simulation/contacts/detail/search_context.h>

#include <string>
#include <utility>
#include <vector>

namespace selvedge::detail {

/// Pairs of triangles that cross or touch in a state, as TriangleMeetings defines it.
struct Crossings {
  using Pairs = std::vector<TrianglePair>;
  TriangleMeetings self;  ///< two triangles of the cloth
  TriangleMeetings body;  ///< triangle of the cloth, triangle of the bodies

  bool empty() const { return self.empty() && body.empty(); }
  /// The number of pairs and the first one: of those that cross a body, cross the cloth, touch a
  /// body, touch the cloth, the first that exist. Requires at least one pair.
  std::string sentence() const;
};

/// Throws std::invalid_argument with count, first pair and remedy if the cloth crosses or touches a
/// body or, where `self` asks for it, itself.
void refuse_crossings(const Crossings& found, bool self);

/// Throws std::invalid_argument if triangles of the cloth with a common edge lie on each other: no
/// motion can part them.
void refuse_folded(const Crossings& found, std::span<const Triangle> cloth);

/// Finds the crossings of the state at the start of the context's motion, by the exact narrow phase
/// whatever the scene names.
class CrossingSearch {
 public:
  /// `context` must outlive it.
  explicit CrossingSearch(const SearchContext& context);

  /// Pairs of triangles that cross or touch. Proofs may make a search unnecessary.
  Crossings find();
  /// The same as edges that pass through triangles of the joint surface, sorted. Leaves out those
  /// of the cloth with itself if the scene does not test them.
  std::vector<EdgeCrossing> find_edges();

 private:
  void find_with_bodies(TriangleMeetings& found);
  void find_with_self(TriangleMeetings& found);
  SurfaceView bodies() const;

  const SearchContext& context_;
  EdgeTriangleTest test_;
  TriangleTest triangles_;
  std::vector<EdgeTrianglePair> found_;
};

}  // namespace selvedge::detail
