// SPDX-License-Identifier: MIT
// What a step leaves out because it is proved to do nothing: in shadow, the part is on and must
// have done nothing; with it and without it, states are the same to the bit.
#include <gtest/gtest.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/contacts/detail/idle_proofs.h>
#include <selvedge/simulation/detail/strain_reach.h>
#include <selvedge/simulation/internal/plan.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace selvedge::plan_test {
namespace {

/// A square metre of n x n cells.
TriangleMesh sheet(int n) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      mesh.vertices.emplace_back(static_cast<double>(i) / n, static_cast<double>(j) / n, 0.0);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const std::int32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

using Bend = std::function<Vec3(const Vec3&)>;

std::vector<Vec3> bent(const TriangleMesh& mesh, const Bend& bend) {
  std::vector<Vec3> x;
  for (const Vec3& p : mesh.vertices) x.push_back(bend(p));
  return x;
}

/// Rolled around the y axis by `angle` in all.
Vec3 rolled(const Vec3& p, double angle) {
  const double turn = angle * (p.x() - 0.5), radius = 1.0 / angle;
  return {radius * std::sin(turn), p.y(), radius * (1.0 - std::cos(turn))};
}

/// Least distance at t = 0 and whether any two primitives without common vertex collide.
struct Nearness {
  double least = 1e300;
  bool collide = false;
};
Nearness nearness(const TriangleMesh& mesh, const std::vector<Vec3>& x_t0,
                  const std::vector<Vec3>& x_t1) {
  const auto edges = unique_edges(mesh.triangles);
  const SurfaceView view{x_t0, x_t1, edges, mesh.triangles, 10.0};
  CandidatePairs pairs;
  make_brute_force()->find_self_pairs(view, pairs);
  std::vector<Contact> contacts;
  find_proximities(view, view, pairs, {.reach = 10.0}, contacts);
  Nearness n;
  for (const Contact& c : contacts) n.least = std::min(n.least, c.gap);
  make_ccd_exact()->find_contacts(view, view, pairs, contacts);
  n.collide = !contacts.empty();
  return n;
}

TEST(SheetProof, AFlatSheetKeepsApartByWhatItsTrianglesLeave) {
  const TriangleMesh mesh = sheet(8);
  detail::SheetProof proof(mesh.vertices, mesh.triangles);
  ASSERT_TRUE(proof.applies());
  EXPECT_NEAR(proof.nearest(), 0.125 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(nearness(mesh, mesh.vertices, mesh.vertices).least, proof.nearest(), 1e-12);
  EXPECT_TRUE(proof.keeps_apart(mesh.vertices, mesh.vertices, 0.99 * proof.nearest()));
  EXPECT_FALSE(proof.keeps_apart(mesh.vertices, mesh.vertices, 1.01 * proof.nearest()));
}

TEST(SheetProof, BendingIsProvedAndAClosingRollIsNot) {
  const TriangleMesh mesh = sheet(24);
  detail::SheetProof proof(mesh.vertices, mesh.triangles);
  for (const double turn : {0.1, 1.0, 2.0, 2.8}) {
    const auto x = bent(mesh, [&](const Vec3& p) { return rolled(p, turn); });
    EXPECT_TRUE(proof.keeps_apart(x, x, 0.1 * proof.nearest())) << turn;
  }
  for (const double turn : {4.0, 6.2}) {
    const auto x = bent(mesh, [&](const Vec3& p) { return rolled(p, turn); });
    EXPECT_FALSE(proof.keeps_apart(x, x, 0.0)) << turn;
  }
}

TEST(SheetProof, ItDoesNotMatterHowTheSheetIsTurned) {
  const TriangleMesh mesh = sheet(10);
  detail::SheetProof proof(mesh.vertices, mesh.triangles);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(any(random), any(random), any(random), any(random)).normalized();
    const auto x = bent(mesh, [&](const Vec3& p) { return Vec3(turn * rolled(p, 1.5)); });
    EXPECT_TRUE(proof.keeps_apart(x, x, 0.3 * proof.nearest()));
  }
}

TEST(SheetProof, WhatItSaysIsTrueOfRandomMotions) {
  const TriangleMesh mesh = sheet(6);
  detail::SheetProof proof(mesh.vertices, mesh.triangles);
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  int yes = 0, crossings = 0;
  for (int k = 0; k < 200; ++k) {
    const double rough = 0.001 * std::pow(10.0, 2.0 * (k % 20) / 19.0);
    const double roll = 0.2 + 0.1 * (k % 17);
    const auto move = [&](const Vec3& p) {
      return Vec3(rolled(p, roll) + rough * Vec3(noise(random), noise(random), noise(random)));
    };
    const auto x_t0 = bent(mesh, move), x_t1 = bent(mesh, move);
    const Nearness truth = nearness(mesh, x_t0, x_t1);
    crossings += truth.collide;
    for (const double share : {1e-6, 0.05, 0.2, 0.5}) {
      if (!proof.keeps_apart(x_t0, x_t1, share * proof.nearest())) continue;
      ++yes;
      EXPECT_FALSE(truth.collide) << k;
      EXPECT_GT(truth.least, share * proof.nearest()) << k;
    }
  }
  EXPECT_GT(yes, 100);
  EXPECT_GT(crossings, 10);
}

TEST(SheetProof, ShortStepsThatCloseARollAreNotAllProved) {
  const TriangleMesh mesh = sheet(8);
  detail::SheetProof proof(mesh.vertices, mesh.triangles);
  const auto at = [&](int k) {
    return bent(mesh, [&](const Vec3& p) { return rolled(p, 0.5 + 0.0025 * k); });
  };
  int yes = 0, again = 0;
  for (int k = 0; k < 2800; ++k) {
    const auto x_t0 = at(k), x_t1 = at(k + 1);
    const double distance = (k % 2 == 0 ? 0.02 : 1e-6) * proof.nearest();
    if (!proof.keeps_apart(x_t0, x_t1, distance)) continue;
    ++yes;
    detail::SheetProof anew(mesh.vertices, mesh.triangles);
    again += anew.keeps_apart(x_t0, x_t1, distance);
    if (k % 50 != 0) continue;
    const Nearness truth = nearness(mesh, x_t0, x_t1);
    EXPECT_FALSE(truth.collide) << k;
    EXPECT_GT(truth.least, distance) << k;
  }
  EXPECT_GT(yes, 500);
  EXPECT_LT(yes, 1500) << "a roll that is closed";
  EXPECT_EQ(again, yes) << "what is known from before is never more than what is proved anew";
}

TEST(SheetProof, AFoldedStateBesideAProvedOneIsNotProved) {
  const TriangleMesh mesh = sheet(6);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int yes = 0, folds = 0;
  for (int k = 0; k < 300; ++k) {
    detail::SheetProof proof(mesh.vertices, mesh.triangles);
    const double distance = 0.01 * proof.nearest(), rough = (k % 60 + 1) / 100.0 / 6.0;
    ASSERT_TRUE(proof.keeps_apart(mesh.vertices, mesh.vertices, distance));
    const auto x = bent(
        mesh, [&](const Vec3& p) { return Vec3(p + rough * Vec3(any(random), any(random), 0.0)); });
    const bool folded = nearness(mesh, mesh.vertices, x).collide;
    folds += folded;
    if (!proof.keeps_apart(mesh.vertices, x, distance)) continue;
    ++yes;
    EXPECT_FALSE(folded) << k;
  }
  EXPECT_GT(yes, 10);
  EXPECT_GT(folds, 10);
}

TEST(SheetProof, ATurningSheetKeepsItsDistanceAlongItsStartingDirections) {
  const TriangleMesh mesh = sheet(6);
  const auto edges = unique_edges(mesh.triangles);
  int yes = 0;
  for (int k = 0; k <= 30; ++k) {
    const Eigen::AngleAxisd turn(0.05 * k, Vec3::UnitY());
    const auto x = bent(mesh, [&](const Vec3& p) { return Vec3(turn * p); });
    const SurfaceView view{mesh.vertices, x, edges, mesh.triangles, 10.0};
    CandidatePairs pairs;
    make_brute_force()->find_self_pairs(view, pairs);
    std::vector<Contact> contacts;
    find_proximities(view, view, pairs, {.reach = 10.0}, contacts);
    double least = 1e300;
    for (const Contact& c : contacts) {
      Vec3 apart = Vec3::Zero();
      for (int i = 0; i < 4; ++i) apart += c.weight[i] * x[c.vertex[i]];
      least = std::min(least, c.normal.dot(apart));
    }
    for (const double share : {0.01, 0.3, 0.6}) {
      detail::SheetProof proof(mesh.vertices, mesh.triangles);
      if (!proof.keeps_apart(mesh.vertices, x, share * proof.nearest())) continue;
      ++yes;
      EXPECT_GE(least, share * proof.nearest()) << k;
    }
  }
  EXPECT_GT(yes, 10);
}

TEST(SheetProof, AFoldThatClosesOntoItselfIsNeverProved) {
  const TriangleMesh mesh = sheet(12);
  detail::SheetProof proof(mesh.vertices, mesh.triangles);
  // A half is folded over in one step.
  const auto folded =
      bent(mesh, [](const Vec3& p) { return p.x() <= 0.5 ? p : Vec3(1.0 - p.x(), p.y(), 1e-4); });
  EXPECT_FALSE(proof.keeps_apart(mesh.vertices, folded, 0.0));
  // The whole is turned inside out through a point.
  const auto inverted = bent(mesh, [](const Vec3& p) { return Vec3(1.0 - p.x(), 1.0 - p.y(), 0); });
  EXPECT_FALSE(proof.keeps_apart(mesh.vertices, inverted, 0.0));
}

TEST(SheetProof, NothingIsProvedOfSheetsThatAreNotFlatConvexOrWhole) {
  TriangleMesh hole = sheet(4), notch = sheet(4), bump = sheet(4), twice = sheet(4);
  hole.triangles.erase(hole.triangles.begin() + 10);
  notch.triangles.erase(notch.triangles.begin(), notch.triangles.begin() + 2);
  bump.vertices[12].z() = 0.01;
  twice.triangles.insert(twice.triangles.end(), twice.triangles.begin(), twice.triangles.end());
  for (const TriangleMesh& mesh : {hole, notch, bump, twice})
    EXPECT_FALSE(detail::SheetProof(mesh.vertices, mesh.triangles).applies());
}

TEST(SheetProof, AVertexInTheMiddleOfAnEdgeIsNotOverlooked) {
  // Two triangles on one side of the edge 0-1 meet at its middle 3, one on the other side does not.
  const std::vector<Vec3> x = {{0, 0, 0}, {2, 0, 0}, {1, -1, 0}, {1, 0, 0}, {0, 1, 0}, {2, 1, 0}};
  const std::vector<Triangle> whole = {{0, 3, 4}, {3, 5, 4}, {3, 1, 5}, {2, 1, 0}};
  const std::vector<Vec3> square = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {1, 1, 0}};
  // The square cut along a diagonal, one half cut again to its middle.
  const std::vector<Triangle> halves = {{0, 1, 2}, {0, 4, 3}, {4, 2, 3}};
  EXPECT_FALSE(detail::SheetProof(x, whole).applies());
  EXPECT_FALSE(detail::SheetProof(square, halves).applies());
}

// -- scenes ---------------------------------------------------------------------------------------

namespace fs = std::filesystem;

Scene scene_file(const std::string& file, std::vector<Override> overrides) {
  return read_scene(fs::path(SELVEDGE_SOURCE_DIR) / "data/scenes" / file, overrides);
}

RunResult run(Scene scene, bool proofs) {
  scene.plan.proofs = proofs;
  Simulation simulation(scene, build_scene(scene));
  for (int frame = 1; frame <= scene.time.frames; ++frame) simulation.advance_to_frame(frame, {});
  return simulation.result();
}

/// With proofs and without: the same bits; returns what was left out.
std::map<std::string, PlanFigures> left_out(const Scene& scene) {
  const RunResult with = run(scene, true), without = run(scene, false);
  EXPECT_EQ(with.state_hash, without.state_hash) << scene.name;
  EXPECT_EQ(with.steps, without.steps) << scene.name;
  EXPECT_EQ(with.counters.at("contacts"), without.counters.at("contacts")) << scene.name;
  EXPECT_EQ(with.clean, without.clean) << scene.name;
  EXPECT_EQ(with.max_stretch, without.max_stretch) << scene.name;
  EXPECT_EQ(with.strain_residual, without.strain_residual) << scene.name;
  for (const char* counter : {"strain_sweeps", "solver_iterations"})
    EXPECT_EQ(with.counters.contains(counter) ? with.counters.at(counter) : 0.0,
              without.counters.contains(counter) ? without.counters.at(counter) : 0.0)
        << scene.name << ": " << counter;
  EXPECT_EQ(with.worst_self_intersections, without.worst_self_intersections) << scene.name;
  EXPECT_EQ(with.worst_body_intersections, without.worst_body_intersections) << scene.name;
  for (const auto& [part, p] : without.plan) EXPECT_EQ(p.left_out, 0) << part;
  return with.plan;
}

TEST(Plan, AFlagSearchesNoContactWhileAHeightField) {
  const auto plan =
      left_out(scene_file("flag.json", {{"geometry.0.cells", "[16,16]"}, {"time.frames", "8"}}));
  EXPECT_FALSE(plan.contains("body_collision"));
  EXPECT_EQ(plan.at("self_collision").left_out, plan.at("self_collision").asked);
  EXPECT_EQ(plan.at("crossings_self").left_out, plan.at("crossings_self").asked);
  EXPECT_EQ(plan.at("crossings_self").asked, 9) << "the start and every frame";
}

TEST(Plan, WithoutSelfCollisionFramesOfAHeightFieldAreNotSearched) {
  const auto plan = left_out(scene_file(
      "flag.json",
      {{"geometry.0.cells", "[16,16]"}, {"time.frames", "8"}, {"contact.self", "false"}}));
  EXPECT_FALSE(plan.contains("self_collision"));
  EXPECT_EQ(plan.at("crossings_self").asked, 9) << "the start and every frame";
  EXPECT_EQ(plan.at("crossings_self").left_out, plan.at("crossings_self").asked);
}

TEST(Plan, AFallingSheetCostsNoNarrowPhaseBeforeTheSphere) {
  const Scene scene =
      scene_file("cloth_on_sphere.json", {{"geometry.0.cells", "[20,20]"},
                                          {"geometry.0.transformation.translation", "[0,0,1.0]"},
                                          {"obstacles.0.shape.resolution", "24"},
                                          {"time.frames", "6"}});
  const auto plan = left_out(scene);
  EXPECT_EQ(plan.at("self_collision").left_out, plan.at("self_collision").asked);
  EXPECT_EQ(plan.at("body_collision").left_out, plan.at("body_collision").asked);
  EXPECT_EQ(plan.at("crossings_body").left_out, plan.at("crossings_body").asked);
  EXPECT_GT(plan.at("strain_limit").left_out, plan.at("strain_limit").asked / 2)
      << "a sheet that falls is not stretched";
}

TEST(Plan, ContactEndsWhatWasLeftOut) {
  const Scene scene = scene_file("cloth_on_sphere.json", {{"geometry.0.cells", "[20,20]"},
                                                          {"obstacles.0.shape.resolution", "24"},
                                                          {"time.frames", "30"}});
  const PlanFigures bodies = left_out(scene).at("body_collision");
  EXPECT_GT(bodies.left_out, 0);
  EXPECT_LT(bodies.left_out, bodies.asked);
}

/// A strip that is blown onto itself.
TEST(Plan, AFoldThatClosesIsTheSameWithProofsAndWithout) {
  Scene scene = scene_file("flag.json", {{"geometry.0.cells", "[12,12]"}, {"time.frames", "40"}});
  scene.air.wind = {0.0, 25.0, 0.0};
  scene.air.normal_drag = 3.0;
  scene.gravity = {0.0, -30.0, -5.0};
  const PlanFigures self = left_out(scene).at("self_collision");
  EXPECT_GT(self.left_out, 0);
  EXPECT_LT(self.left_out, self.asked) << "it never folded: nothing was tried";
}

TEST(Plan, NothingIsProvedWhereTheNarrowPhaseMayRaiseFalseAlarms) {
  for (const auto& [name, make] : narrow_phases()) {
    const NarrowPhaseTraits traits = make.traits();
    Scene scene = scene_file("flag.json", {{"geometry.0.cells", "[6,6]"}, {"time.frames", "1"}});
    scene.contact.narrow_phase = name;
    const RunResult result = run(scene, true);
    EXPECT_EQ(result.plan.at("self_collision").left_out > 0,
              traits.misses_nothing && traits.no_false_alarm)
        << name;
  }
}

/// A sheet that lies on a sphere and folds: neither of the proofs by boxes and height fields holds.
TEST(Plan, AFrameIsSearchedWhereItsStepsProveNothing) {
  const auto searches = [](const char* narrow_phase, bool self) {
    Scene scene = scene_file("cloth_on_sphere.json", {{"geometry.0.cells", "[8,8]"},
                                                      {"obstacles.0.shape.resolution", "16"},
                                                      {"time.frames", "30"}});
    scene.contact.narrow_phase = narrow_phase;
    scene.contact.self = self;
    const PlanFigures body = run(scene, true).plan.at("crossings_body");
    EXPECT_EQ(body.asked, 31) << "the start and every frame";
    return body.asked - body.left_out;
  };
#ifdef SELVEDGE_VALIDATION
  EXPECT_GT(searches("ccd_exact", true), 10) << "a validation build trusts no proof";
#else
  EXPECT_LE(searches("ccd_exact", true), 2) << "the start and the last frame";
#endif
  EXPECT_GT(searches("ccd_exact", false), 10);
  EXPECT_GT(searches("ccd_cubic", true), 10);
}

TEST(Plan, SaysWhatIsNeverBuilt) {
  Scene scene = scene_file("flag.json", {});
  scene.air = {};
  std::map<std::string, PlanItem::Status> status;
  for (const PlanItem& item : plan_scene(scene, build_scene(scene), Methods{}))
    status[item.part] = item.status;
  EXPECT_EQ(status.at("wind and drag"), PlanItem::Status::never);
  EXPECT_EQ(status.at("bodies"), PlanItem::Status::never);
  EXPECT_EQ(status.at("gravity"), PlanItem::Status::runs);
  EXPECT_EQ(status.at("cloth with itself"), PlanItem::Status::when_needed);
}

TEST(Plan, AFoldThroughItselfIsSeenInTheFramesCheck) {
  Scene scene = scene_file("flag.json", {{"geometry.0.cells", "[8,8]"}, {"time.frames", "1"}});
  scene.handles.clear();
  scene.gravity = Vec3::Zero();
  scene.air = {};
  scene.contact.self = true;
  Simulation simulation(scene, build_scene(scene));
  simulation.verify_frame();
  EXPECT_EQ(simulation.result().worst_self_intersections, 0);
  SimulationState state = simulation.state();
  // The last row is pulled through the middle of the sheet.
  double low = state.x[0].z(), high = low, y = state.x[0].y();
  for (const Vec3& x : state.x) {
    low = std::min(low, x.z());
    high = std::max(high, x.z());
  }
  for (Vec3& x : state.x) {
    const double down = (high - x.z()) / (high - low);
    if (down > 0.99)
      x = Vec3(0.9 * x.x() + 0.011, y - 0.1, 0.45 * low + 0.55 * high);
    else if (down > 0.8)
      x.y() += 0.2;
  }
  simulation.restore(state);
  simulation.verify_frame();
  EXPECT_GT(simulation.result().worst_self_intersections, 0);
  EXPECT_FALSE(simulation.result().clean);
}

// -- strain ---------------------------------------------------------------------------------------

struct Springs {
  TriangleMesh mesh = sheet(6);
  std::vector<Spring> springs;
  Springs() {
    for (const Edge& e : unique_edges(mesh.triangles)) {
      Spring s;
      s.a = e[0];
      s.b = e[1];
      s.rest_length = (mesh.vertices[s.b] - mesh.vertices[s.a]).norm();
      springs.push_back(s);
    }
  }
  StrainLimiter limiter(double limit) const {
    return {springs, std::vector<double>(springs.size(), limit), mesh.vertices.size()};
  }
};

TEST(StrainReach, ACarriedSheetIsProvedAndAPulledOneIsNot) {
  const Springs sheet;
  const StrainLimiter limiter = sheet.limiter(0.1);
  detail::StrainReach reach(true, limiter);
  EXPECT_FALSE(reach.keeps_limits(sheet.mesh.vertices, LimitedStrain::stretch))
      << "nothing was measured";
  reach.measure(limiter, sheet.mesh.vertices);
  const auto carried = bent(sheet.mesh, [](const Vec3& p) { return Vec3(p + Vec3(1e3, -5, 2)); });
  EXPECT_TRUE(reach.keeps_limits(carried, LimitedStrain::stretch));
  const auto pulled = bent(sheet.mesh, [](const Vec3& p) { return Vec3(1.11 * p); });
  EXPECT_FALSE(reach.keeps_limits(pulled, LimitedStrain::stretch));
}

TEST(StrainReach, ASheetThatIsPushedTogetherExceedsLimitsOfCompressionOnly) {
  const Springs sheet;
  const StrainLimiter limiter = sheet.limiter(0.1);
  const auto pushed = bent(sheet.mesh, [](const Vec3& p) { return Vec3(0.88 * p); });
  for (const bool is_measured_there : {true, false}) {
    detail::StrainReach reach(true, limiter);
    reach.measure(limiter, is_measured_there ? pushed : sheet.mesh.vertices);
    EXPECT_FALSE(reach.keeps_limits(pushed, LimitedStrain::stretch_and_compression));
  }
  detail::StrainReach reach(true, limiter);
  reach.measure(limiter, pushed);
  EXPECT_TRUE(reach.keeps_limits(pushed, LimitedStrain::stretch));
}

TEST(StrainReach, AShortSpringPulledAlongItsLengthIsTheWorstCase) {
  // The bound is reached where the ends of the shortest spring move apart along it.
  const Spring spring{.a = 0, .b = 1, .rest_length = 1.0, .stiffness = 1.0};
  const StrainLimiter limiter(std::span(&spring, 1), std::vector<double>{0.1}, 2);
  for (const double strain : {0.02, 0.06, 0.09, 0.099, 0.101, 0.12, 0.15, 0.25})
    for (const Vec3& way : {Vec3(1, 0, 0), Vec3(1, 1, 1), Vec3(2, -1, 0.5)}) {
      const Vec3 u = way.normalized();
      const std::vector<Vec3> rest = {-0.5 * u, 0.5 * u};
      std::vector<Vec3> x = rest;
      for (Vec3& p : x) p *= 1.0 + strain;
      detail::StrainReach reach(true, limiter);
      reach.measure(limiter, rest);
      EXPECT_EQ(reach.keeps_limits(x, LimitedStrain::stretch), strain < 0.1) << strain;
    }
}

TEST(StrainReach, WhatItSaysIsTrueOfRandomMotions) {
  const Springs sheet;
  const StrainLimiter limiter = sheet.limiter(0.1);
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  int yes = 0, over = 0, compressed = 0;
  for (int k = 0; k < 400; ++k) {
    const double far = k % 3 == 0 ? 1e6 : 0.0;
    const double rough = 1e-5 * std::pow(10.0, 3.5 * (k % 20) / 19.0);
    const auto moved = [&](const std::vector<Vec3>& from, double size) {
      std::vector<Vec3> x = from;
      for (Vec3& p : x)
        p += Vec3(far, 0, 0) + size * Vec3(noise(random), noise(random), noise(random));
      return x;
    };
    detail::StrainReach reach(true, limiter);
    const auto measured = moved(sheet.mesh.vertices, 1e-3);
    reach.measure(limiter, measured);
    const auto x = moved(measured, rough);
    const StrainReport truth = limiter.measure(x);
    over += truth.excess > 0.0;
    for (const double below : {0.01, 0.03, 0.1})
      if (reach.keeps_below(x, below, 1.0)) {
        EXPECT_LE(truth.max_strain, below) << k;
      }
    compressed += truth.excess <= 0.0 && truth.compression_excess > 0.0;
    if (reach.keeps_limits(x, LimitedStrain::stretch_and_compression)) {
      EXPECT_LE(truth.compression_excess, 0.0) << k;
    }
    EXPECT_FALSE(reach.keeps_limits(x, LimitedStrain::any));
    if (!reach.keeps_limits(x, LimitedStrain::stretch)) continue;
    ++yes;
    EXPECT_LE(truth.excess, 0.0) << k;
    EXPECT_LE(truth.residual, 0.0) << k;
  }
  EXPECT_GT(yes, 100);
  EXPECT_GT(over, 20);
  EXPECT_GT(compressed, 0);
}

TEST(StrainReach, SwitchedOffItProvesNothing) {
  const Springs sheet;
  const StrainLimiter limiter = sheet.limiter(0.1);
  detail::StrainReach reach(false, limiter);
  reach.measure(limiter, sheet.mesh.vertices);
  EXPECT_FALSE(reach.keeps_limits(sheet.mesh.vertices, LimitedStrain::stretch));
  EXPECT_FALSE(reach.keeps_below(sheet.mesh.vertices, 1.0, 1.0));
}

TEST(ProofBackoff, WaitsLongerAfterEveryFailureAndNotAtAllAfterASuccess) {
  detail::ProofBackoff backoff;
  int tries = 0;
  for (int k = 0; k < 1000; ++k)
    if (backoff.is_due()) {
      ++tries;
      backoff.note(false);
    }
  EXPECT_LT(tries, 30);
  backoff.note(true);
  while (!backoff.is_due()) {
  }
  backoff.note(true);
  EXPECT_TRUE(backoff.is_due());
}

}  // namespace
}  // namespace selvedge::plan_test
