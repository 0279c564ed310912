// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/bvh.h>
#include <selvedge/core/parallel.h>
#include <selvedge/core/triangle_mesh.h>

#include <cmath>
#include <random>
#include <set>

using namespace selvedge;

namespace {

/// A surface that owns its arrays.
struct Surface {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  double thickness = 0.0;
  std::uint64_t static_id = 0;

  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, thickness, static_id}; }
};

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(engine_);
  }
  int integer(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(engine_); }
  Vec3 vector(double r) { return {uniform(-r, r), uniform(-r, r), uniform(-r, r)}; }

 private:
  std::mt19937 engine_;
};

/// A square sheet of n x n cells, folded into a box of side `box`, every vertex moving.
Surface crumpled(int n, double box, double speed, unsigned seed) {
  Random random(seed);
  Surface s;
  const auto fold = [box](double u) { return std::abs(std::remainder(u, 2.0 * box)); };
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double u = (i + 0.31 * j) / n, v = (j - 0.27 * i) / n;
      s.x_t0.push_back(Vec3(fold(u), fold(v), fold(0.3 * u + 0.2 * v)) + random.vector(0.2 / n));
    }
  const auto at = [n](int i, int j) { return j * (n + 1) + i; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  s.edges = unique_edges(s.triangles);
  for (const Vec3& x : s.x_t0) s.x_t1.push_back(x + random.vector(speed));
  s.thickness = 0.001;
  return s;
}

CandidatePairs self_pairs_of(BroadPhase& detector, const Surface& a) {
  CandidatePairs out;
  detector.find_self_pairs(a.view(), out);
  return out;
}

/// Skips every subtree whose root is in `depth` or deeper, and keeps what lies below each.
class SkipBelow final : public detail::SelfCull {
 public:
  using Groups = std::vector<std::set<std::int32_t>>;
  SkipBelow(int depth, Groups& groups) : depth_(depth), groups_(groups) {}

  void mark(const detail::BoundingVolumeTree& tree, const SurfaceView&,
            detail::SelfSkip& skip) override {
    groups_.clear();
    visit(tree, tree.root(), 0, skip);
  }
  BroadPhaseTraits traits() const override { return {.source = "a test"}; }

 private:
  void visit(const detail::BoundingVolumeTree& tree, std::int32_t child, int depth,
             detail::SelfSkip& skip) {
    if (depth == depth_) groups_.emplace_back();
    if (depth >= depth_) (child < 0 ? skip.leaves[~child] : skip.nodes[child]) = 1;
    if (child < 0) {
      if (depth < depth_) return;
      const detail::TreeLeaf& leaf = tree.leaf(~child);
      for (int i = 0; i < leaf.edges; ++i)
        groups_.back().insert(tree.edges(leaf)[i / detail::kLanes].id[i % detail::kLanes]);
      return;
    }
    for (const std::int32_t below : tree.node(child).child)
      if (below != detail::kNoChild) visit(tree, below, depth + 1, skip);
  }

  int depth_;
  Groups& groups_;
};

}  // namespace

TEST(SelfCull, LeavesOutExactlyThePairsInsideTheSubtreesItMarks) {
  const Surface s = crumpled(30, 0.15, 0.003, 1);
  const CandidatePairs all = self_pairs_of(*make_brute_force(), s);
  for (const int depth : {0, 1, 2, 3}) {
    SkipBelow::Groups groups;
    auto culled = detail::make_bvh_aabb({}, std::make_unique<SkipBelow>(depth, groups));
    std::vector<EdgeEdgePair> expected;
    const auto inside = [&](const EdgeEdgePair& p) {
      for (const auto& group : groups)
        if (group.contains(p.edge_a) && group.contains(p.edge_b)) return true;
      return false;
    };
    const CandidatePairs found = self_pairs_of(*culled, s);
    for (const EdgeEdgePair& p : all.edge_edge)
      if (!inside(p)) expected.push_back(p);
    EXPECT_EQ(found.edge_edge, expected) << "depth " << depth;
    EXPECT_LT(found.size(), all.size());
    EXPECT_EQ(found.size() == 0, depth == 0);
  }
}
