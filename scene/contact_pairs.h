// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <cstdint>
#include <string>
#include <vector>

namespace selvedge {

/// Friction and rest distance of every pair of surfaces of a scene, resolved once from what its
/// materials, its bodies and `contact.pairs` say. Surfaces count the pieces first, in the order of
/// Scene::cloths, then the bodies.
class ContactPairs {
 public:
  /// Throws std::invalid_argument, naming the entry, for names that are not those of a piece, a
  /// material or a body, for names with two meanings, and for pairs without cloth.
  explicit ContactPairs(const Scene& scene);

  /// Coulomb coefficient between a piece and a surface, >= 0.
  double friction(std::int32_t piece, std::int32_t surface) const {
    return table_[index(piece, surface)].friction;
  }
  /// Distance at which a piece rests on a surface, m, > 0.
  double thickness(std::int32_t piece, std::int32_t surface) const {
    return table_[index(piece, surface)].thickness;
  }
  /// The largest of contact.thickness and all pairs' thicknesses, m: what a search for candidates
  /// has to reach, so that it misses no pair.
  double largest_thickness() const { return largest_; }

 private:
  struct Entry {
    double friction, thickness;
  };
  std::size_t index(std::int32_t piece, std::int32_t surface) const {
    return static_cast<std::size_t>(piece) * surfaces_ + static_cast<std::size_t>(surface);
  }

  std::size_t surfaces_;
  double largest_;
  std::vector<Entry> table_;  // (piece, surface), symmetric among the pieces
};

/// What is wrong with an entry of `contact.pairs`: the key at fault ("" for the entry itself) and a
/// sentence without its place; an empty sentence if nothing is.
struct PairFault {
  std::string key, sentence;
};
PairFault fault_of(const PairSpec& pair, const Scene& scene);

}  // namespace selvedge
