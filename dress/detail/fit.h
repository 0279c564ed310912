// SPDX-License-Identifier: MIT
//
// How a worn garment fits: girths of body and garment at the places that a tailor measures.
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/dress/detail/girth.h>
#include <selvedge/dress/dress.h>

#include <string>
#include <vector>

namespace selvedge::detail {

/// A place of a body at which a tape is laid around one part of it.
struct BodyZone {
  std::string name;  ///< neck, bust, waist, hip, left thigh ...; left is the wearer's, who faces -y
  CutPlane plane;    ///< of the tape; its point is the middle of the part
};
/// The zones of a person who stands upright (z up) with the arms away from the trunk. Those that
/// are not found are left out.
std::vector<BodyZone> body_zones(const TriangleMesh& body);

/// Fills DressResult::fit of a result that has its garment and its body.
void measure_fit(const std::vector<BodyZone>& zones, DressResult& result);

}  // namespace selvedge::detail
