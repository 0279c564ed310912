// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {

/// Which pairs a conservative detector reports, measured by those whose swept boxes overlap.
enum class PairSet : std::uint8_t {
  boxes,           ///< exactly those
  contains_boxes,  ///< those and some more
  culled,  ///< perhaps not all of those, but every pair that comes nearer than the sum of the
           ///< two thicknesses (in a straight line) during the step
};

/// What a detector can serve; the registry carries it.
struct BroadPhaseTraits {
  Guarantee guarantee = Guarantee::conservative;
  PairSet pairs = PairSet::boxes;
  bool self = true;       ///< serves find_self_pairs
  bool deforming = true;  ///< serves surfaces that change shape
  bool closed_body_only = false;
  bool rigid = false;    ///< makes use of a rigid motion: keeps what it has made of such a body
  std::string source{};  ///< author, title, year
};

/// What the last call of a detector cost.
struct BroadPhaseCost {
  double build_s = 0.0;   ///< s, making trees anew
  double refit_s = 0.0;   ///< s, fitting kept trees to new positions
  double query_s = 0.0;   ///< s, finding and sorting the pairs
  std::size_t bytes = 0;  ///< memory kept between calls
};

/// What one call may find and take.
struct PairBudget {
  /// Pairs of the three lists together. So many can be counted by any index.
  std::size_t pairs = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  /// Memory of all that grows with the pairs, scratch included: by default 4 GiB less one byte,
  /// which is about 10^8 pairs. What grows with the primitives is not in it.
  std::size_t bytes = std::size_t{0xffffffffu};
};

/// Thrown by a call that would go over its budget: instead of the allocation, and if and only if
/// the set of pairs is too large, whatever the number of threads. The list is left empty and the
/// detector can be used on.
class BudgetExceeded : public std::runtime_error {
 public:
  BudgetExceeded(std::size_t found, std::size_t limit, const PairBudget& budget);
  std::size_t found() const { return found_; }  ///< pairs counted so far; there may be more
  std::size_t limit() const { return limit_; }  ///< pairs that the budget has room for

 private:
  std::size_t found_, limit_;
};

/// Finds the pairs of primitives that could touch during the step: for a conservative one, every
/// pair whose swept boxes, each inflated by its surface's thickness, overlap (or a provably
/// sufficient part of them, see PairSet). Rejects surfaces with coordinates that are not finite by
/// std::invalid_argument naming the vertex, and ends in BudgetExceeded when there are too many
/// pairs.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  /// Holds for the calls from now on. See stream.h for sets of any size in pieces.
  void set_budget(const PairBudget& budget) { budget_ = budget; }
  const PairBudget& budget() const { return budget_; }

  /// Pairs between two different surfaces. Clears `out` first.
  virtual void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) = 0;
  /// Pairs of one surface with itself. Clears `out` first.
  virtual void find_self_pairs(const SurfaceView& a, CandidatePairs& out) = 0;
  virtual BroadPhaseTraits traits() const = 0;
  /// Cost of the last call; all zero for a detector that does not measure.
  virtual BroadPhaseCost last_cost() const { return {}; }

 private:
  PairBudget budget_;
};

/// Every box against every box, in double precision: the oracle of the others. Reports exactly the
/// pairs whose swept boxes, inflated by the thickness and closed, overlap.
std::unique_ptr<BroadPhase> make_brute_force();

struct BvhConfig {
  /// A kept tree is built anew when its boxes overlap this much more than just after its build
  /// (see VolumeTree::looseness). Lower: better trees, more builds. > 1. Over 150 frames in which a
  /// flat sheet of 120 x 120 crumples or wraps a ball, values from 1.2 to never cost about the
  /// same, within the noise of that machine: refitted trees of cloth stay good, and the bound is
  /// for surfaces that are torn or mixed.
  double rebuild_looseness = 1.5;
  /// Use vectors of eight floats where the processor has them; off: four. Same pairs either way.
  bool wide_vectors = true;
  /// Children of a node, 2 to 8. Fewer: more levels and more memory, boxes that fit better; nodes
  /// are stored and tested eight children at a time whatever it is.
  int arity = 8;
  /// Triangles of a leaf, 1 to 24. Fewer: fewer primitives tested in vain, more nodes and memory.
  /// Of 2 to 24, 16 and more were quickest in building, fitting and asking alike, on a draped sheet
  /// and on a crumpled one of 200 x 200: from 8 to 16, asking takes a fifth less.
  int leaf_size = 16;
};

/// A tree of axis-aligned boxes over the swept triangles, kept between calls: a surface whose
/// triangles were seen before is refitted, one whose nonzero static_id was seen before costs
/// nothing. Reports the same pairs as brute force, bit for bit.
///
/// The leaves of a mesh are groups of triangles that hang together, found by its topology when it
/// is first seen; building makes the nodes above them. Triangles that mostly share no edges (a
/// soup) get leaves by their positions with each build, which then takes some five times as long.
///
/// All trees: against a surface with a rigid motion, boxes are taken in the body's own frame, where
/// its tree needs no refit. The pairs are then those whose boxes overlap there: others than in the
/// world, and none less that comes nearer than the sum of the thicknesses.
std::unique_ptr<BroadPhase> make_bvh_aabb(const BvhConfig& config = {});

/// The tree of boxes, without the pairs inside subtrees that provably keep apart over the step:
/// pieces of surface with swept normals in a cone and a contour that keeps apart [Volino1994],
/// [Tang2009]. Reports every pair that comes nearer than the sum of the thicknesses.
std::unique_ptr<BroadPhase> make_curvature_cone(const BvhConfig& config = {});

/// The tree of boxes with discrete orientation polytopes of k = 6, 14, 18 or 26 sides in their
/// place [Klosowski1998, Mezger2003]: the box pairs less those that a plane across one of the k / 2
/// directions keeps apart by more than the thicknesses during the whole step. k = 6 is bvh_aabb.
std::unique_ptr<BroadPhase> make_bvh_kdop(int k, const BvhConfig& config = {});

/// The tree of boxes with oriented boxes around nodes and leaves [Gottschalk1996] beside the
/// axis-aligned ones: the box pairs less those of leaves that a separating axis keeps apart by more
/// than the thicknesses during the whole step. Which pairs are left out depends on the tree, so on
/// earlier calls; never on the number of threads.
std::unique_ptr<BroadPhase> make_bvh_obb(const BvhConfig& config = {});

struct CellGridConfig {
  /// Size of the primitives that belong to the finest cells but for finer ones, over the typical
  /// extent of an edge's box. Smaller: fewer boxes to compare, more cells to look into. > 0
  double cell = 1.0;
};

/// Cells of the size of a typical edge in a table that repeats in space, so that memory is bounded
/// by the number of primitives. Larger primitives are kept in coarser grids, each four times the
/// last. Reports the same pairs as brute force, bit for bit.
std::unique_ptr<BroadPhase> make_uniform_grid(const CellGridConfig& config = {});

/// The same cells in a hash table [Teschner2003].
std::unique_ptr<BroadPhase> make_hash_grid(const CellGridConfig& config = {});

struct SweepAndPruneConfig {
  /// Side of the columns that are swept each for itself, over the typical extent of an edge's box.
  /// Smaller: fewer boxes to compare, more that are in several columns. 0: one axis alone, as in
  /// the papers.
  double column = 4.0;
};

/// Boxes sorted along an axis [Baraff1992], anew in each call, in columns. Reports the same pairs
/// as brute force, bit for bit.
std::unique_ptr<BroadPhase> make_sweep_and_prune(const SweepAndPruneConfig& config = {});

struct VoxelConfig {
  /// Side of a voxel over the typical extent of an edge's box; 0: 1.7, the optimum of the model in
  /// voxel.cpp. Smaller: shorter lists, in more voxels. >= 0
  double voxel = 0.0;
};

/// Equal cubes that list the primitives reaching into them [ZhangYuen2000]. Reports the same pairs
/// as brute force, bit for bit, whatever the size.
std::unique_ptr<BroadPhase> make_voxel(const VoxelConfig& config = {});

/// One size of voxel and what a call with it took.
struct VoxelTrial {
  double voxel = 0.0;     ///< as in VoxelConfig
  double seconds = 0.0;   ///< build and query
  std::size_t bytes = 0;  ///< memory kept
};

/// Measures voxels of sizes from 0.5 to 8 on these surfaces (b null: a with itself); the fastest
/// comes first.
std::vector<VoxelTrial> search_voxel(const SurfaceView& a, const SurfaceView* b = nullptr);

/// Names and factories of the detectors that this build has.
using BroadPhaseRegistry = std::map<std::string, std::function<std::unique_ptr<BroadPhase>()>>;

/// The detectors that need no optional library.
BroadPhaseRegistry broad_phases();

}  // namespace selvedge
