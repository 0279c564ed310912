// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/bounding_volume_tree.h>
#include <selvedge/broadphase/detail/bvh.h>
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/broadphase/detail/surface_check.h>
#include <selvedge/broadphase/detail/traverse.h>
#include <selvedge/core/parallel.h>

#include <chrono>
#include <stdexcept>

namespace selvedge {
namespace {

using detail::BoundingVolumeTree;
using detail::TreePair;

/// The traversal is cut into about this many parts, whatever the number of threads.
constexpr std::size_t kParts = 128;
/// Surfaces whose trees are kept: those of a call and two older ones.
constexpr std::size_t kKeptTrees = 4;
/// Float boxes are taken about an origin near the first surface. At sixteen times the size of the
/// surface they still resolve 2^-20 of it, so that few pairs need the look in double.
constexpr double kFarFromOrigin = 16.0;
/// A first surface that is much smaller than the second (a single point, say) may move this part of
/// the second's size before the origin follows; else every call would fit the second one again.
constexpr double kSmallPart = 1e-3;

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// A tree and what it was last fitted to.
struct KeptTree {
  BoundingVolumeTree tree;
  std::uint64_t static_id = 0;
  double thickness = -1.0;
  Vec3 origin = Vec3::Zero();
  detail::Bounds bounds;                ///< of x_t0
  const Triangle* triangles = nullptr;  ///< where they were, to find the likely tree first
  std::uint64_t last_use = 0;           ///< 0: never
  bool fitted = false;

  bool is_static_copy_of(const SurfaceView& s) const {
    return fitted && s.static_id != 0 && s.static_id == static_id &&
           s.x_t0.size() == tree.vertex_count() && s.edges.size() == tree.edge_count() &&
           s.triangles.size() == tree.triangle_count();
  }
};

/// Largest side of a box; 0 if it is empty.
double size_of(const detail::Bounds& b) { return std::max(0.0, (b.hi - b.lo).maxCoeff()); }

class Bvh final : public BroadPhase {
 public:
  explicit Bvh(const BvhConfig& config, std::unique_ptr<detail::SelfCull> cull = nullptr)
      : config_(config), cull_(std::move(cull)) {
    if (!(config.rebuild_looseness > 1.0))
      throw std::invalid_argument("bvh: rebuild_looseness must be greater than 1, not " +
                                  std::to_string(config.rebuild_looseness));
    kernel_ = detail::traversal_kernel_narrow();
    if (const detail::TraversalKernel wide = detail::traversal_kernel_wide();
        config.wide_vectors && wide.traverse)
      kernel_ = wide;
  }

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    cost_ = {};
    detail::check_shape(a, "first surface");
    detail::check_shape(b, "second surface");
    KeptTree& tree_a = choose_tree(a, nullptr, "first surface");
    KeptTree& tree_b = choose_tree(b, &tree_a, "second surface");
    place_origin(tree_a.bounds, size_of(tree_b.bounds));
    fit(tree_a, a);
    fit(tree_b, b);
    const Stopwatch watch;
    find({tree_a.tree, tree_b.tree, a, b, false}, out);
    collector_.collect(parts_, &detail::FoundPairs::point_triangle, a.x_t0.size(),
                       b.triangles.size(), out.point_triangle);
    collector_.collect(parts_, &detail::FoundPairs::triangle_point, b.x_t0.size(),
                       a.triangles.size(), out.triangle_point);
    collector_.collect(parts_, &detail::FoundPairs::edge_edge, a.edges.size(), b.edges.size(),
                       out.edge_edge);
    cost_.query_s = watch.seconds();
  }

  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    cost_ = {};
    detail::check_shape(a, "surface");
    KeptTree& tree = choose_tree(a, nullptr, "surface");
    place_origin(tree.bounds, 0.0);
    fit(tree, a);
    const Stopwatch watch;
    find({tree.tree, tree.tree, a, a, true, mark_self(tree.tree, a)}, out);
    collector_.collect(parts_, &detail::FoundPairs::point_triangle, a.x_t0.size(),
                       a.triangles.size(), out.point_triangle);
    collector_.collect(parts_, &detail::FoundPairs::edge_edge, a.edges.size(), a.edges.size(),
                       out.edge_edge);
    out.triangle_point.clear();
    cost_.query_s = watch.seconds();
  }

  BroadPhaseTraits traits() const override {
    if (cull_) return cull_->traits();
    return {.source =
                "tree of axis-aligned boxes over swept triangles with owned vertices and "
                "edges; S. Curtis, R. Tamstorf, D. Manocha, Fast collision detection for "
                "deformable models using representative-triangles, 2008"};
  }

  BroadPhaseCost last_cost() const override {
    BroadPhaseCost cost = cost_;
    cost.bytes = collector_.bytes() + scratch_.bytes() + (cull_ ? cull_->bytes() : 0);
    for (const KeptTree& kept : kept_) cost.bytes += kept.tree.bytes();
    for (const detail::FoundPairs& part : parts_) cost.bytes += part.bytes();
    return cost;
  }

 private:
  /// The kept tree that serves `surface` with the least work, its topology set and its positions
  /// checked. `taken` serves the other surface of this call.
  KeptTree& choose_tree(const SurfaceView& surface, const KeptTree* taken, const char* name) {
    const Stopwatch watch;
    KeptTree* chosen = find_kept(surface, taken);
    const bool unchanged = chosen && chosen->is_static_copy_of(surface);
    if (!unchanged) {
      const detail::Bounds bounds = detail::check_finite(surface, name);
      if (!chosen) {
        detail::check_indices(surface, name);
        chosen = &oldest(taken);
        chosen->fitted = false;
        chosen->static_id = 0;
        chosen->tree.set_topology(surface);
      }
      // A different static surface deserves a tree of its own shape.
      if (surface.static_id != chosen->static_id) chosen->fitted &= surface.static_id == 0;
      chosen->static_id = surface.static_id;
      chosen->thickness = -1.0;
      chosen->bounds = bounds;
    }
    chosen->triangles = surface.triangles.data();
    chosen->last_use = ++uses_;
    (chosen->fitted ? cost_.refit_s : cost_.build_s) += watch.seconds();
    return *chosen;
  }

  KeptTree* find_kept(const SurfaceView& surface, const KeptTree* taken) {
    for (KeptTree& kept : kept_)
      if (&kept != taken && kept.is_static_copy_of(surface)) return &kept;
    for (const bool same_place : {true, false})
      for (KeptTree& kept : kept_)
        if (&kept != taken && kept.last_use > 0 &&
            (kept.triangles == surface.triangles.data()) == same_place &&
            kept.tree.has_topology_of(surface))
          return &kept;
    return nullptr;
  }

  KeptTree& oldest(const KeptTree* taken) {
    KeptTree* best = nullptr;
    for (KeptTree& kept : kept_)
      if (&kept != taken && (!best || kept.last_use < best->last_use)) best = &kept;
    return *best;
  }

  void place_origin(const detail::Bounds& bounds, double other_size) {
    if ((bounds.lo.array() > bounds.hi.array()).any()) return;
    const Vec3 center = 0.5 * bounds.lo + 0.5 * bounds.hi;
    const double size = std::max(size_of(bounds), kSmallPart * other_size);
    // Written so that an infinite difference moves the origin too.
    if (!((center - origin_).cwiseAbs().maxCoeff() <= kFarFromOrigin * size)) origin_ = center;
  }

  void fit(KeptTree& kept, const SurfaceView& surface) {
    if (kept.fitted && kept.thickness == surface.thickness && kept.origin == origin_) return;
    const Stopwatch watch;
    if (kept.fitted) {
      kept.tree.refit(surface, origin_, scratch_);
      cost_.refit_s += watch.seconds();
    }
    if (!kept.fitted || kept.tree.looseness() > config_.rebuild_looseness) {
      const Stopwatch build_watch;
      kept.tree.build(surface, origin_, scratch_);
      cost_.build_s += build_watch.seconds();
    }
    kept.fitted = true;
    kept.thickness = surface.thickness;
    kept.origin = origin_;
  }

  /// What the cull lets the traversal skip; null if there is no cull.
  const detail::SelfSkip* mark_self(const BoundingVolumeTree& tree, const SurfaceView& surface) {
    if (!cull_ || tree.empty()) return nullptr;
    skip_.nodes.assign(tree.node_count(), 0);
    skip_.leaves.assign(tree.leaf_count(), 0);
    cull_->mark(tree, surface, skip_);
    return &skip_;
  }

  /// Fills parts_; clears `out` if they are too much.
  void find(const detail::TraversalInput& input, CandidatePairs& out) {
    detail::PairTally tally(budget(), detail::PairBuffer::kBytesPerPair);
    parts_.resize(kParts);
    for (detail::FoundPairs& part : parts_) part.start(&tally);
    try {
      fill_parts(input);
      for (detail::FoundPairs& part : parts_) part.finish();
    } catch (const BudgetExceeded&) {
      out.clear();
      throw;
    }
  }

  /// The parts depend on the trees alone.
  void fill_parts(const detail::TraversalInput& input) {
    stacks_.resize(kParts);
    if (input.tree_a.empty() || input.tree_b.empty()) return;
    if (input.skip && input.skip->skips(input.tree_a.root())) return;
    pairs_.assign(1, {input.tree_a.root(), input.tree_b.root()});
    for (bool growing = true; growing && pairs_.size() < kParts;) {
      growing = false;
      next_pairs_.clear();
      for (const TreePair& pair : pairs_)
        if (kernel_.expand(input, pair, next_pairs_))
          growing = true;
        else
          next_pairs_.push_back(pair);
      pairs_.swap(next_pairs_);
    }
    const std::size_t grain = (pairs_.size() + kParts - 1) / kParts;
    parallel_for(pairs_.size(), grain, [&](std::size_t begin, std::size_t end) {
      const std::size_t part = begin / grain;
      for (std::size_t i = begin; i < end; ++i)
        kernel_.traverse(input, pairs_[i], stacks_[part], parts_[part]);
    });
  }

  BvhConfig config_;
  std::unique_ptr<detail::SelfCull> cull_;
  detail::SelfSkip skip_;
  detail::TraversalKernel kernel_;
  std::array<KeptTree, kKeptTrees> kept_;
  detail::TreeScratch scratch_;
  std::uint64_t uses_ = 0;
  Vec3 origin_ = Vec3::Zero();
  std::vector<TreePair> pairs_, next_pairs_;
  std::vector<std::vector<TreePair>> stacks_;
  std::vector<detail::FoundPairs> parts_;
  detail::PairCollector collector_;
  BroadPhaseCost cost_;
};

}  // namespace

std::unique_ptr<BroadPhase> make_bvh_aabb(const BvhConfig& config) {
  return std::make_unique<Bvh>(config);
}

std::unique_ptr<BroadPhase> detail::make_bvh_aabb(const BvhConfig& config,
                                                  std::unique_ptr<SelfCull> cull) {
  return std::make_unique<Bvh>(config, std::move(cull));
}

}  // namespace selvedge
