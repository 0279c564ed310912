// SPDX-License-Identifier: MIT
// The C interface beside the C++ library: the same results, errors as codes with a sentence, and
// the symbols of the list.
#include <gtest/gtest.h>
#include <selvedge.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/dress.h>
#include <selvedge/garment/sewing_pattern.h>
#include <selvedge/judge/judge.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace selvedge::c_interface_test {
namespace {

template <auto free_function>
struct Freer {
  template <class Object>
  void operator()(Object* object) const {
    free_function(object);
  }
};
template <class Object, auto free_function>
using Owned = std::unique_ptr<Object, Freer<free_function>>;
using Contacts = Owned<selvedge_contacts, selvedge_contacts_free>;
using Pairs = Owned<selvedge_pairs, selvedge_pairs_free>;
using Detector = Owned<selvedge_detector, selvedge_detector_free>;
using SceneHandle = Owned<selvedge_scene, selvedge_scene_free>;
using SimulationHandle = Owned<selvedge_simulation, selvedge_simulation_free>;
using Garment = Owned<selvedge_garment, selvedge_garment_free>;
using State = Owned<selvedge_state, selvedge_state_free>;

/// Calls make(&object); the call must succeed.
template <class Handle, class Make>
Handle made(Make make) {
  typename Handle::pointer object = nullptr;
  EXPECT_EQ(make(&object), SELVEDGE_OK) << selvedge_last_error();
  return Handle(object);
}

Detector detector(double min_separation = 0.0) {
  return made<Detector>([&](selvedge_detector** out) {
    return selvedge_detector_create(nullptr, nullptr, min_separation, out);
  });
}

/// A soup of triangles in motion.
struct Soup {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Triangle> triangles;

  Soup(unsigned seed, std::size_t count) {
    std::mt19937 random(seed);
    const auto number = [&] { return static_cast<double>(random()) / 4294967296.0; };
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 at(number(), number(), number());
      const auto v = static_cast<std::int32_t>(x_t0.size());
      for (int k = 0; k < 3; ++k) {
        x_t0.push_back(at + 0.8 * Vec3(number(), number(), number()));
        x_t1.push_back(x_t0.back() + 0.2 * Vec3(number(), number(), number()));
      }
      triangles.push_back({v, v + 1, v + 2});
    }
  }
  selvedge_surface surface() const {
    return {x_t0.front().data(), x_t1.front().data(), x_t0.size(), triangles.front().data(),
            triangles.size()};
  }
  MovingSurface moving() const { return {x_t0, x_t1, triangles}; }
  SurfaceState state() const { return {x_t0, triangles}; }
  TriangleMesh mesh() const { return {x_t0, triangles}; }
};

/// The columns of `found` that primitives have are those of `expected`.
template <class Pair>
void expect_equal(const selvedge_contacts& found, const std::vector<Pair>& expected) {
  ASSERT_EQ(found.count, expected.size());
  for (std::size_t i = 0; i < found.count; ++i) {
    EXPECT_EQ(found.kind[i], static_cast<int>(expected[i].kind));
    EXPECT_EQ(found.primitives[2 * i], expected[i].primitive_a);
    EXPECT_EQ(found.primitives[2 * i + 1], expected[i].primitive_b);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(found.vertices[4 * i + k], expected[i].vertex[k]);
      EXPECT_EQ(found.weights[4 * i + k], expected[i].weight[k]);
    }
    for (int k = 0; k < 3; ++k) EXPECT_EQ(found.normal[3 * i + k], expected[i].normal[k]);
  }
}

template <class Pair>
void expect_equal(const Pairs& found, const std::vector<Pair>& expected) {
  ASSERT_EQ(found->count, expected.size());
  for (std::size_t i = 0; i < found->count; ++i) {
    const auto [a, b] = expected[i];
    EXPECT_EQ(found->index[2 * i], a);
    EXPECT_EQ(found->index[2 * i + 1], b);
  }
}

TEST(CInterface, FindsTheSameCollisionsAndCandidatesAsTheLibrary) {
  const Detector finder = detector();
  std::size_t count = 0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Soup a(seed, 40), b(seed + 100, 30);
    const selvedge_surface first = a.surface(), second = b.surface();
    for (const bool both : {false, true}) {
      const auto found = made<Contacts>([&](selvedge_contacts** out) {
        return selvedge_find_collisions(finder.get(), &first, both ? &second : nullptr, out);
      });
      const std::vector<Collision> expected = both ? find_collisions(a.moving(), b.moving())
                                                   : find_collisions(a.x_t0, a.x_t1, a.triangles);
      expect_equal(*found, expected);
      for (std::size_t i = 0; i < found->count; ++i) EXPECT_EQ(found->toi[i], expected[i].toi);
      EXPECT_EQ(found->gap, nullptr);
      count += found->count;

      selvedge_pairs* lists[3];
      ASSERT_EQ(selvedge_find_candidates(finder.get(), &first, both ? &second : nullptr, 0.01,
                                         &lists[0], &lists[1], &lists[2]),
                SELVEDGE_OK);
      const Pairs points(lists[0]), triangles(lists[1]), edges(lists[2]);
      const std::unique_ptr<BroadPhase> broad = broad_phases().at("bvh_aabb")({});
      const CandidatePairs pairs = both ? find_candidates(*broad, a.moving(), b.moving(), 0.01)
                                        : find_candidates(*broad, a.moving(), 0.01);
      expect_equal(points, pairs.point_triangle);
      expect_equal(triangles, pairs.triangle_point);
      expect_equal(edges, pairs.edge_edge);
    }
  }
  EXPECT_GT(count, 100u);
}

TEST(CInterface, FindsTheSameMeetingsAndContactsAsTheLibrary) {
  for (const unsigned seed : {4u, 5u}) {
    const Soup a(seed, 40), b(seed + 100, 30);
    selvedge_surface first = a.surface(), second = b.surface();
    first.x_t1 = second.x_t1 = nullptr;
    for (const bool both : {false, true}) {
      selvedge_pairs *crossing, *touching;
      ASSERT_EQ(selvedge_find_meetings(&first, both ? &second : nullptr, &crossing, &touching),
                SELVEDGE_OK);
      const Pairs crossings(crossing), touches(touching);
      const TriangleMeetings expected =
          both ? find_meetings(a.state(), b.state()) : find_meetings(a.x_t0, a.triangles);
      EXPECT_GT(crossings->count, 10u);
      expect_equal(crossings, expected.crossings);
      expect_equal(touches, expected.touches);

      const auto near = made<Contacts>([&](selvedge_contacts** out) {
        return selvedge_find_contacts(&first, both ? &second : nullptr, 0.02, out);
      });
      const std::vector<Proximity> gaps = both ? find_contacts(a.state(), b.state(), 0.02)
                                               : find_contacts(a.x_t0, a.triangles, 0.02);
      expect_equal(*near, gaps);
      for (std::size_t i = 0; i < near->count; ++i) EXPECT_EQ(near->gap[i], gaps[i].gap);
    }
    const auto edges = made<Pairs>([&](selvedge_pairs** out) {
      return selvedge_edges(first.triangles, first.triangle_count, out);
    });
    expect_equal(edges, unique_edges(a.triangles));
  }
}

TEST(CInterface, ReadsTheMeshThatTheLibraryReads) {
  const std::string folder = SELVEDGE_SOURCE_DIR "/data/";
  for (const std::string file : {"bodies/mannequin.ply", "meshes/no_such_file.obj"}) {
    selvedge_mesh* out = nullptr;
    const int code = selvedge_mesh_read((folder + file).c_str(), &out);
    const Owned<selvedge_mesh, selvedge_mesh_free> mesh(out);
    if (mesh == nullptr) {
      EXPECT_EQ(code, SELVEDGE_INVALID);
      EXPECT_NE(std::string(selvedge_last_error()).find("no_such_file.obj"), std::string::npos);
      continue;
    }
    const TriangleMesh expected = read_mesh(folder + file);
    ASSERT_EQ(mesh->vertices, expected.vertices.size());
    ASSERT_EQ(mesh->triangle_count, expected.triangles.size());
    EXPECT_TRUE(
        std::equal(mesh->x, mesh->x + 3 * mesh->vertices, expected.vertices.front().data()));
    EXPECT_TRUE(std::equal(mesh->triangles, mesh->triangles + 3 * mesh->triangle_count,
                           expected.triangles.front().data()));
  }
}

TEST(CInterface, TheJudgeEnclosesTheTimesOfTheExactNarrowPhase) {
  std::mt19937 random(6);
  constexpr std::size_t n = 400;
  std::vector<double> queries(24 * n), toi(n), lo(n), hi(n);
  for (double& x : queries) x = static_cast<double>(random()) / 4294967296.0;
  for (const int kind : {SELVEDGE_POINT_TRIANGLE, SELVEDGE_EDGE_EDGE}) {
    ASSERT_EQ(selvedge_impact_times(nullptr, kind, queries.data(), n, toi.data()), SELVEDGE_OK);
    ASSERT_EQ(selvedge_touch_times(kind, queries.data(), n, lo.data(), hi.data()), SELVEDGE_OK);
    EXPECT_EQ(toi, lo);
    std::size_t touching = 0;
    for (std::size_t i = 0; i < n; ++i) {
      touching += lo[i] <= 1.0 ? 1 : 0;
      EXPECT_LE(lo[i], hi[i]);
    }
    EXPECT_GT(touching, 20u);
    EXPECT_LT(touching, n);
  }
}

TEST(CInterface, JudgesAsTheJudgeDoes) {
  const Soup mesh(7, 30), body(8, 20);
  const selvedge_surface cloth = mesh.surface(), against = body.surface();
  std::vector<Vec3> rest = mesh.x_t0;
  for (Vec3& x : rest) x *= 0.5;
  selvedge_verdict verdict;
  ASSERT_EQ(selvedge_judge(&cloth, &against, rest.front().data(), &verdict), SELVEDGE_OK);
  const Verdict expected = judge(mesh.mesh(), body.mesh(), {rest, mesh.triangles});
  EXPECT_EQ(verdict.self_crossings, expected.self_intersections);
  EXPECT_EQ(verdict.body_crossings, expected.body_intersections);
  EXPECT_EQ(verdict.self_touches, expected.self_touches);
  EXPECT_EQ(verdict.body_touches, expected.body_touches);
  EXPECT_EQ(verdict.inside_vertices, expected.inside_vertices);
  EXPECT_EQ(verdict.max_stretch, expected.max_stretch);
  EXPECT_EQ(verdict.max_compression, expected.max_compression);
  ASSERT_FALSE(expected.first_self.empty() || expected.first_body.empty());
  EXPECT_EQ(verdict.first_self_crossing[0], expected.first_self[0].first);
  EXPECT_EQ(verdict.first_body_crossing[1], expected.first_body[0].second);

  std::uint64_t self = 0, other = 0;
  ASSERT_EQ(selvedge_judge_path(&cloth, &against, &self, &other), SELVEDGE_OK);
  const PathVerdict path = judge_path(mesh.mesh(), mesh.x_t1, body.mesh(), body.x_t1);
  EXPECT_EQ(self, path.self_collisions);
  EXPECT_EQ(other, path.body_collisions);
  EXPECT_GT(self + other, 0u);
}

constexpr const char* kScene = R"({
  "materials": {"default": {"density": 0.15, "bending_stiffness": 2e-5}},
  "geometry": [{"cells": [12, 12], "transformation": {"translation": [0, 0, 0.31]}}],
  "obstacles": [{"shape": {"type": "sphere", "radius": 0.3}}], "time": {"frames": 12}})";

SceneHandle scene() {
  return made<SceneHandle>(
      [](selvedge_scene** out) { return selvedge_scene_create(kScene, nullptr, out); });
}

SimulationHandle simulation(const std::vector<std::size_t>& driven = {}) {
  const SceneHandle read = scene();
  return made<SimulationHandle>([&](selvedge_simulation** out) {
    return selvedge_simulation_create(read.get(), driven.data(), driven.size(), out);
  });
}

std::string hash_of(const SimulationHandle& now) {
  char hash[17] = "";
  EXPECT_EQ(selvedge_simulation_hash(now.get(), hash), SELVEDGE_OK);
  return hash;
}

TEST(CInterface, SaysThatASceneLeavesPathsUnchecked) {
  std::string text = kScene;
  text.insert(text.rfind('}'), R"(, "contact": {"self": false})");
  const auto read = made<SceneHandle>(
      [&](selvedge_scene** out) { return selvedge_scene_create(text.c_str(), nullptr, out); });
  const auto now = made<SimulationHandle>([&](selvedge_simulation** out) {
    return selvedge_simulation_create(read.get(), nullptr, 0, out);
  });
  double unchecked = 0.0;
  ASSERT_EQ(selvedge_simulation_figure(now.get(), "unchecked", &unchecked), SELVEDGE_OK);
  EXPECT_EQ(unchecked, 1.0);
}

TEST(CInterface, StepsTheSameStatesAsTheLibrary) {
  const SimulationHandle now = simulation();
  const SceneHandle read = scene();
  EXPECT_EQ(selvedge_scene_frames(read.get()), 12);
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / "c_interface_scene.json";
  std::ofstream(file) << selvedge_scene_json(read.get());
  Simulation expected(read_scene(file));
  std::filesystem::remove(file);
  ASSERT_EQ(selvedge_simulation_advance(now.get(), 8), SELVEDGE_OK);
  expected.advance_to_frame(8);
  EXPECT_EQ(hash_of(now), state_hash(expected.state()));
  EXPECT_EQ(selvedge_simulation_time(now.get()), expected.time());
  EXPECT_EQ(selvedge_simulation_steps(now.get()), expected.state().step);
  ASSERT_EQ(selvedge_simulation_vertices(now.get()), expected.positions().size());
  EXPECT_EQ(selvedge_simulation_positions(now.get())[5], expected.positions()[1].z());
  EXPECT_EQ(selvedge_simulation_velocities(now.get())[5], expected.velocities()[1].z());
  std::size_t count = 0;
  EXPECT_NE(selvedge_simulation_triangles(now.get(), &count), nullptr);
  EXPECT_EQ(count, expected.cloth_triangles().size());
  EXPECT_NE(selvedge_simulation_body_triangles(now.get(), &count), nullptr);
  EXPECT_EQ(count, expected.body_triangles().size());
  EXPECT_EQ(selvedge_simulation_bodies(now.get()), 1u);
  EXPECT_EQ(selvedge_simulation_body_begin(now.get(), 1), expected.body_positions().size());
  double clean = 0.0, kinetic = 0.0;
  ASSERT_EQ(selvedge_simulation_figure(now.get(), "clean", &clean), SELVEDGE_OK);
  EXPECT_EQ(clean, 1.0);
  double unchecked = 1.0;
  ASSERT_EQ(selvedge_simulation_figure(now.get(), "unchecked", &unchecked), SELVEDGE_OK);
  EXPECT_EQ(unchecked, 0.0);
  ASSERT_EQ(selvedge_simulation_figure(now.get(), "energy.kinetic", &kinetic), SELVEDGE_OK);
  EXPECT_EQ(kinetic, expected.energies().at("kinetic"));
  const auto contacts = made<Contacts>(
      [&](selvedge_contacts** out) { return selvedge_simulation_contacts(now.get(), out); });
  EXPECT_GT(contacts->count, 0u);
  EXPECT_EQ(contacts->count, expected.contacts().size());
  EXPECT_GT(contacts->rest_gap[0], 0.0);
}

/// Holds a corner, pulls the cloth and moves the ball, from frame `begin` to frame `end`.
void drive(const SimulationHandle& now, int begin, int end) {
  const std::vector<double> push(3 * selvedge_simulation_vertices(now.get()), 1e-4);
  const std::int32_t corner = 0;
  for (int frame = begin; frame < end; ++frame) {
    ASSERT_EQ(selvedge_simulation_set_forces(now.get(), frame % 2 ? push.data() : nullptr),
              SELVEDGE_OK);
    const double* x = selvedge_simulation_positions(now.get());
    const double held[3] = {x[0], x[1], x[2] + 1e-3};
    ASSERT_EQ(selvedge_simulation_hold(now.get(), &corner, 1, held), SELVEDGE_OK);
    const std::size_t n = selvedge_simulation_body_begin(now.get(), 1);
    const double* ball = selvedge_simulation_body_positions(now.get());
    std::vector<double> moved(ball, ball + 3 * n);
    for (double& coordinate : moved) coordinate += 5e-4;
    ASSERT_EQ(selvedge_simulation_move_body(now.get(), 0, moved.data(), n), SELVEDGE_OK)
        << selvedge_last_error();
    ASSERT_EQ(selvedge_simulation_advance(now.get(), frame + 1), SELVEDGE_OK);
    if (frame % 3 == 0) {
      ASSERT_EQ(selvedge_simulation_release(now.get(), nullptr, 0), SELVEDGE_OK);
    }
  }
}

TEST(CInterface, ARestoredStateContinuesWithTheSameBits) {
  const SimulationHandle now = simulation({0});
  drive(now, 0, 3);
  const auto saved =
      made<State>([&](selvedge_state** out) { return selvedge_simulation_save(now.get(), out); });
  ASSERT_EQ(selvedge_simulation_restore(now.get(), saved.get()), SELVEDGE_OK);
  drive(now, 3, 6);
  const std::string first = hash_of(now);
  const SimulationHandle other = simulation({0});
  ASSERT_EQ(selvedge_simulation_restore(other.get(), saved.get()), SELVEDGE_OK);
  drive(other, 3, 6);
  EXPECT_EQ(first, hash_of(other));
  const SimulationHandle free = simulation();
  EXPECT_EQ(selvedge_simulation_restore(free.get(), saved.get()), SELVEDGE_INVALID);
  EXPECT_NE(std::string(selvedge_last_error()), "");
}

TEST(CInterface, ErrorsAreCodesWithASentenceThatNamesTheFault) {
  selvedge_scene* none = nullptr;
  const auto says = [](const char* part) {
    return std::string(selvedge_last_error()).find(part) != std::string::npos;
  };
  EXPECT_EQ(selvedge_scene_create("{\"geometry\": [{\"cels\": [4, 4]}]}", "wrong.json", &none),
            SELVEDGE_INVALID);
  EXPECT_TRUE(says("wrong.json") && says("cels") && says("cells")) << selvedge_last_error();
  EXPECT_EQ(none, nullptr);

  selvedge_detector* no_detector = nullptr;
  EXPECT_EQ(selvedge_detector_create("bhv_aabb", nullptr, 0.0, &no_detector), SELVEDGE_INVALID);
  EXPECT_TRUE(says("bvh_aabb")) << selvedge_last_error();
  EXPECT_EQ(selvedge_detector_create(nullptr, nullptr, -1.0, &no_detector), SELVEDGE_INVALID);

  Soup soup(9, 3);
  selvedge_surface surface = soup.surface();
  selvedge_contacts* no_contacts = nullptr;
  const Detector finder = detector();
  soup.x_t1[4].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(selvedge_find_collisions(finder.get(), &surface, nullptr, &no_contacts),
            SELVEDGE_INVALID);
  EXPECT_TRUE(says("4")) << selvedge_last_error();
  soup.triangles[2][1] = 77;
  EXPECT_EQ(selvedge_find_contacts(&surface, nullptr, 0.1, &no_contacts), SELVEDGE_INVALID);
  EXPECT_TRUE(says("77")) << selvedge_last_error();
  EXPECT_EQ(no_contacts, nullptr);

  const SimulationHandle now = simulation();
  const double x[3] = {0, 0, 0};
  const std::int32_t far = 1 << 20;
  EXPECT_EQ(selvedge_simulation_hold(now.get(), &far, 1, x), SELVEDGE_INVALID);
  EXPECT_TRUE(says("1048576")) << selvedge_last_error();
  EXPECT_EQ(selvedge_simulation_move_body(now.get(), 0, x, 1), SELVEDGE_INVALID);
  double value = 0.0;
  EXPECT_EQ(selvedge_simulation_figure(now.get(), "max_strech", &value), SELVEDGE_INVALID);
  EXPECT_TRUE(says("max_stretch")) << selvedge_last_error();
  EXPECT_EQ(selvedge_set_threads(-1), SELVEDGE_INVALID);
}

TEST(CInterface, NullIsRefusedOrAnsweredEverywhere) {
  const Detector finder = detector();
  const SimulationHandle now = simulation();
  const Soup soup(10, 3);
  const selvedge_surface surface = soup.surface();
  selvedge_surface hollow = surface;
  hollow.triangles = nullptr;
  selvedge_contacts* contacts = nullptr;
  double number = 0.0;
  const std::vector<int> codes = {
      selvedge_detector_create(nullptr, nullptr, 0.0, nullptr),
      selvedge_find_collisions(nullptr, &surface, nullptr, &contacts),
      selvedge_find_collisions(finder.get(), nullptr, nullptr, &contacts),
      selvedge_find_collisions(finder.get(), &surface, &hollow, &contacts),
      selvedge_find_collisions(finder.get(), &surface, nullptr, nullptr),
      selvedge_find_candidates(nullptr, &surface, nullptr, 0.0, nullptr, nullptr, nullptr),
      selvedge_find_meetings(nullptr, &surface, nullptr, nullptr),
      selvedge_find_contacts(&hollow, nullptr, 0.1, &contacts),
      selvedge_edges(nullptr, 1, nullptr),
      selvedge_mesh_read(nullptr, nullptr),
      selvedge_mesh_read("body.obj", nullptr),
      selvedge_impact_times(nullptr, SELVEDGE_EDGE_EDGE, nullptr, 1, &number),
      selvedge_impact_times(nullptr, SELVEDGE_TRIANGLE_POINT, &number, 0, &number),
      selvedge_touch_times(SELVEDGE_EDGE_EDGE, nullptr, 1, &number, &number),
      selvedge_judge(nullptr, nullptr, nullptr, nullptr),
      selvedge_judge(&surface, nullptr, nullptr, nullptr),
      selvedge_judge_path(&surface, nullptr, nullptr, nullptr),
      selvedge_scene_create(nullptr, nullptr, nullptr),
      selvedge_simulation_create(nullptr, nullptr, 0, nullptr),
      selvedge_simulation_step(nullptr),
      selvedge_simulation_advance(nullptr, 1),
      selvedge_simulation_set_forces(nullptr, nullptr),
      selvedge_simulation_hold(now.get(), nullptr, 1, &number),
      selvedge_simulation_release(nullptr, nullptr, 0),
      selvedge_simulation_move_body(now.get(), 0, nullptr, 1),
      selvedge_simulation_contacts(now.get(), nullptr),
      selvedge_simulation_figure(now.get(), nullptr, &number),
      selvedge_simulation_hash(now.get(), nullptr),
      selvedge_simulation_save(now.get(), nullptr),
      selvedge_simulation_restore(now.get(), nullptr)};
  EXPECT_EQ(codes, std::vector<int>(codes.size(), SELVEDGE_INVALID));
  std::size_t count = 7;
  EXPECT_EQ(selvedge_scene_json(nullptr), nullptr);
  EXPECT_EQ(selvedge_scene_frames(nullptr), 0);
  EXPECT_EQ(selvedge_scene_fps(nullptr), 0.0);
  EXPECT_EQ(selvedge_simulation_positions(nullptr), nullptr);
  EXPECT_EQ(selvedge_simulation_body_begin(nullptr, 1), 0u);
  EXPECT_EQ(selvedge_simulation_triangles(nullptr, &count), nullptr);
  EXPECT_EQ(count, 0u);
  selvedge_contacts_free(nullptr);
  selvedge_pairs_free(nullptr);
  selvedge_mesh_free(nullptr);
  selvedge_state_free(nullptr);
}

TEST(CInterface, ASecondThreadIsRefusedWhileOneSteps) {
  bool refused = false;
  for (int trial = 0; trial < 50 && !refused; ++trial) {
    const SimulationHandle now = simulation();
    std::atomic<bool> done = false;
    std::thread other([&] {
      // The other thread may be inside when this one begins.
      int code = SELVEDGE_BUSY;
      while (code == SELVEDGE_BUSY) code = selvedge_simulation_advance(now.get(), 12);
      EXPECT_EQ(code, SELVEDGE_OK);
      done = true;
    });
    while (!done && !refused) {
      char hash[17];
      const int code = selvedge_simulation_hash(now.get(), hash);
      EXPECT_TRUE(code == SELVEDGE_OK || code == SELVEDGE_BUSY);
      refused = code == SELVEDGE_BUSY;
    }
    other.join();
  }
  ASSERT_TRUE(refused);
  EXPECT_NE(std::string(selvedge_last_error()).find("another thread"), std::string::npos);
}

TEST(CInterface, ThreadsDoNotChangeBits) {
  std::set<std::string> hashes;
  for (const int threads : {1, 3, 0}) {
    ASSERT_EQ(selvedge_set_threads(threads), SELVEDGE_OK);
    const SimulationHandle now = simulation();
    ASSERT_EQ(selvedge_simulation_advance(now.get(), 4), SELVEDGE_OK);
    hashes.insert(hash_of(now));
  }
  EXPECT_EQ(hashes.size(), 1u);
}

std::string text_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Puts a pattern on a body.
int dress_on(const char* pattern, const TriangleMesh& body, double edge_length, char up,
             selvedge_garment** out) {
  const selvedge_surface surface{body.vertices.front().data(), nullptr, body.vertices.size(),
                                 body.triangles.front().data(), body.triangles.size()};
  const selvedge_dress_options options{edge_length, nullptr, 0.0, up, 0};
  return selvedge_dress(pattern, "skirt", &surface, &options, out);
}

TEST(CInterface, DressesAsTheLibraryDoes) {
  const std::string folder = SELVEDGE_SOURCE_DIR "/data/";
  const std::string pattern = text_of(folder + "patterns/flared_skirt.json");
  const TriangleMesh body = read_mesh(folder + "bodies/mannequin_arms_out.ply");
  DressConfig config;
  config.edge_length = 0.06;
  const DressResult expected =
      dress(turned_upright(parse_sewing_pattern(pattern, "skirt"), UpAxis::z), body, config);
  const Garment garment = made<Garment>(
      [&](selvedge_garment** out) { return dress_on(pattern.c_str(), body, 0.06, 'z', out); });
  EXPECT_EQ(selvedge_garment_hash(garment.get()), expected.state_hash);
  EXPECT_EQ(selvedge_garment_verdict(garment.get()), expected.verdict());
  EXPECT_EQ(selvedge_garment_mesh(garment.get())->vertices, expected.garment.vertices.size());
  EXPECT_EQ(selvedge_garment_flat(garment.get())->triangle_count,
            expected.garment.triangles.size());
  EXPECT_EQ(selvedge_garment_body(garment.get())->vertices, body.vertices.size());
  double figure = 0.0;
  EXPECT_EQ(selvedge_garment_figure(garment.get(), "max_stretch", &figure), SELVEDGE_OK);
  EXPECT_EQ(figure, expected.max_stretch);
  EXPECT_EQ(selvedge_garment_figure(garment.get(), "stretch", &figure), SELVEDGE_INVALID);
}

TEST(CInterface, RefusesGarmentsThatCannotBePutOn) {
  const std::string folder = SELVEDGE_SOURCE_DIR "/data/";
  const std::string pattern = text_of(folder + "patterns/flared_skirt.json");
  const TriangleMesh body = read_mesh(folder + "bodies/mannequin_arms_out.ply");
  selvedge_garment* garment = nullptr;
  EXPECT_EQ(dress_on("{}", body, 0.06, 'z', &garment), SELVEDGE_INVALID);
  EXPECT_EQ(dress_on(pattern.c_str(), body, 0.0, 'z', &garment), SELVEDGE_INVALID);
  EXPECT_EQ(dress_on(pattern.c_str(), body, 0.06, 'w', &garment), SELVEDGE_INVALID);
  EXPECT_EQ(selvedge_dress(pattern.c_str(), nullptr, nullptr, nullptr, &garment), SELVEDGE_INVALID);
  EXPECT_EQ(garment, nullptr);
  selvedge_garment_free(garment);
}

TEST(CInterface, NamesTheMethodsAndTheVersion) {
  EXPECT_EQ(selvedge_interface_version(), 1);
  EXPECT_NE(std::string(selvedge_version()).find("licence: MIT"), std::string::npos);
  std::set<std::string> names;
  for (std::size_t i = 0; selvedge_broad_phase(i) != nullptr; ++i)
    names.insert(selvedge_broad_phase(i));
  EXPECT_TRUE(names.contains("bvh_aabb"));
  for (const std::string& name : names)
    made<Detector>([&](selvedge_detector** out) {
      return selvedge_detector_create(name.c_str(), nullptr, 0.0, out);
    });
  EXPECT_NE(selvedge_narrow_phase(0), nullptr);
  EXPECT_EQ(selvedge_narrow_phase(1000), nullptr);
}

/// The first group of each match.
std::set<std::string> matches(const std::string& text, const std::regex& pattern) {
  std::set<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at)
    found.insert((*at)[1]);
  return found;
}

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  EXPECT_EQ(pclose(pipe), 0) << command;
  return text;
}

TEST(CInterface, TheLibraryExportsTheSymbolsOfTheListAndNoOther) {
  const std::string folder = SELVEDGE_SOURCE_DIR "/bindings/c/";
  const std::set<std::string> listed =
      matches(text_of(folder + "exported.map"), std::regex("    (selvedge_\\w+);"));
  EXPECT_EQ(listed, matches(text_of(folder + "selvedge.h"),
                            std::regex("SELVEDGE_API[^;]*?\\b(selvedge_\\w+)\\(")));
  const std::string symbols = output_of("nm -D --defined-only " SELVEDGE_C_LIBRARY);
  EXPECT_EQ(listed, matches(symbols, std::regex(" T (\\w+)")));
  const std::set<std::string> others = matches(symbols, std::regex(" [^TA] (\\S+)"));
  EXPECT_TRUE(others.empty()) << *others.begin();
}

}  // namespace
}  // namespace selvedge::c_interface_test
