// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

namespace selvedge {

/// Options of make_verlet_list.
struct VerletListConfig {
  /// Metres, >= 0. Larger: fewer searches, but each finds more pairs that every call then filters.
  /// Negative: chosen by measured cost; may be zero.
  double margin = -1.0;
};

/// Neighbour lists that are kept for several steps, after L. Verlet, Computer "experiments" on
/// classical fluids I: thermodynamical properties of Lennard-Jones molecules, 1967 [Verlet1967],
/// around any other detector. The inner detector searches once with the thickness increased by a
/// margin, and the pairs are kept; each call reports the kept pairs whose boxes overlap now. A new
/// search starts when a surface has left the boxes of the last search.
///
/// Reports exactly the pairs whose swept and inflated boxes overlap in the world frame, like brute
/// force; rigid motions are not exploited. Proof: the search records for every vertex v its box
/// S(v) = [min(x_t0, x_t1) - T, max(x_t0, x_t1) + T], where T is the thickness plus the margin,
/// rounded. A kept list is used only if for every vertex the box B(v) of this call, with this
/// call's thickness, lies in S(v), compared number by number without a tolerance. The box of an
/// edge or triangle is the union of its vertices' boxes, also in rounded arithmetic (see
/// swept_box.h), so it lies in the box of the search. Two boxes that overlap now therefore
/// overlapped in the search, and their pair is in the list. The list is then filtered by the boxes
/// of this call. Verlet's own criterion, twice the largest displacement below the margin, is the
/// special case of points. Here each surface, coordinate and side uses the whole margin, motion
/// along the sweep of the search costs nothing, and a surface with a static_id needs no margin.
///
/// The margin is a multiple of the distance that the fastest vertex moves per step. The mean times
/// of calls with neighbouring multiples, and without a list, are measured while the simulation
/// runs, and the best is used. These times affect only the speed, never the pairs. If no margin is
/// worthwhile, each call searches anew, and margins are attempted again every few hundred calls.
///
/// Throws std::invalid_argument unless `inner` is conservative and reports all pairs of overlapping
/// boxes (PairSet `boxes` or `contains_boxes`).
std::unique_ptr<BroadPhase> make_verlet_list(std::unique_ptr<BroadPhase> inner,
                                             const VerletListConfig& config = {});

}  // namespace selvedge
