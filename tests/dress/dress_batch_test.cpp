// SPDX-License-Identifier: MIT
// Batches of garments: the list, resumption, and the page.
#include <gtest/gtest.h>
#include <selvedge/dress/internal/dress_batch.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace selvedge::dress_batch_test {
namespace {

namespace fs = std::filesystem;

/// Two rectangles in front of and behind the z axis, sewn at their sides to a tube; z up.
constexpr const char* kTube = R"({"pattern": {"panels": {
  "front": {"vertices": [[-30, 0], [30, 0], [30, 30], [-30, 30]], "translation": [0, -32, 0], "rotation": [90, 0, 0],
    "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}]},
  "back": {"vertices": [[-30, 0], [30, 0], [30, 30], [-30, 30]], "translation": [0, 32, 0], "rotation": [90, 0, 180],
    "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}]}},
  "stitches": [[{"panel": "front", "edge": 1}, {"panel": "back", "edge": 3}],
               [{"panel": "front", "edge": 3}, {"panel": "back", "edge": 1}]]},
  "properties": {"units_in_meter": 100, "curvature_coords": "relative"}})";

/// A pyramid with its tip up, on which the tube comes to rest.
TriangleMesh pyramid() {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(-0.3, -0.25, 0), Vec3(0.3, -0.25, 0), Vec3(0.3, 0.25, 0),
                   Vec3(-0.3, 0.25, 0), Vec3(0, 0, 0.6)};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return mesh;
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A new folder with two patterns, of which only `tube` can be read.
fs::path patterns() {
  const fs::path folder =
      fs::temp_directory_path() /
      (std::string("selvedge_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
  fs::remove_all(folder);
  fs::create_directories(folder / "in");
  write(folder / "in" / "tube.json", kTube);
  write(folder / "in" / "broken.json", "{}");
  write(folder / "body", "the body is made by the test");
  return folder;
}

DressBatchConfig config(const fs::path& folder) {
  DressBatchConfig config;
  config.out = folder / "out";
  config.dress.edge_length = 0.06;
  config.dress.sewing_edge_length = 0.06;
  config.folder.pictures = false;
  config.folder.body_file.up = UpAxis::z;
  config.settings = "coarse";
  config.read_body = [](const fs::path&) { return BodyMesh{pyramid(), {.up = UpAxis::z}}; };
  return config;
}

TEST(DressBatch, AFaultyPatternDoesNotStopTheOthers) {
  const fs::path folder = patterns();
  const auto jobs = read_dress_list(folder / "in", folder / "body");
  std::vector<std::string> seen;
  const auto rows = dress_batch(jobs, config(folder), {},
                                [&](const DressBatchRow& row) { seen.push_back(row.job.name); });
  EXPECT_EQ(seen, (std::vector<std::string>{"broken", "tube"}));
  EXPECT_FALSE(rows[0].good);
  EXPECT_NE(rows[0].verdict.find("broken.json"), std::string::npos) << rows[0].verdict;
  EXPECT_TRUE(rows[1].worn) << rows[1].verdict;
  EXPECT_EQ(rows[1].panels, 2u);
  EXPECT_GT(rows[1].vertices, 50u);
  const std::string page = text_of(folder / "out" / "index.html");
  EXPECT_NE(page.find("worn: 1."), std::string::npos);
  EXPECT_NE(page.find("tube/pictures/front.png"), std::string::npos);
  EXPECT_EQ(page.find("broken/pictures"), std::string::npos);  // nothing was drawn

  // The same again keeps the garment that has ended; other settings and another pattern do not.
  const DressBatchConfig same = config(folder);
  EXPECT_TRUE(dress_batch(jobs, same, {})[1].kept);
  // A garment that is kept gets a view if it has none; one that is put on again a new one.
  int views = 0;
  DressBatchConfig viewing = same;
  viewing.write_view = [&](const fs::path& at) {
    write(at / "view.html", std::to_string(++views));
  };
  const std::string link = "href=\"tube/view.html\"";
  EXPECT_EQ(page.find(link), std::string::npos);
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(dress_batch(jobs, viewing, {})[1].view);
  EXPECT_EQ(views, 1);
  EXPECT_NE(text_of(folder / "out" / "index.html").find(link), std::string::npos);
  DressBatchConfig other = same;
  other.settings = "other";
  const auto again = dress_batch(jobs, other, {});
  EXPECT_FALSE(again[1].kept);
  EXPECT_FALSE(again[1].view);
  EXPECT_EQ(again[1].states, rows[1].states);
  viewing.settings = "third";
  EXPECT_TRUE(dress_batch(jobs, viewing, {})[1].view);
  EXPECT_EQ(views, 2);
  // Without the frames there is nothing to view.
  fs::remove(folder / "out" / "tube" / "view.html");
  fs::remove_all(folder / "out" / "tube" / "frames");
  const auto without = dress_batch(jobs, viewing, {});
  EXPECT_TRUE(without[1].kept);
  EXPECT_FALSE(without[1].view);
  EXPECT_EQ(views, 2);
  write(folder / "in" / "tube.json", std::string(kTube) + "\n");
  EXPECT_FALSE(dress_batch(jobs, other, {})[1].kept);
  fs::remove_all(folder);
}

TEST(DressBatch, AGarmentThatTakesTooLongIsStoppedAndNotTriedAgain) {
  const fs::path folder = patterns();
  fs::remove(folder / "in" / "broken.json");
  DressBatchConfig short_time = config(folder);
  short_time.dress.budget = 1e-6;
  int views = 0;
  short_time.write_view = [&](const fs::path&) { ++views; };
  const auto rows = dress_batch(read_dress_list(folder / "in", folder / "body"), short_time, {});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].verdict, "not finished within 1e-06 s");
  EXPECT_EQ(views, fs::exists(folder / "out" / "tube" / "frames") ? 1 : 0);
  fs::remove_all(folder);
}

TEST(DressBatch, AListNamesPatternsAndBodies) {
  const fs::path folder = patterns();
  const fs::path list = folder / "list.txt";
  write(list, "# two garments\n\nin/tube.json\n in/broken.json , other.obj\r\n");
  const auto jobs = read_dress_list(list, "body.obj");
  ASSERT_EQ(jobs.size(), 2u);
  EXPECT_EQ(jobs[0].pattern, folder / "in/tube.json");
  EXPECT_EQ(jobs[0].body, "body.obj");
  EXPECT_EQ(jobs[1].name, "broken");
  EXPECT_EQ(jobs[1].body, folder / "other.obj");
  EXPECT_THROW(read_dress_list(list, ""), std::invalid_argument);  // the first line has no body
  write(list, "in/tube.json,a\nelsewhere/tube.json,b\n");
  EXPECT_THROW(read_dress_list(list, ""), std::invalid_argument);  // the same folder twice
  write(list, "# nothing\n");
  EXPECT_THROW(read_dress_list(list, "body.obj"), std::invalid_argument);
  EXPECT_THROW(read_dress_list(folder / "missing", "body.obj"), std::invalid_argument);
  fs::remove_all(folder);
}

TEST(DressBatch, ThePageEscapesNames) {
  DressBatchRow row;
  row.job.name = "a<b";
  row.verdict = "x & y";
  row.vertices = 1;
  const std::string page = dress_page({row}, 2);
  EXPECT_EQ(page.find("a<b"), std::string::npos);
  EXPECT_NE(page.find("a&lt;b"), std::string::npos);
  EXPECT_NE(page.find("a%3Cb/pictures/front.png"), std::string::npos);
  EXPECT_NE(page.find("x &amp; y"), std::string::npos);
  EXPECT_NE(page.find("Good: 0 of 1, worn: 0; 2 are still to come."), std::string::npos);
}

}  // namespace
}  // namespace selvedge::dress_batch_test
