// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>
#include <selvedge/response/contact_point.h>
#include <selvedge/scene/excluded_pairs.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge {

/// What is not guaranteed of a vertex; bits of its flag. 0: all that docs/guarantees.md says.
enum VertexFlag : std::uint8_t {
  kFlagTangled = 1,     ///< in a tangle of the start: may cross the other side of that tangle
  kFlagPinched = 2,     ///< squeezed from two sides by bodies: nearer to both than it should rest
  kFlagOverStrain = 4,  ///< at a spring that exceeds its strain limit
  kFlagGivenUp = 8,     ///< of a tangle that no way leads out of; with kFlagTangled
};
inline constexpr int kVertexFlags = 4;
/// "tangled", "pinched", "over_strain", "given_up": bit 0 to 3.
const char* flag_name(int bit);

/// Vertices with each flag, by bit.
struct FlagCounts {
  std::array<int, kVertexFlags> end{}, worst{};  ///< at the last frame; most at one frame
};
/// Counts the flags of another frame.
void count_flags(std::span<const std::uint8_t> flags, FlagCounts& counts);

/// What the flags are taken from; views.
struct FlagSources {
  const ClothMesh& cloth;
  std::span<const Vec3> x;                 ///< cloth, m
  std::span<const ContactPoint> contacts;  ///< of the last step, at its start
  const std::vector<Tangle>& tangles;
  bool given_up = false;
  double strain_tolerance = 0.0;  ///< excess that counts as within the limit
};

/// One for each cloth vertex.
std::vector<std::uint8_t> vertex_flags(const FlagSources& sources);

}  // namespace selvedge
