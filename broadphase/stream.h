// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/parallel.h>

namespace selvedge {

/// Receives one piece of a set of pairs; the list is valid only during the call.
using PairSink = FunctionRef<void(const CandidatePairs& piece)>;

/// Totals of a stream.
struct StreamedPairs {
  std::uint64_t pairs = 0;   ///< in all pieces; may exceed any index type
  std::uint64_t pieces = 0;  ///< calls of the sink
  std::uint64_t calls = 0;  ///< calls of the detector, including those that ended in BudgetExceeded
};

/// Delivers the pairs of two surfaces in pieces that each stay within the budget `piece`, each pair
/// once, with the indices of `a` and `b`. For pair sets that exceed the memory or any index type.
///
/// Works with any detector. It first tries the whole surfaces. If that exceeds the budget, it
/// separates points against triangles from edges against edges, and halves the longer index range
/// until the detector stays within the budget. Each piece is sorted; the order of the pieces
/// depends only on the budget and the surfaces. The union is the set that find_pairs would give,
/// with one exception: a detector whose PairSet is `culled` sees only a part of the surface in each
/// piece, and may keep pairs that it would otherwise have culled, though only pairs whose boxes
/// overlap. Kept trees do not help pieces, so a set in k pieces costs more than k sets that fit.
///
/// Throws the exceptions of the detector, and BudgetExceeded if a single pair does not fit, or if
/// the set is too large for a detector that supports only closed bodies, because a part of a body
/// is not closed. Restores the detector's own budget afterwards.
StreamedPairs stream_pairs(BroadPhase& detector, const SurfaceView& a, const SurfaceView& b,
                           const PairBudget& piece, PairSink sink);
/// The same for the pairs of one surface with itself.
StreamedPairs stream_self_pairs(BroadPhase& detector, const SurfaceView& a, const PairBudget& piece,
                                PairSink sink);

}  // namespace selvedge
