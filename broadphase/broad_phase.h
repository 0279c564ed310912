// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/registry.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {

/// Set of pairs that a conservative detector reports, relative to the pairs whose swept boxes
/// overlap.
enum class PairSet : std::uint8_t {
  boxes,           ///< exactly the pairs whose boxes overlap
  contains_boxes,  ///< all pairs whose boxes overlap, and some others
  culled,  ///< at least every pair that comes nearer than the sum of the two thicknesses (on
           ///< straight paths) during the step; may omit other pairs whose boxes overlap
};

/// Capabilities of a detector. The registry reports them.
struct BroadPhaseTraits {
  Guarantee guarantee = Guarantee::conservative;  ///< approximate: may miss pairs
  PairSet pairs = PairSet::boxes;                 ///< pairs that a conservative detector reports
  bool self = true;                               ///< supports find_self_pairs
  bool deforming = true;                          ///< supports surfaces that change shape
  bool closed_body_only = false;                  ///< the second surface must be a closed body
  bool all_pairs = false;  ///< tests every primitive against every other: quadratic cost
  bool rigid = false;      ///< exploits a rigid motion: keeps the structure of a body that moves
                           ///< rigidly
  bool particles = false;  ///< answers particles by contacts of its own (find_particle_contacts)
  std::string source{};    ///< author, title, year
};

/// Cost of the last call of a detector.
struct BroadPhaseCost {
  double build_s = 0.0;   ///< s, building trees
  double refit_s = 0.0;   ///< s, refitting kept trees to new positions
  double query_s = 0.0;   ///< s, finding and sorting the pairs
  std::size_t bytes = 0;  ///< memory kept between calls
};

/// Limits of one call.
struct PairBudget {
  /// Maximum number of pairs in the three lists together. The default fits any 32-bit index.
  std::size_t pairs = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  /// Maximum memory, in bytes, of everything that grows with the pairs, scratch included. The
  /// default, 4 GiB less one byte, holds about 10^8 pairs. Memory that grows with the primitives
  /// does not count.
  std::size_t bytes = std::size_t{0xffffffffu};
};

/// Thrown before a call would exceed its budget. Whether it is thrown depends only on the set of
/// pairs, not on the number of threads. The result list is empty afterwards, and the detector can
/// still be used.
class BudgetExceeded : public std::runtime_error {
 public:
  BudgetExceeded(std::size_t found, std::size_t limit, const PairBudget& budget);
  std::size_t found() const { return found_; }  ///< pairs counted so far; there may be more
  std::size_t limit() const { return limit_; }  ///< pairs that the budget allows

 private:
  std::size_t found_, limit_;
};

/// The contact of a particle that a detector found without a narrow phase, at the end of the step.
struct ParticleContact {
  PointTrianglePair pair;      ///< particle of a, triangle of b
  Vec3 weight = Vec3::Zero();  ///< of the triangle's corners, at the point of contact
  Vec3 normal = Vec3::Zero();  ///< unit, out of b
  double distance = 0.0;       ///< m, to the surface of b; negative: inside
};

/// Finds the candidate pairs of a step: pairs of primitives that could touch. A conservative
/// detector reports every pair whose swept boxes overlap, each inflated by its surface's thickness,
/// or a provably sufficient subset (see PairSet). The find functions throw std::invalid_argument
/// that names the vertex if a coordinate is not finite, and BudgetExceeded if there are too many
/// pairs.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  /// Sets the budget of all later calls. See stream_pairs for pair sets of any size, delivered in
  /// pieces.
  void set_budget(const PairBudget& budget) { budget_ = budget; }
  /// The budget of later calls.
  const PairBudget& budget() const { return budget_; }

  /// Clears `out` and writes the pairs between two different surfaces to it.
  virtual void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) = 0;
  /// Clears `out` and writes the pairs of one surface with itself to it.
  virtual void find_self_pairs(const SurfaceView& a, CandidatePairs& out) = 0;
  /// Clears `out` and writes the contacts of the particles of `a` that end inside the body `b`, or
  /// nearer to it than `reach` metres, in the order of the particles. Only detectors with
  /// traits().particles find any.
  virtual void find_particle_contacts(const SurfaceView& a, const SurfaceView& b, double reach,
                                      std::vector<ParticleContact>& out) {
    static_cast<void>(a);
    static_cast<void>(b);
    static_cast<void>(reach);
    out.clear();
  }
  /// Capabilities of the detector, the same at all times.
  virtual BroadPhaseTraits traits() const = 0;
  /// Cost of the last call; all zero for a detector that does not measure.
  virtual BroadPhaseCost last_cost() const { return {}; }

 private:
  PairBudget budget_;
};

/// Tests every box against every other in double precision: the reference for the other detectors.
/// Reports exactly the pairs whose closed swept boxes, inflated by the thickness, overlap.
std::unique_ptr<BroadPhase> make_brute_force();

/// Options of the detectors based on a bounding volume tree.
struct BvhConfig {
  /// A kept tree is rebuilt when its quality loss exceeds this value: the overlap of its boxes
  /// relative to that just after its build (see VolumeTree::quality_loss). Lower: better trees,
  /// more builds. > 1. Over 150 frames in which a flat sheet of 120 x 120 crumples or wraps a ball,
  /// all values from 1.2 to infinity cost about the same, within the noise of the machine. Refitted
  /// trees of cloth stay good; the limit is for surfaces that are torn or whose parts mix.
  double rebuild_quality_loss = 1.5;
  /// Use vectors of eight floats if the processor supports them; off: four. The pairs are the same.
  bool wide_vectors = true;
  /// Children per node, 2 to 8. Fewer: tighter boxes, but more levels and more memory. Nodes are
  /// always stored and tested eight children at a time.
  int arity = 8;
  /// Triangles per leaf, 1 to 24. Fewer: fewer unnecessary primitive tests, but more nodes and
  /// memory. Of 2 to 24, values from 16 on were the fastest in building, refitting and querying
  /// alike, on a draped and on a crumpled sheet of 200 x 200; from 8 to 16, query time drops by a
  /// fifth.
  int leaf_size = 16;
};

/// A tree of axis-aligned boxes over the swept triangles, kept between calls. A surface with known
/// triangles is refitted; one with a known nonzero static_id costs nothing. Reports the same pairs
/// as brute force, bit for bit.
///
/// The leaves are groups of connected triangles, found from the topology when a mesh is first seen;
/// each build only makes the nodes above them. Triangles that mostly share no edges (a soup) get
/// new leaves from their positions in each build, which then takes about five times as long.
///
/// All trees: against a surface with a rigid motion, boxes are taken in the body's own frame, where
/// its tree needs no refit. The reported pairs are those whose boxes overlap in that frame. They
/// differ from those in the world frame, but include every pair that comes nearer than the sum of
/// the thicknesses.
std::unique_ptr<BroadPhase> make_bvh_aabb(const BvhConfig& config = {});

/// The tree of boxes, without the pairs inside subtrees that provably do not touch themselves
/// during the step: pieces of surface whose swept normals lie in a cone and whose contour does not
/// approach itself [Volino1994], [Tang2009]. Reports every pair that comes nearer than the sum of
/// the thicknesses.
std::unique_ptr<BroadPhase> make_curvature_cone(const BvhConfig& config = {});
/// The same with the cone of normals alone [Provot1997], without the test of the contour: misses
/// the pairs of a surface that winds or spirals over itself with all its normals on one side.
std::unique_ptr<BroadPhase> make_normal_cone(const BvhConfig& config = {});

/// The tree with discrete orientation polytopes of k = 6, 14, 18 or 26 sides instead of boxes
/// [Klosowski1998, Mezger2003]. Reports the pairs whose boxes overlap, except those that a plane
/// perpendicular to one of the k / 2 directions separates by more than the thicknesses during the
/// whole step. k = 6 is bvh_aabb. Throws std::invalid_argument for another k.
std::unique_ptr<BroadPhase> make_bvh_kdop(int k, const BvhConfig& config = {});

/// The tree of boxes with additional oriented boxes around nodes and leaves [Gottschalk1996].
/// Reports the pairs whose boxes overlap, except those of leaves that a separating axis keeps apart
/// by more than the thicknesses during the whole step. Which pairs are omitted depends on the tree
/// and hence on earlier calls, but never on the number of threads.
std::unique_ptr<BroadPhase> make_bvh_obb(const BvhConfig& config = {});

/// Options of `uniform_grid` and `hash_grid`.
struct CellGridConfig {
  /// Size of the primitives in the grid of level 0, relative to the typical extent of an edge's
  /// box; smaller and larger primitives go to other levels. Smaller: fewer box tests, more cells to
  /// visit. > 0
  double cell = 1.0;
};

/// Cells of the size of a typical edge, in a table that repeats in space, so that the number of
/// primitives bounds the memory. Larger primitives are kept in coarser grids, each four times as
/// coarse as the previous one. Reports the same pairs as brute force, bit for bit.
std::unique_ptr<BroadPhase> make_uniform_grid(const CellGridConfig& config = {});

/// The same cells in a hash table [Teschner2003].
std::unique_ptr<BroadPhase> make_hash_grid(const CellGridConfig& config = {});

/// Options of `sweep_and_prune`.
struct SweepAndPruneConfig {
  /// Side of the columns that are swept separately, relative to the typical extent of an edge's
  /// box. Smaller: fewer box tests, more boxes in several columns. 0: a single sweep along one
  /// axis, as in the papers.
  double column = 4.0;
};

/// Sorts boxes along an axis [Baraff1992], in columns, from scratch in each call. Reports the same
/// pairs as brute force, bit for bit.
std::unique_ptr<BroadPhase> make_sweep_and_prune(const SweepAndPruneConfig& config = {});

/// Options of `voxel`.
struct VoxelConfig {
  /// Side of a voxel relative to the typical extent of an edge's box, >= 0; 0: 1.7, the optimum of
  /// the model in voxel.cpp. Smaller: shorter lists, in more voxels.
  double voxel = 0.0;
};

/// Equal cubes, each with a list of the primitives that reach into it [ZhangYuen2000]. Reports the
/// same pairs as brute force, bit for bit, for any size.
std::unique_ptr<BroadPhase> make_voxel(const VoxelConfig& config = {});

/// One voxel size and the cost of a call with it.
struct VoxelTrial {
  double voxel = 0.0;     ///< side, as in VoxelConfig
  double seconds = 0.0;   ///< s, build and query
  std::size_t bytes = 0;  ///< memory kept
};

/// Measures voxel sizes from 0.5 to 8 on these surfaces (b null: a with itself) and returns them,
/// fastest first.
std::vector<VoxelTrial> search_voxel(const SurfaceView& a, const SurfaceView* b = nullptr);

/// The guarantee of a detector with these traits, and what it does not support, as one sentence.
std::string promise_of(const BroadPhaseTraits& traits);

/// The detectors by name.
using BroadPhaseRegistry = Registry<std::unique_ptr<BroadPhase>, BroadPhaseTraits>;

/// The detectors that need no optional library; the names of the others are noted as absent.
BroadPhaseRegistry broad_phases();

/// A box of a hierarchy, m.
struct LevelBox {
  Vec3 lo, hi;
};

/// The boxes of the tree that bvh_aabb builds for this surface, for visualisation. Level 0 is the
/// root; each further level replaces every node of the previous one by its children, so each level
/// contains all primitives. The last level consists of leaves only. Throws std::invalid_argument as
/// bvh_aabb does; an empty surface has no levels.
std::vector<std::vector<LevelBox>> hierarchy_levels(const SurfaceView& surface);

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
/// worthwhile, each call searches again, and margins are tested again every few hundred calls.
///
/// Throws std::invalid_argument unless `inner` is conservative and reports all pairs of overlapping
/// boxes (PairSet `boxes` or `contains_boxes`).
std::unique_ptr<BroadPhase> make_verlet_list(std::unique_ptr<BroadPhase> inner,
                                             const VerletListConfig& config = {});

}  // namespace selvedge
