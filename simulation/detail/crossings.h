// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/detection/find.h>
#include <selvedge/simulation/detail/search_context.h>

#include <string>
#include <utility>
#include <vector>

namespace selvedge {

/// Pairs of triangles that cross in a state: they share no vertex but have a common point.
struct Crossings {
  using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;
  Pairs self;  ///< triangles of the cloth
  Pairs body;  ///< triangle of the cloth, triangle of the bodies

  /// The number of pairs and the first one; with the bodies, or with itself if no pair crosses a
  /// body. Requires at least one pair.
  std::string sentence() const;
};

/// Throws std::invalid_argument with count, first pair and remedy if the cloth crosses a body or,
/// where `self` asks for it, itself.
void refuse_crossings(const Crossings& found, bool self);

/// Finds the crossings of the state at the start of the context's motion, by the exact narrow phase
/// whatever the scene names.
class CrossingSearch {
 public:
  /// `context` must outlive it.
  explicit CrossingSearch(const SearchContext& context);

  /// Pairs of triangles that cross, each list sorted. Proofs may make a search unnecessary.
  Crossings find();
  /// The same as edges that pass through triangles of the joint surface, sorted. Leaves out those
  /// of the cloth with itself if the scene does not test them.
  std::vector<EdgeCrossing> find_edges();

 private:
  void find_with_bodies(Crossings::Pairs& pairs);
  void find_with_self(Crossings::Pairs& pairs);
  SurfaceView bodies() const;

  const SearchContext& context_;
  EdgeTriangleTest test_;
  std::vector<EdgeTrianglePair> found_;
};

}  // namespace selvedge
