// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/bodies/mesh_report.h>

#include "mesh_files.h"

#include <gtest/gtest.h>

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
  const TriangleMesh mesh = load_mesh(write("a.gltf", gltf_text()));
  const MeshReport report = report_mesh(mesh);
  EXPECT_TRUE(report.sentences().empty());
  EXPECT_NEAR(report.volume, 1.0 / 6.0, 1e-6);
  EXPECT_TRUE(report.lower.isApprox(Vec3(9, 0, 0)));
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
