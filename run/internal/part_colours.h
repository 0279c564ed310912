// SPDX-License-Identifier: MIT
//
// The colours that pieces of cloth and bodies have in pictures and in files for other programs.
#pragma once

#include <selvedge/core/base/types.h>

#include <array>
#include <cstddef>

namespace selvedge {

struct Dye {
  Vec3 front, back;  ///< linear RGB in [0,1]
};

/// Of the pieces of cloth in order, repeated if there are more pieces.
inline const Dye& piece_dye(std::size_t piece) {
  static const std::array<Dye, 6> list = {{
      {{0.50, 0.085, 0.065}, {0.72, 0.50, 0.24}},  // madder, straw
      {{0.045, 0.21, 0.27}, {0.40, 0.58, 0.56}},   // petrol, celadon
      {{0.62, 0.34, 0.050}, {0.70, 0.58, 0.40}},   // ochre, sand
      {{0.11, 0.14, 0.36}, {0.45, 0.50, 0.66}},    // indigo, lavender
      {{0.17, 0.26, 0.090}, {0.52, 0.57, 0.38}},   // moss, sage
      {{0.28, 0.060, 0.17}, {0.66, 0.43, 0.50}},   // plum, rose
  }};
  return list[piece % list.size()];
}

inline Vec3 body_colour() { return {0.47, 0.475, 0.485}; }

/// Edges of bodies that are sharper than this stay sharp, degrees.
inline constexpr double kBodyCrease = 40.0;

}  // namespace selvedge
