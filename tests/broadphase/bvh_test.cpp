// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/bvh.h>
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/broadphase/detail/leaf_groups.h>
#include <selvedge/broadphase/detail/sort_rows.h>
#include <selvedge/compare/detectors/conformance.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>
#include <selvedge/narrowphase/distance.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <set>

#include "broad_phase_trial.h"

namespace selvedge::bvh_test {
namespace {

using Surface = OwnedSurface;

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

/// Beside the surface one like it, of another size.
void add_scaled_copy(Surface& s, double scale) {
  const auto n = static_cast<std::int32_t>(s.x_t0.size());
  for (auto* x : {&s.x_t0, &s.x_t1})
    for (std::int32_t v = 0; v < n; ++v) x->push_back(Vec3(0.1, 0.05, 0.1) + scale * (*x)[v]);
  for (std::size_t t = 0, triangles = s.triangles.size(); t < triangles; ++t) {
    const auto [i, j, k] = s.triangles[t];
    s.triangles.push_back({i + n, j + n, k + n});
  }
  s.edges = unique_edges(s.triangles);
}

Vec3 at(const Surface& s, std::int32_t v, double t) {
  return (1.0 - t) * s.x_t0[v] + t * s.x_t1[v];
}

/// Do they come nearer than the sum of the thicknesses at one of some instants?
template <class Distance>
bool come_near(const Surface& a, const Surface& b, Distance distance) {
  constexpr int instants = 16;
  for (int i = 0; i <= instants; ++i)
    if (distance(i / static_cast<double>(instants)) < a.thickness + b.thickness) return true;
  return false;
}

bool point_comes_near(const Surface& a, std::int32_t point, const Surface& b,
                      std::int32_t triangle) {
  const Triangle& v = b.triangles[triangle];
  return come_near(a, b, [&](double t) {
    return point_triangle_closest(at(a, point, t), at(b, v[0], t), at(b, v[1], t), at(b, v[2], t))
        .distance;
  });
}

bool edge_comes_near(const Surface& a, std::int32_t edge_a, const Surface& b, std::int32_t edge_b) {
  const Edge &u = a.edges[edge_a], &v = b.edges[edge_b];
  return come_near(a, b, [&](double t) {
    return edge_edge_closest(at(a, u[0], t), at(a, u[1], t), at(b, v[0], t), at(b, v[1], t))
        .distance;
  });
}

/// Of the pairs in `boxes`, those that come near and are not in `found`; counts those that are.
std::size_t missed(const CandidatePairs& boxes, const CandidatePairs& found, const Surface& a,
                   const Surface& b, std::size_t& near) {
  std::size_t count = 0;
  const auto look = [&](bool comes_near, const auto& list, const auto& pair) {
    if (!comes_near) return;
    ++near;
    count += !std::binary_search(list.begin(), list.end(), pair);
  };
  for (const PointTrianglePair& p : boxes.point_triangle)
    look(point_comes_near(a, p.point, b, p.triangle), found.point_triangle, p);
  for (const PointTrianglePair& p : boxes.triangle_point)
    look(point_comes_near(b, p.point, a, p.triangle), found.triangle_point, p);
  for (const EdgeEdgePair& p : boxes.edge_edge)
    look(edge_comes_near(a, p.edge_a, b, p.edge_b), found.edge_edge, p);
  return count;
}

/// Puts a surface into two poses.
void pose(Surface& s, const std::vector<Vec3>& rest, const Pose& t0, const Pose& t1) {
  for (std::size_t i = 0; i < rest.size(); ++i) {
    s.x_t0[i] = t0.rotation * rest[i] + t0.translation;
    s.x_t1[i] = t1.rotation * rest[i] + t1.translation;
  }
  s.rigid.t0 = t0;
  s.rigid.t1 = t1;
}

Pose random_pose(Random& random, double angle, double reach) {
  Vec3 axis = random.vector(1.0);
  while (axis.norm() < 0.1) axis = random.vector(1.0);
  return {Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), random.vector(reach)};
}

Pose turned(const Pose& pose, Random& random, double angle, double reach) {
  const Pose turn = random_pose(random, angle, reach);
  return {turn.rotation * pose.rotation, pose.translation + turn.translation};
}

/// The box pairs whose polytopes overlap in double precision.
template <int axes>
CandidatePairs dop_pairs(const CandidatePairs& boxes, const SurfaceView& a, const SurfaceView& b) {
  CandidatePairs out = boxes;
  std::erase_if(out.point_triangle, [&](const PointTrianglePair& p) {
    return !detail::point_triangle_overlap<axes>(a, p.point, b, p.triangle);
  });
  std::erase_if(out.triangle_point, [&](const PointTrianglePair& p) {
    return !detail::point_triangle_overlap<axes>(b, p.point, a, p.triangle);
  });
  std::erase_if(out.edge_edge, [&](const EdgeEdgePair& p) {
    return !detail::edge_edge_overlap<axes>(a, p.edge_a, b, p.edge_b);
  });
  return out;
}

/// Calls visit(a, b) for every step of some of the scenes of the conformance kit.
template <class Visit>
void each_scene(std::uint64_t scenes, Visit visit) {
  for (std::uint64_t seed = 0; seed < scenes; ++seed) {
    ConformanceScene scene(seed);
    for (int step = 0; step < scene.step_count(); ++step) {
      if (step > 0) scene.advance();
      visit(scene.a(), scene.b());
      ASSERT_FALSE(::testing::Test::HasFailure()) << scene.description();
    }
  }
}

template <int axes>
void expect_exactly_dop_pairs(std::uint64_t scenes) {
  auto brute = make_brute_force();
  auto wide = make_bvh_kdop(2 * axes), narrow = make_bvh_kdop(2 * axes, {.wide_vectors = false});
  std::size_t found = 0, all = 0;
  each_scene(scenes, [&](const SurfaceView& a, const SurfaceView& b) {
    CandidatePairs boxes, out;
    brute->find_pairs(a, b, boxes);
    const CandidatePairs dops = dop_pairs<axes>(boxes, a, b);
    brute->find_self_pairs(a, boxes);
    const CandidatePairs self = dop_pairs<axes>(boxes, a, a);
    for (BroadPhase* detector : {wide.get(), narrow.get()}) {
      detector->find_pairs(a, b, out);
      EXPECT_TRUE(same(out, dops));
      detector->find_self_pairs(a, out);
      EXPECT_TRUE(same(out, self));
    }
    found += self.size();
    all += boxes.size();
  });
  EXPECT_GT(found, 10000u);
  EXPECT_LT(found, all);
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

TEST(Bvh, NoVolumeLosesAPairThatComesNear) {
  std::size_t near = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    Surface a = crumpled(10, 0.2 + 0.02 * seed, 0.03, seed);
    Surface b = crumpled(8, 0.25, 0.05, seed + 100);
    a.thickness = 0.004;
    b.thickness = 0.001 * seed;
    if (seed % 4 == 1) {
      add_scaled_copy(a, 1e-7);
      a.thickness = b.thickness = 1e-8;
    }
    if (seed % 3 == 2)
      for (Surface* s : {&a, &b})
        for (auto* xs : {&s->x_t0, &s->x_t1})
          for (Vec3& x : *xs) x += Vec3(1e6, -2e6, 3e5);
    auto brute = make_brute_force();
    const CandidatePairs self = self_pairs_of(*brute, a), pairs = pairs_of(*brute, a, b);
    for (const bool wide : {false, true}) {
      const BvhConfig config{.wide_vectors = wide, .leaf_size = seed % 2 ? 8 : 2};
      for (auto& detector : {make_bvh_kdop(14, config), make_bvh_kdop(18, config),
                             make_bvh_kdop(26, config), make_bvh_obb(config)}) {
        const CandidatePairs found = pairs_of(*detector, a, b);
        EXPECT_EQ(missed(pairs, found, a, b, near), 0u) << detector->traits().source;
        EXPECT_LT(found.size(), pairs.size());
        EXPECT_EQ(missed(self, self_pairs_of(*detector, a), a, a, near), 0u) << seed;
      }
    }
  }
  EXPECT_GT(near, 10000u);
}

TEST(Bvh, OrientedBoxesReportBoxPairsOnlyOnAnyNumberOfThreads) {
  const Surface a = crumpled(40, 0.2, 0.004, 3), b = crumpled(30, 0.22, 0.004, 4);
  auto brute = make_brute_force();
  const CandidatePairs boxes = pairs_of(*brute, a, b);
  CandidatePairs first;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    for (const bool wide : {false, true}) {
      auto detector = make_bvh_obb({.wide_vectors = wide});
      const CandidatePairs found = pairs_of(*detector, a, b);
      EXPECT_TRUE(std::includes(boxes.edge_edge.begin(), boxes.edge_edge.end(),
                                found.edge_edge.begin(), found.edge_edge.end()));
      if (first.size() == 0) first = found;
      EXPECT_TRUE(same(found, first)) << threads << " threads, wide " << wide;
      EXPECT_TRUE(same(pairs_of(*detector, a, b), first)) << "refitted";
    }
  }
  EXPECT_LT(first.size(), boxes.size());
  EXPECT_GT(first.size(), 1000u);
}

TEST(RigidFrame, NoPairThatComesNearIsLostHoweverTheBodyMoves) {
  std::size_t near = 0, found_in_all = 0;
  for (unsigned seed = 0; seed < 24; ++seed) {
    Random random(seed);
    Surface cloth = crumpled(8, 0.25, 0.02, seed), body = crumpled(7, 0.3, 0.0, seed + 50);
    cloth.thickness = 0.003;
    body.thickness = 0.002 * (seed % 3);
    const std::vector<Vec3> rest = body.x_t0;
    body.rigid.id = 7;
    const double angle = std::array{0.0, 1e-3, 0.1, 0.8, 1.5, 3.0}[seed % 6];
    const Vec3 far = seed % 4 == 3 ? Vec3(1e5, 2e5, -3e5) : Vec3::Zero();
    for (auto* xs : {&cloth.x_t0, &cloth.x_t1})
      for (Vec3& x : *xs) x += far;
    auto brute = make_brute_force();
    for (auto& detector : {make_bvh_aabb(), make_bvh_kdop(18), make_bvh_kdop(26), make_bvh_obb()}) {
      Pose now = random_pose(random, 0.0, 0.05);
      for (int step = 0; step < 3; ++step) {
        const Pose next = turned(now, random, angle, 0.05);
        pose(body, rest, {now.rotation, now.translation + far},
             {next.rotation, next.translation + far});
        const bool body_first = (seed + static_cast<unsigned>(step)) % 2 == 0;
        const Surface &a = body_first ? body : cloth, &b = body_first ? cloth : body;
        const CandidatePairs boxes = pairs_of(*brute, a, b);
        const CandidatePairs found = pairs_of(*detector, a, b);
        EXPECT_EQ(missed(boxes, found, a, b, near), 0u) << "seed " << seed << " step " << step;
        found_in_all += found.size();
        now = next;
      }
    }
  }
  EXPECT_GT(near, 10000u);
  EXPECT_LT(found_in_all, 20 * near);  // It does cull.
}

TEST(RigidFrame, TheTreeOfAMovingBodyIsNeitherRefittedNorRead) {
  Random random(1);
  Surface cloth = crumpled(10, 0.25, 0.01, 1), body = crumpled(60, 0.3, 0.0, 2);
  const std::vector<Vec3> rest = body.x_t0;
  body.rigid.id = 3;
  auto detector = make_bvh_aabb();
  Pose now = random_pose(random, 0.3, 0.1);
  pose(body, rest, now, now);
  const std::size_t first = pairs_of(*detector, cloth, body).size();
  EXPECT_GT(first, 100u);
  EXPECT_GT(detector->last_cost().build_s, 0.0);
  // The promise is believed: the positions are not read again, only the poses.
  for (Vec3& x : body.x_t0) x.setConstant(1e9);
  for (Vec3& x : body.x_t1) x.setConstant(1e9);
  EXPECT_EQ(pairs_of(*detector, cloth, body).size(), first);
  EXPECT_EQ(detector->last_cost().build_s, 0.0);
  body.rigid.t0.translation.z() += 10.0;
  body.rigid.t1.translation.z() += 10.0;
  EXPECT_EQ(pairs_of(*detector, cloth, body).size(), 0u);
  body.rigid.id = 4;
  EXPECT_EQ(pairs_of(*detector, cloth, body).size(), 0u);
}

TEST(RigidFrame, AMatrixThatIsNoRotationIsRefused) {
  Surface cloth = crumpled(3, 0.25, 0.01, 1), body = crumpled(3, 0.3, 0.0, 2);
  body.rigid.id = 3;
  auto detector = make_bvh_aabb();
  for (const Mat3& bad : {Mat3(1.001 * Mat3::Identity()), Mat3(-Mat3::Identity()),
                          Mat3(Mat3::Constant(std::nan("")))}) {
    body.rigid.t1.rotation = bad;
    EXPECT_THROW(pairs_of(*detector, cloth, body), std::invalid_argument);
  }
}

TEST(SortRows, SortsRowsOfAnyLengthWhateverLiesBehindThem) {
  Random random(1);
  std::vector<std::uint32_t> begin = {0}, second;
  std::vector<EdgeEdgePair> expected;
  for (std::uint32_t n = 0; n <= detail::kLongRow + 3; ++n) {
    std::set<std::uint32_t> row;
    while (row.size() < n) row.insert(static_cast<std::uint32_t>(random.integer(0, 2147483647)));
    std::vector<std::uint32_t> mixed(row.begin(), row.end());
    if (n <= detail::kLongRow)
      for (std::size_t i = mixed.size(); i > 1; --i)
        std::swap(mixed[i - 1], mixed[random.integer(0, static_cast<int>(i) - 1)]);
    second.insert(second.end(), mixed.begin(), mixed.end());
    begin.push_back(static_cast<std::uint32_t>(second.size()));
    for (const std::uint32_t s : row)
      expected.push_back({static_cast<std::int32_t>(n) + 5, static_cast<std::int32_t>(s)});
  }
  second.resize(second.size() + detail::kRowSlack, 0xfffffff0u);
  for (const auto sort :
       {detail::sort_rows_narrow<EdgeEdgePair>(), detail::sort_rows_wide<EdgeEdgePair>()}) {
    if (!sort) continue;
    std::vector<EdgeEdgePair> out(expected.size());
    sort({begin.data(), begin.size() - 1, second.data(), 5}, out.data());
    EXPECT_EQ(out, expected);
  }
}

TEST(PairCollector, SortsTheListsOfPartsOfAnySize) {
  Random random(6);
  constexpr std::uint64_t firsts = 3000, seconds = 5000;
  // Few pairs are sorted directly, others by buckets.
  for (const std::size_t pairs : {0, 900, 3000, 30000, 400000}) {
    std::set<std::uint64_t> keys;
    while (keys.size() < pairs)
      keys.insert(static_cast<std::uint64_t>(random.integer(0, firsts - 1)) << 32 |
                  static_cast<std::uint64_t>(random.integer(0, seconds - 1)));
    std::vector<detail::FoundPairs> parts(300);
    for (const std::uint64_t key : keys) {
      // Most pairs in a few parts, single ones in many, none in some.
      const int part = random.integer(0, 9) < 9 ? random.integer(40, 50) : random.integer(60, 250);
      detail::PairBuffer& list = parts[static_cast<std::size_t>(part)].edge_edge;
      std::uint64_t* at = list.room(1);
      *at++ = key;
      list.advance_to(at);
    }
    std::vector<EdgeEdgePair> expected;
    for (const std::uint64_t key : keys)
      expected.push_back({static_cast<std::int32_t>(key >> 32), static_cast<std::int32_t>(key)});
    for (const int threads : {1, 2, 8}) {
      const ThreadLimit limit(threads);
      detail::PairCollector collector;
      std::vector<EdgeEdgePair> out;
      collector.collect(parts, &detail::FoundPairs::edge_edge, firsts, seconds, out);
      EXPECT_EQ(out, expected) << pairs << " pairs, " << threads << " threads";
    }
  }
}

TEST(Bvh, PolytopesLeaveOutExactlyThePairsThatTheyKeepApart) {
  expect_exactly_dop_pairs<7>(60);
  expect_exactly_dop_pairs<9>(60);
  expect_exactly_dop_pairs<13>(60);
}

/// The primitives of each group, by kind.
struct Grouped {
  std::vector<std::set<std::int32_t>> triangles, edges, points;
  bool operator==(const Grouped&) const = default;
};

Grouped grouped(const Surface& s, int most) {
  const detail::LeafGroups groups(s.view(), most);
  Grouped out;
  for (auto* kind : {&out.triangles, &out.edges, &out.points}) kind->resize(groups.count());
  const auto add = [](auto& kind) {
    return [&](std::int32_t id, std::int32_t g) { EXPECT_TRUE(kind.at(g).insert(id).second); };
  };
  for (std::size_t c = 0; c < groups.chunk_count(); ++c) {
    groups.each_triangle(c, add(out.triangles));
    groups.each_edge(c, add(out.edges));
    groups.each_point(c, add(out.points));
  }
  EXPECT_TRUE(groups.loose_edges().empty());
  EXPECT_TRUE(groups.loose_points().empty());
  return out;
}

template <class Kind>
std::size_t total(const Kind& kind) {
  std::size_t sum = 0;
  for (const auto& ids : kind) sum += ids.size();
  return sum;
}

/// Each primitive is in one group, and each edge and point is part of a triangle of its group.
void expect_sound(const Grouped& all, const Surface& s, int most) {
  EXPECT_EQ(total(all.triangles), s.triangles.size());
  EXPECT_EQ(total(all.edges), s.edges.size());
  EXPECT_EQ(total(all.points), s.x_t0.size());
  for (std::size_t g = 0; g < all.triangles.size(); ++g) {
    EXPECT_FALSE(all.triangles[g].empty());
    EXPECT_LE(all.triangles[g].size(), static_cast<std::size_t>(most));
    const auto is_part = [&](auto... vertices) {
      return std::ranges::any_of(all.triangles[g], [&](std::int32_t t) {
        return (detail::contains(s.triangles[t], vertices) && ...);
      });
    };
    for (const std::int32_t e : all.edges[g]) EXPECT_TRUE(is_part(s.edges[e][0], s.edges[e][1]));
    for (const std::int32_t v : all.points[g]) EXPECT_TRUE(is_part(v));
  }
}

/// Gives the vertices, triangles and edges other numbers.
void shuffle_numbers(Surface& s, bool vertices, bool triangles, bool edges) {
  std::mt19937 random(3);
  std::vector<std::int32_t> name(s.x_t0.size());
  std::iota(name.begin(), name.end(), 0);
  if (vertices) std::shuffle(name.begin(), name.end(), random);
  for (Triangle& t : s.triangles)
    for (std::int32_t& v : t) v = name[v];
  for (Edge& e : s.edges) e = {name[e[1]], name[e[0]]};
  if (triangles) std::shuffle(s.triangles.begin(), s.triangles.end(), random);
  if (edges)
    std::shuffle(s.edges.begin(), s.edges.end(), random);
  else
    s.edges = unique_edges(s.triangles);
}

TEST(LeafGroups, HoldEachPrimitiveOnceWhateverTheOrderOfTheNumbers) {
  for (const int mixture : {0, 1, 2, 3, 4, 7}) {
    Surface s = crumpled(80, 0.3, 0.0, 5);
    shuffle_numbers(s, mixture & 1, mixture & 2, mixture & 4);
    for (const int most : {1, 5, 16, 24}) {
      SCOPED_TRACE(::testing::Message() << "mixture " << mixture << ", at most " << most);
      const Grouped all = grouped(s, most);
      expect_sound(all, s, most);
      // Well filled on the average; less so if the vertices are in no order.
      const double filled =
          static_cast<double>(s.triangles.size()) /
          static_cast<double>(all.triangles.size() * static_cast<std::size_t>(most));
      EXPECT_GE(filled, mixture & 1 ? 0.5 : most == 5 ? 0.75 : 0.95);
      for (const int threads : {1, 2, 8}) {
        const ThreadLimit limit(threads);
        EXPECT_EQ(grouped(s, most), all);
      }
    }
  }
}

TEST(LeafGroups, AVertexWithManyTrianglesHasSeveralGroups) {
  for (const bool last : {false, true}) {
    Surface s;
    constexpr int kSides = 200;
    const std::int32_t hub = last ? kSides : 0;
    s.x_t0.resize(kSides + 1, Vec3::Zero());
    for (int i = 0; i < kSides; ++i)
      s.triangles.push_back({hub, i + !last, (i + 1) % kSides + !last});
    s.close();
    for (const int most : {1, 16}) expect_sound(grouped(s, most), s, most);
  }
}

TEST(LeafGroups, ASurfaceOfPartsThatHangTogetherOrNotIsServedAlike) {
  // A mesh with a triangle soup, loose edges and points beside it, in three mixtures: leaves by the
  // topology, by the positions, and with too many edges for one owner.
  for (const int soup : {0, 5, 600}) {
    Surface s = crumpled(16, 0.3, 0.02, 11);
    Random random(static_cast<unsigned>(soup));
    for (int i = 0; i < soup; ++i) {
      const auto first = static_cast<std::int32_t>(s.x_t0.size());
      const Vec3 middle = random.vector(0.3);
      for (int k = 0; k < 5; ++k) {
        s.x_t0.push_back(middle + random.vector(0.05));
        s.x_t1.push_back(s.x_t0.back() + random.vector(0.02));
      }
      s.triangles.push_back({first, first + 1, first + 2});
      s.edges.push_back({first + 2, first + 3});
    }
    for (int i = 0; i < 30; ++i) s.edges.push_back(s.edges.front());
    const auto bvh = make_bvh_aabb();
    const auto brute = make_brute_force();
    for (int step = 0; step < 2; ++step) {
      const CandidatePairs found = self_pairs_of(*bvh, s), all = self_pairs_of(*brute, s);
      EXPECT_EQ(found.point_triangle, all.point_triangle) << soup << " parts, step " << step;
      EXPECT_EQ(found.edge_edge, all.edge_edge) << soup << " parts, step " << step;
      s.x_t0 = s.x_t1;
      for (Vec3& x : s.x_t1) x += random.vector(0.02);
    }
  }
}

TEST(Bvh, FindsTheSameWithAnyArityAndLeafSize) {
  auto brute = make_brute_force();
  std::vector<std::unique_ptr<BroadPhase>> shaped;
  for (const int arity : {2, 3, 4, 8})
    for (const int leaf_size : {1, 3, 8, 11, 24})
      shaped.push_back(make_bvh_aabb({.arity = arity, .leaf_size = leaf_size}));
  each_scene(40, [&](const SurfaceView& a, const SurfaceView& b) {
    CandidatePairs self, pairs, out;
    brute->find_self_pairs(a, self);
    brute->find_pairs(a, b, pairs);
    for (auto& detector : shaped) {
      detector->find_self_pairs(a, out);
      EXPECT_TRUE(same(out, self));
      detector->find_pairs(a, b, out);
      EXPECT_TRUE(same(out, pairs));
    }
  });
}

TEST(Bvh, RefusesShapesThatItCannotMake) {
  EXPECT_THROW(make_bvh_aabb({.arity = 1}), std::invalid_argument);
  EXPECT_THROW(make_bvh_aabb({.arity = 9}), std::invalid_argument);
  EXPECT_THROW(make_bvh_obb({.leaf_size = 0}), std::invalid_argument);
  EXPECT_THROW(make_bvh_kdop(14, {.leaf_size = 25}), std::invalid_argument);
  EXPECT_THROW(make_bvh_kdop(14, {.rebuild_quality_loss = 1.0}), std::invalid_argument);
  EXPECT_THROW(make_bvh_kdop(8), std::invalid_argument);
}

}  // namespace selvedge::bvh_test
