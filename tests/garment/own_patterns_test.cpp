// SPDX-License-Identifier: MIT
// The patterns of data/patterns, which scripts/make_patterns.py writes for the mannequin.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/detection/find.h>
#include <selvedge/garment/panel_mesh.h>

#include <algorithm>
#include <filesystem>
#include <numbers>

namespace selvedge::own_patterns_test {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(SELVEDGE_SOURCE_DIR) / "data";

std::vector<fs::path> files() {
  std::vector<fs::path> list;
  for (const auto& entry : fs::directory_iterator(kData / "patterns")) list.push_back(entry.path());
  std::sort(list.begin(), list.end());
  return list;
}

TriangleMesh mannequin() { return read_mesh(kData / "bodies" / "mannequin_arms_out.ply"); }

TEST(OwnPatterns, AreTheFiveGarments) {
  std::vector<std::string> names;
  for (const fs::path& file : files()) names.push_back(file.filename());
  EXPECT_EQ(names, (std::vector<std::string>{"dress_with_darts.json", "flared_skirt.json",
                                             "hooded_top.json", "tee.json", "trousers.json"}));
}

TEST(OwnPatterns, HaveSeamsThatAreNotTwistedAndLieFlat) {
  for (const fs::path& file : files()) {
    const GarmentMesh mesh = mesh_garment(read_sewing_pattern(file), {.edge_length = 0.02});
    EXPECT_TRUE(mesh.notes.empty()) << mesh.notes.front();
    EXPECT_GT(mesh.quality.least_angle, 20.0 * std::numbers::pi / 180.0) << file;
    for (const GarmentMesh::Stitch& s : mesh.stitches) {
      EXPECT_FALSE(s.direction.start_to_start) << s.name;
      EXPECT_LT(std::max(s.length_a, s.length_b), 1.27 * std::min(s.length_a, s.length_b))
          << s.name;
    }
  }
}

TEST(OwnPatterns, StandAroundTheMannequinWithoutCrossingIt) {
  const TriangleMesh body = mannequin();
  for (const fs::path& file : files()) {
    const GarmentMesh mesh = mesh_garment(read_sewing_pattern(file), {.edge_length = 0.02});
    const auto at_body = find_crossings(SurfaceState{mesh.placed, mesh.flat.triangles},
                                        SurfaceState{body.vertices, body.triangles});
    EXPECT_TRUE(at_body.empty()) << file << ": panel "
                                 << mesh.panel_names[mesh.panel_of_triangle[at_body[0].triangle_a]];
    const auto among = find_crossings(mesh.placed, mesh.flat.triangles);
    EXPECT_TRUE(among.empty()) << file << ": panels "
                               << mesh.panel_names[mesh.panel_of_triangle[among[0].triangle_a]]
                               << " and "
                               << mesh.panel_names[mesh.panel_of_triangle[among[0].triangle_b]];
  }
}

TEST(OwnPatterns, FaceAwayFromTheBody) {
  const Vec3 axis(0.0, 0.01, 0.0);
  for (const fs::path& file : files()) {
    const GarmentMesh mesh = mesh_garment(read_sewing_pattern(file), {.edge_length = 0.03});
    for (std::size_t t = 0; t < mesh.flat.triangles.size(); ++t) {
      const Triangle& v = mesh.flat.triangles[t];
      const Vec3 &a = mesh.placed[v[0]], &b = mesh.placed[v[1]], &c = mesh.placed[v[2]];
      const Vec3 normal = (b - a).cross(c - a).normalized();
      EXPECT_GT(normal.dot(a - axis), 0.05) << file;
    }
  }
}

TEST(OwnPatterns, TheMannequinWithItsArmsOutIsAClosedBody) {
  EXPECT_TRUE(report_mesh(mannequin()).sentences().empty());
}

}  // namespace

}  // namespace selvedge::own_patterns_test
