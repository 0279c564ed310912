// SPDX-License-Identifier: MIT
// Garments that are put on: free start, sewing, settling, and the folder of the result.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/parallel.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/dressing.h>
#include <selvedge/dress/dress_result.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

namespace selvedge::dress_test {
namespace {

namespace fs = std::filesystem;

/// A tube of two rectangles, `width` wide, in front of and behind the z axis; its lower edge is at
/// z = 0.
SewingPattern tube(double width, double height, double distance) {
  SewingPattern pattern;
  pattern.name = "tube";
  for (const double side : {-1.0, 1.0}) {
    PatternPanel panel;
    panel.name = side < 0.0 ? "front" : "back";
    const double w = 0.5 * width;
    panel.vertices = {{-w, 0.0}, {w, 0.0}, {w, height}, {-w, height}};
    for (std::int32_t i = 0; i < 4; ++i) panel.edges.push_back({{i, (i + 1) % 4}, {}, ""});
    // The plane's normal leads away from the axis.
    panel.rotation << -side, 0, 0, 0, 0, side, 0, 1, 0;
    panel.translation = Vec3(0.0, side * distance, 0.0);
    pattern.panels.push_back(panel);
  }
  using Direction = PatternStitch::Direction;
  pattern.stitches = {{{0, 1}, {1, 3}, Direction::end_to_start},
                      {{0, 3}, {1, 1}, Direction::end_to_start}};
  return pattern;
}

/// A cone with its tip up, on which a tube comes to rest.
TriangleMesh cone(double radius, double height, int segments = 24) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0.0, 0.0, height), Vec3::Zero()};
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / segments;
    mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
  }
  for (int i = 0; i < segments; ++i) {
    const std::int32_t a = 2 + i, b = 2 + (i + 1) % segments;
    mesh.triangles.push_back({0, a, b});
    mesh.triangles.push_back({1, b, a});
  }
  return mesh;
}

/// An upright prism around the z axis.
TriangleMesh prism(double radius, double low, double high, int segments = 24) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0.0, 0.0, low), Vec3(0.0, 0.0, high)};
  for (int i = 0; i < segments; ++i)
    for (const double z : {low, high}) {
      const double angle = 2.0 * std::numbers::pi * i / segments;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  for (int i = 0; i < segments; ++i) {
    const std::int32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % segments);
    for (const Triangle& t :
         {Triangle{0, b, a}, {1, a + 1, b + 1}, {a, b, a + 1}, {b, b + 1, a + 1}})
      mesh.triangles.push_back(t);
  }
  return mesh;
}

DressConfig coarse() {
  DressConfig config;
  config.edge_length = 0.03;
  config.sewing_edge_length = 0.06;
  return config;
}

TEST(Dress, ATubeIsSewnAroundAConeAndComesToRestOnIt) {
  const TriangleMesh body = cone(0.3, 0.6);
  std::vector<std::string> hashes;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    int crossings = 0;
    DressObserver observer;
    observer.accepted = [&](const Simulation& now) {
      crossings += static_cast<int>(find_crossings(now.positions(), now.cloth_triangles()).size());
      crossings += static_cast<int>(
          find_crossings({now.positions(), now.cloth_triangles()}, {body.vertices, body.triangles})
              .size());
    };
    const DressResult r = dress(tube(0.6, 0.3, 0.32), body, coarse(), {}, observer);
    EXPECT_EQ(r.fault(), "");
    EXPECT_EQ(crossings, 0);
    EXPECT_GT(r.states, 10);
    for (const SeamReport& seam : r.seams) EXPECT_EQ(seam.merged, seam.pairs) << seam.name;
    EXPECT_EQ(r.largest_opening, 0.0);
    for (const Vec3& x : r.garment.vertices) EXPECT_GT(x.z(), -0.2);  // not fallen off
    ASSERT_EQ(r.panel_drop.size(), 2u);
    // Seams that close push it up the cone, from a mean height of 0.15 m. A stricter limit refuses
    // it.
    double height = 0.0;
    for (const Vec3& x : r.garment.vertices) height += x.z();
    height /= static_cast<double>(r.garment.vertices.size());
    EXPECT_NEAR(0.5 * (r.panel_drop[0] + r.panel_drop[1]), 0.15 - height, 0.02);
    DressResult strict = r;
    strict.largest_drop = r.panel_drop[0] - 0.01;
    EXPECT_NE(strict.fault().find("lower than the pattern places it"), std::string::npos);
    hashes.push_back(r.state_hash);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Dress, ASplitMovesNoPointAndBendsCurvedEdges) {
  SewingPattern pattern = tube(0.4, 0.3, 0.2);
  PatternCurve& hem = pattern.panels[0].edges[0].curve;
  hem.kind = PatternCurve::Kind::quadratic;
  hem.control[0] = {0.0, -0.05};
  PanelMeshConfig config;
  config.edge_length = 0.06;
  const GarmentMesh mesh = mesh_garment(pattern, config);
  detail::Garment garment = detail::start_garment(mesh);
  const std::vector<Vec3> before = garment.surface.vertices;
  const double area = surface_area(garment.surface.vertices, garment.surface.triangles),
               flat = surface_area(garment.flat.vertices, garment.flat.triangles);
  detail::split_garment(pattern, garment);
  EXPECT_EQ(garment.surface.triangles.size(), 4 * mesh.flat.triangles.size());
  EXPECT_TRUE(std::equal(before.begin(), before.end(), garment.surface.vertices.begin()));
  EXPECT_NEAR(surface_area(garment.surface.vertices, garment.surface.triangles), area,
              1e-12 * area);
  // The polygon of the hem comes nearer to its curve, which bulges outward.
  EXPECT_GT(surface_area(garment.flat.vertices, garment.flat.triangles), flat);
  for (const detail::DividedEdge& border : garment.borders) {
    const PatternPanel& panel = pattern.panels[static_cast<std::size_t>(border.panel)];
    const auto pieces = static_cast<std::int32_t>(border.vertices.size()) - 1;
    const std::vector<Vec2> curve = divide_edge(panel, border.edge, pieces);
    for (std::size_t i = 1; i < curve.size(); ++i)
      EXPECT_NEAR((garment.flat.vertices[border.vertices[i]] -
                   garment.flat.vertices[border.vertices[i - 1]])
                      .norm(),
                  (curve[i] - curve[i - 1]).norm(), 1e-7);  // the mesh has rounded coordinates
  }
}

TEST(Dress, SeamsThatAreFarOpenAtTheStartSpanTheBody) {
  PanelMeshConfig mesh;
  mesh.edge_length = 0.06;
  detail::Garment garment = detail::start_garment(mesh_garment(tube(0.4, 0.3, 0.2), mesh));
  ASSERT_EQ(garment.stitches.size(), 2u);
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_NEAR(garment.stitches[s].span, 0.4, 1e-6);  // front and back are 0.2 m from the axis
    EXPECT_TRUE(garment.is_chosen(s, detail::SeamChoice::spanning));
  }
  garment.stitches[1].span = 0.1;
  EXPECT_TRUE(garment.is_chosen(0, detail::SeamChoice::spanning));
  EXPECT_FALSE(garment.is_chosen(1, detail::SeamChoice::spanning));
}

TEST(Dress, OnlyGatheredSeamsPullWhileTheyCloseFirst) {
  SewingPattern pattern = tube(0.4, 0.3, 0.2);
  // The left side of the front is half as long as the right side of the back, which it joins.
  pattern.panels[0].vertices[3].y() = 0.15;
  DressConfig config = coarse();
  PanelMeshConfig mesh;
  mesh.edge_length = 0.06;
  const detail::Garment garment = detail::start_garment(mesh_garment(pattern, mesh));
  ASSERT_EQ(garment.stitches.size(), 2u);
  EXPECT_FALSE(garment.stitches[0].is_gathered());
  EXPECT_TRUE(garment.stitches[1].is_gathered());
  EXPECT_NEAR(garment.stitches[1].ease, 1.0, 1e-9);
  for (const auto choice : {detail::SeamChoice::all, detail::SeamChoice::gathered}) {
    const detail::DressScene made = detail::make_dress_scene(
        garment, cone(0.05, 0.2), config, {.pull = 10.0, .merge = 0.35, .seams = choice});
    ASSERT_EQ(made.scene.seams.size(), choice == detail::SeamChoice::gathered ? 1u : 2u);
    EXPECT_EQ(made.scene.seams.back().vertices[0].size(), garment.open_pairs(1).size());
  }
}

TEST(Dress, APanelThatCrossesTheBodyIsMovedOutUntilItIsFree) {
  const TriangleMesh body = cone(0.3, 0.6);
  GarmentMesh mesh = mesh_garment(tube(0.6, 0.3, 0.25), {});
  EXPECT_FALSE(
      find_crossings({mesh.placed, mesh.flat.triangles}, {body.vertices, body.triangles}).empty());
  const std::vector<MovedPanel> moved = find_free_start(mesh, body, 0.5);
  ASSERT_EQ(moved.size(), 2u);
  EXPECT_LT(moved[0].by.y(), 0.0);
  EXPECT_GT(moved[1].by.y(), 0.0);
  EXPECT_TRUE(
      find_crossings({mesh.placed, mesh.flat.triangles}, {body.vertices, body.triangles}).empty());
}

TEST(Dress, APanelWithoutAFreePlaceIsNamed) {
  GarmentMesh mesh = mesh_garment(tube(0.6, 0.3, 0.25), {});
  try {
    find_free_start(mesh, cone(0.3, 0.6), 0.01);
    FAIL() << "no free place was needed";
  } catch (const DressFailed& failure) {
    EXPECT_NE(std::string(failure.what()).find("panel \"front\""), std::string::npos)
        << failure.what();
  }
}

TEST(Dress, ASeamThatCannotCloseIsNamed) {
  DressConfig config = coarse();
  config.sewing_edge_length = config.edge_length;
  config.largest_pull = config.pull;  // far too weak for half of the girth
  config.sew_time = 0.5;
  try {
    dress(tube(0.3, 0.2, 0.32), prism(0.3, -1.0, 1.0), config);
    FAIL() << "the tube is much too small";
  } catch (const DressFailed& failure) {
    EXPECT_NE(std::string(failure.what()).find("does not close"), std::string::npos)
        << failure.what();
    EXPECT_NE(std::string(failure.what()).find("front"), std::string::npos) << failure.what();
  }
}

/// Two boxes in one mesh, `gap` apart along x.
TriangleMesh two_boxes(double gap) {
  TriangleMesh mesh;
  for (const double side : {-1.0, 1.0}) {
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (int i = 0; i < 8; ++i) {
      const double x = (i & 1) != 0 ? 0.5 * gap : 0.5 * gap + 0.1;
      mesh.vertices.emplace_back(side * x, (i & 2) != 0 ? 0.05 : -0.05,
                                 (i & 4) != 0 ? 0.05 : -0.05);
    }
    const std::vector<Triangle> faces = {{0, 2, 4}, {2, 6, 4}, {1, 5, 3}, {3, 5, 7},
                                         {0, 4, 1}, {4, 5, 1}, {2, 3, 6}, {3, 7, 6},
                                         {0, 1, 2}, {1, 3, 2}, {4, 6, 5}, {5, 6, 7}};
    for (Triangle t : faces) {
      if (side < 0.0) std::swap(t[1], t[2]);
      mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  return mesh;
}

TEST(Dress, ABodyThatNearlyTouchesItselfMakesRoom) {
  const BodyRoom wide = make_room(two_boxes(0.02), 0.01);
  EXPECT_EQ(wide.vertices, 0);
  const BodyRoom narrow = make_room(two_boxes(0.004), 0.01);
  EXPECT_GT(narrow.vertices, 0);
  EXPECT_GE(narrow.largest, 0.003 - 1e-12);
  double gap = 1.0;
  for (const Vec3& x : narrow.body.vertices) gap = std::min(gap, 2.0 * std::abs(x.x()));
  EXPECT_GT(gap, 0.004);
  EXPECT_EQ(make_room(two_boxes(0.004), 0.0).vertices, 0);
}

TEST(Dress, NumbersOutOfRangeAreRefused) {
  DressConfig config = coarse();
  config.pull = 0.0;
  EXPECT_THROW(dress(tube(0.6, 0.3, 0.32), cone(0.3, 0.6), config), std::invalid_argument);
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(DressFolder, HoldsTheGarmentWithItsPatternAndTheVerdict) {
  const fs::path out = fs::temp_directory_path() / "selvedge_dress_test";
  fs::remove_all(out);
  DressFolderConfig folder;
  folder.out = out;
  folder.pictures = false;
  folder.body_file.up = UpAxis::z;
  folder.body_name = "cone";
  const DressResult r = dress_into_folder(tube(0.6, 0.3, 0.32), cone(0.3, 0.6), coarse(), folder);
  const TriangleMesh garment = read_mesh(out / "garment.obj");
  EXPECT_EQ(garment.vertices, r.garment.vertices);
  EXPECT_EQ(garment.triangles, r.garment.triangles);
  EXPECT_EQ(read_pattern(out / "garment.obj").vertices, r.flat.vertices);
  EXPECT_NE(text_of(out / "garment.obj").find("g back"), std::string::npos);
  EXPECT_NE(text_of(out / "result.json").find("\"verdict\": \"good\""), std::string::npos);
  EXPECT_TRUE(fs::exists(out / "frames" / "cloth_00000.ply"));
  EXPECT_TRUE(fs::exists(out / "frames" / "bodies_00000.ply"));

  std::ofstream(out / "result.json") << "{}";  // of something else
  EXPECT_THROW(dress_into_folder(tube(0.6, 0.3, 0.32), cone(0.3, 0.6), coarse(), folder),
               std::invalid_argument);
  fs::remove_all(out);
}

}  // namespace

}  // namespace selvedge::dress_test
