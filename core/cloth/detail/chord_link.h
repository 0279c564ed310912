// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/force.h>

#include <cstdint>
#include <memory>
#include <span>

namespace selvedge::detail {

/// A link between two particles two cells apart, which pushes with the force of a bending moment:
/// the two cells turn by θ = κ d, their ends are r = 2d cos(θ/2) apart, and the moment M(κ) of the
/// strip exerts M w/(d sin(θ/2)) along the chord [Zhang2012]. Slack under tension.
struct ChordLink {
  std::int32_t a, b;
  double spacing;           ///< m, d: the length of a cell, > 0
  double width;             ///< m, w: of the strip that the link represents, > 0
  double rigidity;          ///< N·m, M'(0), > 0
  double onset;             ///< N/m, stiffness before the strip bends; see make_chord_force
  double damping = 0.0;     ///< s, damping force per stiffness and rate of length change, >= 0
  std::int32_t curve = -1;  ///< the shape of M(κ), among the curves; -1: linear

  bool remap(const auto& to) {
    if (curve >= 0) to.template element<SpringCurve>(curve);
    return to.vertex(a) && to.vertex(b);
  }
};

/// Links that push with the force of the bending moment at the distance of their ends [Zhang2012],
/// and are slack under tension. A straight strip bears 2Bw/d² before it bends; up to there a link
/// has the stiffness `onset`.
std::unique_ptr<Force> make_chord_force(std::span<const ChordLink> links,
                                        std::span<const SpringCurve> curves, std::size_t particles);

}  // namespace selvedge::detail
