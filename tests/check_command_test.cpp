// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_file.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <set>
#include <vector>

#include "run_program.h"

namespace selvedge::check_command_test {
namespace {

using namespace selvedge::testing;
using selvedge::TriangleMesh;
using selvedge::Vec3;

// The names that other programs read.
const std::set<std::string> published = {
    "vertices",     "triangles",      "self_intersections", "body_intersections",
    "self_touches", "body_touches",   "inside_vertices",    "max_penetration_m",
    "max_stretch",  "max_compression"};

std::set<std::string> keys(const Json& json) {
  std::set<std::string> names;
  for (const auto& item : json.items()) names.insert(item.key());
  return names;
}

TriangleMesh sheet(int cells, const Vec3& corner) {
  TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      mesh.vertices.push_back(corner + Vec3(i, j, 0) / static_cast<double>(cells));
  for (std::int32_t j = 0; j < cells; ++j)
    for (std::int32_t i = 0; i < cells; ++i) {
      const std::int32_t a = j * (cells + 1) + i, b = a + 1, c = b + cells, d = c + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, c}});
    }
  return mesh;
}

const TriangleMesh tetrahedron{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                               {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};

class Check : public Program {
 protected:
  void write_mesh(const std::string& name, const TriangleMesh& mesh) const {
    selvedge::write_ply(folder_ / name, mesh.vertices, mesh.triangles);
  }

  Outcome check(const std::string& arguments) const { return run("check " + arguments); }

  /// What `check arguments --json` prints, after it ended with `code`.
  Json judged(const std::string& arguments, int code) const {
    const Outcome o = check(arguments + " --json");
    EXPECT_EQ(o.code, code) << arguments << ": " << o.err;
    EXPECT_EQ(o.err, "");
    return Json::parse(o.out, nullptr, false);
  }

  /// Reads a mesh, lets `change` have it and writes it back.
  void plant(const std::string& name, const std::function<void(TriangleMesh&)>& change) const {
    TriangleMesh mesh = selvedge::read_mesh(folder_ / name);
    change(mesh);
    write_mesh(name, mesh);
  }

  /// Every way of giving `file` to check and render, beside files that are right.
  void expect_refused_everywhere(const std::string& file, const std::string& part) const {
    SCOPED_TRACE(file);
    EXPECT_REFUSED(check(file), part);
    EXPECT_REFUSED(check(file + " --json"), part);
    EXPECT_REFUSED(check("sheet.ply --against " + file), part);
    EXPECT_REFUSED(check("sheet.ply --rest " + file), part);
    EXPECT_REFUSED(check("sheet.ply --next " + file), part);
    EXPECT_REFUSED(run("render " + file + " --out pictures"), part);
    EXPECT_FALSE(exists("pictures/" + fs::path(file).stem().string() + ".png"));
  }

  void write_sheet() const { write_mesh("sheet.ply", sheet(4, Vec3(0, 0, 0.5))); }
};

// -- meshes ---------------------------------------------------------------------------------------

TEST_F(Check, PrintsThePublishedFieldsAndEndsWithZeroForACleanMesh) {
  write_sheet();
  const Json json = judged("sheet.ply", 0);
  EXPECT_EQ(keys(json), published);
  EXPECT_EQ(json["vertices"], 25);
  EXPECT_EQ(json["triangles"], 32);
  for (const char* key : {"self_intersections", "body_intersections", "inside_vertices"})
    EXPECT_TRUE(json[key].is_number_integer()) << key;
  for (const char* key : {"max_penetration_m", "max_stretch", "max_compression"})
    EXPECT_TRUE(json[key].is_number()) << key;
}

TEST_F(Check, EndsWithOneAndCountsWhatCrossesTheBody) {
  write_mesh("body.ply", tetrahedron);
  // One vertex, at a depth of a tenth below the slanted face.
  const double depth = 0.1;
  const Vec3 inside = Vec3::Constant(1.0 / 3.0) - depth * Vec3::Ones().normalized();
  write_mesh("mesh.ply", {{inside, {2, 2, 2}, {2, 2, 2.1}}, {{0, 1, 2}}});
  const Json json = judged("mesh.ply --against body.ply", 1);
  EXPECT_EQ(keys(json), published);
  EXPECT_EQ(json["body_intersections"], 1);
  EXPECT_EQ(json["inside_vertices"], 1);
  EXPECT_NEAR(json["max_penetration_m"].get<double>(), depth, 1e-12);
  EXPECT_EQ(json["self_intersections"], 0);
  EXPECT_SAYS(check("mesh.ply --against body.ply").out, "(triangles 0-2)");
}

TEST_F(Check, EndsWithOneForTwoTrianglesThatCross) {
  write_mesh("cross.ply",
             {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.3, 0.2, 1}},
              {{0, 1, 2}, {3, 4, 5}}});
  EXPECT_EQ(judged("cross.ply", 1)["self_intersections"], 1);
}

TEST_F(Check, EndsWithZeroAndCountsTrianglesThatOnlyTouch) {
  write_mesh("touch.ply", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 0}, {0.2, 0.2, 1}},
                           {{0, 1, 2}, {0, 3, 4}}});
  write_mesh("body.ply", {{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, {{0, 1, 2}}});
  const Json json = judged("touch.ply --against body.ply", 0);
  EXPECT_EQ(json["self_touches"], 1);
  EXPECT_EQ(json["body_touches"], 1);
  EXPECT_EQ(json["self_intersections"].get<int>() + json["body_intersections"].get<int>(), 0);
  const std::string report = check("touch.ply --against body.ply").out;
  EXPECT_SAYS(report, "touches itself        1   (triangles 0-1)");
  EXPECT_SAYS(report, "touches the body      1   (triangles 1-0)");
  EXPECT_SAYS(check("touch.ply touch.ply").out, "1 pair touch");
}

/// A mesh, and the pairs of its triangles that cross and that touch.
struct MeetingCase {
  const char* name;
  std::string obj;
  int crossings, touches;
};

TEST_F(Check, InfoCheckAndTheStartOfARunGiveOneAnswer) {
  const std::string corner = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const std::vector<MeetingCase> cases{
      {"pierced", corner + "v .3 .2 .5\nv .3 .2 -.5\nf 1 2 3\nf 1 4 5\n", 1, 0},
      {"doubled", corner + "f 1 2 3\nf 2 1 3\n", 1, 0},
      {"nested", corner + "v 3 0 0\nv 0 2 0\nf 1 2 3\nf 1 4 5\n", 1, 0},
      {"folded", corner + "v .7 .9 0\nf 1 2 3\nf 2 1 4\n", 1, 0},
      {"hanging", corner + "v .5 0 0\nv .5 -1 0\nf 1 2 3\nf 1 4 5\n", 0, 1},
      {"squares",
       corner + "v 1 1 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\n"
                "f 1 2 4\nf 1 4 3\nf 5 6 7\nf 5 7 8\n",
       0, 3}};
  for (const MeetingCase& c : cases) {
    SCOPED_TRACE(c.name);
    write("mesh.obj", c.obj);
    const Json checked = judged("mesh.obj", c.crossings > 0 ? 1 : 0);
    EXPECT_EQ(checked["self_intersections"], c.crossings);
    EXPECT_EQ(checked["self_touches"], c.touches);
    const Json seen = Json::parse(run("info mesh.obj --json").out, nullptr, false);
    EXPECT_EQ(seen["crossings"], c.crossings);
    EXPECT_EQ(seen["touches"], c.touches);
    EXPECT_REFUSED(run_small("r", "--set obstacles=[] --set geometry='[{\"mesh\":\"mesh.obj\"}]'"),
                   c.crossings > 0 ? "the cloth crosses itself at the start"
                                   : "the cloth touches itself at the start");
  }
}

TEST_F(Check, MeasuresStrainOnlyAgainstARestMesh) {
  write_sheet();
  plant("sheet.ply", [](TriangleMesh& mesh) { mesh.vertices[0] -= Vec3(0.025, 0, 0); });
  write_mesh("rest.ply", sheet(4, Vec3(0, 0, 0.5)));
  EXPECT_NEAR(judged("sheet.ply --rest rest.ply", 0)["max_stretch"].get<double>(), 0.1, 1e-12);
  EXPECT_EQ(judged("sheet.ply", 0)["max_stretch"], 0.0);
}

TEST_F(Check, FindsWhatAPathPassesThroughBetweenTwoCleanStates) {
  write_mesh("body.ply", tetrahedron);
  write_mesh("above.ply", sheet(4, Vec3(-0.3, -0.3, 2)));
  write_mesh("below.ply", sheet(4, Vec3(-0.3, -0.3, -1)));
  EXPECT_EQ(judged("above.ply --against body.ply", 0)["body_intersections"], 0);
  EXPECT_EQ(judged("below.ply --against body.ply", 0)["body_intersections"], 0);
  const Json path = judged("above.ply --against body.ply --next below.ply", 1);
  EXPECT_GT(path["path_body_collisions"].get<int>(), 0);
  EXPECT_EQ(path["path_self_collisions"], 0);
}

TEST_F(Check, SeveralMeshesHaveAResultEach) {
  write_sheet();
  write_mesh("body.ply", tetrahedron);
  const Json results = judged("sheet.ply body.ply", 0)["results"];
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0]["file"], "sheet.ply");
  EXPECT_EQ(results[1]["vertices"], 4);
}

// -- faults of files ------------------------------------------------------------------------------

TEST_F(Check, MissingAndEmptyFilesAreRefused) {
  write_sheet();
  expect_refused_everywhere("none.ply", "no such");
  for (const char* name : {"empty.ply", "empty.obj", "empty.off"}) {
    write(name, "");
    expect_refused_everywhere(name, "is empty");
  }
}

TEST_F(Check, APlyCutAnywhereIsRefused) {
  write_sheet();
  const std::string whole = content(folder_ / "sheet.ply");
  const std::size_t header = whole.find("end_header\n") + 11, vertex = 3 * sizeof(double);
  ASSERT_GT(whole.size(), header + 25 * vertex);
  const std::vector<std::size_t> cuts = {2,
                                         4,
                                         header / 2,
                                         header - 1,
                                         header,
                                         header + 7,
                                         header + 12 * vertex,
                                         header + 25 * vertex,
                                         header + 25 * vertex + 1,
                                         whole.size() - 13,
                                         whole.size() - 1};
  for (const std::size_t cut : cuts) {
    const std::string name = "cut_" + std::to_string(cut) + ".ply";
    write(name, whole.substr(0, cut));
    expect_refused_everywhere(name, name);
  }
}

TEST_F(Check, CoordinatesThatAreNotFiniteAreRefused) {
  write_sheet();
  write("nan.off", "OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n");
  write("infinite.obj", "v 0 0 0\nv 1 0 inf\nv 0 1 0\nf 1 2 3\n");
  write("nan.ply", content(folder_ / "sheet.ply"));
  std::string bytes = content(folder_ / "sheet.ply");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::size_t vertex_2 = bytes.find("end_header\n") + 11 + 2 * 3 * sizeof(double);
  bytes.replace(vertex_2, sizeof nan, reinterpret_cast<const char*>(&nan), sizeof nan);
  write("nan.ply", bytes);
  for (const char* name : {"nan.off", "infinite.obj", "nan.ply"})
    expect_refused_everywhere(name, "finite");
}

TEST_F(Check, IndicesOutOfRangeAreRefused) {
  write_sheet();
  write("high.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n");
  write("negative.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n");
  write("zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n");
  std::string bytes = content(folder_ / "sheet.ply");
  const std::int32_t far = 25;
  bytes.replace(bytes.size() - sizeof far, sizeof far, reinterpret_cast<const char*>(&far),
                sizeof far);
  write("high.ply", bytes);
  for (const char* name : {"high.off", "negative.off", "zero.obj", "high.ply"})
    expect_refused_everywhere(name, name);
}

TEST_F(Check, ARestMeshOfOtherTrianglesIsRefusedWithBothFiles) {
  write_sheet();
  write_mesh("coarse.ply", sheet(3, Vec3::Zero()));
  TriangleMesh turned = sheet(4, Vec3::Zero());
  std::swap(turned.triangles[5][0], turned.triangles[5][1]);
  write_mesh("turned.ply", turned);
  TriangleMesh point = sheet(4, Vec3::Zero());
  point.vertices[1] = point.vertices[0];
  write_mesh("point.ply", point);
  EXPECT_REFUSED(check("sheet.ply --rest coarse.ply"), "sheet.ply with rest mesh coarse.ply");
  EXPECT_REFUSED(check("sheet.ply --rest turned.ply"), "turned.ply");
  EXPECT_REFUSED(check("sheet.ply --rest point.ply"), "has length 0");
  EXPECT_REFUSED(check("sheet.ply --next coarse.ply"), "its triangles are not those of");
}

TEST_F(Check, WrongCommandLinesAreRefused) {
  write_sheet();
  for (const char* arguments :
       {"check", "check sheet.ply --agains sheet.ply",
        "check sheet.ply "
        "--threads -1",
        "check sheet.ply --path",
        "check sheet.ply "
        "--against-next sheet.ply",
        "render", "render sheet.ply --size big", "render sheet.ply --eye 1,2"}) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.code, 2) << arguments;
    EXPECT_NE(o.err, "") << arguments;
  }
}

// -- output ---------------------------------------------------------------------------------------

TEST_F(Check, PrintingToAFullDiskEndsWithOne) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  write_sheet();
  const std::string command =
      "cd '" + folder_.string() + "' && '" + program + "' check sheet.ply --json >/dev/full 2>err";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 1);
  EXPECT_SAYS(content(folder_ / "err"), "could not be written");
}

TEST_F(Check, RenderRefusesAPlaceThatCannotBeAFolder) {
  write_sheet();
  write("file", "");
  EXPECT_REFUSED(run("render sheet.ply --out file/pictures"), "file/pictures");
  const std::string too_long(300, 'x');  // for a name: root cannot make it either
  EXPECT_REFUSED(run("render sheet.ply --out " + too_long), "xxx: cannot be made");
}

TEST_F(Check, RenderOnAFullDiskEndsWithOneWithoutAHalfPicture) {
  write_sheet();
  // A limit on the size of a file stands for the disk; a picture is larger than two blocks.
  const Outcome o = run("render sheet.ply --out pictures", "ulimit -f 2 &&");
  EXPECT_EQ(o.code, 1) << o.out << o.err;
  EXPECT_SAYS(o.err, "sheet.png");
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  EXPECT_EQ(count("pictures", ""), 0u);
  EXPECT_EQ(run("render sheet.ply --out pictures").code, 0);
  EXPECT_EQ(count("pictures", "sheet.png"), 1u);
}

// -- results of runs ------------------------------------------------------------------------------

const std::string moving_ball =
    " --set 'obstacles.ball.motion=[{\"time\":0},{\"time\":0.5,\"translation\":[0.1,0,0.05]}]'";

/// A result folder "r" with every state.
class CheckResult : public Check {
 protected:
  void run_every_step(const std::string& more = "") const {
    ASSERT_EQ(run_small("r", "--every-step --set time.frames=8" + more).code, 0);
  }
};

void expect_all_zero(const Json& json) {
  for (const char* key : {"self_intersections", "body_intersections", "inside_vertices",
                          "max_penetration_m", "path_self_collisions", "path_body_collisions"})
    EXPECT_EQ(json[key], 0) << key;
  EXPECT_EQ(json["first_wrong"], "");
}

TEST_F(CheckResult, EveryAcceptedStateAndPathOfARunIsClean) {
  ASSERT_EQ(run_small("r", "--every-step --set time.frames=45").code, 0);
  const Json json = judged("r", 0);
  const auto steps = result("r")["steps"].get<int>();
  EXPECT_GE(steps, 45);
  EXPECT_EQ(json["states"], steps + 1);
  EXPECT_EQ(json["paths"], steps);
  EXPECT_EQ(json["vertices"], 100);
  EXPECT_GT(json["path_pairs"].get<int>(), 0);
  expect_all_zero(json);
  for (const std::string& key : published) EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_SAYS(check("r").out, std::to_string(steps + 1) + " accepted states");
}

TEST_F(CheckResult, AMovingBodyIsPairedStateByState) {
  run_every_step(moving_ball);
  ASSERT_EQ(count("r/steps", "bodies_"), count("r/steps", "cloth_"));
  expect_all_zero(judged("r", 0));
  plant("r/steps/bodies_000005.ply", [](TriangleMesh& ball) {
    for (Vec3& x : ball.vertices) x.z() += 0.05;
  });
  const Json json = judged("r", 1);
  EXPECT_GT(json["inside_vertices"].get<int>(), 0);
  EXPECT_EQ(json["first_wrong"], "r/steps/cloth_000004.ply") << "its path meets the ball first";
}

TEST_F(CheckResult, AVertexPlantedThroughTheBodyIsFound) {
  run_every_step();
  plant("r/steps/cloth_000007.ply", [](TriangleMesh& cloth) { cloth.vertices[44].z() = 0.1; });
  const Json json = judged("r", 1);
  EXPECT_EQ(json["inside_vertices"], 1);
  EXPECT_GT(json["body_intersections"].get<int>(), 0);
  EXPECT_GT(json["path_body_collisions"].get<int>(), 0);
  EXPECT_GT(json["max_penetration_m"].get<double>(), 0.05);
  EXPECT_EQ(json["first_wrong"], "r/steps/cloth_000006.ply") << "its path leads into the body";
  EXPECT_SAYS(check("r").out, "first at fault");
}

TEST_F(CheckResult, AVertexPlantedThroughTheClothIsFound) {
  run_every_step();
  // Two neighbours at the corner, one below the middle of the flat cloth and one above it.
  plant("r/steps/cloth_000000.ply", [](TriangleMesh& cloth) {
    cloth.vertices[0] = Vec3(0.02, 0.01, 0.306);
    cloth.vertices[1] = Vec3(0.03, 0.02, 0.36);
  });
  const Json json = judged("r", 1);
  EXPECT_GT(json["self_intersections"].get<int>(), 0);
  EXPECT_EQ(json["body_intersections"], 0);
  EXPECT_EQ(json["first_wrong"], "r/steps/cloth_000000.ply");
}

TEST_F(CheckResult, ATunnelBetweenTwoCleanStatesIsFound) {
  run_every_step();
  plant("r/steps/cloth_000016.ply", [](TriangleMesh& cloth) {
    for (Vec3& x : cloth.vertices) x.z() -= 1.0;
  });
  const Json json = judged("r", 1);
  EXPECT_EQ(json["body_intersections"], 0);
  EXPECT_EQ(json["inside_vertices"], 0);
  EXPECT_GT(json["path_body_collisions"].get<int>(), 0);
  EXPECT_EQ(json["first_wrong"], "r/steps/cloth_000015.ply");
}

TEST_F(CheckResult, WithoutStepsTheFramesAreJudgedAndNoPaths) {
  ASSERT_EQ(run_small("r").code, 0);
  const Json json = judged("r", 0);
  EXPECT_EQ(json["states"], 4);
  EXPECT_EQ(json["paths"], 0);
  EXPECT_FALSE(json.contains("path_pairs"));
  EXPECT_EQ(json["max_stretch"], 0.0) << "a start shape need not be the rest shape";
  EXPECT_GT(judged("r --rest r/frames/cloth_00000.ply", 0)["max_stretch"].get<double>(), 0.0);
  plant("r/frames/cloth_00002.ply", [](TriangleMesh& cloth) { cloth.vertices[44].z() = 0.1; });
  EXPECT_EQ(judged("r", 1)["first_wrong"], "r/frames/cloth_00002.ply");
}

TEST_F(CheckResult, ThreadsDoNotChangeTheAnswer) {
  run_every_step();
  plant("r/steps/cloth_000007.ply", [](TriangleMesh& cloth) { cloth.vertices[44].z() = 0.1; });
  EXPECT_EQ(judged("r --threads 1", 1), judged("r --threads 4", 1));
  write("r/steps/cloth_000003.ply", "");
  write("r/steps/cloth_000011.ply", "");
  for (const char* threads : {"1", "4"})
    EXPECT_REFUSED(check(std::string("r --threads ") + threads), "cloth_000003.ply: is empty");
}

TEST_F(CheckResult, AFolderWithoutFramesIsRefused) {
  EXPECT_REFUSED(check("."), "holds no frames/cloth_*.ply");
  EXPECT_REFUSED(run("render ."), "holds no frames/cloth_*.ply");
  fs::create_directories(folder_ / "r/frames");
  EXPECT_REFUSED(check("r"), "holds no frames/cloth_*.ply");
  EXPECT_REFUSED(run("render r"), "holds no frames/cloth_*.ply");
}

TEST_F(CheckResult, AMissingFileIsNotPassedOver) {
  run_every_step(moving_ball);
  fs::rename(folder_ / "r/steps/bodies_000016.ply", folder_ / "last");
  EXPECT_REFUSED(check("r"), "bodies_000016.ply: is missing");
  fs::rename(folder_ / "last", folder_ / "r/steps/bodies_000016.ply");
  fs::rename(folder_ / "r/steps/cloth_000004.ply", folder_ / "fourth");
  EXPECT_REFUSED(check("r"), "cloth_000004.ply: is missing");
  fs::rename(folder_ / "fourth", folder_ / "r/steps/cloth_000004.ply");
  fs::remove(folder_ / "r/steps/cloth_000016.ply");
  EXPECT_REFUSED(check("r"), "holds 16 of the 17 states");
  fs::remove_all(folder_ / "r/steps");
  EXPECT_EQ(check("r").code, 0);
  for (int frame = 0; frame <= 8; ++frame)
    fs::remove(folder_ / ("r/frames/bodies_0000" + std::to_string(frame) + ".ply"));
  EXPECT_REFUSED(check("r"), "bodies_00000.ply: is missing, though the scene has obstacles");
}

TEST_F(CheckResult, BodiesThatAllHaveAMassAreJudgedWithTheCloth) {
  run_every_step(" --set obstacles.ball.mass=1");
  ASSERT_EQ(count("r/steps", "bodies_"), 0u);
  const Json json = judged("r", 0);
  EXPECT_GT(json["vertices"], 100) << "with those of the ball";
  EXPECT_GT(json["path_pairs"].get<int>(), 0);
  expect_all_zero(json);
  fs::remove_all(folder_ / "r/steps");
  EXPECT_EQ(judged("r", 0)["first_wrong"], "");
  plant("r/frames/cloth_00007.ply", [](TriangleMesh& cloth) { cloth.vertices[44].z() = 0.1; });
  EXPECT_EQ(judged("r", 1)["first_wrong"], "r/frames/cloth_00007.ply");
}

TEST_F(CheckResult, LastFramesThatAreMissingAreSaid) {
  ASSERT_EQ(run_small("r").code, 0);
  fs::remove(folder_ / "r/frames/cloth_00003.ply");
  EXPECT_REFUSED(check("r"), "r/frames: holds 3 of the 4 frames of the run");
  fs::remove(folder_ / "r/result.json");
  EXPECT_EQ(judged("r", 0)["states"], 3) << "of a run that has not ended";
}

TEST_F(CheckResult, AStateOfAnotherClothIsRefused) {
  run_every_step();
  write_mesh("r/steps/cloth_000002.ply", sheet(3, Vec3(0, 0, 1)));
  EXPECT_REFUSED(check("r"), "cloth_000002.ply: its triangles are not those of");
  EXPECT_REFUSED(check("r --rest r/frames/cloth_00000.ply"), "cloth_00000");
}

TEST_F(CheckResult, AFolderGoesAlone) {
  ASSERT_EQ(run_small("r").code, 0);
  EXPECT_REFUSED(check("r r/frames/cloth_00000.ply"), "checked alone");
  EXPECT_REFUSED(check("r/frames/cloth_00000.ply r"), "checked alone");
  EXPECT_REFUSED(check("r --against r/frames/bodies_00000.ply"), "checked alone");
  EXPECT_REFUSED(check("r --path"), "checked alone");
}

TEST_F(CheckResult, RenderRefusesDamagedFramesAndSaysWhichFrameIsNotThere) {
  ASSERT_EQ(run_small("r").code, 0);
  EXPECT_REFUSED(run("render r --frames 9"), "selects no frame; the frames are 0 to 3");
  const std::string whole = frame("r", 3);
  for (const std::size_t size : {std::size_t{0}, std::size_t{40}, whole.size() - 5}) {
    write("r/frames/cloth_00003.ply", whole.substr(0, size));
    EXPECT_REFUSED(run("render r"), "cloth_00003.ply");
    EXPECT_FALSE(exists("r/pictures/frame_00003.png"));
  }
  write("r/frames/cloth_00003.ply", whole);
  write("r/scene.json", "{");
  EXPECT_REFUSED(run("render r"), "scene.json: is not JSON");
}

TEST_F(CheckResult, RenderOnAFullDiskEndsWithOneAndKeepsTheFrames) {
  ASSERT_EQ(run_small("r").code, 0);
  const Outcome o = run("render r", "ulimit -f 2 &&");
  EXPECT_EQ(o.code, 1) << o.out << o.err;
  EXPECT_SAYS(o.err, "frame_00003.png");
  EXPECT_EQ(count("r/pictures", ""), 0u);
  EXPECT_EQ(check("r").code, 0);
}

}  // namespace

}  // namespace selvedge::check_command_test
