// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/compare/detectors/conformance.h>
#include <selvedge/core/base/types.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "broad_phase_trial.h"

namespace selvedge::verlet_list_test {
namespace {

/// A folded sheet that flows slowly.
struct FlowingSheet {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  double thickness = 0.002;

  explicit FlowingSheet(int n) {
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double u = static_cast<double>(i) / n;
        x_t1.push_back({std::abs(std::remainder(u, 0.5)), static_cast<double>(j) / n,
                        0.02 * std::sin(40.0 * u)});
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
        triangles.push_back({a, b, d});
        triangles.push_back({a, d, c});
      }
    edges = unique_edges(triangles);
    x_t0 = x_t1;
  }
  /// The next step; the fastest vertex moves by `distance`.
  void flow(double distance) {
    x_t0 = x_t1;
    for (Vec3& x : x_t1) x.z() += distance * std::sin(5.0 * x.x() + 7.0 * x.y());
  }
  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, thickness}; }
};

/// Counts the searches.
class Counting final : public BroadPhase {
 public:
  explicit Counting(int& searches) : searches_(searches) {}
  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    ++searches_;
    inner_->find_pairs(a, b, out);
  }
  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    ++searches_;
    inner_->find_self_pairs(a, out);
  }
  BroadPhaseTraits traits() const override { return inner_->traits(); }

 private:
  int& searches_;
  std::unique_ptr<BroadPhase> inner_ = make_bvh_aabb();
};

/// Says of itself what it is told.
class Claiming final : public BroadPhase {
 public:
  explicit Claiming(BroadPhaseTraits traits) : traits_(std::move(traits)) {}
  void find_pairs(const SurfaceView&, const SurfaceView&, CandidatePairs&) override {}
  void find_self_pairs(const SurfaceView&, CandidatePairs&) override {}
  BroadPhaseTraits traits() const override { return traits_; }

 private:
  BroadPhaseTraits traits_;
};

}  // namespace

TEST(VerletList, FindsWhatBruteForceFindsWithAnyMargin) {
  for (const double margin : {0.0, 0.003, 0.05, 10.0}) {
    const auto make = [margin] { return make_verlet_list(make_bvh_aabb(), {.margin = margin}); };
    const ConformanceReport report = check_conformance(make, {.scenes = 60, .touching = {}});
    EXPECT_TRUE(report.passed()) << "margin " << margin << "\n" << report.summary();
  }
}

TEST(VerletList, SeeksAnewOnlyWhenAVertexHasLeftItsBox) {
  int searches = 0;
  auto kept = make_verlet_list(std::make_unique<Counting>(searches), {.margin = 0.0095});
  auto brute = make_brute_force();
  FlowingSheet sheet(16);
  CandidatePairs found, right;
  std::vector<int> searches_after;
  for (int step = 0; step < 40; ++step) {
    sheet.flow(0.001);
    kept->find_self_pairs(sheet.view(), found);
    brute->find_self_pairs(sheet.view(), right);
    ASSERT_TRUE(same(found, right)) << "step " << step;
    ASSERT_GT(found.size(), 1000u);
    searches_after.push_back(searches);
  }
  // The first search covers the end of its step and nine more of at most a millimetre.
  EXPECT_EQ(searches_after[9], 1);
  EXPECT_EQ(searches_after[12], 2);
  EXPECT_LE(searches, 5);
}

TEST(VerletList, ASurfaceThatStandsStillNeedsNoMarginAndNoSearch) {
  int searches = 0;
  auto kept = make_verlet_list(std::make_unique<Counting>(searches), {.margin = 0.0});
  FlowingSheet sheet(10);
  CandidatePairs found;
  for (int step = 0; step < 10; ++step) kept->find_self_pairs(sheet.view(), found);
  EXPECT_EQ(searches, 1);
  EXPECT_GT(found.size(), 0u);
}

TEST(VerletList, ListsOfSeveralPairsOfSurfacesAreKeptAtOnce) {
  int searches = 0;
  auto kept = make_verlet_list(std::make_unique<Counting>(searches), {.margin = 0.02});
  auto brute = make_brute_force();
  FlowingSheet one(12), other(9);
  CandidatePairs found, right;
  for (int step = 0; step < 10; ++step) {
    one.flow(0.001);
    other.flow(0.001);
    kept->find_self_pairs(one.view(), found);
    brute->find_self_pairs(one.view(), right);
    ASSERT_TRUE(same(found, right));
    kept->find_pairs(one.view(), other.view(), found);
    brute->find_pairs(one.view(), other.view(), right);
    ASSERT_TRUE(same(found, right));
    kept->find_pairs(other.view(), one.view(), found);
    brute->find_pairs(other.view(), one.view(), right);
    ASSERT_TRUE(same(found, right));
  }
  EXPECT_EQ(searches, 3);
}

TEST(VerletList, TheMarginIsChosenAndNeverChangesThePairs) {
  int searches = 0;
  auto kept = make_verlet_list(std::make_unique<Counting>(searches));
  auto fresh = make_bvh_aabb();
  FlowingSheet sheet(20);
  CandidatePairs found, right;
  constexpr int steps = 300;
  for (int step = 0; step < steps; ++step) {
    sheet.flow(step < 200 ? 0.0002 : 0.01);
    kept->find_self_pairs(sheet.view(), found);
    fresh->find_self_pairs(sheet.view(), right);
    ASSERT_TRUE(same(found, right)) << "step " << step;
  }
  // Margins are tried at least, whatever they turn out to be worth on this machine.
  EXPECT_LT(searches, steps);
}

TEST(VerletList, AMarginThatBreaksTheBudgetIsGivenUp) {
  FlowingSheet sheet(16);
  sheet.flow(0.001);
  auto brute = make_brute_force();
  CandidatePairs right, found;
  brute->find_self_pairs(sheet.view(), right);
  auto kept = make_verlet_list(make_bvh_aabb(), {.margin = 1.0});  // Everything with everything.
  kept->set_budget({.pairs = right.size()});
  kept->find_self_pairs(sheet.view(), found);
  EXPECT_TRUE(same(found, right));
  kept->set_budget({.pairs = right.size() - 1});
  EXPECT_THROW(kept->find_self_pairs(sheet.view(), found), BudgetExceeded);
  EXPECT_EQ(found.size(), 0u);
}

TEST(VerletList, RefusesWhatItCannotKeepSafely) {
  const auto refused = [](const BroadPhaseTraits& traits, double margin) {
    EXPECT_THROW(make_verlet_list(std::make_unique<Claiming>(traits), {.margin = margin}),
                 std::invalid_argument);
  };
  refused({.guarantee = Guarantee::approximate, .source = ""}, 0.1);
  refused({.pairs = PairSet::culled, .source = ""}, 0.1);
  refused({.source = ""}, std::nan(""));
  refused({.source = ""}, std::numeric_limits<double>::infinity());
  EXPECT_NO_THROW(make_verlet_list(std::make_unique<Claiming>(
      BroadPhaseTraits{.pairs = PairSet::contains_boxes, .source = ""})));
}

TEST(VerletList, ABodyThatMovesRigidlyHasThePairsOfTheWorld) {
  // In the frame of the body other boxes overlap; a list of those would be used on for other steps.
  FlowingSheet sheet(20), body(24);
  const std::vector<Vec3> rest = body.x_t0;
  const auto list = make_verlet_list(make_bvh_aabb(), {.margin = 0.02});
  const auto brute = make_brute_force();
  CandidatePairs found, all;
  std::size_t pairs = 0;
  RigidMotion motion;
  motion.id = 5;
  for (int step = 0; step < 12; ++step) {
    sheet.flow(0.002);
    for (Pose* pose : {&motion.t0, &motion.t1}) {
      const double turn = 0.05 * (step + (pose == &motion.t1));
      pose->rotation << std::cos(turn), -std::sin(turn), 0, std::sin(turn), std::cos(turn), 0, 0, 0,
          1;
      pose->translation = Vec3(0.0, 0.0, 0.01 * turn);
      for (std::size_t i = 0; i < rest.size(); ++i)
        (pose == &motion.t0 ? body.x_t0 : body.x_t1)[i] =
            pose->rotation * rest[i] + pose->translation;
    }
    SurfaceView view = body.view();
    brute->find_pairs(sheet.view(), view, all);
    view.rigid = &motion;
    list->find_pairs(sheet.view(), view, found);
    EXPECT_TRUE(same(found, all)) << "step " << step;
    pairs += all.size();
  }
  EXPECT_GT(pairs, 1000u);
}

}  // namespace selvedge::verlet_list_test
