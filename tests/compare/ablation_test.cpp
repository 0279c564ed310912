// SPDX-License-Identifier: MIT
// When a part of a scene may go: equivalence over seeds, and what the program says of it.
#include <gtest/gtest.h>
#include <selvedge/compare/internal/ablation.h>

#include <cmath>
#include <random>

#include "run_program.h"

namespace selvedge::ablation_test {
namespace {

using namespace selvedge::testing;

TEST(Equivalence, TheBoundsAreThoseOfATextbook) {
  // Five values with mean 0.02 and standard deviation 0.01·sqrt(2.5): t(4) = 2.132.
  const std::vector<double> values = {0.0, 0.01, 0.02, 0.03, 0.04};
  const Equivalence e = test_equivalence(values, 0.05);
  const double half = 2.132 * 0.01 * std::sqrt(2.5 / 5.0);
  EXPECT_NEAR(e.mean, 0.02, 1e-15);
  EXPECT_NEAR(e.low, 0.02 - half, 1e-12);
  EXPECT_NEAR(e.high, 0.02 + half, 1e-12);
  EXPECT_EQ(e.verdict, EquivalenceVerdict::equivalent);
  EXPECT_EQ(test_equivalence(values, 0.03).verdict, EquivalenceVerdict::undecided);
  EXPECT_EQ(test_equivalence(values, 0.004).verdict, EquivalenceVerdict::different);
}

TEST(Equivalence, OneValueDecidesNothing) {
  EXPECT_EQ(test_equivalence(std::vector<double>{0.0}, 1.0).verdict, EquivalenceVerdict::undecided);
  EXPECT_EQ(test_equivalence({}, 1.0).verdict, EquivalenceVerdict::undecided);
}

TEST(Equivalence, AMeanAtTheToleranceCountsAsEquivalentInOneOfTwenty) {
  std::mt19937 random(11);
  std::normal_distribution<double> at_the_tolerance(0.1, 0.02);
  int wrong = 0;
  constexpr int samples = 20000;
  for (int k = 0; k < samples; ++k) {
    std::vector<double> values(6);
    for (double& v : values) v = at_the_tolerance(random);
    wrong += test_equivalence(values, 0.1).verdict == EquivalenceVerdict::equivalent;
  }
  EXPECT_NEAR(static_cast<double>(wrong) / samples, 0.05, 0.006);
}

TEST(ShapeMeasures, AreThoseOfARollAndOfAStretchedSheet) {
  ClothEnds cloth;
  cloth.start = {{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {0, 4, 0}};
  cloth.triangles = {{0, 1, 2}, {0, 2, 3}};
  cloth.end = cloth.start;
  for (Vec3& x : cloth.end) x = 1.1 * x + Vec3(0, 0, 10);
  auto m = shape_measures(cloth);  // the extent is 5
  EXPECT_NEAR(m.at("rms strain"), 0.1, 1e-12);
  EXPECT_NEAR(m.at("mean z"), 2.0, 1e-12);
  EXPECT_NEAR(m.at("width along y"), 0.88, 1e-12);
  EXPECT_NEAR(m.at("mean angle"), 0.0, 1e-12);
  cloth.end = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.5, 0.5, std::sqrt(0.5)}};  // folded by 90°
  EXPECT_NEAR(shape_measures(cloth).at("mean angle"), 0.5, 1e-12);
}

constexpr const char* kFlag =
    R"({"name": "flag", "geometry": [{"name": "f", "size": [1, 1], "cells": [6, 6],
        "transformation": {"translation": [0, 0, 1], "rotation": {"axis": [1, 0, 0], "angle_deg": 90}}}],
        "handles": [{"name": "c", "select": ["x0y1", "x1y1"]}],
        "materials": {"default": {"bending_stiffness": 1e-7}},
        "air": {"wind": [0, 3, 0], "normal_drag": 0.8}, "time": {"frames": 20, "fps": 60}})";

class PlanCommand : public Program {
 protected:
  fs::path path(const std::string& name) const { return folder_ / name; }
};

TEST_F(PlanCommand, ASeedChangesTheRunAndTheSameSeedRepeatsIt) {
  write("flag.json", kFlag);
  const Scene scene = read_scene(path("flag.json"), {});
  const Methods methods;
  const auto hash = [&](std::uint32_t seed) {
    return run_timed(scene, methods, {.seed = seed}).result.state_hash;
  };
  EXPECT_EQ(hash(1), hash(1));
  EXPECT_NE(hash(1), hash(2));
  EXPECT_NE(hash(0), hash(1));
}

TEST_F(PlanCommand, WindIsNeededAndBendingThatDoesNothingCouldGo) {
  write("flag.json", kFlag);
  const Outcome all = run("plan flag.json --ablate --seeds 4 --json");
  ASSERT_EQ(all.code, 0) << all.err;
  std::map<std::string, std::string> verdict;
  const Json printed = Json::parse(all.out);
  for (const Json& row : printed["ablation"]) verdict[row["part"]] = row["verdict"];
  EXPECT_EQ(verdict.at("air"), "needed");
  EXPECT_TRUE(verdict.at("bending").starts_with("could go")) << verdict.at("bending");
}

constexpr const char* kTwoSheets =
    R"({"name": "two", "geometry": [{"name": "low", "size": [1, 1], "cells": [5, 5]},
        {"name": "high", "size": [0.6, 0.6], "cells": [5, 5],
         "transformation": {"translation": [0, 0, 0.15], "rotation": {"axis": [1, 0, 0], "angle_deg": 20}},
         "velocity": [0, 0, -1]}],
        "handles": [{"name": "c", "geometry": "low", "select": ["x0", "x1"]}],
        "contact": {"pairs": [{"a": "low", "b": "high", "friction": 0.5}]},
        "time": {"frames": 10, "fps": 60}})";

TEST_F(PlanCommand, EveryPartHasItsTimeAndWhatLeavingItOutChanges) {
  write("two.json", kTwoSheets);
  const Outcome all = run("plan two.json --ablate --seeds 2 --json");
  ASSERT_EQ(all.code, 0) << all.err;
  std::map<std::string, Json> rows;
  const Json printed = Json::parse(all.out);
  for (const Json& row : printed["ablation"]) rows[row["part"]] = row;
  for (const char* part : {"self_collision", "friction", "response", "frame_check", "strain_limit",
                           "shear", "bending", "steps_at_rest", "joined_steps"}) {
    ASSERT_TRUE(rows.contains(part)) << part;
    EXPECT_GT(rows[part]["time_ratio"][0], 0.0) << part;
  }
  EXPECT_FALSE(rows.contains("air")) << "the scene has none";
  EXPECT_TRUE(rows["frame_check"]["same_bits"]);
  EXPECT_EQ(rows["frame_check"]["distance"], 0.0);
  EXPECT_FALSE(rows["self_collision"]["clean"]);
  EXPECT_GT(rows["self_collision"]["crossings"], 0);
  EXPECT_GT(rows["self_collision"]["distance"], 1e-3);
  EXPECT_GT(rows["shear"]["distance"], 0.0);
  EXPECT_FALSE(rows["response"]["same_bits"]) << "the fail-safe alone is another answer";
}

TEST_F(PlanCommand, APartWithoutWhichASceneIsRefusedIsNeeded) {
  const Outcome all = run("plan " SELVEDGE_SOURCE_DIR
                          "/data/scenes/plate_springs.json"
                          " --set time.frames=2 --ablate --seeds 2 --json");
  ASSERT_EQ(all.code, 0) << all.err;
  const Json printed = Json::parse(all.out);
  for (const Json& row : printed["ablation"])
    if (row["part"] == "bending") {
      EXPECT_EQ(row["verdict"], "needed");
      EXPECT_SAYS(row["why"].get<std::string>(), "refused without it: ");
    }
}

TEST_F(PlanCommand, APartThatNoSceneCanLeaveOutIsNotAccepted) {
  write("two.json", kTwoSheets);
  const Outcome refused = run("plan two.json --accept frame_check --write less.json --seeds 2");
  EXPECT_EQ(refused.code, 2);
  EXPECT_SAYS(refused.err, "no scene can leave it out");
  EXPECT_FALSE(exists("less.json"));
}

TEST_F(PlanCommand, WhatIsNotShownToBeEquivalentIsNotAccepted) {
  write("flag.json", kFlag);
  const Outcome refused = run("plan flag.json --accept air --write less.json --seeds 3");
  EXPECT_EQ(refused.code, 2);
  EXPECT_SAYS(refused.err, "not shown to be within 0.01");
  EXPECT_FALSE(exists("less.json"));
  const Outcome taken = run("plan flag.json --accept bending --write less.json --seeds 3");
  ASSERT_EQ(taken.code, 0) << taken.err;
  const Scene less = read_scene(path("less.json"), {});
  EXPECT_EQ(less.materials.at("default").bending_stiffness, 0.0);
}

}  // namespace

}  // namespace selvedge::ablation_test
