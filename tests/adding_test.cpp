// SPDX-License-Identifier: MIT
// The examples of docs/adding.md: the page links to the files of examples/adding, and each addition
// works where it is registered.
#include <gtest/gtest.h>
#include <selvedge/run/run.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "additions.h"
#include "owned_surface.h"

namespace {

using namespace selvedge;
namespace fs = std::filesystem;

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(AddingPage, LinksToEveryExample) {
  const fs::path root = SELVEDGE_SOURCE_DIR;
  const std::string page = read(root / "docs/adding.md");
  int examples = 0;
  for (const auto& entry : fs::directory_iterator(root / "examples/adding")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string file = entry.path().filename();
    EXPECT_NE(page.find("(../examples/adding/" + file + ")"), std::string::npos) << file;
    ++examples;
  }
  EXPECT_EQ(examples, 7);
}

/// A sheet over a ball that is near enough to be hit soon.
Scene small_scene() {
  Scene scene;
  scene.materials["default"] = {.density = 0.2};
  scene.cloths.emplace_back().shape =
      ClothGrid{.grid = {.size_x = 0.4, .size_y = 0.4, .cells_x = 6, .cells_y = 6}};
  scene.cloths[0].placement.translation = {0.0, 0.0, 0.105};
  scene.bodies.emplace_back().shape = BodyShape{Sphere{.radius = 0.1}, 12};
  scene.time = {.frames = 6};
  return scene;
}

/// The positions after the last frame.
std::vector<Vec3> end_of(const Scene& scene, const Methods& methods) {
  Simulation simulation(scene, methods);
  simulation.advance_to_frame(scene.time.frames);
  EXPECT_TRUE(simulation.result().clean);
  const auto x = simulation.positions();
  return {x.begin(), x.end()};
}

Methods methods_with_additions() {
  Methods methods;
  adding::register_one_axis(methods.broad_phases);
  adding::register_sampled(methods.narrow_phases);
  adding::register_stop(methods.responses);
  adding::register_dragged_euler(methods.integrators);
  adding::register_threads(methods.patterns);
  return methods;
}

TEST(Adding, TheDetectorReportsEveryPairOfBruteForce) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  OwnedSurface s;
  for (int i = 0; i < 30; ++i) {
    s.x_t0.push_back({coordinate(random), coordinate(random), coordinate(random)});
    s.x_t1.push_back(s.x_t0.back() + 0.1 * Vec3(coordinate(random), coordinate(random), 0.0));
  }
  for (std::int32_t i = 0; i + 2 < 30; i += 2) s.triangles.push_back({i, i + 1, i + 2});
  s.edges = unique_edges(s.triangles);
  s.thickness = 0.01;
  const Methods methods = methods_with_additions();
  for (const double axis : {0.0, 1.0, 2.0}) {
    const auto added = methods.broad_phases.at("one_axis")({{"axis", axis}});
    CandidatePairs found, all;
    added->find_self_pairs(s.view(), found);
    make_brute_force()->find_self_pairs(s.view(), all);
    EXPECT_TRUE(std::includes(found.edge_edge.begin(), found.edge_edge.end(), all.edge_edge.begin(),
                              all.edge_edge.end()));
    EXPECT_TRUE(std::includes(found.point_triangle.begin(), found.point_triangle.end(),
                              all.point_triangle.begin(), all.point_triangle.end()));
    EXPECT_FALSE(all.edge_edge.empty());
  }
  EXPECT_THROW(methods.broad_phases.at("one_axis")({{"axis", 3.0}}), std::invalid_argument);
}

TEST(Adding, TheDetectorLeadsASceneToTheSameBits) {
  Scene scene = small_scene();
  const std::vector<Vec3> usual = end_of(scene, {});
  scene.contact.broad_phase = "one_axis";
  EXPECT_EQ(end_of(scene, methods_with_additions()), usual);
}

TEST(Adding, TheNarrowPhaseFindsASlowCollisionAndMissesAFastOne) {
  const Methods methods = methods_with_additions();
  const auto sampled = methods.narrow_phases.at("sampled")({{"samples", 4.0}});
  const Vec3 corners[] = {{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}};
  const auto falls = [&](double from, double to) {
    Query query{ContactKind::point_triangle, {}, {}};
    query.x_t0 = {Vec3(0, 0, from), corners[0], corners[1], corners[2]};
    query.x_t1 = {Vec3(0, 0, to), corners[0], corners[1], corners[2]};
    double toi = -1.0;
    return sampled->collides(query, toi) ? toi : -1.0;
  };
  EXPECT_EQ(falls(1.0, -1.0), 0.5);
  EXPECT_EQ(falls(1.0, -2.0), -1.0);  // between two samples
  EXPECT_EQ(falls(1.0, 0.5), -1.0);
}

TEST(Adding, TheResponseKeepsAScenesClothAboveItsBody) {
  Scene scene = small_scene();
  scene.contact.response = "stop";
  const std::vector<Vec3> x = end_of(scene, methods_with_additions());
  const Vec3& middle = x[x.size() / 2];
  EXPECT_GT(middle.z(), 0.1);
  EXPECT_NE(x, end_of(small_scene(), {}));
}

TEST(Adding, TheIntegratorSlowsAFall) {
  Scene scene = small_scene();
  scene.bodies.clear();
  scene.solver.integrator = "dragged_euler";
  scene.solver.integrator_options = {{"drag", 0.0}};
  const double free = end_of(scene, methods_with_additions())[0].z();
  scene.solver.integrator_options = {{"drag", 50.0}};
  EXPECT_GT(end_of(scene, methods_with_additions())[0].z(), free + 0.01);
  scene.solver.integrator_options = {{"drags", 50.0}};
  EXPECT_THROW(end_of(scene, methods_with_additions()), std::invalid_argument);
}

TEST(Adding, TheForceIsMinusTheGradientOfItsEnergy) {
  ClothMesh cloth = make_rectangular({.cells_x = 1, .cells_y = 1}, Material{});
  ForceLawRegistry laws;
  adding::register_weight_spring(laws);
  ForceList forces = make_internal_forces(cloth, laws);
  ASSERT_EQ(forces.size(), 1u);
  std::vector<Vec3> x = cloth.surface.vertices, v(x.size(), Vec3::Zero()), f(v);
  for (std::size_t i = 0; i < x.size(); ++i) x[i].z() = 0.1 * (1.0 + static_cast<double>(i));
  forces[0]->add_force({x, v, cloth.mass}, f);
  for (std::size_t i = 0; i < x.size(); ++i) {
    constexpr double kStep = 1e-6;
    std::vector<Vec3> up = x, down = x;
    up[i].z() += kStep;
    down[i].z() -= kStep;
    const double slope =
        (forces[0]->energy({up, v, cloth.mass}) - forces[0]->energy({down, v, cloth.mass})) /
        (2.0 * kStep);
    EXPECT_NEAR(f[i].z(), -slope, 1e-6);
    EXPECT_LT(f[i].z(), 0.0);
  }
}

TEST(Adding, TheForceActsInASceneAndItsEnergyIsListed) {
  Scene scene = small_scene();
  scene.bodies.clear();
  const double free = end_of(scene, {})[0].z();
  Methods methods;
  adding::register_weight_spring(methods.force_laws);
  EXPECT_LT(end_of(scene, methods)[0].z(), free - 1e-4);
  Simulation simulation(scene, methods);
  const double height = scene.cloths[0].placement.translation.z();  // ½ m ω² z²
  EXPECT_NEAR(simulation.energies().at("weight_spring"), 0.5 * 0.2 * 0.16 * 4.0 * height * height,
              1e-12);
  EXPECT_FALSE(Simulation(scene).energies().contains("weight_spring"));
}

TEST(Adding, ASceneSetsAnOptionOfTheForceLaw) {
  Scene scene = small_scene();
  scene.bodies.clear();
  Methods methods;
  adding::register_weight_spring(methods.force_laws);
  const double weak = end_of(scene, methods)[0].z();
  const double energy = Simulation(scene, methods).energies().at("weight_spring");
  scene.force_laws["weight_spring"] = {{"omega", 4.0}};  // twice the default
  EXPECT_LT(end_of(scene, methods)[0].z(), weak - 1e-4);
  EXPECT_NEAR(Simulation(scene, methods).energies().at("weight_spring"), 4.0 * energy, 1e-12);
  scene.force_laws["weight_spring"] = {{"omgea", 4.0}};
  EXPECT_THROW(Simulation(scene, methods), std::invalid_argument);
  scene.force_laws = {{"weight_sprnig", {{"omega", 4.0}}}};
  EXPECT_THROW(Simulation(scene, methods), std::invalid_argument);
}

TEST(Adding, ThePatternHasTheMassOfItsClothAndNoDiagonals) {
  const ClothMesh cloth = methods_with_additions().patterns.at("threads")(
      {.size_x = 0.4, .size_y = 0.2, .cells_x = 4, .cells_y = 2}, {.density = 0.5});
  double mass = 0.0;
  for (const double m : cloth.mass) mass += m;
  EXPECT_NEAR(mass, 0.5 * 0.4 * 0.2, 1e-15);
  EXPECT_EQ(cloth.springs.size(), 4u * 3u + 5u * 2u);
  for (const Spring& s : cloth.springs) EXPECT_NEAR(s.rest_length, 0.1, 1e-15);
  EXPECT_FALSE(make_internal_forces(cloth).empty());
}

TEST(Adding, ASceneNamesThePatternAndItsOptions) {
  Scene scene = small_scene();
  auto& grid = std::get<ClothGrid>(scene.cloths[0].shape);
  grid.pattern = "threads";
  grid.pattern_options = {{"weft", 0.5}};
  const Methods methods = methods_with_additions();
  const ClothMesh cloth = build_scene(scene, methods).cloth;
  EXPECT_EQ(cloth.springs.size(), 2u * 6u * 7u);
  EXPECT_EQ(cloth.springs[1].stiffness, 0.5 * cloth.springs[0].stiffness);
  EXPECT_THROW(build_scene(scene), std::invalid_argument);
  grid.pattern_options = {{"weft", 0.0}};
  EXPECT_THROW(build_scene(scene, methods), std::invalid_argument);
}

TEST(Adding, ARunWritesTheFormatThatItsSceneNames) {
  Scene scene = small_scene();
  scene.output.formats = {"points"};
  scene.output.format_options["points"] = {{"digits", 3.0}};
  RunConfig config;
  config.out = fs::path(::testing::TempDir()) / ("selvedge_adding_" + std::to_string(getpid()));
  adding::register_points(config.formats);
  EXPECT_TRUE(run_scene(scene, config).clean);
  std::ifstream in(config.out / "frames/cloth_00000.xyz");
  std::size_t lines = 0;
  for (std::string line; std::getline(in, line);)
    if (++lines == 1) {
      EXPECT_EQ(line, "-0.2 -0.2 0.105");
    }
  EXPECT_EQ(lines, 49u);
  fs::remove_all(config.out);
}

}  // namespace
