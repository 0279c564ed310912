// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

namespace selvedge {

struct VerletListConfig {
  /// Metres, >= 0: larger means fewer searches, each of which finds more pairs that every call then
  /// has to look at. Negative: the margin is chosen by measured cost, and may be none at all.
  double margin = -1.0;
};

/// Neighbour lists that live for several steps, after L. Verlet, Computer "experiments" on
/// classical fluids I: thermodynamical properties of Lennard-Jones molecules, 1967 [Verlet1967],
/// around any other detector. The pairs are sought once with the thickness increased by a margin,
/// and kept; each call reports those kept pairs whose boxes overlap now. They are sought anew when
/// a surface has left the boxes of the search.
///
/// Reports exactly the pairs whose swept and inflated boxes overlap in the world, like brute force;
/// a promise to move rigidly is not made use of. Proof: with
/// the search every vertex v left its box S(v) = [min(x_t0, x_t1) - T, max(x_t0, x_t1) + T], T the
/// thickness plus the margin, rounded. A kept list is used only if for every vertex the box B(v) of
/// this call, with this call's thickness, lies in S(v), compared number by number, without a
/// tolerance. The box of an edge or triangle is the union of its vertices' boxes, also in rounded
/// arithmetic (see swept_box.h), so it lies in the box of the search; two boxes that overlap now
/// therefore overlapped in the search, and their pair is in the list. The list is then filtered by
/// the boxes of this call. Verlet's own criterion, twice the largest displacement below the margin,
/// is the special case of points; here each surface, coordinate and side has the margin for itself,
/// motion along the sweep of the search costs nothing, and a surface with a static_id needs no
/// margin.
///
/// The margin is a multiple of what the fastest vertex moves in a step. The mean times of calls
/// with neighbouring multiples, and with none, are measured as the simulation runs, and the best is
/// gone on with; the times decide about speed alone, never about the pairs. Where none gains, each
/// call is a search of its own, and margins are tried again every few hundred calls.
///
/// `inner` must be conservative and report all pairs of overlapping boxes (PairSet `boxes` or
/// `contains_boxes`), or std::invalid_argument is thrown.
std::unique_ptr<BroadPhase> make_verlet_list(std::unique_ptr<BroadPhase> inner,
                                             const VerletListConfig& config = {});

}  // namespace selvedge
