// SPDX-License-Identifier: MIT
//
// Scenes whose mesh is refined as they run, and the scene keys of the survey's other meshes.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/run/check_result.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/refinement.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "refined_scenes.h"
#include "scene_runs.h"

namespace selvedge::refinement_test {
namespace {

namespace fs = std::filesystem;

class Refinements : public SceneRuns {};

TEST_F(Refinements, CellsAreSplitWhereClothBendsAndTheRunIsClean) {
  const RunResult result = run_scene(read(over_ball(kCurved)), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_GT(result.counters.at("refinements"), 1.0);
  EXPECT_EQ(vertices_of_frame(0), 81u);
  EXPECT_GT(vertices_of_frame(16), vertices_of_frame(8));
  EXPECT_LT(vertices_of_frame(16), 33u * 33u);  // not everywhere
}

TEST_F(Refinements, SettledClothIsSplitEverywhereLevelAfterLevel) {
  config_.every_step = true;
  const RunResult result = run_scene(read(over_ball(kSettled)), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_EQ(result.counters.at("refinements"), 2.0);
  EXPECT_EQ(vertices_of_frame(5), 81u);
  EXPECT_EQ(vertices_of_frame(10), 17u * 17u);
  EXPECT_EQ(vertices_of_frame(16), 33u * 33u);
  EXPECT_EQ(result.steps, 2 * 16 + 2);  // an exchange of the mesh is a state of its own
  EXPECT_TRUE(fs::exists(numbered(config_.out / "steps", "cloth", 34, kStepFileDigits, ".ply")));
}

TEST_F(Refinements, AResumedRunGoesOnToTheSameBits) {
  const std::string whole = run_scene(read(over_ball(kCurved)), config_).state_hash;
  config_.out = folder_ / "in_parts";
  run_scene(read(over_ball(kCurved), {{"time.frames", "9"}}), config_);
  config_.resume = true;
  std::vector<std::string> warnings;
  config_.warning = [&](const std::string& sentence) { warnings.push_back(sentence); };
  EXPECT_EQ(run_scene(read(over_ball(kCurved)), config_).state_hash, whole);
  EXPECT_EQ(warnings, std::vector<std::string>()) << "no frame is missing";
}

TEST_F(Refinements, ARunStoppedWithinAFrameResumesToTheSameBits) {
  const Scene s = read(over_ball(kCurved), {{"time.steps_per_frame", "4"}});
  const RunResult whole = run_scene(s, config_);
  EXPECT_GT(whole.counters.at("refinements"), 1.0);
  config_.out = folder_ / "in_parts";
  config_.max_steps = 3;
  RunResult part = run_scene(s, config_);
  config_.resume = true;
  int parts = 1;
  for (; part.frames < whole.frames && parts < 100; ++parts) part = run_scene(s, config_);
  EXPECT_GT(parts, 20);
  EXPECT_EQ(part.state_hash, whole.state_hash);
  EXPECT_EQ(part.counters.at("refinements"), whole.counters.at("refinements"));
}

TEST_F(Refinements, OneThreadAndTwoGiveTheSameBits) {
  std::string hash[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    hash[threads - 1] = run_scene(read(over_ball(kCurved)), config_).state_hash;
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST_F(Refinements, TheSwitchKeepsMassMomentumAndTheSurface) {
  const Scene s = read(R"({"geometry": [
      {"name": "still", "size": [0.3, 0.3], "cells": [3, 3]},
      {"name": "sheet", "size": [0.4, 0.4], "cells": [4, 4], )" +
                       kSettled + R"(, "transformation": {"translation": [0, 0, 0.2]}},
      {"name": "last", "size": [0.2, 0.2], "cells": [2, 2],
       "transformation": {"translation": [0, 0, 0.4]}}],
    "handles": [{"geometry": "sheet", "select": "x0"},
                {"geometry": "last", "select": [8]}]})");
  detail::Refinement refinement(s, build_scene(s));
  const BuiltScene before = refinement.build();
  SimulationState state;
  state.time = 1.0;
  state.x = before.cloth.surface.vertices;
  for (std::size_t i = 0; i < state.x.size(); ++i)
    state.v.push_back(0.01 * Vec3(std::sin(9.0 * i), std::cos(5.0 * i), std::sin(2.0 * i)));
  const SimulationState old = state;
  const std::vector<SplitEvent> due = refinement.due(state);
  ASSERT_EQ(due.size(), 1u);
  EXPECT_EQ(due[0].cells.size(), 16u);
  refinement.split(due, state);
  const BuiltScene after = refinement.build();
  ASSERT_EQ(state.x.size(), 16u + 81u + 9u);
  EXPECT_EQ(state.x, after.cloth.surface.vertices);  // it had not moved
  Vec3 p = Vec3::Zero(), q = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < old.v.size(); ++i) p += before.cloth.mass[i] * old.v[i];
  for (std::size_t i = 0; i < state.v.size(); ++i) q += after.cloth.mass[i] * state.v[i];
  for (const double m : after.cloth.mass) mass += m;
  for (const double m : before.cloth.mass) mass -= m;
  EXPECT_NEAR(mass, 0.0, 1e-16);
  EXPECT_LT((p - q).norm(), 1e-15 * old.v.size());
  // Pieces before and after keep their particles, and handles theirs; new ones of the edge are
  // held.
  EXPECT_EQ(state.v[15], old.v[15]);
  EXPECT_EQ(state.v.back(), old.v.back());
  const Scene refined = refinement.scene();
  EXPECT_EQ(refined.handles[0].vertices.size(), 9u);
  EXPECT_EQ(refined.handles[0].pivots, 5u);
  EXPECT_EQ(refined.handles[1].vertices.size(), 1u);
}

/// Largest distance of a hanging node from the middle of its side, over all states of a run, m.
/// `counts`, if given, gets the counters of the run.
double off_the_middle(const Scene& scene, std::map<std::string, double>* counts = nullptr) {
  Simulation run(scene);
  double off = 0.0;
  std::size_t hanging = 0;
  for (int frame = 1; frame <= scene.time.frames; ++frame) {
    while (run.step_towards(frame)) {
      const std::span<const Vec3> x = run.positions(), v = run.velocities();
      for (const HangingNode& node : run.built().cloth.hanging) {
        const auto& [m, a, b] = node.v;
        off = std::max(
            {off, (x[m] - 0.5 * (x[a] + x[b])).norm(), 1e-2 * (v[m] - 0.5 * (v[a] + v[b])).norm()});
      }
      hanging = std::max(hanging, run.built().cloth.hanging.size());
    }
  }
  EXPECT_GT(hanging, 0u);
  const RunResult result = run.result();
  EXPECT_TRUE(result.clean);
  if (counts != nullptr) *counts = result.counters;
  return off;
}

/// Soft cloth, so that explicit steps are long.
const std::string kSoft = R"(, "materials": {"default": {"stretch_stiffness": 60,
    "shear_stiffness": 20, "spring_damping": 0, "bending_damping": 0}})";
const std::string kOnce = R"("refine": {"when": "curved", "levels": 1, "angle_deg": 12})";

constexpr double kRounding = 1e-15;  // m, at coordinates below 0.5 m

TEST_F(Refinements, HangingNodesStayInTheMiddleWithEveryResponse) {
  const ResponseRegistry all = responses();
  for (const auto* response : all.in_order())
    for (const char* integrator : {"implicit_euler", "symplectic_euler"}) {
      const Scene s = read(over_ball(kOnce, kSoft), {{"contact.response", response->name()},
                                                     {"solver.integrator", integrator},
                                                     {"time.frames", "10"}});
      EXPECT_LT(off_the_middle(s), kRounding) << response->name() << " " << integrator;
    }
}

TEST_F(Refinements, HangingNodesStayInTheMiddleWithEveryStrainLimiter) {
  const StrainLimiterRegistry all = strain_limiters();
  for (const auto* limiter : all.in_order()) {
    const Scene s = read(over_ball(kOnce, R"(, "handles": [{"select": ["x0y0"]}],
      "materials": {"default": {"strain_limit": 0.01, "stretch_stiffness": 60, "shear_stiffness": 20}})"),
                         {{"solver.strain_limiter", limiter->name()}, {"time.frames", "10"}});
    EXPECT_LT(off_the_middle(s), kRounding) << limiter->name();
  }
}

TEST_F(Refinements, HangingNodesStayInTheMiddleWithEveryFailSafe) {
  const FailSafeRegistry all = fail_safes();
  for (const auto* fail_safe : all.in_order()) {
    const Scene s =
        read(over_ball(kOnce, kSoft), {{"contact.fail_safe", fail_safe->name()},
                                       {"contact.response", "inverse_dynamics"},
                                       {"geometry.0.transformation.translation", "[0, 0, 0.25]"}});
    std::map<std::string, double> counts;
    EXPECT_LT(off_the_middle(s, &counts), kRounding) << fail_safe->name();
    double rounds = 0.0;
    for (const auto& [name, count] : counts)
      if (name.ends_with("_rounds") || name.ends_with("_passes")) rounds += count;
    EXPECT_GT(rounds, 5.0) << fail_safe->name();  // it acted
  }
}

TEST_F(Refinements, CellsAreJoinedAgainWhereClothBecomesFlat) {
  const RunResult result = run_scene(read(kSagging), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_GT(result.counters.at("refinements"), 1.0);
  EXPECT_GT(result.counters.at("joined_cells"), 4.0);
  std::size_t most = 0;
  for (int frame = 0; frame <= 60; ++frame) most = std::max(most, vertices_of_frame(frame));
  EXPECT_GT(most, 80u);
  EXPECT_LT(vertices_of_frame(60), 60u);  // 27 without a split
}

TEST_F(Refinements, AResumedRunJoinsToTheSameBits) {
  const std::string whole = run_scene(read(kSagging), config_).state_hash;
  config_.out = folder_ / "in_parts";
  const RunResult part = run_scene(read(kSagging, {{"time.frames", "45"}}), config_);
  ASSERT_GT(part.counters.at("joined_cells"), 0.0);
  config_.resume = true;
  EXPECT_EQ(run_scene(read(kSagging), config_).state_hash, whole);
}

TEST_F(Refinements, ACellIsNotJoinedThroughABodyUnlessExcluded) {
  const auto joins = [&](const std::string& height, const std::string& more = "") {
    const Scene s = read(R"({"geometry": [{"name": "cloth", "size": [0.4, 0.4], "cells": [4, 4],
        "refine": {"when": "curved", "levels": 1, "angle_deg": 30, "join_deg": 10}}],
      "obstacles": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.0005, "resolution": 8},
        "transformation": {"translation": [0.05, 0.05, )" +
                         height + "]}}]" + more + "}");
    detail::Refinement refinement(s, build_scene(s));
    SimulationState state;
    state.x = refinement.build().cloth.surface.vertices;
    state.v.assign(state.x.size(), Vec3::Zero());
    refinement.split({{0, 0.0, {{0, 2, 2}}}}, state);
    state.x.back().z() += 0.004;  // the centre of the cell, at (0.05, 0.05)
    Simulation simulation(s, build_scene(s), state);
    simulation.step();
    std::map<std::string, double> counters = simulation.result().counters;
    return std::pair{counters["joined_cells"], counters["joined_cells_postponed"]};
  };
  using Counts = std::pair<double, double>;
  EXPECT_EQ(joins("0.5"), Counts(1.0, 0.0));
  EXPECT_EQ(joins("-0.002"), Counts(1.0, 0.0));
  EXPECT_EQ(joins("0.002"), Counts(0.0, 1.0));
  EXPECT_EQ(
      joins("0.002", R"(, "contact": {"pairs": [{"a": "cloth", "b": "ball", "collide": false}]})"),
      Counts(1.0, 0.0));
}

TEST_F(Refinements, AnAngleOfJoiningThatCannotServeIsRefused) {
  const auto with = [](const char* refine) {
    return over_ball(std::string(R"("refine": {)") + refine + "}");
  };
  EXPECT_NE(refusal(with(R"("when": "settled", "join_deg": 5)")).find("join_deg"),
            std::string::npos);
  EXPECT_NE(refusal(with(R"("when": "curved", "angle_deg": 12, "join_deg": 12)")).find("angle_deg"),
            std::string::npos);
}

// -- what check says of them ----------------------------------------------------------------------

/// Two sheets above a ball; each with its keys.
std::string two_sheets(const std::string& lower, const std::string& upper,
                       const std::string& ball = "") {
  const auto sheet = [](const char* name, const char* height, const std::string& keys) {
    return fmt::format(
        R"({{"name": "{}", "size": [0.3, 0.3], "cells": [4, 4],
          "transformation": {{"translation": [0, 0, {}]}}{}}})",
        name, height, keys.empty() ? "" : ", " + keys);
  };
  return R"({"geometry": [)" + sheet("lower", "0.106", lower) + ", " +
         sheet("upper", "0.12", upper) +
         R"(], "obstacles": [{"shape": {"type": "sphere", "radius": 0.1, "resolution": 10})" +
         ball + R"(}, {"shape": {"type": "plane", "size": 4},
            "transformation": {"translation": [0, 0, -0.11]}}],
  "time": {"frames": 12}})";
}

TEST_F(Refinements, CheckFollowsASplitOfAnyPiece) {
  config_.every_step = true;
  const std::string mass = R"(, "mass": 0.5)", triangles = R"("pattern": "triangular", )" + kOnce;
  for (const std::string& json :
       {two_sheets(kOnce, ""), two_sheets("", kOnce), two_sheets(kOnce, kOnce),
        two_sheets(triangles, kOnce), two_sheets(triangles, ""), two_sheets("", kOnce, mass),
        two_sheets(kOnce, triangles, mass)}) {
    SCOPED_TRACE(json);
    config_.overwrite = true;
    const RunResult result = run_scene(read(json), config_);
    const ResultCheck check = check_result(config_.out.string());
    EXPECT_EQ(check.first_faulty, "");
    EXPECT_EQ(static_cast<double>(check.refinements), result.counters.at("refinements"));
    EXPECT_EQ(check.states, static_cast<std::size_t>(result.steps) + 1);
    EXPECT_EQ(check.paths + check.refinements + 1, check.states);
  }
}

TEST_F(Refinements, CheckJudgesEveryPathWhereCellsAreJoined) {
  config_.every_step = true;
  config_.overwrite = true;
  std::string triangles = kSagging;
  triangles.insert(triangles.find("\"refine\""), "\"pattern\": \"triangular\", ");
  for (const std::string& json : {kSagging, triangles}) {
    SCOPED_TRACE(json);
    const RunResult result = run_scene(read(json), config_);
    const std::size_t states = numbers_of(config_.out / "steps", "cloth").size();
    EXPECT_EQ(states, static_cast<std::size_t>(result.steps) + 1) << "a number is left out";
    const ResultCheck check = check_result(config_.out.string());
    EXPECT_EQ(check.first_faulty, "");
    EXPECT_EQ(static_cast<double>(check.refinements), result.counters.at("refinements"));
    EXPECT_GT(check.joins, 4u);
    EXPECT_EQ(check.paths + check.refinements + check.joins + 1, states);
  }
}

// -- triangles ------------------------------------------------------------------------------------

const std::string kTriangular = R"("pattern": "triangular", )";

TEST_F(Refinements, TrianglesAreSplitWhereClothBendsAndTheRunIsClean) {
  const RunResult result = run_scene(read(over_ball(kTriangular + kCurved)), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_GT(result.counters.at("refinements"), 1.0);
  EXPECT_FALSE(result.counters.contains("refinements_postponed"));
  EXPECT_EQ(vertices_of_frame(0), 85u);  // rows of 9 and 10
  EXPECT_GT(vertices_of_frame(16), vertices_of_frame(8));
  EXPECT_LT(vertices_of_frame(16), 33u * 33u) << "not everywhere";
}

TEST_F(Refinements, AResumedRunOfTrianglesGoesOnToTheSameBits) {
  const std::string json = over_ball(kTriangular + kSettled);
  const RunResult result = run_scene(read(json), config_);
  EXPECT_EQ(result.counters.at("refinements"), 2.0);
  EXPECT_GT(vertices_of_frame(16), 33u * 33u) << "everywhere, twice";
  config_.out = folder_ / "in_parts";
  run_scene(read(json, {{"time.frames", "9"}}), config_);
  config_.resume = true;
  EXPECT_EQ(run_scene(read(json), config_).state_hash, result.state_hash);
}

std::string sagging_triangles() {
  std::string json = kSagging;
  return json.replace(json.find("\"refine\""), 0, kTriangular);
}

TEST_F(Refinements, TrianglesAreJoinedAgainWhereClothBecomesFlat) {
  const RunResult result = run_scene(read(sagging_triangles()), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_GT(result.counters.at("refinements"), 1.0);
  EXPECT_GT(result.counters.at("joined_cells"), 4.0);
  std::size_t most = 0;
  for (int frame = 0; frame <= 60; ++frame) most = std::max(most, vertices_of_frame(frame));
  EXPECT_LT(vertices_of_frame(60), most / 2);
}

TEST_F(Refinements, AResumedRunOfTrianglesJoinsToTheSameBits) {
  const Scene s = read(sagging_triangles());
  const std::string whole = run_scene(s, config_).state_hash;
  config_.out = folder_ / "in_parts";
  const RunResult part = run_scene(read(sagging_triangles(), {{"time.frames", "45"}}), config_);
  ASSERT_GT(part.counters.at("joined_cells"), 0.0);
  config_.resume = true;
  EXPECT_EQ(run_scene(s, config_).state_hash, whole);
}

/// The square over the ball as a mesh in the scene, with parallel diagonals.
std::string mesh_over_ball(const std::string& keys) {
  std::string vertices, triangles;
  constexpr int n = 6;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      vertices += (vertices.empty() ? "[" : ", [") + std::to_string(0.1 * i - 0.3) + ", " +
                  std::to_string(0.1 * j - 0.3) + ", 0]";
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + n + 1;
      const auto add = [&](int u, int v, int w) {
        triangles += (triangles.empty() ? "[" : ", [") + std::to_string(u) + ", " +
                     std::to_string(v) + ", " + std::to_string(w) + "]";
      };
      add(a, a + 1, b + 1);
      add(a, b + 1, b);
    }
  return R"({"geometry": [{"mesh": {"vertices": [)" + vertices + R"(], "triangles": [)" +
         triangles + R"(]}, "transformation": {"translation": [0, 0, 0.156]}, )" + keys + "}]" +
         kBall + "}";
}

TEST_F(Refinements, AMeshIsSplitWhereItBendsAndTheRunIsClean) {
  const RunResult result = run_scene(read(mesh_over_ball(kCurved)), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_GT(result.counters.at("refinements"), 1.0);
  EXPECT_EQ(vertices_of_frame(0), 49u);
  EXPECT_GT(vertices_of_frame(16), vertices_of_frame(8));
  EXPECT_LT(vertices_of_frame(16), 25u * 25u) << "not everywhere";
}

TEST_F(Refinements, AResumedRunOfAMeshGoesOnToTheSameBits) {
  const RunResult result = run_scene(read(mesh_over_ball(kSettled)), config_);
  EXPECT_EQ(result.counters.at("refinements"), 2.0);
  config_.out = folder_ / "in_parts";
  run_scene(read(mesh_over_ball(kSettled), {{"time.frames", "9"}}), config_);
  config_.resume = true;
  EXPECT_EQ(run_scene(read(mesh_over_ball(kSettled)), config_).state_hash, result.state_hash);
}

// The square over the ball as an OBJ file of two halves that are sewn at x = 0, whose flat pattern
// in the texture coordinates is larger by a tenth.
class PatternRefinements : public Refinements {
 protected:
  static constexpr double kLarger = 1.1;

  std::string over_the_ball(const std::string& keys) {
    constexpr int n = 6;  // cells; 2 (n/2 + 1) columns of places
    std::ofstream file(folder_ / "halves.obj");
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) file << "v " << 0.1 * i - 0.3 << " " << 0.1 * j - 0.3 << " 0\n";
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n + 1; ++i)
        file << "vt " << kLarger * 0.1 * (i <= n / 2 ? i : i + 1) << " " << kLarger * 0.1 * j
             << "\n";
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto corner = [&](int u, int v) {
          return std::to_string((j + v) * (n + 1) + i + u + 1) + "/" +
                 std::to_string((j + v) * (n + 2) + i + u + (i < n / 2 ? 0 : 1) + 1) + " ";
        };
        file << "f " << corner(0, 0) << corner(1, 0) << corner(1, 1) << "\n";
        file << "f " << corner(0, 0) << corner(1, 1) << corner(0, 1) << "\n";
      }
    return R"({"geometry": [{"mesh": "halves.obj", "rest_mesh": "texture",
      "transformation": {"translation": [0, 0, 0.156]}, )" +
           keys + "}]" + kBall + "}";
  }
};

TEST_F(PatternRefinements, AreSplitWhereTheyBendAndTheRunIsClean) {
  const RunResult result = run_scene(read(over_the_ball(kCurved)), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_GT(result.counters.at("refinements"), 1.0);
  EXPECT_EQ(vertices_of_frame(0), 49u);
  EXPECT_GT(vertices_of_frame(16), vertices_of_frame(8));
  EXPECT_LT(vertices_of_frame(16), 25u * 25u) << "not everywhere";
}

TEST_F(PatternRefinements, AResumedRunGoesOnToTheSameBits) {
  const RunResult result = run_scene(read(over_the_ball(kSettled)), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_EQ(result.counters.at("refinements"), 2.0);
  config_.out = folder_ / "in_parts";
  run_scene(read(over_the_ball(kSettled), {{"time.frames", "9"}}), config_);
  config_.resume = true;
  EXPECT_EQ(run_scene(read(over_the_ball(kSettled)), config_).state_hash, result.state_hash);
}

TEST_F(PatternRefinements, KeepTheStrainOfTheFlatPatternMassAndMomentum) {
  const Scene s = read(over_the_ball(kSettled));
  detail::Refinement refinement(s, build_scene(s));
  SimulationState state;
  state.time = 1.0;
  state.x = refinement.build().cloth.surface.vertices;
  for (std::size_t i = 0; i < state.x.size(); ++i)
    state.v.push_back(Vec3(std::sin(9.0 * i), std::cos(5.0 * i), std::sin(2.0 * i)));
  double mass = 0.0;
  Vec3 momentum = Vec3::Zero();
  for (int level = 0; level <= 2; ++level) {
    const BuiltScene built = refinement.build();
    EXPECT_EQ(state.x, built.cloth.surface.vertices);  // it has not moved
    for (const TriangleStrain& strain :
         triangle_strains(state.x, built.cloth.surface.triangles, built.rest))
      for (const double part : {strain.larger, strain.smaller})
        EXPECT_NEAR(part, 1.0 / kLarger - 1.0, 1e-9);
    for (const Spring& spring : built.cloth.springs)
      EXPECT_NEAR(spring.rest_length, kLarger * (state.x[spring.a] - state.x[spring.b]).norm(),
                  1e-9);
    double now = 0.0;
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < state.v.size(); ++i) {
      now += built.cloth.mass[i];
      p += built.cloth.mass[i] * state.v[i];
    }
    if (level == 0) {
      mass = now;
      momentum = p;
    }
    EXPECT_NEAR(now, mass, 1e-15);
    EXPECT_LT((p - momentum).norm(), 1e-15);
    if (level < 2) refinement.split(refinement.due(state), state);
    state.time += 1.0;
  }
  EXPECT_GE(state.x.size(), 25u * 25u);
}

TEST_F(Refinements, AMeshThatCannotBeSplitIsRefused) {
  EXPECT_NE(refusal(mesh_over_ball(kCurved + R"(, "plate": 0.3)")).find("plate"),
            std::string::npos);
  EXPECT_NE(refusal(mesh_over_ball(R"("refine": {"when": "settled", "join_deg": 5})")).find("join"),
            std::string::npos);
}

TEST_F(Refinements, TrianglesThatCannotBeFittedAreRefused) {
  EXPECT_NE(refusal(over_ball(kTriangular + kCurved + R"(, "plate": 0.3)")).find("plate"),
            std::string::npos);
  EXPECT_NE(refusal(over_ball(R"("pattern": "responsive", )" + kCurved)).find("triangular"),
            std::string::npos);
}

TEST_F(Refinements, AMeshThatMustNotChangeIsRefused) {
  EXPECT_NE(refusal(over_ball(kCurved, R"(, "output": {"formats": ["pc2"]})")).find("pc2"),
            std::string::npos);
  EXPECT_NE(refusal(over_ball(kCurved, R"(, "contact": {"start": "untangle"})")).find("untangle"),
            std::string::npos);
  EXPECT_NE(refusal(over_ball(kCurved, R"(, "contact": {"still_tangled": "carry"})")).find("carry"),
            std::string::npos);
  EXPECT_NE(refusal(over_ball(R"("pattern": "responsive", )" + kCurved)).find("rectangular"),
            std::string::npos);
}

TEST_F(Refinements, ACheckpointOfOtherCellsIsRefused) {
  const Scene s = read(over_ball(kCurved));
  detail::Refinement refinement(s, build_scene(s));
  EXPECT_THROW(refinement.split({{3, 0.0, {{0, 0, 0}}}}), std::invalid_argument);
}

// -- the other keys -------------------------------------------------------------------------------

using SurveyMeshes = Refinements;

TEST_F(SurveyMeshes, ABilayeredClothCollidesByItsDenseLayerAndIsClean) {
  const RunResult result = run_scene(
      read(over_ball(R"("pattern": "bilayered", "layers": {"ratio": 2, "share": 0.3})")), config_);
  EXPECT_TRUE(result.clean);
  EXPECT_EQ(vertices_of_frame(0), 81u + 25u);
  const Scene s = read(over_ball(R"("pattern": "bilayered", "layers": {"ratio": 2})",
                                 R"(, "handles": [{"select": ["x0y0"]}])"));
  EXPECT_EQ(s.handles[0].vertices, (std::vector<std::int32_t>{0, 81}));  // of both layers
  EXPECT_NE(refusal(over_ball(R"("pattern": "bilayered", "layers": {"ratio": 3})")).find("ratio"),
            std::string::npos);
}

TEST_F(SurveyMeshes, OnlyTheSparseLayerIsSolved) {
  const auto bytes = [&](const std::string& pattern) {
    const Scene s = read(over_ball("\"pattern\": " + pattern),
                         {{"geometry.0.cells", "[24, 24]"}, {"time.frames", "10"}});
    const RunResult result = run_scene(s, config_);
    EXPECT_TRUE(result.clean);
    return result.counters.at("solver_bytes") / result.counters.at("solves");
  };
  EXPECT_LT(bytes(R"({"type": "bilayered", "ratio": 4})"), 0.2 * bytes("\"rectangular\""));
}

TEST_F(SurveyMeshes, RefinedAndBilayeredClothInOneSceneIsRefused) {
  EXPECT_NE(
      refusal(R"({"geometry": [{"pattern": {"type": "bilayered", "ratio": 2}, "cells": [4, 4]},
      {"cells": [4, 4], "transformation": {"translation": [0, 0, 0.5]}, )" +
              kCurved + "}]}")
          .find("refine"),
      std::string::npos);
}

TEST_F(SurveyMeshes, APlateOfAnotherPoissonsRatioReportsItsResidual) {
  const Scene s = read(over_ball(R"("pattern": "triangular", "plate": 0.1)"));
  const BuiltScene built = build_scene(s);
  ASSERT_FALSE(built.warnings.empty());
  EXPECT_NE(built.warnings[0].find("Poisson"), std::string::npos);
  const Scene third = read(over_ball(R"("pattern": "triangular", "plate": 0.3333333333333333)"));
  for (const std::string& sentence : build_scene(third).warnings)
    EXPECT_EQ(sentence.find("Poisson"), std::string::npos);
  EXPECT_NE(refusal(over_ball(R"("plate": 0.3333333333333333)")).find("triangular"),
            std::string::npos);
}

const std::string kOctahedron = R"("mesh": {"vertices": [[0.1,0,0],[-0.1,0,0],[0,0.1,0],[0,-0.1,0],
    [0,0,0.1],[0,0,-0.1]], "triangles": [[0,2,4],[2,1,4],[1,3,4],[3,0,4],[2,0,5],[1,2,5],[3,1,5],
    [0,3,5]]})";

std::string on_floor(const std::string& keys) {
  return R"({"geometry": [{)" + kOctahedron + ", " + keys +
         R"(, "transformation": {"translation": [0, 0, 0.12]}}],
  "materials": {"default": {"density": 1, "stretch_stiffness": 10, "shear_stiffness": 5, "strain_limit": 10}},
  "obstacles": [{"shape": {"type": "plane", "size": 1}}],
  "time": {"frames": 60, "fps": 60}})";
}

/// Height of the body after a second on the floor.
double height(const fs::path& file) {
  double low = 1.0, high = -1.0;
  const TriangleMesh mesh = read_mesh(file);
  for (const Triangle& t : mesh.triangles)
    for (const std::int32_t i : t) {
      low = std::min(low, mesh.vertices[i].z());
      high = std::max(high, mesh.vertices[i].z());
    }
  return high - low;
}

TEST_F(SurveyMeshes, ABodyWithSupportStandsAndOneWithoutCollapses) {
  const auto run = [&](const std::string& keys) {
    EXPECT_TRUE(run_scene(read(on_floor(keys)), config_).clean);
    return height(numbered(config_.out / "frames", "cloth", 60, kFrameFileDigits, ".ply"));
  };
  const double supported = run(R"("support": {"stiffness": 300})");
  const double empty = run(R"("name": "empty")");
  EXPECT_GT(supported, 0.15);
  EXPECT_LT(empty, 0.8 * supported);
  EXPECT_NE(refusal(on_floor(R"("support": {}, "plate": 0.3333333333333333)")).find("support"),
            std::string::npos);
}

TEST_F(SurveyMeshes, VirtualSpringsHoldClothWhereItStartsUnlessTheyFollow) {
  const auto sunk = [&](const std::string& springs) {
    const std::string json = R"({"geometry": [{"size": [0.4, 0.4], "cells": [6, 6])" + springs +
                             R"(}], "time": {"frames": 30, "fps": 60}})";
    run_scene(read(json), config_);
    const TriangleMesh mesh =
        read_mesh(numbered(config_.out / "frames", "cloth", 30, kFrameFileDigits, ".ply"));
    return -mesh.vertices[24].z();
  };
  const double free = sunk(""), half_g_t2 = 0.5 * 9.81 * 0.25;
  EXPECT_NEAR(free, half_g_t2, 0.03);
  EXPECT_NEAR(sunk(R"(, "virtual_springs": {"stiffness": 100, "follow": true})"), free, 1e-6);
  // They give by ρ g/K = 0.2·9.81/100 m at rest, twice that at most on the way.
  EXPECT_LT(sunk(R"(, "virtual_springs": {"stiffness": 100})"), 2.0 * 0.2 * 9.81 / 100.0);
}

}  // namespace
}  // namespace selvedge::refinement_test
