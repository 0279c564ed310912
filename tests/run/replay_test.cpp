// SPDX-License-Identifier: MIT
// Runs that stop, what they leave, and what `selvedge replay` makes of it.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/response/fail_safe.h>
#include <selvedge/run/internal/replay.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>
#include <selvedge/simulation/internal/explain_step.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "run_program.h"

namespace selvedge::replay_test {
namespace {

using namespace selvedge::testing;

/// A napkin between two plates that close at 0.151 m/s until nothing is left between them.
const char* const kPinch = R"({
  "name": "pinch",
  "geometry": [{"name": "napkin", "size": [0.2, 0.2], "cells": [6, 6]}],
  "obstacles": [
    {"name": "lower plate", "shape": {"type": "box", "size": [0.3, 0.3, 0.05]},
     "transformation": {"translation": [0, 0, -0.04]},
     "motion": [{"time": 0}, {"time": 0.2, "translation": [0, 0, 0.0151]}]},
    {"name": "upper plate", "shape": {"type": "box", "size": [0.3, 0.3, 0.05]},
     "transformation": {"translation": [0, 0, 0.04]},
     "motion": [{"time": 0}, {"time": 0.2, "translation": [0, 0, -0.0151]}]}],
  "contact": {"fail_safe": "impulse_zones"},
  "time": {"frames": 14}})";
constexpr double kClosing = 0.151;  // m/s

/// A cloth that a handle holds all over and carries down onto a table.
const char* const kCarried = R"({
  "name": "carried",
  "geometry": [{"name": "sheet", "size": [0.2, 0.2], "cells": [2, 2],
                "transformation": {"translation": [0, 0, 0.04]}}],
  "handles": [{"name": "frame", "geometry": "sheet", "select": [0, 1, 2, 3, 4, 5, 6, 7, 8],
               "motion": [{"time": 0}, {"time": 0.1, "translation": [0, 0, -0.1]}]}],
  "obstacles": [{"name": "table", "shape": {"type": "box", "size": [1, 1, 0.05]}}],
  "time": {"frames": 10}})";

class Replay : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    write("pinch.json", kPinch);
    write("carried.json", kCarried);
  }

  Outcome pinch(const std::string& out, const std::string& more = "") const {
    return run("run pinch.json --no-pictures --out " + out + " " + more);
  }

  Json replayed(const std::string& bundle, const std::string& more = "") const {
    return Json::parse(run("replay " + bundle + " --json " + more).out, nullptr, false);
  }

  Json failure(const std::string& out) const {
    return Json::parse(content(folder_ / out / "failure/failure.json"), nullptr, false);
  }

  void spoil(const std::string& file, const std::string& from, const std::string& to) const {
    std::string text = content(folder_ / file);
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from << " in " << file;
    write(file, text.replace(at, from.size(), to));
  }
};

// -- the bundle -----------------------------------------------------------------------------------

TEST_F(Replay, AFailedRunKeepsItsLastGoodStateToTheBit) {
  const Outcome o = pinch("p", "--every-step");
  EXPECT_EQ(o.code, 1);
  EXPECT_SAYS(o.err, "selvedge replay p/failure --explain");
  const std::size_t last = count("p/steps", "cloth_") - 1;
  const fs::path step = numbered(folder_ / "p/steps", "cloth", static_cast<int>(last), 6, ".ply");
  std::vector<NamedValues> of_bundle, of_step;
  EXPECT_EQ(read_ply(folder_ / "p/failure/state.ply", of_bundle).vertices,
            read_ply(step, of_step).vertices);
  const FailureBundle bundle = read_failure_bundle(folder_ / "p/failure");
  EXPECT_EQ(bundle.kind, FailureKind::not_clean);
  EXPECT_EQ(bundle.state.step, static_cast<std::int64_t>(last));
  EXPECT_EQ(state_hash(bundle.state), result("p")["state_hash"].get<std::string>());
}

TEST_F(Replay, TheCauseIsOneLineThatNamesTimeHalvingsAndThePair) {
  pinch("p");
  const std::string cause = content(folder_ / "p/failure/cause.txt");
  EXPECT_EQ(std::count(cause.begin(), cause.end(), '\n'), 1) << cause;
  EXPECT_SAYS(cause, "no clean step at 0.19");
  EXPECT_SAYS(cause, "after 8 halvings");
  EXPECT_SAYS(cause, "of cloth \"napkin\" and ");
  EXPECT_SAYS(cause, "er plate\"");
  EXPECT_EQ(cause, result("p")["stopped"].get<std::string>() + "\n");
}

TEST_F(Replay, TheStepFailsAgainWithTheSameCauseOnAnyThreads) {
  pinch("p");
  EXPECT_EQ(run("replay p").code, 1) << "the result folder finds its bundle";
  for (const char* more : {"--threads 1", "--threads 2", "--explain"}) {
    const Json again = replayed("p/failure", more);
    EXPECT_EQ(again["as_recorded"], true) << more << again;
    EXPECT_EQ(again["passes"], false);
    EXPECT_EQ(again["kind"], "not clean");
    EXPECT_EQ(again["cause"], result("p")["stopped"]);
    EXPECT_EQ(again["state_hash"], result("p")["state_hash"]);
    EXPECT_EQ(again["attempts_s"], failure("p")["attempts_s"]);
  }
}

TEST_F(Replay, ABundleOfTheFirstFormatIsRepeated) {
  pinch("p");
  Json old = failure("p");
  const Json attempts = old["attempts_s"];
  old["format"] = 1;
  old["what"] = old["kind"];
  old["tried_s"] = attempts;
  old.erase("kind");
  old.erase("attempts_s");
  write("p/failure/failure.json", old.dump());
  const Json again = replayed("p/failure");
  EXPECT_EQ(again["as_recorded"], true) << again;
  EXPECT_EQ(again["attempts_s"], attempts);
}

TEST_F(Replay, EveryFailSafeStopsWithWhatSqueezesWhatAndWhatHelps) {
  for (const std::string& name : fail_safes().names()) {
    SCOPED_TRACE(name);
    ASSERT_EQ(pinch("p", "--overwrite --set contact.fail_safe=" + name).code, 1);
    const std::string cause = content(folder_ / "p/failure/cause.txt");
    EXPECT_SAYS(cause, "squeeze cloth \"napkin\" between them: in this attempt of ");
    EXPECT_SAYS(cause, "body \"lower plate\"");
    EXPECT_SAYS(cause, "body \"upper plate\"");
    EXPECT_SAYS(cause, "leave the cloth more room there, or set contact.still_tangled");
    const Json again = replayed("p", "--explain");
    EXPECT_EQ(again["as_recorded"], true) << again;
    EXPECT_EQ(again["cause"], result("p")["stopped"]);
    EXPECT_EQ(again["state_hash"], result("p")["state_hash"]);
    EXPECT_EQ(again["explanation"]["culprits"][0]["kind"], "squeeze");
  }
}

TEST_F(Replay, AHandleThatLeadsClothIntoABodyIsNamed) {
  const Outcome o = run("run carried.json --no-pictures --out c");
  EXPECT_EQ(o.code, 1);
  EXPECT_SAYS(o.err, "handle \"frame\" carries vertex ");
  EXPECT_SAYS(o.err, "of cloth \"sheet\" into body \"table\"");
  EXPECT_SAYS(o.err, "slow this handle, or lead it another way");
}

TEST_F(Replay, TheExactMethodMissesNoneOfTheQueries) {
  pinch("p");
  for (const std::string kind : {"point_triangle", "edge_edge"}) {
    const Outcome o = run("ccd p/failure/queries/" + kind + ".csv --narrow-phase ccd_exact --json");
    ASSERT_EQ(o.code, 0) << o.err;
    const Json score = Json::parse(o.out, nullptr, false)["results"][0];
    EXPECT_GT(score["positives"], 0) << kind;
    EXPECT_GT(score["queries"], score["positives"]) << "those around them are there, too";
    EXPECT_EQ(score["misses"], 0);
    EXPECT_EQ(score["false_alarms"], 0);
    EXPECT_EQ(score["late_toi"], 0);
  }
}

TEST_F(Replay, TheOffendersAreMeshesBetweenWhichTheJudgeFindsTheCollisions) {
  pinch("p");
  const std::string frames = "p/failure/frames/";
  const Outcome o =
      run("check " + frames + "cloth_00000.ply --against " + frames + "bodies_00000.ply --next " +
          frames + "cloth_00001.ply --against-next " + frames + "bodies_00001.ply --json");
  const Json found = Json::parse(o.out, nullptr, false);
  EXPECT_EQ(found["body_intersections"], 0) << "the start is clean";
  EXPECT_GT(found["path_body_collisions"], 0);
  EXPECT_EQ(run("render p/failure --out pictures").code, 0);
}

TEST_F(Replay, ABundleCarriesTheMeshesOfItsScene) {
  fs::create_directories(folder_ / "meshes");
  const TriangleMesh plate = tessellate(Box{Vec3(0.3, 0.3, 0.05)}, 4);
  write_obj(folder_ / "meshes/plate.obj", plate.vertices, plate.triangles);
  spoil("pinch.json", R"("shape": {"type": "box", "size": [0.3, 0.3, 0.05]})",
        R"("mesh": "meshes/plate.obj")");
  ASSERT_EQ(pinch("p").code, 1);
  fs::remove_all(folder_ / "meshes");
  const Json again = replayed("p");
  EXPECT_EQ(again["as_recorded"], true) << again;
}

TEST_F(Replay, ANewRunRemovesTheBundleOfTheFormerOne) {
  ASSERT_EQ(pinch("p").code, 1);
  ASSERT_EQ(pinch("p", "--overwrite --set time.frames=2").code, 0);
  EXPECT_FALSE(exists("p/failure"));
}

// -- who pushed whom ------------------------------------------------------------------------------

TEST_F(Replay, ExplainNamesTheTwoBodiesThatSqueezeAndHowFastTheyClose) {
  pinch("p");
  const Json explanation = replayed("p", "--explain")["explanation"];
  const Json& culprit = explanation["culprits"][0];
  EXPECT_EQ(culprit["kind"], "squeeze");
  // The plates press alike; which of them rounding calls the stronger does not matter.
  auto names = culprit["names"].get<std::vector<std::string>>();
  std::sort(names.begin(), names.end());
  EXPECT_EQ(Json(names),
            Json({"body \"lower plate\"", "body \"upper plate\"", "cloth \"napkin\""}));
  EXPECT_NEAR(culprit["motion_m"].get<double>(), kClosing * explanation["try_s"].get<double>(),
              1e-9);
  EXPECT_LT(culprit["room_m"].get<double>(), 2e-5) << "there is no room left";
  const Outcome text = run("replay p --explain");
  EXPECT_SAYS(text.out, "squeeze cloth \"napkin\" between them");
  EXPECT_SAYS(text.out, "it collides since: ");
}

TEST_F(Replay, ExplainNamesTheStageSinceWhichAPairCollides) {
  pinch("p");
  const Json pairs = replayed("p", "--explain")["explanation"]["pairs"];
  ASSERT_FALSE(pairs.empty());
  for (const Json& pair : pairs) {
    EXPECT_EQ(pair["stages"].back()["collides"], true);
    bool since = false;
    for (const Json& stage : pair["stages"]) {
      since = since || stage["stage"] == pair["brought_by"];
      EXPECT_TRUE(!since || stage["collides"] == true) << pair;
    }
    EXPECT_TRUE(since) << pair;
  }
}

TEST_F(Replay, ExplainNamesTheHandleThatCarriesClothIntoABody) {
  ASSERT_EQ(run("run carried.json --no-pictures --out c").code, 1);
  const Json explanation = replayed("c", "--explain")["explanation"];
  const Json& culprit = explanation["culprits"][0];
  EXPECT_EQ(culprit["kind"], "carry") << explanation;
  EXPECT_EQ(culprit["names"], Json({"handle \"frame\"", "cloth \"sheet\"", "body \"table\""}));
  EXPECT_NEAR(culprit["motion_m"].get<double>(), 1.0 * explanation["try_s"].get<double>(), 1e-12);
}

// -- bundles that are none
// --------------------------------------------------------------------------

TEST_F(Replay, DamagedBundlesAreRefusedWithASentence) {
  EXPECT_REFUSED(run("replay nothing"), "failure.json: is missing or damaged");
  pinch("p");
  const std::string json = content(folder_ / "p/failure/failure.json");
  write("p/failure/failure.json", json.substr(0, json.size() / 2));
  EXPECT_REFUSED(run("replay p"), "failure.json: is missing or damaged");
  write("p/failure/failure.json", json);
  spoil("p/failure/failure.json", "\"kind\": \"not clean\"", "\"kind\": \"tired\"");
  EXPECT_REFUSED(run("replay p"), "\"tired\" is not a cause");
  write("p/failure/failure.json", json);
  spoil("p/failure/failure.json", "\"time\"", "\"tim\"");
  EXPECT_REFUSED(run("replay p"), "is damaged");
  write("p/failure/failure.json", json);
  std::string state = content(folder_ / "p/failure/state.ply");
  state[state.size() / 2] ^= 1;
  write("p/failure/state.ply", state);
  EXPECT_REFUSED(run("replay p"), "state.ply: is missing or damaged");
}

TEST_F(Replay, ABundleWhoseBodiesWereMovedIsRefused) {
  pinch("p");
  spoil("p/failure/scene.json", "-0.0151", "-0.0152");
  EXPECT_REFUSED(run("replay p"), "its bodies are not where they were");
}

TEST_F(Replay, ASceneWithoutTheSameClothIsRefused) {
  pinch("p");
  spoil("p/failure/scene.json", "\"geometry\": [",
        "\"geometry\": [{\"name\": \"more\", "
        "\"transformation\": {\"translation\": [0, 0, 2]}},");
  EXPECT_REFUSED(run("replay p"), "particles");
}

// -- budget and stall
// -------------------------------------------------------------------------------

TEST_F(Replay, ARunOverItsBudgetResumesToTheSameBits) {
  ASSERT_EQ(run_small("whole").code, 0);
  Outcome o = run_small("part", "--budget 1e-6");
  int stops = 0;
  for (; o.code == 1 && stops < 10; ++stops) {
    EXPECT_SAYS(result("part")["stopped"].get<std::string>(), "out of budget at ");
    EXPECT_EQ(result("part")["steps"], stops + 1) << "a step is always made";
    EXPECT_EQ(failure("part")["kind"], "out of budget");
    const Json again = replayed("part");
    EXPECT_EQ(again["passes"], true) << "nothing is the matter with the step";
    o = run_small("part", "--resume --budget 1e-6");
  }
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(stops, 5) << "six steps";
  EXPECT_EQ(result("part")["state_hash"], result("whole")["state_hash"]);
  EXPECT_EQ(frame("part", 3), frame("whole", 3));
  EXPECT_FALSE(exists("part/failure")) << "the run has got beyond it";
}

TEST_F(Replay, ARunStoppedBetweenHalvedStepsGoesOnToTheSameFailure) {
  ASSERT_EQ(pinch("whole").code, 1);
  const int steps = result("whole")["steps"];
  ASSERT_EQ(pinch("part", "--max-steps " + std::to_string(steps - 3)).code, 1);
  EXPECT_EQ(failure("part")["kind"], "out of budget");
  for (int i = 0; i < 3; ++i) ASSERT_EQ(pinch("part", "--max-steps 1 --resume").code, 1);
  EXPECT_GT(failure("part")["control"]["halvings"], 0) << "not between halved steps";
  ASSERT_EQ(pinch("part", "--resume").code, 1);
  EXPECT_EQ(failure("part"), failure("whole"));
}

/// A sheet that a bump of another pushes through; both start tangled.
const char* const kTangled = R"({
  "name": "tangled",
  "geometry": [{"name": "lying", "size": [0.3, 0.3], "cells": [12, 12], "transformation": {"translation": [0, 0, 0.2]}},
               {"name": "tilted", "size": [0.3, 0.3], "cells": [12, 12],
                "transformation": {"translation": [0.007, 0.003, 0.2], "rotation": {"axis": [1, 0.1, 0], "angle_deg": 8}}}],
  "contact": {"start": "untangle"},
  "time": {"frames": 12}})";

TEST_F(Replay, ARunStoppedAmidATangleResumesToTheSameBits) {
  write("tangled.json", kTangled);
  const std::string all = "run tangled.json --no-pictures --out ";
  run(all + "whole");
  ASSERT_GT(result("whole")["tangle"]["start_pairs"], 0);
  ASSERT_EQ(run(all + "part --max-steps 3").code, 1);
  ASSERT_GT(result("part")["tangle"]["pairs"], 0) << "it has to be tangled where it stops";
  run(all + "part --resume");
  EXPECT_EQ(result("part")["state_hash"], result("whole")["state_hash"]);
  EXPECT_EQ(result("part")["tangle"], result("whole")["tangle"]);
  EXPECT_EQ(result("part")["clean_elsewhere"], result("whole")["clean_elsewhere"]);
}

TEST_F(Replay, ARunThatCreepsIsStalledAndItsReplayCreepsAgain) {
  const Outcome o = pinch("p", "--stall-steps 1 --set time.max_halvings=4");
  EXPECT_EQ(o.code, 1);
  EXPECT_SAYS(o.err, "stalled at 0.19");
  EXPECT_SAYS(o.err, "squeeze cloth \"napkin\" between them");
  EXPECT_SAYS(o.err, "the last 1 steps was accepted only after 3 or more halvings");
  EXPECT_EQ(failure("p")["kind"], "stalled");
  EXPECT_EQ(run("replay p").code, 1);
  const Json again = replayed("p", "--explain");
  EXPECT_EQ(again["as_recorded"], true) << again;
  EXPECT_EQ(again["explanation"]["culprits"][0]["kind"], "squeeze");
  EXPECT_SAYS(pinch("q", "--stall-steps 0 --set time.max_halvings=4").err, "no clean step");
}

TEST(Stall, StepsWithFewHalvingsAllowedNeverStall) {
  EXPECT_FALSE(is_near_smallest(3, 3));
  EXPECT_TRUE(is_near_smallest(3, 4));
  EXPECT_FALSE(is_near_smallest(6, 8));
  EXPECT_TRUE(is_near_smallest(7, 8));
}

// -- positions that are nowhere
// -----------------------------------------------------------------------

/// A method of a program of its own whose force on particle 5 is no number.
class BadResponse final : public Response {
 public:
  void begin(const ResponseStep&) override {
    term_.particle = {5, -1, -1, -1};
    term_.weight = {1.0, 0.0, 0.0, 0.0};
    term_.matrix.setZero();
    term_.rhs.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  void add(std::span<const ContactPoint>) override {}
  std::span<const ImplicitTerm> terms() override { return {&term_, 1}; }
  ResponseTraits traits() const override { return {"nothing", "this test"}; }

 private:
  ImplicitTerm term_;
};

TEST_F(Replay, APositionThatIsNotFiniteStopsTheRunByName) {
  Scene scene;
  scene.name = "nowhere";
  scene.materials["default"] = {};
  scene.cloths.emplace_back().shape = ClothGrid{.grid = {.cells_x = 3, .cells_y = 3}};
  scene.cloths[0].name = "kite";
  scene.contact.response = "bad";
  RunConfig config;
  config.methods.responses.add(
      "bad", {}, [](const MethodOptions&) { return std::make_unique<BadResponse>(); });
  config.out = folder_ / "n";
  try {
    run_scene(scene, config);
    FAIL() << "a force that is no number must not be borne";
  } catch (const SimulationFailed& failed) {
    EXPECT_EQ(failed.kind, FailureKind::not_finite) << failed.what();
    EXPECT_SAYS(std::string(failed.what()), "vertex 5 of cloth \"kite\" has no finite position");
  }
  const FailureBundle bundle = read_failure_bundle(config.out / "failure");
  EXPECT_EQ(bundle.kind, FailureKind::not_finite);
  Simulation simulation(scene, build_scene(scene), config.methods);
  StepRecording recording;
  simulation.set_trace(&recording.trace());
  const StepReplay replay = replay_step(simulation, scene, bundle);
  EXPECT_TRUE(replay.as_recorded) << replay.cause;
  const Explanation explanation = explain_step(scene, simulation, recording.last());
  ASSERT_EQ(explanation.culprits.size(), 1u);
  EXPECT_SAYS(explanation.culprits[0].sentence, "vertex 5 of cloth \"kite\" loses its position in");
  EXPECT_REFUSED(run("replay n"), "its scene was made in code");
}

// -- two runs
// -----------------------------------------------------------------------------------------

TEST_F(Replay, TwoRunsOfOneSceneAreTheSameToTheBit) {
  ASSERT_EQ(run_small("a", "--every-step --threads 1").code, 0);
  ASSERT_EQ(run_small("b", "--every-step --threads 2").code, 0);
  const Outcome o = run("replay a b");
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  EXPECT_SAYS(o.out, "the same to the bit: 7 steps");
}

TEST_F(Replay, TwoRunsDifferFromTheFirstStepAfterTheirBodies) {
  const std::string motion =
      "--every-step --set 'obstacles.ball.motion=[{\"time\":0},{\"time\":0.025},{\"time\":1,"
      "\"translation\":[";
  ASSERT_EQ(run_small("a", motion + "0,0,0]}]'").code, 0);
  ASSERT_EQ(run_small("b", motion + "0,0,0.1]}]'").code, 0);
  const Outcome o = run("replay a b --json");
  EXPECT_EQ(o.code, 1) << o.err;
  const Json found = Json::parse(o.out, nullptr, false);
  EXPECT_EQ(found["states"], "steps");
  EXPECT_EQ(found["first"]["number"], 4) << "steps of 1/120 s: the fourth ends after 0.025 s";
  EXPECT_EQ(found["compared"], 4);
}

TEST_F(Replay, OneVertexThatDiffersInOneStepIsNamed) {
  ASSERT_EQ(run_small("a", "--every-step").code, 0);
  fs::copy(folder_ / "a", folder_ / "b", fs::copy_options::recursive);
  const fs::path file = folder_ / "b/steps/cloth_000004.ply";
  std::vector<NamedValues> values;
  TriangleMesh mesh = read_ply(file, values);
  mesh.vertices[17].z() += 1e-12;
  write_ply(file, mesh.vertices, mesh.triangles, values);
  const Outcome o = run("replay a b");
  EXPECT_EQ(o.code, 1);
  EXPECT_SAYS(o.out, "they differ from step 4 on, first at vertex 17 of cloth \"cloth\"");
  const RunDifference d = find_difference(folder_ / "a", folder_ / "b");
  EXPECT_EQ(d.vertex, 17);
  EXPECT_EQ(d.vertices, 1);
  EXPECT_NEAR(d.distance, 1e-12, 1e-15);
}

TEST_F(Replay, ALongerRunIsTheSameAsFarAsTheShorterGoes) {
  ASSERT_EQ(run_small("a").code, 0);
  ASSERT_EQ(run_small("b", "--set time.frames=2").code, 0);
  const Outcome o = run("replay a b");
  EXPECT_EQ(o.code, 1);
  EXPECT_SAYS(o.out, "4 and 3 frames, of which 3 are the same");
  EXPECT_REFUSED(run("replay a nothing"), "holds no frames");
}

}  // namespace

}  // namespace selvedge::replay_test
