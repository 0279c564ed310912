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
  bool self = true;       ///< serves find_self_pairs
  bool deforming = true;  ///< serves surfaces that change shape
  bool closed_body_only = false;
  std::string source;  ///< author, title, year
};

/// What the last call of a detector cost.
struct BroadPhaseCost {
  double build_s = 0.0;   ///< s, making trees anew
  double refit_s = 0.0;   ///< s, fitting kept trees to new positions
  double query_s = 0.0;   ///< s, finding and sorting the pairs
  std::size_t bytes = 0;  ///< memory kept between calls
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
  /// Cost of the last call; all zero for a detector that does not measure.
  virtual BroadPhaseCost last_cost() const { return {}; }
};

/// Every box against every box, in double precision: the oracle of the others. Reports exactly the
/// pairs whose swept boxes, inflated by the thickness and closed, overlap.
std::unique_ptr<BroadPhase> make_brute_force();

struct BvhConfig {
  /// A kept tree is built anew when its boxes overlap this much more than just after its build
  /// (see BoundingVolumeTree::looseness). Lower: better trees, more builds. > 1
  double rebuild_looseness = 1.3;
  /// Use vectors of eight floats where the processor has them; off: four. Same pairs either way.
  bool wide_vectors = true;
};

/// A tree of axis-aligned boxes over the swept triangles, kept between calls: a surface whose
/// triangles were seen before is refitted, one whose nonzero static_id was seen before costs
/// nothing. Reports the same pairs as brute force, bit for bit.
std::unique_ptr<BroadPhase> make_bvh_aabb(const BvhConfig& config = {});

/// Names and factories of the detectors that this build has.
using BroadPhaseRegistry = std::map<std::string, std::function<std::unique_ptr<BroadPhase>()>>;

/// The detectors that need no optional library: brute_force, bvh_aabb.
BroadPhaseRegistry broad_phases();

}  // namespace selvedge
