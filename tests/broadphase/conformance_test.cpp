// SPDX-License-Identifier: MIT
// Every registered detector through the conformance kit, and the kit through detectors that are
// broken on purpose.
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/compare/detectors/conformance.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/narrowphase/narrow_phase.h>
#include <selvedge/scene/methods.h>

#include <algorithm>
#include <iostream>
#include <set>

namespace selvedge::conformance_test {
namespace {

/// Distances are computed with roundings; a pair that counts as near is nearer than the thicknesses
/// by this part of them, far more than the roundings and far less than what matters.
constexpr double kSurelyNear = 1.0 - 1e-6;
/// They say so much only of coordinates that are not larger than this many reaches.
constexpr double kTrusted = 1e8;

bool near_at(const std::array<Vec3, 4>& x, ContactKind kind, double reach) {
  for (const Vec3& corner : x)
    if (!(corner.cwiseAbs().maxCoeff() <= kTrusted * reach)) return false;
  return reach > 0.0 &&
         (kind == ContactKind::edge_edge ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                         : point_triangle_closest(x[0], x[1], x[2], x[3]))
                 .distance < kSurelyNear * reach;
}

Query query_of(const SurfaceView& a, std::int32_t point, const SurfaceView& b, const Triangle& t) {
  const std::array<std::int32_t, 3> v = t;
  return {ContactKind::point_triangle,
          {a.x_t0[point], b.x_t0[v[0]], b.x_t0[v[1]], b.x_t0[v[2]]},
          {a.x_t1[point], b.x_t1[v[0]], b.x_t1[v[1]], b.x_t1[v[2]]}};
}

Query query_of(const SurfaceView& a, const Edge& e, const SurfaceView& b, const Edge& f) {
  return {ContactKind::edge_edge,
          {a.x_t0[e[0]], a.x_t0[e[1]], b.x_t0[f[0]], b.x_t0[f[1]]},
          {a.x_t1[e[0]], a.x_t1[e[1]], b.x_t1[f[0]], b.x_t1[f[1]]}};
}

/// Collides by the exact test, or is nearer than the thicknesses at the start or the end of the
/// step.
class ExactlyTouching {
 public:
  void operator()(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& boxes,
                  CandidatePairs& out) const {
    const double reach = a.thickness + b.thickness;
    keep(boxes.point_triangle, out.point_triangle, reach, [&](const PointTrianglePair& p) {
      return query_of(a, p.point, b, b.triangles[p.triangle]);
    });
    keep(boxes.triangle_point, out.triangle_point, reach, [&](const PointTrianglePair& p) {
      return query_of(b, p.point, a, a.triangles[p.triangle]);
    });
    keep(boxes.edge_edge, out.edge_edge, reach, [&](const EdgeEdgePair& p) {
      return query_of(a, a.edges[p.edge_a], b, b.edges[p.edge_b]);
    });
  }

 private:
  template <class Pair, class QueryOf>
  void keep(const std::vector<Pair>& pairs, std::vector<Pair>& out, double reach,
            QueryOf query_of_pair) const {
    for (const Pair& pair : pairs) {
      const Query query = query_of_pair(pair);
      double toi = 0.0;
      if (near_at(query.x_t0, query.kind, reach) || near_at(query.x_t1, query.kind, reach) ||
          exact_->collides(query, toi))
        out.push_back(pair);
    }
  }

  std::shared_ptr<NarrowPhase> exact_ = narrow_phases().at("ccd_exact")({});
};

/// Hands on to brute force; the faults are derived from it.
class Broken : public BroadPhase {
 public:
  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    exact_->find_pairs(a, b, out);
    spoil(out);
  }
  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    exact_->find_self_pairs(a, out);
    spoil(out);
  }
  BroadPhaseTraits traits() const override { return {.source = "broken on purpose"}; }

 protected:
  virtual void spoil(CandidatePairs& out) = 0;

 private:
  std::unique_ptr<BroadPhase> exact_ = make_brute_force();
};

/// Also hands on the budget.
class BrokenWithBudget : public Broken {
 public:
  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    Broken::find_pairs(a, b, out);
    keep_budget(out);
  }
  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    Broken::find_self_pairs(a, out);
    keep_budget(out);
  }

 private:
  void keep_budget(CandidatePairs& out) {
    const std::size_t limit = std::min(budget().pairs, budget().bytes / 8);
    if (out.size() <= limit) return;
    const std::size_t found = out.size();
    out.clear();
    throw BudgetExceeded(found, limit, budget());
  }
};

class Sound final : public BrokenWithBudget {
  void spoil(CandidatePairs&) override {}
};

class WithoutBudget final : public Broken {
  void spoil(CandidatePairs&) override {}
};

class Unsorted final : public BrokenWithBudget {
  void spoil(CandidatePairs& out) override {
    std::reverse(out.edge_edge.begin(), out.edge_edge.end());
  }
};

class Duplicating final : public BrokenWithBudget {
  void spoil(CandidatePairs& out) override {
    if (!out.point_triangle.empty()) out.point_triangle.push_back(out.point_triangle.back());
  }
};

/// Vectors of eight whose rest is not looked at.
class WithoutLastLane final : public BrokenWithBudget {
  void spoil(CandidatePairs& out) override {
    if (out.edge_edge.size() % 8 == 7) out.edge_edge.pop_back();
  }
};

class OneThreadTooMany final : public BrokenWithBudget {
  void spoil(CandidatePairs& out) override {
    if (thread_count() > 2 && out.size() > 40 && !out.edge_edge.empty()) out.edge_edge.pop_back();
  }
};

class TooMany final : public BrokenWithBudget {
 public:
  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    SurfaceView thicker = a;
    thicker.thickness += 0.01;
    BrokenWithBudget::find_pairs(thicker, b, out);
  }

 private:
  void spoil(CandidatePairs&) override {}
};

/// Fits its boxes to the first positions that it sees and forgets to fit them again when they move.
class WithoutRefit final : public BrokenWithBudget {
 public:
  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    if (triangles_.size() != a.triangles.size() || x_t0_.size() != a.x_t0.size() ||
        !std::equal(triangles_.begin(), triangles_.end(), a.triangles.begin())) {
      triangles_.assign(a.triangles.begin(), a.triangles.end());
      x_t0_.assign(a.x_t0.begin(), a.x_t0.end());
      x_t1_.assign(a.x_t1.begin(), a.x_t1.end());
    }
    SurfaceView stale = a;
    stale.x_t0 = x_t0_;
    stale.x_t1 = x_t1_;
    BrokenWithBudget::find_self_pairs(stale, out);
  }

 private:
  void spoil(CandidatePairs&) override {}

  std::vector<Triangle> triangles_;
  std::vector<Vec3> x_t0_, x_t1_;
};

/// Culls what it may not: all pairs of one vertex.
class CullsTooMuch final : public BrokenWithBudget {
 public:
  BroadPhaseTraits traits() const override {
    return {.pairs = PairSet::culled, .source = "broken"};
  }

 private:
  void spoil(CandidatePairs& out) override {
    std::erase_if(out.point_triangle, [](const PointTrianglePair& p) { return p.point == 1; });
  }
};

/// The same as an approximate one: no fault, but a recall.
class Approximate final : public BrokenWithBudget {
 public:
  BroadPhaseTraits traits() const override {
    return {.guarantee = Guarantee::approximate, .source = "broken"};
  }

 private:
  void spoil(CandidatePairs& out) override {
    std::erase_if(out.edge_edge, [](const EdgeEdgePair& p) { return p.edge_a % 2 == 0; });
  }
};

template <class Detector>
ConformanceReport report_of(std::size_t scenes = 80) {
  return check_conformance([] { return std::make_unique<Detector>(); },
                           {.scenes = scenes, .touching = ExactlyTouching()});
}

/// Sanitizers slow everything down by five and more.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::size_t kScenes = 200;
#else
constexpr std::size_t kScenes = 1000;
#endif

/// The kinds of faults, by their first words.
std::set<std::string> kinds(const ConformanceReport& report) {
  std::set<std::string> out;
  for (const ConformanceFault& fault : report.faults)
    out.insert(fault.what.substr(0, fault.what.find(':')));
  return out;
}

using Kinds = std::set<std::string>;

}  // namespace

namespace {

void expect_conformance(const BroadPhaseRegistry& detectors, std::size_t scenes) {
  for (const auto& [name, report] :
       check_conformance(detectors, {.scenes = scenes, .touching = ExactlyTouching()})) {
    std::cout << report.summary() << "\n";
    EXPECT_TRUE(report.passed()) << name;
    EXPECT_GT(report.scenes, scenes / 10) << name;
    EXPECT_GT(report.pairs, 10 * scenes) << name;
    EXPECT_GT(report.touching, scenes) << name;
  }
}

bool is_approximate(const BroadPhaseRegistry::value_type& entry) {
  return entry.second.traits().guarantee == Guarantee::approximate;
}

}  // namespace

TEST(Conformance, EveryDetectorIsRightOnAThousandScenes) {
  BroadPhaseRegistry detectors = broad_phases();
  detectors.erase("brute_force");  // The kit asks it anyway.
  detectors.erase_if(is_approximate);
  expect_conformance(detectors, kScenes);
}

/// They are slower in small scenes, and each has tests of its own. Detectors that answer particles
/// find few pairs in random scenes.
TEST(Conformance, AdaptersAreRightAndApproximateDetectorsTellTheirRecall) {
  BroadPhaseRegistry detectors = methods_of_this_build().broad_phases;
  const BroadPhaseRegistry ours = broad_phases();
  detectors.erase_if([&](const auto& entry) {
    return (ours.contains(entry.first) && !is_approximate(entry)) ||
           entry.second.traits().particles;
  });
  expect_conformance(detectors, kScenes / 20);
}

TEST(Conformance, BruteForceKeepsBudgetsAndRefusesWhatIsBad) {
  const ConformanceReport report =
      check_conformance(make_brute_force, {.scenes = 100, .touching = {}});
  EXPECT_TRUE(report.passed()) << report.summary();
}

TEST(ConformanceKit, PassesASoundDetector) {
  const ConformanceReport report = report_of<Sound>();
  EXPECT_TRUE(report.passed()) << report.summary();
  EXPECT_EQ(report.scenes, 80u);
  EXPECT_EQ(report.box_recall(), 1.0);
}

/// Counts how often it is asked.
class Asked final : public BrokenWithBudget {
 public:
  static inline int times = 0;

 private:
  void spoil(CandidatePairs&) override { ++times; }
};

TEST(ConformanceKit, LooksForTouchingPairsInFewScenesIfNoDetectorNeedsThem) {
  int looked = 0;
  Asked::times = 0;
  check_conformance([] { return std::make_unique<Asked>(); },
                    {.scenes = 80, .touching = [&](auto&&...) { ++looked; }});
  EXPECT_GT(looked, 0);
  EXPECT_LT(8 * looked, Asked::times);
}

TEST(ConformanceKit, WhatTouchesMayComeInAnyOrderAndTwice) {
  const auto twice = [](auto& pairs) {
    const auto all = pairs;
    std::reverse(pairs.begin(), pairs.end());
    pairs.insert(pairs.end(), all.begin(), all.end());
  };
  const ExactlyTouching exactly;
  const auto touching = [&](const SurfaceView& a, const SurfaceView& b, const CandidatePairs& boxes,
                            CandidatePairs& out) {
    exactly(a, b, boxes, out);
    twice(out.point_triangle);
    twice(out.triangle_point);
    twice(out.edge_edge);
  };
  const ConformanceReport report = check_conformance([] { return std::make_unique<Approximate>(); },
                                                     {.scenes = 80, .touching = touching});
  const ConformanceReport same = report_of<Approximate>();
  EXPECT_EQ(report.touching, same.touching);
  EXPECT_EQ(report.touching_recall(), same.touching_recall());
}

TEST(ConformanceKit, CatchesABoundLeftStale) {
  const ConformanceReport report = report_of<WithoutRefit>();
  EXPECT_TRUE(kinds(report).contains("lost")) << report.summary();
  EXPECT_GT(report.lost, 0u);
}

TEST(ConformanceKit, CatchesALostLane) {
  EXPECT_EQ(kinds(report_of<WithoutLastLane>()), Kinds{"lost"});
}

TEST(ConformanceKit, CatchesAnOrderThatIsNone) {
  EXPECT_EQ(kinds(report_of<Unsorted>()), Kinds{"not sorted"});
}

TEST(ConformanceKit, CatchesDuplicates) {
  EXPECT_EQ(kinds(report_of<Duplicating>()), Kinds{"duplicates"});
}

TEST(ConformanceKit, CatchesWhatDependsOnTheNumberOfThreads) {
  EXPECT_EQ(kinds(report_of<OneThreadTooMany>()), Kinds{"depends on the threads"});
}

TEST(ConformanceKit, CatchesPairsWhoseBoxesAreApart) {
  EXPECT_EQ(kinds(report_of<TooMany>()), Kinds{"boxes that do not overlap"});
}

TEST(ConformanceKit, CatchesABudgetThatIsNotKept) {
  EXPECT_EQ(kinds(report_of<WithoutBudget>(50)), Kinds{"budget"});
}

/// Serves closed bodies that keep their shape, and no others.
class WithoutBudgetForBodies final : public Broken {
 public:
  BroadPhaseTraits traits() const override {
    return {.self = false, .deforming = false, .closed_body_only = true, .source = "broken"};
  }

 private:
  void spoil(CandidatePairs&) override {}
};

TEST(ConformanceKit, TriesBudgetsOnTheFirstStepThatEveryDetectorSupports) {
  const ConformanceReport report = report_of<WithoutBudgetForBodies>();
  EXPECT_TRUE(kinds(report).contains("budget")) << report.summary();
  for (const ConformanceFault& fault : report.faults)
    EXPECT_TRUE(fault.step == 0 || !fault.what.starts_with("budget")) << fault.what;
}

TEST(ConformanceKit, CatchesACullOfWhatTouches) {
  EXPECT_EQ(kinds(report_of<CullsTooMuch>()), Kinds{"lost"});
}

TEST(ConformanceKit, TellsTheRecallOfAnApproximateDetector) {
  const ConformanceReport report = report_of<Approximate>();
  EXPECT_TRUE(report.passed()) << report.summary();
  EXPECT_LT(report.box_recall(), 0.9);
  EXPECT_GT(report.box_recall(), 0.4);
  EXPECT_LT(report.touching_recall(), 0.9);
}

namespace {

/// Adds up pieces; each must keep within the budget, be sorted, and have nothing twice in all.
class Gathered {
 public:
  explicit Gathered(std::size_t most) : most_(most) {}

  void operator()(const CandidatePairs& piece) {
    ASSERT_LE(piece.size(), most_);
    ASSERT_TRUE(std::is_sorted(piece.edge_edge.begin(), piece.edge_edge.end()));
    add(piece.point_triangle, all_.point_triangle);
    add(piece.triangle_point, all_.triangle_point);
    add(piece.edge_edge, all_.edge_edge);
  }
  CandidatePairs sorted() {
    std::sort(all_.point_triangle.begin(), all_.point_triangle.end());
    std::sort(all_.triangle_point.begin(), all_.triangle_point.end());
    std::sort(all_.edge_edge.begin(), all_.edge_edge.end());
    return all_;
  }

 private:
  template <class Pair>
  static void add(const std::vector<Pair>& from, std::vector<Pair>& to) {
    to.insert(to.end(), from.begin(), from.end());
  }
  std::size_t most_;
  CandidatePairs all_;
};

bool equal(const CandidatePairs& a, const CandidatePairs& b) {
  return a.point_triangle == b.point_triangle && a.triangle_point == b.triangle_point &&
         a.edge_edge == b.edge_edge;
}

}  // namespace

TEST(PairStream, DeliversTheWholeSetInPiecesOfAnySize) {
  auto brute = make_brute_force();
  auto bvh = make_bvh_aabb();
  std::uint64_t pieces = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const ConformanceScene scene(seed);
    CandidatePairs pairs, self;
    brute->find_pairs(scene.a(), scene.b(), pairs);
    brute->find_self_pairs(scene.a(), self);
    for (const std::size_t most : {self.size() / 20 + 5, self.size() + 1}) {
      const PairBudget piece{.pairs = most};
      Gathered of_pairs(most), of_self(most);
      const StreamedPairs done = stream_pairs(*bvh, scene.a(), scene.b(), piece, of_pairs);
      ASSERT_EQ(done.pairs, pairs.size()) << "seed " << seed;
      ASSERT_TRUE(equal(of_pairs.sorted(), pairs)) << "seed " << seed;
      pieces += done.pieces + stream_self_pairs(*bvh, scene.a(), piece, of_self).pieces;
      ASSERT_TRUE(equal(of_self.sorted(), self)) << "seed " << seed;
      EXPECT_EQ(bvh->budget().pairs, PairBudget().pairs);
    }
  }
  EXPECT_GT(pieces, 2000u);
}

TEST(PairStream, CutsDownToSinglePairsAndNoFurther) {
  const ConformanceScene scene(3);
  auto brute = make_brute_force();
  CandidatePairs self;
  brute->find_self_pairs(scene.a(), self);
  Gathered one_by_one(1);
  const StreamedPairs done = stream_self_pairs(*brute, scene.a(), {.pairs = 1}, one_by_one);
  EXPECT_EQ(done.pieces, self.size());
  EXPECT_TRUE(equal(one_by_one.sorted(), self));
  EXPECT_THROW(stream_self_pairs(*brute, scene.a(), {.pairs = 0}, one_by_one), BudgetExceeded);
}

TEST(PairStream, ASetBeyondEveryListIsRefusedQuicklyAndCanBeStreamed) {
  // Everything in one point: 30,000 vertices against 60,000 triangles would be 1.8·10^9 pairs.
  const std::vector<Vec3> x(30'000, Vec3(1, 2, 3));
  std::vector<Triangle> triangles;
  for (std::int32_t i = 0; i < 60'000; ++i)
    triangles.push_back({i % 29'998, i % 29'998 + 1, i % 29'998 + 2});
  const SurfaceView points{.x_t0 = x, .x_t1 = x, .edges = {}, .triangles = {}};
  const SurfaceView body{.x_t0 = x, .x_t1 = x, .edges = {}, .triangles = triangles};
  auto detector = make_bvh_aabb();
  detector->set_budget({.bytes = 20'000'000});
  CandidatePairs out;
  EXPECT_THROW(detector->find_pairs(points, body, out), BudgetExceeded);
  std::uint64_t seen = 0;
  struct Enough {};
  const auto count = [&](const CandidatePairs& piece) {
    seen += piece.size();
    if (seen > 3'000'000) throw Enough();  // A sink may end the stream by an exception.
  };
  EXPECT_THROW(stream_pairs(*detector, points, body, {.bytes = 20'000'000}, count), Enough);
  EXPECT_EQ(detector->budget().bytes, 20'000'000u);
}

TEST(ConformanceScene, IsTheSameForTheSameSeed) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    ConformanceScene one(seed), other(seed);
    for (int step = 0; step < one.step_count(); ++step) {
      if (step > 0) one.advance();
      if (step > 0) other.advance();
      ASSERT_EQ(one.description(), other.description());
      ASSERT_TRUE(std::equal(one.b().x_t1.begin(), one.b().x_t1.end(), other.b().x_t1.begin(),
                             other.b().x_t1.end()))
          << "seed " << seed;
    }
  }
}

TEST(ConformanceScene, KeepsThePromiseOfItsStaticIds) {
  std::map<std::uint64_t, std::vector<Vec3>> seen;
  std::size_t kept = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    ConformanceScene scene(seed);
    for (int step = 0; step < scene.step_count(); ++step) {
      if (step > 0) scene.advance();
      for (const SurfaceView& s : {scene.a(), scene.b()}) {
        if (s.static_id == 0) continue;
        const auto [place, is_new] =
            seen.try_emplace(s.static_id, std::vector<Vec3>(s.x_t1.begin(), s.x_t1.end()));
        if (!is_new) {
          ++kept;
          ASSERT_TRUE(
              std::equal(s.x_t1.begin(), s.x_t1.end(), place->second.begin(), place->second.end()))
              << "seed " << seed;
        }
      }
    }
  }
  EXPECT_GT(kept, 100u);
}

}  // namespace selvedge::conformance_test
