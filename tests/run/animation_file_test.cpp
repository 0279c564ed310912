// SPDX-License-Identifier: MIT
// Animated meshes of other programs.
#include <gtest/gtest.h>
#include <selvedge/bodies/internal/animation_file.h>
#include <selvedge/core/base/internal/html.h>
#include <selvedge/run/frame_writer.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

namespace selvedge::animation_file_test {
namespace {

namespace fs = std::filesystem;

class Animation : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("selvedge_animation_" + std::to_string(getpid()));
    fs::create_directories(folder_ / "frames");
    for (int f = 0; f < 4; ++f) {
      std::vector<Vec3>& x = frames_.emplace_back();
      for (int i = 0; i < 4; ++i)
        x.emplace_back(i % 2 + 0.1 * f, i / 2 - 1.0 / 3.0, 0.2 + 0.05 * f * f * (i % 2));
    }
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Writes the frames in a format of runs.
  void write(const std::string& format) const {
    const FrameFormatRegistry formats = frame_formats();
    const auto writer = formats.at(format)(folder_);
    for (int f = 0; f < 4; ++f)
      writer->write({.number = f,
                     .time = f / 25.0,
                     .x = frames_[f],
                     .v = {},
                     .triangles = triangles_,
                     .values = {},
                     .bodies = {},
                     .body_triangles = {}});
    writer->finish();
  }

  void write_text(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string read_text(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  void expect_frames(const MeshAnimation& animation) const {
    ASSERT_EQ(animation.frames.size(), frames_.size());
    EXPECT_EQ(animation.triangles, triangles_);
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      ASSERT_EQ(animation.frames[f].size(), frames_[f].size());
      for (std::size_t v = 0; v < frames_[f].size(); ++v)
        EXPECT_LE((animation.frames[f][v] - frames_[f][v]).norm(), 1e-6) << f << ", " << v;
    }
  }

  std::string refusal(const std::string& name, const AnimationConfig& config = {}) const {
    try {
      load_animation(folder_ / name, config);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  const std::vector<Triangle> triangles_ = {{0, 1, 3}, {0, 3, 2}};
  std::vector<std::vector<Vec3>> frames_;
  fs::path folder_;
};

#define EXPECT_SAYS(text, part) \
  EXPECT_NE(std::string(text).find(part), std::string::npos) << "it says: " << (text)

TEST_F(Animation, PointCachesReadBackOnTheirBaseMesh) {
  for (const char* format : {"pc2", "mdd"}) {
    SCOPED_TRACE(format);
    write(format);
    const std::string name = std::string("cloth.") + format;
    const MeshAnimation animation =
        load_animation(folder_ / name, {.base = folder_ / "cloth_base.ply"});
    expect_frames(animation);
    EXPECT_NEAR(animation.fps, std::string(format) == "mdd" ? 25.0 : 0.0, 1e-5);
    EXPECT_SAYS(refusal(name), "name the mesh that it moves");
    const std::string bytes = read_text(name);
    for (std::size_t size = 1; size < bytes.size(); size += 7) {
      write_text(name, bytes.substr(0, size));
      EXPECT_SAYS(refusal(name, {.base = folder_ / "cloth_base.ply"}), name) << size << " bytes";
    }
  }
}

TEST_F(Animation, UsdStagesReadBackWithTheirFrameRate) {
  write("usd");
  const MeshAnimation animation = load_animation(folder_ / "result.usda");
  expect_frames(animation);
  EXPECT_NEAR(animation.fps, 25.0, 1e-9);
  const std::string text = read_text("result.usda");
  for (std::size_t size = 1; size + 3 < text.size(); size += 37) {
    write_text("cut.usda", text.substr(0, size));
    EXPECT_SAYS(refusal("cut.usda"), "cut.usda") << size << " bytes";
  }
}

TEST_F(Animation, AUsdStageOfAnotherProgramKeepsUnitAxisAndPolygons) {
  write_text("stage.usda", R"(#usda 1.0
(
    doc = """a "quoted" { text"""
    metersPerUnit = 0.01
    upAxis = "Y"
)
def Xform "root" (
    kind = "group"
)
{
    def Mesh "quad" # a comment { 
    {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        uniform token orientation = "leftHanded"
        point3f[] points = [(0, 100, 0), (100, 100, 0), (100, 100, -100), (0, 100, -100)]
        normal3f[] normals = [(0, 1, 0)]
    }
}
)");
  const MeshAnimation animation = load_animation(folder_ / "stage.usda");
  ASSERT_EQ(animation.frames.size(), 1u);
  EXPECT_EQ(animation.frames[0],
            (std::vector<Vec3>{{0, -0.0, 1}, {1, -0.0, 1}, {1, 1, 1}, {0, 1, 1}}));
  EXPECT_EQ(animation.triangles, (std::vector<Triangle>{{3, 2, 1}, {3, 1, 0}}));
  write_text("moved.usda", R"(#usda 1.0
def Mesh "m" { double3 xformOp:translate = (1, 0, 0)
 uniform token[] xformOpOrder = ["xformOp:translate"] })");
  EXPECT_SAYS(refusal("moved.usda"), "moved.usda: line 3: a prim has a transformation");
}

#ifdef SELVEDGE_HAS_ASSIMP

TEST_F(Animation, MorphTargetsOfGltfAreBaked) {
  write("gltf");
  const AnimationConfig config{.fps = 25.0, .load = {.up = UpAxis::y, .weld = false}};
  const MeshAnimation animation = load_animation(folder_ / "result.glb", config);
  expect_frames(animation);
  EXPECT_EQ(animation.fps, 25.0);
  // Between two frames, the weights and so the points are linear.
  const MeshAnimation finer = load_animation(
      folder_ / "result.glb", {.fps = 50.0, .load = {.up = UpAxis::y, .weld = false}});
  ASSERT_EQ(finer.frames.size(), 7u);
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_LE((finer.frames[5][v] - 0.5 * (frames_[2][v] + frames_[3][v])).norm(), 1e-6);
}

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Two joints along x. The second, at (1, 0, 0), turns by 90 degrees about z within a second. The
/// vertices at x = 0.5, 1 and 2 follow the first joint, both half, and the second.
std::string skinned_gltf() {
  const std::string data =
      bytes_of(std::vector<float>{0.5, 0, 0, 1, 0.5, 0, 2, 0, 0}) +              // 0: positions
      bytes_of(std::vector<std::uint8_t>{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}) +  // 36: joints
      bytes_of(std::vector<float>{1, 0, 0, 0, 0.5, 0.5, 0, 0, 0, 1, 0, 0}) +     // 48: weights
      bytes_of(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0,  0, 0, 0, 1, 1,
                                  0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1}) +  // 96: inverse
      bytes_of(std::vector<float>{0, 1}) +                                          // 224: times
      bytes_of(std::vector<float>{0, 0, 0, 1, 0, 0, float(std::sqrt(0.5)),
                                  float(std::sqrt(0.5))}) +  // 232: rotations
      bytes_of(std::vector<std::uint32_t>{0, 2, 1});         // 264: indices
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "nodes": [{"name": "body", "mesh": 0, "skin": 0}, {"name": "hip", "children": [2]},
              {"name": "knee", "translation": [1, 0, 0]}],
    "skins": [{"joints": [1, 2], "inverseBindMatrices": 3}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}, "indices": 6}]}],
    "animations": [{"channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}],
                    "samplers": [{"input": 4, "output": 5, "interpolation": "LINEAR"}]}],
    "buffers": [{"byteLength": )" +
         std::to_string(data.size()) + R"(, "uri": "data:application/octet-stream;base64,)" +
         base64(std::as_bytes(std::span(data))) + R"("}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12},
      {"buffer": 0, "byteOffset": 48, "byteLength": 48}, {"buffer": 0, "byteOffset": 96, "byteLength": 128},
      {"buffer": 0, "byteOffset": 224, "byteLength": 8}, {"buffer": 0, "byteOffset": 232, "byteLength": 32},
      {"buffer": 0, "byteOffset": 264, "byteLength": 12}],
    "accessors": [
      {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0.5, 0, 0], "max": [2, 0.5, 0]},
      {"bufferView": 1, "componentType": 5121, "count": 3, "type": "VEC4"},
      {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC4"},
      {"bufferView": 3, "componentType": 5126, "count": 2, "type": "MAT4"},
      {"bufferView": 4, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
      {"bufferView": 5, "componentType": 5126, "count": 2, "type": "VEC4"},
      {"bufferView": 6, "componentType": 5125, "count": 3, "type": "SCALAR"}]})";
}

TEST_F(Animation, SkinsAreBakedByTheirJoints) {
  write_text("leg.gltf", skinned_gltf());
  const MeshAnimation animation =
      load_animation(folder_ / "leg.gltf", {.fps = 2.0, .load = {.up = UpAxis::z, .weld = false}});
  ASSERT_EQ(animation.frames.size(), 3u);
  for (int f = 0; f < 3; ++f) {
    const double angle = 0.25 * M_PI * f;
    const auto turned = [&](const Vec3& x) {
      const Vec3 d = x - Vec3::UnitX();
      return Vec3(1.0 + std::cos(angle) * d.x() - std::sin(angle) * d.y(),
                  std::sin(angle) * d.x() + std::cos(angle) * d.y(), d.z());
    };
    const Vec3 thigh(0.5, 0, 0), knee(1, 0.5, 0), foot(2, 0, 0);
    const std::vector<Vec3> wanted = {thigh, 0.5 * (knee + turned(knee)), turned(foot)};
    for (int v = 0; v < 3; ++v)
      EXPECT_LE((animation.frames[f][v] - wanted[v]).norm(), 1e-6) << f << ", " << v;
  }
}

#endif

TEST_F(Animation, VerticesThatStayTogetherAreWelded) {
  // Two triangles with vertices of their own along a common edge; one of a second pair moves away.
  std::vector<std::vector<Vec3>> frames(
      2, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  frames[1][4].z() = 0.5;
  {
    const FrameFormatRegistry formats = frame_formats();
    const auto writer = formats.at("usd")(folder_);
    const std::vector<Triangle> triangles = {{0, 1, 2}, {3, 4, 5}};
    for (int f = 0; f < 2; ++f)
      writer->write({.number = f,
                     .time = 0.1 * f,
                     .x = frames[f],
                     .v = {},
                     .triangles = triangles,
                     .values = {},
                     .bodies = {},
                     .body_triangles = {}});
    writer->finish();
  }
  const MeshAnimation welded = load_animation(folder_ / "result.usda", {.load = {.weld = true}});
  EXPECT_EQ(welded.frames[1].size(), 5u);
  EXPECT_EQ(welded.triangles[0][0], welded.triangles[1][0]);
  EXPECT_NE(welded.triangles[0][2], welded.triangles[1][1]);
  EXPECT_EQ(welded.frames[1][welded.triangles[1][1]].z(), 0.5);
}

}  // namespace
}  // namespace selvedge::animation_file_test
