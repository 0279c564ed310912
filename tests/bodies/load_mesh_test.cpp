// SPDX-License-Identifier: MIT
#include <selvedge/bodies/internal/animation_file.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/bodies/mesh_report.h>

#include "mesh_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace selvedge::load_mesh_test {
namespace {

using LoadMesh = Files;

TEST_F(LoadMesh, UnitAndUpAxisTurnTheMeshWithoutMirroringIt) {
  const fs::path file = write("a.off", off_text());
  for (const UpAxis up : {UpAxis::x, UpAxis::y, UpAxis::z}) {
    const TriangleMesh mesh = load_mesh(file, {.unit = 0.01, .up = up});
    const Vec3 tip = mesh.vertices[1 + static_cast<int>(up)];
    EXPECT_TRUE(tip == Vec3(0.0, 0.0, 0.01));
    EXPECT_GT(report_mesh(mesh).volume, 0.0);
  }
}

TEST_F(LoadMesh, WeldingRestoresSharedVertices) {
  const fs::path file =
      write("a.obj",
            "v 9 9 9\nv 0 0 0\nv 0 1 0\nv 1 0 0\nv -0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 "
            "0\nv 0 0 1\nv 0 0 0\nv 0 0 1\nv 0 1 0\nf 2 3 4\nf 5 6 7\nf 8 9 10\nf 11 12 "
            "13\nf 2 11 4\n");
  const TriangleMesh welded = load_mesh(file);
  EXPECT_EQ(welded.vertices.size(), 4u);
  EXPECT_EQ(welded.triangles.size(), 4u);  // the last one collapses
  EXPECT_TRUE(report_mesh(welded).sentences().empty());
  EXPECT_EQ(load_mesh(file, {.weld = false}).vertices.size(), 13u);
}

TEST_F(LoadMesh, BadSettingsAreRefused) {
  const fs::path file = write("a.off", off_text());
  EXPECT_SAYS(fault([&] { load_mesh(file, {.unit = 0.0}); }), "unit");
  EXPECT_SAYS(fault([&] { load_mesh(file, {.unit = 1e308 * 10}); }), "unit");
  EXPECT_SAYS(fault([&] { load_mesh(file, {.timeout = -1.0}); }), "time");
  EXPECT_SAYS(fault([&] { load_mesh(path("none.stl")); }), "none.stl: no such file");
  EXPECT_SAYS(fault([&] { load_mesh(write("e.stl", "")); }), "is empty");
}

std::string stl_text() {
  std::ostringstream text;
  text << "solid s\n";
  const TriangleMesh mesh = tetrahedron();
  for (const Triangle& t : mesh.triangles) {
    text << "facet normal 0 0 0\nouter loop\n";
    for (const std::int32_t v : t) text << "vertex " << mesh.vertices[v].transpose() << "\n";
    text << "endloop\nendfacet\n";
  }
  text << "endsolid s\n";
  return text.str();
}

// A triangle strip of glTF nodes: the tetrahedron in a data URI, moved by its node.
std::string gltf_text() {
  Bytes buffer(false);
  for (const Vec3& x : tetrahedron().vertices)
    for (int k = 0; k < 3; ++k) buffer.add(static_cast<float>(x[k]));
  for (const Triangle& t : tetrahedron().triangles)
    for (const std::int32_t v : t) buffer.add(static_cast<std::uint16_t>(v));
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64;
  for (std::size_t i = 0; i < buffer.text().size(); i += 3) {  // 72 bytes: no padding
    std::uint32_t word = 0;
    for (int k = 0; k < 3; ++k) word = word << 8 | static_cast<unsigned char>(buffer.text()[i + k]);
    for (int shift = 18; shift >= 0; shift -= 6) base64 += digits[word >> shift & 63];
  }
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"mesh":0,"translation":[10,0,0],"scale":[-1,1,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],
"buffers":[{"byteLength":72,"uri":"data:application/octet-stream;base64,)" +
         base64 + R"("}]})";
}

bool build_has_assimp(const fs::path& stl) {
  return fault([&] { load_mesh(stl); }).find("this build has no assimp") == std::string::npos;
}

TEST_F(LoadMesh, StlIsReadAndWelded) {
  const fs::path file = write("a.stl", stl_text());
  if (!build_has_assimp(file)) GTEST_SKIP() << "this build has no assimp";
  const TriangleMesh mesh = load_mesh(file);
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_TRUE(report_mesh(mesh).sentences().empty());
  EXPECT_NEAR(report_mesh(mesh).volume, 1.0 / 6.0, 1e-7);  // assimp reads floats
}

TEST_F(LoadMesh, GltfNodesPlaceTheirMeshesAndMirrorsStayOutward) {
  if (!build_has_assimp(write("a.stl", stl_text()))) GTEST_SKIP() << "this build has no assimp";
  const TriangleMesh mesh = load_mesh(write("a.gltf", gltf_text()), {.up = UpAxis::z});
  const MeshReport report = report_mesh(mesh);
  EXPECT_TRUE(report.sentences().empty());
  EXPECT_NEAR(report.volume, 1.0 / 6.0, 1e-6);
  EXPECT_TRUE(report.lower.isApprox(Vec3(9, 0, 0)));
}

/// The tetrahedron in Collada; an empty unit or axis is not stated.
std::string collada_text(const std::string& unit, const std::string& up) {
  std::string asset = "<asset><created>2026-01-01</created><modified>2026-01-01</modified>";
  if (!unit.empty()) asset += "<unit name=\"u\" meter=\"" + unit + "\"/>";
  if (!up.empty()) asset += "<up_axis>" + up + "_UP</up_axis>";
  return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">)" +
         asset + R"(</asset><library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="a" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common>
<accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="4">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 1 2 3 0 3 2</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/>
</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

/// The tetrahedron in FBX; `factor`: centimetres per unit.
std::string fbx_text(double factor, int up, int sign = 1) {
  std::ostringstream text;
  text << "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n\tFBXHeaderVersion: "
          "1003\n\tFBXVersion: "
          "7400\n}\nGlobalSettings:  {\n\tVersion: 1000\n\tProperties70:  {\n\t\tP: \"UpAxis\", "
          "\"int\", "
          "\"Integer\", \"\","
       << up << "\n\t\tP: \"UpAxisSign\", \"int\", \"Integer\", \"\"," << sign
       << "\n\t\tP: \"UnitScaleFactor\", \"double\", \"Number\", \"\"," << factor << R"(
	}
}
Definitions:  {
	Version: 100
	Count: 2
}
Objects:  {
	Geometry: 100, "Geometry::g", "Mesh" {
		Vertices: *12 {
			a: 0,0,0,1,0,0,0,1,0,0,0,1
		}
		PolygonVertexIndex: *12 {
			a: 0,2,-2,0,1,-4,1,2,-4,0,3,-3
		}
	}
	Model: 200, "Model::m", "Mesh" {
		Version: 232
	}
}
Connections:  {
	C: "OO",200,0
	C: "OO",100,200
}
)";
  return text.str();
}

/// Vertices in order of their coordinates, which do not depend on how assimp splits them.
std::vector<Vec3> sorted(std::vector<Vec3> x) {
  std::sort(x.begin(), x.end(), [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  });
  return x;
}

void expect_axes(const fs::path& file, double unit, UpAxis up) {
  const BodyMesh body = load_body_mesh(file);
  EXPECT_NEAR(body.axes.unit, unit, 1e-9 * unit) << file;
  EXPECT_EQ(body.axes.up, up) << file;
  EXPECT_TRUE(body.axes.unit_stated && body.axes.up_stated) << file;
  const TriangleMesh wanted = prepare_mesh(tetrahedron(), {.unit = unit, .up = up}, "wanted");
  const auto near = [&](const std::vector<Vec3>& x) {
    const std::vector<Vec3> a = sorted(x), b = sorted(wanted.vertices);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LE((a[i] - b[i]).norm(), 1e-5 * unit) << file;
  };
  near(body.mesh.vertices);
  EXPECT_GT(report_mesh(body.mesh).volume, 0.0) << file;
  near(load_animation(file, {.load = {}}).frames.front());  // as `sequence` reads it
  // What is given counts instead of what the file states.
  const BodyMesh other = load_body_mesh(file, {.unit = 2.0, .up = UpAxis::x});
  EXPECT_NEAR(report_mesh(other.mesh).volume, 8.0 / 6.0, 1e-4) << file;
  EXPECT_EQ(other.axes.up, UpAxis::x);
}

TEST_F(LoadMesh, UnitAndAxesThatAFileStatesCount) {
  if (!build_has_assimp(write("a.stl", stl_text()))) GTEST_SKIP() << "this build has no assimp";
  std::string gltf = gltf_text();
  const std::string node = R"(,"translation":[10,0,0],"scale":[-1,1,1])";
  gltf.erase(gltf.find(node), node.size());
  expect_axes(write("a.gltf", gltf), 1.0, UpAxis::y);
  const UpAxis axes[] = {UpAxis::x, UpAxis::y, UpAxis::z};
  const std::string letters[] = {"X", "Y", "Z"};
  for (int k = 0; k < 3; ++k) {
    for (const std::string unit : {"1", "0.01", "0.0254", "0.3048"})
      expect_axes(write("a.dae", collada_text(unit, letters[k])), std::stod(unit), axes[k]);
    for (const double factor : {1.0, 2.54, 100.0})
      expect_axes(write("a.fbx", fbx_text(factor, k)), 0.01 * factor, axes[k]);
  }
  expect_axes(write("a.dae", collada_text("", "")), 1.0, UpAxis::y);
  const BodyMesh silent = load_body_mesh(path("a.stl"));
  EXPECT_FALSE(silent.axes.unit_stated || silent.axes.up_stated);
  EXPECT_EQ(silent.axes.up, UpAxis::z);
}

TEST_F(LoadMesh, ANegativeUpAxisIsRefusedUnlessTheAxisIsGiven) {
  if (!build_has_assimp(write("a.stl", stl_text()))) GTEST_SKIP() << "this build has no assimp";
  const fs::path file = write("a.fbx", fbx_text(1.0, 1, -1));
  EXPECT_SAYS(fault([&] { load_mesh(file); }), "a.fbx: states that its negative y axis points up");
  EXPECT_EQ(load_mesh(file, {.up = UpAxis::y}).triangles.size(), 4u);
}

TEST_F(LoadMesh, NodesThatAreChildrenOfSeveralNodesAreRefusedAtOnce) {
  if (!build_has_assimp(write("a.stl", stl_text()))) GTEST_SKIP() << "this build has no assimp";
  for (const int levels : {40, 25}) {
    std::string nodes;
    for (int i = 0; i < levels; ++i)
      nodes += "{\"children\":[" + std::to_string(i + 1) + "," + std::to_string(i + 1) + "]},";
    std::string text = gltf_text();
    const auto at = text.find("\"nodes\":[{");
    text.insert(at + 9, nodes);
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_SAYS(fault([&] { load_mesh(write("a.gltf", text)); }), "children of several nodes");
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  }
}

TEST_F(LoadMesh, FilesThatAssimpCannotReadGiveASentence) {
  if (!build_has_assimp(write("a.stl", stl_text()))) GTEST_SKIP() << "this build has no assimp";
  EXPECT_SAYS(fault([&] { load_mesh(write("a.xyz", "hello")); }), "assimp cannot read it");
  EXPECT_SAYS(fault([&] { load_mesh(write("a.glb", "glTFrubbish")); }), "a.glb: ");
  const std::string stl = stl_text();
  for (std::size_t n = 1; n < stl.size(); n += stl.size() / 12) {
    const fs::path file = write("b.stl", stl.substr(0, n));
    const std::string sentence = fault([&] { load_mesh(file); });
    EXPECT_TRUE(sentence.empty() || sentence.find("b.stl: ") != std::string::npos) << sentence;
  }
}

// Puts a shell script in the place of the program that reads by assimp.
class ImpostorProgram {
 public:
  ImpostorProgram(const fs::path& script, const std::string& commands) {
    std::ofstream(script) << "#!/bin/sh\n" << commands << "\n";
    fs::permissions(script, fs::perms::owner_all);
    ::setenv("SELVEDGE_ASSIMP", script.c_str(), 1);
  }
  ~ImpostorProgram() { ::unsetenv("SELVEDGE_ASSIMP"); }
};

TEST_F(LoadMesh, AReaderThatHangsCrashesOrTalksNonsenseGivesASentence) {
  const fs::path file = write("a.stl", stl_text());
  if (!build_has_assimp(file)) GTEST_SKIP() << "this build has no assimp";
  const auto sentence = [&](const std::string& commands) {
    const ImpostorProgram impostor(path("impostor"), commands);
    return fault([&] { load_mesh(file, {.timeout = 0.4, .memory_limit = 1 << 20}); });
  };
  const auto start = std::chrono::steady_clock::now();
  EXPECT_SAYS(sentence("sleep 60"), "did not finish reading within 0.4 s");
  EXPECT_SAYS(sentence("exec 1>&-; sleep 60"), "did not finish reading within 0.4 s");
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - start;
  EXPECT_LT(waited.count(), 5.0);
  EXPECT_SAYS(sentence("kill -SEGV $$"), "crashed (signal 11)");
  EXPECT_SAYS(sentence("yes"), "more memory than the limit of 1 MiB");
  EXPECT_SAYS(sentence("printf M12345"), "gave no mesh");
  EXPECT_SAYS(sentence("printf 'Ebad\\nfile.'; exit 1"), "assimp cannot read it: bad file; ");
  EXPECT_SAYS(sentence("exit 3"), "gave no mesh (exit status 3)");
  ::setenv("SELVEDGE_ASSIMP", path("nowhere").c_str(), 1);
  EXPECT_SAYS(fault([&] { load_mesh(file); }), "cannot be started");
  ::unsetenv("SELVEDGE_ASSIMP");
}

}  // namespace
}  // namespace selvedge::load_mesh_test
