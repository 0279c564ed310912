// SPDX-License-Identifier: MIT
// Values of single pairs of surfaces (contact.pairs): friction, rest gap, whether they collide.
#include <gtest/gtest.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace selvedge::pairs_test {
namespace {

constexpr double kGravity = 9.81;                  // m/s²
constexpr double kAngle = std::numbers::pi / 6.0;  // of the incline; its tangent is 0.577
constexpr int kCells = 4, kPiece = 25;             // particles of a sheet

/// A plane tilted by `angle` about y, so that cloth slides towards +x of the plane.
Scene incline(double angle) {
  Scene scene;
  scene.name = "pairs";
  scene.materials["default"] = Material{};
  BodySpec body;
  body.name = "plane";
  body.shape = BodyShape{Plane{20.0}, 16};
  body.placement.rotation = Eigen::AngleAxisd(angle, Vec3::UnitY());
  scene.bodies.push_back(body);
  return scene;
}

/// A sheet of 0.2 m parallel to the plane; `where` is in the plane's own axes.
void add_sheet(Scene& scene, const std::string& name, const Vec3& where) {
  ClothSpec spec;
  spec.name = name;
  spec.shape = ClothGrid{"rectangular", {0.2, 0.2, kCells, kCells}};
  spec.placement.rotation = scene.bodies[0].placement.rotation;
  spec.placement.translation = spec.placement.rotation * where;
  scene.cloths.push_back(spec);
}

/// Mean position of each sheet in the plane's axes after `frames`.
std::vector<Vec3> means_after(const Scene& scene, int frames) {
  Simulation simulation(scene, build_scene(scene));
  for (int frame = 1; frame <= frames; ++frame) simulation.advance_to_frame(frame, {});
  std::vector<Vec3> means(scene.cloths.size(), Vec3::Zero());
  for (std::size_t p = 0; p < means.size(); ++p)
    for (int i = 0; i < kPiece; ++i)
      means[p] += scene.bodies[0].placement.rotation.inverse() *
                  simulation.state().x[p * kPiece + i] / kPiece;
  return means;
}

TEST(Pairs, SaySomethingOnlyAboutThemselves) {
  Scene scene = incline(0.0);
  scene.materials["silk"].friction = 0.1;
  scene.materials["default"].friction = 0.4;
  for (const char* name : {"a", "b", "c"}) add_sheet(scene, name, Vec3::Zero());
  scene.cloths[1].material = scene.cloths[2].material = "silk";
  scene.bodies[0].friction = 0.7;
  scene.contact.pairs = {{"silk", "plane", 0.2, 0.005}, {"c", "a", 0.9, {}}, {"b", "b", {}, 0.001}};
  const ContactPairs pairs(scene);
  constexpr std::int32_t kA = 0, kB = 1, kC = 2, kPlane = 3;
  EXPECT_EQ(pairs.friction(kA, kPlane), 0.7);
  EXPECT_EQ(pairs.friction(kB, kPlane), 0.2);
  EXPECT_EQ(pairs.friction(kC, kPlane), 0.2);
  EXPECT_EQ(pairs.friction(kA, kB), 0.4);
  EXPECT_EQ(pairs.friction(kA, kC), 0.9);
  EXPECT_EQ(pairs.friction(kC, kA), 0.9);
  EXPECT_EQ(pairs.friction(kB, kC), 0.1);
  EXPECT_EQ(pairs.rest_gap(kA, kPlane), scene.contact.rest_gap);
  EXPECT_EQ(pairs.rest_gap(kC, kPlane), 0.005);
  EXPECT_EQ(pairs.rest_gap(kB, kB), 0.001);
  EXPECT_EQ(pairs.rest_gap(kB, kC), scene.contact.rest_gap);
  EXPECT_EQ(pairs.largest_rest_gap(), 0.005);
}

TEST(Pairs, TheLastOneThatMatchesCountsForEitherFieldByItself) {
  Scene scene = incline(0.0);
  add_sheet(scene, "a", Vec3::Zero());
  scene.contact.pairs = {
      {"default", "plane", 0.2, 0.005}, {"plane", "a", 0.5, {}}, {"a", "plane", {}, 0.004}};
  const ContactPairs pairs(scene);
  EXPECT_EQ(pairs.friction(0, 1), 0.5);
  EXPECT_EQ(pairs.rest_gap(0, 1), 0.004);
}

TEST(Pairs, AnUnknownNameIsRefusedInASceneMadeByHand) {
  Scene scene = incline(0.0);
  add_sheet(scene, "a", Vec3::Zero());
  scene.contact.pairs = {{"a", "plain", 0.2, {}}};
  EXPECT_THROW(build_scene(scene), std::invalid_argument);
  scene.contact.pairs = {{"a", "plane", -0.2, {}}};
  EXPECT_THROW(build_scene(scene), std::invalid_argument);
  scene.contact.pairs = {{"a", "plane", {}, 0.0}};
  EXPECT_THROW(build_scene(scene), std::invalid_argument);
}

TEST(Pairs, ASheetSticksToTheBodyOnWhichAnotherSlides) {
  Scene scene = incline(kAngle);
  scene.bodies[0].friction = 0.3;
  add_sheet(scene, "slides", {0.03, 0.02, 0.002});
  add_sheet(scene, "sticks", {0.03, 0.52, 0.002});
  scene.contact.pairs = {{"plane", "sticks", 0.8, {}}};
  const auto start = means_after(scene, 0), end = means_after(scene, 30);
  // s = a t² / 2 with a = g (sin - μ cos), t = 0.5 s
  const double way = 0.125 * kGravity * (std::sin(kAngle) - 0.3 * std::cos(kAngle));
  EXPECT_NEAR(end[0].x() - start[0].x(), way, 0.03 * way);
  EXPECT_LT(std::abs(end[1].x() - start[1].x()), 1e-4);
}

double way_of_a_sheet_on_a_sheet(const std::vector<PairSpec>& pairs) {
  Scene scene = incline(kAngle);
  scene.bodies[0].friction = 1.0;
  scene.materials["default"].friction = 1.0;
  add_sheet(scene, "lower", {0.03, 0.02, 0.002});
  add_sheet(scene, "upper", {0.04, 0.03, 0.004});
  scene.contact.pairs = pairs;
  const auto start = means_after(scene, 0), end = means_after(scene, 15);
  EXPECT_LT(std::abs(end[0].x() - start[0].x()), 1e-3);
  return end[1].x() - start[1].x();
}

TEST(Pairs, ASheetSlidesOnASheetToWhichItStuckByDefault) {
  EXPECT_LT(std::abs(way_of_a_sheet_on_a_sheet({})), 1e-3);
  EXPECT_GT(way_of_a_sheet_on_a_sheet({{"upper", "lower", 0.1, {}}}), 0.05);
}

TEST(Pairs, EachSheetRestsAtTheRestGapOfItsPair) {
  Scene scene = incline(0.0);
  add_sheet(scene, "thin", {0.03, 0.02, 0.01});
  add_sheet(scene, "thick", {0.03, 0.52, 0.01});
  add_sheet(scene, "on top", {0.04, 0.53, 0.02});
  scene.contact.pairs = {{"thick", "plane", {}, 0.004}, {"thick", "on top", {}, 0.003}};
  const auto end = means_after(scene, 60);
  EXPECT_NEAR(end[0].z(), 0.002, 5e-5);
  EXPECT_NEAR(end[1].z(), 0.004, 5e-5);
  EXPECT_NEAR(end[2].z(), 0.007, 3e-4);  // its rim hangs over
}

PairSpec apart(const char* a, const char* b) { return {a, b, {}, {}, false}; }

TEST(Pairs, AnExcludedPairIsExcludedInBothDirections) {
  Scene scene = incline(0.0);
  for (const char* name : {"a", "b", "c"}) add_sheet(scene, name, Vec3::Zero());
  scene.contact.pairs = {apart("default", "plane"), apart("c", "a"), {"b", "plane", 0.2, {}, true}};
  const ContactPairs pairs(scene);
  constexpr std::int32_t kA = 0, kB = 1, kC = 2, kPlane = 3;
  EXPECT_FALSE(pairs.collide(kA, kC));
  EXPECT_FALSE(pairs.collide(kC, kA));
  EXPECT_TRUE(pairs.collide(kA, kB));
  EXPECT_TRUE(pairs.collide(kA, kA));
  EXPECT_FALSE(pairs.collide(kA, kPlane));
  EXPECT_TRUE(pairs.collide(kB, kPlane));
  EXPECT_EQ(pairs.count(), 9);
  EXPECT_EQ(pairs.excluded().size(), 3u);
}

/// A sheet on a sheet on a plane, each 5 mm above the next.
Scene stack(const std::vector<PairSpec>& pairs) {
  Scene scene = incline(0.0);
  add_sheet(scene, "lower", {0.03, 0.02, 0.005});
  add_sheet(scene, "upper", {0.04, 0.03, 0.010});
  scene.contact.pairs = pairs;
  return scene;
}

TEST(Pairs, ASheetFallsThroughAnExcludedSheetWithAReport) {
  const Scene scene = stack({apart("upper", "lower")});
  Simulation simulation(scene, build_scene(scene));
  for (int frame = 1; frame <= 20; ++frame) simulation.advance_to_frame(frame, {});
  double lowest = 1.0, highest = -1.0;
  for (int i = 0; i < 2 * kPiece; ++i) {
    lowest = std::min(lowest, simulation.state().x[i].z());
    highest = std::max(highest, simulation.state().x[i].z());
  }
  EXPECT_GT(lowest, 0.0015);  // neither has passed through the plane
  EXPECT_LT(highest, 0.0025);
  EXPECT_GT(simulation.result().worst_self_intersections, 0);
  EXPECT_EQ(simulation.result().worst_body_intersections, 0);
}

TEST(Pairs, AnExcludedBodyStopsTheOtherSheetOnly) {
  const Scene scene = stack({apart("upper", "plane"), apart("upper", "lower")});
  const auto end = means_after(scene, 20);
  EXPECT_NEAR(end[0].z(), 0.002, 5e-5);
  EXPECT_LT(end[1].z(), -0.1);
}

TEST(Pairs, ExclusionOfWhatNeverMeetsChangesNoBit) {
  Scene scene = stack({});
  add_sheet(scene, "far", {0.03, 0.52, 0.005});
  const auto positions = [](const Scene& s) {
    Simulation simulation(s, build_scene(s));
    for (int frame = 1; frame <= 20; ++frame) simulation.advance_to_frame(frame, {});
    EXPECT_TRUE(simulation.result().clean);
    return simulation.state().x;
  };
  const std::vector<Vec3> all = positions(scene);
  scene.contact.pairs = {apart("far", "lower"), apart("far", "upper"), apart("far", "far")};
  EXPECT_EQ(all, positions(scene));
}

TEST(Pairs, ASceneThatExcludesClothFromItselfIsNotSearched) {
  const auto asked = [](const std::vector<PairSpec>& pairs) {
    const Scene scene = stack(pairs);
    Simulation simulation(scene, build_scene(scene));
    simulation.advance_to_frame(1, {});
    const auto& plan = simulation.result().plan;
    const auto part = plan.find("self_collision");
    return part == plan.end() ? std::int64_t{0} : part->second.asked;
  };
  EXPECT_GT(asked({apart("upper", "lower")}), 0);
  EXPECT_EQ(asked({apart("default", "default")}), 0);
}

}  // namespace
}  // namespace selvedge::pairs_test
