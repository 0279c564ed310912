// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/garment/detail/size_field.h>
#include <selvedge/garment/detail/triangulation.h>
#include <selvedge/garment/panel_mesh.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "garment_patterns.h"

namespace selvedge::garment_mesh_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

SewingPattern bodice() { return parse_sewing_pattern(garment_patterns::kBodice, "bodice"); }
SewingPattern skirt() { return parse_sewing_pattern(garment_patterns::kSkirt, "skirt"); }

/// How often each edge occurs in the triangles, in either direction.
std::map<Edge, int> uses_of_edges(std::span<const Triangle> triangles) {
  std::map<Edge, int> uses;
  for (const Triangle& t : triangles)
    for (int i = 0; i < 3; ++i)
      ++uses[{std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])}];
  return uses;
}

double polygon_area(std::span<const Vec2> loop) {
  double twice = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(0.5 * twice);
}

/// All that holds for every mesh of a polygon.
void expect_sound(std::span<const Vec2> loop, const PolygonMesh& mesh, double edge_length) {
  const auto n = static_cast<std::int32_t>(loop.size());
  double extent = 0.0, area = 0.0;
  for (const Vec2& p : loop) extent = std::max(extent, (p - loop[0]).norm());
  for (std::int32_t i = 0; i < n; ++i)
    EXPECT_LT((mesh.vertices[i] - loop[i]).norm(), 1e-7 * extent);
  for (const Triangle& t : mesh.triangles) {
    const Vec2 u = mesh.vertices[t[1]] - mesh.vertices[t[0]],
               v = mesh.vertices[t[2]] - mesh.vertices[t[0]];
    const double twice = u.x() * v.y() - u.y() * v.x();
    EXPECT_GT(twice, 0.0);
    area += 0.5 * twice;
  }
  EXPECT_NEAR(area, polygon_area(loop), 1e-6 * extent * extent);
  // The edges with one triangle are the sides of the loop, and no triangle has two of them.
  std::set<Edge> border, sides;
  for (const auto& [edge, uses] : uses_of_edges(mesh.triangles)) {
    ASSERT_LE(uses, 2);
    if (uses == 1) border.insert(edge);
  }
  for (std::int32_t i = 0; i < n; ++i)
    sides.insert({std::min(i, (i + 1) % n), std::max(i, (i + 1) % n)});
  EXPECT_EQ(border, sides);
  for (const Triangle& t : mesh.triangles) {
    int on_border = 0;
    for (int i = 0; i < 3; ++i)
      on_border +=
          border.contains({std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])});
    EXPECT_LE(on_border, 1);
  }
  std::set<std::int32_t> used;
  for (const Triangle& t : mesh.triangles) used.insert(t.begin(), t.end());
  EXPECT_EQ(used.size(), mesh.vertices.size());
  EXPECT_LT(mesh.quality.longest, 2.0 * edge_length);
}

std::vector<Vec2> sampled(std::span<const Vec2> corners, double step) {
  std::vector<Vec2> loop;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const int n = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
    for (int k = 0; k < n; ++k) loop.push_back(a + (static_cast<double>(k) / n) * (b - a));
  }
  return loop;
}

TEST(PolygonMesh, HasTheLoopAsItsBorderAndItsArea) {
  const std::vector<Vec2> square = {{0, 0}, {0.3, 0}, {0.3, 0.2}, {0, 0.2}};
  const std::vector<Vec2> loop = sampled(square, 0.01);
  const PolygonMesh mesh = mesh_polygon(loop);
  expect_sound(loop, mesh, 0.01);
  EXPECT_GT(mesh.quality.least_angle, 28.0 * kDegree);
  EXPECT_NEAR(mesh.quality.mean, 0.01, 0.001);
}

TEST(PolygonMesh, RefusesALongSideThatCrossesOneThatBeginsFartherRight) {
  const std::vector<Vec2> loop = {{0, 0}, {0.4, 0.4}, {0.4, 0}, {0.1, 0.3}};
  for (int sign : {1, -1}) {
    std::vector<Vec2> turned = loop;
    for (Vec2& p : turned) p *= sign;
    EXPECT_THROW(mesh_polygon(turned), std::invalid_argument) << sign;
  }
}

TEST(PolygonMesh, OfALoopThatRunsClockwiseIsCounterClockwise) {
  const std::vector<Vec2> square = {{0, 0.2}, {0.3, 0.2}, {0.3, 0}, {0, 0}};
  const std::vector<Vec2> loop = sampled(square, 0.02);
  expect_sound(loop, mesh_polygon(loop, {.edge_length = 0.02}), 0.02);
}

TEST(PolygonMesh, DividesASingleTriangle) {
  const std::vector<Vec2> loop = {{0, 0}, {0.01, 0}, {0, 0.01}};
  const PolygonMesh mesh = mesh_polygon(loop, {.edge_length = 0.02});
  EXPECT_EQ(mesh.triangles.size(), 3u);
  expect_sound(loop, mesh, 0.02);
}

TEST(PolygonMesh, GrowsFromShortSides) {
  std::vector<Vec2> loop;
  for (int i = 0; i < 40; ++i) loop.emplace_back(0.005 * i, 0.0);
  for (const Vec2& p : sampled(std::vector<Vec2>{{0.2, 0}, {0.2, 0.2}, {0, 0.2}, {0, 0}}, 0.02))
    if (p.y() > 0.0 || p.x() == 0.2) loop.push_back(p);
  const PolygonMesh mesh = mesh_polygon(loop, {.edge_length = 0.02});
  expect_sound(loop, mesh, 0.02);
  EXPECT_GT(mesh.quality.least_angle, 12.0 * kDegree);
  EXPECT_LT(mesh.triangles.size(), 600u) << "the short edges must not fill the panel";
}

// One side of 2 mm in the middle of the lower border of a square of 20 cm, all others are 2 cm.
TEST(PolygonMesh, AShortSideMakesShortEdgesNearItAlone) {
  constexpr double kShort = 0.002, kLong = 0.02, kGrowth = 0.35;
  std::vector<Vec2> loop =
      sampled(std::vector<Vec2>{{0, 0}, {0.1, 0}, {0.2, 0}, {0.2, 0.2}, {0, 0.2}}, kLong);
  loop.insert(loop.begin() + 6, Vec2(0.1 + kShort, 0.0));
  const detail::SizeField field(loop, {}, kLong, 10000);
  EXPECT_NEAR(field.size({0.101, 0.001}), kShort, 1e-12);
  for (const double height : {0.03, 0.04, 0.05}) {
    EXPECT_LE(field.size({0.1, height}), kShort + kGrowth * (height + kLong)) << height;
    EXPECT_GE(field.size({0.1, height}), kShort + kGrowth * (height - kLong)) << height;
  }
  for (const Vec2& far : {Vec2(0.1, 0.1), Vec2(0.1, 0.19), Vec2(0.01, 0.1), Vec2(0.19, 0.19)})
    EXPECT_NEAR(field.size(far), kLong, 1e-12) << far.transpose();
}

TEST(PolygonMesh, RefusesALoopThatMeetsItself) {
  const std::vector<std::vector<Vec2>> loops = {
      {{0, 0}, {1, 1}, {1, 0}, {0, 1}},
      {{0, 0}, {1, 0}, {1, 1}, {0.5, 0}, {0, 1}},  // touches
      {{0, 0}, {1, 0}, {2, 0}},                    // no area
      {{0, 0}, {1, 0}, {1, 1}, {1, 0.5}, {1, 2}, {0, 1}},
      {{0, 0}, {1, 0}, {1, 0}, {0, 1}},
      {{0, 0}, {1, 0}, {NAN, 1}},
      {{0, 0}, {1, 0}},
  };
  for (const std::vector<Vec2>& loop : loops)
    EXPECT_THROW(mesh_polygon(loop), std::invalid_argument);
}

TEST(PolygonMesh, RefusesAnEdgeLengthThatGivesTooManyVertices) {
  const std::vector<Vec2> square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  EXPECT_THROW(mesh_polygon(square, {.edge_length = 1e-6}), std::invalid_argument);
  EXPECT_THROW(mesh_polygon(square, {.edge_length = 0.01, .vertices = 1000}),
               std::invalid_argument);
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_THROW(mesh_polygon(square, {.edge_length = bad}), std::invalid_argument);
}

/// A star-shaped polygon with spikes and notches.
std::vector<Vec2> random_star(std::mt19937& random) {
  std::uniform_real_distribution<double> radius(0.05, 0.4);
  std::vector<Vec2> corners;
  const int n = 3 + static_cast<int>(random() % 12);
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / n;
    corners.push_back(radius(random) * Vec2(std::cos(angle), std::sin(angle)));
  }
  return corners;
}

TEST(PolygonMesh, OfRandomStarsIsSound) {
  std::mt19937 random(17);
  for (int k = 0; k < 60; ++k) {
    const std::vector<Vec2> corners = random_star(random);
    const std::vector<Vec2> loop = sampled(corners, 0.02 + 0.03 * (k % 3));
    SCOPED_TRACE("star " + std::to_string(k));
    expect_sound(loop, mesh_polygon(loop, {.edge_length = 0.03}), 0.08);
  }
}

TEST(PolygonMesh, IsTheSameTwice) {
  std::mt19937 random(5);
  const std::vector<Vec2> loop = sampled(random_star(random), 0.01);
  const PolygonMesh a = mesh_polygon(loop), b = mesh_polygon(loop);
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles, b.triangles);
}

void expect_sound(const SewingPattern& pattern, const GarmentMesh& mesh) {
  const std::size_t panels = pattern.panels.size();
  ASSERT_EQ(mesh.first_vertex.size(), panels + 1);
  double area = 0.0;
  for (const PatternPanel& panel : pattern.panels) area += std::abs(panel_area(panel));
  EXPECT_NEAR(mesh.quality.area, area, 0.01 * area) << "curves become polygons";
  validate(mesh.flat, "flat");
  for (std::size_t t = 0; t < mesh.flat.triangles.size(); ++t) {
    const Triangle& v = mesh.flat.triangles[t];
    const Vec3 u = mesh.flat.vertices[v[1]] - mesh.flat.vertices[v[0]];
    EXPECT_GT(u.cross(mesh.flat.vertices[v[2]] - mesh.flat.vertices[v[0]]).z(), 0.0);
    for (const std::int32_t i : v) EXPECT_EQ(mesh.panel_of_vertex[i], mesh.panel_of_triangle[t]);
  }
  for (const Edge& e : unique_edges(mesh.flat.triangles)) {
    const double flat = (mesh.flat.vertices[e[0]] - mesh.flat.vertices[e[1]]).norm();
    EXPECT_NEAR((mesh.placed[e[0]] - mesh.placed[e[1]]).norm(), flat, 1e-9) << "placing is rigid";
  }
  const std::map<Edge, int> uses = uses_of_edges(mesh.flat.triangles);
  const auto expect_along = [&](const std::vector<std::int32_t>& line) {
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
      EXPECT_EQ(uses.at({std::min(line[i], line[i + 1]), std::max(line[i], line[i + 1])}), 1);
  };
  ASSERT_EQ(mesh.stitches.size(), pattern.stitches.size());
  for (const GarmentMesh::Stitch& s : mesh.stitches) {
    ASSERT_EQ(s.a.size(), s.b.size()) << s.name;
    expect_along(s.a);
    expect_along(s.b);
    for (const auto& [line, length] : {std::pair(s.a, s.length_a), {s.b, s.length_b}}) {
      double shortest = length, longest = 0.0;
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const double step = (mesh.flat.vertices[line[i]] - mesh.flat.vertices[line[i + 1]]).norm();
        shortest = std::min(shortest, step);
        longest = std::max(longest, step);
      }
      EXPECT_GT(shortest, 0.9 * longest) << s.name << " is not evenly divided";
    }
  }
  // Flat panels do not overlap.
  std::vector<std::array<double, 2>> spans;
  for (std::size_t p = 0; p < panels; ++p) {
    std::array<double, 2> span = {1e9, -1e9};
    for (std::int32_t v = mesh.first_vertex[p]; v < mesh.first_vertex[p + 1]; ++v) {
      span[0] = std::min(span[0], mesh.flat.vertices[v].x());
      span[1] = std::max(span[1], mesh.flat.vertices[v].x());
    }
    EXPECT_TRUE(p == 0 || span[0] > spans.back()[1]);
    spans.push_back(span);
  }
}

TEST(GarmentMesh, SewsCurvesDartsAndGathers) {
  const SewingPattern pattern = bodice();
  for (const double length : {0.03, 0.01}) {
    const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = length});
    expect_sound(pattern, mesh);
    EXPECT_GT(mesh.quality.least_free_angle, 14.0 * kDegree);
    EXPECT_TRUE(mesh.notes.empty()) << mesh.notes.front();
    EXPECT_EQ(mesh.panel_labels, (std::vector<std::string>{"", "", "body"}));
  }
}

TEST(GarmentMesh, SewsADartAtItsTip) {
  const SewingPattern pattern = bodice();
  const GarmentMesh mesh = mesh_garment(pattern);
  const GarmentMesh::Stitch& dart = mesh.stitches[0];
  EXPECT_EQ(dart.direction.reason, SeamDirection::Reason::file);
  EXPECT_EQ(dart.a.back(), dart.b.back());
  EXPECT_NE(dart.a.front(), dart.b.front());
}

TEST(GarmentMesh, GathersTheLongerSideEvenly) {
  const SewingPattern pattern = bodice();
  const GarmentMesh mesh = mesh_garment(pattern);
  const GarmentMesh::Stitch& gather = mesh.stitches[5];
  EXPECT_NEAR(gather.length_a / gather.length_b, 2.0, 1e-12);
  EXPECT_EQ(gather.a.size(), 101u);
}

TEST(Triangulation, HasTheSidesOfItsLoopAndTheAreaInIt) {
  // Stars whose points vary from the middle to the rim have many sides that the Delaunay
  // triangulation of their points lacks.
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    constexpr std::int32_t n = 40;
    std::vector<detail::GridPoint> loop;
    for (int i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / n;
      const double radius = std::ldexp(1.0, -static_cast<int>(random() % 6)) * (1 << 24);
      loop.push_back({(1 << 25) + std::llround(radius * std::cos(angle)),
                      (1 << 25) + std::llround(radius * std::sin(angle))});
    }
    ASSERT_FALSE(detail::loop_crossing(loop)) << seed;
    const detail::Triangulation mesh(loop, static_cast<std::int32_t>(loop.size()), {});
    std::int64_t area = 0, expected = 0;  // twice the area
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const detail::GridPoint &a = loop[i], &b = loop[(i + 1) % n];
      expected += a.x * b.y - b.x * a.y;
    }
    std::set<std::pair<std::int32_t, std::int32_t>> sides;
    for (const auto& cell : mesh.cells()) {
      if (!cell.inside) continue;
      const auto &a = mesh.points()[cell.v[0]], &b = mesh.points()[cell.v[1]],
                 &c = mesh.points()[cell.v[2]];
      EXPECT_EQ(detail::turn(a, b, c), 1) << seed;
      area += (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
      for (int k = 0; k < 3; ++k)
        if (cell.fixed[k]) sides.insert({cell.v[(k + 1) % 3], cell.v[(k + 2) % 3]});
    }
    EXPECT_EQ(area, expected) << seed;
    std::set<std::pair<std::int32_t, std::int32_t>> of_loop;
    for (std::int32_t i = 0; i < n; ++i)
      of_loop.insert(
          {detail::Triangulation::kOuter + i, detail::Triangulation::kOuter + (i + 1) % n});
    EXPECT_EQ(sides, of_loop) << seed;
  }
}

TEST(GarmentMesh, NeighbouringEdgesAreSewnFromTheVertexThatTheyShare) {
  SewingPattern pattern = skirt();
  for (const auto& [a, b] : {std::pair{0, 1}, std::pair{1, 0}, std::pair{3, 0}, std::pair{0, 3}}) {
    pattern.stitches = {{.a = {0, a}, .b = {0, b}}};
    const SeamDirection direction = seam_directions(pattern).at(0);
    EXPECT_EQ(direction.reason, SeamDirection::Reason::shared_end) << a << " and " << b;
    EXPECT_FALSE(direction.start_to_start) << a << " and " << b;
  }
  pattern.stitches = {{.a = {0, 1}, .b = {0, 3}}};
  EXPECT_NE(seam_directions(pattern).at(0).reason, SeamDirection::Reason::shared_end);
}

TEST(GarmentMesh, ListsTheVerticesOfALabel) {
  const GarmentMesh mesh = mesh_garment(bodice());
  ASSERT_EQ(mesh.labels.size(), 1u);
  const std::vector<std::int32_t>& waist = mesh.labels.at("lower_interface");
  EXPECT_EQ(waist.size(), 42u);
  for (const std::int32_t v : waist) EXPECT_NEAR(mesh.placed[v].y(), 0.0, 1e-8);
}

TEST(GarmentMesh, FacesOutwardWhereThePlacementDecides) {
  const SewingPattern pattern = skirt();
  const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = 0.02});
  expect_sound(pattern, mesh);
  for (const GarmentMesh::Stitch& s : mesh.stitches) {
    EXPECT_TRUE(s.direction.start_to_start);
    EXPECT_EQ(s.direction.reason, SeamDirection::Reason::placement);
    EXPECT_FALSE(s.direction.twisted);
  }
  ASSERT_EQ(mesh.notes.size(), 1u);
  EXPECT_NE(mesh.notes[0].find("\"back\" is turned over"), std::string::npos);
  for (std::size_t t = 0; t < mesh.flat.triangles.size(); ++t) {
    const Triangle& v = mesh.flat.triangles[t];
    const Vec3 normal =
        (mesh.placed[v[1]] - mesh.placed[v[0]]).cross(mesh.placed[v[2]] - mesh.placed[v[0]]);
    EXPECT_GT(normal.z() * mesh.placed[v[0]].z(), 0.0);
  }
}

TEST(GarmentMesh, SaysWhichSeamIsTwisted) {
  SewingPattern pattern = skirt();
  pattern.stitches[0].direction = PatternStitch::Direction::end_to_start;
  const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = 0.05});
  ASSERT_EQ(mesh.notes.size(), 2u) << "one is twisted, the other joins outside to inside";
  EXPECT_TRUE(std::any_of(mesh.notes.begin(), mesh.notes.end(), [](const std::string& note) {
    return note.find("stitch 0") == 0 && note.find("twisted") != std::string::npos;
  }));
}

TEST(GarmentMesh, IsTheSameTwice) {
  const GarmentMesh a = mesh_garment(bodice()), b = mesh_garment(bodice());
  EXPECT_EQ(a.flat.vertices, b.flat.vertices);
  EXPECT_EQ(a.placed, b.placed);
  EXPECT_EQ(a.flat.triangles, b.flat.triangles);
}

/// Merging the seams makes a surface whose edges have at most two triangles, in opposite
/// directions.
void expect_surface_when_sewn(const GarmentMesh& mesh) {
  std::vector<std::int32_t> same(mesh.placed.size());
  for (std::size_t i = 0; i < same.size(); ++i) same[i] = static_cast<std::int32_t>(i);
  const auto find = [&](std::int32_t v) {
    while (same[v] != v) v = same[v];
    return v;
  };
  for (const GarmentMesh::Stitch& s : mesh.stitches)
    for (std::size_t i = 0; i < s.a.size(); ++i) {
      const std::int32_t a = find(s.a[i]), b = find(s.b[i]);
      same[std::max(a, b)] = std::min(a, b);
    }
  std::map<Edge, int> directed;
  for (const Triangle& t : mesh.flat.triangles)
    for (int i = 0; i < 3; ++i) {
      const Edge e = {find(t[i]), find(t[(i + 1) % 3])};
      EXPECT_NE(e[0], e[1]);
      EXPECT_EQ(++directed[e], 1) << "an edge between " << e[0] << " and " << e[1];
    }
}

/// A pattern whose panels stand as mirror images of themselves or of each other has a mesh that is
/// its own mirror image: each triangle is the image of one.
void expect_mirror_image(const GarmentMesh& mesh, double middle) {
  ASSERT_EQ(mesh.image.size(), mesh.placed.size());
  std::set<Triangle> triangles;
  const auto put = [](Triangle t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
  };
  for (const Triangle& t : mesh.flat.triangles) triangles.insert(put(t));
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(mesh.image.size()); ++v) {
    const std::int32_t image = mesh.image[v];
    ASSERT_GE(image, 0) << "panel " << mesh.panel_names[mesh.panel_of_vertex[v]];
    EXPECT_EQ(mesh.image[image], v);
    const Vec3& x = mesh.placed[v];
    EXPECT_LT((Vec3(2.0 * middle - x.x(), x.y(), x.z()) - mesh.placed[image]).norm(), 1e-6);
  }
  for (const auto& [a, b, c] : mesh.flat.triangles)
    EXPECT_TRUE(triangles.contains(put({mesh.image[a], mesh.image[c], mesh.image[b]})));
}

TEST(GarmentMesh, OfASymmetricPatternIsItsOwnMirrorImage) {
  SewingPattern pattern = skirt();
  for (const double length : {0.1, 0.05, 0.03, 0.02, 0.013, 0.01}) {
    SCOPED_TRACE(length);
    const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = length});
    expect_sound(pattern, mesh);
    expect_surface_when_sewn(mesh);
    expect_mirror_image(mesh, 0.0);
    EXPECT_GT(mesh.quality.least_angle, 20.0 * kDegree);
  }
  // Corners in other places, and narrow panels of one to five rows.
  for (const double height : {10.0, 17.0, 30.0, 60.0}) {
    pattern = skirt();
    for (PatternPanel& panel : pattern.panels) {
      for (PatternEdge& edge : panel.edges) edge.curve = {};
      panel.vertices[2].y() = panel.vertices[3].y() = height / 300.0;
    }
    const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = 0.02});
    expect_sound(pattern, mesh);
    expect_surface_when_sewn(mesh);
    if (height > 16.0) expect_mirror_image(mesh, 0.0);
  }
}

TEST(GarmentMesh, PanelsThatMirrorEachOtherHaveMirroredMeshes) {
  // Halves of the panels of a skirt, beside a middle that is not x = 0; the right ones begin their
  // loops elsewhere, and those of the back run the other way.
  constexpr double kMiddle = 0.07;
  const SewingPattern whole = skirt();
  SewingPattern pattern;
  pattern.name = "halves";
  for (const bool is_back : {false, true})
    for (const double side : {1.0, -1.0}) {
      PatternPanel panel = whole.panels[is_back ? 1 : 0];
      panel.name += side > 0.0 ? "_left" : "_right";
      panel.vertices = {{0.0, 0.0}, {side * 0.4, 0.0}, {side * 0.22, 0.5}, {side * 0.02, 0.46}};
      panel.edges.clear();
      for (std::int32_t i = 0; i < 4; ++i) {
        const std::int32_t from = side > 0.0 ? i : (i + 2) % 4;
        panel.edges.push_back({{from, (from + 1) % 4}, {}, ""});
      }
      panel.translation.x() = kMiddle + side * 0.01;
      pattern.panels.push_back(panel);
    }
  using Direction = PatternStitch::Direction;
  pattern.stitches = {{{0, 1}, {2, 1}, Direction::start_to_start},
                      {{1, 3}, {3, 3}, Direction::start_to_start}};
  for (const double length : {0.05, 0.02, 0.011}) {
    SCOPED_TRACE(length);
    const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = length});
    expect_sound(pattern, mesh);
    expect_mirror_image(mesh, kMiddle);
  }
  pattern.panels[1].vertices[2].y() += 0.004;
  const GarmentMesh other = mesh_garment(pattern, {.edge_length = 0.02});
  expect_sound(pattern, other);
  EXPECT_EQ(other.image[static_cast<std::size_t>(other.first_vertex[1])], -1) << "no longer alike";
}

TEST(GarmentMesh, IsAnOrientedSurfaceWhenSewn) {
  for (const double length : {0.04, 0.02, 0.01}) {
    expect_surface_when_sewn(mesh_garment(bodice(), {.edge_length = length}));
    expect_surface_when_sewn(mesh_garment(skirt(), {.edge_length = length}));
  }
}

/// Patterns of other people, where this machine has them.
TEST(GarmentMesh, OfForeignPatternsIsSound) {
  const std::filesystem::path folder =
      std::filesystem::path(SELVEDGE_SOURCE_DIR) / "../shared/data/garments/patterns";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const std::filesystem::path& file : files) {
    SCOPED_TRACE(file.filename());
    const SewingPattern pattern = read_sewing_pattern(file);
    const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = 0.02});
    expect_sound(pattern, mesh);
    expect_surface_when_sewn(mesh);
    EXPECT_TRUE(mesh.notes.empty()) << mesh.notes.front();
    EXPECT_GT(mesh.quality.least_angle, 9.0 * kDegree);
  }
  EXPECT_GE(files.size(), 15u);
}

}  // namespace

}  // namespace selvedge::garment_mesh_test
