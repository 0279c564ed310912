// SPDX-License-Identifier: MIT
// Runs of scenes that are made in code, as the sample of the README makes them.
#include <gtest/gtest.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge::run_test {
namespace {

namespace fs = std::filesystem;

class RunOfASceneMadeInCode : public ::testing::Test {
 protected:
  RunOfASceneMadeInCode() {
    scene_.materials["default"] = {};
    scene_.cloths.emplace_back().shape = ClothGrid{.grid = {.cells_x = 8, .cells_y = 8}};
    scene_.cloths[0].placement.translation = {0.0, 0.0, 0.32};
    scene_.bodies.emplace_back().shape = BodyShape{Sphere{.radius = 0.3}, 16};
    scene_.time.frames = 3;
    config_.out = fs::path(::testing::TempDir()) / ("selvedge_run_" + std::to_string(getpid()));
  }
  ~RunOfASceneMadeInCode() override { fs::remove_all(config_.out); }

  Scene scene_;
  RunConfig config_;
};

TEST_F(RunOfASceneMadeInCode, RepeatsInItsFolderWithTheSameBits) {
  const RunResult first = run_scene(scene_, config_);
  const RunResult second = run_scene(scene_, config_);
  EXPECT_TRUE(first.clean);
  EXPECT_EQ(first.frames, 4);
  EXPECT_EQ(first.state_hash, second.state_hash);
}

TEST_F(RunOfASceneMadeInCode, LeavesTheFolderOfAnotherSceneAlone) {
  scene_.name = "one";
  run_scene(scene_, config_);
  scene_.name = "other";
  EXPECT_THROW(run_scene(scene_, config_), std::invalid_argument);
}

TEST_F(RunOfASceneMadeInCode, IsRefusedInAFolderInUse) {
  run_scene(scene_, config_);
  {
    const FolderLock lock(config_.out, "run");
    EXPECT_EQ(lock.warning(), "");
    EXPECT_THROW(run_scene(scene_, config_), std::invalid_argument);
    EXPECT_TRUE(fs::exists(config_.out / "result.json"));
    EXPECT_TRUE(fs::exists(config_.out / FolderLock::kFile)) << "removed by the refused run";
  }
  EXPECT_FALSE(fs::exists(config_.out / FolderLock::kFile));
  EXPECT_NO_THROW(run_scene(scene_, config_));
}

TEST_F(RunOfASceneMadeInCode, IsNotResumedBecauseItCannotBeCompared) {
  run_scene(scene_, config_);
  config_.resume = true;
  EXPECT_THROW(run_scene(scene_, config_), std::invalid_argument);
}

// -- formats of frames ----------------------------------------------------------------------------

TEST_F(RunOfASceneMadeInCode, WritesObjFramesThatReadBackExactly) {
  scene_.output.formats = {"obj"};
  run_scene(scene_, config_);
  for (const int frame : {0, 3}) {
    const auto mesh = [&](const char* extension) {
      return read_mesh(
          numbered(config_.out / "frames", "cloth", frame, kFrameFileDigits, extension));
    };
    EXPECT_EQ(mesh(".obj").vertices, mesh(".ply").vertices);
    EXPECT_EQ(mesh(".obj").triangles, mesh(".ply").triangles);
  }
  EXPECT_TRUE(fs::exists(config_.out / "frames/bodies_00000.obj"));
  EXPECT_FALSE(fs::exists(config_.out / "frames/bodies_00001.obj")) << "the body is at rest";
}

TEST_F(RunOfASceneMadeInCode, RemovesTheFilesOfAllFormatsOfAnEarlierRun) {
  scene_.output.formats = {"obj", "vtk", "pc2"};
  run_scene(scene_, config_);
  EXPECT_TRUE(fs::exists(config_.out / "cloth.pc2"));
  // What a killed run leaves, and what `measure` writes.
  std::ofstream(config_.out / "frames/cloth_00000.ply.partial77") << "half";
  fs::create_directories(config_.out / "measures");
  std::ofstream(config_.out / "measures/strain.csv") << "strain";
  scene_.output.formats.clear();
  scene_.time.frames = 1;
  run_scene(scene_, config_);
  EXPECT_FALSE(fs::exists(config_.out / "measures"));
  std::set<std::string> left;
  for (const char* folder : {".", "frames"})
    for (const auto& entry : fs::directory_iterator(config_.out / folder))
      if (entry.is_regular_file()) left.insert(entry.path().filename());
  EXPECT_EQ(left, (std::set<std::string>{"bodies_00000.ply", "checkpoint.json", "checkpoint.ply",
                                         "cloth_00000.ply", "cloth_00001.ply", "result.json",
                                         "scene.json"}));
}

// The names are as long as those of a run's files, or longer by more than a number.
TEST_F(RunOfASceneMadeInCode, LeavesFilesThatARunDoesNotWrite) {
  run_scene(scene_, config_);
  const std::set<std::string> own = {"shirt_00002.ply", "cloth_2b.ply", "cloth_.ply",
                                     "cloth_00002.txt"};
  for (const std::string& name : own) std::ofstream(config_.out / "frames" / name) << "mine";
  scene_.time.frames = 1;
  run_scene(scene_, config_);
  for (const std::string& name : own)
    EXPECT_TRUE(fs::exists(config_.out / "frames" / name)) << name;
  EXPECT_FALSE(fs::exists(config_.out / "frames/cloth_00002.ply"));
}

TEST_F(RunOfASceneMadeInCode, RefusesAnUnknownFormatAndNamesTheNearest) {
  scene_.output.formats = {"vtx"};
  try {
    run_scene(scene_, config_);
    FAIL() << "it ran";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what())
                  .find("output.formats: there is no \"vtx\" in this build; nearest is \"vtk\""),
              std::string::npos)
        << error.what();
  }
  EXPECT_FALSE(fs::exists(config_.out));
}

TEST_F(RunOfASceneMadeInCode, WritesAFormatOfTheCaller) {
  struct Heights final : FrameWriter {
    explicit Heights(std::vector<double>& lowest) : lowest_(lowest) {}
    void write(const Frame& frame) override {
      EXPECT_EQ(frame.number, static_cast<int>(lowest_.size()));
      EXPECT_EQ(frame.time, frame.number / 60.0);
      EXPECT_EQ(frame.bodies.empty(), frame.number > 0);
      lowest_.push_back(frame.x[0].z());
      for (const Vec3& p : frame.x) lowest_.back() = std::min(lowest_.back(), p.z());
    }
    std::vector<double>& lowest_;
  };
  std::vector<double> lowest;
  config_.formats.add(
      "heights", {},
      [&](const MethodOptions&, const fs::path&) { return std::make_unique<Heights>(lowest); },
      {.promise = "", .source = ""});
  scene_.output.formats = {"heights"};
  scene_.time.fps = 60.0;
  run_scene(scene_, config_);
  ASSERT_EQ(lowest.size(), 4u);
  EXPECT_LT(lowest[3], lowest[0]);
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Fails at one frame.
struct FullDisk final : FrameWriter {
  explicit FullDisk(int frame) : frame_(frame) {}
  void write(const Frame& frame) override {
    if (frame.number == frame_) throw std::runtime_error("the disk is full");
  }
  int frame_;
};

TEST_F(RunOfASceneMadeInCode, EndsWithTheErrorOfAFrameThatCannotBeWritten) {
  scene_.time.frames = 6;
  for (const int threads : {1, 4})
    for (const int frame : {0, 2, 6}) {
      const ThreadLimit limit(threads);
      RunConfig config = config_;
      config.formats.add(
          "full", {},
          [&](const MethodOptions&, const fs::path&) { return std::make_unique<FullDisk>(frame); },
          {.promise = "", .source = ""});
      scene_.output.formats = {"full"};
      std::vector<int> whole;
      config.progress = [&](int number, double) { whole.push_back(number); };
      try {
        run_scene(scene_, config);
        ADD_FAILURE() << "it ran";
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "the disk is full");
      }
      const RunResult result = result_from_text(text_of(config_.out / "result.json"));
      EXPECT_EQ(result.stopped, "the disk is full");
      EXPECT_EQ(result.frames, frame) << "frames that are whole";
      EXPECT_EQ(whole.size(), static_cast<std::size_t>(frame));
      EXPECT_EQ(fs::exists(config_.out / "checkpoint.json"), frame > 0);
    }
}

TEST_F(RunOfASceneMadeInCode, ReportsEveryFrameInOrderOnceItsFilesAreWhole) {
  std::vector<int> reported;
  config_.progress = [&](int frame, double) {
    reported.push_back(frame);
    EXPECT_TRUE(
        fs::exists(numbered(config_.out / "frames", "cloth", frame, kFrameFileDigits, ".ply")));
    EXPECT_TRUE(fs::exists(config_.out / "checkpoint.json"));
  };
  run_scene(scene_, config_);
  EXPECT_EQ(reported, (std::vector<int>{0, 1, 2, 3}));
}

TEST_F(RunOfASceneMadeInCode, WritesTheSameBytesWithATaskBesideItAndWithout) {
  const auto bytes = [&](int threads) {
    const ThreadLimit limit(threads);
    run_scene(scene_, config_);
    std::map<std::string, std::string> files;
    for (const char* name : {"frames/cloth_00000.ply", "frames/cloth_00003.ply",
                             "frames/bodies_00000.ply", "checkpoint.ply"}) {
      files[name] = text_of(config_.out / name);
      EXPECT_FALSE(files[name].empty()) << name;
    }
    return files;
  };
  EXPECT_EQ(bytes(1), bytes(3));
}

TEST_F(RunOfASceneMadeInCode, RefusesAnOptionThatTheFormatDoesNotHave) {
  scene_.output.formats = {"vtk"};
  scene_.output.format_options["vtk"] = {{"digits", 3.0}};
  try {
    run_scene(scene_, config_);
    FAIL() << "it ran";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "vtk: has no option \"digits\" and no other option");
  }
}

TEST(FrameFormats, EachHasAPromiseAndASource) {
  for (const auto& [name, format] : frame_formats()) {
    EXPECT_FALSE(format.promise().empty()) << name;
    EXPECT_FALSE(format.source().empty()) << name;
  }
}

}  // namespace
}  // namespace selvedge::run_test
