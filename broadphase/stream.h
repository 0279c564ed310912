// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/parallel.h>

namespace selvedge {

/// Takes one piece of a set of pairs; the list is valid during the call only.
using PairSink = FunctionRef<void(const CandidatePairs& piece)>;

/// What a stream delivered.
struct StreamedPairs {
  std::uint64_t pairs = 0;   ///< of all pieces together; may be more than any index counts
  std::uint64_t pieces = 0;  ///< calls of the sink
  std::uint64_t calls = 0;   ///< calls of the detector, those that ended in BudgetExceeded included
};

/// Delivers the pairs of two surfaces in pieces that each stay within `piece`, each pair once, with
/// the indices of `a` and `b`: for sets that do not fit the memory or that no index could count.
///
/// Works with any detector: first the whole surfaces, then, if that is too much, points against
/// triangles and edges against edges apart, and of these the longer range of indices is halved
/// until the detector keeps within the budget. Each piece is sorted; their order depends on the
/// budget and the surfaces alone. The union is the set that find_pairs would give, with one
/// exception: a detector whose PairSet is `culled` sees in a piece only a part of the surface, and
/// may keep pairs that it would have culled with the whole, though never others than overlap. Kept
/// trees are of no use to pieces, which makes a set in k pieces dearer than k sets that fit.
///
/// Throws what the detector throws, and BudgetExceeded if a single pair does not fit or if the set
/// is too large for a detector that serves closed bodies only, since a part of a body is not
/// closed. The detector's own budget is as before afterwards.
StreamedPairs stream_pairs(BroadPhase& detector, const SurfaceView& a, const SurfaceView& b,
                           const PairBudget& piece, PairSink sink);
/// The same with the pairs of one surface with itself.
StreamedPairs stream_self_pairs(BroadPhase& detector, const SurfaceView& a, const PairBudget& piece,
                                PairSink sink);

}  // namespace selvedge
