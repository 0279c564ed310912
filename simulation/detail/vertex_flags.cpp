// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/vertex_flags.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

// Cosine below which two pushes come from opposite sides: more than 120 degrees apart.
constexpr double kOpposite = -0.5;

void flag_tangled(const FlagSources& s, std::vector<std::uint8_t>& flags) {
  const auto triangles = static_cast<std::int32_t>(s.cloth.surface.triangles.size());
  for (const Tangle& tangle : s.tangles) {
    const int bits =
        kFlagTangled | (s.given_up ? kFlagGivenUp : 0) | (tangle.jam ? kFlagPinched : 0);
    for (const auto& side : tangle.side)
      for (const std::int32_t t : side)
        if (t < triangles)
          for (const std::int32_t v : s.cloth.surface.triangles[t])
            flags[v] |= static_cast<std::uint8_t>(bits);
  }
}

// Vertices that are held, and those with two contacts with bodies that both violate their rest gap
// and push against each other.
void flag_pinched(const FlagSources& s, std::vector<std::uint8_t>& flags) {
  for (const Pinch& pinch : s.pinches) flags[pinch.vertex] |= kFlagPinched;
  const std::size_t n = flags.size();
  std::vector<Vec3> push(n, Vec3::Zero());  // the first one on each vertex
  for (const ContactPoint& c : s.contacts) {
    const auto is_body = [&](int k) { return static_cast<std::size_t>(c.vertex[k]) >= n; };
    if (!(c.gap < c.rest_gap) || (!is_body(0) && !is_body(3))) continue;
    for (int k = 0; k < 4; ++k) {
      if (is_body(k) || c.weight[k] == 0.0) continue;
      const Vec3 direction = c.weight[k] > 0.0 ? c.normal : Vec3(-c.normal);
      Vec3& first = push[c.vertex[k]];
      if (first.isZero(0.0))
        first = direction;
      else if (first.dot(direction) < kOpposite)
        flags[c.vertex[k]] |= kFlagPinched;
    }
  }
}

void flag_over_strain(const FlagSources& s, std::vector<std::uint8_t>& flags) {
  for (std::size_t i = 0; i < s.cloth.springs.size(); ++i) {
    const Spring& spring = s.cloth.springs[i];
    const double strain = (s.x[spring.b] - s.x[spring.a]).norm() / spring.rest_length - 1.0;
    if (!(strain > s.cloth.strain_limit[i] + s.strain_tolerance)) continue;
    flags[spring.a] |= kFlagOverStrain;
    flags[spring.b] |= kFlagOverStrain;
  }
}

}  // namespace

std::vector<std::uint8_t> vertex_flags(const FlagSources& sources) {
  std::vector<std::uint8_t> flags(sources.x.size(), 0);
  flag_tangled(sources, flags);
  flag_pinched(sources, flags);
  flag_over_strain(sources, flags);
  return flags;
}

}  // namespace selvedge::detail
