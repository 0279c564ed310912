// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/query_file.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "run_program.h"

namespace selvedge::ccd_command_test {
namespace {

using namespace selvedge::testing;

/// A triangle at rest in the plane z = 0 and a point that falls through it at the time t = toi,
/// which is a double, or passes beside it.
Query falling_point(double toi, bool beside) {
  Query q;
  q.kind = ContactKind::point_triangle;
  q.x_t0 = {Vec3(beside ? 2.0 : 0.25, 0.25, toi), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  q.x_t1 = q.x_t0;
  q.x_t1[0][2] = toi - 1.0;
  return q;
}

class CcdCommand : public Program {
 protected:
  /// Twelve queries, four of which collide, at known times.
  void write_falling(const std::string& name, bool wrong = false) const {
    QueryWriter writer(folder_ / name);
    for (int i = 0; i < 12; ++i) {
      const bool hits = i % 3 == 0;
      const double toi = (i + 1) / 16.0;
      TimeEnclosure truth;
      if (hits != (wrong && i == 0)) truth = {toi, toi};
      writer.append(falling_point(toi, !hits), truth);
    }
    writer.commit();
  }

  /// The only result of `selvedge ccd --json arguments`.
  Json score(const std::string& arguments) const {
    const Outcome o = run("ccd --json " + arguments);
    EXPECT_EQ(o.code, 0) << o.err;
    const Json all = Json::parse(o.out, nullptr, false);
    EXPECT_EQ(all["results"].size(), 1u) << o.out;
    return all["results"].empty() ? Json() : all["results"][0];
  }
};

TEST_F(CcdCommand, EveryFieldIsThereAndCounts) {
  write_falling("fall_vf.csv");
  const Json r = score("fall_vf.csv --narrow-phase ccd_exact");
  EXPECT_EQ(r["file"], "fall_vf.csv");
  EXPECT_EQ(r["kind"], "point_triangle");
  EXPECT_EQ(r["narrow_phase"], "ccd_exact");
  EXPECT_EQ(r["queries"], 12);
  EXPECT_EQ(r["positives"], 4);
  EXPECT_EQ(r["misses"], 0);
  EXPECT_EQ(r["false_alarms"], 0);
  EXPECT_EQ(r["late_toi"], 0);
  EXPECT_EQ(r["max_toi_error"], 0.0);
  EXPECT_EQ(r["toi_from"], "file");
  double last = 0.0;
  for (const char* time : {"median_us", "p99_us", "max_us"}) {
    ASSERT_TRUE(r[time].is_number()) << time;
    EXPECT_GE(r[time].get<double>(), last) << time;
    last = r[time].get<double>();
  }
  EXPECT_GT(r["mean_us"].get<double>(), 0.0);
}

TEST_F(CcdCommand, WrongAnswersInTheFileAreMissesAndFalseAlarms) {
  write_falling("fall_vf.csv", true);
  Json r = score("fall_vf.csv --narrow-phase ccd_exact --repeats 0");
  EXPECT_EQ(r["false_alarms"], 1) << "the file says that the first query does not collide";
  EXPECT_EQ(r["first_false_alarm"], 0);
  EXPECT_EQ(r["positives"], 3);
  EXPECT_TRUE(r["mean_us"].is_null());
  QueryWriter writer(folder_ / "wrong_vf.csv");
  writer.append(falling_point(0.5, false), {0.5, 0.5});
  writer.append(falling_point(0.5, true), {0.5, 0.5});
  writer.commit();
  r = score("wrong_vf.csv --narrow-phase ccd_exact");
  EXPECT_EQ(r["misses"], 1);
  EXPECT_EQ(r["first_miss"], 1);
}

TEST_F(CcdCommand, TimesAreJudgedByTheEnclosureBesideTheFile) {
  const auto judged = [&](const TimeEnclosure& truth) {
    QueryWriter writer(folder_ / "t_vf.csv");
    writer.append(falling_point(0.5, false), truth);
    writer.commit();
    return score("t_vf.csv --narrow-phase ccd_exact --repeats 0");
  };
  const double below = std::nextafter(0.5, 0.0), above = std::nextafter(0.5, 1.0);
  EXPECT_EQ(judged({0.5, above})["late_toi"], 0);
  EXPECT_EQ(judged({below, 0.5})["late_toi"], 1) << "0.5 is no time before 0.5";
  EXPECT_EQ(judged({0.25, 0.75})["late_toi"], 0) << "a wide enclosure does not tell";
  const Json late = judged({0.125, 0.25});
  EXPECT_EQ(late["late_toi"], 1);
  EXPECT_EQ(late["max_toi_error"], 0.25);
  const Json early = judged({0.75, 0.875});
  EXPECT_EQ(early["late_toi"], 0);
  EXPECT_EQ(early["max_toi_error"], 0.25);
}

TEST_F(CcdCommand, WithoutATimeFileCcdExactTellsTheTimes) {
  write_falling("fall_vf.csv");
  fs::remove(folder_ / "fall_vf.toi.csv");
  const Json r = score("fall_vf.csv --narrow-phase ccd_cubic --repeats 0");
  EXPECT_EQ(r["toi_from"], "ccd_exact");
  EXPECT_EQ(r["misses"], 0);
  EXPECT_LT(r["max_toi_error"].get<double>(), 1e-9);
}

TEST_F(CcdCommand, FoldersAreSearchedAndMerged) {
  for (const char* folder : {"set/cloth/vertex-face", "set/cloth/edge-edge", "set/rod/vertex-face"})
    fs::create_directories(folder_ / folder);
  write_falling("set/cloth/vertex-face/a.csv");
  write_falling("set/cloth/vertex-face/b.csv");
  write_falling("set/cloth/edge-edge/a.csv");  // the kind is what the folder says
  write_falling("set/rod/vertex-face/a.csv");
  const auto results = [&](const std::string& more) {
    const Outcome o = run("ccd set --json --repeats 0 --narrow-phase ccd_exact " + more);
    EXPECT_EQ(o.code, 0) << o.err;
    return Json::parse(o.out, nullptr, false)["results"];
  };
  EXPECT_EQ(results("").size(), 4u);
  const Json families = results("--merge family");
  ASSERT_EQ(families.size(), 3u);
  EXPECT_EQ(families[0]["file"], "cloth");
  EXPECT_EQ(families[0]["kind"], "edge_edge");
  EXPECT_EQ(families[1]["queries"], 24);
  EXPECT_EQ(families[2]["file"], "rod");
  const Json kinds = results("--merge kind");
  ASSERT_EQ(kinds.size(), 2u);
  EXPECT_EQ(kinds[0]["queries"].get<int>() + kinds[1]["queries"].get<int>(), 48);
}

TEST_F(CcdCommand, AllAsksEveryMethodAndTheTableNamesThem) {
  write_falling("fall_vf.csv");
  const Outcome listed = run("list --json");
  const Outcome o = run("ccd fall_vf.csv --narrow-phase all --json --repeats 1");
  EXPECT_EQ(o.code, 0) << o.err;
  const Json all = Json::parse(o.out, nullptr, false);
  std::size_t methods = 0;
  const Json list = Json::parse(listed.out)["methods"];
  for (const Json& method : list) methods += method["family"] == "narrow_phase";
  EXPECT_EQ(all["results"].size() + all["skipped"].size(), methods);
  EXPECT_GE(all["results"].size(), 2u);
  const Outcome table = run("ccd fall_vf.csv --repeats 1");
  EXPECT_EQ(table.code, 0);
  EXPECT_SAYS(table.out, "12 point_triangle queries, 4 collide");
  EXPECT_SAYS(table.out, "ccd_exact");
  EXPECT_SAYS(table.out, "misses");
}

TEST_F(CcdCommand, WhoCannotKeepAMinimumSeparationIsLeftOutAndSaidSo) {
  QueryWriter writer(folder_ / "near_vf.csv");
  Query query = falling_point(0.5, true);  // passes the triangle's edge x + y = 1 at a distance
  query.x_t0[0][0] = query.x_t1[0][0] = 0.875;
  writer.append(query, {});
  writer.commit();
  const std::string separation = "near_vf.csv --json --repeats 0 --min-separation 0.25 ";
  const Json r = score("--narrow-phase ccd_exact " + separation);
  EXPECT_EQ(r["false_alarms"], 1) << "the answers of the file are for no separation";
  const Outcome all = run("ccd " + separation);
  EXPECT_EQ(all.code, 0) << all.err;
  EXPECT_NE(Json::parse(all.out, nullptr, false)["skipped"].size(), 0u);
  EXPECT_REFUSED(run("ccd --narrow-phase ccd_cubic " + separation),
                 "selvedge: ccd_cubic: has no option");
  EXPECT_EQ(run("ccd --narrow-phase ccd_exact near_vf.csv --min-separation nan").code, 2);
}

TEST_F(CcdCommand, WindowsLineEndsAreNotedAndRead) {
  write_falling("fall_vf.csv");
  std::string text;
  for (const char c : content(folder_ / "fall_vf.csv")) {
    if (c == '\n') text += '\r';
    text += c;
  }
  write("fall_vf.csv", text);
  const Outcome o = run("ccd fall_vf.csv --json --repeats 0 --narrow-phase ccd_exact");
  EXPECT_EQ(o.code, 0);
  EXPECT_SAYS(o.err, "note: fall_vf.csv: line 1: ");
  EXPECT_EQ(Json::parse(o.out)["results"][0]["queries"], 12);
}

TEST_F(CcdCommand, WrongInputIsRefusedWithItsPlace) {
  write_falling("fall_vf.csv");
  const std::string good = content(folder_ / "fall_vf.csv");
  const auto with = [&](const std::string& text) {
    fs::remove(folder_ / "x_vf.toi.csv");
    write("x_vf.csv", text);
    return run("ccd x_vf.csv --narrow-phase ccd_exact");
  };
  EXPECT_REFUSED(with(""), "x_vf.csv: is empty");
  EXPECT_REFUSED(with(good + "1,1,1,1,1,1,0\n"),
                 "x_vf.csv: line 97: the file ends after 1 of the 8");
  EXPECT_REFUSED(with("1,1,1,0,1,1,0\n" + good), "x_vf.csv: line 1: y_den is zero");
  EXPECT_REFUSED(with("1,1,1,3,1,1,0\n" + good), "x_vf.csv: line 1: y is \"1/3\", which no double");
  EXPECT_REFUSED(with("1,1,1,1\n" + good), "x_vf.csv: line 1: has 4 columns");
  std::string contradicting = good;
  contradicting[contradicting.find(",1\n") + 1] = '0';
  EXPECT_REFUSED(with(contradicting), "line 2: truth is 1, but line 1 of the same query says 0");
  write("x_vf.csv", good);
  write("x_vf.toi.csv", "0,1,0,0\n");
  EXPECT_REFUSED(run("ccd x_vf.csv"), "x_vf.toi.csv: has times for 1 of 12 queries");
  EXPECT_REFUSED(run("ccd none.csv"), "none.csv: no such file");
  EXPECT_REFUSED(run("ccd small.json"), "small.json");
  write("data.csv", good);
  EXPECT_REFUSED(run("ccd data.csv"), "give --kind point_triangle or --kind edge_edge");
  EXPECT_EQ(run("ccd data.csv --kind point_triangle --repeats 0").code, 0);
  fs::create_directory(folder_ / "hollow");
  EXPECT_REFUSED(run("ccd hollow"), "holds no query file");
  EXPECT_REFUSED(run("ccd fall_vf.csv --narrow-phase ccd_guess"), "there is no \"ccd_guess\"");
  for (const char* arguments :
       {"ccd", "ccd fall_vf.csv --kind both", "ccd fall_vf.csv --repeats -1",
        "ccd fall_vf.csv --min-separation -1"}) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.code, 2) << arguments;
    EXPECT_NE(o.err, "") << arguments;
  }
}

// -- recording ------------------------------------------------------------------------------------

TEST_F(CcdCommand, RecordingDoesNotChangeARunAndHasNoWrongAnswer) {
  // A ball of coarse cells that the cloth falls on fast: there are collisions to record.
  const std::string fast = "--set time.frames=6 --set time.fps=12 --set contact.self=true ";
  ASSERT_EQ(run_small("plain", fast).code, 0);
  const Outcome o = run_small("recorded", fast + "--record rec --record-limit 3000");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_SAYS(o.err, "rec.point_triangle.csv");
  EXPECT_EQ(result("plain")["state_hash"], result("recorded")["state_hash"]);
  const Outcome scored =
      run("ccd rec.point_triangle.csv rec.edge_edge.csv --json --narrow-phase ccd_exact");
  ASSERT_EQ(scored.code, 0) << scored.err;
  const Json results = Json::parse(scored.out)["results"];
  ASSERT_EQ(results.size(), 2u);
  for (const Json& r : results) {
    EXPECT_EQ(r["misses"], 0);
    EXPECT_EQ(r["false_alarms"], 0);
    EXPECT_EQ(r["late_toi"], 0);
    EXPECT_EQ(r["toi_from"], "file");
    EXPECT_GT(r["queries"], 1500);
    EXPECT_LE(r["queries"], 3000);
  }
}

TEST_F(CcdCommand, ARecordingNeedsAPlaceBeforeTheRunStarts) {
  EXPECT_REFUSED(run_small("r", "--record none/rec"), "there is no such folder");
  EXPECT_FALSE(exists("r"));
  fs::create_directory(folder_ / "queries");
  ASSERT_EQ(run_small("r", "--record queries").code, 0);
  EXPECT_TRUE(exists("queries/point_triangle.csv"));
  EXPECT_EQ(count("queries", ""), 4u) << "two kinds with their times and nothing else";
}

}  // namespace

}  // namespace selvedge::ccd_command_test
