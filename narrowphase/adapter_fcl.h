// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge {

/// Adds `fcl_vertex_face_edge_edge`: the vertex-face and edge-edge tests over straight paths of the
/// Flexible Collision Library, which solve a coplanarity cubic by interval Newton iteration. For
/// comparison only, never a default: it misses motion that stays coplanar, degenerate primitives
/// and parallel edges, and its inside tests have absolute tolerances. The adapter makes these
/// relative by moving and scaling each pair to primitives of size one; unscaled, FCL misses 43 % of
/// vertex-face and 99 % of edge-edge collisions between primitives of 1 cm in metres. Has no
/// tolerance option and no minimum separation. (FCL's own continuousCollide ignores the motion of
/// vertices.)
void register_fcl(NarrowPhaseRegistry& registry);

}  // namespace selvedge
