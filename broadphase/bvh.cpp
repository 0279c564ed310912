// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/bvh.h>
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/broadphase/detail/extent.h>
#include <selvedge/broadphase/detail/surface_check.h>
#include <selvedge/broadphase/detail/traverse.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <stdexcept>

namespace selvedge {
namespace {

using detail::BoundingVolume;
using detail::TreePair;
using detail::TreePlace;

/// The traversal is divided into about this many parts, whatever the number of threads.
constexpr std::size_t kParts = 128;
/// Number of surfaces whose trees are kept: those of the current call and some older ones. A
/// surface that meets rigid bodies has one tree for each body and one for the world.
constexpr std::size_t kKeptTrees = 6;

/// Purpose of a kept tree. A tree of the same surface in another frame has another shape.
struct Role {
  std::uint64_t frame = 0;  ///< id of the rigid body that defines the frame; 0: the world
  bool is_body = false;     ///< the surface is that body

  bool operator==(const Role&) const = default;
};

/// A tree and the input of its last fit.
template <BoundingVolume V>
struct KeptTree {
  detail::VolumeTree<V> tree;
  Role role;
  std::uint64_t static_id = 0;
  double thickness = -1.0;  ///< of the last fit; < 0: positions have changed since
  Vec3 origin = Vec3::Zero();
  std::uint64_t maps = 0;               ///< version of the maps that replace the origin; 0: none
  detail::Extent extent;                ///< of x_t0, or of a rigid body's rest positions
  const Triangle* triangles = nullptr;  ///< address at the last call, to find the likely tree first
  std::uint64_t last_use = 0;           ///< 0: never
  bool fitted = false;

  bool has_counts_of(const SurfaceView& s) const {
    return s.x_t0.size() == tree.vertex_count() && s.edges.size() == tree.edge_count() &&
           s.triangles.size() == tree.triangle_count();
  }
  bool is_static_copy_of(const SurfaceView& s) const {
    return fitted && s.static_id != 0 && s.static_id == static_id && has_counts_of(s);
  }
};

template <BoundingVolume V>
class Bvh final : public BroadPhase {
 public:
  Bvh(const BvhConfig& config, BroadPhaseTraits traits,
      std::unique_ptr<detail::SelfCull> cull = nullptr)
      : config_(config), traits_(std::move(traits)), cull_(std::move(cull)) {
    kernel_ = detail::traversal_kernel_narrow<V>();
    if (const auto wide = detail::traversal_kernel_wide<V>(); config.wide_vectors && wide.traverse)
      kernel_ = wide;
    for (Kept& kept : kept_) kept.tree = Tree({config.arity, config.leaf_size});
  }

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    cost_ = {};
    detail::check_shape(a, "first surface");
    detail::check_shape(b, "second surface");
    const TwoTrees trees = fit_both(a, b);
    const Stopwatch watch;
    find({trees.a->tree, trees.b->tree, a, b, false, nullptr, !trees.in_frame}, out);
    collector_.collect(parts_, a, &b, out);
    cost_.query_s = watch.seconds();
  }

  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    cost_ = {};
    detail::check_shape(a, "surface");
    Kept& kept = choose_tree(a, {}, nullptr, "surface");
    place_origin(kept.extent, 0.0);
    choose_maps(a, nullptr);
    fit(kept, a, place());
    const Stopwatch watch;
    find({kept.tree, kept.tree, a, a, true, mark_self(kept.tree, a)}, out);
    collector_.collect(parts_, a, nullptr, out);
    cost_.query_s = watch.seconds();
  }

  BroadPhaseTraits traits() const override { return traits_; }

  BroadPhaseCost last_cost() const override {
    BroadPhaseCost cost = cost_;
    cost.bytes = collector_.bytes() + scratch_.bytes() + (cull_ ? cull_->bytes() : 0);
    for (const Kept& kept : kept_) cost.bytes += kept.tree.bytes();
    for (const detail::FoundPairs& part : parts_) cost.bytes += part.bytes();
    return cost;
  }

 private:
  using Tree = detail::VolumeTree<V>;
  using Kept = KeptTree<V>;
  using Input = detail::TraversalInput<V>;

  struct TwoTrees {
    Kept* a;
    Kept* b;
    bool in_frame;
  };

  TwoTrees fit_both(const SurfaceView& a, const SurfaceView& b) {
    const bool use_a = is_rigid(a) && (!is_rigid(b) || a.triangles.size() > b.triangles.size());
    if (use_a || is_rigid(b))
      if (const auto trees = use_a ? fit_in_frame(a, "first surface", b, "second surface")
                                   : fit_in_frame(b, "second surface", a, "first surface"))
        return use_a ? *trees : TwoTrees{trees->b, trees->a, true};
    Kept& kept_a = choose_tree(a, {}, nullptr, "first surface");
    Kept& kept_b = choose_tree(b, {}, &kept_a, "second surface");
    place_origin(kept_a.extent, kept_b.extent.size);
    choose_maps(a, &b);
    fit(kept_a, a, place());
    fit(kept_b, b, place());
    return {&kept_a, &kept_b, false};
  }

  static bool is_rigid(const SurfaceView& s) {
    return s.static_id == 0 && s.rigid && s.rigid->id != 0 && !s.x_t0.empty();
  }

  /// Both trees in the frame of the rigid `body`, whose own tree is fitted only once; empty if the
  /// body rotates too far.
  std::optional<TwoTrees> fit_in_frame(const SurfaceView& body, const char* body_name,
                                       const SurfaceView& other, const char* other_name) {
    const Role role{body.rigid->id, true};
    Kept& kept = choose_body(body, role, body_name);
    const detail::RigidFrame frame(*body.rigid, kept.extent.reach, body.thickness);
    if (!frame.serves()) return std::nullopt;
    const TreePlace place{kept.extent.center, &frame, true};
    if (!kept.fitted) fit(kept, body, place);
    Kept& kept_other = choose_tree(other, {role.frame, false}, &kept, other_name);
    kept_other.thickness = -1.0;  // The frame has moved, even if a static surface has not.
    fit(kept_other, other, {place.origin, &frame, false});
    return TwoTrees{&kept, &kept_other, true};
  }

  Kept& choose_body(const SurfaceView& body, const Role& role, const char* name) {
    for (Kept& kept : kept_)
      if (kept.last_use > 0 && kept.role == role && kept.fitted && kept.has_counts_of(body)) {
        kept.last_use = ++uses_;
        return kept;
      }
    const Stopwatch watch;
    detail::check_finite(body, name);
    detail::check_indices(body, name);
    Kept& kept = oldest(nullptr);
    kept.fitted = false;
    kept.role = role;
    kept.static_id = 0;
    kept.tree.set_topology(body);
    // The frames for all thicknesses and sizes map the body in the same way.
    kept.extent = detail::rest_extent(body);
    kept.triangles = body.triangles.data();
    kept.last_use = ++uses_;
    cost_.build_s += watch.seconds();
    return kept;
  }

  /// Chooses the kept tree that serves `surface` in that role with the least work, sets its
  /// topology and checks its positions. `taken` serves the other surface of this call.
  Kept& choose_tree(const SurfaceView& surface, const Role& role, const Kept* taken,
                    const char* name) {
    const Stopwatch watch;
    Kept* chosen = find_kept(surface, role, taken);
    const bool unchanged = chosen && chosen->is_static_copy_of(surface);
    if (!unchanged) {
      detail::check_finite(surface, name);
      if (!chosen) {
        detail::check_indices(surface, name);
        chosen = &oldest(taken);
        chosen->fitted = false;
        chosen->static_id = 0;
        chosen->role = role;
        chosen->tree.set_topology(surface);
      }
      // A different static surface gets a tree of its own shape.
      if (surface.static_id != chosen->static_id) chosen->fitted &= surface.static_id == 0;
      chosen->static_id = surface.static_id;
      chosen->thickness = -1.0;
      chosen->extent = detail::extent_of(surface.x_t0);
    }
    chosen->triangles = surface.triangles.data();
    chosen->last_use = ++uses_;
    (chosen->fitted ? cost_.refit_s : cost_.build_s) += watch.seconds();
    return *chosen;
  }

  Kept* find_kept(const SurfaceView& surface, const Role& role, const Kept* taken) {
    const auto may_serve = [&](const Kept& kept) { return &kept != taken && kept.role == role; };
    for (Kept& kept : kept_)
      if (may_serve(kept) && kept.is_static_copy_of(surface)) return &kept;
    for (const bool same_place : {true, false})
      for (Kept& kept : kept_)
        if (may_serve(kept) && kept.last_use > 0 &&
            (kept.triangles == surface.triangles.data()) == same_place &&
            kept.tree.has_topology_of(surface))
          return &kept;
    return nullptr;
  }

  Kept& oldest(const Kept* taken) {
    Kept* best = nullptr;
    for (Kept& kept : kept_)
      if (&kept != taken && (!best || kept.last_use < best->last_use)) best = &kept;
    return *best;
  }

  void place_origin(const detail::Extent& extent, double other_size) {
    // Float boxes are relative to an origin near the first surface. At a distance of sixteen times
    // the size of the surface they still resolve 2^-20 of it, so few pairs need the test in double.
    constexpr double kFarFromOrigin = 16.0;
    // A first surface that is much smaller than the second (a single point, say) may move by this
    // fraction of the second's size before the origin follows; otherwise every call would refit the
    // second.
    constexpr double kSmallPart = 1e-3;
    const double size = std::max(extent.size, kSmallPart * other_size);
    // The comparison is written so that an infinite difference moves the origin too.
    if (!((extent.center - origin_).cwiseAbs().maxCoeff() <= kFarFromOrigin * size))
      origin_ = extent.center;
  }

  TreePlace place() const {
    return {.origin = origin_, .maps = maps_in_use_ ? maps_.data() : nullptr};
  }

  /// Uses maps instead of the origin if floats relative to the origin do not resolve a part of the
  /// surfaces that is much smaller than the whole. Otherwise all pairs of that part would be tested
  /// in double.
  void choose_maps(const SurfaceView& a, const SurfaceView* b) {
    std::vector<detail::DoubleBox> sample = detail::sample_boxes(a);
    if (b)
      for (const detail::DoubleBox& box : detail::sample_boxes(*b)) sample.push_back(box);
    const auto unresolved = [&](const auto& map) { return detail::count_unresolved(sample, map); };
    const auto mapped = [&](int k, double s) { return maps_[k](s); };
    if (maps_in_use_ && unresolved(mapped) < detail::kWorthAnotherMap) return;
    const int without = unresolved([&](int k, double s) { return s - origin_[k]; });
    maps_in_use_ = 0;
    if (without < detail::kWorthAnotherMap) return;
    constexpr auto directions = detail::dop_directions<V::axes>();
    maps_ = detail::quantile_maps(directions, a.x_t0, b ? b->x_t0 : std::span<const Vec3>());
    if (2 * unresolved(mapped) <= without) maps_in_use_ = ++maps_made_;
  }

  void fit(Kept& kept, const SurfaceView& surface, const TreePlace& place) {
    const std::uint64_t maps = place.maps ? maps_in_use_ : 0;
    if (kept.fitted && kept.thickness == surface.thickness && kept.origin == place.origin &&
        kept.maps == maps)
      return;
    const Stopwatch watch;
    if (kept.fitted) {
      kept.tree.refit(surface, place, scratch_);
      cost_.refit_s += watch.seconds();
    }
    if (!kept.fitted || kept.tree.quality_loss() > config_.rebuild_quality_loss) {
      const Stopwatch build_watch;
      kept.tree.build(surface, place, scratch_);
      cost_.build_s += build_watch.seconds();
    }
    kept.fitted = true;
    kept.thickness = surface.thickness;
    kept.origin = place.origin;
    kept.maps = maps;
  }

  /// The subtrees that the cull lets the traversal skip; null if there is no cull.
  const detail::SelfSkip* mark_self(const Tree& tree, const SurfaceView& surface) {
    if constexpr (std::is_same_v<Tree, detail::BoundingVolumeTree>) {
      if (!cull_ || tree.empty()) return nullptr;
      skip_.nodes.assign(tree.node_count(), 0);
      skip_.leaves.assign(tree.leaf_count(), 0);
      cull_->mark(tree, surface, skip_);
      return &skip_;
    } else {
      return nullptr;
    }
  }

  /// Fills parts_; clears `out` if they exceed the budget.
  void find(const Input& input, CandidatePairs& out) {
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

  /// The division into parts depends only on the trees.
  void fill_parts(const Input& input) {
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
  BroadPhaseTraits traits_;
  std::unique_ptr<detail::SelfCull> cull_;
  detail::SelfSkip skip_;
  detail::TraversalKernel<V> kernel_;
  std::array<Kept, kKeptTrees> kept_;
  typename Tree::Scratch scratch_;
  std::uint64_t uses_ = 0;
  Vec3 origin_ = Vec3::Zero();
  std::vector<detail::QuantileMap> maps_;  ///< by direction
  std::uint64_t maps_in_use_ = 0, maps_made_ = 0;
  std::vector<TreePair> pairs_, next_pairs_;
  std::vector<std::vector<TreePair>> stacks_;
  std::vector<detail::FoundPairs> parts_;
  detail::PairCollector collector_;
  BroadPhaseCost cost_;
};

void check(const BvhConfig& config) {
  const auto in_range = [](const char* name, int value, int least, int most) {
    if (value < least || value > most)
      throw std::invalid_argument("bvh: " + std::string(name) + " must be from " +
                                  std::to_string(least) + " to " + std::to_string(most) + ", not " +
                                  std::to_string(value));
  };
  if (!(config.rebuild_quality_loss > 1.0))
    throw std::invalid_argument("bvh: rebuild_quality_loss must be greater than 1, not " +
                                std::to_string(config.rebuild_quality_loss));
  in_range("arity", config.arity, 2, detail::kLanes);
  in_range("leaf_size", config.leaf_size, 1, detail::kMostLeafItems);
}

template <BoundingVolume V>
std::unique_ptr<BroadPhase> make(const BvhConfig& config, PairSet pairs, const char* source,
                                 std::unique_ptr<detail::SelfCull> cull = nullptr) {
  check(config);
  BroadPhaseTraits traits = cull ? cull->traits() : BroadPhaseTraits{};
  if (!cull) {
    traits.pairs = pairs;
    traits.source = source;
  }
  traits.rigid = true;
  return std::make_unique<Bvh<V>>(config, std::move(traits), std::move(cull));
}

constexpr const char* kAabbSource =
    "tree of axis-aligned boxes over swept triangles with owned vertices and edges; S. Curtis, "
    "R. Tamstorf, D. Manocha, Fast collision detection for deformable models using "
    "representative-triangles, 2008";
constexpr const char* kDopSource =
    "tree of discrete orientation polytopes over swept triangles; J. Klosowski, M. Held, "
    "J. Mitchell, H. Sowizral, K. Zikan, Efficient collision detection using bounding volume "
    "hierarchies of k-DOPs, 1998; J. Mezger, S. Kimmerle, O. Etzmuss, Hierarchical techniques in "
    "collision detection for cloth animation, 2003";
constexpr const char* kObbSource =
    "tree of oriented boxes over swept triangles; S. Gottschalk, M. Lin, D. Manocha, OBBTree: a "
    "hierarchical structure for rapid interference detection, 1996";

}  // namespace

std::unique_ptr<BroadPhase> make_bvh_aabb(const BvhConfig& config) {
  return make<detail::AabbVolume>(config, PairSet::boxes, kAabbSource);
}

std::unique_ptr<BroadPhase> make_bvh_kdop(int k, const BvhConfig& config) {
  switch (k) {
    case 6:
      return make<detail::AabbVolume>(config, PairSet::boxes, kDopSource);
    case 14:
      return make<detail::KDopVolume<14>>(config, PairSet::culled, kDopSource);
    case 18:
      return make<detail::KDopVolume<18>>(config, PairSet::culled, kDopSource);
    case 26:
      return make<detail::KDopVolume<26>>(config, PairSet::culled, kDopSource);
    default:
      throw std::invalid_argument("bvh_kdop: k must be 6, 14, 18 or 26, not " + std::to_string(k));
  }
}

std::unique_ptr<BroadPhase> make_bvh_obb(const BvhConfig& config) {
  return make<detail::ObbVolume>(config, PairSet::culled, kObbSource);
}

std::unique_ptr<BroadPhase> detail::make_bvh_aabb(const BvhConfig& config,
                                                  std::unique_ptr<SelfCull> cull) {
  return make<AabbVolume>(config, PairSet::culled, kAabbSource, std::move(cull));
}

void register_bvh(BroadPhaseRegistry& registry) {
  registry.add("bvh_aabb", {}, [](const MethodOptions&) { return make_bvh_aabb(); });
  registry.add("bvh_obb", {}, [](const MethodOptions&) { return make_bvh_obb(); });
  for (const int k : {6, 14, 18, 26})
    registry.add("bvh_kdop" + std::to_string(k), {},
                 [k](const MethodOptions&) { return make_bvh_kdop(k); });
}

}  // namespace selvedge
