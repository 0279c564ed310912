// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/compare/detectors/compare_detectors.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "run_program.h"

namespace selvedge::detect_command_test {
namespace {

using namespace selvedge::testing;

/// A square sheet of n x n cells in the plane z = height, waved so that nothing is coplanar.
TriangleMesh sheet(int n, double height, double wave) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = static_cast<double>(i) / n, y = static_cast<double>(j) / n;
      mesh.vertices.emplace_back(x, y, height + wave * std::sin(9.0 * x + 1.0) * std::cos(7.0 * y));
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const std::int32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

/// One mesh made of two.
TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const auto n = static_cast<std::int32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Triangle& t : b.triangles) a.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  return a;
}

class DetectCommand : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    save("above.ply", sheet(8, 0.1, 0.01));
    save("through.ply", sheet(8, -0.05, 0.015));
    save("body.ply", sheet(6, 0.0, 0.01));
    save("two_0.ply", joined(sheet(5, 0.1, 0.01), sheet(5, 0.0, 0.02)));
    save("two_1.ply", joined(sheet(5, -0.1, 0.01), sheet(5, 0.0, 0.02)));
  }
  void save(const std::string& name, const TriangleMesh& mesh) const {
    write_ply(folder_ / name, mesh.vertices, mesh.triangles);
  }

  Json detect(const std::string& arguments) const {
    const Outcome o = run("detect --json --repeats 2 " + arguments);
    EXPECT_EQ(o.code, 0) << o.err;
    return Json::parse(o.out, nullptr, false);
  }
};

const std::string two_surfaces = "--a0 above.ply --a1 through.ply --b0 body.ply ";
const std::string one_surface = "--a0 two_0.ply --a1 two_1.ply ";

TEST_F(DetectCommand, EveryFieldIsThereForTwoSurfaces) {
  const Json j =
      detect(two_surfaces + "--b1 body.ply --broad-phase bvh_aabb,brute_force --threads 1");
  ASSERT_EQ(j["results"].size(), 2u);
  EXPECT_EQ(j["results"][0]["broad_phase"], "bvh_aabb");
  EXPECT_EQ(j["results"][1]["broad_phase"], "brute_force");
  for (const Json& r : j["results"]) {
    EXPECT_EQ(r["threads"], 1);
    EXPECT_GT(r["query_ms"].get<double>(), 0.0);
    EXPECT_GE(r["build_ms"].get<double>(), 0.0);
    EXPECT_GE(r["refit_ms"].get<double>(), 0.0);
    EXPECT_GT(r["point_triangle"], 0);
    EXPECT_GT(r["edge_edge"], 0);
    EXPECT_EQ(r["missed"], 0);
    EXPECT_EQ(r["recall"], 1.0);
    EXPECT_GE(r["peak_bytes"], 0);
    EXPECT_EQ(r["failure"], "");
    EXPECT_EQ(r["point_triangle"], j["reference"]["point_triangle"]);
    EXPECT_EQ(r["edge_edge"], j["reference"]["edge_edge"]);
  }
  EXPECT_GT(j["results"][0]["build_ms"].get<double>(), 0.0);
  ASSERT_EQ(j["contacts"].size(), 1u);
  const Json contact = j["contacts"][0];
  EXPECT_EQ(contact["narrow_phase"], "ccd_exact");
  EXPECT_GT(contact["contacts"], 0);
  EXPECT_EQ(contact["contacts"], j["reference"]["colliding"]);
  EXPECT_GT(contact["first_toi"].get<double>(), 0.3) << "the sheets meet at about 0.6";
  EXPECT_LT(contact["first_toi"].get<double>(), 0.9);
  EXPECT_GT(contact["ms"].get<double>(), 0.0);
}

TEST_F(DetectCommand, OneSurfaceIsTestedAgainstItself) {
  const Json j = detect(one_surface + "--broad-phase bvh_aabb --narrow-phase ccd_exact,ccd_cubic");
  EXPECT_GT(j["reference"]["colliding"], 0);
  EXPECT_EQ(j["results"][0]["recall"], 1.0);
  EXPECT_EQ(j["results"][0]["triangle_point"], 0);
  ASSERT_EQ(j["contacts"].size(), 2u);
  EXPECT_EQ(j["contacts"][0]["missed"], 0);
  EXPECT_EQ(j["contacts"][0]["false_alarms"], 0);
}

TEST_F(DetectCommand, AllRunsEveryDetectorOfTheBuildOrSaysWhyNot) {
  const Json listed = Json::parse(run("list --json").out, nullptr, false)["methods"];
  for (const std::string& surfaces : {two_surfaces, one_surface}) {
    const Json j = detect(surfaces + "--broad-phase all --narrow-phase all");
    std::multiset<std::string> met;
    for (const Json& r : j["results"]) {
      met.insert(r["broad_phase"]);
      EXPECT_EQ(r["failure"], "") << r["broad_phase"];
    }
    for (const Json& r : j["contacts"]) met.insert(r["narrow_phase"]);
    for (const Json& s : j["skipped"]) {
      met.insert(s["name"]);
      EXPECT_NE(s["why"], "");
    }
    for (const Json& method : listed) {
      if (method["family"] != "broad_phase" && method["family"] != "narrow_phase") continue;
      const std::size_t times = method["available"].get<bool>() ? 1 : 0;
      EXPECT_EQ(met.count(method["name"]), times) << method["name"];
    }
  }
}

TEST_F(DetectCommand, ThicknessAddsPairsAndThreadsDoNot) {
  const auto pairs = [&](const std::string& more) {
    const Json r = detect(two_surfaces + "--broad-phase bvh_aabb " + more)["results"][0];
    return r["point_triangle"].get<int>() + r["edge_edge"].get<int>();
  };
  EXPECT_GT(pairs("--thickness 0.03"), pairs(""));
  EXPECT_EQ(pairs("--threads 2"), pairs("--threads 1"));
}

TEST_F(DetectCommand, TheRecordingHoldsThePairsAndTheirAnswers) {
  const Json j = detect(two_surfaces + "--broad-phase bvh_aabb --record pairs");
  const Outcome o =
      run("ccd pairs.point_triangle.csv pairs.edge_edge.csv --json --narrow-phase ccd_exact");
  ASSERT_EQ(o.code, 0) << o.err;
  const Json results = Json::parse(o.out, nullptr, false)["results"];
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0]["queries"], j["reference"]["point_triangle"]);
  EXPECT_EQ(results[1]["queries"], j["reference"]["edge_edge"]);
  int positives = 0;
  for (const Json& r : results) {
    EXPECT_EQ(r["misses"], 0);
    EXPECT_EQ(r["false_alarms"], 0);
    EXPECT_EQ(r["late_toi"], 0);
    positives += r["positives"].get<int>();
  }
  EXPECT_EQ(positives, j["contacts"][0]["contacts"]);
}

TEST_F(DetectCommand, WithoutCollisionsThereIsNoFirstTimeAndNothingToMiss) {
  const Json j = detect("--a0 above.ply --a1 above.ply --b0 body.ply --broad-phase bvh_aabb");
  EXPECT_EQ(j["reference"]["colliding"], 0);
  EXPECT_EQ(j["results"][0]["recall"], 1.0);
  EXPECT_TRUE(j["contacts"][0]["first_toi"].is_null());
}

TEST_F(DetectCommand, TheTableNamesWhatWasMeasured) {
  const Outcome o = run("detect " + two_surfaces + "--repeats 1 --broad-phase bvh_aabb");
  EXPECT_EQ(o.code, 0) << o.err;
  for (const char* word : {"bvh_aabb", "recall", "refit ms", "ccd_exact", "first time"})
    EXPECT_SAYS(o.out, word);
  EXPECT_EQ(o.out.find("FAILURE"), std::string::npos);
}

// -- detectors that break their promises ----------------------------------------------------------

/// Brute force after which somebody changes the pairs or the promise.
class Spoilt final : public BroadPhase {
 public:
  using Change = std::function<void(CandidatePairs&, int call)>;
  Spoilt(BroadPhaseTraits traits, Change change) : traits_(traits), change_(std::move(change)) {}

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override {
    whole_->find_pairs(a, b, out);
    change_(out, calls_++);
  }
  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override {
    whole_->find_self_pairs(a, out);
    change_(out, calls_++);
  }
  BroadPhaseTraits traits() const override { return traits_; }

 private:
  std::unique_ptr<BroadPhase> whole_ = make_brute_force();
  BroadPhaseTraits traits_;
  Change change_;
  int calls_ = 0;
};

class DetectorJudge : public ::testing::Test {
 protected:
  DetectorScore judge(const BroadPhaseTraits& traits, const Spoilt::Change& change) const {
    DetectorTrial trial([&] { return std::make_unique<Spoilt>(traits, change); }, case_,
                        reference_);
    trial.measure();
    trial.measure();
    return trial.score();
  }

  TriangleMesh t0_ = joined(sheet(5, 0.1, 0.01), sheet(5, 0.0, 0.02));
  TriangleMesh t1_ = joined(sheet(5, -0.1, 0.01), sheet(5, 0.0, 0.02));
  std::vector<Edge> edges_ = unique_edges(t0_.triangles);
  SurfaceView view_{t0_.vertices, t1_.vertices, edges_, t0_.triangles, 0.0, 0};
  DetectionCase case_{view_, view_, true};
  ReferencePairs reference_ = reference_pairs(case_);
};

TEST_F(DetectorJudge, AnHonestDetectorKeepsItsPromise) {
  const DetectorScore s = judge({}, [](CandidatePairs&, int) {});
  EXPECT_EQ(s.failure, "");
  EXPECT_EQ(s.recall, 1.0);
  EXPECT_EQ(s.build_ms, 0.0) << "it does not measure";
  EXPECT_EQ(s.query_ms, s.wall_ms);
}

TEST_F(DetectorJudge, ALostCollisionIsAFailureOfAConservativeDetectorOnly) {
  const EdgeEdgePair lost = reference_.colliding.edge_edge.at(3);
  const auto lose = [&](CandidatePairs& pairs, int) { std::erase(pairs.edge_edge, lost); };
  DetectorScore s = judge({}, lose);
  EXPECT_EQ(s.missed, 1u);
  EXPECT_LT(s.recall, 1.0);
  EXPECT_NE(s.failure.find("missed 1"), std::string::npos) << s.failure;
  EXPECT_EQ(judge({.pairs = PairSet::culled}, lose).failure, s.failure);
  s = judge({.guarantee = Guarantee::approximate}, lose);
  EXPECT_EQ(s.missed, 1u);
  EXPECT_EQ(s.failure, "");
}

TEST_F(DetectorJudge, ACollisionLostInTheSecondCallIsAFailureToo) {
  const PointTrianglePair lost = reference_.colliding.point_triangle.at(0);
  const DetectorScore s = judge({}, [&](CandidatePairs& pairs, int call) {
    if (call == 1) std::erase(pairs.point_triangle, lost);
  });
  EXPECT_EQ(s.missed, 1u);
  EXPECT_NE(s.failure, "");
}

TEST_F(DetectorJudge, WhoReportsTheBoxesMustReportThemAllAndNoMore) {
  EdgeEdgePair apart = reference_.boxes.edge_edge.front();
  for (const EdgeEdgePair& p : reference_.boxes.edge_edge)
    if (!std::binary_search(reference_.colliding.edge_edge.begin(),
                            reference_.colliding.edge_edge.end(), p))
      apart = p;
  const auto lose = [&](CandidatePairs& pairs, int) { std::erase(pairs.edge_edge, apart); };
  EXPECT_NE(judge({}, lose).failure.find("left out 1"), std::string::npos);
  EXPECT_NE(judge({.pairs = PairSet::contains_boxes}, lose).failure, "");
  EXPECT_EQ(judge({.pairs = PairSet::culled}, lose).failure, "");
  const auto add = [](CandidatePairs& pairs, int) {
    pairs.point_triangle.push_back({100000, 100000});
  };
  EXPECT_NE(judge({}, add).failure.find("1 more"), std::string::npos);
  EXPECT_EQ(judge({.pairs = PairSet::contains_boxes}, add).failure, "");
}

TEST_F(DetectorJudge, WhatCannotServeTheCaseIsToldApart) {
  EXPECT_EQ(why_not({}, case_), "");
  EXPECT_NE(why_not({.self = false}, case_), "");
  EXPECT_NE(why_not({.deforming = false}, case_), "");
  EXPECT_NE(why_not({.closed_body_only = true}, case_), "");
  const TriangleMesh solid{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)},
                           {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  const std::vector<Edge> edges = unique_edges(solid.triangles);
  const SurfaceView rest{solid.vertices, solid.vertices, edges, solid.triangles, 0.0, 1};
  EXPECT_EQ(
      why_not({.self = false, .deforming = false, .closed_body_only = true}, {view_, rest, false}),
      "");
}

TEST_F(DetectCommand, WrongInputIsRefused) {
  write("nan.off", "OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n");
  write("index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n");
  write("empty.obj", "");
  write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write("other.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 3 2\n");
  write("more.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 1 1\nf 1 2 3\nf 1 2 4\n");
  EXPECT_REFUSED(run("detect --a0 nan.off --a1 one.obj"), "nan.off");
  EXPECT_REFUSED(run("detect --a0 one.obj --a1 index.off"), "index.off");
  EXPECT_REFUSED(run("detect --a0 empty.obj --a1 one.obj"), "empty.obj: is empty");
  EXPECT_REFUSED(run("detect --a0 one.obj --a1 none.obj"), "none.obj: no such file");
  EXPECT_REFUSED(run("detect --a0 one.obj --a1 more.obj"), "more.obj: has 4 vertices");
  EXPECT_REFUSED(run("detect --a0 one.obj --a1 other.obj"), "other.obj: its triangle 0 is not");
  EXPECT_REFUSED(run("detect --a0 one.obj --a1 one.obj --b1 one.obj"), "--b1 needs --b0");
  const std::string good = "detect --a0 one.obj --a1 one.obj ";
  EXPECT_EQ(run(good + "--repeats 1").code, 0) << "one triangle is a surface";
  EXPECT_REFUSED(run(good + "--broad-phase magic"), "there is no \"magic\" in this build");
  EXPECT_REFUSED(run(good + "--narrow-phase bvh_aabb"), "there is no \"bvh_aabb\"");
  EXPECT_REFUSED(run(good + "--record none/x"), "there is no such folder");
  for (const char* bad : {"--thickness -1", "--thickness nan", "--repeats 0", "--threads -1"})
    EXPECT_EQ(run(good + bad).code, 2) << bad;
  EXPECT_EQ(run("detect --a0 one.obj").code, 2);
}

}  // namespace

}  // namespace selvedge::detect_command_test
