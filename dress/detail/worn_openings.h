// SPDX-License-Identifier: MIT
//
// Which parts of the body come out of which opening of a worn garment.
#pragma once

#include <selvedge/dress/detail/dressing.h>
#include <selvedge/dress/dress.h>
#include <selvedge/dress/internal/landmarks.h>

#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// A part of a body, and the ways along which it may leave a garment, m: from the trunk along the
/// middle of the part, and on beyond its end. The head has one through its top, then those through
/// the face, which a hood leaves free; a leg one over its toes and one through its sole.
struct BodyEnd {
  std::string name;  ///< "head", "left arm", "right arm", "left leg", "right leg"
  std::vector<std::vector<Vec3>> ways;
};
/// The five ends, from the point of the trunk that is nearest to `middle`, m.
std::vector<BodyEnd> body_ends(const BodyLandmarks& landmarks, const Vec3& middle);

/// A closed line of a border: triangle by triangle, with the corner from which its edge leads on.
using BorderLoop = std::vector<std::pair<std::int32_t, int>>;
/// All borders of a mesh with at most two triangles at an edge. Of one without consistent
/// orientation, such as a Moebius band, some may be missing.
std::vector<BorderLoop> border_loops(std::span<const Triangle> triangles);

/// Signed number of times a way crosses the fan of triangles from the middle of a closed line.
int crossings(std::span<const Vec3> loop, std::span<const Vec3> way);

/// Fills openings, panel_turned and misworn of a result that has its garment. `start` and `worn`
/// are the garment before the sewing and now.
void measure_openings(const Garment& start, const Garment& worn, const BodyLandmarks& landmarks,
                      DressResult& result);

}  // namespace selvedge::detail
