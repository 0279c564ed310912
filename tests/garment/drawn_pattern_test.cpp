// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/garment/internal/drawn_pattern.h>
#include <selvedge/garment/panel_mesh.h>

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

namespace selvedge::drawn_pattern_test {
namespace {

PatternPanel polygon(const char* name, std::vector<Vec2> points) {
  PatternPanel panel;
  panel.name = name;
  panel.vertices = std::move(points);
  const auto n = static_cast<std::int32_t>(panel.vertices.size());
  for (std::int32_t i = 0; i < n; ++i) panel.edges.push_back({{i, (i + 1) % n}, {}, ""});
  return panel;
}

double seam_length(const SewingPattern& p, const PatternStitch::Side& side) {
  return edge_length(p.panels[side.panel], side.edge);
}

double perimeter(const PatternPanel& panel) {
  double sum = 0.0;
  for (std::int32_t e = 0; e < static_cast<std::int32_t>(panel.edges.size()); ++e)
    sum += edge_length(panel, e);
  return sum;
}

std::string fault_of(const DrawnPattern& drawn) {
  try {
    as_sewn(drawn);
  } catch (const std::invalid_argument& fault) {
    return fault.what();
  }
  return "";
}

/// Parts of an edge have its length, and its points.
TEST(DrawnPattern, ADividedEdgeKeepsItsCurve) {
  for (const PatternCurve::Kind kind :
       {PatternCurve::Kind::straight, PatternCurve::Kind::quadratic, PatternCurve::Kind::cubic,
        PatternCurve::Kind::arc, PatternCurve::Kind::polyline}) {
    PatternPanel panel = polygon("a", {{0, 0}, {0.4, 0.1}, {0.2, 0.5}});
    PatternCurve& curve = panel.edges[0].curve;
    curve.kind = kind;
    curve.control = {Vec2(0.1, 0.2), Vec2(0.5, -0.1)};
    curve.radius = 0.3;
    curve.through = {{0.1, 0.1}, {0.2, -0.05}, {0.35, 0.0}};
    const double whole = edge_length(panel, 0);
    const std::vector<double> shares = {0.2, 0.55, 0.9};
    const EdgeParts parts = split_edge(panel, 0, shares);
    ASSERT_EQ(parts.curves.size(), 4u);
    double before = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 from = i == 0 ? panel.vertices[0] : parts.points[i - 1];
      const Vec2 to = i == 3 ? panel.vertices[1] : parts.points[i];
      PatternPanel part = polygon("part", {from, to, {0.2, 0.5}});
      part.edges[0].curve = parts.curves[i];
      const double share = (i == 3 ? 1.0 : shares[i]) - (i == 0 ? 0.0 : shares[i - 1]);
      EXPECT_NEAR(edge_length(part, 0), share * whole, 1e-5 * whole) << static_cast<int>(kind);
      // A point in the middle of the part lies on the whole edge at its place.
      const Vec2 middle = divide_edge(part, 0, 2)[1];
      const double at = (before + 0.5 * share);
      const Vec2 on_whole =
          divide_edge(panel, 0, 1000)[static_cast<std::size_t>(std::lround(1000 * at))];
      EXPECT_LT((middle - on_whole).norm(), 1e-3) << static_cast<int>(kind);
      before += share;
    }
  }
}

/// A cap of five edges, sewn to two armholes of two edges each.
DrawnPattern cap_and_armholes() {
  DrawnPattern drawn;
  drawn.name = "cap";
  drawn.panels.push_back(
      {.panel = polygon(
           "sleeve", {{0, 0}, {0.4, 0}, {0.35, 0.1}, {0.25, 0.15}, {0.15, 0.14}, {0.05, 0.08}})});
  for (const char* name : {"front", "back"})
    drawn.panels.push_back(
        {.panel = polygon(name, {{0, 0}, {0.3, 0}, {0.32, 0.12}, {0.27, 0.23}, {0, 0.3}})});
  drawn.stitches.push_back(
      {{{0, {1, 2, 3, 4, 5}, false}}, {{1, {1, 2}, false}, {2, {1, 2}, false}}, false});
  return drawn;
}

TEST(DrawnPattern, ASleeveCapOfFiveEdgesIsSewnToTwoArmholes) {
  const DrawnPattern drawn = cap_and_armholes();
  const SewingPattern sewn = as_sewn(drawn);
  double cap = 0.0, armholes = 0.0, ratio = 0.0;
  std::set<std::pair<std::int32_t, std::int32_t>> used;
  for (const PatternStitch& s : sewn.stitches) {
    EXPECT_EQ(s.direction, PatternStitch::Direction::end_to_start);
    EXPECT_TRUE(used.insert({s.a.panel, s.a.edge}).second);
    EXPECT_TRUE(used.insert({s.b.panel, s.b.edge}).second);
    cap += seam_length(sewn, s.a);
    armholes += seam_length(sewn, s.b);
    const double here = seam_length(sewn, s.a) / seam_length(sewn, s.b);
    if (ratio == 0.0) ratio = here;
    EXPECT_NEAR(here, ratio, 0.05 * ratio);  // ease is spread evenly, but for ends that meet
  }
  // 5 edges and 4 edges end at 7 places in between, unless ends meet.
  EXPECT_GE(sewn.stitches.size(), 6u);
  EXPECT_LE(sewn.stitches.size(), 8u);
  double wanted_cap = 0.0;
  for (const std::int32_t e : {1, 2, 3, 4, 5}) wanted_cap += edge_length(drawn.panels[0].panel, e);
  EXPECT_NEAR(cap, wanted_cap, 1e-9);
  EXPECT_NEAR(armholes,
              2.0 * (edge_length(drawn.panels[1].panel, 1) + edge_length(drawn.panels[1].panel, 2)),
              1e-9);
  for (std::size_t p = 0; p < 3; ++p) {
    EXPECT_NEAR(perimeter(sewn.panels[p]), perimeter(drawn.panels[p].panel), 1e-9);
    EXPECT_NEAR(panel_area(sewn.panels[p]), panel_area(drawn.panels[p].panel), 1e-12);
  }
  // The seam is one line: each part begins where the one before ends, on both sides.
  const auto end = [&](const PatternStitch::Side& s, int which) {
    return sewn.panels[s.panel].edges[s.edge].endpoints[which];
  };
  for (std::size_t i = 1; i < sewn.stitches.size(); ++i)
    EXPECT_EQ(end(sewn.stitches[i - 1].a, 1), end(sewn.stitches[i].a, 0));
}

TEST(DrawnPattern, NotchesMeet) {
  DrawnPattern drawn;
  drawn.name = "notches";
  drawn.panels = {{.panel = polygon("a", {{0, 0}, {1, 0}, {1, 1}, {0, 1}})},
                  {.panel = polygon("b", {{0, 0}, {1.2, 0}, {1.2, 1}, {0, 1}})}};
  drawn.panels[0].notches = {{0, 0.25, "n"}};
  drawn.panels[1].notches = {{0, 0.5, "n"}};
  drawn.stitches.push_back({{{0, {0}, false}}, {{1, {0}, false}}, false});
  SewingPattern sewn = as_sewn(drawn);
  ASSERT_EQ(sewn.stitches.size(), 2u);
  EXPECT_NEAR(seam_length(sewn, sewn.stitches[0].a), 0.25, 1e-12);
  EXPECT_NEAR(seam_length(sewn, sewn.stitches[0].b), 0.6, 1e-12);
  EXPECT_NEAR(seam_length(sewn, sewn.stitches[1].a), 0.75, 1e-12);
  // Notches of other names do not meet.
  drawn.panels[1].notches[0].name = "m";
  EXPECT_EQ(as_sewn(drawn).stitches.size(), 1u);
  // Those without names meet in their order.
  drawn.panels[0].notches = {{0, 0.25, ""}, {0, 0.5, ""}};
  drawn.panels[1].notches = {{0, 0.4, ""}, {0, 0.7, ""}};
  sewn = as_sewn(drawn);
  ASSERT_EQ(sewn.stitches.size(), 3u);
  EXPECT_NEAR(seam_length(sewn, sewn.stitches[0].b), 0.3 * 1.2, 1e-12);
  drawn.panels[0].notches = {{0, 0.25, "x"}, {0, 0.5, "y"}};
  drawn.panels[1].notches = {{0, 0.25, "x"}, {0, 0.5, "y"}};
  EXPECT_NE(fault_of(drawn).find("notches follow each other in another order"), std::string::npos);
}

/// Two halves on the fold: the seam at the side is made on both sides of the body.
TEST(DrawnPattern, AFoldIsOpenedAndItsSeamsAreMadeTwice) {
  DrawnPattern drawn;
  drawn.name = "fold";
  for (const char* name : {"front", "back"}) {
    DrawnPanel& half = drawn.panels.emplace_back();
    half.panel = polygon(name, {{0, 0}, {0.25, 0}, {0.22, 0.5}, {0, 0.45}});
    half.panel.edges[0].curve = {.kind = PatternCurve::Kind::arc, .radius = 0.5, .clockwise = true};
    half.fold = 3;
  }
  drawn.stitches.push_back({{{0, {1}, false}}, {{1, {1}, true}}, false});
  const SewingPattern sewn = as_sewn(drawn);
  ASSERT_EQ(sewn.panels.size(), 2u);
  ASSERT_EQ(sewn.panels[0].edges.size(), 6u);
  EXPECT_NEAR(panel_area(sewn.panels[0]), 2.0 * panel_area(drawn.panels[0].panel), 1e-6);
  ASSERT_EQ(sewn.stitches.size(), 2u);
  for (const PatternStitch& s : sewn.stitches) {
    EXPECT_NE(s.a.panel, s.b.panel);
    EXPECT_NEAR(seam_length(sewn, s.a), seam_length(sewn, s.b), 1e-12);
  }
  EXPECT_NE(sewn.stitches[0].a.edge, sewn.stitches[1].a.edge);
  // It is a tube: it meshes with both seams around a body.
  SewingPattern placed = sewn;
  placed.panels[0].rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  placed.panels[0].translation = Vec3(0, -0.2, 0);
  placed.panels[1].rotation << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  placed.panels[1].translation = Vec3(0, 0.2, 0);
  const GarmentMesh mesh = mesh_garment(placed, {.edge_length = 0.03});
  for (const GarmentMesh::Stitch& stitch : mesh.stitches) {
    EXPECT_FALSE(stitch.direction.twisted) << stitch.name;
    for (std::size_t i = 0; i < stitch.a.size(); ++i)
      EXPECT_LT((mesh.placed[stitch.a[i]] - mesh.placed[stitch.b[i]]).norm(), 0.41);
  }
}

TEST(DrawnPattern, APairIsMirrored) {
  DrawnPattern drawn;
  drawn.name = "pair";
  DrawnPanel& leg = drawn.panels.emplace_back();
  leg.panel = polygon("leg", {{0, 0}, {0.25, 0}, {0.3, 0.7}, {0.22, 1.0}, {0.0, 1.0}});
  leg.is_pair = true;
  drawn.stitches.push_back({{{0, {2}, false}}, {{0, {2}, true}}, false});  // the centre
  const SewingPattern sewn = as_sewn(drawn);
  ASSERT_EQ(sewn.panels.size(), 2u);
  EXPECT_EQ(sewn.panels[0].name, "leg.left");
  EXPECT_EQ(sewn.panels[1].name, "leg.right");
  EXPECT_NEAR(panel_area(sewn.panels[0]), panel_area(sewn.panels[1]), 1e-12);
  ASSERT_EQ(sewn.stitches.size(), 1u);  // its own mirror image
  EXPECT_EQ(sewn.stitches[0].a.panel, 0);
  EXPECT_EQ(sewn.stitches[0].b.panel, 1);
  EXPECT_NEAR(seam_length(sewn, sewn.stitches[0].a), seam_length(sewn, sewn.stitches[0].b), 1e-12);
  drawn.panels[0].is_right = true;
  EXPECT_EQ(as_sewn(drawn).panels[0].name, "leg.right");
}

TEST(DrawnPattern, TheGrainBecomesUpright) {
  DrawnPattern drawn;
  drawn.name = "grain";
  drawn.panels = {{.panel = polygon("a", {{0, 0}, {0.6, 0}, {0.6, 0.2}, {0, 0.2}})}};
  drawn.panels[0].grain = Vec2(1.0, 0.0);
  const SewingPattern sewn = as_sewn(drawn);
  const Vec2 along = sewn.panels[0].vertices[1] - sewn.panels[0].vertices[0];
  EXPECT_NEAR(along.x(), 0.0, 1e-12);
  EXPECT_NEAR(along.y(), 0.6, 1e-12);
  // The panel stands where it stood.
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_LT((place_point(sewn.panels[0], sewn.panels[0].vertices[v]) -
               place_point(drawn.panels[0].panel, drawn.panels[0].panel.vertices[v]))
                  .norm(),
              1e-12);
}

TEST(DrawnPattern, FaultsNameThePlaceAndARemedy) {
  DrawnPattern drawn = cap_and_armholes();
  drawn.stitches[0].a[0].edges = {1, 3};
  EXPECT_NE(fault_of(drawn).find("do not follow each other along its loop"), std::string::npos);
  drawn.stitches[0].a[0].edges = {9};
  EXPECT_NE(fault_of(drawn).find("names edge 9 of panel \"sleeve\", which has the edges 0 to 5"),
            std::string::npos);
  drawn.stitches[0].a[0] = {0, {1}, true};
  EXPECT_NE(fault_of(drawn).find("has no mirror image"), std::string::npos);
  drawn.stitches[0].a[0] = {0, {}, false};
  EXPECT_NE(fault_of(drawn).find("side without edges"), std::string::npos);
  drawn.panels[0].fold = 7;
  EXPECT_NE(fault_of(drawn).find("its fold must be one of its straight edges"), std::string::npos);
}

/// The keys of the JSON format.
TEST(DrawnPattern, AFileMayHaveFoldsPairsNotchesAndChains) {
  const std::string text =
      R"({"properties": {"units_in_meter": 100, "curvature_coords": "absolute"},
    "pattern": {"panels": {
      "back": {"vertices": [[0,0],[25,0],[22,40],[20,50],[8,55],[0,54]], "fold": 5, "edges": [
        {"endpoints": [0,1]}, {"endpoints": [1,2]}, {"endpoints": [2,3]}, {"endpoints": [3,4]},
        {"endpoints": [4,5]}, {"endpoints": [5,0]}]},
      "front": {"vertices": [[0,0],[25,0],[22,40],[20,50],[8,55],[0,48]], "fold": 5, "edges": [
        {"endpoints": [0,1]}, {"endpoints": [1,2]}, {"endpoints": [2,3]}, {"endpoints": [3,4]},
        {"endpoints": [4,5]}, {"endpoints": [5,0]}]},
      "sleeve": {"vertices": [[0,0],[20,0],[21,20],[10,24],[-1,20]], "pair": "right", "grain": [0,1],
        "notches": [{"edge": 2, "at": 0.9}], "edges": [
        {"endpoints": [0,1]}, {"endpoints": [1,2]}, {"endpoints": [2,3]}, {"endpoints": [3,4]},
        {"endpoints": [4,0]}]}},
    "stitches": [
      [{"panel": "front", "edge": 1}, {"panel": "back", "edge": 1, "mirror": true}],
      [{"panel": "front", "edge": 3}, {"panel": "back", "edge": 3, "mirror": true}],
      [{"panel": "sleeve", "edge": 1}, {"panel": "sleeve", "edge": 4}],
      [{"panel": "sleeve", "edges": [2, 3]},
       [{"panel": "back", "edge": 2}, {"panel": "front", "edge": 2, "mirror": true}]]]}})";
  const SewingPattern sewn = parse_sewing_pattern(text, "tee", {.places = false});
  ASSERT_EQ(sewn.panels.size(), 4u);
  EXPECT_EQ(sewn.panels[0].edges.size(), 10u + 0u);
  // Two sides, two shoulders, two sleeve seams, and two caps of at least two parts.
  EXPECT_GE(sewn.stitches.size(), 10u);
  std::map<std::string, int> seams;
  for (const PatternStitch& s : sewn.stitches) {
    ++seams[sewn.panels[s.a.panel].name];
    EXPECT_NEAR(seam_length(sewn, s.a) / seam_length(sewn, s.b), 1.0, 0.2);
  }
  EXPECT_EQ(seams["sleeve.left"], seams["sleeve.right"]);
  const auto broken = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    other.replace(other.find(from), from.size(), to);
    try {
      parse_sewing_pattern(other, "tee", {.places = false});
    } catch (const std::invalid_argument& fault) {
      return std::string(fault.what());
    }
    return std::string();
  };
  EXPECT_NE(
      broken("\"pair\": \"right\"", "\"pair\": \"both\"").find("the side for which it is drawn"),
      std::string::npos);
  EXPECT_NE(broken("\"grain\": [0,1]", "\"grain\": [0,0]").find("grain without length"),
            std::string::npos);
  EXPECT_NE(broken("\"edges\": [2, 3]", "\"edges\": []").find("side without edges"),
            std::string::npos);
}

}  // namespace
}  // namespace selvedge::drawn_pattern_test
