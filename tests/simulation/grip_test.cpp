// SPDX-License-Identifier: MIT
//
// Cloth that jaws grip: held cloth stays flat, and closed jaws hold what hangs from them.
#include <gtest/gtest.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/tests/grips.h>

#include <algorithm>

namespace selvedge::grip_test {
namespace {

// `bench grips` runs 120 of them.
class Grip : public ::testing::TestWithParam<unsigned> {};

GripScene scene_of(unsigned seed) {
  return make_grip(static_cast<GripKind>(seed % kGripKinds), seed / kGripKinds % 2 == 1, seed);
}

TEST_P(Grip, HeldClothStaysFlatAndClosedJawsHoldCloth) {
  const GripScene scene = scene_of(GetParam());
  EXPECT_EQ(grip_fault(scene, grip(scene)), "") << scene.text;
}

INSTANTIATE_TEST_SUITE_P(Seeds, Grip,
                         ::testing::Values(1U, 4U, 6U, 8U, 11U, 12U, 13U, 20U, 27U, 29U, 42U,
                                           113U));

TEST(Grips, AStateWithPinchedClothContinuesWithTheSameBits) {
  for (const unsigned seed : {1U, 55U}) {
    const GripScene grip = scene_of(seed);
    for (const double time : {grip.released, grip.parts}) {
      Simulation whole(grip.scene);
      const int half = static_cast<int>(time * grip.scene.time.fps) + 2;
      whole.advance_to_frame(half);
      ASSERT_FALSE(whole.state().pinches.empty());
      Simulation part(grip.scene, build_scene(grip.scene), whole.state());
      for (Simulation* simulation : {&whole, &part}) simulation->advance_to_frame(half + 6);
      EXPECT_EQ(whole.result().state_hash, part.result().state_hash) << seed << " at " << time;
    }
  }
}

TEST(Grips, ASavedStateWithAPinchOfNoVertexIsRefused) {
  const GripScene grip = scene_of(1);
  Simulation simulation(grip.scene);
  SimulationState state = simulation.state();
  state.pinches = {{.vertex = static_cast<std::int32_t>(state.x.size())}};
  EXPECT_THROW(simulation.restore(state), std::invalid_argument);
}

TEST(Grips, JawsAtATwentiethOfTheRestGapHoldAStripCleanly) {
  const Scene scene = read_scene(SELVEDGE_SOURCE_DIR "/data/extreme/grip.json");
  Simulation simulation(scene);
  simulation.advance_to_frame(31);
  const SimulationState held = simulation.state();
  EXPECT_GT(held.pinches.size(), 50U);
  simulation.advance_to_frame(47);
  for (const Pinch& pinch : held.pinches)
    EXPECT_LT((simulation.state().x[pinch.vertex] - held.x[pinch.vertex]).norm(), 1e-9);
  EXPECT_LT(simulation.result().max_stretch, 0.005);
  simulation.advance_to_frame(scene.time.frames);
  EXPECT_TRUE(simulation.state().pinches.empty());
  EXPECT_LT(simulation.state().x[18 * 9 + 4].z(), held.x[18 * 9 + 4].z() - 0.1);
  EXPECT_TRUE(simulation.result().clean);
}

// Contacts with the rims pushed the rows beside them along the cloth, by a whole rest gap.
TEST(Grips, JawsThatCloseCompletelyHardlyStretchWhatTheyPinch) {
  for (const unsigned seed : {29U, 49U, 57U, 81U, 113U}) {
    const GripScene scene = scene_of(seed);
    ASSERT_EQ(scene.kind, GripKind::closed);
    EXPECT_LT(grip(scene).stretch, 0.05) << seed << ": " << scene.text;
  }
}

// A rim that slides over cloth must not push it along, nor a surface that cloth leaves keep it. A
// step is repeated from 1.25 times the strain limit.
TEST(Grips, JawsThatShearWithEqualFrictionDoNotTearCloth) {
  for (const unsigned seed : {3U, 23U})
    for (const double share : {-0.35, 0.35}) {
      GripScene scene = scene_of(seed);
      ASSERT_EQ(scene.kind, GripKind::shears);
      BodySpec& jaw = scene.scene.bodies[0];
      scene.scene.bodies[1].friction = jaw.friction;
      const double tall = std::get<Box>(std::get<BodyShape>(jaw.shape).shape).size.z();
      for (Keyframe& key : jaw.motion)
        if (key.time > scene.released + 0.06) key.translation.z() += share * tall;
      scene.jaws = scene.scene.bodies;
      scene.leads = -1;
      const GripOutcome outcome = grip(scene);
      EXPECT_EQ(outcome.stopped, "");
      EXPECT_TRUE(outcome.result.clean_elsewhere);
      EXPECT_EQ(outcome.result.tangle.pairs, 0) << seed << ", " << share;
      EXPECT_LT(outcome.stretch, 1.25 * 0.1) << seed << ", " << share;
    }
}

// The row is held at a plane that a jaw passes: what is prescribed crosses.
TEST(Grips, AJawOverAHeldRowIsCountedAndTheRowFlagged) {
  for (const unsigned seed : {99U, 447U}) {
    const GripScene grip = scene_of(seed);
    Simulation simulation(grip.scene);
    simulation.advance_to_frame(static_cast<int>(grip.released * grip.scene.time.fps) - 1);
    const RunResult result = simulation.result();
    EXPECT_FALSE(result.clean) << seed;
    EXPECT_TRUE(result.clean_elsewhere) << seed;
    EXPECT_GT(result.counters.at("max_held_inside_bodies"), 0.0) << seed;
    const std::vector<std::uint8_t> flags = simulation.flags();
    const auto& row = grip.scene.handles[0].vertices;
    EXPECT_GE(std::count_if(row.begin(), row.end(),
                            [&](auto v) { return (flags[v] & kFlagPinched) != 0; }),
              static_cast<std::ptrdiff_t>(result.counters.at("max_held_inside_bodies")))
        << seed;
  }
  const GripScene apart = scene_of(1);
  Simulation simulation(apart.scene);
  simulation.advance_to_frame(static_cast<int>(apart.released * apart.scene.time.fps));
  EXPECT_EQ(simulation.result().counters.count("max_held_inside_bodies"), 0U);
}

TEST(Grips, PinchedVerticesAreFlagged) {
  const GripScene grip = scene_of(1);
  Simulation simulation(grip.scene);
  simulation.advance_to_frame(static_cast<int>(grip.released * grip.scene.time.fps) + 2);
  const std::vector<std::uint8_t> flags = simulation.flags();
  ASSERT_FALSE(simulation.state().pinches.empty());
  for (const Pinch& pinch : simulation.state().pinches)
    EXPECT_NE(flags[pinch.vertex] & kFlagPinched, 0) << pinch.vertex;
}

}  // namespace
}  // namespace selvedge::grip_test
