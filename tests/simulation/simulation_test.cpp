// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/judge/judge.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/turning_bodies.h>
#include <selvedge/simulation/detail/useful_threads.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

namespace selvedge::simulation_test {
namespace {

Scene empty_scene() {
  Scene scene;
  scene.name = "test";
  scene.materials["default"] = Material{};
  scene.time.frames = 30;
  return scene;
}

ClothSpec cloth(double size, int cells, const Vec3& where) {
  ClothSpec spec;
  spec.name = "cloth";
  spec.shape = ClothGrid{"rectangular", {size, size, cells, cells}};
  spec.placement.translation = where;
  return spec;
}

BodySpec body(const AnalyticShape& shape, const Vec3& where, int resolution = 16) {
  BodySpec spec;
  spec.name = "body";
  spec.shape = BodyShape{shape, resolution};
  spec.placement.translation = where;
  return spec;
}

LimiterTraits traits_of(bool bounds) {
  LimiterTraits traits{};
  traits.bounds_strain = bounds;
  return traits;
}

/// Moves nothing and says that it took three sweeps.
class ThreeSweeps final : public StrainLimitMethod {
 public:
  explicit ThreeSweeps(bool bounds) : bounds_(bounds) {}
  LimiterTraits traits() const override { return traits_of(bounds_); }
  StrainReport limit_ends(const LimitStep&, std::span<Vec3>) override {
    StrainReport report;
    report.sweeps = 3;
    return report;
  }

 private:
  bool bounds_;
};

/// Sweeps of ThreeSweeps in one step of cloth that hangs by an edge, stretched beyond its limit.
double sweeps_in_a_step(bool bounds) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.5, 4, Vec3::Zero()));
  HandleSpec& handle = scene.handles.emplace_back();
  handle.geometry = "cloth";
  handle.vertices = {0, 1, 2, 3, 4};
  scene.materials["default"].strain_limit = 1e-6;
  scene.gravity = {0.0, 300.0, 0.0};  // along the cloth
  scene.time.frames = scene.time.steps_per_frame = 1;
  scene.solver.limiter = "three";
  Methods methods;
  methods.strain_limiters.add(
      "three", {},
      [=](const MethodOptions&, std::span<const Spring>, std::span<const double>, std::size_t) {
        StrainLimit limit;
        limit.method = std::make_unique<ThreeSweeps>(bounds);
        limit.max_sweeps = 4;
        return limit;
      },
      traits_of(bounds));
  Simulation simulation(scene, build_scene(scene, methods), methods);
  simulation.step_towards(1);
  return simulation.result().counters.at("strain_sweeps") /
         static_cast<double>(simulation.result().steps);
}

/// Asks for another solve each time, and counts.
class NeverSettled final : public Response {
 public:
  explicit NeverSettled(int& asked) : asked_(asked) {}
  void begin(const ResponseStep&) override {}
  void add(std::span<const ContactPoint>) override {}
  bool update(std::span<Vec3>) override {
    ++asked_;
    return true;
  }
  ResponseTraits traits() const override { return responses().at("contact_force").traits(); }

 private:
  int& asked_;
};

Simulation simulate(const Scene& scene) { return Simulation(scene, build_scene(scene)); }

TriangleMesh mesh(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  return {{x.begin(), x.end()}, {triangles.begin(), triangles.end()}};
}

// Runs a scene and asks the independent judge about every accepted state and every path.
RunResult run_and_judge(const Scene& scene, int frames) {
  Simulation simulation = simulate(scene);
  TriangleMesh last = mesh(simulation.state().x, simulation.cloth_triangles());
  TriangleMesh last_body = mesh(simulation.body_positions(), simulation.body_triangles());
  for (int frame = 1; frame <= frames; ++frame)
    simulation.advance_to_frame(frame, [&](double time) {
      const TriangleMesh now = mesh(simulation.state().x, simulation.cloth_triangles());
      const TriangleMesh now_body = mesh(simulation.body_positions(), simulation.body_triangles());
      const Verdict verdict = judge(now, now_body, {});
      EXPECT_EQ(verdict.self_intersections, 0u) << "at " << time << " s";
      EXPECT_EQ(verdict.body_intersections, 0u) << "at " << time << " s";
      EXPECT_EQ(verdict.inside_vertices, 0u) << "at " << time << " s";
      const PathVerdict path = judge_path(last, now.vertices, last_body, now_body.vertices);
      EXPECT_EQ(path.self_collisions, 0u) << "before " << time << " s";
      EXPECT_EQ(path.body_collisions, 0u) << "before " << time << " s";
      last = now;
      last_body = now_body;
    });
  return simulation.result();
}

TEST(Simulation, DrapesOnASphereWithoutASingleIntersectionInStatesOrPaths) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.6, 16, {0.02, 0.01, 0.25}));
  scene.bodies.push_back(body(Sphere{0.2}, {0, 0, 0}));
  const RunResult result = run_and_judge(scene, 30);
  EXPECT_TRUE(result.clean);
  EXPECT_LT(result.max_stretch, 0.1);
}

TEST(Simulation, DrapesOverASharpBoxWhoseEdgesOnlyEdgesCanCatch) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.6, 6, {0.013, 0.017, 0.06}));
  scene.bodies.push_back(body(Box{Vec3(0.11, 0.13, 0.1)}, {0, 0, 0}));
  EXPECT_TRUE(run_and_judge(scene, 30).clean);
}

TEST(Simulation, AFinThinnerThanTheClothSpacingDoesNotComeThrough) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.5, 10, {0.01, 0.013, 0.12}));
  scene.bodies.push_back(body(Box{Vec3(0.001, 0.3, 0.2)}, {0, 0, 0}));
  EXPECT_TRUE(run_and_judge(scene, 30).clean);
}

TEST(Simulation, AFastSheetDoesNotPassAThinPlate) {
  for (const double speed : {2.0, 40.0, 1000.0}) {
    Scene scene = empty_scene();
    scene.cloths.push_back(cloth(0.3, 8, {0, 0, 0.1}));
    scene.cloths[0].velocity = Vec3(0, 0, -speed);
    scene.bodies.push_back(body(Box{Vec3(1.0, 1.0, 0.005)}, {0, 0, 0}));
    const RunResult result = run_and_judge(scene, 12);
    EXPECT_TRUE(result.clean) << speed << " m/s";
  }
}

TEST(Simulation, ASphereFasterThanTheClothPushesItCleanly) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.4, 10, {0, 0, 0.3}));
  scene.bodies.push_back(body(Sphere{0.1}, {0, 0, 0}));
  Keyframe end;
  end.time = 0.1;
  end.translation = Vec3(0, 0, 1.0);  // 10 m/s
  scene.bodies[0].motion = {Keyframe{}, end};
  EXPECT_TRUE(run_and_judge(scene, 12).clean);
}

TEST(Simulation, ATurningBladeStaysOutsideTheCloth) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.4, 10, {0, 0, 0.06}));
  scene.bodies.push_back(body(Box{Vec3(0.3, 0.02, 0.1)}, {0, 0, 0}));
  Keyframe turned;
  turned.time = 0.5;
  turned.rotation = Eigen::AngleAxisd(3.0, Vec3::UnitZ());
  scene.bodies[0].motion = {Keyframe{}, turned};
  EXPECT_TRUE(run_and_judge(scene, 30).clean);
}

TEST(Simulation, ABodyThatChangesItsShapeStaysOutsideTheCloth) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.4, 10, {0.01, 0.02, 0.11}));
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / ("swelling_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  BodySequence swelling;
  for (int k = 0; k < 8; ++k) {  // a ball that swells from 10 cm to 17 cm, taller than wide
    TriangleMesh ball = tessellate(Sphere{0.1}, 24);
    for (Vec3& x : ball.vertices) x *= 1.0 + 0.1 * k * (0.5 + 5.0 * std::abs(x.z()));
    swelling.files.push_back(folder / (std::to_string(k) + ".ply"));
    write_ply(swelling.files.back(), ball.vertices, ball.triangles);
  }
  swelling.fps = 30.0;
  BodySpec ball;
  ball.name = "ball";
  ball.shape = swelling;
  scene.bodies.push_back(ball);
  EXPECT_TRUE(run_and_judge(scene, 20).clean);
  std::filesystem::remove_all(folder);
}

TEST(Simulation, SheetsFallOnEachOtherCleanly) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.3, 10, {0, 0, 0.12}));
  scene.cloths.push_back(cloth(0.3, 10, {0.03, 0.02, 0.15}));
  scene.cloths[1].name = "second";
  scene.bodies.push_back(body(Sphere{0.1}, {0, 0, 0}));
  EXPECT_TRUE(run_and_judge(scene, 40).clean);
}

// A strip falls upright on its edge and crumples onto itself: edges and points of one piece meet
// from all sides.
TEST(Simulation, ACrumplingStripStaysClean) {
  Scene scene = empty_scene();
  ClothSpec strip = cloth(0.3, 12, {0, 0, 0.16});
  strip.shape = ClothGrid{"triangular", {0.05, 0.3, 3, 16}};
  strip.placement.rotation =
      Eigen::AngleAxisd(1.5, Vec3::UnitX()) * Eigen::AngleAxisd(0.1, Vec3::UnitZ());
  strip.velocity = Vec3(0, 0, -3.0);
  scene.cloths.push_back(strip);
  scene.bodies.push_back(body(Box{Vec3(1, 1, 0.005)}, {0, 0, 0}));
  EXPECT_TRUE(run_and_judge(scene, 40).clean);
}

// More layers than the contact solves of one step get apart: the fail-safe does.
TEST(Simulation, AFastStackOfSheetsNeedsTheFailSafeAndStaysClean) {
  Scene scene = empty_scene();
  for (int k = 0; k < 12; ++k) {
    scene.cloths.push_back(cloth(0.2, 4, {0.003 * k, 0.002 * k, 0.01 + 0.003 * k}));
    scene.cloths[k].name = "sheet" + std::to_string(k);
    scene.cloths[k].velocity = Vec3(0, 0, -300.0);
    scene.cloths[k].placement.rotation = Eigen::AngleAxisd(0.2 * k, Vec3::UnitZ());
  }
  scene.bodies.push_back(body(Box{Vec3(1, 1, 0.005)}, {0, 0, 0}));
  RunResult result = run_and_judge(scene, 10);
  EXPECT_TRUE(result.clean);
  EXPECT_GT(result.counters["projection_rounds"], 0.0);
  EXPECT_EQ(result.halvings, 0);
}

TEST(Simulation, ClothBetweenClosingJawsEndsWithASentenceAndCleanStates) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.2, 6, {0, 0, 0}));
  for (const double side : {-1.0, 1.0}) {
    scene.bodies.push_back(body(Box{Vec3(0.3, 0.3, 0.05)}, {0, 0, 0.04 * side}));
    scene.bodies.back().name = side < 0.0 ? "lower" : "upper";
    Keyframe closed;
    closed.time = 0.2;
    closed.translation = Vec3(0, 0, -0.0151 * side);
    scene.bodies.back().motion = {Keyframe{}, closed};
  }
  try {
    run_and_judge(scene, 14);
    FAIL() << "the jaws close on the cloth: no clean state exists";
  } catch (const SimulationFailed& failed) {
    EXPECT_NE(std::string(failed.what()).find("no clean step at"), std::string::npos)
        << failed.what();
  }
}

/// Two sheets whose edges are sewn together over a gap, m.
Scene sewn_sheets(double gap) {
  Scene scene = empty_scene();
  SeamSpec& seam = scene.seams.emplace_back();
  seam.name = "seam";
  seam.sewing.pull = 0.5;
  for (int k = 0; k < 2; ++k) {
    ClothSpec& cloth = scene.cloths.emplace_back();
    cloth.name = k == 0 ? "left" : "right";
    cloth.shape = ClothGrid{.grid = {0.2, 0.2, 4, 4}, .path = {}};
    cloth.placement.translation = Vec3((0.2 + gap) * k, 0.0, 0.0);
    seam.geometry[static_cast<std::size_t>(k)] = cloth.name;
  }
  for (std::int32_t row = 0; row < 5; ++row) {
    seam.vertices[0].push_back(5 * row + 4);
    seam.vertices[1].push_back(5 * row);
  }
  scene.solver.integrator = "implicit_blend";
  scene.gravity = Vec3::Zero();
  return scene;
}

// The pull of a seam is no force of the material: its motion is damped.
TEST(Simulation, TheBlendIsImplicitEulerWhileSeamsAreSewn) {
  for (const bool open : {true, false}) {
    const Scene scene = sewn_sheets(open ? 0.1 : 1e-4);
    Simulation blend(scene, build_scene(scene));
    blend.advance_to_frame(2);
    const RunResult& result = blend.result();
    EXPECT_EQ(result.counters.at("substituted_implicit_blend_by_implicit_euler"),
              open ? static_cast<double>(result.steps) : 0.0);
  }
}

TEST(Simulation, RefusesAClothThatCrossesABody) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.5, 10, {0, 0, 0}));
  scene.bodies.push_back(body(Sphere{0.1}, {0, 0, 0}));
  try {
    simulate(scene);
    FAIL() << "must be refused";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("crosses a body"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("the first is triangle"), std::string::npos);
  }
}

TEST(Simulation, RefusesPiecesThatCrossEachOther) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.5, 10, {0, 0, 0}));
  scene.cloths.push_back(cloth(0.5, 10, {0.01, 0.01, 0}));
  scene.cloths[1].name = "second";
  scene.cloths[1].placement.rotation = Eigen::AngleAxisd(1.0, Vec3::UnitX());
  EXPECT_THROW(simulate(scene), std::invalid_argument);
}

TEST(Simulation, RefusesHandlesOnClothThatIsNotThere) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.3, 8, {0, 0, 0}));
  scene.handles.push_back({"pin", "curtain", {0}, {}, {}});
  EXPECT_THROW(simulate(scene), std::invalid_argument);
  scene.handles[0].geometry = "cloth";
  EXPECT_NO_THROW(simulate(scene));
  scene.handles[0].vertices = {81};  // 9 x 9 vertices
  EXPECT_THROW(simulate(scene), std::invalid_argument);
}

Scene small_drape() {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.5, 40, {0.02, 0.01, 0.22}));
  scene.bodies.push_back(body(Sphere{0.2}, {0, 0, 0}, 32));
  return scene;
}

TEST(Simulation, GivesTheSameBitsForAnyNumberOfThreads) {
  std::vector<std::string> hashes;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    Simulation simulation = simulate(small_drape());
    for (int frame = 1; frame <= 20; ++frame) simulation.advance_to_frame(frame, {});
    hashes.push_back(state_hash(simulation.state()));
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

/// The number of threads on which a task in this arena runs.
std::size_t threads_of_a_task(ThreadArena& arena) {
  std::mutex mutex;
  std::set<std::thread::id> seen;
  arena.run([&] {
    parallel_for(200, 1, [&](std::size_t, std::size_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const std::lock_guard lock(mutex);
      seen.insert(std::this_thread::get_id());
    });
  });
  return seen.size();
}

TEST(ThreadArena, LimitsTheThreadsOfItsTasksOnly) {
  const ThreadLimit limit(4);
  ThreadArena one(1), two(2), many(64);
  EXPECT_EQ(threads_of_a_task(one), 1u);
  EXPECT_LE(threads_of_a_task(two), 2u);
  EXPECT_LE(threads_of_a_task(many), 4u);
  EXPECT_EQ(thread_count(), 4);
}

TEST(ThreadArena, PassesExceptionsOn) {
  const ThreadLimit limit(4);
  ThreadArena one(1);
  EXPECT_THROW(one.run([] { throw std::domain_error("thrown in a task"); }), std::domain_error);
}

TEST(Simulation, UsesAThreadPer600VerticesThatMove) {
  const auto threads = [](const Scene& scene) {
    return detail::useful_threads(scene, build_scene(scene));
  };
  Scene scene = small_drape();
  EXPECT_EQ(threads(scene), 3);  // 41 x 41 particles; the ball is at rest
  scene.cloths[0] = cloth(0.5, 4, {0.02, 0.01, 0.22});
  EXPECT_EQ(threads(scene), 2);
  scene.bodies[0] = body(Sphere{0.2}, {0, 0, 0}, 64);
  scene.bodies[0].motion = {{.time = 0.0}, {.time = 0.1, .translation = {0, 0, 0.01}}};
  EXPECT_GE(threads(scene), 4);  // a ball of over 1,900 vertices that moves
}

TEST(Simulation, EveryConservativeDetectorGivesACleanDrape) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.5, 10, {0.013, 0.01, 0.22}));
  scene.cloths.push_back(cloth(0.4, 8, {0.0, 0.02, 0.25}));
  scene.cloths[1].name = "upper";
  scene.bodies.push_back(body(Sphere{0.2}, {0, 0, 0}));
  const auto drape = [&](const std::string& detector, bool& clean) {
    scene.contact.broad_phase = detector;
    Simulation simulation = simulate(scene);
    simulation.advance_to_frame(20, {});
    clean = simulation.result().clean;
    return state_hash(simulation.state());
  };
  bool clean = false;
  const std::string right = drape("brute_force", clean);
  for (const auto& [name, make] : broad_phases()) {
    const BroadPhaseTraits traits = make()->traits();
    if (traits.guarantee != Guarantee::conservative) continue;
    const std::string hash = drape(name, clean);
    EXPECT_TRUE(clean) << name;
    if (traits.pairs == PairSet::boxes) {
      EXPECT_EQ(hash, right) << name;
    }
  }
}

TEST(Simulation, RestoredItGoesOnToTheSameBits) {
  Simulation whole = simulate(small_drape());
  Simulation first = simulate(small_drape()), second = simulate(small_drape());
  for (int frame = 1; frame <= 20; ++frame) whole.advance_to_frame(frame, {});
  for (int frame = 1; frame <= 12; ++frame) first.advance_to_frame(frame, {});
  second.restore(first.state());
  for (int frame = 13; frame <= 20; ++frame) second.advance_to_frame(frame, {});
  EXPECT_EQ(state_hash(whole.state()), state_hash(second.state()));
}

TEST(Simulation, HeldParticlesAreWhereTheirHandleSaysToTheBit) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.3, 8, {0, 0, 0}));
  Keyframe end;
  end.time = 0.25;
  end.translation = Vec3(0.1, 0.0, 0.05);
  scene.handles.push_back({"corner", "cloth", {0}, {Keyframe{}, end}, {}});
  scene.handles.push_back({"other", "cloth", {8}, {}, {}});
  Simulation simulation = simulate(scene);
  const Vec3 start0 = simulation.state().x[0], start8 = simulation.state().x[8];
  for (int frame = 1; frame <= 20; ++frame) simulation.advance_to_frame(frame, {});
  EXPECT_EQ(simulation.state().x[0], Vec3(start0 + Vec3(0.1, 0.0, 0.05)));
  EXPECT_EQ(simulation.state().x[8], start8);
}

TEST(Simulation, AReleasedHandleLetsGo) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.3, 8, {0, 0, 0}));
  scene.handles.push_back({"all", "cloth", {0, 8}, {}, 0.2});
  Simulation simulation = simulate(scene);
  for (int frame = 1; frame <= 30; ++frame) simulation.advance_to_frame(frame, {});
  EXPECT_LT(simulation.state().x[0].z(), -0.1);
}

Scene incline(double mu) {
  Scene scene = empty_scene();
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(-M_PI / 6.0, Vec3::UnitY()));  // 30°
  scene.cloths.push_back(cloth(0.2, 8, tilt * Vec3(0.031, 0.017, 0.002)));
  scene.cloths[0].placement.rotation = tilt;
  scene.bodies.push_back(body(Plane{20.0}, {0, 0, 0}));
  scene.bodies[0].placement.rotation = tilt;
  scene.bodies[0].friction = mu;
  return scene;
}

Vec3 centre(const SimulationState& state) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& x : state.x) sum += x;
  return sum / static_cast<double>(state.x.size());
}

TEST(Simulation, AClothSticksOnAnInclineThatFrictionHolds) {
  Simulation simulation = simulate(incline(0.6));
  const Vec3 start = centre(simulation.state());
  for (int frame = 1; frame <= 120; ++frame) simulation.advance_to_frame(frame, {});
  EXPECT_LT((centre(simulation.state()) - start).norm(), 1e-5);
}

TEST(Simulation, AClothSlidesDownAnInclineAsCoulombSays) {
  Simulation simulation = simulate(incline(0.3));
  const Vec3 start = centre(simulation.state());
  for (int frame = 1; frame <= 60; ++frame) simulation.advance_to_frame(frame, {});
  EXPECT_NEAR((centre(simulation.state()) - start).norm(), 1.17814, 0.02 * 1.17814);
}

// The longest step is proportional to the square root of the gap.
TEST(Simulation, ATurningBodyTakesShorterStepsBesideASmallerRestGap) {
  Scene scene = empty_scene();
  scene.cloths = {cloth(0.2, 4, {0, 0, 1})};
  scene.bodies = {body(Sphere{0.1}, {0, 0, 0}), body(Box{Vec3(0.5, 0.1, 0.1)}, {2, 0, 0})};
  scene.bodies[0].name = "still";
  scene.bodies[1].name = "turning";
  scene.bodies[1].motion = {
      {.time = 0.0},
      {.time = 0.1, .rotation = Eigen::Quaterniond(Eigen::AngleAxisd(2.0, Vec3::UnitZ()))}};
  const auto longest_step = [&] {
    const BuiltScene built = build_scene(scene);
    return detail::TurningBodies(scene, built).longest_step(built, 0.0, 0.05);
  };
  const double step = longest_step();
  EXPECT_LT(step, 0.05);
  PairSpec& pair = scene.contact.pairs.emplace_back();
  pair.a = "cloth";
  pair.b = "still";
  pair.rest_gap = scene.contact.rest_gap / 16.0;
  EXPECT_EQ(longest_step(), step) << "the gap of another body";
  pair.b = "turning";
  EXPECT_NEAR(longest_step(), step / 4.0, 1e-12);
}

TEST(Simulation, TheExplicitIntegratorSubstepsToItsBoundAndStaysClean) {
  Scene scene = empty_scene();
  scene.solver.integrator = "symplectic_euler";
  scene.cloths.push_back(cloth(0.2, 6, {0.01, 0.02, 0.105}));
  scene.bodies.push_back(body(Sphere{0.1}, {0, 0, 0}));
  Simulation simulation = simulate(scene);
  for (int frame = 1; frame <= 8; ++frame) simulation.advance_to_frame(frame, {});
  const RunResult result = simulation.result();
  EXPECT_TRUE(result.clean);
  EXPECT_GT(result.steps, 2 * 8);
  EXPECT_LT(result.max_stretch, 0.1);
}

TEST(Simulation, PinsTooFarApartAreReportedAndDoNotDiverge) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.3, 8, {0, 0, 0}));
  Keyframe end;
  end.time = 0.2;
  end.translation = Vec3(-0.15, -0.15, 0.0);
  scene.handles.push_back({"a", "cloth", {0}, {Keyframe{}, end}, {}});
  scene.handles.push_back({"b", "cloth", {80}, {}, {}});
  Simulation simulation = simulate(scene);
  for (int frame = 1; frame <= 20; ++frame) simulation.advance_to_frame(frame, {});
  const RunResult result = simulation.result();
  EXPECT_GT(result.strain_residual, 0.05);
  EXPECT_LT(result.final_max_speed, 10.0);
}

TEST(Simulation, CountsTheSweepsOfALimiterOnceOrUntilTheLimitsHold) {
  EXPECT_EQ(sweeps_in_a_step(false), 3.0);
  // A first attempt that is hopeless has no rounds; two shorter ones have five each, in vain.
  EXPECT_EQ(sweeps_in_a_step(true), 3.0 + 2.0 * (3.0 + 5.0 * 4.0));
}

TEST(Simulation, AResponseThatNeverSettlesIsAskedFortyEightTimes) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.5, 4, Vec3::Zero()));
  scene.time.frames = scene.time.steps_per_frame = 1;
  scene.contact.response = "never";
  int asked = 0;
  Methods methods;
  methods.responses.add(
      "never", {}, [&](const MethodOptions&) { return std::make_unique<NeverSettled>(asked); },
      responses().at("contact_force").traits());
  Simulation simulation(scene, build_scene(scene, methods), methods);
  simulation.step_towards(1);
  EXPECT_EQ(asked, 48);
}

TEST(Simulation, ADrapeComesToRest) {
  Scene scene = empty_scene();
  scene.cloths.push_back(cloth(0.5, 20, {0.02, 0.01, 0.22}));
  scene.bodies.push_back(body(Sphere{0.2}, {0, 0, 0}, 48));
  scene.air.normal_drag = 1.0;
  scene.air.viscous_drag = 0.1;
  Simulation simulation = simulate(scene);
  for (int frame = 1; frame <= 240; ++frame) simulation.advance_to_frame(frame, {});
  EXPECT_LT(simulation.result().final_max_speed, 0.03);
}

}  // namespace
}  // namespace selvedge::simulation_test
