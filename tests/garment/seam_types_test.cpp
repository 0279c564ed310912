// SPDX-License-Identifier: MIT
// Lines, elastics, zips, buttons, pleats and fabrics in pattern files and in the mesh.
#include <gtest/gtest.h>
#include <selvedge/garment/internal/drawn_pattern.h>
#include <selvedge/garment/internal/pattern_svg.h>
#include <selvedge/garment/panel_mesh.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <stdexcept>
#include <string>

namespace selvedge::seam_types_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// A front of 60 by 40 cm and a back, sewn at the sides; `front` and `stitch` go into the file.
std::string file_of(const std::string& front, const std::string& stitch) {
  const std::string edges =
      R"("edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}])";
  return R"({"pattern": {"panels": {
    "front": {"translation": [0, 0, 20], "rotation": [0, 0, 0], "label": "",
      "vertices": [[-30, 0], [30, 0], [30, 40], [-30, 40])" +
         std::string(front.empty() ? "], " : ", [-10, 10], [10, 10], [-10, 25], [10, 25]], ") +
         edges + front + R"(},
    "back": {"translation": [0, 0, -20], "rotation": [0, 180, 0], "label": "",
      "vertices": [[-30, 0], [30, 0], [30, 40], [-30, 40]], )" +
         edges + R"(}},
    "stitches": [[{"panel": "front", "edge": 1}, {"panel": "back", "edge": 3}],
                 [{"panel": "front", "edge": 3}, {"panel": "back", "edge": 1})" +
         stitch + R"(]]},
    "properties": {"units_in_meter": 100, "curvature_coords": "absolute"}})";
}

const std::string kLines = R"(, "lines": [
    {"endpoints": [4, 5], "angle": 60, "stiffness": 0.2},
    {"endpoints": [5, 7], "elastic": 0.75},
    {"endpoints": [6, 4], "elastic": {"ratio": 0.5, "stiffness": 35}},
    {"endpoints": [6, 7]}], "fabric": "denim.json#blue")";

std::string fault_of(const std::string& text) {
  try {
    parse_sewing_pattern(text, "file");
  } catch (const std::invalid_argument& fault) {
    return fault.what();
  }
  return "";
}

TEST(SeamTypes, LinesElasticsAndFabricsAreReadAndWritten) {
  SewingPattern pattern = parse_sewing_pattern(file_of(kLines, ", \"zip\""), "file");
  for (const bool is_written : {false, true}) {
    if (is_written) pattern = parse_sewing_pattern(sewing_pattern_text(pattern), "file");
    const PatternPanel& front = pattern.panels[pattern.panels[0].name == "front" ? 0 : 1];
    ASSERT_EQ(front.lines.size(), 4u);
    EXPECT_NEAR(front.lines[0].angle.value(), 60.0 * kDegree, 1e-12);
    EXPECT_EQ(front.lines[0].stiffness, 0.2);
    EXPECT_FALSE(front.lines[1].angle);
    EXPECT_EQ(front.lines[1].elastic.ratio, 0.75);
    EXPECT_EQ(front.lines[1].elastic.stiffness, PatternElastic{}.stiffness);
    EXPECT_EQ(front.lines[2].elastic.stiffness, 35.0);
    EXPECT_EQ(front.fabric, "denim.json#blue");
    EXPECT_NEAR(edge_length(front, 4), 0.2, 1e-12);
    EXPECT_EQ(pattern.stitches[0].closure, PatternStitch::Closure::seam);
    EXPECT_EQ(pattern.stitches[1].closure, PatternStitch::Closure::zip);
  }
  EXPECT_NE(pattern_svg(pattern).find("line 0, fold 60"), std::string::npos);
}

TEST(SeamTypes, ButtonsHaveTheirNumberOrTheirPlaces) {
  const auto buttons = [](const std::string& words) {
    return parse_sewing_pattern(file_of("", words), "file").stitches[1].buttons;
  };
  EXPECT_EQ(buttons(R"(, {"buttons": 4})"), (std::vector<double>{0.125, 0.375, 0.625, 0.875}));
  EXPECT_EQ(buttons(R"(, {"buttons": [0.1, 0.9]})"), (std::vector<double>{0.1, 0.9}));
  // An edge of 40 cm with vertices every 2 cm.
  const GarmentMesh mesh =
      mesh_garment(parse_sewing_pattern(file_of("", R"(, {"buttons": [0, 0.49, 1]})"), "file"),
                   {.edge_length = 0.02});
  EXPECT_EQ(mesh.stitches[1].buttons, (std::vector<std::int32_t>{0, 10, 20}));
}

/// Lines stay whole in a sound mesh, at any edge length, and share their ends.
TEST(SeamTypes, TheMeshHasItsLines) {
  const SewingPattern pattern = parse_sewing_pattern(file_of(kLines, ""), "file");
  const auto p = static_cast<std::size_t>(pattern.panels[0].name == "front" ? 0 : 1);
  const PatternPanel& front = pattern.panels[p];
  for (const double length : {0.05, 0.02, 0.012}) {
    const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = length});
    std::map<Edge, int> uses;
    for (const Triangle& t : mesh.flat.triangles)
      for (int k = 0; k < 3; ++k)
        ++uses[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
    ASSERT_EQ(mesh.line_vertices[p].size(), 4u);
    std::map<std::int32_t, std::int32_t> vertex_of;  // of the ends
    for (std::int32_t l = 0; l < 4; ++l) {
      const std::vector<std::int32_t>& row = mesh.line_vertices[p][static_cast<std::size_t>(l)];
      ASSERT_GE(static_cast<double>(row.size()), edge_length(front, 4 + l) / length);
      double along = 0.0;
      for (std::size_t i = 1; i < row.size(); ++i) {
        EXPECT_EQ((uses[{std::min(row[i - 1], row[i]), std::max(row[i - 1], row[i])}]), 2);
        along += (mesh.flat.vertices[row[i]] - mesh.flat.vertices[row[i - 1]]).norm();
      }
      EXPECT_NEAR(along, edge_length(front, 4 + l), 1e-6);
      for (const int end : {0, 1}) {
        const std::int32_t v = end == 0 ? row.front() : row.back();
        const std::int32_t corner = front.lines[static_cast<std::size_t>(l)].endpoints[end];
        EXPECT_EQ(vertex_of.try_emplace(corner, v).first->second, v);
      }
    }
    EXPECT_GT(mesh.quality.least_angle, 25.0 * kDegree);
    EXPECT_NEAR(mesh.quality.area, 2.0 * 0.6 * 0.4, 1e-6);
  }
}

/// Chords of a random star-shaped polygon, from corner to corner past random inner points.
TEST(SeamTypes, RandomLinesStayWhole) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    const auto draw = [&] { return static_cast<double>(random()) / 4294967296.0; };
    PanelOutline outline;
    outline.sides = 24;
    for (std::size_t i = 0; i < outline.sides; ++i) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / 24.0;
      outline.points.push_back((0.2 + 0.05 * draw()) * Vec2(std::cos(angle), std::sin(angle)));
    }
    outline.points.push_back(0.1 * Vec2(draw(), draw()));
    for (const std::int32_t corner : {0, 5, 11, 17}) outline.lines.push_back({corner, 24});
    const PolygonMesh mesh = mesh_outline(outline, {.edge_length = 0.02 + 0.05 * draw()});
    const std::vector<Edge> edges = unique_edges(mesh.triangles);
    for (const auto& [a, b] : outline.lines)
      EXPECT_TRUE(std::binary_search(edges.begin(), edges.end(), Edge{a, b})) << seed;
    for (const Triangle& t : mesh.triangles) {
      const Vec2 u = mesh.vertices[t[1]] - mesh.vertices[t[0]],
                 v = mesh.vertices[t[2]] - mesh.vertices[t[0]];
      EXPECT_GT(u.x() * v.y() - u.y() * v.x(), 0.0) << seed;
    }
  }
}

TEST(SeamTypes, FaultsAreSentences) {
  const auto lines = [](const std::string& list) {
    return fault_of(file_of(", \"lines\": [" + list + "]", ""));
  };
  const std::map<std::string, std::string> faults = {
      {R"({"endpoints": [4, 9]})", "names vertex 9"},
      {R"({"endpoints": [4, 4]}, {"endpoints": [4, 5]}, {"endpoints": [6, 7]})", "line 0 meets"},
      {R"({"endpoints": [4, 7]}, {"endpoints": [5, 6]})", "line 1 meets"},
      {R"({"endpoints": [0, 1]}, {"endpoints": [4, 5]}, {"endpoints": [6, 7]})", "line 0"},
      {R"({"endpoints": [4, 5], "angle": 180}, {"endpoints": [6, 7]})", "180"},
      {R"({"endpoints": [4, 5], "elastic": 1.2}, {"endpoints": [6, 7]})", "ratio 1.2"},
      {R"({"endpoints": [4, 5], "elastic": 0}, {"endpoints": [6, 7]})", "above 0"},
      {R"({"endpoints": [4, 5], "stiffness": 0}, {"endpoints": [6, 7]})", "stiffness 0"},
      {R"({"endpoints": [4, 5]})", "vertex 6 is on no edge"}};
  for (const auto& [list, words] : faults)
    EXPECT_NE(lines(list).find(words), std::string::npos) << list << ": " << lines(list);
  for (const auto& [words, sentence] :
       std::map<std::string, std::string>{{", \"velcro\"", "\"zip\" or {\"buttons\": 5}"},
                                          {", {\"buttons\": 0}", "give 1 to"},
                                          {", {\"buttons\": [1.5]}", "button at 1.5"},
                                          {", {\"hooks\": 2}", "buttons"}})
    EXPECT_NE(fault_of(file_of("", words)).find(sentence), std::string::npos)
        << fault_of(file_of("", words));
}

/// A piece of 30 by 50 cm on a fold or not, with a stitch of its top to a band.
DrawnPattern pleated(std::vector<DrawnPleat> pleats, std::int32_t fold) {
  DrawnPattern drawn;
  drawn.name = "pleated";
  PatternPanel skirt, band;
  skirt.name = "skirt";
  skirt.vertices = {{0, 0}, {0.3, 0}, {0.3, 0.5}, {0, 0.5}};
  band.name = "band";
  band.vertices = {{0, 0}, {0.3, 0}, {0.3, 0.04}, {0, 0.04}};
  for (PatternPanel* panel : {&skirt, &band})
    for (std::int32_t i = 0; i < 4; ++i) panel->edges.push_back({{i, (i + 1) % 4}, {}, ""});
  drawn.panels = {{.panel = skirt, .fold = fold}, {.panel = band, .fold = fold}};
  drawn.panels[0].pleats = std::move(pleats);
  drawn.stitches.push_back({{{0, {2}, false}}, {{1, {0}, false}}, false});
  return drawn;
}

TEST(SeamTypes, APanelWithAPocketThatRunsTheWrongWayIsNamed) {
  SewingPattern pattern = parse_sewing_pattern(file_of(kLines, ""), "file");
  const std::size_t f = pattern.panels[0].name == "front" ? 0 : 1;
  PatternPanel pocket = pattern.panels[f];
  pocket.name = "pocket";
  pocket.vertices = {{-0.1, 0.1}, {0.1, 0.1}, {0.1, 0.25}, {-0.1, 0.25}};
  pocket.lines.clear();
  pocket.translation += 0.02 * pocket.rotation.col(2);
  pattern.panels.push_back(pocket);
  const auto front = static_cast<std::int32_t>(f);
  for (const auto& [edge, line] : {std::pair{0, 4}, {1, 5}, {3, 6}})
    pattern.stitches.push_back({{2, edge}, {front, line}});
  EXPECT_NO_THROW(check_sewing_pattern(pattern));
  for (PatternStitch& stitch : pattern.stitches)
    for (PatternStitch::Side* side : {&stitch.a, &stitch.b})
      if (side->panel == front && side->edge < 4) side->edge = 3 - side->edge;
  std::vector<PatternEdge>& edges = pattern.panels[f].edges;
  std::reverse(edges.begin(), edges.end());
  for (PatternEdge& edge : edges) std::swap(edge.endpoints[0], edge.endpoints[1]);
  try {
    check_sewing_pattern(pattern);
    FAIL() << "its side seams are twisted";
  } catch (const std::invalid_argument& fault) {
    EXPECT_NE(std::string(fault.what()).find("panel \"front\" runs clockwise"), std::string::npos)
        << fault.what();
  }
}

TEST(SeamTypes, APleatTakesTwiceItsDepthOutOfItsEdge) {
  for (const bool to_end : {false, true}) {
    const SewingPattern sewn = as_sewn(
        pleated({{.edge = 2, .at = 0.5, .depth = 0.03, .length = 0.2, .to_end = to_end}}, -1));
    const PatternPanel& skirt = sewn.panels[0];
    check_sewing_pattern(sewn, {.places = false});
    ASSERT_EQ(skirt.lines.size(), 2u);
    ASSERT_EQ(sewn.stitches.size(), 3u);  // two parts of the band, and the pleat
    double band = 0.0;
    for (const PatternStitch& s : sewn.stitches) {
      if (s.a.panel == 0 && s.b.panel == 0) {
        EXPECT_NEAR(edge_length(skirt, s.a.edge), 0.03, 1e-12);
        EXPECT_NEAR(edge_length(skirt, s.b.edge), 0.03, 1e-12);
        EXPECT_EQ(skirt.edges[s.a.edge].endpoints[1], skirt.edges[s.b.edge].endpoints[0]);
      } else {
        band += edge_length(skirt, s.a.edge);
      }
    }
    EXPECT_NEAR(band, 0.3 - 0.06, 1e-12);
    // One fold is outward at the side to which it lies, the other one inward in its middle.
    EXPECT_GT(skirt.lines[0].angle.value(), 2.5);
    EXPECT_NEAR(skirt.vertices[skirt.lines[0].endpoints[0]].x(), to_end ? 0.12 : 0.18, 1e-12);
    EXPECT_LT(skirt.lines[1].angle.value(), -2.5);
    EXPECT_NEAR(skirt.vertices[skirt.lines[1].endpoints[0]].x(), 0.15, 1e-12);
    EXPECT_NEAR(skirt.vertices[skirt.lines[1].endpoints[1]].y(), 0.3, 1e-12);
  }
}

TEST(SeamTypes, PleatsOnAFoldAreMirrored) {
  const SewingPattern sewn =
      as_sewn(pleated({{.edge = 2, .at = 0.3, .depth = 0.02, .length = 0.1},
                       {.edge = 2, .at = 0.7, .depth = 0.02, .length = 0.1, .to_end = true}},
                      3));
  EXPECT_EQ(sewn.panels[0].lines.size(), 8u);
  double taken = 0.0;
  for (const PatternStitch& s : sewn.stitches)
    if (s.a.panel == 0 && s.b.panel == 0) taken += 2.0 * edge_length(sewn.panels[0], s.a.edge);
  EXPECT_NEAR(taken, 4 * 0.04, 1e-12);
  EXPECT_NO_THROW(mesh_garment(sewn, {.edge_length = 0.02, .limits = {.places = false}}));
}

TEST(SeamTypes, PleatsThatDoNotFitAreNamed) {
  for (const auto& [pleats, words] : std::vector<std::pair<std::vector<DrawnPleat>, std::string>>{
           {{{.edge = 2, .at = 0.5, .depth = 0.2, .length = 0.1}}, "begins before"},
           {{{.edge = 2, .at = 0.95, .depth = 0.03, .length = 0.1}}, "beyond the end"},
           {{{.edge = 2, .at = 0.4, .depth = 0.03, .length = 0.1},
             {.edge = 2, .at = 0.5, .depth = 0.03, .length = 0.1}},
            "begins before"},
           {{{.edge = 2, .at = 0.5, .depth = 0.03, .length = 0.0}}, "above 0"},
           {{{.edge = 7, .at = 0.5, .depth = 0.03, .length = 0.1}}, "edge 7"}}) {
    std::string fault;
    try {
      as_sewn(pleated(pleats, -1));
    } catch (const std::invalid_argument& error) {
      fault = error.what();
    }
    EXPECT_NE(fault.find(words), std::string::npos) << fault;
  }
}

/// A pocket may be sewn to lines of a piece on a fold and of a pair.
TEST(SeamTypes, StitchesOnLinesAreMirrored) {
  DrawnPattern drawn = pleated({}, 3);
  PatternPanel& skirt = drawn.panels[0].panel;
  skirt.vertices.insert(skirt.vertices.end(), {{0.1, 0.1}, {0.2, 0.1}});
  skirt.lines.push_back({.endpoints = {4, 5}});
  PatternPanel pocket;
  pocket.name = "pocket";
  pocket.vertices = {{0.1, 0.1}, {0.2, 0.1}, {0.2, 0.2}, {0.1, 0.2}};
  pocket.translation = {0.0, 0.0, 0.01};
  for (std::int32_t i = 0; i < 4; ++i) pocket.edges.push_back({{i, (i + 1) % 4}, {}, ""});
  drawn.panels.push_back({.panel = pocket, .is_pair = true});
  drawn.stitches.push_back({{{2, {0}, false}}, {{0, {4}, false}}, false});
  const SewingPattern sewn = as_sewn(drawn);
  check_sewing_pattern(sewn, {.places = false});
  std::set<std::pair<std::int32_t, std::int32_t>> lines;
  for (const PatternStitch& s : sewn.stitches)
    if (sewn.panels[s.b.panel].is_line(s.b.edge)) lines.insert({s.a.panel, s.b.edge});
  const auto edges = static_cast<std::int32_t>(sewn.panels[0].edges.size());
  EXPECT_EQ(lines, (std::set<std::pair<std::int32_t, std::int32_t>>{{2, edges}, {3, edges + 1}}));
  for (const SeamDirection& d : seam_directions(sewn))
    EXPECT_TRUE(d.start_to_start || d.reason != SeamDirection::Reason::placement);
}

}  // namespace
}  // namespace selvedge::seam_types_test
