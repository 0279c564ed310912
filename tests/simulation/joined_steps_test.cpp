// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/joined_steps.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace selvedge::joined_steps_test {
namespace {

using detail::JoinedSteps;

constexpr IntegratorTraits kFirstOrder{"", "", 1, true, true};

// A sheet of 0.5 m x 0.5 m and one of 2 m x 2 m, far from each other.
Scene two_sheets() {
  Scene scene;
  scene.name = "joined steps";
  scene.materials["default"] = Material{};
  for (const double size : {0.5, 2.0}) {
    ClothSpec spec;
    spec.name = size < 1.0 ? "small" : "large";
    spec.shape = ClothGrid{"rectangular", {size, size, 4, 4}};
    spec.placement.translation = Vec3(0, 0, size);
    scene.cloths.push_back(spec);
  }
  scene.time.steps_per_frame = 4;
  scene.time.step_error = 1e-3 * 16;  // 1e-3 for each step
  return scene;
}

TEST(JoinedSteps, TwoStepsOfAFrameAreOneWhereTheErrorAllows) {
  const Scene scene = two_sheets();
  const BuiltScene built = build_scene(scene);
  const JoinedSteps joined(scene, built, kFirstOrder);
  constexpr double kLimit = 2.0 * 1e-3 * 120.0 * 120.0;  // of the acceleration in a step of 1/120 s
  EXPECT_EQ(joined.span(8, 0.0), 2);
  EXPECT_EQ(joined.span(8, kLimit * 0.999), 2);
  EXPECT_EQ(joined.span(8, kLimit * 1.001), 1);
  EXPECT_EQ(joined.span(10, 0.0), 2);
  EXPECT_EQ(joined.span(11, 0.0), 1) << "a step ends with its frame";
  EXPECT_EQ(joined.span(8, -1.0), 1) << "unknown";
  EXPECT_EQ(joined.span(8, NAN), 1);
}

TEST(JoinedSteps, TwiceAsManyStepsPerFrameHalveEveryStep) {
  Scene scene = two_sheets();
  const BuiltScene built = build_scene(scene);
  const auto span = [&](int steps_per_frame, double acceleration) {
    scene.time.steps_per_frame = steps_per_frame;
    return JoinedSteps(scene, built, kFirstOrder).span(4 * steps_per_frame, acceleration);
  };
  constexpr double kLimit = 2.0 * 1e-3 * 16 * 30.0 * 30.0;
  for (const int steps_per_frame : {2, 4, 8, 64}) {
    EXPECT_EQ(span(steps_per_frame, kLimit * 1.001), 1) << steps_per_frame;
    EXPECT_EQ(span(steps_per_frame, kLimit * 0.999), 2) << steps_per_frame;
  }
  EXPECT_EQ(span(1, 0.0), 1);
}

TEST(JoinedSteps, TheFastestPieceCountsByItsOwnSize) {
  const Scene scene = two_sheets();
  const BuiltScene built = build_scene(scene);
  const JoinedSteps joined(scene, built, kFirstOrder);
  const auto n = static_cast<std::size_t>(built.piece_begin.back());
  const auto small = static_cast<std::size_t>(built.piece_begin[1]);
  const std::vector<Vec3> rest(n, Vec3::Zero());
  std::vector<Vec3> v = rest;
  for (std::size_t i = 0; i < small; ++i) v[i] = Vec3(0, 0.03, 0.04);
  EXPECT_NEAR(joined.acceleration(rest, v, 0.01), 0.05 / 0.01 / 0.5, 1e-12);
  v = rest;
  for (std::size_t i = small; i < n; ++i) v[i] = Vec3(0, 0.03, 0.04);
  EXPECT_NEAR(joined.acceleration(rest, v, 0.01), 0.05 / 0.01 / 2.0, 1e-12);
  EXPECT_EQ(joined.acceleration(v, v, 0.01), 0.0);
  v[small] = Vec3(1e300, 0, 0);  // its square overflows
  EXPECT_EQ(joined.acceleration(rest, v, 0.01), -1.0);
}

TEST(JoinedSteps, OnlyMethodsOfFirstOrderThatAreStableAtAnyStepJoin) {
  Scene scene = two_sheets();
  const BuiltScene built = build_scene(scene);
  const auto span = [&](int order, bool any_step, bool is_implicit) {
    return JoinedSteps(scene, built, {"", "", order, any_step, is_implicit}).span(8, 0.0);
  };
  EXPECT_EQ(span(1, true, true), 2);
  EXPECT_EQ(span(2, true, true), 1);
  EXPECT_EQ(span(1, false, true), 1);
  EXPECT_EQ(span(1, true, false), 1);
  scene.time.step_error = 0.0;
  EXPECT_EQ(span(1, true, true), 1);
}

// Lengths of the accepted steps of a scene, in steps of 1/120 s.
std::vector<int> spans(const Scene& scene, int frames) {
  Simulation simulation(scene);
  std::vector<int> spans;
  double time = 0.0;
  for (int frame = 1; frame <= frames; ++frame) {
    simulation.advance_to_frame(frame, [&](double now) {
      spans.push_back(static_cast<int>(std::lround((now - time) * 120.0)));
      time = now;
    });
    EXPECT_NEAR(time, frame / 60.0, 1e-12) << "a frame ends on time";
  }
  return spans;
}

// A sheet of `size` falls freely in the gravity g.
std::vector<int> spans_of_a_fall(double size, double g) {
  Scene scene = two_sheets();
  scene.cloths.resize(1);
  scene.cloths[0].shape = ClothGrid{"rectangular", {size, size, 4, 4}};
  scene.time.steps_per_frame = 2;
  scene.time.step_error = 1e-3 * 4;
  scene.solver.integrator = "implicit_euler";
  scene.gravity = Vec3(0, 0, -g);
  scene.contact.rest_gap *= size;
  return spans(scene, 4);
}

TEST(JoinedSteps, AFallOfAnySizeJoinsByItsAccelerationOverItsSize) {
  // h = 1/60 s: h² g/2 = 1.36 mm in the gravity of the earth, more than 1e-3 of 1 m.
  const std::vector<int> apart(8, 1), together = {1, 1, 2, 2, 2};
  for (const double size : {0.001, 1.0, 1000.0}) {
    EXPECT_EQ(spans_of_a_fall(size, 9.81 * size), apart) << size;
    EXPECT_EQ(spans_of_a_fall(size, 7.0 * size), together) << size;
  }
}

// A sheet on a plate: it falls 2 mm, then rests.
Scene landing() {
  Scene scene = two_sheets();
  scene.cloths.resize(1);
  scene.cloths[0].placement.translation = Vec3(0, 0, 0.004);
  BodySpec plate;
  plate.name = "plate";
  plate.shape = BodyShape{Box{Vec3(2, 2, 0.1)}, 3};
  plate.placement.translation = Vec3(0, 0, -0.1);
  scene.bodies.push_back(plate);
  scene.time.step_error = TimeSpec{}.step_error;
  scene.time.steps_per_frame = 2;
  return scene;
}

TEST(JoinedSteps, RestTakesOneStepAFrameAndARestoredRunTheSame) {
  const Scene scene = landing();
  const std::vector<int> all = spans(scene, 20);
  EXPECT_EQ(std::vector<int>(all.begin(), all.begin() + 2), (std::vector<int>{1, 1}));
  EXPECT_EQ(std::vector<int>(all.end() - 5, all.end()), std::vector<int>(5, 2));
  Simulation whole(scene), first(scene), second(scene);
  for (int frame = 1; frame <= 20; ++frame) whole.advance_to_frame(frame, {});
  for (int frame = 1; frame <= 19; ++frame) first.advance_to_frame(frame, {});
  second.restore(first.state());
  second.advance_to_frame(20, {});
  EXPECT_EQ(second.state().step, whole.state().step);
  EXPECT_EQ(state_hash(second.state()), state_hash(whole.state()));
}

}  // namespace
}  // namespace selvedge::joined_steps_test
