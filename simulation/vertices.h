// SPDX-License-Identifier: MIT
//
// Names and flags of vertices, for reports.
#pragma once

#include <selvedge/response/contact_point.h>
#include <selvedge/scene/build.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Names the vertices of the joint index space of ContactPoint (cloth particles first, then the
/// vertices of all bodies) by piece or body and by their index there.
class VertexNames {
 public:
  VertexNames() = default;
  VertexNames(const Scene& scene, const BuiltScene& built);

  bool is_cloth(std::int32_t vertex) const { return vertex < owner_begin_[pieces_]; }
  /// Index of the owner: pieces of cloth first, then bodies.
  std::size_t owner_index(std::int32_t vertex) const;
  /// `cloth "skirt"`, `body "table"`; an owner without a name goes by its index: `cloth 0`.
  const std::string& owner_name(std::size_t owner) const { return owner_[owner]; }
  const std::string& owner(std::int32_t vertex) const { return owner_[owner_index(vertex)]; }
  /// The first vertex of an owner.
  std::int32_t first(std::size_t owner) const { return owner_begin_[owner]; }
  std::size_t owners() const { return owner_.size(); }
  std::size_t pieces() const { return pieces_; }
  /// The index of a vertex within its owner, as in the files of that mesh.
  std::int32_t local(std::int32_t vertex) const;
  /// `vertex 24 of cloth "skirt"`.
  std::string vertex(std::int32_t vertex) const;
  /// `vertex 24 of cloth "skirt" and triangle (3, 7, 9) of body "table"`.
  std::string pair(const ContactPoint& contact) const;

 private:
  std::string primitive(const std::int32_t* vertices, int count) const;

  std::vector<std::string> owner_;
  std::vector<std::int32_t> owner_begin_;  // first vertex of each owner, plus the total
  std::size_t pieces_ = 0;
};

/// Guarantees that do not hold at a vertex, as bits of its flag. 0: all of docs/guarantees.md hold.
enum VertexFlag : std::uint8_t {
  kFlagTangled = 1,     ///< in a tangle of the start: may cross the other side of that tangle
  kFlagPinched = 2,     ///< squeezed by bodies from two sides: nearer to both than its rest gap
  kFlagOverStrain = 4,  ///< at a spring that exceeds its strain limit
  kFlagGivenUp = 8,     ///< in a tangle that could not be undone; set together with kFlagTangled
};
inline constexpr int kVertexFlags = 4;
/// "tangled", "pinched", "over_strain", "given_up": bit 0 to 3.
const char* flag_name(int bit);

/// Number of vertices with each flag, by bit.
struct FlagCounts {
  std::array<int, kVertexFlags> end{}, worst{};  ///< in the last frame; the most in one frame
};
/// Adds the flags of another frame to `counts`.
void count_flags(std::span<const std::uint8_t> flags, FlagCounts& counts);

}  // namespace selvedge
