// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/detection/find.h>
#include <selvedge/detection/internal/contours.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/vertex_flags.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/tests/tangles.h>

#include <algorithm>
#include <array>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace selvedge::untangle_test {
namespace {

constexpr double kFastest = 5.0;  // m/s

void expect_free(TangleKind kind, unsigned seed) {
  const TangledScene tangled = make_tangle(kind, seed);
  SCOPED_TRACE(std::string(tangle_name(kind)) + " " + std::to_string(seed) + ": " + tangled.text);
  const TangleOutcome outcome = untangle(make_tangle(kind, seed), 60, 4);
  EXPECT_GT(outcome.start_pairs, 0);
  EXPECT_EQ(outcome.pairs, 0);
  EXPECT_GT(outcome.until_s, 0.0);
  EXPECT_LT(outcome.max_speed, kFastest);
  EXPECT_TRUE(outcome.only_shrinks);
  EXPECT_EQ(outcome.elsewhere, 0u);
  EXPECT_EQ(outcome.after, 0u);
  EXPECT_EQ(outcome.stopped, "");
  EXPECT_TRUE(outcome.result.clean);
}

TEST(Untangle, ABumpThroughASheetComesBackAndNothingElseIsCrossed) {
  expect_free(TangleKind::bump, 1);
  expect_free(TangleKind::bump, 9);
}

TEST(Untangle, TwoSheetsThatCrossFromBorderToBorderPart) {
  expect_free(TangleKind::layers, 2);
  expect_free(TangleKind::layers, 6);
}

TEST(Untangle, ASleeveSunkIntoTheArmComesOut) {
  expect_free(TangleKind::sleeve, 3);
  expect_free(TangleKind::sleeve, 167);
}

TEST(Untangle, ACornerThroughItsOwnSheetComesBack) { expect_free(TangleKind::corner, 4); }

/// Two triangles with one common corner, at the origin.
Scene corner_scene(const std::array<Vec3, 4>& ends) {
  Scene scene;
  scene.materials["default"] = Material{};
  ClothFile file;
  file.mesh = {{Vec3::Zero(), ends[0], ends[1], ends[2], ends[3]}, {{0, 1, 2}, {0, 3, 4}}};
  scene.cloths.emplace_back().shape = file;
  scene.contact.untangle_start = true;
  return scene;
}

/// Steps until nothing crosses, at most `seconds`. Returns whether the result is clean then.
bool gets_free(const Scene& scene, double seconds) {
  Simulation simulation(scene);
  while (simulation.state().time < seconds && !simulation.result().clean) simulation.step();
  return simulation.result().clean && simulation.result().tangle.start_pairs == 1 &&
         find_meetings(simulation.positions(), simulation.cloth_triangles()).empty();
}

TEST(Untangle, TrianglesThatCrossAtACommonCornerPart) {
  EXPECT_TRUE(gets_free(corner_scene({Vec3(1, 0, 0), {0, 1, 0}, {2, 0, 0}, {0, 2, 0}}), 3.0))
      << "one lies in the other";
  constexpr unsigned kSeed = 41;
  std::mt19937 engine(kSeed);
  std::uniform_real_distribution<double> draw(-0.5, 0.5);
  int crossing = 0;
  while (crossing < 20) {
    std::array<Vec3, 4> ends;
    for (Vec3& x : ends) x = Vec3(draw(engine), draw(engine), draw(engine));
    const std::vector<Vec3> x{Vec3::Zero(), ends[0], ends[1], ends[2], ends[3]};
    const std::vector<Triangle> triangles{{0, 1, 2}, {0, 3, 4}};
    if (find_meetings(x, triangles).crossings.empty()) continue;
    EXPECT_TRUE(gets_free(corner_scene(ends), 3.0)) << "pair " << crossing << ", seed " << kSeed;
    ++crossing;
  }
}

TEST(Untangle, TheBitsAreTheSameForAnyNumberOfThreads) {
  std::string hash;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    const TangleOutcome outcome = untangle(make_tangle(TangleKind::bump, 1), 60, 1, false);
    if (hash.empty()) hash = outcome.hash;
    EXPECT_EQ(outcome.hash, hash) << threads << " threads";
  }
}

Scene sheet_on_ball(double height) {
  Scene scene;
  scene.materials["default"] = Material{};
  scene.cloths.emplace_back().shape = ClothGrid{"rectangular", {0.3, 0.3, 10, 10}};
  scene.cloths[0].name = "sheet";
  scene.cloths[0].placement.translation = Vec3(0.01, 0.02, height);
  scene.bodies.emplace_back().shape = BodyShape{Sphere{0.1}, 16};
  scene.bodies[0].name = "ball";
  return scene;
}

// Explicit steps are many and short: what is not free after as many of them as implicit ones have
// is given up, but never said to be free, and nothing else is crossed.
TEST(Untangle, TheExplicitIntegratorGetsFreeOrStopsWithItsPairs) {
  for (const TangleKind kind : {TangleKind::bump, TangleKind::corner}) {
    TangledScene tangled = make_tangle(kind, kind == TangleKind::bump ? 1 : 4);
    tangled.scene.solver.integrator = "symplectic_euler";
    const TangleOutcome outcome = untangle(std::move(tangled), 4, 1);
    SCOPED_TRACE(tangle_name(kind));
    EXPECT_GT(outcome.start_pairs, 0);
    EXPECT_EQ(outcome.elsewhere, 0u);
    EXPECT_EQ(outcome.after, 0u);
    EXPECT_TRUE(outcome.only_shrinks);
    const bool free = outcome.pairs == 0;
    EXPECT_EQ(outcome.result.clean, free);
    if (!outcome.stopped.empty()) {
      EXPECT_NE(outcome.stopped.find("pairs of triangles cross"), std::string::npos);
    }
  }
}

TEST(Untangle, ASceneThatStartsCleanRunsToTheSameBits) {
  std::string hash;
  for (const bool untangle : {false, true}) {
    Scene scene = sheet_on_ball(0.11);
    scene.contact.untangle_start = untangle;
    Simulation simulation(scene, build_scene(scene));
    simulation.advance_to_frame(12, {});
    if (!untangle) hash = simulation.result().state_hash;
    EXPECT_EQ(simulation.result().state_hash, hash);
    EXPECT_EQ(simulation.result().tangle.start_pairs, 0);
  }
}

TEST(Untangle, ASceneThatDoesNotAskForItIsRefused) {
  const Scene scene = sheet_on_ball(0.02);
  EXPECT_THROW(Simulation(scene, build_scene(scene)), std::invalid_argument);
}

TEST(Untangle, ASheetThroughTheMiddleOfABallSlidesOffIt) {
  Scene scene = sheet_on_ball(0.0);
  scene.contact.untangle_start = true;
  Simulation simulation(scene, build_scene(scene));
  simulation.advance_to_frame(60, {});
  EXPECT_EQ(simulation.result().tangle.pairs, 0);
  EXPECT_TRUE(simulation.result().clean);
  EXPECT_LT(simulation.result().tangle.max_speed, kFastest);
}

TEST(Untangle, APieceInsideAClosedBodyIsRefusedByName) {
  Scene scene = sheet_on_ball(0.0);
  scene.contact.untangle_start = true;
  std::get<ClothGrid>(scene.cloths[0].shape).grid = {0.05, 0.05, 4, 4};
  try {
    Simulation(scene, build_scene(scene));
    FAIL() << "accepted";
  } catch (const std::invalid_argument& refusal) {
    const std::string said = refusal.what();
    EXPECT_NE(said.find("sheet"), std::string::npos) << said;
    EXPECT_NE(said.find("inside a closed body"), std::string::npos) << said;
  }
}

// A dent of the ball's surface pokes into the sheet within, which has no vertex outside: undoing
// that leaves the sheet inside, and to `check` its vertices are inside a closed body.
TEST(Untangle, ClothThatEndsInsideAClosedBodyIsNotCalledClean) {
  Scene scene;
  scene.materials["default"] = Material{};
  scene.gravity = Vec3::Zero();
  scene.contact.untangle_start = true;
  scene.cloths.emplace_back().shape = ClothGrid{"rectangular", {0.6, 0.6, 3, 3}};
  scene.cloths[0].name = "sheet";
  BodyFile cube;  // its upper side is a funnel that ends below the sheet
  cube.mesh = {{{-1, -1, -1},
                {1, -1, -1},
                {1, 1, -1},
                {-1, 1, -1},
                {-1, -1, 1},
                {1, -1, 1},
                {1, 1, 1},
                {-1, 1, 1},
                {0.01, 0.02, -0.05}},
               {{0, 2, 1},
                {0, 3, 2},
                {0, 1, 5},
                {0, 5, 4},
                {1, 2, 6},
                {1, 6, 5},
                {2, 3, 7},
                {2, 7, 6},
                {3, 0, 4},
                {3, 4, 7},
                {4, 5, 8},
                {5, 6, 8},
                {6, 7, 8},
                {7, 4, 8}}};
  scene.bodies.emplace_back().shape = cube;
  scene.bodies[0].name = "cube";
  Simulation simulation(scene, build_scene(scene));
  ASSERT_GT(simulation.result().tangle.start_pairs, 0);
  try {
    simulation.advance_to_frame(120, {});
    FAIL() << "went on";
  } catch (const SimulationFailed& failure) {
    const std::string said = failure.what();
    EXPECT_NE(said.find("sheet"), std::string::npos) << said;
    EXPECT_NE(said.find("inside a closed body, body \"cube\""), std::string::npos) << said;
  }
  EXPECT_FALSE(simulation.result().clean);
}

/// Goes on for `frames` frames from a copy of the state at `at` s, by a simulation of its own and
/// by the one that made it; both must end with the same bits, tangles and flags. `make` makes a
/// scene.
template <typename Make>
void expect_same_from_copy(const Make& make, double at, int frames, bool jam) {
  auto [scene, built] = make();
  Simulation first(scene, std::move(built));
  while (first.time() < at) first.step();
  const SimulationState copy = first.state();
  const auto& list = copy.tangles.list;
  ASSERT_TRUE(std::any_of(list.begin(), list.end(),
                          [&](const Tangle& t) { return !t.is_over() && t.jam == jam; }));
  auto [again, built_again] = make();
  Simulation second(again, std::move(built_again), copy);
  EXPECT_EQ(second.flags(), first.flags());
  const int end = static_cast<int>(at * scene.time.fps) + frames;
  first.advance_to_frame(end);
  second.advance_to_frame(end);
  EXPECT_EQ(state_hash(second.state()), state_hash(first.state()));
  EXPECT_EQ(second.flags(), first.flags());
  EXPECT_EQ(second.result().clean_elsewhere, first.result().clean_elsewhere);
  EXPECT_EQ(second.state().tangles.list.size(), first.state().tangles.list.size());
}

TEST(Untangle, ASimulationMadeFromAStateKeepsItsTangles) {
  const auto make = [] {
    TangledScene tangled = make_tangle(TangleKind::bump, 1);
    return std::pair(tangled.scene, std::move(tangled.built));
  };
  expect_same_from_copy(make, 0.05, 4, false);
}

// Two boxes close on the sheet until they overlap by 1 cm.
TEST(Untangle, ASimulationMadeFromAStateKeepsItsJams) {
  const auto make = [] {
    Scene scene;
    scene.materials["default"] = Material{};
    scene.gravity = Vec3::Zero();
    scene.contact.carry_tangled = true;
    scene.cloths.emplace_back().shape = ClothGrid{"rectangular", {0.2, 0.2, 8, 8}};
    scene.cloths[0].name = "sheet";
    scene.cloths[0].placement.translation = Vec3(0.003, 0.005, 0.0);
    for (const double side : {1.0, -1.0}) {
      BodySpec& box = scene.bodies.emplace_back();
      box.shape = BodyShape{Box{Vec3::Constant(0.1)}, 8};
      box.name = side > 0.0 ? "upper" : "lower";
      box.placement.translation = Vec3(0.0, 0.0, 0.08 * side);
      box.motion = {{.time = 0.0}, {.time = 0.2, .translation = Vec3(0.0, 0.0, -0.035 * side)}};
    }
    BuiltScene built = build_scene(scene);
    return std::pair(std::move(scene), std::move(built));
  };
  expect_same_from_copy(make, 0.19, 3, true);
}

// Both sheets held still at every vertex: no way can lead out.
Scene knotted() {
  Scene scene;
  scene.materials["default"] = Material{};
  scene.contact.untangle_start = true;
  for (const char* name : {"a", "b"}) {
    scene.cloths.emplace_back().shape = ClothGrid{"rectangular", {0.1, 0.1, 4, 4}};
    scene.cloths.back().name = name;
    HandleSpec& handle = scene.handles.emplace_back();
    handle.name = handle.geometry = name;
    for (std::int32_t i = 0; i < 25; ++i) handle.vertices.push_back(i);
  }
  scene.cloths[1].placement.rotation = Eigen::AngleAxisd(1.0, Vec3::UnitX());
  scene.cloths[1].placement.translation = Vec3(0.003, 0.004, 0.002);
  return scene;
}

TEST(Untangle, ARefusalCountsThePairsThatCrossAndNamesTheFirst) {
  Scene scene = knotted();
  scene.contact.untangle_start = false;
  const TriangleMesh cloth = build_scene(scene).cloth.surface;
  const std::vector<TrianglePair> pairs = find_crossings(cloth.vertices, cloth.triangles);
  ASSERT_FALSE(pairs.empty());
  const std::string expected = std::to_string(pairs.size()) +
                               " pairs of triangles cross, the first is triangle " +
                               std::to_string(pairs[0].triangle_a) + " of the cloth and triangle " +
                               std::to_string(pairs[0].triangle_b) + " of the cloth;";
  try {
    Simulation(scene, build_scene(scene));
    FAIL() << "accepted";
  } catch (const std::invalid_argument& refusal) {
    const std::string said = refusal.what();
    EXPECT_NE(said.find(expected), std::string::npos) << said << "\nexpected: " << expected;
  }
}

TEST(Untangle, ATangleThatRemainsStopsTheRunWithItsPairs) {
  const Scene scene = knotted();
  Simulation simulation(scene, build_scene(scene));
  try {
    simulation.advance_to_frame(600, {});
    FAIL() << "went on";
  } catch (const SimulationFailed& failure) {
    const std::string said = failure.what();
    EXPECT_NE(said.find("no way was found to untangle"), std::string::npos) << said;
    EXPECT_NE(said.find("pairs of triangles"), std::string::npos) << said;
  }
  EXPECT_TRUE(simulation.result().tangle.given_up);
  EXPECT_EQ(simulation.result().tangle.pairs, simulation.result().tangle.start_pairs);
  EXPECT_FALSE(simulation.result().clean);
}

TEST(Untangle, WhatCannotBeUndoneIsCarriedOnWhereTheSceneSaysSo) {
  Scene scene = knotted();
  scene.contact.carry_tangled = true;
  Simulation simulation(scene, build_scene(scene));
  simulation.advance_to_frame(300, {});
  const RunResult result = simulation.result();
  EXPECT_TRUE(result.tangle.given_up);
  EXPECT_GT(result.tangle.pairs, 0);
  EXPECT_EQ(result.tangle.elsewhere, 0);
  EXPECT_EQ(result.tangle.until_s, -1.0);
  EXPECT_FALSE(result.clean);
}

TEST(Untangle, ARunRestoredAmidATangleGivesTheSameBits) {
  TangledScene first = make_tangle(TangleKind::layers, 2),
               second = make_tangle(TangleKind::layers, 2);
  Simulation whole(first.scene, std::move(first.built));
  whole.advance_to_frame(4, {});
  const SimulationState state = whole.state();
  whole.advance_to_frame(20, {});
  Simulation resumed(second.scene, std::move(second.built));
  resumed.restore(state);
  resumed.advance_to_frame(20, {});
  EXPECT_EQ(resumed.result().state_hash, whole.result().state_hash);
  EXPECT_EQ(resumed.result().tangle.until_s, whole.result().tangle.until_s);
}

TEST(VertexFlags, OnlyTheSidesOfATangleAreFlaggedUntilItsEnd) {
  TangledScene tangled = make_tangle(TangleKind::corner, 4);
  Simulation simulation(tangled.scene, std::move(tangled.built));
  const std::vector<std::uint8_t> flags = simulation.flags();
  std::vector<char> in_tangle(flags.size(), 0);
  for (const Tangle& tangle : simulation.state().tangles.list)
    for (const auto& side : tangle.side)
      for (const std::int32_t t : side)
        for (const std::int32_t v : simulation.cloth_triangles()[t]) in_tangle[v] = 1;
  for (std::size_t i = 0; i < flags.size(); ++i)
    EXPECT_EQ(flags[i] & kFlagTangled, in_tangle[i] ? kFlagTangled : 0) << i;
  simulation.advance_to_frame(20, {});
  for (const std::uint8_t flag : simulation.flags()) EXPECT_EQ(flag & kFlagTangled, 0);
  EXPECT_EQ(simulation.result().flags.end[0], 0);
}

TEST(VertexFlags, OnlyAPointBetweenTwoBodiesIsPinched) {
  const ClothMesh cloth = make_rectangular({0.1, 0.1, 1, 1}, Material{});
  const auto on_body = [](std::int32_t point, const Vec3& normal) {
    ContactPoint c;
    c.vertex = {point, 4, 5, 6};
    c.weight = {1.0, -0.5, -0.25, -0.25};
    c.normal = normal;
    c.gap = 0.001;
    c.rest_gap = 0.002;
    return c;
  };
  const std::vector<ContactPoint> contacts = {on_body(0, Vec3::UnitZ()), on_body(1, Vec3::UnitZ()),
                                              on_body(0, -Vec3::UnitZ())};
  const auto flags =
      detail::vertex_flags({cloth, cloth.surface.vertices, contacts, {}, {}, false, 1e-3});
  EXPECT_EQ(flags, (std::vector<std::uint8_t>{kFlagPinched, 0, 0, 0}));
}

TEST(VertexFlags, TheEndsOfASpringBeyondItsLimitAreFlagged) {
  const ClothMesh cloth = make_rectangular({0.1, 0.1, 1, 1}, Material{});
  std::vector<Vec3> x = cloth.surface.vertices;
  x[0] -= Vec3(0.05, 0.0, 0.0);
  const auto flags = detail::vertex_flags({cloth, x, {}, {}, {}, false, 1e-3});
  EXPECT_EQ(flags[0], kFlagOverStrain);
  EXPECT_EQ(flags[1], kFlagOverStrain);
}

TEST(Contours, ASheetThroughAnotherLeavesOneContourThatCutsOffItsTip) {
  // A triangle whose tip goes through the middle of a larger one.
  const std::vector<Vec3> x = {{-1, -1, 0}, {2, -1, 0},    {-1, 2, 0},
                               {0, 0, -1},  {0.2, 0, 0.5}, {-0.2, 0, 0.5}};
  const std::vector<Triangle> triangles = {{0, 1, 2}, {3, 4, 5}};
  const JointSurface surface(6, 0, unique_edges(triangles), triangles, {}, {});
  std::vector<EdgeCrossing> crossings;
  for (std::size_t e = 0; e < surface.edges().size(); ++e)
    if (surface.edges()[e][0] == 3) crossings.push_back({static_cast<std::int32_t>(e), 0});
  const auto contours = trace_contours(surface, crossings);
  ASSERT_EQ(contours.size(), 1u);
  EXPECT_EQ(contours[0].nodes.size(), 2u);
  std::vector<std::int32_t> kept(surface.parts(), CutRegions::kUnknown);
  const CutRegions regions(surface, contours, x, kept);
  EXPECT_FALSE(regions.divides(0, 1));
  EXPECT_TRUE(regions.is_cut_off(0, 0, 3) || regions.is_cut_off(0, 0, 4));
  EXPECT_NE(regions.is_cut_off(0, 0, 3), regions.is_cut_off(0, 0, 4));
}

}  // namespace
}  // namespace selvedge::untangle_test
