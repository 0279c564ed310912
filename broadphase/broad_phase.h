// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace selvedge {

/// What a detector can serve; the registry carries it.
struct BroadPhaseTraits {
  Guarantee guarantee = Guarantee::conservative;
  bool self = true;              ///< serves find_self_pairs
  bool deforming = true;         ///< serves surfaces that change shape
  bool closed_body_only = false;
  std::string source;            ///< author, title, year
};

/// Finds the pairs of primitives that could touch during the step: for a conservative one, every
/// pair whose swept boxes, each inflated by its surface's thickness, overlap (or a provably
/// sufficient part of them). Rejects surfaces with coordinates that are not finite by
/// std::invalid_argument naming the vertex.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  /// Pairs between two different surfaces. Clears `out` first.
  virtual void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) = 0;
  /// Pairs of one surface with itself. Clears `out` first.
  virtual void find_self_pairs(const SurfaceView& a, CandidatePairs& out) = 0;
  virtual BroadPhaseTraits traits() const = 0;
};

/// Names and factories of the detectors that this build has.
using BroadPhaseRegistry = std::map<std::string, std::function<std::unique_ptr<BroadPhase>()>>;

/// The detectors that need no optional library: brute_force, bvh_aabb.
BroadPhaseRegistry broad_phases();

}  // namespace selvedge
