// SPDX-License-Identifier: MIT
// Compares of small scenes: what is read of --vary, errors and times, and what becomes of cells and
// folders that go wrong.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/compare/compare_table.h>
#include <selvedge/compare/detail/compare_error.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/narrowphase/distance.h>
#include <sys/file.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "run_program.h"

namespace selvedge::compare_test {
namespace {

using namespace selvedge::testing;

// -- what is varied -------------------------------------------------------------------------------

std::vector<std::string> values_of(const std::string& vary) {
  return read_axes({vary}, Methods{}).at(0).values;
}

template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(CompareAxes, ListsKeepTheirOrderAndEachValueOnce) {
  EXPECT_EQ(values_of("dt=0.01,0.002,0.01"), (std::vector<std::string>{"0.01", "0.002"}));
  EXPECT_EQ(values_of("geometry.0.cells=[3,3],[5,7]"),
            (std::vector<std::string>{"[3,3]", "[5,7]"}));
}

TEST(CompareAxes, RangesHaveEqualStepsOrEqualRatios) {
  EXPECT_EQ(values_of("rest_gap=1..3:3"), (std::vector<std::string>{"1", "2", "3"}));
  EXPECT_EQ(values_of("dt=0.001..0.1:3 log"), (std::vector<std::string>{"0.001", "0.01", "0.1"}));
}

TEST(CompareAxes, AllMeansWhateverThisBuildHas) {
  std::vector<std::string> names;
  for (const auto& entry : Methods{}.broad_phases) names.push_back(entry.first);
  EXPECT_EQ(values_of("broad_phase"), names);
  EXPECT_EQ(values_of("contact.self=all"), (std::vector<std::string>{"false", "true"}));
}

TEST(CompareAxes, AnUnknownNameIsRefusedWithTheNearestOne) {
  EXPECT_SAYS(refusal([] { values_of("broad_fase"); }), "nearest is \"broad_phase\"");
  EXPECT_SAYS(refusal([] { values_of("contact.rest_gab=1"); }), "nearest is \"contact.rest_gap\"");
  EXPECT_SAYS(refusal([] { values_of("thickness"); }), "has no list of all values");
  EXPECT_SAYS(refusal([] { values_of("dt=1..2"); }), "a range is lo..hi:n");
  EXPECT_SAYS(refusal([] { values_of("dt=1,,2"); }), "an empty value");
}

TEST(CompareAxes, TheOldNameOfTheRestGapVariesIt) {
  for (const char* name : {"thickness", "contact.thickness", "rest_gap", "contact.rest_gap"}) {
    const auto axes = read_axes({std::string(name) + "=0.001,0.002"}, Methods{});
    const std::vector<Override> overrides = cell_overrides(axes, {"0.002"}, Scene{});
    ASSERT_EQ(overrides.size(), 1u) << name;
    EXPECT_EQ(overrides[0].path, "contact.rest_gap") << name;
  }
  EXPECT_SAYS(refusal([] {
                read_axes({"thickness=1", "contact.rest_gap=1"}, Methods{});
              }),
              "is varied twice");
}

TEST(CompareAxes, OneAtATimeKeepsTheFirstOfTheOthers) {
  const std::vector<CompareAxis> axes = {{"a", {"1", "2"}}, {"b", {"x", "y", "z"}}};
  using Cells = std::vector<std::vector<std::string>>;
  EXPECT_EQ(design_cells(axes, CompareDesign::one_at_a_time),
            (Cells{{"1", "x"}, {"2", "x"}, {"1", "y"}, {"1", "z"}}));
  EXPECT_EQ(design_cells(axes, CompareDesign::product).size(), 6u);
}

TEST(CompareAxes, AStepOfAnyLengthEndsWithTheScene) {
  Scene scene;
  scene.time.frames = 30;  // half a second
  for (const double dt : {1e-5, 1e-3, 0.004, 1.0 / 60.0, 0.03, 0.4}) {
    std::map<std::string, double> value = {{"time.frames", 30},
                                           {"time.fps", 60.0},
                                           {"time.step_error", 1.0},
                                           {"time.sleep_speed", 1.0}};
    for (const Override& o : step_overrides(scene, dt)) value[o.path] = std::stod(o.value);
    EXPECT_EQ(value["time.step_error"], 0.0) << "steps of a given length are not joined";
    EXPECT_EQ(value["time.sleep_speed"], 0.0) << "nor left out";
    const double steps = value["time.frames"] * value["time.steps_per_frame"];
    EXPECT_NEAR(value["time.frames"] / value["time.fps"], 0.5, 1e-12) << dt;
    EXPECT_LE(0.5 / steps, dt * (1.0 + 1e-9)) << dt;
    EXPECT_GE(0.5 / steps, 0.5 * dt) << dt;
  }
}

// -- numbers --------------------------------------------------------------------------------------

TEST(CompareNumbers, QuartilesAreThoseOfTheSortedValues) {
  const Quartiles q = quartiles({5.0, 1.0, 3.0, 2.0, 4.0});
  EXPECT_EQ(q.low, 2.0);
  EXPECT_EQ(q.median, 3.0);
  EXPECT_EQ(q.high, 4.0);
}

TEST(CompareNumbers, RichardsonFindsTheOrderAndWhatIsLeft) {
  // Errors 16 e, 4 e, e of a method of second order.
  const double e = 1e-5;
  const detail::Convergence c = detail::judge_convergence({12.0 * e}, {3.0 * e}, "m");
  EXPECT_TRUE(c.converges);
  EXPECT_NEAR(c.order, 2.0, 1e-12);
  EXPECT_NEAR(c.uncertainty, e, 1e-12);
}

TEST(CompareNumbers, AReferenceThatDoesNotConvergeIsNoBetterThanItsDifferences) {
  const detail::Convergence c = detail::judge_convergence({1e-3}, {2e-3}, "m");
  EXPECT_FALSE(c.converges);
  EXPECT_EQ(c.uncertainty, 2e-3);
  EXPECT_SAYS(c.sentence, "does NOT converge");
}

TEST(CompareNumbers, RefinementsWithinTheScatterAreAsGoodAsTheScatter) {
  const detail::Convergence c = detail::judge_convergence({1e-3, 1e-4}, {2e-3, 3e-3}, "m");
  EXPECT_TRUE(c.converges);
  EXPECT_EQ(c.uncertainty, 3e-3);
  EXPECT_SAYS(c.sentence, "scatter, 0.003 m");
}

/// A square metre of n x n cells, bent smoothly at its end.
ClothEnds bent_sheet(int n) {
  ClothEnds ends;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = static_cast<double>(i) / n, y = static_cast<double>(j) / n;
      ends.start.emplace_back(x, y, 0.0);
      ends.end.emplace_back(x, y, 0.1 * std::sin(3.0 * x) * y);
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const std::int32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      ends.triangles.push_back({a, b, d});
      ends.triangles.push_back({a, d, c});
    }
  return ends;
}

/// A finished cell whose error has this interval over three seeds.
CompareRow row_with_error(double error, double half, bool counts) {
  CompareRow row;
  row.error = error;
  row.error_half = half;
  row.counts = counts;
  return row;
}

TEST(Ranking, ErrorsWhoseIntervalsOverlapRankNothing) {
  CompareTable table;
  table.error_unit = "m";
  table.converges = true;
  table.plan.limits.seeds = true;
  table.plan.repeats = 3;
  table.rows = {row_with_error(0.10, 0.01, true), row_with_error(0.20, 0.01, true),
                row_with_error(0.21, 0.01, true), row_with_error(0.001, 0.01, false)};
  EXPECT_SAYS(ranking(table), "Ranks 3 of 4 cells by their errors, in 2 groups");
  table.rows = {row_with_error(0.5, 0.375, true), row_with_error(0.75, 0.375, true)};
  EXPECT_SAYS(ranking(table), "Ranks no errors: the intervals of 2 of 2 cells overlap");
  EXPECT_SAYS(ranking(table), "about 27 seeds could") << "(0.75 / 0.25)² times three";
  table.rows = {row_with_error(0.01, 0.02, false)};
  EXPECT_SAYS(ranking(table), "about 12 seeds could") << "(0.02 / 0.01)² times three";
  table.uncertainty = 0.05;
  EXPECT_SAYS(ranking(table), "a reference 5 times as accurate could");
  table.converges = false;
  EXPECT_SAYS(ranking(table), "the reference does not converge");
  EXPECT_TRUE(to_text(table).starts_with("Ranks no errors")) << "first of all";
}

TEST(CompareNumbers, MeshesOfOneSurfaceDifferByNoMoreThanTheirOwnCells) {
  const ClothEnds coarse = bent_sheet(7), fine = bent_sheet(40);
  EXPECT_LT(detail::distance(coarse, fine), 1e-4);
  EXPECT_GT(detail::distance(fine, coarse), 1e-5);  // flat cells of the coarse one cut the bend
  EXPECT_EQ(detail::distance(fine, fine), 0.0);
}

/// Largest distance of a vertex of either cloth to the triangles of the other.
double hausdorff_by_all_pairs(const ClothEnds& a, const ClothEnds& b) {
  double largest = 0.0;
  for (const auto& [from, to] : {std::pair(&a, &b), std::pair(&b, &a)})
    for (const Vec3& p : from->end) {
      double nearest = 1e300;
      for (const Triangle& t : to->triangles)
        nearest = std::min(
            nearest,
            point_triangle_closest(p, to->end[t[0]], to->end[t[1]], to->end[t[2]]).distance);
      largest = std::max(largest, nearest);
    }
  return largest;
}

TEST(CompareNumbers, TheHausdorffDistanceIsThatOfAllPairsNearAndFar) {
  const ClothEnds still = bent_sheet(20);
  for (const double far : {0.01, 0.3, 5.0, 40.0}) {
    ClothEnds moved = bent_sheet(17);
    for (Vec3& x : moved.end) x += far * Vec3(0.6, 0.3 * x.y(), 0.8);
    const double exact = hausdorff_by_all_pairs(moved, still);
    EXPECT_NEAR(detail::hausdorff_distance(moved, still) * still.extent(), exact, 1e-12 * exact)
        << far;
    EXPECT_EQ(detail::hausdorff_distance(moved, still), detail::hausdorff_distance(still, moved));
  }
}

TEST(CompareNumbers, TheHausdorffDistanceSeesASpikeAndNoSlidingAlongTheSurface) {
  const ClothEnds still = bent_sheet(20);
  ClothEnds spike = still;
  spike.end[210].z() += 0.2;
  EXPECT_GT(detail::hausdorff_distance(spike, still) * still.extent(), 0.15);
  EXPECT_LT(detail::distance(spike, still) * still.extent(), 0.01);
  ClothEnds turned = still;  // the same surface, with other particles everywhere
  std::reverse(turned.end.begin(), turned.end.end());
  for (Triangle& t : turned.triangles)
    for (std::int32_t& v : t) v = static_cast<std::int32_t>(turned.end.size()) - 1 - v;
  EXPECT_EQ(detail::hausdorff_distance(turned, still), 0.0);
}

TEST(CompareNumbers, MeansOfSeedsHaveStudentsInterval) {
  const auto cell = [](std::vector<double> strains) {
    detail::CellEnd end;
    for (const double strain : strains) {
      end.results.emplace_back();
      end.results.back().measures["strain_rms"] = strain;
    }
    return end;
  };
  const detail::ErrorQuantity& strain = detail::error_quantity("strain");
  // 1, 2, 3: deviation 1, of the mean 1/√3; Student's t of 2 degrees of freedom is 2.920.
  const auto d = difference(strain, cell({1, 2, 3}), cell({5, 5}));
  ASSERT_TRUE(d);
  EXPECT_NEAR(d->value, 3.0, 1e-15);
  EXPECT_NEAR(d->half, 2.920 / std::sqrt(3.0), 1e-12);
  EXPECT_EQ(difference(strain, cell({1}), cell({4}))->half, 0.0);
  EXPECT_FALSE(difference(detail::error_quantity("drape"), cell({1}), cell({1})));
}

TEST(CompareNumbers, ClothSlidesByTheAccelerationThatFrictionLeavesOrSticks) {
  const double slope = std::atan(0.75);  // sin 0.6, cos 0.8
  EXPECT_NEAR(detail::slide(10.0, slope, 0.5, 2.0), 0.5 * 10.0 * (0.6 - 0.5 * 0.8) * 4.0, 1e-12);
  EXPECT_EQ(detail::slide(10.0, slope, 0.8, 2.0), 0.0);
}

// -- cells ----------------------------------------------------------------------------------------

/// Says that it misses nothing, and finds nothing.
class BlindDetector final : public BroadPhase {
 public:
  void find_pairs(const SurfaceView&, const SurfaceView&, CandidatePairs& out) override {
    out.clear();
  }
  void find_self_pairs(const SurfaceView&, CandidatePairs& out) override { out.clear(); }
  BroadPhaseTraits traits() const override { return {}; }
};

constexpr const char* kBall = R"({"name": "ball",
  "geometry": [{"name": "cloth", "size": [0.5, 0.5], "cells": [6, 6],
                "transformation": {"translation": [0, 0, 0.303]}}],
  "obstacles": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.3, "resolution": 12}}],
  "time": {"frames": 3}})";

class CompareCells : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    write("ball.json", kBall);
    // Hangs by two corners, so that its motion stays smooth.
    write("hang.json", R"({"name": "hang",
      "geometry": [{"name": "cloth", "size": [0.2, 0.2], "cells": [4, 4]}],
      "handles": [{"select": ["x0y1", "x1y1"]}],
      "time": {"frames": 3}})");
  }

  Outcome compare(const std::string& arguments, const std::string& before = "") const {
    return run("compare " + arguments, before);
  }
  Json table(const std::string& out) const {
    return Json::parse(content(folder_ / out / "compare.json"), nullptr, false);
  }
  /// The CSV without the columns that hold times or memory.
  std::string lasting_csv(const std::string& out) const {
    std::istringstream in(content(folder_ / out / "compare.csv"));
    std::vector<bool> keep;
    std::string text;
    for (std::string line; std::getline(in, line);) {
      const std::vector<std::string> cells = split(line);
      if (keep.empty())
        for (const std::string& name : cells) keep.push_back(!is_measured(name));
      for (std::size_t i = 0; i < cells.size(); ++i)
        if (keep.at(i)) text += cells[i] + ";";
      text += "\n";
    }
    return text;
  }
  static std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"') quoted = !quoted;
      if (c == ',' && !quoted)
        cells.emplace_back();
      else
        cells.back() += c;
    }
    return cells;
  }
};

TEST_F(CompareCells, AMethodThatMissesAgainstItsPromiseIsAFailure) {
  Methods methods;
  methods.broad_phases.add("blind", {},
                           [](const MethodOptions&) { return std::make_unique<BlindDetector>(); });
  std::string scene = kBall;
  scene.insert(scene.rfind('}'), R"(, "contact": {"broad_phase": "blind"})");
  write("cell/scene.json", scene);
  fs::create_directories(folder_ / "cell");
  write("cell/scene.json", scene);
#ifdef SELVEDGE_VALIDATION
  EXPECT_DEATH(run_cell(folder_ / "cell", 0, {.judged_motions = 3}, methods),
               "pairs that collide are not among the candidates")
      << "a validation build searches every step again";
#else
  const CellRun run = run_cell(folder_ / "cell", 0, {.judged_motions = 3}, methods);
  EXPECT_GT(run.pairs.colliding, 0u);
  EXPECT_LT(run.pairs.recall, 1.0);
  EXPECT_SAYS(run.pairs.failure, "blind is to ");
#endif
}

TEST_F(CompareCells, SmallerStepsOfAMethodOfFirstOrderErrLess) {
  const Outcome outcome =
      compare("hang.json --vary dt=0.0005,0.001,0.002,0.004 --repeats 1 --no-pictures --out c");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json all = table("c");
  EXPECT_TRUE(all["converges"].get<bool>()) << all["reference"];
  double former = 0.0;
  for (const Json& row : all["rows"]) {
    EXPECT_GT(row["error"].get<double>(), 1.5 * former);
    former = row["error"].get<double>();
  }
  EXPECT_TRUE(all["rows"][0]["counts"].get<bool>());
}

TEST_F(CompareCells, SeedsAreMembersOfAnEnsembleThatTheProgramCanRepeat) {
  const Outcome outcome =
      compare("hang.json --vary dt=0.002,0.004 --seeds 3 --error strain --no-pictures --out c");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_SAYS(outcome.out, "means of 3 seeds");
  const Json all = table("c");
  EXPECT_EQ(all["seeds"].get<int>(), 3);
  EXPECT_EQ(all["quantity"].get<std::string>(), "strain");
  for (const Json& row : all["rows"]) {
    EXPECT_EQ(row["status"].get<std::string>(), "ok");
    EXPECT_EQ(row["error"], row["errors"]["strain"]);
    EXPECT_GT(row["error_half_interval"].get<double>(), 0.0);
    for (const char* quantity : {"position", "hausdorff", "energy"})
      EXPECT_GT(row["errors"][quantity].get<double>(), 0.0) << quantity;
    EXPECT_FALSE(row["errors"].contains("drape")) << "it hangs over no support";
  }
  std::set<std::string> hashes;
  const fs::path cell = cell_folder(folder_ / "c", all["rows"][1]["id"].get<std::string>());
  for (int member = 0; member < 3; ++member) {
    const auto run = read_cell_run(cell, member);
    ASSERT_TRUE(run);
    hashes.insert(run->result.state_hash);
    EXPECT_TRUE(read_ends(cell, member));
  }
  EXPECT_EQ(hashes.size(), 3u);
  ASSERT_EQ(
      run("run " + (cell / "scene.json").string() + " --set perturbation.seed=2 --out again").code,
      0);
  const Json again = Json::parse(content(folder_ / "again/result.json"));
  EXPECT_EQ(again["state_hash"].get<std::string>(), read_cell_run(cell, 1)->result.state_hash);
}

TEST_F(CompareCells, RunsArePinnedToACoreAndAMissingCoreIsSaid) {
  const std::string plain = "hang.json --vary dt=0.004 --repeats 1 --no-reference --no-pictures ";
  EXPECT_EQ(compare(plain + "--core 0 --out c").code, 0);
  EXPECT_EQ(table("c")["rows"][0]["status"].get<std::string>(), "ok");
  const Outcome outcome = compare(plain + "--core 1023 --out d");
  EXPECT_NE(outcome.code, 0);
  EXPECT_SAYS(outcome.err, "--core 1023: a run cannot be pinned to this core");
}

TEST_F(CompareCells, TheQuantityOfErrorsMayChangeWithoutAnotherRun) {
  const std::string plain = "hang.json --vary dt=0.002,0.004 --repeats 1 --no-pictures --out c";
  ASSERT_EQ(compare(plain).code, 0);
  const Json before = table("c");
  const Outcome outcome = compare(plain + " --error hausdorff");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json after = table("c");
  EXPECT_EQ(after["rows"][1]["run_s"], before["rows"][1]["run_s"]);
  EXPECT_EQ(after["rows"][1]["error"], before["rows"][1]["errors"]["hausdorff"]);
  EXPECT_NE(after["rows"][1]["error"], before["rows"][1]["error"]);
  EXPECT_SAYS(after["error_meaning"].get<std::string>(), "Hausdorff");
  EXPECT_SAYS(compare(plain + " --error drap").err, "drape");
}

TEST_F(CompareCells, SeedsOfMeshesThatChangeAreRefused) {
  write("split.json", R"({"name": "split",
    "geometry": [{"name": "cloth", "refine": {"when": "curved", "levels": 1}}], "time": {"frames": 1}})");
  const Outcome outcome = compare("split.json --vary dt=0.002,0.004 --seeds 2 --out c");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_SAYS(outcome.err, "no mean shape");
}

TEST_F(CompareCells, DetectorsThatAreExactEndInTheSameBitsAndMissNothing) {
  const Outcome outcome = compare(
      "ball.json --vary broad_phase=bvh_aabb,brute_force,uniform_grid --repeats 1 --out c "
      "--no-pictures");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::set<std::string> hashes;
  const Json all = table("c");
  for (const Json& row : all["rows"]) {
    hashes.insert(row["state_hash"].get<std::string>());
    EXPECT_EQ(row["pairs"]["recall"].get<double>(), 1.0);
    EXPECT_GT(row["pairs"]["colliding"].get<int>(), 0);
  }
  EXPECT_EQ(hashes.size(), 1u);
}

TEST_F(CompareCells, AWrongNameIsRefusedBeforeAnythingRuns) {
  EXPECT_REFUSED(compare("ball.json --vary broad_fase --out c"), "nearest is \"broad_phase\"");
  EXPECT_REFUSED(compare("ball.json --vary broad_phase=bvh_aab --out c"),
                 "nearest is \"bvh_aabb\"");
  EXPECT_FALSE(exists("c"));
}

TEST_F(CompareCells, CellsThatAreSplitAreComparedByStartingPoints) {
  const std::string adaptive = std::string(SELVEDGE_SOURCE_DIR) + "/data/scenes/adaptive.json " +
                               "--set geometry.0.cells=[4,4] --set time.frames=14 "
                               "--set obstacles.0.shape.resolution=12 ";
  const Outcome outcome = compare(adaptive +
                                  "--vary geometry.0.refine.levels=1,2 --repeats 1 "
                                  "--no-reference --no-pictures --judge 1 --out c");
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  const Json rows = table("c")["rows"];
  const auto particles = [&](int row) { return rows[row]["particles"].get<int>(); };
  EXPECT_GT(particles(0), 25) << "5 x 5 to begin with";
  EXPECT_GE(particles(1), particles(0));
  // The same ball below: they lie within a fifth of the cloth of each other.
  EXPECT_LT(rows[1]["deviation"].get<double>(), 0.2);
  ASSERT_EQ(run("run " + adaptive + "--set geometry.0.refine.levels=1 --no-pictures --out r").code,
            0);
  EXPECT_EQ(result("r")["state_hash"], rows[0]["state_hash"]) << "it is the run that `run` makes";
}

TEST_F(CompareCells, ACellThatCannotStartIsMarkedAndTheOthersRun) {
  const Outcome outcome = compare(
      "ball.json --vary geometry.0.transformation.translation=[0,0,0.303],[0,0,0.2] --repeats 1 "
      "--no-reference --no-pictures --out c");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_SAYS(outcome.err, "cannot run and is marked: geometry.0.transformation.translation");
  const Json rows = table("c")["rows"];
  EXPECT_EQ(rows[0]["status"], "ok");
  EXPECT_EQ(rows[1]["status"], "refused");
  EXPECT_SAYS(rows[1]["why"].get<std::string>(), "crosses a body");
}

TEST_F(CompareCells, ACellThatDivergesIsMarkedAndTheOthersGoOn) {
  const Outcome outcome = compare(
      "hang.json --set solver.strain_limiter=false --vary gravity=[0,0,-9.81],[0,0,-1e6] --repeats "
      "1 --no-reference "
      "--no-pictures "
      "--out c");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const Json rows = table("c")["rows"];
  EXPECT_EQ(rows[0]["status"], "ok");
  EXPECT_EQ(rows[1]["status"], "unstable");
  EXPECT_NE(rows[1]["why"], "");
}

TEST_F(CompareCells, LargeClothIsRunInCopiesOfAProcessWithOneThread) {
  const Outcome outcome = compare(
      "hang.json --set geometry.0.cells=[48,48] --set time.frames=1 --vary threads=1,2 --repeats 1 "
      "--no-pictures --out c");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_SAYS(outcome.out, "2 runs took");
  const Json rows = table("c")["rows"];
  EXPECT_EQ(rows[0]["state_hash"], rows[1]["state_hash"]);
}

// -- folders --------------------------------------------------------------------------------------

constexpr const char* kSmall =
    "hang.json --vary dt=0.002,0.004,0.008 --repeats 2 --no-pictures --out ";

TEST_F(CompareCells, KilledAtAnyMomentItGoesOnToTheSameTable) {
  ASSERT_EQ(compare(std::string(kSmall) + "whole").code, 0);
  for (const char* seconds : {"0.15", "0.4"})
    run(std::string("compare ") + kSmall + "torn", std::string("timeout -s KILL ") + seconds);
  ASSERT_EQ(compare(std::string(kSmall) + "torn").code, 0);
  EXPECT_EQ(lasting_csv("torn"), lasting_csv("whole"));
}

TEST_F(CompareCells, WhatIsDoneIsNotDoneAgain) {
  ASSERT_EQ(compare(std::string(kSmall) + "c").code, 0);
  const std::string csv = content(folder_ / "c" / "compare.csv");
  ASSERT_EQ(compare(std::string(kSmall) + "c").code, 0);
  EXPECT_EQ(content(folder_ / "c" / "compare.csv"), csv) << "times differ: it ran again";
}

TEST_F(CompareCells, AnotherCompareDoesNotMixWithTheOneInAFolder) {
  ASSERT_EQ(compare(std::string(kSmall) + "c").code, 0);
  EXPECT_REFUSED(compare("hang.json --vary dt=0.002 --repeats 1 --out c"), "is another compare");
  fs::create_directories(folder_ / "other");
  write("other/letter.txt", "dear");
  EXPECT_REFUSED(compare("hang.json --vary dt=0.002 --repeats 1 --out other"),
                 "holds files that are of no compare");
}

/// A plan of one cell, without its runs.
ComparePlan small_plan() {
  ComparePlan plan;
  plan.axes = {{"dt", {"0.002"}, true}};
  plan.cells = {{"0000_ab", {"0.002"}, {}, 1, ""}};
  plan.levels = {"reference_ab"};
  return plan;
}

TEST_F(CompareCells, APlanIsReadAsItWasWritten) {
  write_plan(folder_ / "c", small_plan(), {});
  const ComparePlan read = read_plan(folder_ / "c");
  EXPECT_EQ(read.cells.at(0).id, "0000_ab");
  EXPECT_EQ(read.cells.at(0).threads, 1);
  EXPECT_EQ(read.repeats, 7);
  EXPECT_EQ(read.limits.core, -1);
  EXPECT_EQ(read.limits.budget_s, 300.0);
}

TEST_F(CompareCells, AChangedPlanIsRefusedWithThePlaceAndARemedy) {
  write_plan(folder_ / "c", small_plan(), {});
  const fs::path file = folder_ / "c" / "plan.json";
  const Json whole = Json::parse(content(file));
  struct Change {
    const char *pointer, *value, *fault;
  };
  const Change changes[] = {
      {"/repeats", "1e30", "repeats: must be a whole number from 1 to 1000, is 1e+30"},
      {"/repeats", "2.5", "repeats: must be a whole number from 1 to 1000, is 2.5"},
      {"/repeats", "0", "repeats: must be a whole number from 1 to 1000, is 0"},
      {"/repeats", "\"2\"", "repeats: must be a whole number from 1 to 1000, is \"2\""},
      {"/threads", "-1", "threads: must be a whole number from 0 to 1024, is -1"},
      {"/threads", "4294967297", "threads: must be a whole number from 0 to 1024, is 4294967297"},
      {"/core", "-2", "core: must be a whole number from -1 to 2147483647, is -2"},
      {"/judged_motions", "0.5", "judged_motions: must be a whole number from 0 to "},
      {"/cells/0/threads", "18446744073709551615", "cells[0].threads: must be a whole number"},
      {"/cells/0/id", "\"../../up\"", "cells[0].id: must be a name of letters, digits and _"},
      {"/levels/0", "\"\"", "levels[0]: must be a name of letters, digits and _"},
      {"/cells/0/values", "[]", "cells[0].values: must be a list of 1, one value for each axis"},
      {"/cells/0/values", "[7]", "cells[0].values[0]: must be a string, is 7"},
      {"/cells", "{}", "cells: must be a list [...], is {}"},
      {"/cells/0", "3", "cells[0]: must be an object {...}, is 3"},
      {"/axes/0/numeric", "1", "axes[0].numeric: must be true or false, is 1"},
      {"/budget_s", "0", "budget_s: must be a number greater than 0, is 0"},
      {"/budget_s", "null", "budget_s: must be a number greater than 0, is null"},
      {"/reference", "\"moon\"", "reference: must be \"none\", \"closed_form\" or \"converged\""},
      {"/error", "\"moon\"", "error: must be one of position, hausdorff"},
  };
  for (const auto& [pointer, value, fault] : changes) {
    Json changed = whole;
    changed[Json::json_pointer(pointer)] = Json::parse(value);
    write("c/plan.json", changed.dump());
    const std::string said = refusal([&] { read_plan(folder_ / "c"); });
    EXPECT_TRUE(said.starts_with(file.string() + ": " + fault)) << pointer << ": " << said;
    EXPECT_TRUE(said.ends_with("; remove the folder and start the compare again")) << said;
  }
  for (const auto& [key, value] : whole.items()) {
    Json changed = whole;
    changed.erase(key);
    write("c/plan.json", changed.dump());
    EXPECT_SAYS(refusal([&] { read_plan(folder_ / "c"); }), key + ": is missing");
  }
  EXPECT_REFUSED(run("advise c --error 1"), "is missing; remove the folder");
}

TEST_F(CompareCells, ARunWhoseCountsAreNoneIsMadeAgain) {
  fs::create_directories(folder_ / "cell");
  note_run(folder_ / "cell", 0, {});
  ASSERT_TRUE(read_cell_run(folder_ / "cell", 0));
  const Json whole = Json::parse(content(folder_ / "cell/run_0.json"));
  for (const char* pointer : {"/particles", "/peak_bytes", "/pairs/motions", "/pairs/colliding",
                              "/pairs/broad_missed", "/pairs/narrow_missed", "/pairs/narrow_false"})
    for (const char* value : {"1e30", "2.5", "-1", "\"2\"", "null"}) {
      Json changed = whole;
      changed[Json::json_pointer(pointer)] = Json::parse(value);
      write("cell/run_0.json", changed.dump());
      EXPECT_FALSE(read_cell_run(folder_ / "cell", 0)) << pointer << ": " << value;
    }
}

TEST_F(CompareCells, MoreThreadsThanThereCanBeAreRefused) {
  for (const char* threads : {"1e30", "1025", "-1", "1.5"})
    EXPECT_REFUSED(compare(std::string("hang.json --out c --vary threads=") + threads),
                   "must be a whole number from 0 to 1024");
}

TEST_F(CompareCells, TwoComparesInOneFolderExcludeEachOther) {
  const FolderLock lock(folder_ / "c", "compare");
  EXPECT_REFUSED(compare(std::string(kSmall) + "c"), "is at work in this folder");
}

TEST_F(CompareCells, AFullDiskIsSaidAndNothingIsLost) {
  // No file may have more than so many blocks of 512 bytes: scenes fit, what they end in does not.
  const Outcome full = compare(std::string(kSmall) + "c", "ulimit -f 10;");
  EXPECT_EQ(full.code, 1) << full.out;
  EXPECT_SAYS(full.err, "File too large");
  ASSERT_EQ(compare(std::string(kSmall) + "c").code, 0);
  EXPECT_EQ(table("c")["rows"][2]["status"], "ok");
}

TEST_F(CompareCells, AdviceIsTheQuickestWithinTheError) {
  ASSERT_EQ(
      compare("hang.json --vary dt=0.0005,0.002,0.008 --repeats 1 --no-pictures --out c").code, 0);
  const Json rows = table("c")["rows"];
  const double between = 1.01 * rows[1]["error"].get<double>();
  const Outcome outcome = run("advise c --json --error " + std::to_string(between));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json advice = Json::parse(outcome.out);
  EXPECT_LE(advice["error"].get<double>(), between);
  EXPECT_SAYS(advice["command"].get<std::string>(), "--set time.steps_per_frame=");
  EXPECT_EQ(run("advise c --error 1e-12").code, 1);
}

// -- the page -------------------------------------------------------------------------------------

TEST_F(CompareCells, ThePageNeedsNothingButItself) {
  ASSERT_EQ(compare("ball.json --vary dt=0.004,0.008 --repeats 1 --out c").code, 0);
  const std::string page = content(folder_ / "c" / "compare.html");
  EXPECT_SAYS(page, "data:image/png;base64,");
  for (const char* outside : {"src=\"http", "href=\"http", "url(http", "import ", "@import"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
}

TEST_F(CompareCells, ThePageLinksThePagesOfItsCells) {
  ASSERT_EQ(
      compare("ball.json --vary dt=0.004,0.008 --repeats 1 --no-pictures --views --out c").code, 0);
  const std::string page = content(folder_ / "c" / "compare.html");
  const Json all = table("c");
  ASSERT_EQ(all["rows"].size(), 2u);
  for (const Json& row : all["rows"]) {
    const std::string view = "cells/" + row["id"].get<std::string>() + "/view.html";
    EXPECT_SAYS(page, "\"view\":\"" + view + "\"");
    EXPECT_SAYS(content(folder_ / "c" / view), "\"name\":\"" + row["label"].get<std::string>());
  }
}

TEST_F(CompareCells, InABrowserThePageOpensWithoutErrorAndPlotsEveryCell) {
  const char* browser = has_program("chromium")        ? "chromium"
                        : has_program("google-chrome") ? "google-chrome"
                                                       : nullptr;
  if (browser == nullptr)
    GTEST_SKIP() << "there is no browser; install chromium to have the page of compare opened";
  ASSERT_EQ(compare("hang.json --vary dt=0.001,0.002,0.004,0.008 --repeats 1 --out c").code, 0);
  const std::string command =
      "cd '" + folder_.string() + "' && HOME='" + folder_.string() + "' timeout 60 " + browser +
      " --headless --no-sandbox --disable-dev-shm-usage --disable-gpu --enable-logging=stderr "
      "--dump-dom "
      "\"file://$PWD/c/compare.html\" >page.txt 2>said.txt";
  ASSERT_EQ(std::system(command.c_str()), 0) << content(folder_ / "said.txt");
  const std::string page = content(folder_ / "page.txt");
  EXPECT_EQ(content(folder_ / "said.txt").find("CONSOLE"), std::string::npos)
      << content(folder_ / "said.txt");
  EXPECT_SAYS(page, "data-ready=\"yes\"");
  EXPECT_SAYS(page, "data-rows=\"4\"");
  std::size_t points = 0;
  for (auto at = page.find("class=\"point\""); at != std::string::npos;
       at = page.find("class=\"point\"", at + 1))
    ++points;
  EXPECT_EQ(points, 4u);
}

/// A script that counts texts of the page's plots that overlap or leave their picture.
constexpr const char* kCountFaults = R"(<script>
const boxes = [...document.querySelectorAll("svg")].map(svg => [svg.getBoundingClientRect(),
  [...svg.querySelectorAll("text")].filter(t => t.textContent).map(t => t.getBoundingClientRect())]);
let overlaps = 0, cut = 0;
for (const [svg, texts] of boxes)
  texts.forEach((a, i) => {
    cut += a.left < svg.left - 1 || a.right > svg.right + 1 || a.top < svg.top - 1 || a.bottom > svg.bottom + 1;
    for (const b of texts.slice(i + 1))
      overlaps += Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3;
  });
parent.postMessage(`texts ${boxes.flatMap(b => b[1]).length > 4} overlaps ${overlaps} cut ${cut}`, "*");
</script>)";

TEST_F(CompareCells, TextsOfThePlotsNeitherOverlapNorAreCut) {
  if (!has_program("chromium")) GTEST_SKIP() << "there is no chromium";
  ASSERT_EQ(
      compare("hang.json --vary dt=0.001,0.00102,0.00104 --repeats 1 --no-pictures --out c").code,
      0);
  ASSERT_EQ(
      compare("hang.json --vary integrator=implicit_euler,implicit_newton,bdf2 --no-reference "
              "--set time.frames=1 --repeats 1 --no-pictures --out d")
          .code,
      0);
  for (const std::string out : {"c", "d"}) {
    std::ofstream(folder_ / out / "compare.html", std::ios::app) << kCountFaults;
    for (const char* width : {"390", "1280"}) {
      // A window is at least 500 pixels wide, so the page is shown in a frame.
      std::ofstream(folder_ / "frame.html")
          << "<script>onmessage = e => document.body.append(e.data)</script>"
             "<iframe style='border:0;height:3000px;width:"
          << width << "px' src='" << out << "/compare.html'></iframe>";
      const std::string command =
          "cd '" + folder_.string() + "' && HOME='" + folder_.string() +
          "' timeout 60 chromium --headless --no-sandbox --disable-dev-shm-usage --disable-gpu "
          "--allow-file-access-from-files --virtual-time-budget=3000 --window-size=1400,3200 "
          "--dump-dom \"file://$PWD/frame.html\" >page.txt 2>/dev/null";
      ASSERT_EQ(std::system(command.c_str()), 0);
      EXPECT_SAYS(content(folder_ / "page.txt"), "texts true overlaps 0 cut 0");
    }
  }
}

// -- a workflow -----------------------------------------------------------------------------------

TEST_F(CompareCells, SpreadOverJobsItGivesTheSameTable) {
  if (!has_program("snakemake"))
    GTEST_SKIP() << "there is no snakemake; install it to have the workflow of compare run";
  const std::string what = "hang.json --vary dt=0.004,0.008 --repeats 1 --no-pictures ";
  ASSERT_EQ(compare(what + "--out whole").code, 0);
  ASSERT_EQ(compare(what + "--workflow jobs").code, 0);
  const std::string command = "cd '" + (folder_ / "jobs").string() + "' && HOME='" +
                              folder_.string() + "' snakemake --cores 2 --config selvedge='" +
                              program + "' >said.txt 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << content(folder_ / "jobs" / "said.txt");
  EXPECT_EQ(lasting_csv("jobs"), lasting_csv("whole"));
}

}  // namespace

}  // namespace selvedge::compare_test
