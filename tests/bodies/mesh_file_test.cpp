// SPDX-License-Identifier: MIT
#include <selvedge/bodies/body.h>
#include <selvedge/bodies/mesh_file.h>

#include "mesh_files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace selvedge::mesh_file_test {
namespace {

using std::numbers::pi;

using MeshFile = Files;
using MeshFileFaults = Files;

bool same_bits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

// Every kind of double a file must carry.
TriangleMesh awkward_mesh() {
  using Limits = std::numeric_limits<double>;
  TriangleMesh mesh;
  mesh.vertices = {{-0.0, 0.0, Limits::denorm_min()},
                   {Limits::max(), Limits::lowest(), Limits::min()},
                   {1.0 / 3.0, -2.0 / 3.0, 0.1},
                   {std::nextafter(1.0, 2.0), 1e-310, -4.9e-324},
                   {pi, 1e22, 123456789.123456789}};
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}, {4, 3, 0}, {3, 3, 1}};
  return mesh;
}

// ---------------------------------------------------------------- files that are right

TEST_F(MeshFile, PlyGivesBackTheSameBits) {
  const TriangleMesh mesh = awkward_mesh();
  const std::vector<NamedValues> extra{{"speed", {0.5, -0.0, 5e-324, 1.0 / 3.0, 2.0}},
                                       {"u", {1, 2, 3, 4, 5}},
                                       {"flag", {0, 255, 1, 128, 2}, true}};
  write_ply(path("a.ply"), mesh.vertices, mesh.triangles, extra);
  const TriangleMesh back = read_mesh(path("a.ply"));
  EXPECT_TRUE(same_bits(back.vertices, mesh.vertices));
  EXPECT_EQ(back.triangles, mesh.triangles);
  std::vector<NamedValues> extra_back{{"rubbish", {1.0}}};
  EXPECT_TRUE(same_bits(read_ply(path("a.ply"), extra_back).vertices, mesh.vertices));
  ASSERT_EQ(extra_back.size(), extra.size());
  for (std::size_t i = 0; i < extra.size(); ++i) {
    EXPECT_EQ(extra_back[i].name, extra[i].name);
    EXPECT_EQ(extra_back[i].as_byte, extra[i].as_byte);
    EXPECT_EQ(0,
              std::memcmp(extra_back[i].values.data(), extra[i].values.data(), 5 * sizeof(double)));
  }
}

TEST_F(MeshFile, ObjGivesBackTheSameBits) {
  const TriangleMesh mesh = awkward_mesh();
  write_obj(path("a.obj"), mesh.vertices, mesh.triangles);
  const TriangleMesh back = read_mesh(path("a.obj"));
  EXPECT_TRUE(same_bits(back.vertices, mesh.vertices));
  EXPECT_EQ(back.triangles, mesh.triangles);
}

TEST_F(MeshFile, AllThreeFormatsReadTheSameMesh) {
  expect_tetrahedron(read_mesh(write("a.off", off_text())));
  expect_tetrahedron(read_mesh(write("a.obj", obj_text())));
  expect_tetrahedron(read_mesh(write("a.PLY", ply_text())));
}

TEST_F(MeshFile, EveryKindOfLineEndIsRead) {
  for (const std::string end : {"\r\n", "\r"})
    for (const auto& [name, text] : {std::pair{"a.off", off_text()}, std::pair{"a.obj", obj_text()},
                                     std::pair{"a.ply", ply_text()}}) {
      std::string changed;
      for (const char c : text) changed += c == '\n' ? end : std::string(1, c);
      expect_tetrahedron(read_mesh(write(name, changed)));
    }
}

TEST_F(MeshFile, ObjCornersMayCarryTextureAndNormals) {
  const std::string text =
      "mtllib a.mtl\no thing\nv 0 0 0 1.0\nv\t1 0 0 0.5 0.5 0.5\n v 0 1 0\nv 0 0 1 # tip\nvt 0 "
      "0\nvn 0 0 "
      "1\nusemtl m\ns off\nf 1/1/1 3/1/1 2/1/1\nf -4//1 -3//1 -1//1\nf 2/1 3/1 \\\n4/1\nf 1 4 "
      "3\nl 1 2\np 1\n";
  expect_tetrahedron(read_mesh(write("a.obj", text)));
}

TEST_F(MeshFile, ObjFacesMayStandBeforeTheirVertices) {
  expect_tetrahedron(read_mesh(
      write("a.obj", "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n")));
}

TEST_F(MeshFile, PolygonsBecomeFansInFileOrder) {
  const std::vector<Triangle> fan{{4, 0, 1}, {4, 1, 2}, {4, 2, 3}};
  const std::string points = "0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 1 0\n";
  EXPECT_EQ(read_mesh(write("a.off", "OFF\n5 1 0\n" + points + "5 4 0 1 2 3\n")).triangles, fan);
  EXPECT_EQ(read_mesh(write("a.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 5 1 2 3 4"))
                .triangles,
            fan);
  EXPECT_EQ(read_mesh(write("a.ply",
                            "ply\nformat ascii 1.0\nelement vertex 5\nproperty float "
                            "x\nproperty float y\nproperty float z\nelement face 1\n"
                            "property list uchar int vertex_index\nend_header\n" +
                                points + "5 4 0 1 2 3\n"))
                .triangles,
            fan);
}

TEST_F(MeshFile, OffKindsWithColoursAndNormalsAreRead) {
  expect_tetrahedron(read_mesh(
      write("a.off",
            "# first\nCOFF\n\n4 4 0 # counts\n0 0 0 255 0 0 255\n1 0 0 1 1 1 1\n0 1 0 0 0 "
            "0 0\n0 0 1 0 0 0 0\n3 0 2 1 200 0 0\n3 0 1 3\n3 1 2 3\n3 0 3 2 # end")));
  expect_tetrahedron(
      read_mesh(write("b.off",
                      "NOFF 4 4 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n0 0 1 0 0 1\n3 0 "
                      "2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n\n")));
  expect_tetrahedron(read_mesh(write("c.off", off_text().substr(4))));
}

TEST_F(MeshFile, PlyOfAnyTypesAndWithForeignElementsIsRead) {
  for (const bool big : {false, true}) {
    const std::string header =
        std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
        " 1.0\nobj_info x\nelement material 2\nproperty uchar red\nproperty list ushort float "
        "weights\nelement face 4\nproperty short flag\nproperty list uint ushort "
        "vertex_index\nproperty list char double uv\nelement vertex 4\nproperty int8 q\nproperty "
        "float64 z\nproperty int x\nproperty list uint8 int16 tags\nproperty float y\nelement edge "
        "1\nproperty int a\nend_header\n";
    Bytes body(big);
    body.add<std::uint8_t>(7).add<std::uint16_t>(2).add(1.0f).add(2.0f);
    body.add<std::uint8_t>(8).add<std::uint16_t>(0);
    for (const Triangle& t : tetrahedron().triangles) {
      body.add<std::int16_t>(-3).add<std::uint32_t>(3);
      for (const std::int32_t v : t) body.add(static_cast<std::uint16_t>(v));
      body.add<std::int8_t>(1).add(0.25);
    }
    for (const Vec3& x : tetrahedron().vertices) {
      body.add<std::int8_t>(-1).add(x.z()).add(static_cast<std::int32_t>(x.x()));
      body.add<std::uint8_t>(2).add<std::int16_t>(1).add<std::int16_t>(2);
      body.add(static_cast<float>(x.y()));
    }
    body.add<std::int32_t>(0);
    expect_tetrahedron(read_mesh(write("a.ply", header + body.text())));
  }
}

TEST_F(MeshFile, DecimalsAreReadToTheNearestDouble) {
  const TriangleMesh mesh =
      read_mesh(write("a.obj",
                      "v 0.1 +0.2 1e-400\nv 2.4703282292062328e-324 .5 5.\nv 1E3 -1e+2 "
                      "9007199254740993\nf 1 2 3\n"));
  EXPECT_TRUE(mesh.vertices[0] == Vec3(0.1, 0.2, 0.0));
  EXPECT_TRUE(mesh.vertices[1] == Vec3(5e-324, 0.5, 5.0));
  EXPECT_TRUE(mesh.vertices[2] == Vec3(1000.0, -100.0, 9007199254740992.0));
}

TEST_F(MeshFile, LargeMeshesAreReadQuickly) {
  const TriangleMesh sphere = tessellate(Sphere{1.0}, 500);
  ASSERT_GT(sphere.triangles.size(), 250000u);
  write_ply(path("a.ply"), sphere.vertices, sphere.triangles);
  const auto start = std::chrono::steady_clock::now();
  const TriangleMesh back = read_mesh(path("a.ply"));
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_TRUE(same_bits(back.vertices, sphere.vertices));
  EXPECT_LT(seconds.count(), 1.0);
}

// ---------------------------------------------------------------- files that are wrong

TEST_F(MeshFileFaults, WhatIsNoMeshFileIsSaidInOneSentence) {
  EXPECT_SAYS(fault_of(path("none.obj")), "none.obj: no such file");
  EXPECT_SAYS(fault_of(path("")), "is a folder");
  EXPECT_SAYS(fault_of(write("mesh", "x")), "has no extension");
  fs::create_directory(path("folder.ply"));
  EXPECT_SAYS(fault_of(path("folder.ply")), "is a folder");
  for (const char* name : {"e.obj", "e.ply", "e.off"})
    EXPECT_SAYS(fault_of(write(name, "")), "is empty");
  EXPECT_SAYS(fault_of(write("a.txt", "hello")), "extension '.txt' is not supported");
  EXPECT_SAYS(fault_of(write("a.off", "hello\n")), "not an OFF file");
  EXPECT_SAYS(fault_of(write("a.ply", "hello\n")), "not a PLY file");
  EXPECT_SAYS(fault_of(write("a.obj", "%PDF-1.4\n")), "not an OBJ statement");
  EXPECT_SAYS(fault_of(write("b.obj", "v 0 0 0\n")), "has no faces");
  EXPECT_SAYS(fault_of(write("c.obj", "# nothing\n")), "has no vertices");
}

TEST_F(MeshFileFaults, ABadIndexIsNamedWithItsLine) {
  EXPECT_SAYS(fault_of(write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 77\n")),
              "line 6: face 0 names vertex 77");
  EXPECT_SAYS(fault_of(write("b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n")), "vertex -1");
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_SAYS(fault_of(write("a.obj", points + "f 1 2 4\n")), "line 4: a face names vertex 4");
  EXPECT_SAYS(fault_of(write("b.obj", points + "f 0 1 2\n")), "indices begin at 1");
  EXPECT_SAYS(fault_of(write("c.obj", points + "f 1 2 -4\n")), "line 4: a face names vertex -4");
  EXPECT_SAYS(fault_of(write("d.obj", points + "f 1 2 99999999999\n")), "vertex 99999999999");
  EXPECT_SAYS(fault_of(write("e.obj", points + "f 1 2 3x\n")), "is not a face corner");
  EXPECT_SAYS(fault_of(write("f.obj", points + "f 1 2\n")), "2 corners");
  std::string text = ply_text();
  text.replace(text.find("3 1 2 3"), 7, "3 1 2 4");
  EXPECT_SAYS(fault_of(write("a.ply", text)), "line 17: face 2 names vertex 4");
}

TEST_F(MeshFileFaults, ACoordinateThatIsNotFiniteIsNamedWithItsLine) {
  for (const std::string bad : {"nan", "inf", "-inf", "1e400", "NaN"}) {
    EXPECT_SAYS(fault_of(write("a.obj", "v 0 0 0\nv 1 " + bad + " 0\nv 0 1 0\nf 1 2 3\n")),
                "line 2: the y coordinate is '" + bad + "', which is not finite");
    EXPECT_SAYS(fault_of(write("a.off", "OFF\n3 1 0\n0 0 0\n1 " + bad + " 0\n0 1 0\n3 0 1 2\n")),
                "line 4");
    std::string text = ply_text();
    text.replace(text.find("\n1 0 0\n") + 1, 1, bad);
    EXPECT_SAYS(fault_of(write("a.ply", text)), "line 12: vertex 1 has a coordinate");
  }
  TriangleMesh mesh = tetrahedron();
  mesh.vertices[2].y() = std::numeric_limits<double>::quiet_NaN();
  write_ply(path("b.ply"), mesh.vertices, mesh.triangles);
  EXPECT_SAYS(fault_of(path("b.ply")), "vertex 2 has a coordinate that is not finite");
}

TEST_F(MeshFileFaults, WordsThatAreNoNumbersAreQuoted) {
  EXPECT_SAYS(fault_of(write("a.obj", "v 0 zero 0\n")), "expected the y coordinate, found 'zero'");
  EXPECT_SAYS(fault_of(write("a.obj", "v 0 1,5 0\n")), "'1,5'");
  EXPECT_SAYS(fault_of(write("a.obj", "v 0 0\n")), "ends before the z coordinate");
  EXPECT_SAYS(fault_of(write("a.off", "OFF\nmany 4 0\n")), "'many'");
}

TEST_F(MeshFileFaults, CountsThatTheFileCannotHoldTakeNoMemory) {
  for (const std::string count : {"2147483647", "100000000"}) {
    EXPECT_SAYS(fault_of(write("a.off", "OFF\n" + count + " 1 0\n0 0 0\n")), "more than the file");
    EXPECT_SAYS(fault_of(write("b.off", "OFF\n1 " + count + " 0\n0 0 0\n")), "more than the file");
    for (const std::string format : {"ascii", "binary_little_endian"})
      EXPECT_SAYS(
          fault_of(write("a.ply", "ply\nformat " + format + " 1.0\nelement vertex " + count +
                                      "\nproperty float x\nproperty float y\nproperty "
                                      "float z\nelement face 1\nproperty list uchar int "
                                      "vertex_indices\nend_header\n0 0 0\n")),
          "more than the file");
  }
  EXPECT_SAYS(fault_of(write("c.off", "OFF\n99999999999999 1 0\n")), "impossible");
  EXPECT_SAYS(fault_of(write("d.off", "OFF\n-4 1 0\n")), "impossible");
  EXPECT_SAYS(fault_of(write("e.ply",
                             "ply\nformat ascii 1.0\nelement empty 2147483647\nelement "
                             "vertex 1\nproperty float x\nproperty float y\nproperty float "
                             "z\nelement face 1\nproperty list uchar int "
                             "vertex_indices\nend_header\n0 0 0\n")),
              "more than the file");
}

TEST_F(MeshFileFaults, AListLongerThanTheFileTakesNoMemory) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n";
  Bytes body(false);
  body.add(0.0f).add(0.0f).add(0.0f).add<std::uint32_t>(4000000000u);
  body.add<std::int32_t>(0).add<std::int32_t>(0).add<std::int32_t>(0);
  EXPECT_SAYS(fault_of(write("a.ply", header + body.text())), "ends within face 0");
}

TEST_F(MeshFileFaults, MoreThanTheHeaderCountsIsRefused) {
  EXPECT_SAYS(fault_of(write("a.off", off_text() + "3 0 1 2\n")), "more lines follow");
  EXPECT_SAYS(fault_of(write("a.ply", ply_text() + "3 0 1 2\n")), "more lines follow");
  write_ply(path("b.ply"), tetrahedron().vertices, tetrahedron().triangles);
  EXPECT_SAYS(fault_of(write("b.ply", bytes_of(path("b.ply")) + "\1\2\3")), "3 bytes more");
}

TEST_F(MeshFileFaults, DamagedPlyHeadersAreRefused) {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = ply_text();
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_SAYS(fault_of(write("a.ply", changed("ascii", "asci"))), "format 'asci' is unknown");
  EXPECT_SAYS(fault_of(write("a.ply", changed("format ascii 1.0\n", ""))), "names no format");
  EXPECT_SAYS(fault_of(write("a.ply", changed("float y", "quad y"))), "type 'quad' is unknown");
  EXPECT_SAYS(fault_of(write("a.ply", changed("float y", "float w"))), "must have the properties");
  EXPECT_SAYS(fault_of(write("a.ply", changed("float y", "float x"))), "declared twice");
  EXPECT_SAYS(fault_of(write("a.ply", changed("uchar int", "float int"))), "floating-point");
  EXPECT_SAYS(fault_of(write("a.ply", changed("uchar int", "uchar float"))), "floating-point");
  EXPECT_SAYS(fault_of(write("a.ply", changed("vertex_indices", "corners"))), "vertex_indices");
  EXPECT_SAYS(fault_of(write("a.ply", changed("element face", "element fase"))), "element 'face'");
  EXPECT_SAYS(fault_of(write("a.ply", changed("end_header\n", ""))),
              "not a statement of a PLY header");
  EXPECT_SAYS(fault_of(write("a.ply", changed("3 0 2 1", "3 0 2  "))),
              "line 15: the line ends before");
  EXPECT_SAYS(fault_of(write("a.ply", changed("3 0 2 1", "3 0 2 1 9"))), "more values");
  EXPECT_SAYS(fault_of(write("a.ply", changed("3 0 2 1", "-3 0 2 1"))), "negative length");
  EXPECT_SAYS(fault_of(write("a.ply", changed("3 0 2 1", "2 0 2  "))), "2 corners");
}

std::vector<std::pair<std::string, std::string>> sample_files(const fs::path& scratch) {
  write_ply(scratch, tetrahedron().vertices, tetrahedron().triangles,
            std::vector<NamedValues>{{"u", {1, 2, 3, 4}}});
  std::ifstream stream(scratch, std::ios::binary);
  std::ostringstream binary;
  binary << stream.rdbuf();
  std::string big = binary.str();
  big.replace(big.find("little"), 6, "big");
  return {{"a.off", off_text()},
          {"a.obj", obj_text()},
          {"a.ply", ply_text()},
          {"b.ply", binary.str()},
          {"c.ply", big}};
}

// Whatever comes back must be a mesh that indexes only itself; anything else must be a sentence.
void read_or_sentence(const fs::path& file) {
  try {
    const TriangleMesh mesh = read_mesh(file);
    for (const Triangle& t : mesh.triangles)
      for (const std::int32_t v : t) {
        ASSERT_GE(v, 0);
        ASSERT_LT(static_cast<std::size_t>(v), mesh.vertices.size());
      }
    for (const Vec3& x : mesh.vertices) ASSERT_TRUE(x.allFinite());
  } catch (const std::invalid_argument& sentence) {
    ASSERT_TRUE(std::string(sentence.what()).starts_with(file.string() + ": "));
    ASSERT_EQ(std::string(sentence.what()).find('\n'), std::string::npos);
  }
}

TEST_F(MeshFileFaults, ACutAtEveryByteGivesASentence) {
  for (const auto& [name, bytes] : sample_files(path("scratch.ply")))
    for (std::size_t n = 0; n < bytes.size(); ++n) {
      const fs::path file = write(name, bytes.substr(0, n));
      ASSERT_NO_FATAL_FAILURE(read_or_sentence(file));
      const bool cut_within_body = name == "b.ply" && n + 1 < bytes.size();
      ASSERT_TRUE(!cut_within_body || fault_of(file) != "") << n;
    }
}

TEST_F(MeshFileFaults, RandomDamageGivesASentence) {
  std::mt19937 random(20240607);
  for (const auto& [name, bytes] : sample_files(path("scratch.ply")))
    for (int round = 0; round < 200; ++round) {
      std::string damaged = bytes;
      for (int hit = 0; hit < 3; ++hit) {
        const std::size_t at = random() % damaged.size();
        switch (random() % 3) {
          case 0:
            damaged[at] = static_cast<char>(random());
            break;
          case 1:
            damaged.erase(at, 1 + random() % 4);
            break;
          default:
            damaged.insert(at, std::to_string(static_cast<int>(random())));
        }
        if (damaged.empty()) damaged.push_back('x');
      }
      ASSERT_NO_FATAL_FAILURE(read_or_sentence(write(name, damaged))) << "round " << round;
    }
}

// ---------------------------------------------------------------- writing

std::string write_fault(const fs::path& file) {
  try {
    write_ply(file, tetrahedron().vertices, tetrahedron().triangles);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

TEST_F(MeshFileFaults, WhatCannotBeWrittenIsSaidAndLeavesNothing) {
  EXPECT_SAYS(write_fault(path("none/a.ply")), "a.ply: cannot be written: No such file");
  fs::create_directory(path("folder.ply"));
  EXPECT_SAYS(write_fault(path("folder.ply")), "directory");
  EXPECT_SAYS(write_fault("/dev/null"), "not a regular file");
  EXPECT_EQ(std::distance(fs::directory_iterator(path("")), fs::directory_iterator()), 1);
}

TEST_F(MeshFileFaults, AFullDiskKeepsTheOldFile) {
  write("a.ply", ply_text());
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{64, before.rlim_max};  // stands for a disk with 64 bytes left
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string sentence = write_fault(path("a.ply"));
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_SAYS(sentence, "a.ply: cannot be written: File too large");
  EXPECT_EQ(bytes_of(path("a.ply")), ply_text());
  EXPECT_EQ(std::distance(fs::directory_iterator(path("")), fs::directory_iterator()), 1);
}

TEST_F(MeshFileFaults, ExtraValuesMustFitTheVertices) {
  const auto attempt = [&](std::vector<NamedValues> extra) {
    return fault(
        [&] { write_ply(path("a.ply"), tetrahedron().vertices, tetrahedron().triangles, extra); });
  };
  EXPECT_SAYS(attempt({{"u", {1, 2}}}), "2 values for 4 vertices");
  EXPECT_SAYS(attempt({{"x", {1, 2, 3, 4}}}), "cannot name a property");
  EXPECT_SAYS(attempt({{"a b", {1, 2, 3, 4}}}), "cannot name a property");
  EXPECT_SAYS(attempt({{"u", {1, 2, 3, 4}}, {"u", {1, 2, 3, 4}}}), "twice");
  EXPECT_FALSE(fs::exists(path("a.ply")));
}

}  // namespace
}  // namespace selvedge::mesh_file_test
