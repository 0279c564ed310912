// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/garment/panel_mesh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <random>
#include <string>

#include "garment_patterns.h"

namespace selvedge::short_edges_test {
namespace {

namespace fs = std::filesystem;

/// A star-shaped loop of a few corners, with runs of edges of 0.05 to 3 mm at some of them, as
/// trimming and chords of small curves leave them.
std::vector<Vec2> random_loop(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const int corners = 3 + static_cast<int>(between(0.0, 8.0));
  const double size = between(0.03, 0.12);
  std::vector<Vec2> loop;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + between(0.0, 0.4)) / corners;
    const Vec2 out(std::cos(angle), std::sin(angle)), along(-out.y(), out.x());
    Vec2 p = size * between(0.6, 1.0) * out;
    loop.push_back(p);
    if (between(0.0, 1.0) < 0.4) continue;
    for (int k = static_cast<int>(between(1.0, 8.0)); k > 0; --k) {
      const double length = 5e-5 * std::pow(60.0, between(0.0, 1.0));
      p += length * (along + between(-0.8, 0.8) * out).normalized();
      loop.push_back(p);
    }
  }
  return loop;
}

PatternPanel panel_of(const std::string& name, const std::vector<Vec2>& loop, double y) {
  PatternPanel panel;
  panel.name = name;
  panel.vertices = loop;
  const auto n = static_cast<std::int32_t>(loop.size());
  for (std::int32_t i = 0; i < n; ++i)
    panel.edges.push_back({.endpoints = {i, (i + 1) % n}, .curve = {}, .label = ""});
  panel.translation = Vec3(0.0, y, 0.0);
  panel.rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return panel;
}

/// A front, and the same panel behind it. Every second edge is sewn.
SewingPattern random_pattern(std::mt19937& random) {
  const std::vector<Vec2> loop = random_loop(random);
  SewingPattern pattern{.name = "random", .panels = {}, .stitches = {}};
  pattern.panels = {panel_of("front", loop, -0.2), panel_of("back", loop, 0.2)};
  for (std::int32_t e = 0; e < static_cast<std::int32_t>(loop.size()); e += 2)
    pattern.stitches.push_back({{0, e}, {1, e}});
  return pattern;
}

double perimeter(const PatternPanel& panel) {
  double sum = 0.0;
  for (std::int32_t e = 0; e < static_cast<std::int32_t>(panel.edges.size()); ++e)
    sum += edge_length(panel, e);
  return sum;
}

// The work of the mesher is proportional to the number of vertices.
TEST(ShortEdges, AThousandPanelsHaveVerticesInProportionToTheirArea) {
  std::mt19937 random(44);
  int meshed = 0, joined = 0;
  while (meshed < 1000) {
    const SewingPattern pattern = random_pattern(random);
    try {
      check_sewing_pattern(pattern);
    } catch (const std::invalid_argument&) {
      continue;  // the runs may cross
    }
    ++meshed;
    SCOPED_TRACE(meshed);
    const double h = std::array{0.01, 0.015, 0.025}[static_cast<std::size_t>(meshed) % 3];
    const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = h});
    joined += static_cast<int>(!mesh.notes.empty() &&
                               mesh.notes[0].find("joined with") != std::string::npos);
    const double area = std::abs(panel_area(pattern.panels[0])),
                 around = perimeter(pattern.panels[0]);
    // An equilateral mesh has 1.15 vertices for each square of its edge length. A side at the limit
    // of joining has up to 30 more around it.
    EXPECT_LT(static_cast<double>(mesh.panel_quality[0].vertices),
              1.6 * area / (h * h) + 3.0 * around / h +
                  30.0 * static_cast<double>(pattern.panels[0].edges.size()));
    EXPECT_NEAR(mesh.panel_quality[0].area, area, 0.2 * h * around);
    validate(mesh.flat, "flat");
    EXPECT_GT(mesh.quality.shortest, 0.02 * h);
    for (const GarmentMesh::Stitch& s : mesh.stitches) {
      ASSERT_EQ(s.a.size(), s.b.size());
      EXPECT_EQ(std::count(s.a.begin(), s.a.end(), s.a[0]), 1) << "no vertex stands twice";
    }
  }
  EXPECT_GT(joined, 600);
}

TEST(ShortEdges, TheSurfaceMovesByLessThanTheEdgesThatAreJoined) {
  std::mt19937 random(45);
  for (int seed = 0; seed < 60; ++seed) {
    const SewingPattern pattern = random_pattern(random);
    try {
      check_sewing_pattern(pattern);
    } catch (const std::invalid_argument&) {
      continue;
    }
    constexpr double h = 0.01;
    const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = h});
    for (std::size_t e = 0; e < pattern.panels[0].edges.size(); ++e)
      for (const bool last : {false, true}) {
        const std::vector<std::int32_t>& along = mesh.edge_vertices[0][e];
        const Vec3& x = mesh.placed[last ? along.back() : along.front()];
        const Vec2& v = pattern.panels[0].vertices[pattern.panels[0].edges[e].endpoints[last]];
        EXPECT_LT((x - place_point(pattern.panels[0], v)).norm(), 0.2 * h) << seed;
      }
  }
}

TEST(ShortEdges, ACurveOfManyChordsKeepsItsShape) {
  std::vector<Vec2> circle;
  for (int i = 0; i < 3000; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 3000;
    circle.emplace_back(0.1 * std::cos(angle), 0.1 * std::sin(angle));
  }
  SewingPattern pattern{.name = "disc", .panels = {panel_of("disc", circle, 0.0)}, .stitches = {}};
  const GarmentMesh mesh = mesh_garment(pattern, {.edge_length = 0.01});
  const double area = std::numbers::pi * 0.01;
  EXPECT_NEAR(mesh.quality.area, area, 0.002 * area);
  EXPECT_LT(mesh.quality.vertices, 4000);
  ASSERT_EQ(mesh.notes.size(), 1u);
  EXPECT_NE(mesh.notes[0].find("others are shorter than 2 mm"), std::string::npos) << mesh.notes[0];
}

// ---- faults that are named -------------------------------------------------------------------

std::string refusal(const SewingPattern& pattern) {
  try {
    check_sewing_pattern(pattern);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(PatternFaults, ABowtieIsToldThatItCrossesItself) {
  std::mt19937 random(46);
  std::uniform_real_distribution<double> part(0.02, 0.4), turn(0.0, 6.0);
  for (int seed = 0; seed < 100; ++seed) {
    const double w = part(random), h = part(random), angle = turn(random);
    const Eigen::Rotation2Dd rotation(angle);
    // The halves of a symmetric one have areas of opposite signs, so the sum is 0.
    std::vector<Vec2> loop;
    for (const Vec2& p : {Vec2(0, 0), Vec2(w, h), Vec2(w, 0), Vec2(0, h)})
      loop.push_back(rotation * p);
    SewingPattern pattern{.name = "tie", .panels = {panel_of("bow", loop, 0.0)}, .stitches = {}};
    const std::string message = refusal(pattern);
    EXPECT_NE(message.find("crosses itself"), std::string::npos) << message;
  }
}

/// The same panel with its edges in the other order.
PatternPanel reversed(PatternPanel panel) {
  std::reverse(panel.edges.begin(), panel.edges.end());
  for (PatternEdge& edge : panel.edges) {
    std::swap(edge.endpoints[0], edge.endpoints[1]);
    if (edge.curve.kind == PatternCurve::Kind::cubic)
      std::swap(edge.curve.control[0], edge.curve.control[1]);
    edge.curve.clockwise = !edge.curve.clockwise;
  }
  return panel;
}

/// The same pattern with the loop of one panel the other way round.
SewingPattern with_reversed(SewingPattern pattern, std::size_t p) {
  pattern.panels[p] = reversed(pattern.panels[p]);
  const auto last = static_cast<std::int32_t>(pattern.panels[p].edges.size()) - 1;
  for (PatternStitch& s : pattern.stitches)
    for (PatternStitch::Side* side : {&s.a, &s.b})
      if (side->panel == static_cast<std::int32_t>(p) && side->edge <= last)
        side->edge = last - side->edge;
  return pattern;
}

/// Our patterns; with `file`, the file says which ends of all seams meet.
std::vector<SewingPattern> own_patterns(bool file) {
  std::vector<SewingPattern> patterns;
  for (const auto& entry :
       fs::directory_iterator(fs::path(SELVEDGE_SOURCE_DIR) / "data/patterns")) {
    if (entry.path().extension() != ".json") continue;
    SewingPattern pattern = read_sewing_pattern(entry.path());
    const std::vector<SeamDirection> directions = seam_directions(pattern);
    for (std::size_t s = 0; s < directions.size(); ++s)
      pattern.stitches[s].direction = !file ? PatternStitch::Direction::unknown
                                      : directions[s].start_to_start
                                          ? PatternStitch::Direction::start_to_start
                                          : PatternStitch::Direction::end_to_start;
    patterns.push_back(std::move(pattern));
  }
  return patterns;
}

TEST(PatternFaults, APanelThatRunsTheWrongWayRoundIsNamed) {
  std::mt19937 random(48);
  std::normal_distribution<double> part;
  std::uniform_real_distribution<double> degrees(-15.0, 15.0);
  for (const SewingPattern& own : own_patterns(true))
    for (int k = 0; k < 5; ++k) {
      // As they are, and then with each panel turned a little about an axis of its own.
      SewingPattern pattern = own;
      for (PatternPanel& panel : pattern.panels)
        if (k > 0)
          panel.rotation =
              Eigen::AngleAxisd(degrees(random) * std::numbers::pi / 180.0,
                                Vec3(part(random), part(random), part(random)).normalized()) *
              panel.rotation;
      EXPECT_EQ(refusal(pattern), "") << k;
      for (std::size_t p = 0; p < pattern.panels.size(); ++p) {
        const std::string message = refusal(with_reversed(pattern, p));
        EXPECT_NE(message.find("panel \"" + pattern.panels[p].name + "\""), std::string::npos)
            << pattern.name << " " << pattern.panels[p].name << " " << k << ": " << message;
        EXPECT_NE(message.find("twisted"), std::string::npos) << message;
      }
    }
}

TEST(PatternFaults, WithoutDirectionsAnyLoopSewsTheSameEnds) {
  for (const SewingPattern& pattern : own_patterns(false)) {
    const std::vector<SeamDirection> directions = seam_directions(pattern);
    for (std::size_t p = 0; p < pattern.panels.size(); ++p) {
      const SewingPattern other = with_reversed(pattern, p);
      EXPECT_EQ(refusal(other), "");
      const std::vector<SeamDirection> after = seam_directions(other);
      for (std::size_t s = 0; s < after.size(); ++s) {
        const PatternStitch& stitch = pattern.stitches[s];
        const bool is_reversed = (stitch.a.panel == static_cast<std::int32_t>(p)) !=
                                 (stitch.b.panel == static_cast<std::int32_t>(p));
        EXPECT_EQ(after[s].start_to_start != directions[s].start_to_start, is_reversed)
            << pattern.name << " " << pattern.panels[p].name << " " << s;
      }
    }
  }
}

TEST(PatternFaults, APanelThatHangsByOneSeamMayFaceEitherWay) {
  SewingPattern pattern{
      .name = "facing",
      .panels = {panel_of("skirt", {{0, 0}, {0.4, 0}, {0.4, 0.5}, {0, 0.5}}, 0.0),
                 panel_of("facing", {{0, 0}, {0.4, 0}, {0.4, 0.3}, {0, 0.3}}, 0.01)},
      .stitches = {{{0, 0}, {1, 0}, PatternStitch::Direction::end_to_start}}};
  EXPECT_EQ(refusal(pattern), "");
  pattern.stitches.push_back({{0, 1}, {1, 1}, PatternStitch::Direction::end_to_start});
  EXPECT_NE(refusal(pattern).find("are twisted as the panels stand"), std::string::npos);
}

}  // namespace
}  // namespace selvedge::short_edges_test
