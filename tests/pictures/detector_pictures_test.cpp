// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/types.h>
#include <selvedge/pictures/detector_pictures.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <set>

namespace selvedge::detector_pictures_test {
namespace {

bool holds(const LevelBox& box, const Vec3& x) {
  return (box.lo.array() <= x.array()).all() && (x.array() <= box.hi.array()).all();
}

bool holds(const LevelBox& outer, const LevelBox& inner) {
  return holds(outer, inner.lo) && holds(outer, inner.hi);
}

/// A grid of n by n cells over a square metre.
TriangleMesh hill(int n) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = double(i) / n, y = double(j) / n;
      mesh.vertices.push_back({x, y, 2.0 * x * (1.0 - x) * y});
    }
  const auto at = [n](int i, int j) { return j * (n + 1) + i; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

struct Moving {
  TriangleMesh mesh = hill(24);
  std::vector<Vec3> x_t1 = mesh.vertices;
  std::vector<Edge> edges = unique_edges(mesh.triangles);
  Moving() {
    for (Vec3& x : x_t1) x += Vec3(0.0, 0.02, 0.01);
  }
  SurfaceView view() const { return {mesh.vertices, x_t1, edges, mesh.triangles, 0.001}; }
};

}  // namespace

TEST(HierarchyLevels, EachLevelHoldsEveryVertexAndLiesInTheOneAbove) {
  const Moving body;
  const auto levels = hierarchy_levels(body.view());
  ASSERT_GT(levels.size(), 2u);
  ASSERT_EQ(levels[0].size(), 1u);
  for (std::size_t k = 0; k < levels.size(); ++k) {
    for (std::size_t v = 0; v < body.x_t1.size(); v += 7)
      EXPECT_TRUE(std::any_of(levels[k].begin(), levels[k].end(),
                              [&](const LevelBox& box) {
                                return holds(box, body.mesh.vertices[v]) &&
                                       holds(box, body.x_t1[v]);
                              }))
          << "level " << k << ", vertex " << v;
    if (k == 0) continue;
    EXPECT_GT(levels[k].size(), levels[k - 1].size());
    for (const LevelBox& box : levels[k])
      EXPECT_TRUE(std::any_of(levels[k - 1].begin(), levels[k - 1].end(),
                              [&](const LevelBox& above) { return holds(above, box); }));
  }
  EXPECT_GE(8 * levels.back().size(), body.mesh.triangles.size());
}

TEST(HierarchyLevels, OfNothingThereAreNoneAndABadVertexIsNamed) {
  EXPECT_TRUE(hierarchy_levels({}).empty());
  Moving body;
  body.x_t1[12][0] = std::numeric_limits<double>::quiet_NaN();
  try {
    hierarchy_levels(body.view());
    ADD_FAILURE() << "not refused";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("vertex 12"), std::string::npos);
  }
}

TEST(DetectorPictures, AreWrittenForEveryLevelAndSide) {
  const Moving body;
  const auto folder = std::filesystem::path(::testing::TempDir()) / "detector_pictures";
  std::filesystem::remove_all(folder);
  const std::string missing = write_detector_pictures(body.view(), folder, "body");
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files.insert(entry.path().filename().string());
  const std::size_t levels = hierarchy_levels(body.view()).size();
  EXPECT_TRUE(files.contains("body_level_0.png"));
  EXPECT_TRUE(files.contains("body_level_" + std::to_string(levels - 1) + ".png"));
  EXPECT_EQ(files.size(), levels + (missing.empty() ? 6 : 0)) << missing;
  if (missing.empty()) {
    EXPECT_TRUE(files.contains("body_back_index.png"));
  } else {
    EXPECT_NE(missing.find("OSMesa"), std::string::npos);
  }
  std::filesystem::remove_all(folder);
}

TEST(DetectorPictures, TheIndexMapHasOneColourPerTriangleThatIsSeenFlat) {
  // Two triangles that fill a square: nothing, and two colours, each half of what is covered.
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}, {0, 2, 3}};
  const std::vector<Edge> edges = unique_edges(triangles);
  std::vector<DetectorPicture> pictures;
  try {
    pictures = map_pictures({x, x, edges, triangles}, 64);
  } catch (const std::invalid_argument& error) {
    GTEST_SKIP() << error.what();
  }
  const auto index = std::find_if(pictures.begin(), pictures.end(),
                                  [](const auto& p) { return p.name == "front_index"; });
  ASSERT_NE(index, pictures.end());
  std::map<std::array<std::uint8_t, 3>, int> texels;
  const auto& rgb = index->image.rgb;
  for (std::size_t i = 0; i < rgb.size(); i += 3) ++texels[{rgb[i], rgb[i + 1], rgb[i + 2]}];
  ASSERT_EQ(texels.size(), 3u);
  std::vector<int> counts;
  for (const auto& [colour, count] : texels) counts.push_back(count);
  std::sort(counts.begin(), counts.end());
  EXPECT_EQ(counts[0], 64 * 64 - 62 * 62) << "the border";
  EXPECT_EQ(counts[1] + counts[2], 62 * 62);
  EXPECT_NEAR(counts[1], counts[2], 63);
}

}  // namespace selvedge::detector_pictures_test
