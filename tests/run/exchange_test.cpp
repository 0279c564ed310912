// SPDX-License-Identifier: MIT
// Files for other programs, read by independent readers: glTF, USD, MDD.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/run/detail/spool_file.h>
#include <selvedge/run/frame_writer.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace selvedge::exchange_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Three frames of a square cloth above a moving triangle, as a run passes them on.
class Exchange : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("selvedge_exchange_" + std::to_string(getpid()));
    fs::create_directories(folder_ / "frames");
    for (int f = 0; f < kFrames; ++f) {
      std::vector<Vec3>&x = cloth_.emplace_back(), &b = bodies_.emplace_back();
      for (int i = 0; i < 4; ++i) {
        const double side = i % 2, other = i / 2;
        x.emplace_back(side + 0.1 * f, other - 1.0 / 3.0, 0.2 + 0.05 * f * f * side);
        if (i < 3) b.emplace_back(3.0 * side - 1.0, 3.0 * other - 1.0, 0.01 * f);
      }
    }
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// A frame of two pieces and two bodies, with values: each triangle of the cloth is a piece.
  Frame frame_of_parts(int f) const {
    return {.number = f,
            .time = f / kFps,
            .x = parts_[f],
            .v = {},
            .triangles = kParts,
            .values = values_,
            .bodies = boxes_,
            .body_triangles = kBoxes,
            .pieces = kPieces,
            .body_parts = kBodyParts,
            .texture = kTexture};
  }

  void write_parts(const std::string& format) {
    values_ = {{"flag", {0, 4, 0, 0, 0, 0, 0}, true}, {"pressure", {0, 1.5, 0, 0, 2, 0, 0}}};
    for (int f = 0; f < kFrames; ++f) {
      parts_.push_back(
          {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
      for (Vec3& x : parts_.back()) x.z() += 0.1 * f;
    }
    const auto writer = frame_formats().at(format)(folder_);
    for (int f = 0; f < kFrames; ++f) writer->write(frame_of_parts(f));
    writer->finish();
  }

  void write(const std::string& format, bool moving = true) const {
    const FrameFormatRegistry formats = frame_formats();
    const auto writer = formats.at(format)(folder_);
    for (int f = 0; f < kFrames; ++f) {
      const bool due = f == 0 || moving;
      writer->write({.number = f,
                     .time = f / kFps,
                     .x = cloth_[f],
                     .v = {},
                     .triangles = kCloth,
                     .values = {},
                     .bodies = due ? std::span<const Vec3>(bodies_[f]) : std::span<const Vec3>(),
                     .body_triangles = kBody});
      writer->update_series();
    }
    writer->finish();
  }

  static constexpr int kFrames = 3;
  static constexpr double kFps = 30.0;
  const std::vector<Triangle> kCloth = {{0, 1, 3}, {0, 3, 2}}, kBody = {{0, 1, 2}};
  std::vector<std::vector<Vec3>> cloth_, bodies_;

  const std::vector<Triangle> kParts = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}};
  // Two triangles with a right angle between them, and one alone.
  const std::vector<Triangle> kBoxes = {{0, 1, 2}, {0, 3, 1}, {4, 5, 6}};
  const std::vector<Vec3> boxes_ = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1},
                                    {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  const std::vector<FramePart> kPieces = {{"front piece", 0, 4, {0.5, 0.25, 0.125}},
                                          {"back", 4, 3, {0.0, 0.0, 1.0}}};
  const std::vector<FramePart> kBodyParts = {{"wedge", 0, 4, {}}, {"back", 4, 3, {}}};
  // Vertex 2 of the front has two places; the back has none.
  const std::vector<std::array<TexturePoint, 3>> kTexture = {
      {{{0, 0}, {1, 0}, {1, 1}}}, {{{0, 0}, {0.5, 1}, {0, 1}}}, {{{std::nan(""), 0}, {}, {}}}};
  std::vector<std::vector<Vec3>> parts_;
  std::vector<NamedValues> values_;
  fs::path folder_;
};

void expect_near(const std::vector<Vec3>& found, const std::vector<Vec3>& wanted) {
  constexpr double float_error = 1e-6;  // m
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_LE((found[i] - wanted[i]).norm(), float_error) << i;
}

// -- glTF -----------------------------------------------------------------------------------------

/// A .glb file by the text of the specification.
class GlbFile {
 public:
  explicit GlbFile(const fs::path& file) {
    const std::string bytes = content(file);
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(number(bytes, 4), 2u);
    EXPECT_EQ(number(bytes, 8), bytes.size());
    const std::uint32_t length = number(bytes, 12);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    EXPECT_EQ(length % 4, 0u);
    json = Json::parse(bytes.substr(20, length));
    const std::size_t chunk = 20 + length;
    EXPECT_EQ(bytes.substr(chunk + 4, 4), std::string("BIN\0", 4));
    EXPECT_EQ(chunk + 8 + number(bytes, chunk), bytes.size());
    binary_ = bytes.substr(chunk + 8);
    EXPECT_EQ(json["buffers"][0]["byteLength"], binary_.size());
  }

  template <class Number>
  std::vector<Number> values(int accessor) const {
    const Json& a = json["accessors"][accessor];
    const Json& view = json["bufferViews"][a["bufferView"].get<int>()];
    const std::size_t components = a["type"] == "VEC3" ? 3 : a["type"] == "VEC2" ? 2 : 1;
    EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0u);
    std::vector<Number> list(a["count"].get<std::size_t>() * components);
    EXPECT_EQ(view["byteLength"], list.size() * sizeof(Number));
    std::memcpy(list.data(), binary_.data() + view["byteOffset"].get<std::size_t>(),
                list.size() * sizeof(Number));
    if (a.contains("min"))
      for (std::size_t i = 0; i < list.size(); ++i) {
        EXPECT_GE(list[i], a["min"][i % components].get<Number>());
        EXPECT_LE(list[i], a["max"][i % components].get<Number>());
      }
    return list;
  }

  /// Positions of a node at the time of a frame, turned to z up.
  std::vector<Vec3> at(int node, int frame) const {
    const Json& mesh = json["meshes"][json["nodes"][node]["mesh"].get<int>()];
    const Json& primitive = mesh["primitives"][0];
    std::vector<float> x = values<float>(primitive["attributes"]["POSITION"]);
    for (const Json& channel : json.at("animations")[0]["channels"]) {
      if (channel["target"]["node"] != node) continue;
      const Json& sampler = json["animations"][0]["samplers"][channel["sampler"].get<int>()];
      const std::vector<float> weights = values<float>(sampler["output"]);
      const std::size_t targets = primitive["targets"].size();
      for (std::size_t i = 0; i < targets; ++i) {
        const std::vector<float> d = values<float>(primitive["targets"][i]["POSITION"]);
        for (std::size_t k = 0; k < x.size(); ++k) x[k] += weights[frame * targets + i] * d[k];
      }
    }
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < x.size(); i += 3) points.emplace_back(x[i], -x[i + 2], x[i + 1]);
    return points;
  }

  Json json;

 private:
  static std::uint32_t number(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  }
  std::string binary_;
};

TEST_F(Exchange, EveryGltfFrameHasThePositionsOfClothAndBodies) {
  write("gltf");
  const GlbFile file(folder_ / "result.glb");
  ASSERT_EQ(file.json["nodes"].size(), 2u);
  for (int f = 0; f < kFrames; ++f) {
    expect_near(file.at(0, f), cloth_[f]);
    expect_near(file.at(1, f), bodies_[f]);
  }
  const int indices = file.json["meshes"][0]["primitives"][0]["indices"];
  EXPECT_EQ(file.values<std::uint32_t>(indices), (std::vector<std::uint32_t>{0, 1, 3, 0, 3, 2}));
  const auto times = file.values<float>(file.json["animations"][0]["samplers"][0]["input"]);
  EXPECT_EQ(times, (std::vector<float>{0.0F, float(1 / kFps), float(2 / kFps)}));
}

TEST_F(Exchange, EachPieceAndBodyIsAGltfMeshOfItsOwn) {
  write_parts("gltf");
  const GlbFile file(folder_ / "result.glb");
  std::vector<std::string> names;
  for (const Json& node : file.json["nodes"]) names.push_back(node["name"]);
  EXPECT_EQ(names, (std::vector<std::string>{"front piece", "back", "wedge", "back"}));
  const auto attribute = [&](int mesh, const char* name) {
    return file.values<float>(file.json["meshes"][mesh]["primitives"][0]["attributes"].at(name));
  };
  EXPECT_EQ(attribute(0, "TEXCOORD_0"), (std::vector<float>{0, 1, 1, 1, 0.5F, 0, 1, 0, 0, 0}));
  EXPECT_EQ(attribute(0, "_FLAG"), (std::vector<float>{0, 4, 0, 0, 0}));
  EXPECT_EQ(attribute(0, "_PRESSURE"), (std::vector<float>{0, 1.5F, 0, 0, 0}));
  EXPECT_EQ(attribute(1, "_PRESSURE"), (std::vector<float>{2, 0, 0}));
  EXPECT_EQ(attribute(1, "NORMAL"), (std::vector<float>{0, 1, 0, 0, 1, 0, 0, 1, 0}));
  EXPECT_FALSE(file.json["meshes"][1]["primitives"][0]["attributes"].contains("TEXCOORD_0"));
  EXPECT_EQ(file.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"],
            Json({0.5, 0.25, 0.125, 1.0}));
  EXPECT_EQ(attribute(2, "POSITION").size(), 3u * 6) << "the edge of the wedge is sharp";
  EXPECT_FALSE(file.json["meshes"][3]["primitives"][0].contains("targets")) << "it rests";
  expect_near(file.at(1, 2), {parts_[2].begin() + 4, parts_[2].end()});
}

TEST_F(Exchange, BodiesAtRestHaveNoAnimationInTheGltfFile) {
  write("gltf", false);
  const GlbFile file(folder_ / "result.glb");
  EXPECT_FALSE(file.json["meshes"][1]["primitives"][0].contains("targets"));
  EXPECT_EQ(file.json["animations"][0]["channels"].size(), 1u);
  expect_near(file.at(1, 2), bodies_[0]);
}

#ifdef SELVEDGE_HAS_ASSIMP
TEST_F(Exchange, AssimpReadsTheGltfFile) {
  write("gltf");
  const TriangleMesh mesh = load_mesh(folder_ / "result.glb", {.up = UpAxis::y, .weld = false});
  EXPECT_EQ(mesh.triangles.size(), kCloth.size() + kBody.size());
  for (const Vec3& x : cloth_[0])
    EXPECT_TRUE(std::any_of(mesh.vertices.begin(), mesh.vertices.end(), [&](const Vec3& y) {
      return (x - y).norm() < 1e-6;
    })) << x.transpose();
}
#endif

// -- USD ------------------------------------------------------------------------------------------

/// The text between `open` and `close` after `start`.
std::string between(const std::string& text, const std::string& start, const std::string& open,
                    const std::string& close) {
  const auto at = text.find(open, text.find(start)) + open.size();
  return text.substr(at, text.find(close, at) - at);
}

/// All numbers in a text.
std::vector<double> numbers(std::string text) {
  for (char& c : text)
    if (std::string("0123456789.+-e").find(c) == std::string::npos) c = ' ';
  std::istringstream in(text);
  std::vector<double> list;
  for (double value = 0.0; in >> value;) list.push_back(value);
  return list;
}

TEST_F(Exchange, EveryTimeSampleOfTheUsdStageHasThePositions) {
  write("usd");
  const std::string text = content(folder_ / "result.usda");
  EXPECT_EQ(text.substr(0, 10), "#usda 1.0\n");
  for (const char* said : {"upAxis = \"Z\"", "metersPerUnit = 1\n", "timeCodesPerSecond = 30\n",
                           "startTimeCode = 0\n", "endTimeCode = 2\n"})
    EXPECT_NE(text.find(said), std::string::npos) << said;
  for (const auto& [name, x] :
       {std::pair{"def Mesh \"cloth\"", &cloth_}, {"def Mesh \"bodies\"", &bodies_}}) {
    const std::string prim = text.substr(text.find(name));
    const std::string samples = between(prim, "points.timeSamples", "{", "}");
    for (int f = 0; f < kFrames; ++f) {
      const auto line =
          numbers(between(samples, "\n            " + std::to_string(f) + ":", "[", "]"));
      std::vector<Vec3> points;
      for (std::size_t i = 0; i + 2 < line.size(); i += 3)
        points.emplace_back(line[i], line[i + 1], line[i + 2]);
      expect_near(points, (*x)[f]);
    }
  }
  EXPECT_EQ(numbers(between(text, "faceVertexIndices", "[", "]")),
            (std::vector<double>{0, 1, 3, 0, 3, 2}));
  EXPECT_EQ(std::count(text.begin(), text.end(), '{'), std::count(text.begin(), text.end(), '}'));
}

TEST_F(Exchange, EachPieceAndBodyIsAUsdMeshOfItsOwn) {
  write_parts("usd");
  const std::string text = content(folder_ / "result.usda");
  for (const char* said :
       {"def Mesh \"front_piece\"", "string name = \"front piece\"", "def Mesh \"back\"",
        "def Mesh \"wedge\"", "def Mesh \"back_\"", "primvars:displayColor = [(0.5, 0.25, 0.125)]"})
    EXPECT_NE(text.find(said), std::string::npos) << said;
  const std::string front = between(text, "def Mesh \"front_piece\"", "{\n", "def Mesh");
  EXPECT_EQ(numbers(between(front, "primvars:st", "[(", "]")),
            (std::vector<double>{0, 0, 1, 0, 0.5, 1, 1, 1, 0, 1}));
  EXPECT_EQ(numbers(between(front, "primvars:pressure.timeSamples", "2: [", "]")),
            (std::vector<double>{0, 1.5, 0, 0, 0}));
  EXPECT_EQ(numbers(between(front, "normals.timeSamples", "0: [", ")")),
            (std::vector<double>{0, 0, 1}));
}

TEST_F(Exchange, ABodyThatRestsBeforeItMovesDoesNotDriftMeanwhile) {
  for (const char* format : {"gltf", "usd"}) {
    const auto writer = frame_formats().at(format)(folder_);
    for (int f = 0; f < 4; ++f) {
      std::vector<Vec3> body = bodies_[0];
      if (f == 3) body[0].x() += 1.0;
      writer->write({.number = f,
                     .time = f / kFps,
                     .x = cloth_[0],
                     .v = {},
                     .triangles = kCloth,
                     .values = {},
                     .bodies = body,
                     .body_triangles = kBody});
    }
    writer->finish();
  }
  const GlbFile file(folder_ / "result.glb");
  expect_near(file.at(1, 2), bodies_[0]);
  EXPECT_NEAR(file.at(1, 3)[0].x(), bodies_[0][0].x() + 1.0, 1e-6);
  const std::string text = content(folder_ / "result.usda");
  const std::string samples =
      between(text.substr(text.find("def Mesh \"bodies\"")), "points.timeSamples", "{", "}");
  EXPECT_EQ(std::count(samples.begin(), samples.end(), ':'), 3) << samples;
  EXPECT_EQ(between(samples, " 2:", "[", "]"), between(samples, " 0:", "[", "]"));
}

TEST_F(Exchange, EachPieceAndBodyIsAnObjectOfTheObjFile) {
  write_parts("obj");
  const std::string text = content(folder_ / "frames" / "cloth_00002.obj");
  EXPECT_NE(text.find("o front_piece\nusemtl front_piece\n"), std::string::npos) << text;
  EXPECT_NE(text.find("o back\n"), std::string::npos);
  EXPECT_NE(text.find("\nf 1/1/1 2/2/2 3/4/4\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nf 5//6 6//7 7//8\n"), std::string::npos) << text;
  EXPECT_NE(content(folder_ / "frames" / "cloth.mtl").find("newmtl back\nKd 0 0 1\n"),
            std::string::npos);
  const TriangleMesh mesh = read_mesh(folder_ / "frames" / "cloth_00002.obj");
  EXPECT_EQ(mesh.vertices, parts_[2]);
  EXPECT_EQ(mesh.triangles, kParts);
}

// -- MDD ------------------------------------------------------------------------------------------

std::uint32_t big_endian(const std::string& bytes, std::size_t word) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k)
    value = value << 8 | static_cast<unsigned char>(bytes.at(4 * word + k));
  return value;
}

float big_endian_float(const std::string& bytes, std::size_t word) {
  const std::uint32_t bits = big_endian(bytes, word);
  float value = 0.0F;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

TEST_F(Exchange, TheMddFileHasEveryFrameAndItsTime) {
  write("mdd");
  const std::string bytes = content(folder_ / "cloth.mdd");
  ASSERT_EQ(bytes.size(), 4u * (2 + kFrames + kFrames * 4 * 3));
  EXPECT_EQ(big_endian(bytes, 0), 3u);
  EXPECT_EQ(big_endian(bytes, 1), 4u);
  for (int f = 0; f < kFrames; ++f) {
    EXPECT_EQ(big_endian_float(bytes, 2 + f), static_cast<float>(f / kFps));
    std::vector<Vec3> x;
    for (int v = 0; v < 4; ++v) {
      const std::size_t word = 2 + kFrames + 3 * (4 * f + v);
      x.emplace_back(big_endian_float(bytes, word), big_endian_float(bytes, word + 1),
                     big_endian_float(bytes, word + 2));
    }
    expect_near(x, cloth_[f]);
  }
  EXPECT_EQ(read_mesh(folder_ / "cloth_base.ply").vertices, cloth_[0]);
}

// -- faults ---------------------------------------------------------------------------------------

TEST_F(Exchange, AFrameWithOtherVerticesIsRefused) {
  for (const char* format : {"gltf", "mdd", "usd"}) {
    SCOPED_TRACE(format);
    const FrameFormatRegistry formats = frame_formats();
    const auto writer = formats.at(format)(folder_);
    Frame frame = {.x = cloth_[0],
                   .v = {},
                   .triangles = kCloth,
                   .values = {},
                   .bodies = {},
                   .body_triangles = {}};
    writer->write(frame);
    frame.number = 1;
    frame.x = bodies_[1];
    EXPECT_THROW(writer->write(frame), std::invalid_argument);
    frame.x = cloth_[1];
    cloth_[1][2].x() = 1e39;
    EXPECT_THROW(writer->write(frame), std::invalid_argument) << "outside the range of float";
    cloth_[1][2].x() = 0.0;
    EXPECT_TRUE(formats.at(format).traits().one_mesh);
  }
}

TEST_F(Exchange, NoFileIsLeftBehindBeforeTheEnd) {
  for (const char* format : {"gltf", "usd"}) {
    const FrameFormatRegistry formats = frame_formats();
    const auto writer = formats.at(format)(folder_);
    writer->write({.x = cloth_[0],
                   .v = {},
                   .triangles = kCloth,
                   .values = {},
                   .bodies = {},
                   .body_triangles = {}});
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(folder_)) files += entry.is_regular_file();
    EXPECT_EQ(files, 0u) << format;
  }
  EXPECT_THROW(detail::SpoolFile(folder_ / "missing"), std::system_error);
}

}  // namespace
}  // namespace selvedge::exchange_test
