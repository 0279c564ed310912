// SPDX-License-Identifier: MIT
// Pattern pieces in DXF and SVG: files of our own, damaged ones among them.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <selvedge/garment/internal/pattern_files.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge::pattern_files_test {
namespace {

using Points = std::vector<Vec2>;

std::string group(int code, const std::string& value) {
  return fmt::format("  {}\n{}\n", code, value);
}

std::string at(const Vec2& p, int x = 10) {
  return group(x, fmt::format("{}", p.x())) + group(x + 10, fmt::format("{}", p.y()));
}

std::string polyline(const std::string& layer, const Points& points, bool closed = true) {
  std::string text =
      group(0, "POLYLINE") + group(8, layer) + group(66, "1") + group(70, closed ? "1" : "0");
  for (const Vec2& p : points) text += group(0, "VERTEX") + group(8, layer) + at(p);
  return text + group(0, "SEQEND");
}

std::string light(const std::string& layer, const Points& points,
                  const std::vector<double>& bulges = {}) {
  std::string text = group(0, "LWPOLYLINE") + group(8, layer) +
                     group(90, std::to_string(points.size())) + group(70, "1");
  for (std::size_t i = 0; i < points.size(); ++i) {
    text += at(points[i]);
    if (!bulges.empty()) text += group(42, fmt::format("{}", bulges[i]));
  }
  return text;
}

std::string segment(const std::string& layer, const Vec2& a, const Vec2& b) {
  return group(0, "LINE") + group(8, layer) + at(a) + at(b, 11);
}
std::string mark(const std::string& layer, const Vec2& p) {
  return group(0, "POINT") + group(8, layer) + at(p);
}
std::string words(const std::string& value, const Vec2& p = Vec2::Zero(),
                  const std::string& layer = "1") {
  return group(0, "TEXT") + group(8, layer) + at(p) + group(1, value);
}
std::string block(const std::string& name, const std::string& inside) {
  return group(0, "BLOCK") + group(8, "1") + group(2, name) + group(70, "0") + at(Vec2::Zero()) +
         inside + group(0, "ENDBLK");
}
std::string section(const char* name, const std::string& inside) {
  return group(0, "SECTION") + group(2, name) + inside + group(0, "ENDSEC");
}
std::string dxf(const std::string& blocks, const std::string& entities = words("Units: METRIC")) {
  return section("BLOCKS", blocks) + section("ENTITIES", entities) + group(0, "EOF");
}

const Points kSquare = {{0, 0}, {400, 0}, {400, 600}, {0, 600}};  // mm

Points scaled(Points points, double by) {
  for (Vec2& p : points) p *= by;
  return points;
}

/// A half circle of points above a side, which goes on without a corner.
Points with_arc(int chords) {
  Points points = {{0, 0}, {400, 0}};
  for (int i = 0; i <= chords; ++i) {
    const double a = std::numbers::pi * i / chords;
    points.emplace_back(200 + 200 * std::cos(a), 300 + 200 * std::sin(a));
  }
  return points;
}

struct FileCase {
  std::string name, text;
  double area = 0.24;  // m², of the first piece
  std::size_t pieces = 1, edges = 4;
  std::string note{};  // that stands among the notes
  std::function<void(const PatternImport&)> check = [](const PatternImport&) {};
};

std::vector<FileCase> good_dxf() {
  std::vector<FileCase> cases;
  const double half_circle = 0.4 * 0.3 + 0.5 * std::numbers::pi * 0.2 * 0.2;
  cases.push_back(
      {"polyline", dxf(block("B1", words("Piece Name: FRONT") + polyline("1", kSquare))), 0.24, 1,
       4, "boundary (layer 1)",
       [](const PatternImport& i) { EXPECT_EQ(i.drawn.panels[0].panel.name, "FRONT"); }});
  cases.push_back(
      {"lwpolyline", dxf(block("BACK", light("1", kSquare))), 0.24, 1, 4, "",
       [](const PatternImport& i) { EXPECT_EQ(i.drawn.panels[0].panel.name, "BACK"); }});
  cases.push_back(
      {"lines in any order and direction",
       dxf(block("B", segment("1", kSquare[0], kSquare[1]) + segment("1", kSquare[3], kSquare[2]) +
                          segment("1", kSquare[1], kSquare[2]) +
                          segment("1", kSquare[0], kSquare[3])))});
  cases.push_back({"inches", dxf(block("B", polyline("1", scaled(kSquare, 1 / 25.4))),
                                 words("Units: ENGLISH"))});
  cases.push_back({"centimetres without units",
                   dxf(block("B", polyline("1", scaled(kSquare, 0.1))), ""), 0.24, 1, 4,
                   "centimetres are taken"});
  cases.push_back({"centimetres that say METRIC",
                   dxf(block("B", polyline("1", scaled(kSquare, 0.1)))), 0.24, 1, 4,
                   "centimetres are taken"});
  cases.push_back(
      {"units of the header", section("HEADER", group(9, "$INSUNITS") + group(70, "6")) +
                                  dxf(block("B", polyline("1", scaled(kSquare, 0.001))), "")});
  cases.push_back({"seam allowance",
                   dxf(block("B", polyline("1", {{-10, -10}, {410, -10}, {410, 610}, {-10, 610}}) +
                                      polyline("14", kSquare))),
                   0.24, 1, 4, "sew line (layer 14)"});
  cases.push_back({"mirror line",
                   dxf(block("B", polyline("1", kSquare) + segment("6", kSquare[3], kSquare[0]))),
                   0.24, 1, 4, "", [](const PatternImport& i) {
                     EXPECT_EQ(i.drawn.panels[0].fold, 3);
                     EXPECT_NEAR(panel_area(as_sewn(i.drawn).panels[0]), 0.48, 1e-9);
                   }});
  cases.push_back({"mirror line inside",
                   dxf(block("B", polyline("1", kSquare) + segment("6", {200, 0}, {200, 600}))),
                   0.24, 1, 4, "mirror line is no edge"});
  cases.push_back(
      {"quantity of two",
       dxf(block("B", words("Piece Name: SLEEVE") + words("Quantity: 2") + polyline("1", kSquare))),
       0.24, 1, 4, "", [](const PatternImport& i) {
         EXPECT_TRUE(i.drawn.panels[0].is_pair);
         EXPECT_EQ(as_sewn(i.drawn).panels.size(), 2u);
       }});
  cases.push_back({"grain along x",
                   dxf(block("B", polyline("1", kSquare) + segment("7", {300, 300}, {100, 300}))),
                   0.24, 1, 4, "", [](const PatternImport& i) {
                     EXPECT_NEAR(i.drawn.panels[0].grain.x(), 1.0, 1e-12);
                     const PatternPanel turned = as_sewn(i.drawn).panels[0];
                     EXPECT_NEAR((turned.vertices[1] - turned.vertices[0]).y(), 0.4, 1e-12);
                   }});
  cases.push_back({"notches",
                   dxf(block("B", polyline("1", kSquare) + mark("4", {100, 0}) +
                                      segment("80", {400, 150}, {390, 150}))),
                   0.24, 1, 4, "", [](const PatternImport& i) {
                     ASSERT_EQ(i.drawn.panels[0].notches.size(), 2u);
                     for (const PatternNotch& notch : i.drawn.panels[0].notches) {
                       EXPECT_NEAR(notch.at, 0.25, 1e-9);
                       EXPECT_TRUE(notch.edge == 0 || notch.edge == 1);
                     }
                   }});
  cases.push_back(
      {"names of layers",
       dxf(block("B", polyline("Boundary", {{-9, -9}, {409, -9}, {409, 609}, {-9, 609}}) +
                          polyline("Sew line", kSquare))),
       0.24, 1, 4, "sew line (layer 14)"});
  cases.push_back(
      {"without blocks",
       dxf("", polyline("1", kSquare) + polyline("1", {{1000, 0}, {1500, 0}, {1500, 500}}) +
                   words("Units: METRIC") + words("front", {200, 300}, "15")),
       0.24, 2, 4, "2 closed lines are taken for pieces", [](const PatternImport& i) {
         EXPECT_EQ(i.drawn.panels[0].panel.name, "front");
         EXPECT_NEAR(panel_area(i.drawn.panels[1].panel), 0.125, 1e-9);
       }});
  cases.push_back(
      {"without blocks and layers", dxf("", polyline("0", kSquare)), 0.24, 1, 4, "no units"});
  cases.push_back(
      {"open by a millimetre",
       dxf(block("B", polyline("1", {{0, 0}, {400, 0}, {400, 600}, {0, 600}, {0, 1}}, false))),
       0.24, 1, 4, "open by up to 1 units, which are closed"});
  cases.push_back(
      {"clockwise", dxf(block("B", polyline("1", {{0, 600}, {400, 600}, {400, 0}, {0, 0}})))});
  cases.push_back(
      {"bulges",
       dxf(block("B", light("1", {{0, 0}, {400, 0}, {400, 300}, {0, 300}}, {0, 0, 1, 0}))),
       half_circle, 1, 2});
  cases.push_back(
      {"curve points", dxf(block("B", polyline("1", with_arc(80)))), half_circle, 1, 2});
  cases.push_back(
      {"turn points decide",
       dxf(block("B", polyline("1", with_arc(80)) + mark("2", {0, 0}) + mark("2", {400, 0}) +
                          mark("2", {400, 300}) + mark("2", {200, 500}) + mark("2", {0, 300}))),
       half_circle, 1, 5});
  cases.push_back(
      {"several sizes",
       dxf(block("S",
                 words("Piece Name: F") + words("Size: 36") + polyline("1", scaled(kSquare, 0.9))) +
               block("M", words("Piece Name: F") + words("Size: 38") + polyline("1", kSquare)),
           words("Units: METRIC") + words("Sample Size: 38")),
       0.24, 1, 4, "several sizes; size \"38\" is taken"});
  cases.push_back({"windows lines and a byte of blanks", [] {
                     std::string text = dxf(block("B", polyline("1", kSquare))), out;
                     for (const char c : text) out += c == '\n' ? "\r\n" : std::string(1, c);
                     return out;
                   }()});
  cases.push_back({"a spline inside",
                   dxf(block("B", polyline("1", kSquare) + group(0, "SPLINE") + group(8, "8")))});
  return cases;
}

std::vector<FileCase> good_svg() {
  std::vector<FileCase> cases;
  const double half_circle = 0.4 * 0.3 + 0.5 * std::numbers::pi * 0.2 * 0.2;
  cases.push_back({"millimetres",
                   "<?xml version=\"1.0\"?><!-- a > b --><svg width=\"500mm\" height=\"700mm\" "
                   "viewBox=\"0 0 500 700\">"
                   "<path d=\"M0 0 H400 V600 H0 Z\"><title>front &amp; more</title></path></svg>",
                   0.24, 1, 4, "", [](const PatternImport& i) {
                     EXPECT_EQ(i.drawn.panels[0].panel.name, "front & more");
                   }});
  cases.push_back(
      {"pixels", "<svg><rect id=\"back\" width=\"1511.811\" height=\"2267.717\"/></svg>", 0.24, 1,
       4, "1/96 inch",
       [](const PatternImport& i) { EXPECT_EQ(i.drawn.panels[0].panel.name, "back"); }});
  cases.push_back({"inches and a scale",
                   "<svg width='10in' viewBox='0 0 254 100'><g transform='translate(5,5) scale(2)'>"
                   "<polygon points='0,0 200,0 200,300 0,300'/></g></svg>"});
  cases.push_back({"turned",
                   "<svg width='50cm' viewBox='0 0 50 70'><path transform='rotate(30 10 10)' d='m1 "
                   "1 l40 0 0 60 -40 0z'/></svg>"});
  cases.push_back({"an arc",
                   "<svg width='500mm' viewBox='0 0 500 700'><path d='M0 0 L400 0 400 300 A200 200 "
                   "0 0 1 0 300 Z'/></svg>",
                   half_circle, 1, 2});
  cases.push_back({"arc flags without blanks",
                   "<svg width='500mm' viewBox='0 0 500 700'><path "
                   "d='M0,0L400,0L400,300a200,200,0,01-400,0z'/></svg>",
                   half_circle, 1, 2});
  cases.push_back({"a cubic and its smooth one",
                   "<svg width='500mm' viewBox='0 0 500 700'><path d='M0 0 H400 V300 C400 410.457 "
                   "310.457 500 200 500 S0 410.457 0 300 Z'/></svg>",
                   half_circle, 1, 2});
  cases.push_back(
      {"a grain and notes",
       "<svg width='500mm' viewBox='0 0 500 700'><g id='Cut'><path id='p' d='M0 0 H400 V600 H0 "
       "Z'/></g>"
       "<g id='grain'><line x1='100' y1='50' x2='300' y2='50'/></g><path d='M1 1 L5 5'/></svg>",
       0.24, 1, 4, "1 open paths are no pieces", [](const PatternImport& i) {
         EXPECT_NEAR(std::abs(i.drawn.panels[0].grain.x()), 1.0, 1e-9);
       }});
  return cases;
}

void expect_good(const FileCase& c, const PatternImport& import) {
  ASSERT_EQ(import.drawn.panels.size(), c.pieces) << c.name;
  const PatternPanel& panel = import.drawn.panels[0].panel;
  EXPECT_NEAR(panel_area(panel), c.area, 1e-3 * c.area) << c.name;
  EXPECT_EQ(panel.edges.size(), c.edges) << c.name;
  const bool noted =
      std::any_of(import.notes.begin(), import.notes.end(),
                  [&](const std::string& note) { return note.find(c.note) != std::string::npos; });
  EXPECT_TRUE(noted || c.note.empty())
      << c.name << ": " << (import.notes.empty() ? "" : import.notes[0]);
  c.check(import);
}

TEST(PatternFiles, PiecesInDxfHaveTheirAreas) {
  for (const FileCase& c : good_dxf()) expect_good(c, parse_dxf_pattern(c.text, c.name));
}

TEST(PatternFiles, PiecesInSvgHaveTheirAreas) {
  for (const FileCase& c : good_svg()) expect_good(c, parse_svg_pattern(c.text, c.name));
}

using Parser = PatternImport (*)(const std::string&, const std::string&);

std::string fault_of(Parser parse, const std::string& text) {
  try {
    parse(text, "file");
  } catch (const std::invalid_argument& fault) {
    return fault.what();
  }
  return "";
}

TEST(PatternFiles, DamagedFilesNameTheirFault) {
  const std::string whole = dxf(block("B", polyline("1", kSquare)));
  const auto swapped = [&](const std::string& from, const std::string& to) {
    std::string text = whole;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::pair<std::string, const char*> dxf_faults[] = {
      {"AutoCAD Binary DXF\r\n", "is binary DXF"},
      {"", "is empty"},
      {whole.substr(0, whole.size() / 2), "cut off"},
      {swapped("  10\n400", "  10\nwide"), "\"wide\" is not a coordinate"},
      {swapped("  10\n400", "ten\n400"), "\"ten\" is not a group code"},
      {swapped("  10\n400", "  10\n1e99"), "is not a coordinate"},
      {swapped(group(0, "SEQEND"), ""), "ends without SEQEND"},
      {dxf(block("B", group(0, "VERTEX") + at(Vec2::Zero()))), "outside a POLYLINE"},
      {dxf(block("B", polyline("1", {{0, 0}, {400, 0}, {400, 600}, {0, 600}, {0, 30}}, false))),
       "outline is open at"},
      {dxf(block("B", group(0, "SPLINE") + group(8, "1") + segment("7", {0, 0}, {0, 9}))),
       "has no pieces"},
      {dxf(block("B", polyline("1", {{0, 0}, {400, 0}, {0, 0}}))), ""},
      {dxf(""), "has no pieces"},
      {"<svg/>", "not a group code"}};
  for (const auto& [text, words] : dxf_faults) {
    const std::string fault = fault_of(parse_dxf_pattern, text);
    if (*words == '\0') continue;  // refused later, by check_sewing_pattern
    EXPECT_NE(fault.find(words), std::string::npos) << words << ": " << fault;
    EXPECT_TRUE(fault.starts_with("file: ")) << fault;
  }
  const std::pair<const char*, const char*> svg_faults[] = {
      {"", "is not SVG"},
      {"<html><body/></html>", "is not SVG"},
      {"<svg><path d='M0 0 L10 0 10 10", "cut off"},
      {"<svg><g><path d='M0 0 L10 0 10 10z'/>", "does not end"},
      {"<svg><path d='M0 0 L10 x 10 10z'/></svg>", "has no number where one belongs"},
      {"<svg><path d='L0 0 10'/></svg>", "no number"},
      {"<svg><path d='M0 0 W10 0z'/></svg>", "which SVG does not know"},
      {"<svg><path d='M0 0 L1000 0 1000 1000'/></svg>", "has no closed path"},
      {"<svg><path d=M0/></svg>", "has no value in quotes"},
      {"<svg><path transform='skewX(3)' d='M0 0 H9 V9z'/></svg>",
       "transform \"skewX\" cannot be read"}};
  for (const auto& [text, words] : svg_faults) {
    const std::string fault = fault_of(parse_svg_pattern, text);
    EXPECT_NE(fault.find(words), std::string::npos) << text << ": " << fault;
  }
}

/// Cut or changed anywhere, a file is read or refused with a sentence; nothing else happens.
TEST(PatternFiles, AnyDamageIsReadOrRefused) {
  std::vector<std::pair<Parser, std::string>> files;
  for (const FileCase& c : good_dxf()) files.emplace_back(parse_dxf_pattern, c.text);
  for (const FileCase& c : good_svg()) files.emplace_back(parse_svg_pattern, c.text);
  std::uint32_t seed = 1;
  const auto draw = [&](std::size_t below) {
    seed = seed * 1664525u + 1013904223u;
    return static_cast<std::size_t>(seed >> 8) % below;
  };
  int refused = 0;
  for (const auto& [parse, text] : files)
    for (int k = 0; k < 40; ++k) {
      std::string damaged = text;
      if (k % 2 == 0)
        damaged.resize(draw(text.size()));
      else
        for (int c = 0; c < 3; ++c) damaged[draw(text.size())] = static_cast<char>(32 + draw(95));
      try {
        const PatternImport import = parse(damaged, "file");
        for (const DrawnPanel& panel : import.drawn.panels)
          EXPECT_TRUE(std::isfinite(panel_area(panel.panel)));
      } catch (const std::invalid_argument& fault) {
        ++refused;
        EXPECT_TRUE(std::string(fault.what()).starts_with("file: ")) << fault.what();
      }
    }
  EXPECT_GT(refused, 400);
}

TEST(PatternFiles, OurPatternsComeBackFromDxf) {
  const std::filesystem::path folder = std::filesystem::path(SELVEDGE_SOURCE_DIR) / "data/patterns";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const SewingPattern pattern = read_sewing_pattern(entry.path());
    const PatternImport import = parse_dxf_pattern(dxf_pattern_text(pattern), "again");
    ASSERT_EQ(import.drawn.panels.size(), pattern.panels.size()) << entry.path();
    for (std::size_t p = 0; p < pattern.panels.size(); ++p) {
      const PatternPanel &is = import.drawn.panels[p].panel, &was = pattern.panels[p];
      EXPECT_EQ(is.name, was.name);
      EXPECT_NEAR(panel_area(is), std::abs(panel_area(was)), 1e-3 * std::abs(panel_area(was)))
          << was.name;
      ASSERT_EQ(is.edges.size(), was.edges.size()) << was.name;
      std::vector<double> lengths, wanted;
      for (std::int32_t e = 0; e < static_cast<std::int32_t>(is.edges.size()); ++e) {
        lengths.push_back(edge_length(is, e));
        wanted.push_back(edge_length(was, e));
      }
      std::sort(lengths.begin(), lengths.end());
      std::sort(wanted.begin(), wanted.end());
      for (std::size_t e = 0; e < lengths.size(); ++e)
        EXPECT_NEAR(lengths[e], wanted[e], 1e-3 * wanted[e]) << was.name;
    }
    ASSERT_EQ(import.drawn.stitches.size(), pattern.stitches.size()) << entry.path();
    const SewingPattern sewn = as_sewn(import.drawn);
    for (const PatternStitch& s : sewn.stitches) {
      const double a = edge_length(sewn.panels[s.a.panel], s.a.edge),
                   b = edge_length(sewn.panels[s.b.panel], s.b.edge);
      EXPECT_LT(std::max(a, b), 3.0 * std::min(a, b));
    }
  }
}

}  // namespace
}  // namespace selvedge::pattern_files_test
