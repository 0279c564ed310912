// SPDX-License-Identifier: MIT
//
// Flat patterns as rest shapes, seams, and cloth that becomes wet.
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/run/run.h>
#include <selvedge/simulation/simulation_state.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace selvedge::garment_test {
namespace {

namespace fs = std::filesystem;
constexpr double pi = std::numbers::pi;

/// A cone and the three quarters of a flat ring that it is made of; the seam at angle 0.
struct Skirt {
  TriangleMesh surface, pattern;
};
Skirt make_skirt(int sides, int rings) {
  const double turn = 1.5 * pi, sine = turn / (2.0 * pi), cosine = std::sqrt(1.0 - sine * sine);
  Skirt skirt;
  for (int j = 0; j <= rings; ++j) {
    const double r = 0.16 + 0.4 * j / rings;
    for (int k = 0; k <= sides; ++k) {
      const double a = 2.0 * pi * k / sides, flat = turn * k / sides;
      if (k < sides)
        skirt.surface.vertices.emplace_back(r * sine * std::cos(a), r * sine * std::sin(a),
                                            -r * cosine);
      skirt.pattern.vertices.emplace_back(r * std::cos(flat), r * std::sin(flat), 0.0);
    }
  }
  for (int j = 0; j < rings; ++j)
    for (int k = 0; k < sides; ++k) {
      const auto corner = [&](int ring, int spoke) { return ring * sides + spoke % sides; };
      const auto place = [&](int ring, int spoke) { return ring * (sides + 1) + spoke; };
      skirt.surface.triangles.push_back({corner(j, k), corner(j + 1, k), corner(j + 1, k + 1)});
      skirt.surface.triangles.push_back({corner(j, k), corner(j + 1, k + 1), corner(j, k + 1)});
      skirt.pattern.triangles.push_back({place(j, k), place(j + 1, k), place(j + 1, k + 1)});
      skirt.pattern.triangles.push_back({place(j, k), place(j + 1, k + 1), place(j, k + 1)});
    }
  return skirt;
}

TEST(Pattern, ASewnConeHasTheMassOfItsClothAndNoStrain) {
  const Skirt skirt = make_skirt(96, 12);
  const Material m;
  const ClothMesh cloth = make_from_pattern(skirt.surface, skirt.pattern, m);
  const double mass = std::accumulate(cloth.mass.begin(), cloth.mass.end(), 0.0);
  EXPECT_NEAR(mass, m.density * surface_area(skirt.pattern.vertices, skirt.pattern.triangles),
              1e-12);
  const StrainSummary strain =
      summary_of(triangle_strains(cloth.surface.vertices, cloth.surface.triangles, skirt.pattern));
  EXPECT_LT(strain.max, 1e-3);  // chords of a circle and of its roll
  EXPECT_GT(strain.min, -1e-3);
  EXPECT_LT(spring_strains(cloth.springs, cloth.surface.vertices).rms, 1e-3);
}

TEST(Pattern, BothSidesOfASeamKeepTheirSpringsAndItFoldsFreely) {
  const Skirt skirt = make_skirt(16, 4);
  const ClothMesh cloth = make_from_pattern(skirt.surface, skirt.pattern, Material{});
  const ClothMesh flat = make_from_mesh(skirt.pattern, skirt.pattern, Material{});
  EXPECT_EQ(cloth.springs.size(), flat.springs.size());
  EXPECT_EQ(cloth.hinges.size(), flat.hinges.size());
  const auto on_seam =
      std::count_if(cloth.springs.begin(), cloth.springs.end(),
                    [](const Spring& s) { return s.a % 16 == 0 && s.b % 16 == 0; });
  EXPECT_EQ(on_seam, 2 * 4);
}

TEST(Pattern, OnesThatDoNotFitAreRefused) {
  const Skirt skirt = make_skirt(8, 2);
  TriangleMesh fewer = skirt.pattern;
  fewer.triangles.pop_back();
  EXPECT_THROW(make_from_pattern(skirt.surface, fewer, Material{}), std::invalid_argument);
  TriangleMesh shared = skirt.pattern;
  shared.triangles[0][0] = shared.triangles[3][1];
  EXPECT_THROW(make_from_pattern(skirt.surface, shared, Material{}), std::invalid_argument);
  TriangleMesh folded = skirt.pattern;
  for (Vec3& p : folded.vertices) p.y() = 0.0;
  EXPECT_THROW(make_from_pattern(skirt.surface, folded, Material{}), std::invalid_argument);
}

class Folder : public ::testing::Test {
 protected:
  Folder() : folder_(fs::temp_directory_path() / ("garment_test_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~Folder() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::string refusal(const std::string& text) const {
    try {
      read_pattern(write("bad.obj", text));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "was read";
  }

  fs::path folder_;
};

TEST_F(Folder, ThePatternIsReadCornerByCorner) {
  const fs::path file = write("quad.obj",
                              "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvt 0 0\nvt 2 0\nvt 2 2\nvt 0 2\n"
                              "f 1/1/9 2/2/9 3/3/9 4/-1/9\n");
  const TriangleMesh pattern = read_pattern(file, 0.5);
  ASSERT_EQ(pattern.triangles.size(), 2u);
  EXPECT_EQ(pattern.triangles[1], (Triangle{0, 2, 3}));
  EXPECT_EQ(pattern.vertices[2], Vec3(1, 1, 0));
  EXPECT_NE(refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").find("no texture coordinate"),
            std::string::npos);
  EXPECT_NE(refusal("v 0 0 0\nvt 0 0\nf 1/1 1/2 1/3\n").find("line 3"), std::string::npos);
}

TEST_F(Folder, SeamsCloseToTheThicknessOfTheCloth) {
  const fs::path file = write("scene.json", R"({"gravity": [0, 0, 0],
    "geometry": [{"name": "left", "size": [0.2, 0.2], "cells": [6, 6], "transformation": {"translation": [-0.13, 0, 0]}},
                 {"name": "right", "size": [0.2, 0.2], "cells": [6, 6], "transformation": {"translation": [0.13, 0, 0.01]}}],
    "seams": [{"sides": [{"geometry": "left", "select": "x1"}, {"geometry": "right", "select": "x0"}]}],
    "air": {"viscous_drag": 0.5}, "time": {"frames": 60, "fps": 60, "steps_per_frame": 1}})");
  const Scene scene = read_scene(file);
  Simulation simulation(scene, build_scene(scene));
  simulation.advance_to_frame(60, {});
  const auto& x = simulation.state().x;
  for (int j = 0; j <= 6; ++j) {
    const double gap = (x[7 * j + 6] - x[49 + 7 * j]).norm();
    EXPECT_LT(gap, 1.5 * scene.contact.rest_gap) << j;
  }
  EXPECT_TRUE(simulation.result().clean);
}

TEST_F(Folder, SeamsThatCannotBeSewnAreRefused) {
  const auto refused = [&](const std::string& seams) -> std::string {
    try {
      read_scene(
          write("scene.json",
                R"({"geometry": [{"name": "a", "cells": [4, 6]}], "seams": [)" + seams + "]}"));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "was read";
  };
  const std::string uneven = refused(R"({"sides": [{"select": "x0"}, {"select": "y0"}]})");
  EXPECT_NE(uneven.find("one side has 7 particles and the other 5"), std::string::npos) << uneven;
  const std::string itself = refused(R"({"sides": [{"select": "x0"}, {"select": "x0"}]})");
  EXPECT_NE(itself.find("sewn to itself"), std::string::npos) << itself;
}

const char* const wet = R"({
    "geometry": [{"name": "cloth", "size": [0.3, 0.3], "cells": [8, 8], "transformation": {"translation": [0, 0, 1]}}],
    "handles": [{"select": "y1"}],
    "water": {"diffusivity": 1e-4, "saturation": 0.5,
      "sources": [{"select": [40, 41], "rate": 0.05, "begin": 0.05, "end": 0.15}]},
    "time": {"frames": 12, "fps": 60, "steps_per_frame": 1}})";

TEST_F(Folder, WaterThatFellIsInTheClothOrHasDripped) {
  const Scene scene = read_scene(write("wet.json", wet));
  BuiltScene built = build_scene(scene);
  const std::vector<double> dry = built.cloth.mass;
  Simulation simulation(scene, std::move(built));
  simulation.advance_to_frame(12, {});
  const std::vector<double>& water = simulation.state().water;
  ASSERT_EQ(water.size(), dry.size());
  const double held = std::accumulate(water.begin(), water.end(), 0.0);
  const double dripped = simulation.result().counters.at("dripped_kg");
  EXPECT_NEAR(held + dripped, 0.05 * 0.1, 1e-12);
  EXPECT_GT(dripped, 0.0);
  for (std::size_t i = 0; i < dry.size(); ++i) {
    EXPECT_NEAR(simulation.mass()[i], dry[i] + water[i], 1e-15);
    EXPECT_LE(water[i], 0.5 * dry[i] * (1.0 + 1e-12));
  }
  EXPECT_GT(water[31], 0.0) << "beside where it fell";
}

TEST_F(Folder, AWetRunResumesToTheSameBits) {
  const fs::path file = write("wet.json", wet);
  const Scene scene = read_scene(file);
  RunConfig config;
  config.out = folder_ / "whole";
  const RunResult whole = run_scene(scene, config);
  config.out = folder_ / "parts";
  config.max_steps = 6;
  run_scene(scene, config);
  config.max_steps = 0;
  config.resume = true;
  EXPECT_EQ(run_scene(scene, config).state_hash, whole.state_hash);
}

}  // namespace
}  // namespace selvedge::garment_test
