// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <cstdint>
#include <string>
#include <vector>

namespace selvedge {

/// Friction and rest gap of every pair of surfaces of a scene, resolved once from its materials,
/// its bodies and `contact.pairs`. Surface indices count the pieces first, in the order of
/// Scene::cloths, then the bodies.
class ContactPairs {
 public:
  /// Throws std::invalid_argument that names the entry of `contact.pairs` if a name is unknown or
  /// ambiguous, or if a pair has no cloth.
  explicit ContactPairs(const Scene& scene);

  /// Coulomb coefficient between a piece and a surface, >= 0.
  double friction(std::int32_t piece, std::int32_t surface) const {
    return table_[index(piece, surface)].friction;
  }
  /// Distance that contacts between a piece and a surface keep at rest, m, > 0.
  double rest_gap(std::int32_t piece, std::int32_t surface) const {
    return table_[index(piece, surface)].rest_gap;
  }
  /// The largest rest gap of any pair, m. A search for candidates that reaches this far misses no
  /// pair.
  double largest_rest_gap() const { return largest_; }

 private:
  struct Entry {
    double friction, rest_gap;
  };
  std::size_t index(std::int32_t piece, std::int32_t surface) const {
    return static_cast<std::size_t>(piece) * surfaces_ + static_cast<std::size_t>(surface);
  }

  std::size_t surfaces_;
  double largest_;
  std::vector<Entry> table_;  // (piece, surface), symmetric among the pieces
};

/// The fault of an entry of `contact.pairs`: its key ("" for the entry itself) and a sentence
/// without the place. An empty sentence means no fault.
struct PairFault {
  std::string key, sentence;
};
PairFault fault_of(const PairSpec& pair, const Scene& scene);

}  // namespace selvedge
