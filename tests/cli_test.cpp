// SPDX-License-Identifier: MIT
#include "run_program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

extern char** environ;

namespace selvedge::cli_test {

namespace {

using namespace selvedge::testing;

/// A program that is stopped by a signal.
class InterruptedProgram : public Program {
 protected:
  /// Starts a run of many frames, waits for `frames` of them, sends `signal` and waits for the end.
  int interrupt(const std::string& out, int frames, int signal) const {
    const pid_t child = start(out);
    int status = 0;
    if (!wait_for_frame(child, out, frames, status)) return status;
    kill(child, signal);
    waitpid(child, &status, 0);
    return status;
  }

  /// Starts a run of many frames.
  pid_t start(const std::string& out) const {
    const fs::path scene = folder_ / "small.json", target = folder_ / out;
    std::vector<std::string> words = {program, "run",  scene.string(), "--no-pictures",
                                      "--out", target, "--set",        "time.frames=90000"};
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO})
      posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_WRONLY, 0);
    pid_t child = 0;
    EXPECT_EQ(posix_spawn(&child, program.c_str(), &actions, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    return child;
  }

  /// False if the run ended before that frame, with `status`.
  bool wait_for_frame(pid_t child, const std::string& out, int frame, int& status) const {
    const fs::path awaited =
        folder_ / out / "frames" / ("cloth_0000" + std::to_string(frame) + ".ply");
    for (int wait = 0; wait < 6000 && !fs::exists(awaited); ++wait) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (waitpid(child, &status, WNOHANG) == child) return false;
    }
    return true;
  }
};

// -- what a run leaves --------------------------------------------------------------------------

TEST_F(Program, ARunEndsWithZeroAndLeavesFramesPictureAndResult) {
  const Outcome o = run("run small.json --out r");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(o.err, "") << "no progress bar in a pipe";
  EXPECT_SAYS(o.out, "clean        yes");
  EXPECT_EQ(count("r/frames", "cloth_"), 4u);
  EXPECT_EQ(count("r/frames", "bodies_"), 1u);
  EXPECT_TRUE(exists("r/pictures/frame_00003.png"));
  EXPECT_TRUE(exists("r/checkpoint.ply"));
  const Json r = result("r");
  EXPECT_EQ(r["clean"], true);
  EXPECT_EQ(r["frames"], 4);
  EXPECT_EQ(r["steps"], 6);
  EXPECT_EQ(r["stopped"], "");
  for (const char* key :
       {"wall_s", "phase_s", "worst_self_intersections", "worst_body_intersections",
        "max_penetration_m", "max_stretch", "final_max_speed", "peak_bytes", "state_hash"})
    EXPECT_TRUE(r.contains(key)) << key;
  EXPECT_GT(r["final_max_speed"].get<double>(), 0.0);
}

TEST_F(Program, InfoReportsTheGroupsAndAsksForTheUnitOfAMesh) {
  write("tetrahedron.obj",
        "v 0 0 0\nv 1700 0 0\nv 0 1700 0\nv 0 0 1700\no body\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
        "o hair\nv 0 0 2000\nv 0 9 2000\nv 9 0 2000\nf 5 6 7\n");
  const Outcome all = run("info tetrahedron.obj");
  EXPECT_EQ(all.code, 0) << all.err;
  EXPECT_SAYS(all.out, "open: 3 border edges");
  EXPECT_SAYS(all.out, "millimetres? Then the unit is 0.001 m");
  EXPECT_SAYS(all.out, "object   body: 4 triangles, closed");
  const Outcome body = run("info tetrahedron.obj --groups body --unit 0.001 --json");
  const Json j = Json::parse(body.out);
  EXPECT_EQ(j["closed"], true);
  EXPECT_NEAR(j["volume"].get<double>(), 1.7 * 1.7 * 1.7 / 6.0, 1e-12);
  EXPECT_TRUE(j["unit_question"].is_null());
  EXPECT_EQ(j["groups"].size(), 2u);
  EXPECT_REFUSED(run("info tetrahedron.obj --groups bdoy"), "it has 'body', 'hair'");
}

TEST_F(Program, TheJudgeFindsNothingInWhatWasWritten) {
  ASSERT_EQ(run_small("r", "--set time.frames=12").code, 0);
  const Outcome body = run("check r/frames/bodies_00000.ply --json");
  EXPECT_EQ(body.code, 0) << body.out;
  const Json ball = Json::parse(body.out, nullptr, false);
  EXPECT_EQ(ball["self_intersections"], 0) << "the body is not written as it is";
  EXPECT_EQ(ball["triangles"].get<int>(), 2 * ball["vertices"].get<int>() - 4)
      << "Euler: no sphere";
  const Outcome cloth =
      run("check r/frames/cloth_00012.ply --against r/frames/bodies_00000.ply --json");
  EXPECT_EQ(cloth.code, 0) << cloth.out;
}

TEST_F(Program, EveryPublishedSceneStarts) {
  for (const auto& entry : fs::directory_iterator(fs::path(SELVEDGE_SOURCE_DIR) / "data/scenes")) {
    const fs::path scene = entry.path();
    if (scene.extension() != ".json" || scene.filename() == "scene.schema.json") continue;
    const std::string text = content(scene);
    std::string coarse = " --set time.frames=1";
    // Numbers of vertices are those of the scene's own cells.
    const bool has_numbers = text.find("\"select\": [") != std::string::npos;
    if (text.find("\"cells\"") != std::string::npos && !has_numbers)
      coarse += " --set geometry.0.cells=[12,12]";
    if (text.find("\"upper\"") != std::string::npos)
      coarse += " --set geometry.upper.cells=[12,12]";
    if (text.find("\"lower\"") != std::string::npos)
      coarse += " --set geometry.lower.cells=[12,12]";
    const Outcome o =
        run("run '" + scene.string() + "' --no-pictures --out r_" + scene.stem().string() + coarse);
    if (o.err.find("fetch_bodies.sh") != std::string::npos) continue;
    EXPECT_EQ(o.code, 0) << scene << ": " << o.err;
  }
}

TEST_F(Program, ADetectorThatMayMissCollisionsIsNamedInTheVerdict) {
  EXPECT_SAYS(run_small("a", "--set contact.narrow_phase=ccd_root_parity").out,
              "clean        yes: no crossing in any frame; ccd_root_parity may miss collisions");
  EXPECT_SAYS(run_small("b", "--set contact.narrow_phase=ccd_inclusion").out,
              "clean        yes: nothing passed through anything");
  EXPECT_EQ(result("b")["unchecked"], "");
}

// Each scene lets a sheet pass through another one within a frame.
TEST_F(Program, TheVerdictNamesThePathsThatTheSceneLeavesUnchecked) {
  write("two.json", R"({
    "geometry": [{"name": "upper", "size": [0.3, 0.3], "cells": [4, 4], "velocity": [0, 0, -20],
                  "transformation": {"translation": [0.01, 0, 0.2]}},
                 {"name": "lower", "size": [0.3, 0.3], "cells": [4, 4]}],
    "time": {"frames": 3, "fps": 24}})");
  write("sheets.obj",
        "v -.2 -.2 0\nv .2 -.2 0\nv .2 .2 0\nv -.2 .2 0\nv -.15 -.13 .2\nv .13 -.13 .2\n"
        "v .13 .15 .2\nv -.15 .15 .2\nf 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n");
  write("one.json", R"({
    "geometry": [{"name": "sheets", "mesh": "sheets.obj"}],
    "handles": [{"name": "lower", "select": {"box": [[-1, -1, -0.1], [1, 1, 0.1]]}}],
    "time": {"frames": 1, "fps": 2}})");
  const std::string apart = R"('contact.pairs=[{"a": "upper", "b": "lower", "collide": false}]')";
  for (const auto& [scene, set, says] :
       {std::tuple("two", std::string("contact.self=false"), "against itself between frames"),
        std::tuple("two", apart, "1 of 3 pairs of surfaces were not checked between frames"),
        std::tuple("one", std::string("contact.self=false"), "against itself between frames")}) {
    const Outcome o = run(std::string("run ") + scene + ".json --no-pictures --overwrite --out " +
                          scene + " --set " + set);
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_SAYS(o.out, "clean        yes: no crossing in any frame; ");
    EXPECT_SAYS(o.out, says);
    EXPECT_SAYS(result(scene)["unchecked"].get<std::string>(), says);
    EXPECT_EQ(o.out.find("nothing passed"), std::string::npos) << o.out;
  }
}

TEST_F(Program, ARunSaysThatNoStepHadAnEnergyBalance) {
  const std::string says = "energy       not checked";
  EXPECT_EQ(run_small("a").out.find(says), std::string::npos);
  EXPECT_SAYS(run_small("b", "--set solver.integrator=implicit_kang").out, says);
  EXPECT_SAYS(run_small("c", "--set contact.response=penalty").out, says);
}

TEST_F(Program, JsonPrintsTheResult) {
  const Outcome o = run_small("r", "--json");
  EXPECT_EQ(Json::parse(o.out, nullptr, false), result("r"));
}

TEST_F(Program, ThreadsDoNotChangeABit) {
  ASSERT_EQ(run_small("one", "--threads 1").code, 0);
  ASSERT_EQ(run_small("two", "--threads 2").code, 0);
  EXPECT_EQ(result("one")["state_hash"], result("two")["state_hash"]);
  EXPECT_EQ(frame("one", 3), frame("two", 3));
}

TEST_F(Program, TakesTheNumberOfThreadsBeforeAndAfterTheCommand) {
  const std::string scene = (folder_ / "small.json").string();
  EXPECT_EQ(run("--threads 1 plan " + scene).code, 0);
  EXPECT_EQ(run("plan " + scene + " --threads 1").code, 0);
  EXPECT_REFUSED(run("plan " + scene + " --threads -1"), "--threads");
  EXPECT_REFUSED(run("plan " + scene + " --threads many"), "--threads");
}

TEST_F(Program, EveryStepWritesEveryAcceptedState) {
  ASSERT_EQ(run_small("r", "--every-step").code, 0);
  EXPECT_EQ(count("r/steps", "cloth_"), result("r")["steps"].get<std::size_t>() + 1);
  EXPECT_EQ(content(folder_ / "r/steps/cloth_000006.ply"), frame("r", 3));
}

TEST_F(Program, AMovingBodyIsWrittenWithEveryFrame) {
  ASSERT_EQ(
      run_small(
          "r",
          "--set 'obstacles.ball.motion=[{\"time\":0},{\"time\":1,\"translation\":[0.01,0,0]}]'")
          .code,
      0);
  EXPECT_EQ(count("r/frames", "bodies_"), 4u);
}

TEST_F(Program, SeriesForOtherProgramsAreWrittenOnRequest) {
  ASSERT_EQ(run_small("r", R"(--set 'output.formats=["vtk","pc2"]')").code, 0);
  EXPECT_EQ(count("r/frames", "cloth_"), 8u);
  for (const char* name : {"r/cloth.pvd", "r/bodies.pvd", "r/cloth.pc2", "r/cloth_base.ply"})
    EXPECT_TRUE(exists(name)) << name;
}

TEST_F(Program, AResumedRunCompletesASeriesThatItDidNotHaveBefore) {
  const std::string formats = "--set 'output.formats=[\"vtk\",\"obj\"]'";
  ASSERT_EQ(run_small("whole", formats).code, 0);
  ASSERT_EQ(run_small("parts", "--set time.frames=1").code, 0);
  ASSERT_EQ(run_small("parts", formats + " --resume").code, 0);
  for (const char* name :
       {"cloth.pvd", "bodies.pvd", "frames/cloth_00000.vtp", "frames/cloth_00003.vtp",
        "frames/bodies_00000.vtp", "frames/cloth_00001.obj", "frames/bodies_00000.obj"})
    EXPECT_EQ(content(folder_ / "whole" / name), content(folder_ / "parts" / name)) << name;
  EXPECT_EQ(count("whole/frames", ""), count("parts/frames", ""));
  EXPECT_TRUE(exists("whole/cloth.pvd"));
}

TEST_F(Program, HangsTheGridOfASceneByGeometryAlone) {
  // Two corners of a sheet of 1 m approach to 0.8 m: the middle of the side between them sags by
  // the catenary of length 1 and span 0.8, 0.265438 m.
  std::ofstream(folder_ / "hang.json") << R"({"geometry": [{"size": [1, 1], "cells": [20, 20]}],
    "handles": [{"select": [0], "motion": [{"time": 0}, {"time": 1, "translation": [0.1, 0, 0]}]},
                {"select": [20], "motion": [{"time": 0}, {"time": 1, "translation": [-0.1, 0, 0]}]}],
    "time": {"frames": 60, "fps": 60}})";
  const Outcome o = run("drape --geometric hang.json --most-sweeps 0 --json --out hung.obj");
  ASSERT_EQ(o.code, 0) << o.err;
  const Json j = Json::parse(o.out);
  EXPECT_EQ(j["curves"], 1);
  EXPECT_EQ(j["sweeps"], 0);
  std::ifstream in(folder_ / "hung.obj");
  std::vector<double> z;
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("v ")) z.push_back(std::stod(line.substr(line.rfind(' '))));
  ASSERT_EQ(z.size(), 441u);
  EXPECT_NEAR(z[10], -0.265438, 1e-5);
  EXPECT_EQ(z[0], 0.0);
  EXPECT_EQ(run("drape --geometric small.json").code, 2) << "no handles";
  EXPECT_EQ(run("drape --geometric hang.json --most-sweeps -1").code, 2);
}

TEST_F(Program, FindsTheSpringsOfANet) {
  const Outcome o = run(
      "identify --trial pulled --finite-elements 200,0.3333 --method nelder_mead --evaluations 6 "
      "--constants stretch_stiffness,shear_stiffness --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const Json found = Json::parse(o.out)["results"][0];
  EXPECT_TRUE(found["constants"].contains("shear_stiffness"));
  EXPECT_EQ(found["method"], "nelder_mead");
  EXPECT_SAYS(run("identify --trial hanging").err, "stretch, shear or bend");
  for (const char* sizes : {"0,2,4", "3,2", "3,2,5", "3,2000,4"})
    EXPECT_SAYS(run("identify --genetic " + std::string(sizes)).err, "an even number from 4");
  EXPECT_SAYS(run("identify --trial hanging --constants bend_length").err, "needs a target");
}

TEST_F(Program, AnUnknownFormatIsRefusedBeforeTheRun) {
  EXPECT_REFUSED(run_small("r", "--set 'output.formats=[\"ob\"]'"), "nearest is \"obj\"");
  EXPECT_FALSE(exists("r"));
}

TEST_F(Program, AShorterRunReplacesALongerOneOfTheSameScene) {
  ASSERT_EQ(run_small("r", "--set time.frames=5 --every-step").code, 0);
  ASSERT_EQ(run_small("r", "--overwrite --set time.frames=2").code, 0);
  EXPECT_EQ(count("r/frames", "cloth_"), 3u);
  EXPECT_EQ(count("r/steps", ""), 0u);
  EXPECT_EQ(result("r")["frames"], 3);
}

TEST_F(Program, TheSceneInTheResultRunsToTheSameBits) {
  ASSERT_EQ(run_small("a").code, 0);
  fs::create_directory(folder_ / "elsewhere");
  fs::copy(folder_ / "a/scene.json", folder_ / "elsewhere/copy.json");
  ASSERT_EQ(run("run elsewhere/copy.json --no-pictures --out b").code, 0);
  EXPECT_EQ(result("a")["state_hash"], result("b")["state_hash"]);
}

// -- a wrong command line -------------------------------------------------------------------------

TEST_F(Program, WithoutACommandItSaysWhichToType) {
  EXPECT_REFUSED(run(""), "give a command, such as `selvedge run`");
}

TEST_F(Program, AnUnknownCommandIsRefusedAndTheNearestNamed) {
  EXPECT_REFUSED(run("chekc r"), "did you mean `selvedge check`?");
  EXPECT_REFUSED(run("zzzzzzz"), "there is no command \"zzzzzzz\"; `selvedge --help`");
}

TEST_F(Program, AWrongOptionNamesTheCommandWhoseHelpExplainsIt) {
  EXPECT_REFUSED(run("run small.json --colour red"), "`selvedge run --help`");
  EXPECT_REFUSED(run("run small.json --budget -1"), "-1 must be a number above 0");
  EXPECT_REFUSED(run("run small.json --threads 5000"), "not in range 0 to 1024");
}

TEST_F(Program, EveryCommandDescribesItsOptions) {
  const Json commands = Json::parse(run("list --json").out)["commands"];
  ASSERT_FALSE(commands.empty());
  for (const Json& command : commands) {
    const std::string name = command["name"];
    const Outcome o = run(name + " --help");
    EXPECT_EQ(o.code, 0) << name;
    EXPECT_SAYS(o.out, "Usage: selvedge " + name);
  }
}

TEST_F(Program, ItsPageHasTheTableOfCommands) {
  const Json commands = Json::parse(run("list --json").out)["commands"];
  std::string table;
  for (const Json& command : commands)
    table += "| `" + command["name"].get<std::string>() + "` | " +
             command["purpose"].get<std::string>() + " |\n";
  const std::string page = content(fs::path(SELVEDGE_SOURCE_DIR) / "docs/program.md");
  EXPECT_NE(page.find("| --- | --- |\n" + table + "\n"), std::string::npos)
      << "docs/program.md must have these lines:\n"
      << table;
}

// -- stopping and going on ------------------------------------------------------------------------

TEST_F(Program, ResumingGoesOnToTheSameBits) {
  ASSERT_EQ(
      run_small("whole", "--set time.frames=8 --every-step --set 'output.formats=[\"pc2\"]'").code,
      0);
  ASSERT_EQ(
      run_small("parts", "--set time.frames=4 --every-step --set 'output.formats=[\"pc2\"]'").code,
      0);
  ASSERT_EQ(run_small("parts",
                      "--set time.frames=8 --every-step --set 'output.formats=[\"pc2\"]' --resume")
                .code,
            0);
  const Json whole = result("whole"), parts = result("parts");
  for (const char* key :
       {"state_hash", "frames", "steps", "clean", "max_stretch", "halvings", "final_max_speed"})
    EXPECT_EQ(whole[key], parts[key]) << key;
  EXPECT_EQ(frame("whole", 8), frame("parts", 8));
  EXPECT_EQ(content(folder_ / "whole/cloth.pc2"), content(folder_ / "parts/cloth.pc2"));
  EXPECT_EQ(count("whole/steps", ""), count("parts/steps", ""));
}

TEST_F(InterruptedProgram, CtrlCFinishesTheFrameAndTheRunCanGoOn) {
  const int status = interrupt("r", 2, SIGINT);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  const Json r = result("r");
  ASSERT_TRUE(r.is_object());
  EXPECT_SAYS(r["stopped"].get<std::string>(), "stopped on request");
  const int frames = r["frames"].get<int>();
  EXPECT_EQ(count("r/frames", "cloth_"), static_cast<std::size_t>(frames));
  const std::string length = "--set time.frames=" + std::to_string(frames + 1);
  ASSERT_EQ(run_small("r", length + " --resume").code, 0);
  ASSERT_EQ(run_small("whole", length).code, 0);
  EXPECT_EQ(result("r")["state_hash"], result("whole")["state_hash"]);
}

TEST_F(InterruptedProgram, AKilledRunGoesOnToTheSameBits) {
  const int status = interrupt("r", 2, SIGKILL);
  ASSERT_TRUE(WIFSIGNALED(status));
  const int done = Json::parse(content(folder_ / "r/checkpoint.json"))["frame"].get<int>();
  const std::string length = "--set time.frames=" + std::to_string(done + 2);
  ASSERT_EQ(run_small("r", length + " --resume").code, 0);
  EXPECT_EQ(count("r/frames", "cloth_"), static_cast<std::size_t>(done + 3)) << "from frame 0";
  ASSERT_EQ(run_small("whole", length).code, 0);
  EXPECT_EQ(result("r")["state_hash"], result("whole")["state_hash"]);
}

TEST_F(InterruptedProgram, ASecondRunIntoAFolderInUseIsRefused) {
  const pid_t first = start("r");
  int status = 0;
  ASSERT_TRUE(wait_for_frame(first, "r", 2, status)) << status;
  const std::string number = std::to_string(first);
  EXPECT_REFUSED(run_small("r"), "another run (process " + number + ") is at work in this folder");
  EXPECT_REFUSED(run_small("r", "--resume"), "is at work in this folder");
  EXPECT_TRUE(fs::exists(folder_ / "r/frames/cloth_00002.ply")) << "removed by the second run";
  EXPECT_EQ(waitpid(first, &status, WNOHANG), 0) << "the first run ended";
  kill(first, SIGKILL);
  waitpid(first, &status, 0);
  EXPECT_TRUE(exists("r/lock")) << "a killed run removes nothing";
  EXPECT_EQ(run_small("r", "--resume --set time.frames=9").code, 0);
  EXPECT_EQ(run_small("r", "--overwrite").code, 0);
  EXPECT_FALSE(exists("r/lock"));
}

TEST_F(InterruptedProgram, ARunKilledBeforeItWroteAnythingLeavesItsFolderUsable) {
  fs::create_directories(folder_ / "r");
  write("r/lock", "1\n");
  EXPECT_EQ(run_small("r").code, 0);
}

TEST_F(Program, AKillBetweenTheTwoCheckpointFilesLosesNothing) {
  ASSERT_EQ(run_small("r").code, 0);
  const std::string early = content(folder_ / "r/checkpoint.json");
  ASSERT_EQ(run_small("r", "--set time.frames=4 --resume").code, 0);
  std::ofstream(folder_ / "r/checkpoint.json") << early;  // checkpoint.ply is a frame ahead
  ASSERT_EQ(run_small("r", "--set time.frames=6 --resume").code, 0);
  ASSERT_EQ(run_small("whole", "--set time.frames=6").code, 0);
  EXPECT_EQ(result("r")["state_hash"], result("whole")["state_hash"]);
}

TEST_F(Program, ResumingWhatIsNotThereOrDiffersIsRefused) {
  EXPECT_REFUSED(run_small("none", "--resume"), "there is no checkpoint");
  ASSERT_EQ(run_small("r").code, 0);
  EXPECT_REFUSED(run_small("r", "--resume --set contact.rest_gap=0.001"), "differs from the scene");
  Json checkpoint = Json::parse(content(folder_ / "r/checkpoint.json"));
  checkpoint["control"]["span"] = 1000000;  // steps that are taken as one
  std::ofstream(folder_ / "r/checkpoint.json") << checkpoint;
  EXPECT_REFUSED(run_small("r", "--resume --set time.frames=4"), "is damaged");
  std::ofstream(folder_ / "r/checkpoint.json") << "{\"frame\": 2}";
  EXPECT_REFUSED(run_small("r", "--resume"), "is damaged");
}

TEST_F(Program, AResumedRunFallsAsleepAtTheSameTime) {
  const std::string set = "--set gravity=[0,0,0] --set time.sleep_speed=0.1 --set time.frames=";
  ASSERT_EQ(run_small("part", set + "20").code, 0);
  EXPECT_FALSE(result("part")["counters"].contains("steps_asleep"));
  ASSERT_EQ(run_small("part", set + "40 --resume").code, 0);
  ASSERT_EQ(run_small("whole", set + "40").code, 0);
  EXPECT_EQ(result("whole")["counters"]["steps_asleep"], 20);  // of the last 10 frames
  EXPECT_EQ(result("part")["counters"]["steps_asleep"], 20);
  EXPECT_EQ(result("part")["state_hash"], result("whole")["state_hash"]);
}

TEST_F(Program, NoStatesAreWrittenWhileTheClothSleeps) {
  const std::string set = "--every-step --set time.frames=60 --set time.sleep_speed=";
  ASSERT_EQ(run_small("asleep", set + "1").code, 0);
  ASSERT_EQ(run_small("awake", set + "0").code, 0);
  EXPECT_GT(result("asleep")["counters"]["steps_asleep"], 0);
  const auto steps = result("asleep")["steps"].get<std::size_t>();
  EXPECT_EQ(count("asleep/steps", "cloth_"), steps + 1);
  std::string number = std::to_string(steps);
  number.insert(0, 6 - number.size(), '0');
  const fs::path last = "steps/cloth_" + number + ".ply";
  EXPECT_TRUE(content(folder_ / "asleep" / last) == content(folder_ / "awake" / last)) << last;
}

/// Rewrites a result folder as version 0.1 would have left it: other keys, and a scene that is
/// completed with the options of all methods.
void age_result(const fs::path& folder, double stiffness) {
  Json scene = Json::parse(content(folder / "scene.json"));
  Json& contact = scene["contact"];
  contact["thickness"] = contact["rest_gap"];
  contact.erase("rest_gap");
  contact.update({{"stiffness", stiffness},
                  {"damping", 0.1},
                  {"restitution", 0.0},
                  {"retention", 0.9},
                  {"slip_speed", 1e-4},
                  {"sticking", false}});
  scene["solver"].update({{"error", 1e-5}, {"drag", 0.5}, {"max_newton", 20}});
  std::ofstream(folder / "scene.json") << scene;
  Json checkpoint = Json::parse(content(folder / "checkpoint.json"));
  Json& counters = checkpoint["result"]["counters"];
  counters["max_gap_lack_m"] = counters.at("max_gap_violation_m");
  counters.erase("max_gap_violation_m");
  checkpoint["control"].erase("span");
  checkpoint.erase("acceleration");
  checkpoint.erase("still");
  std::ofstream(folder / "checkpoint.json") << checkpoint;
}

TEST_F(Program, AResultOfTheFirstVersionIsResumedAndMeasured) {
  for (const std::string response : {"contact_force", "penalty"}) {
    const std::string part = "part_" + response, whole = "whole_" + response,
                      set = "--set contact.response=" + response + " --set time.frames=";
    ASSERT_EQ(run_small(part, set + "2").code, 0);
    age_result(folder_ / part, 1000.0);
    EXPECT_EQ(run("measure " + part + " --no-pictures").code, 0);
    const Outcome resumed = run_small(part, set + "4 --resume");
    ASSERT_EQ(resumed.code, 0) << resumed.err;
    ASSERT_EQ(run_small(whole, set + "4").code, 0);
    EXPECT_EQ(result(part)["state_hash"], result(whole)["state_hash"]);
    EXPECT_EQ(result(part)["counters"]["max_gap_violation_m"],
              result(whole)["counters"]["max_gap_violation_m"]);
  }
}

TEST_F(Program, AFirstVersionResultWithAnotherOptionValueIsRefused) {
  ASSERT_EQ(run_small("r", "--set contact.response=penalty").code, 0);
  age_result(folder_ / "r", 2000.0);
  EXPECT_REFUSED(run_small("r", "--set contact.response=penalty --resume"),
                 "differs from the scene");
}

TEST_F(Program, ASceneIsResumedHoweverItsFileGivesTheOptions) {
  ASSERT_EQ(run_small("r", "--set time.frames=2").code, 0);
  EXPECT_EQ(run_small("r", "--set solver.strain_limiter=true --resume").code, 0);
  EXPECT_REFUSED(run_small("r", "--set solver.strain_limiter=false --resume"),
                 "differs from the scene");
  const std::string two_layers = "--set 'geometry.0.cells=[8,8]' --set ";
  ASSERT_EQ(run_small("layers", two_layers + "geometry.0.pattern=bilayered").code, 0);
  const auto resume = [&](const std::string& ratio) {
    return run_small(
        "layers", two_layers + "'geometry.0.pattern={\"type\": \"bilayered\", \"ratio\": " + ratio +
                      "}' --resume");
  };
  EXPECT_EQ(resume("4").code, 0);
  EXPECT_REFUSED(resume("2"), "differs from the scene");
}

// -- the result folder
// ------------------------------------------------------------------------------

TEST_F(Program, AFolderWithOtherThingsIsRefusedAndLeftAlone) {
  fs::create_directory(folder_ / "mine");
  write("mine/letter.txt", "dear");
  EXPECT_REFUSED(run_small("mine"), "holds files but no selvedge run");
  EXPECT_EQ(count("mine", ""), 1u);
  ASSERT_EQ(run_small("r").code, 0);
  EXPECT_REFUSED(run_small("r", "--set name=other"), "holds results of the scene \"small\"");
  EXPECT_EQ(result("r")["frames"], 4);
}

TEST_F(Program, AFolderThatCannotBeMadeIsRefused) {
  write("file", "");
  EXPECT_REFUSED(run_small("file"), "is a file, not a folder");
  EXPECT_REFUSED(run_small("file/r"), "cannot be");
  const std::string too_long(300, 'x');  // for a name: root cannot make it either
  EXPECT_REFUSED(run_small(too_long), "the result folder cannot be made");
}

TEST_F(Program, AFolderWithoutPermissionIsRefused) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::create_directory(folder_ / "locked");
  fs::permissions(folder_ / "locked", fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_REFUSED(run_small("locked"), "cannot be written");
  EXPECT_REFUSED(run_small("locked/r"), "cannot be made");
  fs::permissions(folder_ / "locked", fs::perms::owner_all);
}

TEST_F(Program, AFullDiskEndsTheRunWithOneAndKeepsTheFrames) {
  // A limit on the size of a file stands for the disk: the point cache is the file that grows.
  // Its checkpoints are small: this integrator has no memory.
  const std::string set = "--set solver.integrator=implicit_euler ";
  const Outcome o = run_small("r", set + "--set 'output.formats=[\"pc2\"]' --set time.frames=60",
                              "ulimit -f 20 &&");
  EXPECT_EQ(o.code, 1) << o.out;
  EXPECT_SAYS(o.err, "cloth.pc2");
  const Json r = result("r");
  ASSERT_TRUE(r.is_object());
  EXPECT_SAYS(r["stopped"].get<std::string>(), "cloth.pc2");
  EXPECT_GE(r["frames"].get<int>(), 5);
  ASSERT_EQ(run_small("r", set + "--resume --set time.frames=20").code, 0);
  EXPECT_EQ(result("r")["frames"], 21);
}

TEST_F(Program, NoSpaceForTheCheckpointIsSaidInASentence) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  ASSERT_EQ(run_small("r").code, 0);
  fs::remove(folder_ / "r/checkpoint.json");
  fs::create_symlink("/dev/full", folder_ / "r/checkpoint.json");
  const Outcome o = run_small("r", "--overwrite");
  EXPECT_EQ(o.code, 1) << o.err;
  EXPECT_SAYS(o.err, "No space left on device");
  EXPECT_SAYS(result("r")["stopped"].get<std::string>(), "No space left on device");
  EXPECT_EQ(count("r/frames", "cloth_00000.ply"), 1u);
}

TEST_F(Program, PrintingToAFullDiskEndsWithOne) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  const std::string command =
      "'" + program + "' list >/dev/full 2>'" + (folder_ / "err").string() + "'";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_SAYS(content(folder_ / "err"), "could not be written");
}

// -- wrong input
// ------------------------------------------------------------------------------------

TEST_F(Program, WrongScenesAreRefusedBeforeAnythingIsWritten) {
  write("empty.json", "");
  write("cut.json", R"({"geometry": [{"name": )");
  EXPECT_REFUSED(run("run none.json --out r"), "no such file");
  EXPECT_REFUSED(run("run empty.json --out r"), "the file is empty");
  EXPECT_REFUSED(run("run cut.json --out r"), "not valid JSON");
  EXPECT_REFUSED(run("run . --out r"), "is a folder");
  EXPECT_REFUSED(run_small("r", "--set materials.default.density=-0.2"),
                 "materials.default.density: must be at least");
  EXPECT_REFUSED(run_small("r", "--set materials.default.stretch_stiffness=-500"),
                 "must be at least");
  EXPECT_REFUSED(run_small("r", "--set contact.rest_gap=0"), "contact.rest_gap: must be at least");
  EXPECT_REFUSED(run_small("r", "--set gravity=[0,0,nan]"), "gravity");
  EXPECT_REFUSED(run_small("r", "--set contakt.rest_gap=1"), "nearest is \"contact\"");
  EXPECT_REFUSED(run_small("r", "--set 'handles=[{\"select\":{\"vertices\":[100]}}]'"),
                 "there is no vertex 100");
  EXPECT_REFUSED(run_small("r", "--set nonsense"), "must be path=value");
  EXPECT_FALSE(exists("r"));
}

TEST_F(Program, WrongMeshesAreRefused) {
  const std::string head =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\nproperty double "
      "y\nproperty double z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  write("cut.ply", head + std::string(40, '\0'));
  write("nan.off", "OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n");
  write("infinite.off", "OFF\n3 1 0\n0 0 0\n1 0 1e999\n0 1 0\n3 0 1 2\n");
  write("index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n");
  write("empty.obj", "");
  for (const char* name : {"cut.ply", "nan.off", "infinite.off", "index.off", "empty.obj"}) {
    const std::string mesh = std::string("'[{\"mesh\":\"") + name + "\"}]'";
    EXPECT_REFUSED(run_small("r", "--set obstacles=" + mesh), name);
    EXPECT_REFUSED(run_small("r", "--set geometry=" + mesh), name);
  }
  EXPECT_REFUSED(run_small("r", "--set 'obstacles=[{\"mesh\":\"none.obj\"}]'"), "there is no file");
  EXPECT_FALSE(exists("r"));
}

TEST_F(Program, ClothThatCrossesABodyAtTheStartIsRefused) {
  const Outcome o = run_small("r", "--set geometry.0.transformation.translation=[0,0,0.2]");
  EXPECT_REFUSED(o, "cross");
  EXPECT_NE(o.err.find_first_of("0123456789"), std::string::npos) << o.err;
  EXPECT_FALSE(exists("r/frames/cloth_00000.ply"));
}

// A cube of the given side around the origin, and how to turn or open it.
std::string cube(double side, bool reversed, bool open, const std::string& name = "box") {
  const int faces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                            {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  std::string vertices, triangles;
  const auto number = [&](int corner, int bit) {
    return std::to_string((corner & bit) != 0 ? 0.5 * side : -0.5 * side);
  };
  for (int c = 0; c < 8; ++c)
    vertices +=
        (c == 0 ? "[" : ",[") + number(c, 1) + "," + number(c, 2) + "," + number(c, 4) + "]";
  for (int f = open ? 1 : 0; f < 12; ++f) {
    const int *t = faces[f], b = reversed ? 2 : 1, c = reversed ? 1 : 2;
    triangles += (triangles.empty() ? "[" : ",[") + std::to_string(t[0]) + "," +
                 std::to_string(t[b]) + "," + std::to_string(t[c]) + "]";
  }
  return "{\"name\": \"" + name + R"(", "mesh": {"vertices": [)" + vertices +
         R"(], "triangles": [)" + triangles + "]}";
}

// `run` and `check` have the same notion of inside, whichever way a closed body is turned.
TEST_F(Program, ClothInsideAClosedBodyOnlyIsRefused) {
  const std::string up = R"(, "motion": [{"time": 0}, {"time": 1, "translation": [0, 0, 0.1]}]})";
  const struct {
    const char* name;
    std::string bodies;
    bool refused;
  } cases[] = {
      {"closed", cube(1, false, false) + "}", true},
      {"reversed", cube(1, true, false) + "}", true},
      {"moving", cube(1, false, false) + up, true},
      {"open", cube(1, false, true) + "}", false},
      {"room", cube(1, true, false) + "}," + cube(1.2, false, false, "shell") + "}", false},
      {"sphere", R"({"name": "box", "shape": {"type": "sphere", "radius": 0.4}})", true}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    write("in.json", R"({"gravity": [0, 0, 0], "geometry": [{"name": "flag", "size": [0.2, 0.2],
      "cells": [4, 4]}], "time": {"frames": 1}, "obstacles": [)" +
                         c.bodies + "]}");
    const std::string out = std::string("r_") + c.name;
    const Outcome o = run("run in.json --no-pictures --out " + out);
    if (c.refused) {
      EXPECT_EQ(o.code, 2) << o.out;
      EXPECT_SAYS(o.err, "vertex 0 of cloth \"flag\"");
      EXPECT_SAYS(o.err, "inside a closed body, body \"box\"");
      EXPECT_FALSE(exists(out));
      continue;
    }
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_EQ(run("check " + out).code, 0) << "run says that it is clean";
  }
}

TEST_F(Program, ClothThatCrossesItselfAtTheStartIsRefused) {
  write("two.json", R"({"geometry": [
    {"cells": [4, 4]}, {"cells": [4, 4], "transformation": {"rotation": {"axis": [1, 0.3, 0], "angle_deg": 60}}}]})");
  EXPECT_REFUSED(run("run two.json --out r"), "cross");
}

TEST_F(Program, AFailedStartLeavesAnEarlierResultAsItIs) {
  ASSERT_EQ(run_small("r").code, 0);
  const std::string before = content(folder_ / "r/result.json");
  EXPECT_REFUSED(
      run_small("r", "--overwrite --set geometry.0.transformation.translation=[0,0,0.2]"), "cross");
  EXPECT_EQ(content(folder_ / "r/result.json"), before);
  EXPECT_EQ(count("r/frames", "cloth_"), 4u);
}

TEST_F(Program, AnOpenBodyIsWarnedOfAndTheRunGoesOn) {
  write("sheet.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n");
  const Outcome o =
      run_small("r", "--set 'obstacles=[{\"name\":\"sheet\",\"mesh\":\"sheet.obj\"}]'");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_SAYS(o.err, "warning: obstacles[0] (\"sheet\")");
}

TEST_F(Program, WrongCommandLinesAreRefused) {
  for (const char* arguments :
       {"", "simulate", "run", "run small.json --thread 1", "run small.json --threads -1"}) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.code, 2) << arguments;
    EXPECT_NE(o.err, "") << arguments;
  }
  EXPECT_EQ(run("--help").code, 0);
  EXPECT_SAYS(run("run --help").out, "--resume");
}

TEST_F(Program, VersionNamesTheLicenceAndTheLibraries) {
  const Outcome o = run("--version");
  EXPECT_EQ(o.code, 0);
  EXPECT_SAYS(o.out, "\n  Eigen 3.");
  EXPECT_SAYS(o.out, "(MPL-2.0)");
  // Only CGAL takes the program from MIT to the GPL.
  const bool has_cgal = o.out.find("\n  CGAL ") != std::string::npos;
  EXPECT_SAYS(o.out, has_cgal ? "\nlicence: GPL-3.0-or-later" : "\nlicence: MIT\n");
  const Json methods = Json::parse(run("list --json").out, nullptr, false)["methods"];
  for (const Json& method : methods)
    if (method["name"] == "cgal_box_intersection") {
      EXPECT_EQ(method["available"].get<bool>(), has_cgal);
    }
}

TEST_F(Program, ListNamesEveryMethodWithItsGuarantee) {
  const Outcome o = run("list --json");
  EXPECT_EQ(o.code, 0);
  const Json methods = Json::parse(o.out, nullptr, false)["methods"];
  const auto guarantee = [&](const std::string& name) {
    for (const Json& method : methods)
      if (method["name"] == name) return method["guarantee"].get<std::string>();
    return std::string();
  };
  EXPECT_SAYS(guarantee("bvh_aabb"), "misses nothing");
  EXPECT_SAYS(guarantee("ccd_exact"), "misses nothing, no false alarm");
  EXPECT_SAYS(run("list").out, "implicit_euler");
}

}  // namespace

}  // namespace selvedge::cli_test
