// SPDX-License-Identifier: MIT
//
// Seams whose pairs of vertices become one: the mesh, its forces, the motion there, and runs.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/run/check_result.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/internal/seam_merging.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "scene_runs.h"

namespace selvedge::seam_merging_test {
namespace {

namespace fs = std::filesystem;

/// Two panels of 5 x 4 particles, side by side with a gap of 1 cm, and their seam.
struct TwoPanels {
  ClothMesh open;
  std::vector<std::int32_t> number, kept;  // of the closed seam

  explicit TwoPanels(const Material& material = {}) {
    const GridConfig grid{0.4, 0.3, 4, 3};
    const ClothMesh panel = make_rectangular(grid, material);
    append(open, panel);
    append(open, panel);
    for (std::size_t i = 0; i < 20; ++i) open.surface.vertices[i].x() -= 0.205;
    for (std::size_t i = 20; i < 40; ++i) open.surface.vertices[i].x() += 0.205;
    for (std::int32_t i = 0; i < 40; ++i) {
      const bool sewn = i >= 20 && i % 5 == 0;  // to the last one of the row of the left panel
      if (!sewn) kept.push_back(i);
      number.push_back(sewn ? number[i - 16] : static_cast<std::int32_t>(kept.size()) - 1);
    }
  }
  ClothMesh closed() const { return merge_vertices(open, number, kept); }
};

std::vector<Vec3> forces_on(const ClothMesh& cloth, std::span<const Vec3> x,
                            std::span<const Vec3> v) {
  std::vector<Vec3> f(x.size(), Vec3::Zero());
  for (const auto& force : make_internal_forces(cloth))
    force->add_force({x, v, cloth.mass, 0.0}, f);
  return f;
}

TEST(MergedVertices, CarryTheForcesAndTheMassOfBothSides) {
  Material material;
  material.spring_damping = 0.02;
  material.bending_damping = 0.03;
  const TwoPanels panels(material);
  const ClothMesh closed = panels.closed();
  std::vector<Vec3> x, v, all_x, all_v;
  for (std::size_t j = 0; j < closed.mass.size(); ++j) {
    x.push_back(closed.surface.vertices[j] +
                0.02 * Vec3(std::sin(7.0 * j), std::cos(3.0 * j), std::sin(2.0 * j + 1.0)));
    v.push_back(Vec3(std::cos(5.0 * j), std::sin(4.0 * j), std::cos(j)));
  }
  for (const std::int32_t j : panels.number) {
    all_x.push_back(x[j]);
    all_v.push_back(v[j]);
  }
  const std::vector<Vec3> merged = forces_on(closed, x, v);
  const std::vector<Vec3> parts = forces_on(panels.open, all_x, all_v);
  std::vector<Vec3> sum(x.size(), Vec3::Zero());
  std::vector<double> mass(x.size(), 0.0);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    sum[panels.number[i]] += parts[i];
    mass[panels.number[i]] += panels.open.mass[i];
  }
  for (std::size_t j = 0; j < x.size(); ++j) {
    EXPECT_LT((merged[j] - sum[j]).norm(), 1e-10) << j;
    EXPECT_NEAR(closed.mass[j], mass[j], 1e-18);
  }
}

TEST(MergedVertices, HaveNoElementTwice) {
  const TwoPanels panels;
  const ClothMesh closed = panels.closed();
  EXPECT_EQ(closed.surface.vertices.size(), 36u);
  EXPECT_EQ(closed.surface.triangles.size(), panels.open.surface.triangles.size());
  EXPECT_EQ(closed.edges.size(), panels.open.edges.size() - 3u);
  EXPECT_EQ(closed.springs.size(), panels.open.springs.size() - 3u);
  EXPECT_EQ(closed.strain_limit.size(), closed.springs.size());
  EXPECT_EQ(closed.hinges.size(), panels.open.hinges.size());
  std::set<Edge> ends;
  for (const Spring& s : closed.springs)
    EXPECT_TRUE(ends.insert({std::min(s.a, s.b), std::max(s.a, s.b)}).second) << s.a << " " << s.b;
}

TEST(MergedVertices, OfOneTriangleAreRefused) {
  const ClothMesh panel = make_rectangular({1.0, 1.0, 1, 1}, Material{});
  const std::vector<std::int32_t> number{0, 0, 1, 2}, kept{0, 2, 3};
  EXPECT_THROW(merge_vertices(panel, number, kept), std::invalid_argument);
}

class SeamScenes : public SceneRuns {};

/// Two panels in a plane, 6 cm apart, of 5 x 4 particles each.
std::string panels(const std::string& seam, const std::string& more = "") {
  return R"({"geometry": [
    {"name": "left", "size": [0.2, 0.15], "cells": [4, 3],
     "transformation": {"translation": [-0.13, 0, 0]}},
    {"name": "right", "size": [0.2, 0.15], "cells": [4, 3],
     "transformation": {"translation": [0.13, 0, 0.01]}}],
  "seams": [{"sides": [{"geometry": "left", "select": "x1"},
    {"geometry": "right", "select": "x0"}], "pull": 20, )" +
         seam + R"(}], "contact": {"rest_gap": 0.001}, "gravity": [0, 0, 0],
  "time": {"frames": 24, "fps": 60})" +
         more + "}";
}

const std::string kMerge = R"("merge": 0.003)";

TEST_F(SeamScenes, AClosedSeamHasOneVertexForEachPair) {
  config_.every_step = true;
  const RunResult result = run_scene(read(panels(kMerge)), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_EQ(result.counters.at("merged_pairs"), 4.0);
  EXPECT_EQ(result.counters.count("merged_pairs_postponed"), 0u);
  EXPECT_EQ(vertices_of_frame(0), 40u);
  EXPECT_EQ(vertices_of_frame(24), 36u);
  EXPECT_EQ(result.measures.at("energy_seams_J"), 0.0);
  const ResultCheck check = check_result(config_.out.string());
  EXPECT_EQ(check.first_faulty, "");
  EXPECT_GE(check.merges, 1u);
  EXPECT_EQ(check.paths + 1, check.states);  // the merges have a path, and it was judged
}

TEST_F(SeamScenes, WithoutMergeTheSeamStaysOpen) {
  const RunResult result = run_scene(read(panels(R"("merge": 0)")), config_);
  EXPECT_EQ(result.counters.count("merged_pairs"), 0u);
  EXPECT_EQ(vertices_of_frame(24), 40u);
}

TEST_F(SeamScenes, AResumedRunGoesOnToTheSameBits) {
  const std::string whole = run_scene(read(panels(kMerge)), config_).state_hash;
  ASSERT_EQ(vertices_of_frame(20), 36u);
  config_.out = folder_ / "in_parts";
  run_scene(read(panels(kMerge), {{"time.frames", "20"}}), config_);
  config_.resume = true;
  EXPECT_EQ(run_scene(read(panels(kMerge)), config_).state_hash, whole);
}

TEST_F(SeamScenes, OneThreadAndTwoGiveTheSameBits) {
  std::string hash[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    hash[threads - 1] = run_scene(read(panels(kMerge)), config_).state_hash;
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST_F(SeamScenes, StepsInMemoryMergeToTheBitsOfARun) {
  const Scene s = read(panels(kMerge));
  Simulation simulation(s);
  simulation.advance_to_frame(s.time.frames);
  EXPECT_EQ(simulation.result().counters.at("merged_pairs"), 4.0);
  EXPECT_EQ(simulation.result().state_hash, run_scene(s, config_).state_hash);
}

TEST_F(SeamScenes, ABodyThatAnswersStaysAsItIsInAMerge) {
  const Scene s = read(panels(kMerge, R"(, "obstacles": [{"name": "ball", "mass": 0.2,
    "shape": {"type": "sphere", "radius": 0.03, "resolution": 6},
    "transformation": {"translation": [0, 0.4, 0]}}])"));
  Simulation simulation(s);
  const std::size_t before = simulation.positions().size();
  const std::int32_t leader = simulation.built().solids[0].leader;
  const Vec3 place = simulation.positions()[leader];
  simulation.advance_to_frame(s.time.frames);
  ASSERT_EQ(simulation.result().counters.at("merged_pairs"), 4.0);
  ASSERT_EQ(simulation.positions().size(), before - 4);
  const BuiltSolid& ball = simulation.built().solids[0];
  EXPECT_EQ(ball.leader, leader - 4);
  EXPECT_LT((simulation.positions()[ball.leader] - place).norm(), 1e-12);
}

/// The panels of `panels` at the start of a simulation in which their sides are 2 mm apart.
struct Near {
  Scene scene;
  BuiltScene built;
  SimulationState state;

  explicit Near(Scene s) : scene(std::move(s)), built(build_scene(scene)) {
    state.x = built.cloth.surface.vertices;
    for (std::size_t i = 0; i < 40; ++i) {
      state.x[i].x() += i < 20 ? 0.029 : -0.029;
      state.x[i].z() = 0.0;
      state.v.push_back(0.1 * Vec3(std::sin(9.0 * i), std::cos(5.0 * i), std::sin(2.0 * i)));
    }
    for (std::size_t i = 40; i < built.cloth.mass.size(); ++i) {
      state.x[i] = built.cloth.surface.vertices[i];
      state.v.emplace_back(0.0, 0.0, 0.0);
    }
  }
  Simulation simulation() const {
    return Simulation(with_fixed_mesh(scene), build_scene(scene), state);
  }
};

TEST_F(SeamScenes, TheMergeKeepsMassMomentumAndCentreOfMass) {
  const std::string heavy =
      R"(, "weights": [{"geometry": "right", "select": "x0", "mass": 0.002}])";
  Near near(read(panels(kMerge, heavy)));
  SeamMerging merging(near.scene, near.built, cloth_patterns());
  const SeamMerging::Due due = merging.due(near.simulation());
  ASSERT_EQ(due.event.pairs.size(), 4u);
  SimulationState after = near.state;
  merging.merge(due.event, after);
  const BuiltScene merged = merging.build();
  ASSERT_EQ(after.x.size(), 36u);
  Vec3 p = Vec3::Zero(), q = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < 40; ++i) {
    p += near.built.cloth.mass[i] * near.state.v[i];
    q += near.built.cloth.mass[i] * near.state.x[i];
    mass += near.built.cloth.mass[i];
  }
  for (std::size_t j = 0; j < 36; ++j) {
    p -= merged.cloth.mass[j] * after.v[j];
    q -= merged.cloth.mass[j] * after.x[j];
    mass -= merged.cloth.mass[j];
  }
  EXPECT_LT(p.norm(), 1e-17);
  EXPECT_LT(q.norm(), 1e-17);
  EXPECT_NEAR(mass, 0.0, 1e-17);
  EXPECT_EQ(after.x[0], near.state.x[0]);  // others keep their bits
  EXPECT_EQ(after.v[35], near.state.v[39]);
  EXPECT_EQ(merged.piece_begin, (std::vector<std::int32_t>{0, 20, 36}));
  EXPECT_TRUE(merged.seams[0].empty());
}

TEST_F(SeamScenes, APairWithSomethingInBetweenIsPostponedUnlessExcluded) {
  // A strip of cloth stands on edge between the two lowest pairs.
  const std::string strip = R"({"name": "strip", "size": [0.01, 0.06], "cells": [1, 3],
    "transformation": {"rotation": {"axis": [0, 1, 0], "angle_deg": 90},
                       "translation": [0, -0.06, 0]}, "material": "default"})";
  std::string json = panels(R"("merge": 0.003)");
  json.replace(json.find("}],\n  \"seams\""), 2, "}, " + strip + "]");
  json.replace(json.find("0.001"), 5, "1e-4 ");
  Near near(read(json));
  SeamMerging merging(near.scene, near.built, cloth_patterns());
  const SeamMerging::Due due = merging.due(near.simulation());
  // The upper one of the two is above the strip: it merges once the lower one is left out.
  EXPECT_EQ(due.postponed, 1u);
  EXPECT_EQ(due.event.pairs.size(), 3u);
  for (const Edge& pair : due.event.pairs) EXPECT_GT(near.state.x[pair[0]].y(), -0.03);

  const auto postponed_without = [&](const std::string& excluded) {
    std::string text = json;
    text.replace(text.find("\"contact\": {"), 12, "\"contact\": {\"pairs\": [" + excluded + "], ");
    Near other(read(text));
    return SeamMerging(other.scene, other.built, cloth_patterns())
        .due(other.simulation())
        .postponed;
  };
  const std::string left = R"({"a": "strip", "b": "left", "collide": false})";
  const std::string right = R"({"a": "strip", "b": "right", "collide": false})";
  EXPECT_EQ(postponed_without(left + ", " + right), 0u);
  EXPECT_EQ(postponed_without(left), 1u) << "the right panel meets the strip";
}

TEST_F(SeamScenes, AHeldParticleKeepsItsPlaceAndTwoHeldOnesStayApart) {
  const std::string one = R"(, "handles": [{"geometry": "right", "select": "x0"}])";
  const std::string both =
      R"(, "handles": [{"geometry": "right", "select": "x0"},
                       {"geometry": "left", "select": [4]}])";
  Near near(read(panels(kMerge, one)));
  SeamMerging merging(near.scene, near.built, cloth_patterns());
  const SeamMerging::Due due = merging.due(near.simulation());
  ASSERT_EQ(due.event.pairs.size(), 4u);
  SimulationState after = near.state;
  merging.merge(due.event, after);
  const Scene now = merging.scene();
  const BuiltScene built = merging.build();
  ASSERT_EQ(now.handles[0].vertices.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    const std::int32_t held = built.piece_begin[1] + now.handles[0].vertices[k];
    EXPECT_EQ(after.x[held], near.state.x[20 + 5 * k]);
    EXPECT_EQ(built.cloth.surface.vertices[held], near.built.cloth.surface.vertices[20 + 5 * k]);
  }
  Near apart(read(panels(kMerge, both)));
  SeamMerging other(apart.scene, apart.built, cloth_patterns());
  EXPECT_EQ(other.due(apart.simulation()).event.pairs.size(), 3u);
}

TEST_F(SeamScenes, TheCornerOfABagStaysOpen) {
  // Two panels above each other, sewn along two sides: at one of their common corners, the
  // triangles of both panels would become one.
  const auto bag = [](const char* other) {
    return std::string(R"({"geometry": [
    {"name": "front", "size": [0.1, 0.1], "cells": [3, 3]},
    {"name": "back", "size": [0.1, 0.1], "cells": [3, 3],
     "transformation": {"translation": [0, 0, 0.002]}}],
  "seams": [{"sides": [{"geometry": "front", "select": "y0"},
             {"geometry": "back", "select": "y0"}], "merge": 0.003},
            {"sides": [{"geometry": "front", "select": ")") +
           other + R"("},
             {"geometry": "back", "select": ")" +
           other + R"("}], "merge": 0.003}],
  "contact": {"rest_gap": 0.001}})";
  };
  std::size_t merged[2] = {0, 0};
  for (const int k : {0, 1}) {
    const Scene s = read(bag(k == 0 ? "x0" : "x1"));
    const BuiltScene built = build_scene(s);
    SeamMerging merging(s, built, cloth_patterns());
    const SeamMerging::Due due = merging.due(Simulation(with_fixed_mesh(s)));
    merged[k] = due.event.pairs.size();
    merging.merge(due.event);
    std::set<Triangle> known;
    for (Triangle t : merging.build().cloth.surface.triangles) {
      std::sort(t.begin(), t.end());
      EXPECT_TRUE(known.insert(t).second);
    }
  }
  // The diagonals alternate, so that they cut off one of the two corners of each panel.
  EXPECT_EQ(std::min(merged[0], merged[1]), 6u);
  EXPECT_EQ(std::max(merged[0], merged[1]), 7u);
}

TEST_F(SeamScenes, WhatMergingCannotKeepIsRefused) {
  EXPECT_NE(refusal(panels(R"("merge": 0.001)")).find("keep its sides 0.001 m apart"),
            std::string::npos);
  EXPECT_NE(refusal(panels(kMerge, R"(, "water": {})")).find("\"water\""), std::string::npos);
  EXPECT_NE(refusal(panels(kMerge, R"(, "output": {"formats": ["pc2"]})")).find("pc2"),
            std::string::npos);
  EXPECT_EQ(refusal(panels(R"("merge": 0)", R"(, "water": {})")), "");
}

}  // namespace
}  // namespace selvedge::seam_merging_test
