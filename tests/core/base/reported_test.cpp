// SPDX-License-Identifier: MIT
//
// Inputs that once showed a fault, and their kin: each behaves as a user would expect.
#include <selvedge/core/base/internal/text.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "run_program.h"

namespace selvedge::testing::reported_test {
namespace {

using Reported = Program;

std::string scene_with(const std::string& more) {
  return R"({"geometry": [{"size": [0.5, 0.5], "cells": [5, 5],
             "transformation": {"translation": [0, 0, 0.6]}}], "time": {"frames": 2}, )" +
         more + "}";
}

/// A square pyramid of four faces without its base.
std::string obj_file(double height) {
  return "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 " + std::to_string(height) +
         "\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
}

// -- files that must stay -------------------------------------------------------------------------

TEST_F(Reported, AnOutputFileDoesNotReplaceAFileOfAnotherKind) {
  ASSERT_EQ(run_small("r").code, 0);
  const std::string scene = content(folder_ / "r/scene.json");
  EXPECT_REFUSED(run("view r --out r/scene.json"), "r/scene.json: holds something else than");
  EXPECT_REFUSED(run("view r --out r/frames/cloth_00000.ply"), "than an HTML page");
  EXPECT_EQ(content(folder_ / "r/scene.json"), scene);
  EXPECT_REFUSED(run("stability small.json --map small.json --stiffness 1,2"),
                 "than an SVG picture");
  EXPECT_EQ(run("view r --out page.html").code, 0);
  EXPECT_EQ(run("view r --out page.html").code, 0);
}

TEST_F(Reported, ARunDoesNotWriteThroughLinksInItsFolder) {
  for (const std::string part : {"frames", "steps", "pictures", "measures", "failure"}) {
    fs::remove_all(folder_ / "r");
    ASSERT_EQ(run_small("r").code, 0);
    fs::create_directories(folder_ / "elsewhere");
    write("elsewhere/cloth_00000.ply", "mine");
    fs::remove_all(folder_ / "r" / part);
    fs::create_directory_symlink(folder_ / "elsewhere", folder_ / "r" / part);
    for (const std::string more : {"--overwrite", "--overwrite --every-step", "--resume"})
      EXPECT_REFUSED(run_small("r", more), "r/" + part + ": is a link");
    EXPECT_EQ(content(folder_ / "elsewhere/cloth_00000.ply"), "mine");
  }
  fs::create_directory_symlink(folder_ / "elsewhere2", folder_ / "whole");
  fs::create_directories(folder_ / "elsewhere2");
  EXPECT_EQ(run_small("whole").code, 0);
}

// -- sizes ----------------------------------------------------------------------------------------

TEST_F(Reported, ARestGapOfManyCellsIsRefusedWithOneThatWorks) {
  write("tiny.json", R"({"geometry": [{"name": "c", "size": [0.001, 0.001], "cells": [40, 40]}],
                         "time": {"frames": 1}})");
  const std::string command = "run tiny.json --no-pictures --out t";
  EXPECT_REFUSED(run(command, "timeout 20"), "use a rest gap of at most ");
  const std::string mark = "at most ", sentence = run(command).err;
  const auto at = sentence.find(mark) + mark.size();
  const std::string gap = sentence.substr(at, sentence.find(' ', at) - at);
  EXPECT_EQ(run("run tiny.json --no-pictures --out t --set contact.rest_gap=" + gap).code, 0);
  // Without contacts of the cloth with itself, its cells do not matter.
  EXPECT_EQ(run("run tiny.json --no-pictures --out u --set contact.self=false").code, 0);
}

TEST_F(Reported, VerticesOfASequenceThatChangePlacesAreSaid) {
  write("b_00.obj", obj_file(0.5));
  write("b_01.obj",
        "v 0 1 0\nv 0.5 0.5 0.5\nv 0 0 0\nv 1 0 0\nv 1 1 0\n"
        "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
  write("leap.json", scene_with(R"("obstacles": [{"sequence": {"files": "b_##.obj", "fps": 1}}])"));
  const Outcome outcome = run("run leap.json --no-pictures --out l");
  EXPECT_SAYS(outcome.err, "b_01.obj the vertices change places");
  write("b_01.obj", obj_file(0.6));
  EXPECT_EQ(run("run leap.json --no-pictures --out m").err.find("places"), std::string::npos);
}

// -- words ----------------------------------------------------------------------------------------

TEST_F(Reported, CountsOfOneAreSingular) {
  write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_SAYS(run("sequence one.obj --out s").out, "1 frame of 3 vertices and 1 triangle in");
  EXPECT_SAYS(run("check one.obj").out, "3 vertices, 1 triangle\n");
  EXPECT_SAYS(run("view one.obj --out one.html").out, "1 frame,");
}

TEST_F(Reported, AMeshFileInAnObjectIsAskedForByName) {
  write("wrapped.json", scene_with(R"("obstacles": [{"mesh": {"file": "ball.obj"}}])"));
  EXPECT_REFUSED(run("run wrapped.json"),
                 "obstacles[0].mesh: must be a string, such as \"mesh\": \"ball.obj\"");
  write("wrapped.json", R"({"geometry": [{"mesh": {"path": "c.obj"}}]})");
  EXPECT_REFUSED(run("run wrapped.json"), "such as \"mesh\": \"c.obj\"");
}

TEST_F(Reported, AControlCharacterIsShownOnce) {
  write("c.json", scene_with("\"name\": \"c\\u001b\""));
  EXPECT_REFUSED(run("run c.json"), "is \"c\\x1b\"");
}

TEST_F(Reported, TheCommandOfACellSetsEachValueOnce) {
  ASSERT_EQ(
      run("compare small.json --vary dt=0.01,0.02 --set time.frames=1 --set "
          "time.steps_per_frame=7 --set time.frames=2 --no-reference --repeats 1 --no-pictures "
          "--out c")
          .code,
      0);
  const std::string command = run("advise c").out;
  for (const std::string path : {"time.steps_per_frame=", "time.frames="}) {
    const auto first = command.find(path);
    ASSERT_NE(first, std::string::npos) << command;
    EXPECT_EQ(command.find(path, first + 1), std::string::npos) << command;
  }
  EXPECT_SAYS(command, "time.frames=2");
}

// -- names ----------------------------------------------------------------------------------------

TEST_F(Reported, ANameThatLeavesTheResultFolderIsRefused) {
  for (const std::string name : {"../../evil", "/tmp/evil", "..", ".", "a/b"}) {
    write("name.json", scene_with("\"name\": \"" + name + "\""));
    EXPECT_REFUSED(run("run name.json --no-pictures"), "cannot be the name of a folder");
    EXPECT_REFUSED(run("compare name.json --vary dt=0.01"), "cannot be the name of a folder");
  }
  EXPECT_FALSE(exists("out"));
  EXPECT_FALSE(fs::exists("/tmp/evil"));
}

TEST_F(Reported, ControlCharactersOfASceneNeverReachTheTerminal) {
  const std::string escape = "\\u001b]0;owned\\u0007";
  for (const std::string& more : std::vector<std::string>{
           "\"name\": \"" + escape + "\"", "\"materials\": {\"" + escape + "\": {}}",
           "\"obstacles\": [{\"name\": \"a\\u0085b\", \"shape\": {\"type\": \"plane\"}}]",
           "\"obstacles\": [{\"mesh\": \"" + escape + ".obj\"}]"}) {
    write("control.json", scene_with(more));
    const Outcome outcome = run("run control.json --no-pictures");
    EXPECT_REFUSED(outcome, "control character");
    EXPECT_EQ(outcome.err.find('\x1b'), std::string::npos);
    EXPECT_EQ(outcome.err.find("\xc2\x85"), std::string::npos);
  }
}

TEST_F(Reported, NamesOfFilesAndGroupsReachTheTerminalWithoutEscapes) {
  const std::string escape = "\x1b[31mred\x07", c1 = "\xc2\x9b";
  const std::string name = "a" + escape + c1 + "b";
  write("group.obj", obj_file(0.5).insert(obj_file(0.5).find("f "), "g " + name + "\n"));
  write(name + ".json", content(folder_ / "small.json"));
  write(name + ".obj", obj_file(0.5));
  write("broken.json", R"({"geometry": [{}], "obstacles": [{"mesh": "none.obj"}])");
  const std::string quoted = "'" + name + "'";
  for (const std::string& arguments :
       std::vector<std::string>{"info group.obj",
                                "info group.obj --json",
                                "info '" + name + ".obj'",
                                "info '" + name + ".obj' --json",
                                "info group.obj --groups " + quoted,
                                "info group.obj --groups nothing",
                                "info " + quoted,
                                "check '" + name + ".obj'",
                                "check '" + name + ".obj' --json",
                                "run '" + name + ".json' --no-pictures --out " + quoted,
                                "run '" + name + ".json' --resume --out " + quoted,
                                "plan '" + name + ".json'",
                                "view " + quoted,
                                "measure " + quoted,
                                "render " + quoted,
                                "check " + quoted,
                                "compare '" + name + ".json' --vary " + quoted,
                                "run small.json --set " + quoted + "=1",
                                "sequence '" + name + ".obj' --out s" + quoted,
                                "list " + quoted,
                                quoted,
                                "run small.json --" + name,
                                "fabric " + quoted,
                                "stability " + quoted,
                                "replay " + quoted,
                                "ccd " + quoted,
                                "detect --a0 " + quoted + " --a1 " + quoted}) {
    const Outcome outcome = run(arguments);
    for (const std::string& text : {outcome.out, outcome.err}) {
      EXPECT_EQ(text.find('\x1b'), std::string::npos) << arguments << ": " << printable(text);
      EXPECT_EQ(text.find('\x07'), std::string::npos) << arguments << ": " << printable(text);
      EXPECT_EQ(text.find(c1), std::string::npos) << arguments << ": " << printable(text);
    }
  }
  const Json info = Json::parse(run("info group.obj --json").out);
  EXPECT_EQ(info["groups"][0]["name"], name);
}

TEST_F(Reported, CommandsThatAreNamedCanBePasted) {
  write("a b;$(touch owned).json", content(folder_ / "small.json"));
  const std::string scene = "'a b;$(touch owned).json'";
  const Outcome compared = run("compare " + scene +
                               " --vary dt=0.01 --set time.frames=1 --no-reference --repeats 1 "
                               "--no-pictures --out c");
  ASSERT_EQ(compared.code, 0) << compared.err;
  const Outcome advised = run("advise c");
  ASSERT_EQ(advised.code, 0) << advised.err;
  const auto begin = advised.out.find("selvedge run ");
  ASSERT_NE(begin, std::string::npos) << advised.out;
  std::string command = advised.out.substr(begin, advised.out.find('\n', begin) - begin);
  command.replace(0, std::string("selvedge").size(), "'" + program + "'");
  command =
      "cd '" + folder_.string() + "' && " + command + " --no-pictures --out pasted >said 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << command << content(folder_ / "said");
  EXPECT_FALSE(exists("owned"));
  EXPECT_EQ(result("pasted")["frames"], 2);
}

// -- files ----------------------------------------------------------------------------------------

TEST_F(Reported, ASequenceWithAGapIsRefused) {
  for (const char* name : {"b_00.obj", "b_01.obj", "b_03.obj", "other_07.obj", "b_x.obj"})
    write(name, obj_file(0.2));
  write("gap.json", scene_with(R"("obstacles": [{"sequence": {"files": "b_##.obj"}}])"));
  EXPECT_REFUSED(run("run gap.json --no-pictures --out r"),
                 "number 2 is missing although b_03.obj exists");
  EXPECT_FALSE(exists("r"));
  fs::remove(folder_ / "b_03.obj");
  EXPECT_EQ(run("run gap.json --no-pictures --out r").code, 0);
}

TEST_F(Reported, AByteOrderMarkIsSkippedInEveryMeshFile) {
  const std::string mark = "\xEF\xBB\xBF";
  write("bom.obj", mark + obj_file(0.2));
  write("bom.off", mark + "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  write("bom.ply", mark +
                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\n"
                       "property double y\nproperty double z\nelement face 1\n"
                       "property list uchar int vertex_indices\nend_header\n"
                       "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  for (const char* name : {"bom.obj", "bom.off", "bom.ply"}) {
    const Outcome outcome = run(std::string("check ") + name);
    EXPECT_EQ(outcome.err, "") << name;
    EXPECT_NE(outcome.code, 2) << name;
  }
}

#ifdef __SANITIZE_ADDRESS__  // it reserves terabytes, and its builds take many times as long
constexpr const char *kLessMemory = "", *kFewSeconds = "ulimit -t 200;";
#else
constexpr const char *kLessMemory = "ulimit -v 1000000;", *kFewSeconds = "ulimit -t 10;";
#endif

TEST_F(Reported, AMeshWhoseHeaderPromisesTooMuchIsRefusedAtOnce) {
  const std::string header("glTF\x02\0\0\0\0\x28\x6b\xee\0\x28\x6b\xeeJSON", 20);
  write("trunc.glb", header);
  const auto begin = std::chrono::steady_clock::now();
  const Outcome outcome = run("check trunc.glb", kLessMemory);
  EXPECT_REFUSED(outcome, "trunc.glb");
  EXPECT_SAYS(outcome.err, "it is cut short");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

TEST_F(Reported, APolygonOfThousandsOfCornersIsRefusedAtOnce) {
  std::string text, face = "f";
  for (int i = 0; i < 20'000; ++i) {
    text += "v " + std::to_string(i) + " " + std::to_string(i * i % 17) + " 0\n";
    face += " " + std::to_string(i + 1);
  }
  write("face.obj", text + face + "\n");
  EXPECT_REFUSED(run("check face.obj"), "triangles meet at vertex 0");
}

// -- numbers --------------------------------------------------------------------------------------

TEST_F(Reported, NumbersNearZeroAreRefusedByTheSchema) {
  for (const char* set :
       {"time.fps=1e-12", "time.fps=1e-300", "time.fps=0.001", "contact.rest_gap=1e-300",
        "solver.tolerance=1e-300", "materials.default.density=1e-300",
        "materials.default.stretch_stiffness=1e-300", "materials.default.strain_limit=1e-300",
        "geometry.0.size=[1e-300,1]", "geometry.0.scale=1e-300", "obstacles.0.shape.radius=1e-300"})
    EXPECT_REFUSED(run_small("r", std::string("--set ") + set), "must be at least");
  EXPECT_FALSE(exists("r"));
}

TEST_F(Reported, SchemaAndProgramHaveOneBoundOfTheResolution) {
  EXPECT_REFUSED(run_small("r", "--set obstacles.0.shape.resolution=1001"),
                 "obstacles[0].shape.resolution: must be at most 1000");
  EXPECT_REFUSED(run_small("r", "--set obstacles.0.shape.resolution=2"), "must be at least 3");
}

TEST_F(Reported, ABudgetThatIsNotPositiveIsRefusedInOneSentence) {
  for (const char* budget : {"0", "-1", "nan", "inf", "x"}) {
    const Outcome outcome = run_small("r", std::string("--budget ") + budget);
    EXPECT_EQ(outcome.code, 2) << budget;
    EXPECT_LT(outcome.err.size(), 200u) << outcome.err;
  }
  EXPECT_FALSE(exists("r"));
}

TEST_F(Reported, TheHelpOfSetAgreesWithWhatItTakes) {
  EXPECT_EQ(run("run --help").out.find("--set TEXT ..."), std::string::npos);
  EXPECT_EQ(run_small("r", "--set time.frames=1 time.fps=30").code, 2);
  EXPECT_EQ(run_small("r", "--set time.frames=1 --set time.fps=30").code, 0);
}

// -- comparisons ----------------------------------------------------------------------------------

TEST_F(Reported, ACompareNamesTheStepThatIsMadeAndMakesItOnce) {
  const Outcome outcome =
      run("compare small.json --vary dt=0.0057,0.0065,0.008,0.03 --set time.frames=2 "
          "--no-reference --repeats 1 --no-pictures --out c --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_SAYS(outcome.err, "dt=0.0065");
  const Json rows = Json::parse(outcome.out)["rows"];
  ASSERT_EQ(rows.size(), 2u);  // 3 steps a frame, and one of 2 frames
  for (const Json& row : rows)
    EXPECT_NEAR(std::stod(row["values"][0].get<std::string>()), row["dt"].get<double>(),
                1e-5 * row["dt"].get<double>());
  const std::string csv = content(folder_ / "c" / "compare.csv");
  const std::string head = "," + csv.substr(0, csv.find('\n')) + ",";
  const auto first = head.find(",dt,");
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(head.find(",dt,", first + 1), std::string::npos) << head;
  EXPECT_EQ(outcome.out.find("runs took 1 "), std::string::npos);
}

// -- result folders -------------------------------------------------------------------------------

TEST_F(Reported, ASecondRunDoesNotReplaceTheFirstUnlessAsked) {
  ASSERT_EQ(run("run small.json --out r").code, 0);
  ASSERT_EQ(run("measure r --no-pictures").code, 0);
  const std::string before = content(folder_ / "r" / "result.json");
  EXPECT_REFUSED(run_small("r"), "--overwrite");
  EXPECT_EQ(content(folder_ / "r" / "result.json"), before);
  EXPECT_EQ(count("r/frames", "cloth"), 4u);
  write("r/frames/cloth_00007.ply.partial4711", "a killed run");
  EXPECT_EQ(run_small("r", "--overwrite --set time.frames=1").code, 0);
  EXPECT_EQ(count("r/frames", "cloth"), 2u);
  EXPECT_EQ(count("r/pictures", "frame"), 0u);
  EXPECT_FALSE(exists("r/measures"));
  EXPECT_EQ(run_small("r", "--overwrite --resume").code, 2);
}

TEST_F(Reported, ARunKilledAtItsStartDoesNotBlockItsFolder) {
  fs::create_directory(folder_ / "r");
  write("r/lock", "4711\n");
  write("r/scene.json.partial4711", "{");
  EXPECT_EQ(run_small("r", "--set time.frames=1").code, 0);
  EXPECT_FALSE(exists("r/scene.json.partial4711"));
}

TEST_F(Reported, AResumedRunSaysWhichFramesAreMissing) {
  ASSERT_EQ(run_small("r").code, 0);
  fs::remove(folder_ / "r/frames/cloth_00000.ply");
  fs::remove(folder_ / "r/frames/cloth_00002.ply");
  const Outcome outcome = run_small("r", "--resume --set time.frames=5");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_SAYS(outcome.err, "2 of the 4 frames before the checkpoint are missing");
  EXPECT_SAYS(outcome.err, "the first is frame 0");
}

TEST_F(Reported, ARunThatNeedsMissingFramesIsNotResumed) {
  ASSERT_EQ(run_small("r").code, 0);
  const std::string checkpoint = content(folder_ / "r/checkpoint.json");
  const std::string more = "--resume --set time.frames=5 --set 'output.formats=[\"pc2\"]'";
  for (const std::string name : {"cloth_00001", "bodies_00000"}) {
    const fs::path file = folder_ / ("r/frames/" + name + ".ply");
    const std::string bytes = content(file);
    fs::remove(file);
    const Outcome outcome = run_small("r", more);
    EXPECT_REFUSED(outcome, "1 of the 4 frames before the checkpoint is missing");
    EXPECT_EQ(outcome.err.find("continues"), std::string::npos) << outcome.err;
    EXPECT_EQ(content(folder_ / "r/checkpoint.json"), checkpoint);
    std::ofstream(file, std::ios::binary) << bytes;
  }
  EXPECT_EQ(run_small("r", more).code, 0);
}

TEST_F(Reported, ResumedSumsHaveTheSameBits) {
  write("drop.json", R"({
    "geometry": [{"size": [0.5, 0.5], "cells": [8, 8], "transformation": {"translation": [0.01, 0.02, 0.302]}}],
    "obstacles": [{"shape": {"type": "sphere", "radius": 0.3, "resolution": 12}}],
    "solver": {"integrator": "symplectic_euler"}, "contact": {"response": "impulse"},
    "time": {"frames": 9, "max_halvings": 12}})");
  ASSERT_EQ(run("run drop.json --no-pictures --out whole").code, 0);
  for (const char* frames : {"3", "5", "9"})
    ASSERT_EQ(run("run drop.json --no-pictures --out parts --set time.frames=" +
                  std::string(frames) + (frames[0] == '3' ? "" : " --resume"))
                  .code,
              0);
  const Json whole = result("whole"), parts = result("parts");
  EXPECT_EQ(whole["state_hash"], parts["state_hash"]);
  EXPECT_EQ(whole["ledger"], parts["ledger"]);
  EXPECT_NE(whole["ledger"]["response"]["energy_normal_J"], 0.0);
}

// -- jams -----------------------------------------------------------------------------------------

/// Two boxes close on cloth until they overlap by 1 cm, and part again.
std::string jam_scene(const std::string& still_tangled) {
  const auto box = [](const char* name, const char* z, const char* closed) {
    return std::string(R"({"name": ")") + name +
           R"(", "shape": {"type": "box", "size": [0.1, 0.1, 0.1]},
      "transformation": {"translation": [0, 0, )" +
           z + R"(]}, "motion": [{"time": 0}, {"time": 0.2, "translation": [0, 0, )" + closed +
           R"(]}, {"time": 0.4}]})";
  };
  return R"({"name": "jam", "gravity": [0, 0, 0], "geometry": [{"name": "cloth", "size": [0.2, 0.2],
    "cells": [8, 8], "transformation": {"translation": [0.003, 0.005, 0]}}], "obstacles": [)" +
         box("upper", "0.08", "-0.035") + ", " + box("lower", "-0.08", "0.035") +
         R"(], "contact": {"still_tangled": ")" + still_tangled +
         R"("}, "time": {"frames": 36, "fps": 60}})";
}

TEST_F(Reported, BodiesThatCloseOnClothStopTheRunOrFlagIt) {
  write("stop.json", jam_scene("stop"));
  const Outcome stopped = run("run stop.json --no-pictures --out stop");
  EXPECT_EQ(stopped.code, 1);
  EXPECT_SAYS(stopped.err, "jammed: ");
  write("jam.json", jam_scene("carry"));
  const Outcome carried = run("run jam.json --no-pictures --out r");
  EXPECT_EQ(carried.code, 0) << carried.err;
  EXPECT_SAYS(carried.out, "bodies left cloth no room");
  const Json r = result("r");
  EXPECT_EQ(r["frames"], 37);
  EXPECT_EQ(r["clean"], false);
  EXPECT_EQ(r["clean_elsewhere"], true);
  EXPECT_GT(r["tangle"]["jams"].get<int>(), 0);
  EXPECT_EQ(r["tangle"]["elsewhere"], 0);
  EXPECT_GT(r["flags"]["pinched"]["worst"].get<int>(), 0);
  // The bodies have parted: nothing crosses any more, and no vertex is flagged.
  EXPECT_EQ(r["tangle"]["pairs"], 0);
  EXPECT_GT(r["tangle"]["until_s"].get<double>(), 0.1);
  EXPECT_EQ(r["flags"]["tangled"]["end"], 0);
  EXPECT_EQ(r["flags"]["pinched"]["end"], 0);
}

TEST_F(Reported, AJamHasTheSameBitsInPartsAndOnOneThread) {
  write("jam.json", jam_scene("carry"));
  ASSERT_EQ(run("run jam.json --no-pictures --out whole --threads 2").code, 0);
  for (const char* more : {"14", "20 --resume", "36 --resume"})
    ASSERT_EQ(run("run jam.json --no-pictures --out parts --threads 1 --set time.frames=" +
                  std::string(more))
                  .code,
              0);
  const Json whole = result("whole"), parts = result("parts");
  EXPECT_EQ(whole["state_hash"], parts["state_hash"]);
  EXPECT_EQ(whole["tangle"], parts["tangle"]);
  EXPECT_EQ(parts["clean"], false);
}

// -- time -----------------------------------------------------------------------------------------

TEST_F(Reported, ThousandsOfHandlesMakeThePieceOnce) {
  std::string handles;
  for (int i = 0; i < 1500; ++i)
    handles += (i == 0 ? "" : ", ") + std::string(R"({"select": [)") + std::to_string(i) + "]}";
  write(
      "handles.json", R"({"geometry": [{"size": [1, 1], "cells": [60, 60]}], "time": {"frames": 1},
        "handles": [)" + handles +
                          "]}");
  const Outcome outcome = run("run handles.json --no-pictures --out r", kFewSeconds);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

}  // namespace
}  // namespace selvedge::testing::reported_test
