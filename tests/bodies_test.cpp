// SPDX-License-Identifier: MIT
#include <selvedge/bodies/analytic_body.h>
#include <selvedge/bodies/body.h>
#include <selvedge/bodies/detail/exact_orientation.h>
#include <selvedge/bodies/load_mesh.h>
#include <selvedge/bodies/mannequin.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/core/parallel.h>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using std::numbers::pi;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("selvedge-bodies-" + std::to_string(::getpid()) + "-" + test->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path path(const std::string& name) const { return folder_ / name; }
  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }
  static std::string bytes_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

 private:
  fs::path folder_;
};

using MeshFile = Files;
using MeshFileFaults = Files;
using LoadMesh = Files;

// The sentence that `read` throws; empty if it throws none.
template <class Read>
std::string fault(Read&& read) {
  try {
    read();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

std::string fault_of(const fs::path& file) {
  return fault([&] { read_mesh(file); });
}

#define EXPECT_SAYS(sentence, part) \
  EXPECT_NE((sentence).find(part), std::string::npos) << "the sentence is: " << (sentence)

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

TriangleMesh tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

std::string off_text() {
  return "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
}
std::string obj_text() {
  return "# tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
}
std::string ply_text() {
  return "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty "
         "float "
         "y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
}

void expect_tetrahedron(const TriangleMesh& mesh) {
  EXPECT_TRUE(mesh.vertices == tetrahedron().vertices);
  EXPECT_EQ(mesh.triangles, tetrahedron().triangles);
}

// Values of any type in either byte order, for binary PLY.
class Bytes {
 public:
  explicit Bytes(bool big) : big_(big) {}
  template <class T>
  Bytes& add(T value) {
    auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (big_ != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
    text_.append(bytes.data(), bytes.size());
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  bool big_;
  std::string text_;
};

// ---------------------------------------------------------------- files that are right

TEST_F(MeshFile, PlyGivesBackTheSameBits) {
  const TriangleMesh mesh = awkward_mesh();
  const std::vector<NamedValues> extra{{"speed", {0.5, -0.0, 5e-324, 1.0 / 3.0, 2.0}},
                                       {"u", {1, 2, 3, 4, 5}}};
  write_ply(path("a.ply"), mesh.vertices, mesh.triangles, extra);
  const TriangleMesh back = read_mesh(path("a.ply"));
  EXPECT_TRUE(same_bits(back.vertices, mesh.vertices));
  EXPECT_EQ(back.triangles, mesh.triangles);
  std::vector<NamedValues> extra_back{{"rubbish", {1.0}}};
  EXPECT_TRUE(same_bits(read_ply(path("a.ply"), extra_back).vertices, mesh.vertices));
  ASSERT_EQ(extra_back.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(extra_back[i].name, extra[i].name);
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
  EXPECT_SAYS(fault_of(write("a.txt", "hello")), "extension '.txt' is unknown");
  EXPECT_SAYS(fault_of(write("a.off", "hello\n")), "no OFF file");
  EXPECT_SAYS(fault_of(write("a.ply", "hello\n")), "no PLY file");
  EXPECT_SAYS(fault_of(write("a.obj", "%PDF-1.4\n")), "no OBJ statement");
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
  EXPECT_SAYS(fault_of(write("e.obj", points + "f 1 2 3x\n")), "is no face corner");
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
  EXPECT_SAYS(fault_of(write("a.obj", "v 0 zero 0\n")), "'zero' stands where the y coordinate");
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
  EXPECT_SAYS(fault_of(write("c.off", "OFF\n99999999999999 1 0\n")), "cannot be");
  EXPECT_SAYS(fault_of(write("d.off", "OFF\n-4 1 0\n")), "cannot be");
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
  EXPECT_SAYS(fault_of(write("a.ply", changed("float y", "float w"))),
              "lack one of the properties");
  EXPECT_SAYS(fault_of(write("a.ply", changed("float y", "float x"))), "declared twice");
  EXPECT_SAYS(fault_of(write("a.ply", changed("uchar int", "float int"))), "floating point");
  EXPECT_SAYS(fault_of(write("a.ply", changed("uchar int", "uchar float"))), "floating point");
  EXPECT_SAYS(fault_of(write("a.ply", changed("vertex_indices", "corners"))), "vertex_indices");
  EXPECT_SAYS(fault_of(write("a.ply", changed("element face", "element fase"))), "element 'face'");
  EXPECT_SAYS(fault_of(write("a.ply", changed("end_header\n", ""))),
              "no statement of a PLY header");
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

// ---------------------------------------------------------------- loading bodies

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
  EXPECT_SAYS(sentence("kill -SEGV $$"), "broke down (signal 11)");
  EXPECT_SAYS(sentence("yes"), "more memory than the limit of 1 MiB");
  EXPECT_SAYS(sentence("printf M12345"), "gave no mesh");
  EXPECT_SAYS(sentence("printf 'Ebad\\nfile.'; exit 1"), "assimp cannot read it: bad file; ");
  EXPECT_SAYS(sentence("exit 3"), "gave no mesh (exit status 3)");
  ::setenv("SELVEDGE_ASSIMP", path("nowhere").c_str(), 1);
  EXPECT_SAYS(fault([&] { load_mesh(file); }), "cannot be started");
  ::unsetenv("SELVEDGE_ASSIMP");
}

// ---------------------------------------------------------------- analytic shapes

struct NamedShape {
  const char* name;
  AnalyticShape shape;
  double volume;
};

std::vector<NamedShape> closed_shapes() {
  return {{"box", Box{{1.0, 2.0, 0.5}}, 1.0},
          {"sphere", Sphere{0.7}, 4.0 / 3.0 * pi * 0.343},
          {"capsule", Capsule{0.3, 1.1}, pi * 0.09 * 1.1 + 4.0 / 3.0 * pi * 0.027},
          {"cylinder", Cylinder{0.4, 1.5}, pi * 0.16 * 1.5},
          {"flat cylinder", Cylinder{0.6, 0.02}, pi * 0.36 * 0.02},
          {"cone", Cone{0.5, 1.2}, pi * 0.25 * 1.2 / 3.0},
          {"torus", Torus{0.3, 0.08}, 2.0 * pi * pi * 0.3 * 0.0064}};
}

TEST(AnalyticBody, TessellationsAreClosedOutwardAndClean) {
  for (const NamedShape& s : closed_shapes())
    for (const int resolution : {3, 4, 5, 7, 8, 16, 33, 64}) {
      const MeshReport report = report_mesh(tessellate(s.shape, resolution));
      EXPECT_TRUE(report.sentences().empty())
          << s.name << " at " << resolution << ": " << report.sentences()[0];
      EXPECT_EQ(report.components, 1u) << s.name;
    }
}

TEST(AnalyticBody, VerticesLieOnTheShapeAndFacesWithinTheStatedDistance) {
  for (const NamedShape& s : closed_shapes())
    for (const int resolution : {3, 8, 24, 48}) {
      const TriangleMesh mesh = tessellate(s.shape, resolution);
      for (const Vec3& x : mesh.vertices)
        ASSERT_NEAR(signed_distance(s.shape, x), 0.0, 1e-15) << s.name;
      if (std::holds_alternative<Torus>(s.shape)) continue;  // curved both ways
      const double radius = s.shape.index() == 2 ? 0.7 : 0.6;
      const double allowed = radius * (1.0 - std::cos(pi / resolution)) + 1e-15;
      for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        for (int i = 0; i <= 6; ++i)
          for (int j = 0; i + j <= 6; ++j) {
            const double d = signed_distance(s.shape, ((6 - i - j) * a + i * b + j * c) / 6.0);
            ASSERT_LE(d, 1e-15) << s.name << " at " << resolution;
            ASSERT_GE(d, -allowed) << s.name << " at " << resolution;
          }
      }
    }
}

TEST(AnalyticBody, VolumesConvergeWithTheSquareOfTheResolution) {
  for (const NamedShape& s : closed_shapes()) {
    const double coarse = s.volume - report_mesh(tessellate(s.shape, 24)).volume;
    const double fine = s.volume - report_mesh(tessellate(s.shape, 96)).volume;
    if (std::holds_alternative<Box>(s.shape)) {
      EXPECT_NEAR(coarse, 0.0, 1e-14);
      continue;
    }
    EXPECT_GT(fine, 0.0) << s.name;
    EXPECT_LT(fine, 0.005 * s.volume) << s.name;
    EXPECT_NEAR(std::log2(coarse / fine) / 2.0, 2.0, 0.25) << s.name;
  }
}

// Distance to a mesh by brute force, signed by the winding number.
double mesh_distance(const TriangleMesh& mesh, const Vec3& p) {
  double square = std::numeric_limits<double>::infinity(), angle = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p,
               c = mesh.vertices[t[2]] - p;
    const Vec3 n = (b - a).cross(c - a);
    const double u = n.dot(b.cross(c)), v = n.dot(c.cross(a)), w = n.dot(a.cross(b));
    if (u >= 0.0 && v >= 0.0 && w >= 0.0)
      square = std::min(square, std::pow(a.dot(n), 2) / n.squaredNorm());
    for (const auto& [x, y] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
      const double s = std::clamp(-x.dot(y - x) / (y - x).squaredNorm(), 0.0, 1.0);
      square = std::min(square, (x + s * (y - x)).squaredNorm());
    }
    // [VanOosterom1983] solid angle of a triangle.
    angle +=
        2.0 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                                b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return angle > 2.0 * pi ? -std::sqrt(square) : std::sqrt(square);
}

TEST(AnalyticBody, SignedDistancesAgreeWithTheTessellation) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1.2, 1.2);
  for (const NamedShape& s : closed_shapes()) {
    const TriangleMesh mesh = tessellate(s.shape, 64);
    for (int i = 0; i < 60; ++i) {
      const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
      EXPECT_NEAR(signed_distance(s.shape, p), mesh_distance(mesh, p), 2e-3)
          << s.name << " at " << p.transpose();
    }
  }
}

TEST(AnalyticBody, SpecialPointsHaveTheirExactDistances) {
  EXPECT_EQ(signed_distance(Plane{}, {3, 4, -2}), -2.0);
  EXPECT_EQ(signed_distance(Box{{2, 2, 2}}, {0, 0, 0}), -1.0);
  EXPECT_EQ(signed_distance(Box{{2, 2, 2}}, {4, 5, 0}), 5.0);
  EXPECT_EQ(signed_distance(Capsule{0.5, 2.0}, {0, 0, 3}), 1.5);
  EXPECT_EQ(signed_distance(Cylinder{1.0, 2.0}, {0, 0, 0}), -1.0);
  EXPECT_EQ(signed_distance(Cone{1.0, 1.0}, {0, 0, 2}), 1.5);
  EXPECT_EQ(signed_distance(Cone{1.0, 1.0}, {0, 0, -2}), 1.5);
  EXPECT_EQ(signed_distance(Cone{1.0, 1.0}, {3, 0, -0.5}), 2.0);
  EXPECT_EQ(signed_distance(Torus{1.0, 0.25}, {0, 0, 0}), 0.75);
  EXPECT_EQ(signed_distance(Torus{1.0, 0.25}, {0, 1, 0}), -0.25);
}

TEST(AnalyticBody, TrianglesAreWellShaped) {
  for (const NamedShape& s : closed_shapes()) {
    if (std::holds_alternative<Box>(s.shape)) continue;
    const TriangleMesh mesh = tessellate(s.shape, 48);
    double least = 1.0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 e0 = mesh.vertices[t[1]] - mesh.vertices[t[0]];
      const Vec3 e1 = mesh.vertices[t[2]] - mesh.vertices[t[1]];
      const Vec3 e2 = mesh.vertices[t[0]] - mesh.vertices[t[2]];
      const double edges = e0.squaredNorm() + e1.squaredNorm() + e2.squaredNorm();
      least = std::min(least, 2.0 * std::sqrt(3.0) * e0.cross(e1).norm() / edges);
    }
    EXPECT_GT(least, 0.3) << s.name;  // 1: equilateral; 0.4: right-angled, four times as long
  }
}

TEST(AnalyticBody, ImpossibleSizesAreRefused) {
  EXPECT_SAYS(fault([] { tessellate(Sphere{0.0}, 16); }), "radius of a sphere");
  EXPECT_SAYS(fault([] { tessellate(Box{{1, -1, 1}}, 16); }), "size of a box");
  EXPECT_SAYS(fault([] { tessellate(Cone{0.5, NAN}, 16); }), "height of a cone");
  EXPECT_SAYS(fault([] { tessellate(Torus{0.1, 0.2}, 16); }), "smaller than its radius");
  EXPECT_SAYS(fault([] { tessellate(Sphere{}, 2); }), "resolution");
  EXPECT_SAYS(fault([] { tessellate(Sphere{}, 1000000); }), "resolution");
}

// ---------------------------------------------------------------- moving bodies

std::vector<Vec3> positions(const Body& body, double time) {
  std::vector<Vec3> x(body.vertex_count());
  body.positions(time, x);
  return x;
}

TEST(MovingBody, AStaticBodyStays) {
  const auto body = make_static_body(tetrahedron());
  EXPECT_TRUE(same_bits(positions(*body, 7.0), tetrahedron().vertices));
  EXPECT_TRUE(body->is_static(-1e9, 1e9));
  EXPECT_EQ(body->triangles(), tetrahedron().triangles);
}

Eigen::Quaterniond about_z(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
}

TEST(MovingBody, KeyframesTurnEvenlyAndHoldAtTheEnds) {
  const auto body = make_keyframed_body(
      tetrahedron(), {{1.0, {0, 0, 0}, about_z(0.0)}, {3.0, {0, 0, 4}, about_z(pi / 2)}});
  EXPECT_TRUE(same_bits(positions(*body, 0.0), tetrahedron().vertices));
  EXPECT_TRUE(
      positions(*body, 1.5)[1].isApprox(Vec3(std::cos(pi / 8), std::sin(pi / 8), 1.0), 1e-14));
  EXPECT_TRUE(positions(*body, 99.0)[1].isApprox(Vec3(0, 1, 4), 1e-14));
  EXPECT_TRUE(body->is_static(-5.0, 1.0));
  EXPECT_TRUE(body->is_static(3.0, 5.0));
  EXPECT_FALSE(body->is_static(0.9, 1.1));
}

TEST(MovingBody, EqualKeyframesAreStaticToTheBit) {
  Eigen::Quaterniond turned = about_z(0.7), negative = turned;
  negative.coeffs() *= -1.0;
  const Vec3 place(0.1, 0.2, 0.3);
  const auto body = make_keyframed_body(
      tetrahedron(), {{0.0, place, turned}, {1.0, place, negative}, {2.0, Vec3::Zero(), turned}});
  EXPECT_TRUE(body->is_static(0.0, 1.0));
  EXPECT_FALSE(body->is_static(0.5, 1.5));
  for (const double time : {0.1, 0.37, 1.0})
    EXPECT_TRUE(same_bits(positions(*body, time), positions(*body, 0.0)));
}

TEST(MovingBody, ASequenceIsLinearBetweenItsFrames) {
  std::vector<TriangleMesh> frames(4, tetrahedron());
  for (Vec3& x : frames[2].vertices) x.z() += 1.0;
  frames[3] = frames[2];
  const auto body = make_sequence_body(frames, 10.0, 5.0);
  EXPECT_TRUE(same_bits(positions(*body, 0.0), frames[0].vertices));
  EXPECT_TRUE(same_bits(positions(*body, 5.05), frames[0].vertices));
  EXPECT_NEAR(positions(*body, 5.125)[3].z(), 1.25, 1e-12);
  EXPECT_TRUE(same_bits(positions(*body, 99.0), frames[3].vertices));
  EXPECT_TRUE(body->is_static(0.0, 5.1));
  EXPECT_FALSE(body->is_static(5.05, 5.15));
  EXPECT_TRUE(body->is_static(5.2, 9.0));
  EXPECT_TRUE(body->is_static(5.3, 5.3));
}

TEST(MovingBody, ImpossibleMotionsAreRefused) {
  EXPECT_SAYS(fault([] { make_keyframed_body(tetrahedron(), {}); }), "at least one keyframe");
  EXPECT_SAYS(fault([] { make_keyframed_body(tetrahedron(), {{1.0}, {1.0}}); }), "keyframe 1");
  EXPECT_SAYS(fault([] { make_keyframed_body(tetrahedron(), {{NAN}}); }), "not finite");
  EXPECT_SAYS(
      fault([] {
        make_keyframed_body(tetrahedron(), {{0.0, Vec3::Zero(), Eigen::Quaterniond(0, 0, 0, 0)}});
      }),
      "rotation 0");
  EXPECT_SAYS(fault([] { make_sequence_body({}, 10.0, 0.0); }), "at least one frame");
  EXPECT_SAYS(fault([] { make_sequence_body({tetrahedron()}, 0.0, 0.0); }), "frames per second");
  TriangleMesh other = tetrahedron();
  std::swap(other.triangles[0], other.triangles[1]);
  EXPECT_SAYS(fault([&] { make_sequence_body({tetrahedron(), other}, 1.0, 0.0); }), "frame 1");
  TriangleMesh bad = tetrahedron();
  bad.triangles[2] = {0, 0, 1};
  EXPECT_SAYS(fault([&] { make_static_body(bad); }), "triangle 2");
}

// ---------------------------------------------------------------- report

TEST(MeshReport, ACleanMeshHasNoSentence) {
  const MeshReport report = report_mesh(tetrahedron());
  EXPECT_TRUE(report.closed());
  EXPECT_TRUE(report.sentences().empty());
  EXPECT_EQ(report.components, 1u);
  EXPECT_NEAR(report.volume, 1.0 / 6.0, 1e-15);
}

TEST(MeshReport, EveryFaultIsCounted) {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.pop_back();
  EXPECT_EQ(report_mesh(mesh).boundary_edges, 3u);
  mesh = tetrahedron();
  std::swap(mesh.triangles[2][0], mesh.triangles[2][1]);
  EXPECT_EQ(report_mesh(mesh).inconsistent_edges, 3u);
  mesh = tetrahedron();
  mesh.triangles.push_back({1, 0, 2});
  EXPECT_EQ(report_mesh(mesh).duplicate_faces, 1u);
  EXPECT_EQ(report_mesh(mesh).non_manifold_edges, 3u);
  mesh = tetrahedron();
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(report_mesh(mesh).inward_components, 1u);
  mesh = tetrahedron();
  mesh.vertices.push_back({1, 0, 0});
  mesh.triangles.push_back({0, 0, 1});
  EXPECT_EQ(report_mesh(mesh).duplicate_vertices, 1u);
  EXPECT_EQ(report_mesh(mesh).unused_vertices, 1u);
  EXPECT_EQ(report_mesh(mesh).zero_area_faces, 1u);
  EXPECT_EQ(report_mesh(mesh).components, 1u);
  EXPECT_EQ(report_mesh(mesh).sentences().size(), 3u);
  EXPECT_THROW(report_mesh({{{0, 0, 0}}, {{0, 0, 7}}}), std::invalid_argument);
  EXPECT_THROW(report_mesh({{{NAN, 0, 0}}, {}}), std::invalid_argument);
}

TriangleMesh two_triangles(const std::array<Vec3, 6>& x) {
  return {{x.begin(), x.end()}, {{0, 1, 2}, {3, 4, 5}}};
}

std::size_t crossings(const std::array<Vec3, 6>& x) {
  return report_mesh(two_triangles(x)).self_intersections;
}

TEST(MeshReport, PairsOfTrianglesAreJudgedExactly) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const double e = std::numeric_limits<double>::epsilon();
  // Through the middle, beside it, touching with a tip, and missing by the last bit.
  EXPECT_EQ(crossings({a, b, c, {0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.3, 0.3, 1}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.8, 0.8, -1}, {0.8, 0.8, 1}, {0.9, 0.9, 1}}), 0u);
  EXPECT_EQ(crossings({a, b, c, {0.25, 0.25, 0}, {0.2, 0.2, 1}, {0.3, 0.3, 1}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.25, 0.25, 5e-324}, {0.2, 0.2, 1}, {0.3, 0.3, 1}}), 0u);
  EXPECT_EQ(crossings({a, b, c, {0.5, 0.5, 0}, {1, 1, 1}, {1, 1, 0}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.5 + e, 0.5, 0}, {1, 1, 1}, {1, 1, 0}}), 0u);
  // In one plane: overlapping, one inside the other, apart.
  EXPECT_EQ(crossings({a, b, c, {0.4, 0.4, 0}, {1.4, 0.4, 0}, {0.4, 1.4, 0}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.1, 0.1, 0}, {0.2, 0.1, 0}, {0.1, 0.2, 0}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.6, 0.6, 0}, {1.6, 0.6, 0}, {0.6, 1.6, 0}}), 0u);
  // Without area: judged by its edge; sharing a position: a neighbour.
  EXPECT_EQ(crossings({a, b, c, {0.2, 0.2, -1}, {0.2, 0.2, 0.5}, {0.2, 0.2, 1}}), 1u);
  EXPECT_EQ(crossings({a, b, c, a, {0.2, 0.2, 1}, {0.3, 0.3, 1}}), 0u);
}

__extension__ using Int128 = __int128;

int sign_of(Int128 value) { return (value > 0) - (value < 0); }

// Integer points in one plane, or off it by 1, so far out that double arithmetic cannot tell: the
// terms of the determinant reach 2^92 and differ by 2^37. 128-bit integers can.
TEST(ExactOrientation, SignsAreRightWhereDoublesCannotTell) {
  std::mt19937_64 random(3);
  const auto below = [&](int bits) {
    return static_cast<std::int64_t>(random() >> (63 - bits)) - (std::int64_t{1} << bits);
  };
  int zeros = 0;
  for (int round = 0; round < 3000; ++round) {
    std::array<std::int64_t, 3> u, v, w, d;
    const std::int64_t i = below(18), j = below(18);
    for (int k = 0; k < 3; ++k) {
      u[k] = below(18), v[k] = below(18), d[k] = below(30);
      w[k] = i * u[k] + j * v[k];
    }
    w[round % 3] += round % 5 - 2;
    const auto minor = [&](int a, int b) { return Int128(v[a]) * w[b] - Int128(v[b]) * w[a]; };
    const int expected = sign_of(u[0] * minor(1, 2) + u[1] * minor(2, 0) + u[2] * minor(0, 1));
    Vec3 p[4];
    for (int k = 0; k < 3; ++k) {
      p[0][k] = static_cast<double>(u[k] + d[k]);
      p[1][k] = static_cast<double>(v[k] + d[k]);
      p[2][k] = static_cast<double>(w[k] + d[k]);
      p[3][k] = static_cast<double>(d[k]);
    }
    ASSERT_EQ(detail::orientation(p[0], p[1], p[2], p[3]), expected) << "round " << round;
    ASSERT_EQ(detail::orientation(p[1], p[0], p[2], p[3]), -expected) << "round " << round;
    zeros += expected == 0;
    // In the plane: (n, n+1) × (nm + s, (n+1)m + s) = -s, a difference of terms near 2^76.
    const std::int64_t n = below(25), m = below(25), s = round % 3 - 1;
    const Vec3 q[2] = {{0.0, static_cast<double>(n), static_cast<double>(n + 1)},
                       {0.0, static_cast<double>(n * m + s), static_cast<double>((n + 1) * m + s)}};
    ASSERT_EQ(detail::orientation(q[0], q[1], Vec3::Zero(), 0), -s) << "round " << round;
  }
  EXPECT_GT(zeros, 300);
}

// Coordinates on a coarse lattice make every degenerate case common; the judgement must not change
// when the corners are permuted or the axes are turned.
TEST(MeshReport, DegeneratePairsAreJudgedTheSameInEveryOrder) {
  std::mt19937 random(11);
  std::size_t met = 0;
  for (int round = 0; round < 4000; ++round) {
    std::array<Vec3, 6> x;
    for (Vec3& p : x)
      p = Vec3(static_cast<int>(random() % 4), static_cast<int>(random() % 4),
               static_cast<int>(random() % 4));
    const std::size_t expected = crossings(x);
    met += expected;
    ASSERT_EQ(expected, crossings({x[4], x[3], x[5], x[1], x[2], x[0]})) << "round " << round;
    for (Vec3& p : x) p = Vec3(p.y(), p.z(), p.x()) * 0.25 + Vec3(0.5, 0.25, 0.125);
    ASSERT_EQ(expected, crossings(x)) << "round " << round;
  }
  EXPECT_GT(met, 400u);
}

TEST(MeshReport, TwoLinkedTubesThatPassThroughEachOtherAreFound) {
  TriangleMesh mesh = tessellate(Torus{0.3, 0.05}, 32);
  EXPECT_EQ(report_mesh(mesh).self_intersections, 0u);
  TriangleMesh second = mesh;
  const auto n = static_cast<std::int32_t>(mesh.vertices.size());
  for (const Vec3& x : second.vertices)
    mesh.vertices.push_back(Vec3(x.x(), x.z(), x.y()) + Vec3(0.3, 0, 0));
  for (const Triangle& t : second.triangles)
    mesh.triangles.push_back({t[0] + n, t[2] + n, t[1] + n});
  EXPECT_EQ(report_mesh(mesh).self_intersections, 0u);  // linked, not touching
  EXPECT_EQ(report_mesh(mesh).components, 2u);
  for (std::size_t i = n; i < mesh.vertices.size(); ++i) mesh.vertices[i].x() += 0.3;
  const std::size_t found = report_mesh(mesh).self_intersections;
  EXPECT_GT(found, 20u);
  const ThreadLimit one(1);
  EXPECT_EQ(report_mesh(mesh).self_intersections, found);
}

fs::path fetched(const std::string& name) {
  return fs::path(SELVEDGE_SOURCE_DIR) / "data" / "fetched" / name;
}

TEST(MeshReport, DebiansHomerIsClean) {
  if (!fs::exists(fetched("homer.off"))) GTEST_SKIP() << "run scripts/fetch_bodies.sh first";
  const MeshReport report = report_mesh(read_mesh(fetched("homer.off")));
  EXPECT_EQ(report.triangles, 9856u);
  EXPECT_TRUE(report.sentences().empty());
}

TEST(MeshReport, DebiansManCrossesItself) {
  if (!fs::exists(fetched("man.off"))) GTEST_SKIP() << "run scripts/fetch_bodies.sh first";
  const MeshReport report = report_mesh(read_mesh(fetched("man.off")));
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.self_intersections, 788u);
  EXPECT_EQ(report.folded_neighbours, 60u);  // together CGAL's count of 848
}

// ---------------------------------------------------------------- mannequin

TEST(Mannequin, IsClosedCleanAndOfAdultSize) {
  const TriangleMesh mesh = make_mannequin();
  const MeshReport report = report_mesh(mesh);
  EXPECT_TRUE(report.sentences().empty());
  EXPECT_EQ(report.components, 1u);
  EXPECT_EQ(static_cast<int>(report.vertices) - static_cast<int>(report.triangles) / 2, 2);
  EXPECT_NEAR(static_cast<double>(report.triangles), 10000.0, 2.0);
  EXPECT_EQ(report.lower.z(), 0.0);
  EXPECT_NEAR(report.upper.z(), 1.7, 0.01);
  EXPECT_GT(report.volume, 0.045);  // an adult of this height has 50 to 75 litres
  EXPECT_LT(report.volume, 0.08);

  // The file in the repository. Sines and cosines of other C libraries may differ in the last bit,
  // so the shape is compared.
  const TriangleMesh file =
      read_mesh(fs::path(SELVEDGE_SOURCE_DIR) / "data" / "bodies" / "mannequin.ply");
  EXPECT_TRUE(report_mesh(file).sentences().empty());
  EXPECT_EQ(file.triangles.size(), mesh.triangles.size());
  EXPECT_NEAR(report_mesh(file).volume, report.volume, 1e-6);
}

TEST(Mannequin, FacesHeightAndPoseAreSettable) {
  MannequinConfig config;
  config.faces = 5000;
  config.height = 0.85;
  config.left = {.shoulder_swing = -0.4, .elbow = 0.4, .hip_swing = 0.5, .knee = 0.3};
  config.right = {.shoulder_swing = 0.5, .elbow = 0.7, .hip_swing = -0.35, .knee = 0.4};
  const MeshReport report = report_mesh(make_mannequin(config));
  EXPECT_TRUE(report.sentences().empty());
  EXPECT_NEAR(static_cast<double>(report.triangles), 5000.0, 2.0);
  EXPECT_EQ(report.lower.z(), 0.0);
  EXPECT_LT(report.upper.z(), 0.86);
}

TEST(Mannequin, TheSameConfigurationGivesTheSameBits) {
  MannequinConfig config;
  config.faces = 5000;
  const TriangleMesh many = make_mannequin(config);
  const ThreadLimit one(1);
  const TriangleMesh single = make_mannequin(config);
  EXPECT_TRUE(same_bits(many.vertices, single.vertices));
  EXPECT_EQ(many.triangles, single.triangles);
}

TEST(Mannequin, PosesOutsideTheirRangesAreRefused) {
  EXPECT_SAYS(fault([] { make_mannequin({.faces = 100}); }), "faces");
  EXPECT_SAYS(fault([] { make_mannequin({.height = NAN}); }), "height");
  MannequinConfig config;
  config.left.knee = -1.0;
  EXPECT_SAYS(fault([&] { make_mannequin(config); }), "knee");
}

}  // namespace
}  // namespace selvedge
