// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/garment/internal/pattern_svg.h>
#include <selvedge/garment/panel_mesh.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "garment_patterns.h"

namespace selvedge::garment_pattern_test {
namespace {

using Json = nlohmann::json;

/// The message with which a pattern is refused; empty if it is read.
std::string refusal_of(const std::string& text) {
  try {
    parse_sewing_pattern(text, "p.json");
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

std::string refusal(const Json& j) { return refusal_of(j.dump()); }

Json bodice() { return Json::parse(garment_patterns::kBodice); }

void expect_refused(const Json& j, const std::vector<std::string>& words) {
  const std::string message = refusal(j);
  ASSERT_FALSE(message.empty()) << "it was read";
  EXPECT_TRUE(message.starts_with("p.json: ")) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  for (const std::string& word : words)
    EXPECT_NE(message.find(word), std::string::npos) << message << "\n  lacks " << word;
}

Json& front(Json& j) { return j["pattern"]["panels"]["front"]; }

TEST(SewingPattern, IsReadInMetres) {
  const SewingPattern pattern = parse_sewing_pattern(garment_patterns::kBodice, "bodice");
  ASSERT_EQ(pattern.panels.size(), 3u);
  const PatternPanel& panel = pattern.panels[2];
  EXPECT_EQ(panel.name, "front");
  EXPECT_EQ(panel.label, "body");
  EXPECT_EQ(panel.edges[0].label, "lower_interface");
  EXPECT_NEAR(panel.translation.z(), 0.2, 1e-15);
  EXPECT_NEAR(edge_length(panel, 0), 0.2, 1e-15);
  EXPECT_EQ(pattern.stitches.size(), 6u);
  for (const PatternStitch& s : pattern.stitches)
    EXPECT_EQ(s.direction, PatternStitch::Direction::end_to_start) << "the newer files fix it";
  const SewingPattern skirt = parse_sewing_pattern(garment_patterns::kSkirt, "skirt");
  EXPECT_NEAR(skirt.panels[0].vertices[0].x(), -1.0 / 3.0, 1e-15);
  EXPECT_EQ(skirt.stitches[0].direction, PatternStitch::Direction::unknown);
}

TEST(SewingPattern, RotatesAboutFixedAxesInTurn) {
  Json j = bodice();
  front(j)["rotation"] = {90, 90, 0};
  const SewingPattern pattern = parse_sewing_pattern(j.dump(), "p");
  // About x: y becomes z; then about y: z becomes x.
  EXPECT_LT((pattern.panels[2].rotation * Vec3::UnitY() - Vec3::UnitX()).norm(), 1e-12);
}

TEST(SewingPattern, TurnsAQuadraticCurveToTheLeftOfItsEdge) {
  Json j = Json::parse(garment_patterns::kSkirt);
  const SewingPattern relative = parse_sewing_pattern(j.dump(), "p");
  const Vec2 middle = edge_point(relative.panels[0], 0, 0.5);
  EXPECT_NEAR(middle.x(), 0.0, 1e-15);
  EXPECT_NEAR(middle.y(), -0.5 * 0.1 * 2.0 / 3.0, 1e-15);
  j["properties"]["curvature_coords"] = "absolute";
  for (auto& panel : j["pattern"]["panels"]) {
    panel["edges"][0]["curvature"] = {0, -20};
    panel["edges"][2]["curvature"] = {0, 138};
  }
  const SewingPattern absolute = parse_sewing_pattern(j.dump(), "p");
  EXPECT_LT((edge_point(absolute.panels[0], 0, 0.5) - middle).norm(), 1e-15);
}

TEST(SewingPattern, HasArcsAsInSvgPaths) {
  // From (0.1, 0.5) to (-0.1, 0.5), radius 12 cm, clockwise, less than half a circle.
  const SewingPattern pattern = parse_sewing_pattern(garment_patterns::kBodice, "bodice");
  const PatternPanel& panel = pattern.panels[2];
  const Vec2 centre(0.0, 0.5 + std::sqrt(0.12 * 0.12 - 0.1 * 0.1));
  for (const double t : {0.0, 0.3, 0.5, 1.0})
    EXPECT_NEAR((edge_point(panel, 6, t) - centre).norm(), 0.12, 1e-15);
  EXPECT_LT(edge_point(panel, 6, 0.5).y(), 0.5) << "the neck dips into the panel";
  EXPECT_NEAR(edge_length(panel, 6), 0.12 * 2.0 * std::asin(10.0 / 12.0), 1e-12);
  PatternPanel large = panel;
  large.edges[6].curve.large_arc = true;
  EXPECT_NEAR(edge_length(large, 6), 0.12 * 2.0 * (std::numbers::pi - std::asin(10.0 / 12.0)),
              1e-12);
  EXPECT_LT(edge_point(large, 6, 0.5).y(), 0.4);
}

TEST(SewingPattern, DividesCurvesIntoEqualLengths) {
  const SewingPattern pattern = parse_sewing_pattern(garment_patterns::kBodice, "bodice");
  for (const std::int32_t edge : {4, 6, 8}) {
    const PatternPanel& panel = pattern.panels[2];
    const std::vector<Vec2> points = divide_edge(panel, edge, 50);
    double sum = 0.0;
    for (int i = 0; i < 50; ++i) sum += (points[i + 1] - points[i]).norm();
    for (int i = 0; i < 50; ++i)
      EXPECT_NEAR((points[i + 1] - points[i]).norm(), sum / 50, 1e-3 * sum / 50);
    EXPECT_NEAR(sum, edge_length(panel, edge), 1e-3 * sum);
    EXPECT_EQ(points.front(), panel.vertices[panel.edges[edge].endpoints[0]]);
    EXPECT_EQ(points.back(), panel.vertices[panel.edges[edge].endpoints[1]]);
  }
}

TEST(SewingPattern, NamesALoopThatIsOpenOrCrossesItself) {
  Json j = bodice();
  front(j)["edges"][3]["endpoints"] = {2, 4};
  expect_refused(j, {"\"front\"", "open", "edge 2", "edge 3", "order"});
  j = bodice();
  front(j)["vertices"][5] = {-24, 20};
  expect_refused(j, {"\"front\"", "crosses itself", "edge"});
  j = bodice();
  front(j)["edges"][4]["curvature"]["params"] = {{3.0, 2.0}};
  expect_refused(j, {"\"front\"", "crosses itself", "edge 4"});
  j = bodice();
  front(j)["vertices"].push_back({0, 3});
  expect_refused(j, {"\"front\"", "vertex 9 is on no edge"});
}

TEST(SewingPattern, NamesAPanelWithoutArea) {
  Json j = bodice();
  j["pattern"]["panels"]["frill"]["vertices"] = {{-50, 0}, {50, 0}, {50, 0.01}, {-50, 0.01}};
  expect_refused(j, {"\"frill\"", "area"});
  j = bodice();
  j["properties"]["units_in_meter"] = 1000000;
  expect_refused(j, {"area", "units_in_meter"});
  j = bodice();
  j["properties"]["units_in_meter"] = 0.01;
  expect_refused(j, {"beyond 50 m", "units_in_meter"});
}

TEST(SewingPattern, NamesAStitchAtFault) {
  Json j = bodice();
  j["pattern"]["stitches"][2][0]["edge"] = 4;
  expect_refused(j, {"stitch 2", "edge 4 of panel \"front\"", "already in stitch 1"});
  j = bodice();
  j["pattern"]["stitches"][2][1]["edge"] = 17;
  expect_refused(j, {"stitch 2", "edge 17", "0 to 5"});
  j = bodice();
  j["pattern"]["stitches"][2][1]["panel"] = "bakc";
  expect_refused(j, {"stitch 2", "\"bakc\""});
  j = bodice();
  j["pattern"]["stitches"][3][0] = {{"panel", "frill"}, {"edge", 0}};
  expect_refused(j, {"stitch 3", "1 m long", "at most 3 times"});
  j = bodice();
  j["pattern"]["stitches"].erase(5);
  expect_refused(j, {"\"frill\"", "no stitch"});
  j = bodice();
  j["pattern"]["stitches"][0][1] = j["pattern"]["stitches"][0][0];
  expect_refused(j, {"stitch 0", "already in stitch 0"});
  j = bodice();
  j["pattern"]["stitches"][0].push_back("left");
  expect_refused(j, {"stitch 0", "\"left\"", "right_wrong"});
}

TEST(SewingPattern, NamesAnArcOfAnImpossibleRadius) {
  for (const double radius : {9.0, 1e7}) {  // cm
    Json j = bodice();
    front(j)["edges"][6]["curvature"]["params"][0] = radius;
    expect_refused(j, {"\"front\"", "edge 6 is an arc of radius", "0.2 m apart"});
  }
}

// A thin angle along two sides of a square: three quarters of the box of the angle are the square.
TEST(SewingPattern, AcceptsAPanelThatSurroundsAnotherInItsPlane) {
  const auto panel = [](const std::vector<std::array<double, 2>>& vertices) {
    Json j = {{"vertices", vertices}, {"translation", {0, 0, 0}}, {"rotation", {0, 0, 0}}};
    for (std::size_t i = 0; i < vertices.size(); ++i)
      j["edges"].push_back({{"endpoints", {i, (i + 1) % vertices.size()}}});
    return j;
  };
  Json j = bodice();
  j["pattern"]["panels"] = {
      {"square", panel({{0, 0}, {28, 0}, {28, 28}, {0, 28}})},
      {"angle", panel({{-2, -2}, {30, -2}, {30, -0.5}, {-0.5, -0.5}, {-0.5, 30}, {-2, 30}})}};
  const auto side = [](const char* name, int edge) {
    return Json{{"panel", name}, {"edge", edge}};
  };
  j["pattern"]["stitches"] = Json::array({Json::array({side("square", 0), side("angle", 2)})});
  EXPECT_EQ(refusal(j), "");
  j["pattern"]["panels"]["angle"]["translation"] = {3, 3, 0};
  expect_refused(j, {"one place"});
}

TEST(SewingPattern, NamesPanelsInOnePlace) {
  Json j = bodice();
  j["pattern"]["panels"]["back"]["translation"] = {0, 0, 20};
  expect_refused(j, {"\"back\"", "\"front\"", "one place", "rotation or translation"});
  j["pattern"]["panels"]["back"]["translation"] = {0, 0, 20.5};
  EXPECT_EQ(refusal(j), "");
}

TEST(SewingPattern, TakesRightToWrongAsItsWord) {
  Json j = bodice();
  j["pattern"]["stitches"][3].push_back("right_wrong");
  EXPECT_EQ(parse_sewing_pattern(j.dump(), "p").stitches[3].direction,
            PatternStitch::Direction::start_to_start);
}

TEST(SewingPattern, RefusesTextThatIsNoPattern) {
  for (const std::string text :
       {"", "{", "[]", "null", "{}", "{\"pattern\": 3}", "{\"pattern\": {\"panels\": []}}",
        "\xff\xfe", "{\"pattern\": {\"panels\": {}}, \"properties\": {\"units_in_meter\": 100}}",
        "{\"pattern\": {\"panels\": {\"a\": 1, \"a\": 2}}}", "{\"x\": 1e999}"}) {
    const std::string message = refusal_of(text);
    EXPECT_TRUE(message.starts_with("p.json: ")) << text << ": " << message;
  }
  EXPECT_NE(refusal_of("{\"pattern\": {\"panels\": {\"a\": 1, \"a\": 2}}}").find("\"a\" twice"),
            std::string::npos);
  EXPECT_NE(refusal_of(std::string(100000, '[')).find("nested"), std::string::npos);
  EXPECT_THROW(read_sewing_pattern("no_such_file.json"), std::invalid_argument);
  EXPECT_THROW(read_sewing_pattern("."), std::invalid_argument);
}

/// All values of a document, so that one can be replaced.
void collect(Json& j, std::vector<Json*>& values) {
  values.push_back(&j);
  if (j.is_structured())
    for (Json& inner : j) collect(inner, values);
}

/// One change such as a careless program makes.
void mutilate(Json& j, std::mt19937& random) {
  std::vector<Json*> values;
  collect(j, values);
  Json& value = *values[1 + random() % (values.size() - 1)];
  switch (random() % 10) {
    case 0:
      value = nullptr;
      break;
    case 1:
      value = "text";
      break;
    case 2:
      value = -1;
      break;
    case 3:
      value = 1e300;
      break;
    case 4:
      value = Json::array();
      break;
    case 5:
      value = Json::object();
      break;
    case 6:
      value = value.is_number() ? Json(value.get<double>() * 1e6) : Json(true);
      break;
    case 7:
      if (value.is_structured() && !value.empty())
        value.erase(value.is_array() ? value.begin()
                                     : std::next(value.begin(), random() % value.size()));
      else
        value = 0;
      break;
    case 8:
      if (value.is_array() && value.size() > 1)
        std::swap(value[random() % value.size()], value[random() % value.size()]);
      else
        value = 7;
      break;
    default:
      if (value.is_array() && !value.empty())
        value.push_back(value[random() % value.size()]);
      else
        value = 0.5;
  }
}

TEST(SewingPattern, IsReadOrRefusedInOneSentenceHoweverItIsMutilated) {
  std::mt19937 random(20);
  int refused = 0;
  for (int k = 0; k < 400; ++k) {
    Json j = Json::parse(k % 2 == 0 ? garment_patterns::kBodice : garment_patterns::kSkirt);
    for (int change = 0; change <= k % 3; ++change) mutilate(j, random);
    try {
      const SewingPattern pattern = parse_sewing_pattern(j.dump(), "p.json");
      const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = 0.1});
      EXPECT_GT(mesh.quality.triangles, 0);
    } catch (const std::invalid_argument& error) {
      const std::string message = error.what();
      EXPECT_TRUE(message.starts_with("p.json: ")) << message << " of change " << k;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      EXPECT_LT(message.size(), 400u) << message;
      ++refused;
    }
  }
  EXPECT_GT(refused, 200);
  EXPECT_LT(refused, 400) << "some changes, such as that of a parameter, do no harm";
}

TEST(SewingPattern, OfCutTextIsRefused) {
  const std::string& text = garment_patterns::kBodice;
  for (std::size_t size = 0; size + 2 < text.size(); size += 97)
    EXPECT_TRUE(refusal_of(text.substr(0, size)).starts_with("p.json: "));
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

TEST(PatternSheet, HasRoomForEveryPanel) {
  const std::string svg =
      pattern_svg(parse_sewing_pattern(garment_patterns::kBodice, "folder/p.json"));
  double width = 0.0, height = 0.0;
  ASSERT_EQ(
      std::sscanf(svg.c_str() + svg.find("viewBox="), "viewBox=\"0 0 %lf %lf\"", &width, &height),
      2);
  std::size_t points = 0;
  for (std::size_t path = svg.find("<path d=\"M"); path != std::string::npos;
       path = svg.find("<path d=\"M", path + 1)) {
    const std::string drawn = svg.substr(path + 9, svg.find('"', path + 9) - path - 9);
    for (std::size_t at = drawn.find_first_of("ML"); at != std::string::npos;
         at = drawn.find_first_of("ML", at + 1)) {
      double x = 0.0, y = 0.0;
      if (std::sscanf(drawn.c_str() + at + 1, "%lf %lf", &x, &y) != 2) continue;
      ++points;
      EXPECT_TRUE(x >= 0.0 && x <= width && y >= 0.0 && y <= height) << x << " " << y;
    }
  }
  EXPECT_GT(points, 19u);
}

TEST(PatternSheet, HasEveryPanelEdgeAndStitch) {
  Json j = bodice();
  j["pattern"]["panels"]["a<b> & \"c\""] = front(j);
  j["pattern"]["panels"].erase("front");
  for (auto& stitch : j["pattern"]["stitches"])
    for (auto& side : stitch)
      if (side["panel"] == "front") side["panel"] = "a<b> & \"c\"";
  const std::string svg = pattern_svg(parse_sewing_pattern(j.dump(), "folder/p.json"));
  EXPECT_TRUE(svg.starts_with("<svg "));
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
  EXPECT_EQ(count_of(svg, "<path d=\"M"), 3u + 1u) << "panels and the bar of the scale";
  EXPECT_EQ(count_of(svg, "<polyline"), 19u);
  EXPECT_EQ(count_of(svg, "<circle"), 2u * 12u)
      << "a number and a mark for each side of six stitches";
  EXPECT_NE(svg.find(">a&lt;b&gt; &amp; &quot;c&quot;<"), std::string::npos);
  EXPECT_EQ(count_of(svg, ">lower_interface<"), 2u);
  EXPECT_EQ(count_of(svg, "nan"), 0u);
  // Both sides of a stitch have one colour: the number of the stitch, its mark and the edge.
  const std::size_t at = svg.find("stroke=\"hsl(");
  const std::string colour = svg.substr(at + 8, svg.find('"', at + 8) - at - 8);
  EXPECT_EQ(count_of(svg, colour), 6u);
}

}  // namespace

}  // namespace selvedge::garment_pattern_test
