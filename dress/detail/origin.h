// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/dress/internal/landmarks.h>
#include <selvedge/garment/panel_mesh.h>

#include <string>

namespace selvedge::detail {

/// Where a pattern stands that is drawn for a body with another origin.
struct OriginFit {
  Vec3 by = Vec3::Zero();    ///< m, that moves the pattern as a whole to its place on the body
  double distance = 0.0;     ///< m, mean of the panels from the body, as they stand
  double distance_by = 0.0;  ///< m, the same once they are moved
  std::string origin;        ///< of the body for which the pattern is drawn; empty: unknown
  double gap = 0.0;          ///< m, between the boxes of pattern and body; 0: they meet

  bool is_beside() const;
  /// How the pattern stands, as a sentence.
  std::string fault() const;
};

/// Tries the two origins that bodies have, at the pelvis and between the feet.
OriginFit fit_origin(const GarmentMesh& garment, const TriangleMesh& body);

/// How a pattern stands on the body of a person, compared with where `arrange` places its panels.
struct PatternStand {
  SewingPattern arranged;
  double height = 0.0;  ///< m, up to the place of its trunk, or else of its skirt or legs
  /// m, from a sleeve to where it belongs, the farthest, across the view from the front and after
  /// the trunk has come to its place; large for a pattern for arms at another angle
  double sleeves = 0.0;
  bool is_upside_down = false;  ///< trunk, skirt and legs stand with their tops at the bottom
};
PatternStand stand_of(const SewingPattern& pattern, const TriangleMesh& body,
                      const BodyLandmarks& landmarks);

}  // namespace selvedge::detail
