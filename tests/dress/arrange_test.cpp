// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/dress.h>
#include <selvedge/dress/internal/arrange.h>
#include <selvedge/garment/panel_mesh.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace selvedge::arrange_test {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(SELVEDGE_SOURCE_DIR) / "data";
const fs::path kShared = fs::path(SELVEDGE_SOURCE_DIR).parent_path() / "shared/data/garments";

const TriangleMesh& mannequin() {
  static const TriangleMesh body = read_mesh(kData / "bodies" / "mannequin_arms_out.ply");
  return body;
}

SewingPattern stripped(SewingPattern pattern) {
  for (PatternPanel& panel : pattern.panels) {
    panel.translation.setZero();
    panel.rotation.setIdentity();
  }
  return pattern;
}

Vec3 middle_of(const PatternPanel& panel) {
  Vec3 sum = Vec3::Zero();
  for (const Vec2& v : panel.vertices) sum += place_point(panel, v);
  return sum / static_cast<double>(panel.vertices.size());
}

Vec3 outward(const PatternPanel& panel) {
  return panel_area(panel) < 0.0 ? Vec3(-panel.rotation.col(2)) : Vec3(panel.rotation.col(2));
}

/// The panels stand where somebody placed them, and every seam joins the same ends.
void expect_as_placed(const SewingPattern& placed, const TriangleMesh& body, double nearer,
                      double cosine) {
  const Arrangement a = arrange(stripped(placed), body, find_landmarks(body));
  for (std::size_t p = 0; p < placed.panels.size(); ++p) {
    const PatternPanel &is = a.pattern.panels[p], &was = placed.panels[p];
    EXPECT_LT((middle_of(is) - middle_of(was)).norm(), nearer)
        << placed.name << ": " << is.name << " as " << a.roles[p].text();
    EXPECT_GT(outward(is).dot(outward(was)), cosine)
        << placed.name << ": " << is.name << " as " << a.roles[p].text();
  }
  const std::vector<SeamDirection> was = seam_directions(placed), is = seam_directions(a.pattern);
  for (std::size_t s = 0; s < was.size(); ++s)
    EXPECT_EQ(is[s].start_to_start, was[s].start_to_start) << placed.name << ": stitch " << s;
  EXPECT_NO_THROW(check_sewing_pattern(a.pattern));
}

TEST(Arrange, OurOwnPatternsStandAsTheirMakerPlacedThem) {
  for (const char* name : {"dress_with_darts", "flared_skirt", "hooded_top", "tee", "trousers"})
    expect_as_placed(read_sewing_pattern(kData / "patterns" / (std::string(name) + ".json")),
                     mannequin(), 0.12, 0.7);
}

TEST(Arrange, ForeignPatternsStandAsTheirMakersPlacedThem) {
  if (!fs::exists(kShared)) GTEST_SKIP() << kShared << " is not there";
  for (const auto& entry : fs::directory_iterator(kShared / "patterns")) {
    const std::string name = entry.path().filename();
    const bool is_newer = name.ends_with("_specification.json");
    // The legs' part of this pattern stands 0.2 m from where its bodice ends.
    const double nearer = name.starts_with("dress_pencil") ? 0.25 : 0.16;
    const TriangleMesh body = load_mesh(
        kShared / "bodies" / (is_newer ? "f_smpl_average_A40.obj" : "f_smpl_template.obj"),
        {.up = UpAxis::y});
    expect_as_placed(turned_upright(read_sewing_pattern(entry.path()), UpAxis::y), body, nearer,
                     0.5);
  }
}

/// A crotch fits its mirror image best when one leg lies across; legs hang all the same.
TEST(Arrange, MirroredLegsHang) {
  const auto leg = [](double sign) {
    PatternPanel panel;
    panel.name = sign > 0.0 ? "front.left" : "front.right";
    const std::vector<Vec2> outline = {{0.05, 0.0}, {0.22, 0.0},  {0.25, 0.95},
                                       {0.06, 1.0}, {0.02, 0.76}, {-0.04, 0.72}};
    for (const Vec2& p : outline) panel.vertices.emplace_back(sign * p.x(), p.y());
    for (std::int32_t i = 0; i < 6; ++i) panel.edges.push_back({{i, (i + 1) % 6}, {}, ""});
    if (sign < 0.0) {
      std::reverse(panel.edges.begin(), panel.edges.end());
      for (PatternEdge& edge : panel.edges) std::swap(edge.endpoints[0], edge.endpoints[1]);
    }
    return panel;
  };
  SewingPattern trousers;
  trousers.name = "trousers";
  for (const char* face : {"front", "back"})
    for (const double sign : {1.0, -1.0}) {
      trousers.panels.push_back(leg(face == std::string("front") ? sign : -sign));
      trousers.panels.back().name = std::string(face) + (sign > 0.0 ? ".left" : ".right");
    }
  // Edges of a mirrored panel run the other way: e becomes 5 - e.
  using Direction = PatternStitch::Direction;
  for (const auto& [a, b, mirrored] : {std::tuple(0, 1, false), std::tuple(2, 3, true)})
    for (const std::int32_t e : {3, 4}) {
      const std::int32_t own = mirrored ? 5 - e : e;
      trousers.stitches.push_back({{a, own}, {b, 5 - own}, Direction::end_to_start});
    }
  for (const auto& [a, b] : {std::pair(0, 2), std::pair(1, 3)})
    for (const std::int32_t e : {1, 5}) {
      const std::int32_t own = a == 0 ? e : 5 - e;
      trousers.stitches.push_back({{a, own}, {b, 5 - own}, Direction::end_to_start});
    }
  const Arrangement a = arrange(trousers, mannequin(), find_landmarks(mannequin()));
  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_EQ(a.roles[p].part, PanelRole::Part::leg) << a.roles[p].text();
    EXPECT_GT(a.pattern.panels[p].rotation(2, 1), 0.99) << a.pattern.panels[p].name;
  }
}

TEST(Arrange, NamesGiveRoles) {
  const auto role = [](const char* name) { return role_of_name(name).text(); };
  EXPECT_EQ(role("lfsleeve"), "sleeve.left.front");
  EXPECT_EQ(role("left_ftorso"), "torso.left.front");
  EXPECT_EQ(role("Rback"), "unknown.right.back");
  EXPECT_EQ(role("wb_front"), "waistband.front");
  EXPECT_EQ(role("skirt_back"), "skirt.back");
  EXPECT_EQ(role("top_front"), "torso.front");
  EXPECT_EQ(role("sleeve.left"), "sleeve.left");
  EXPECT_EQ(role("Left Trouser Leg Back"), "leg.left.back");
  EXPECT_EQ(role("Lhood"), "hood.left");
  EXPECT_EQ(role("right_0"), "unknown.right");
  EXPECT_EQ(role("piece 3"), "unknown");
  EXPECT_EQ(role("floral"), "unknown");
  EXPECT_EQ(role(""), "unknown");
}

/// Without names: by openings, seams and areas.
TEST(Arrange, PanelsWithoutNamesAreFoundByTheirSeams) {
  SewingPattern tee = read_sewing_pattern(kData / "patterns" / "flared_skirt.json");
  std::vector<PanelRole> named, unnamed;
  std::vector<std::string> why;
  SewingPattern skirt = stripped(read_sewing_pattern(kData / "patterns" / "flared_skirt.json"));
  for (std::size_t p = 0; p < skirt.panels.size(); ++p)
    if (skirt.panels[p].name == "front" || skirt.panels[p].name == "back")
      skirt.panels[p].name = "piece " + std::to_string(p);
  unnamed = panel_roles(skirt, {}, why);
  named = panel_roles(tee, {}, why);
  for (std::size_t p = 0; p < named.size(); ++p) EXPECT_EQ(unnamed[p].part, named[p].part) << p;
}

TEST(Arrange, TheTableGoesBeforeTheNames) {
  const SewingPattern skirt =
      stripped(read_sewing_pattern(kData / "patterns" / "flared_skirt.json"));
  std::vector<std::string> why;
  const std::string name = skirt.panels[0].name;
  const std::vector<PanelRole> roles = panel_roles(skirt, {.table = {{name, "sleeve.left"}}}, why);
  EXPECT_EQ(roles[0].text(), "sleeve.left");
  EXPECT_EQ(why[0], "table");
  EXPECT_THROW(panel_roles(skirt, {.table = {{"nobody", "front"}}}, why), std::invalid_argument);
  EXPECT_THROW(panel_roles(skirt, {.table = {{name, "xyz"}}}, why), std::invalid_argument);
}

TEST(Arrange, TheTextOfAPatternIsReadBack) {
  const BodyLandmarks marks = find_landmarks(mannequin());
  SewingPattern tee = read_sewing_pattern(kData / "patterns" / "dress_with_darts.json");
  tee.panels[0].bend = {.radius = 0.2, .at = {0.1, 0.0}, .axis = {0.6, 0.8}};
  tee.panels[0].edges[1].curve = {
      .kind = PatternCurve::Kind::arc, .radius = 2.0, .clockwise = true};
  const SewingPattern again =
      parse_sewing_pattern(sewing_pattern_text(tee), "again", {.places = false});
  ASSERT_EQ(again.panels.size(), tee.panels.size());
  for (const PatternPanel& is : again.panels) {
    const auto was = std::find_if(tee.panels.begin(), tee.panels.end(),
                                  [&](const PatternPanel& p) { return p.name == is.name; });
    ASSERT_NE(was, tee.panels.end());
    ASSERT_EQ(is.edges.size(), was->edges.size());
    EXPECT_NEAR(panel_area(is), panel_area(*was), 1e-9);
    for (std::int32_t e = 0; e < static_cast<std::int32_t>(is.edges.size()); ++e)
      for (const double t : {0.0, 0.3, 1.0})
        EXPECT_LT(
            (place_point(is, edge_point(is, e, t)) - place_point(*was, edge_point(*was, e, t)))
                .norm(),
            1e-9);
  }
  EXPECT_EQ(again.stitches.size(), tee.stitches.size());
}

/// A bend keeps lengths along the panel, and the outer side outside.
TEST(Arrange, ABentPanelKeepsItsLengths) {
  PatternPanel panel;
  panel.vertices = {{0, 0}, {0.3, 0}, {0.3, 0.2}, {0, 0.2}};
  for (std::int32_t i = 0; i < 4; ++i) panel.edges.push_back({{i, (i + 1) % 4}, {}, ""});
  panel.bend = {.radius = 0.05, .at = {0.15, 0.1}, .axis = {0, 1}};
  double length = 0.0;
  for (int i = 0; i < 1000; ++i)
    length += (place_point(panel, {0.3 * (i + 1) / 1000, 0.0}) -
               place_point(panel, {0.3 * i / 1000, 0.0}))
                  .norm();
  EXPECT_NEAR(length, 0.3, 1e-5);
  EXPECT_NEAR((place_point(panel, {0.15, 0.0}) - Vec3(0.15, 0.0, 0.0)).norm(), 0.0, 1e-12);
  for (const double x : {0.0, 0.1, 0.25})
    EXPECT_NEAR((place_point(panel, {x, 0.1}) - Vec3(0.15, 0.1, -0.05)).norm(), 0.05, 1e-12);
}

TEST(Arrange, AStrippedPatternDressesAsWithItsPlaces) {
  DressConfig config;
  config.edge_length = config.sewing_edge_length = 0.04;
  const SewingPattern placed = read_sewing_pattern(kData / "patterns" / "flared_skirt.json");
  const DressResult was = dress(placed, mannequin(), config);
  const DressResult is =
      dress(arrange(stripped(placed), mannequin(), find_landmarks(mannequin())).pattern,
            mannequin(), config);
  EXPECT_TRUE(was.good()) << was.verdict();
  EXPECT_TRUE(is.worn()) << is.verdict();  // corners differ by 1.1 cm from their images
  const auto height = [](const DressResult& r) {
    double sum = 0.0;
    for (const Vec3& x : r.garment.vertices) sum += x.z();
    return sum / static_cast<double>(r.garment.vertices.size());
  };
  EXPECT_NEAR(height(is), height(was), 0.03);
}

TEST(Arrange, TheDrawingShowsEveryPanel) {
  const BodyLandmarks marks = find_landmarks(mannequin());
  const Arrangement a =
      arrange(stripped(read_sewing_pattern(kData / "patterns" / "tee.json")), mannequin(), marks);
  const std::string svg = arrangement_svg(a, mannequin(), marks);
  for (const PatternPanel& panel : a.pattern.panels)
    EXPECT_NE(svg.find(">" + panel.name + "<"), std::string::npos);
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
}

}  // namespace
}  // namespace selvedge::arrange_test
