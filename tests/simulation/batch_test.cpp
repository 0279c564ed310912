// SPDX-License-Identifier: MIT
// Many scenes stepped together: the bits of single runs, single members, failures, memory.
#include <gtest/gtest.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/batch.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <numeric>
#include <string>

namespace selvedge::batch_test {
namespace {

using Scenes = std::vector<std::shared_ptr<const Scene>>;

Scene sheet_over(const BodyShape& body, int cells) {
  Scene scene;
  scene.materials["default"] = {.density = 0.15, .bending_stiffness = 2e-5};
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "cloth";
  cloth.shape =
      ClothGrid{.grid = {.size_x = 0.4, .size_y = 0.4, .cells_x = cells, .cells_y = cells}};
  cloth.placement.translation = {0.01, 0.02, 0.205};
  BodySpec& spec = scene.bodies.emplace_back();
  spec.name = "body";
  spec.shape = body;
  scene.time.frames = 30;
  return scene;
}

Scene ball_scene() { return sheet_over({Sphere{.radius = 0.2}, 16}, 10); }

/// Scenes that differ in what a simulation carries from step to step.
std::vector<Scene> mixed_scenes() {
  std::vector<Scene> scenes;
  scenes.push_back(ball_scene());
  Scene& moving = scenes.emplace_back(sheet_over({Box{Vec3(0.3, 0.3, 0.4)}, 3}, 8));
  moving.bodies[0].motion = {
      {.time = 0.0}, {.time = 0.05}, {.time = 0.15, .translation = Vec3(0.05, 0.0, 0.02)}};
  Scene& verlet = scenes.emplace_back(ball_scene());
  verlet.solver.integrator = "verlet";
  verlet.materials["default"].spring_damping = 0.0;
  verlet.materials["default"].stretch_stiffness = 20.0;
  Scene& euler = scenes.emplace_back(ball_scene());
  euler.solver.integrator = "implicit_euler";
  euler.contact.response = "impulse";
  Scene& two = scenes.emplace_back(ball_scene());
  two.cloths.push_back(two.cloths[0]);
  two.cloths[1].name = "upper";
  two.cloths[1].placement.translation.z() += 0.01;
  Scene& refined = scenes.emplace_back(ball_scene());
  std::get<ClothGrid>(refined.cloths[0].shape).refine = {.when = RefineSpec::When::curved,
                                                         .angle_deg = 6.0};
  Scene& tangled = scenes.emplace_back(ball_scene());
  tangled.contact.untangle_start = true;
  tangled.cloths[0].placement.translation.z() = 0.19;
  Scene& sleeping = scenes.emplace_back(sheet_over({Box{Vec3(1.0, 1.0, 0.4)}, 3}, 6));
  sleeping.cloths[0].placement.translation.z() = 0.2 + 1.1 * sleeping.contact.rest_gap;
  sleeping.time.sleep_speed = 0.1;
  sleeping.time.fps = 15.0;  // twelve frames are longer than cloth has to be still
  sleeping.time.steps_per_frame = 8;
  return scenes;
}

std::string hash_of_single(const Scene& scene, int frames) {
  Simulation simulation(scene);
  simulation.advance_to_frame(frames);
  return state_hash(simulation.state());
}

std::vector<std::string> hashes(Batch& batch) {
  std::vector<std::string> found;
  for (std::size_t k = 0; k < batch.size(); ++k)
    found.push_back(state_hash(batch.member(k).state()));
  return found;
}

TEST(Batch, SixtyFourMixedMembersHaveTheBitsOfSingleRuns) {
  const std::vector<Scene> kinds = mixed_scenes();
  Scenes shared;
  std::vector<std::string> expected;
  for (const Scene& scene : kinds) {
    shared.push_back(std::make_shared<const Scene>(scene));
    expected.push_back(hash_of_single(scene, 12));
  }
  for (const int threads : {1, 3}) {
    const ThreadLimit limit(threads);
    Scenes scenes;
    for (std::size_t k = 0; k < 64; ++k) scenes.push_back(shared[k * 5 % shared.size()]);
    Batch batch(scenes);
    EXPECT_TRUE(batch.advance(12).empty());
    const std::vector<std::string> found = hashes(batch);
    for (std::size_t k = 0; k < found.size(); ++k)
      EXPECT_EQ(found[k], expected[k * 5 % shared.size()]) << k << ", " << threads << " threads";
  }
}

TEST(Batch, MembersThatAreStepsApartKeepTheirBits) {
  for (const Scene& scene : mixed_scenes()) {
    const auto shared = std::make_shared<const Scene>(scene);
    Simulation single(scene);
    std::vector<std::string> expected{state_hash(single.state())};
    for (int step = 0; step < 24; ++step) {
      single.step();
      expected.push_back(state_hash(single.state()));
    }
    Batch batch({shared, shared, shared});
    std::vector<std::size_t> done(3, 0);
    for (std::size_t round = 0; round < 36; ++round) {
      const std::vector<std::size_t> some = {round * round % 3,
                                             (round * round + 1 + round % 2) % 3};
      for (const std::size_t k : some) ++done[k];
      ASSERT_TRUE(batch.step(some).empty());
      if (*std::ranges::max_element(done) >= 24) break;
    }
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(state_hash(batch.member(k).state()), expected[done[k]])
          << scene.solver.integrator << ", member " << k << " after " << done[k] << " steps";
  }
}

TEST(Batch, TheArraysHoldAllMembersInARow) {
  const auto scene = std::make_shared<const Scene>(ball_scene());
  Batch batch({scene, scene, scene});
  const Vec3* const memory = batch.positions().data();
  EXPECT_TRUE(batch.advance(2, std::vector<std::size_t>{1}).empty());
  EXPECT_TRUE(batch.step().empty());
  EXPECT_EQ(batch.positions().data(), memory);
  ASSERT_EQ(batch.positions().size(), 3U * 121U);
  for (std::size_t k = 0; k < 3; ++k) {
    const Simulation& member = batch.member(k);
    const std::size_t begin = batch.vertex_begin()[k];
    EXPECT_TRUE(std::ranges::equal(member.positions(), batch.positions().subspan(begin, 121)));
    EXPECT_TRUE(std::ranges::equal(member.velocities(), batch.velocities().subspan(begin, 121)));
  }
}

TEST(Batch, AMemberIsSavedRestoredAndResetAlone) {
  const auto scene = std::make_shared<const Scene>(ball_scene());
  Batch batch({scene, scene});
  const std::string start = state_hash(batch.member(0).state());
  batch.advance(5);
  const MemberState saved = batch.save(0);
  batch.advance(5);
  const std::string at_ten = state_hash(batch.member(1).state());
  batch.restore(0, saved);
  EXPECT_EQ(batch.member(0).frame(), 5);
  batch.advance(5, std::vector<std::size_t>{0});
  EXPECT_EQ(state_hash(batch.member(0).state()), at_ten);
  EXPECT_EQ(state_hash(batch.member(1).state()), at_ten);
  batch.reset(1);
  EXPECT_EQ(state_hash(batch.member(1).state()), start);
  EXPECT_EQ(batch.positions()[batch.vertex_begin()[1]], batch.member(1).positions()[0]);
  batch.advance(10, std::vector<std::size_t>{1});
  EXPECT_EQ(state_hash(batch.member(1).state()), at_ten);
}

TEST(Batch, InputsBelongToOneMember) {
  const auto scene = std::make_shared<const Scene>(ball_scene());
  const std::size_t driven[] = {0};
  Batch batch({scene, scene, scene}, driven);
  BuiltScene built = build_scene(*scene);
  std::vector<Vec3> body(built.bodies[0]->vertex_count());
  built.bodies[0]->positions(0.0, body);
  for (Vec3& x : body) x.z() += 0.004;
  const std::int32_t corner[] = {0};
  const Vec3 there[] = {batch.member(2).positions()[0] + Vec3(0.0, 0.0, 0.003)};
  batch.move_body(1, 0, body);
  batch.member(2).hold(corner, there);
  EXPECT_TRUE(batch.step().empty());
  EXPECT_EQ(batch.member(2).positions()[0], there[0]);
  EXPECT_NE(batch.member(0).positions()[0], there[0]);
  EXPECT_EQ(batch.member(1).body_positions()[7], body[7]);
  EXPECT_NE(batch.member(0).body_positions()[7], body[7]);
  EXPECT_EQ(state_hash(batch.member(0).state()), [&] {
    Simulation single(*scene);
    single.step();
    return state_hash(single.state());
  }());
}

// A search tree of bodies at rest must not outlive a change to another place at rest.
TEST(Batch, BodiesAtRestInSeveralPlacesAreNotMixedUp) {
  Scene scene = sheet_over({Box{Vec3(0.2, 0.2, 0.1)}, 3}, 8);
  scene.cloths[0].placement.translation = {0.0, 0.0, 0.06};
  const auto shared = std::make_shared<const Scene>(scene);
  const std::size_t driven[] = {0};
  Batch batch({shared, shared}, driven);
  std::vector<Vec3> aside = batch.member(1).body_positions();
  for (Vec3& x : aside) x.x() += 0.15;
  batch.move_body(1, 0, aside);
  EXPECT_TRUE(batch.advance(30).empty());
  for (int frame = 0; frame < 10; ++frame) EXPECT_TRUE(batch.advance(1).empty());
  for (std::size_t k = 0; k < 2; ++k) EXPECT_TRUE(batch.result(k).clean) << k;
  Simulation single(scene);
  single.advance_to_frame(40);
  EXPECT_EQ(state_hash(batch.member(0).state()), state_hash(single.state()));
}

TEST(Batch, AMemberThatFailsStopsNoOther) {
  Scene scene = sheet_over({Box{Vec3(1.0, 1.0, 0.4)}, 3}, 4);
  scene.cloths[0].placement.translation.z() = 0.21;
  scene.time.max_halvings = 3;
  const auto shared = std::make_shared<const Scene>(scene);
  Batch batch({shared, shared, shared});
  const std::int32_t corner[] = {0};
  const Vec3 inside[] = {batch.member(1).positions()[0] - Vec3(0.0, 0.0, 0.1)};
  batch.member(1).hold(corner, inside);
  const std::vector<MemberFailure> failures = batch.step();
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_EQ(failures[0].member, 1U);
  EXPECT_EQ(failures[0].kind, FailureKind::not_clean);
  EXPECT_NE(failures[0].cause.find("no clean step"), std::string::npos) << failures[0].cause;
  EXPECT_EQ(batch.member(1).time(), 0.0);
  EXPECT_GT(batch.member(0).time(), 0.0);
  EXPECT_FALSE(batch.result(1).clean);
  batch.reset(1);
  EXPECT_TRUE(batch.step().empty());
  EXPECT_TRUE(batch.result(1).clean);
}

TEST(Batch, MistakesAreSentences) {
  const auto scene = std::make_shared<const Scene>(ball_scene());
  Batch batch({scene, scene});
  const auto message = [&](const auto& act) -> std::string {
    try {
      act();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message([&] { batch.member(2); }), "there is no member 2; the batch has 2, from 0 on");
  EXPECT_EQ(message([&] {
              batch.step(std::vector<std::size_t>{1, 1});
            }),
            "member 1 is named twice; name each once");
  EXPECT_NE(message([&] { batch.move_body(0, 0, {}); }).find("is not driven"), std::string::npos);
  Scene inside = ball_scene();
  inside.cloths[0].placement.translation.z() = 0.15;
  EXPECT_EQ(message([&] {
              Batch({scene, std::make_shared<const Scene>(inside)});
            }).find("member 1: "),
            0U);
}

TEST(RestoredSimulation, FindsABodyThatMovedInBetweenWhereItIs) {
  Scene scene = sheet_over({Box{Vec3(0.2, 0.2, 0.1)}, 3}, 8);
  scene.cloths[0].placement.translation = {0.0, 0.0, 0.06};
  scene.bodies[0].motion = {{.time = 0.2}, {.time = 0.3, .translation = Vec3(0.3, 0.0, 0.0)}};
  Simulation simulation(scene);
  simulation.advance_to_frame(6);
  const SimulationState before = simulation.state();
  simulation.advance_to_frame(12);
  const std::string expected = state_hash(simulation.state());
  simulation.advance_to_frame(30);
  simulation.restore(before);
  simulation.advance_to_frame(12);
  EXPECT_EQ(state_hash(simulation.state()), expected);
}

}  // namespace
}  // namespace selvedge::batch_test
