// SPDX-License-Identifier: MIT
// Patterns in DXF that name no seam, to a garment that can be put on.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/dress/dress.h>
#include <selvedge/dress/internal/arrange.h>
#include <selvedge/garment/internal/pattern_files.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace selvedge::guess_seams_test {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(SELVEDGE_SOURCE_DIR) / "data";

/// The file of a pattern, without the annotations that name its seams.
fs::path plain_dxf(const char* name) {
  const SewingPattern pattern =
      read_sewing_pattern(kData / "patterns" / (std::string(name) + ".json"));
  std::string text = dxf_pattern_text(pattern);
  text = std::regex_replace(text, std::regex("Seam [0-9]+"), "without meaning");
  const fs::path file = fs::temp_directory_path() / (std::string("selvedge_") + name + ".dxf");
  std::ofstream(file) << text;
  return file;
}

std::string shape_of(const SewingPattern& pattern) {
  std::multiset<std::string> seams;
  for (const PatternStitch& s : pattern.stitches) {
    std::string a = pattern.panels[s.a.panel].name, b = pattern.panels[s.b.panel].name;
    if (b < a) std::swap(a, b);
    seams.insert(a + "-" + b);
  }
  std::string text;
  for (const std::string& seam : seams) text += seam + " ";
  return text;
}

/// The seams join the same panels as those that its maker drew.
TEST(GuessSeams, TrousersHaveTheSeamsOfTheirMaker) {
  std::vector<std::string> notes;
  const SewingPattern trousers = open_pattern(plain_dxf("trousers"), {}, notes);
  EXPECT_EQ(shape_of(trousers),
            shape_of(read_sewing_pattern(kData / "patterns" / "trousers.json")));
  for (const PatternStitch& s : trousers.stitches) {
    const double a = edge_length(trousers.panels[s.a.panel], s.a.edge),
                 b = edge_length(trousers.panels[s.b.panel], s.b.edge);
    EXPECT_LT(std::max(a, b), 1.3 * std::min(a, b));
  }
  std::vector<std::string> why;
  for (const PanelRole& role : panel_roles(trousers, {}, why))
    EXPECT_EQ(role.part, PanelRole::Part::leg);
}

TEST(GuessSeams, ASkirtWithItsBandIsPutOn) {
  std::vector<std::string> notes;
  const SewingPattern skirt = open_pattern(plain_dxf("flared_skirt"), {}, notes);
  EXPECT_EQ(shape_of(skirt),
            shape_of(read_sewing_pattern(kData / "patterns" / "flared_skirt.json")));
  const TriangleMesh body = read_mesh(kData / "bodies" / "mannequin_arms_out.ply");
  DressConfig config;
  config.edge_length = config.sewing_edge_length = 0.04;
  const DressResult r = dress(arrange(skirt, body, find_landmarks(body)).pattern, body, config);
  EXPECT_TRUE(r.worn()) << r.verdict();
}

std::string piece(const std::string& name, const std::vector<Vec2>& outline,
                  const std::string& more) {
  std::string text = "0\nBLOCK\n8\n1\n2\n" + name +
                     "\n0\nTEXT\n8\n1\n10\n0\n20\n0\n1\nPiece Name: " + name + "\n" + more +
                     "0\nPOLYLINE\n8\n1\n66\n1\n70\n1\n";
  for (const Vec2& p : outline)
    text +=
        "0\nVERTEX\n8\n1\n10\n" + std::to_string(p.x()) + "\n20\n" + std::to_string(p.y()) + "\n";
  return text + "0\nSEQEND\n0\nENDBLK\n";
}

/// A tee as a cutter gets it: front and back on the fold, the sleeve twice.
TEST(GuessSeams, ATeeOnTheFoldWithAPairOfSleeves) {
  const auto body = [](double neck) {
    return std::vector<Vec2>{{0, 0},
                             {240, 0},
                             {240, 400},
                             {200, 430},
                             {190, 580},
                             {80, 610},
                             {40, 610 - 0.6 * neck},
                             {0, 610 - neck}};
  };
  const std::string fold = "0\nLINE\n8\n6\n10\n0\n20\n0\n11\n0\n21\n";
  const std::string text =
      "0\nSECTION\n2\nBLOCKS\n" + piece("FRONT", body(80), fold + "530\n") +
      piece("BACK", body(25), fold + "585\n") +
      piece("SLEEVE",
            {{-150, 0}, {150, 0}, {165, 150}, {90, 215}, {0, 255}, {-90, 215}, {-165, 150}},
            "0\nTEXT\n8\n1\n10\n0\n20\n0\n1\nQuantity: 2\n") +
      "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nTEXT\n8\n1\n10\n0\n20\n0\n1\nUnits: "
      "METRIC\n0\nENDSEC\n0\nEOF\n";
  const fs::path file = fs::temp_directory_path() / "selvedge_fold_tee.dxf";
  std::ofstream(file) << text;
  std::vector<std::string> notes;
  const SewingPattern tee = open_pattern(file, {}, notes);
  ASSERT_EQ(tee.panels.size(), 4u);
  std::map<std::string, double> length;
  for (const PatternStitch& s : tee.stitches) {
    std::string a = tee.panels[s.a.panel].name, b = tee.panels[s.b.panel].name;
    length[std::min(a, b) + "-" + std::max(a, b)] += edge_length(tee.panels[s.a.panel], s.a.edge);
  }
  // Sides and shoulders, each sleeve with itself and with both armholes.
  ASSERT_EQ(length.size(), 7u);
  EXPECT_NEAR(length["BACK-FRONT"], 2.0 * (0.400 + 0.1140), 0.01);
  EXPECT_NEAR(length["SLEEVE.left-SLEEVE.left"], 0.1507, 0.001);
  EXPECT_NEAR(length["FRONT-SLEEVE.left"], length["FRONT-SLEEVE.right"], 0.003);
  EXPECT_NEAR(length["FRONT-SLEEVE.left"], length["BACK-SLEEVE.left"], 0.01);
  // The cap of each side meets the front with its front half.
  const TriangleMesh mannequin = read_mesh(kData / "bodies" / "mannequin_arms_out.ply");
  const Arrangement placed = arrange(tee, mannequin, find_landmarks(mannequin));
  for (const PatternStitch& s : placed.pattern.stitches) {
    const PatternPanel &a = placed.pattern.panels[s.a.panel], &b = placed.pattern.panels[s.b.panel];
    if (a.name == b.name) continue;
    const Vec3 p = place_point(a, edge_point(a, s.a.edge, 0.5)),
               q = place_point(b, edge_point(b, s.b.edge, 0.5));
    EXPECT_LT(std::abs(p.x() - q.x()), 0.15)
        << a.name << " to " << b.name;  // the same side of the body
  }
  EXPECT_NO_THROW(check_sewing_pattern(placed.pattern));
}

TEST(GuessSeams, WhatHasNoSeamIsNamed) {
  const fs::path file = fs::temp_directory_path() / "selvedge_nothing.dxf";
  std::ofstream(file) << "0\nSECTION\n2\nBLOCKS\n" + piece("X", {{0, 0}, {300, 0}, {0, 300}}, "") +
                             piece("Y", {{0, 0}, {300, 0}, {0, 300}}, "") + "0\nENDSEC\n0\nEOF\n";
  std::vector<std::string> notes;
  try {
    open_pattern(file, {}, notes);
    FAIL();
  } catch (const std::invalid_argument& fault) {
    EXPECT_NE(std::string(fault.what()).find("no stitch holds it"), std::string::npos)
        << fault.what();
    EXPECT_NE(std::string(fault.what()).find("no seam of it is guessed"), std::string::npos)
        << fault.what();
  }
}

}  // namespace
}  // namespace selvedge::guess_seams_test
