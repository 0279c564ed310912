// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/garment/detail/pattern_names.h>
#include <selvedge/garment/detail/piece_outline.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace selvedge {
namespace {

using detail::PieceDrawing;
using detail::PieceLayer;

/// A group of a DXF file: a code and its value, on two lines.
struct DxfGroup {
  int code = 0;
  std::string value;
  std::size_t line = 0;  // of the code
};

std::string without_blanks(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") - first + 1));
}

std::optional<double> dxf_number(const std::string& text) {
  double value = 0.0;
  const char* first = text.data() + (text.starts_with("+") ? 1 : 0);
  const auto [end, fault] = std::from_chars(first, text.data() + text.size(), value);
  if (fault != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// An entity: its kind and its groups.
struct DxfEntity {
  std::string kind;
  std::size_t line = 0;
  std::vector<DxfGroup> groups;

  const DxfGroup* group(int code) const {
    for (const DxfGroup& g : groups)
      if (g.code == code) return &g;
    return nullptr;
  }
  std::string text(int code) const {
    const DxfGroup* g = group(code);
    return g ? g->value : "";
  }
};

class DxfReader {
 public:
  DxfReader(const std::string& text, const std::string& name) : text_(text) {
    import_.drawn.name = name;
  }

  PatternImport read() {
    read_groups();
    read_sections();
    choose_pieces();
    const double unit = find_unit();
    std::vector<detail::SeamMark> marks;
    for (const PieceDrawing& piece : pieces_) detail::add_piece(piece, unit, import_, marks);
    detail::join_marks(marks, import_);
    return std::move(import_);
  }

 private:
  [[noreturn]] void refuse(const std::string& fault) const {
    throw std::invalid_argument(import_.drawn.name + ": " + fault);
  }
  void note(const std::string& sentence) { import_.notes.push_back(sentence); }

  // Groups and entities.

  void read_groups() {
    if (text_.starts_with("AutoCAD Binary DXF"))
      refuse("is binary DXF; export it as text (ASCII), release 12 or 13");
    std::size_t at = 0, line = 0;
    const auto next = [&](std::string& out) {
      if (at >= text_.size()) return false;
      const std::size_t end = std::min(text_.find('\n', at), text_.size());
      out = without_blanks(std::string_view(text_).substr(at, end - at));
      at = end + 1;
      ++line;
      return true;
    };
    std::string code, value;
    while (next(code)) {
      if (code.empty() && at >= text_.size()) break;
      DxfGroup group;
      group.line = line;
      const auto [end, fault] = std::from_chars(code.data(), code.data() + code.size(), group.code);
      if (fault != std::errc() || end != code.data() + code.size())
        refuse(fmt::format("line {}: {} is not a group code; the file is damaged or not DXF", line,
                           detail::quoted(code)));
      if (!next(value))
        refuse(fmt::format("line {}: the file ends after a group code; it is cut off", line));
      group.value = value;
      groups_.push_back(std::move(group));
    }
    if (groups_.empty()) refuse("is empty; export the pattern again");
    if (groups_.back().code != 0 || groups_.back().value != "EOF")
      refuse("has no EOF at its end, so it is cut off; export the pattern again");
  }

  void read_sections() {
    std::string section;
    std::string header;
    PieceDrawing* block = nullptr;
    DxfEntity entity;
    const auto finish = [&] {
      if (!entity.kind.empty()) take(entity, block);
      entity = {};
    };
    for (const DxfGroup& g : groups_) {
      if (section == "HEADER") {
        if (g.code == 9) header = g.value;
        if (header == "$INSUNITS" && g.code == 70)
          if (const auto value = dxf_number(g.value)) header_unit_ = static_cast<int>(*value);
      }
      if (g.code != 0) {
        if (!entity.kind.empty()) entity.groups.push_back(g);
        if (section.empty() && g.code == 2) section = g.value;
        if (in_block_head_ && g.code == 2) block->name = g.value;
        continue;
      }
      finish();
      in_block_head_ = false;
      if (g.value == "SECTION") {
        section.clear();
      } else if (g.value == "ENDSEC") {
        end_polyline(g.line);
        section = "none";
      } else if (g.value == "BLOCK" && section == "BLOCKS") {
        block = &blocks_.emplace_back();
        in_block_head_ = true;
      } else if (g.value == "ENDBLK") {
        end_polyline(g.line);
        block = nullptr;
      } else if (g.value != "EOF" && (section == "BLOCKS" || section == "ENTITIES")) {
        entity.kind = g.value;
        entity.line = g.line;
      }
    }
    end_polyline(groups_.back().line);
  }

  double coordinate(const DxfEntity& entity, int code) const {
    const DxfGroup* g = entity.group(code);
    if (!g)
      refuse(fmt::format("line {}: {} has no coordinate {}; the file is damaged", entity.line,
                         entity.kind, code));
    const auto value = dxf_number(g->value);
    if (!value || std::abs(*value) > 1e7)
      refuse(fmt::format("line {}: {} is not a coordinate; the file is damaged", g->line,
                         detail::quoted(g->value)));
    return *value;
  }
  Vec2 point(const DxfEntity& entity, int x = 10) const {
    return {coordinate(entity, x), coordinate(entity, x + 10)};
  }

  void end_polyline(std::size_t line) const {
    if (in_polyline_)
      refuse(fmt::format("line {}: a POLYLINE ends without SEQEND; the file is damaged", line));
  }

  /// `block`: none in ENTITIES.
  void take(const DxfEntity& entity, PieceDrawing* block) {
    PieceDrawing& to = block ? *block : loose_;
    const PieceLayer layer = detail::piece_layer(entity.text(8));
    if (entity.kind == "VERTEX") {
      if (!in_polyline_)
        refuse(fmt::format("line {}: a VERTEX stands outside a POLYLINE; the file is damaged",
                           entity.line));
      add_vertex(point(entity), entity);
      return;
    }
    if (entity.kind == "SEQEND") {
      if (in_polyline_) close_polyline(to);
      return;
    }
    end_polyline(entity.line);
    if (entity.kind == "POLYLINE") {
      in_polyline_ = true;
      line_ = {layer, {}, (static_cast<int>(dxf_number(entity.text(70)).value_or(0.0)) & 1) != 0};
      bulge_.clear();
    } else if (entity.kind == "LWPOLYLINE") {
      read_light_polyline(entity, layer, to);
    } else if (entity.kind == "LINE") {
      to.lines.push_back({layer, {point(entity, 10), point(entity, 11)}, false});
    } else if (entity.kind == "POINT") {
      if (layer == PieceLayer::turn) to.turns.push_back(point(entity));
      if (layer == PieceLayer::notch) to.notches.push_back(point(entity));
    } else if (entity.kind == "TEXT" || entity.kind == "MTEXT") {
      read_text(entity, block, to);
    } else if (entity.kind == "INSERT") {
      ++inserts_[entity.text(2)];
    } else if (entity.kind != "ATTDEF" && entity.kind != "VIEWPORT") {
      to.left_out.push_back(entity.kind);
    }
  }

  void add_vertex(const Vec2& p, const DxfEntity& entity) {
    line_.points.push_back(p);
    bulge_.push_back(dxf_number(entity.text(42)).value_or(0.0));
  }

  /// Sides with a bulge, the tangent of a quarter of their angle, are arcs.
  void close_polyline(PieceDrawing& to) {
    in_polyline_ = false;
    detail::PieceLine line{line_.layer, {}, line_.is_closed};
    const std::size_t n = line_.points.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 &a = line_.points[i], &b = line_.points[(i + 1) % n];
      line.points.push_back(a);
      if (bulge_[i] == 0.0 || (i + 1 == n && !line_.is_closed)) continue;
      const double angle = 4.0 * elementary::atan2(bulge_[i], 1.0);
      const int pieces = 1 + static_cast<int>(std::abs(angle) / 0.05);
      const Vec2 half = 0.5 * (b - a), across(-half.y(), half.x());
      const Vec2 centre =
          0.5 * (a + b) + across * (1.0 - bulge_[i] * bulge_[i]) / (2.0 * bulge_[i]);
      for (int k = 1; k < pieces; ++k) {
        const auto [sine, cosine] = elementary::sin_cos(angle * k / pieces);
        const Vec2 r = a - centre;
        line.points.push_back(centre +
                              Vec2(cosine * r.x() - sine * r.y(), sine * r.x() + cosine * r.y()));
      }
    }
    if (n > 0) to.lines.push_back(std::move(line));
  }

  void read_light_polyline(const DxfEntity& entity, PieceLayer layer, PieceDrawing& to) {
    line_ = {layer, {}, (static_cast<int>(dxf_number(entity.text(70)).value_or(0.0)) & 1) != 0};
    bulge_.clear();
    for (std::size_t i = 0; i < entity.groups.size(); ++i) {
      const DxfGroup& g = entity.groups[i];
      if (g.code == 42 && !bulge_.empty()) bulge_.back() = dxf_number(g.value).value_or(0.0);
      if (g.code != 10) continue;
      DxfEntity vertex{entity.kind, g.line, {g}};
      if (i + 1 < entity.groups.size()) vertex.groups.push_back(entity.groups[i + 1]);
      add_vertex(point(vertex), vertex);
    }
    close_polyline(to);
  }

  void read_text(const DxfEntity& entity, const PieceDrawing* block, PieceDrawing& to) {
    const std::string words = entity.text(1);
    const auto colon = words.find(':');
    const auto key = [&] {
      std::string k = without_blanks(std::string_view(words).substr(0, colon));
      std::transform(k.begin(), k.end(), k.begin(),
                     [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
      return k;
    };
    const std::string value =
        colon == std::string::npos ? "" : without_blanks(std::string_view(words).substr(colon + 1));
    const std::string name = colon == std::string::npos ? "" : key();
    if (name == "units") stated_unit_ = value;
    if (name == "sample size") sample_size_ = value;
    if (block && name == "piece name" && !value.empty()) to.name = value;
    if (block && name == "size") sizes_[block - blocks_.data()] = value;
    if (block && name == "quantity")
      to.quantity =
          static_cast<int>(dxf_number(value.substr(0, value.find_first_of(" ,/"))).value_or(1.0));
    if (colon == std::string::npos || name == "annotation") {
      std::string note = colon == std::string::npos ? words : value;
      if (entity.group(10)) to.texts.push_back({point(entity), note});
    }
  }

  // Pieces.

  static bool has_outline(const PieceDrawing& piece) {
    return std::any_of(piece.lines.begin(), piece.lines.end(), [](const detail::PieceLine& line) {
      return line.layer == PieceLayer::boundary || line.layer == PieceLayer::sew;
    });
  }

  void choose_pieces() {
    std::map<std::string, std::size_t> by_name;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      PieceDrawing& block = blocks_[b];
      if (block.lines.empty() || block.name.starts_with("*")) continue;
      if (!has_outline(block)) {
        note(fmt::format("block {} has no outline on layer 1 or 14, so it is left out",
                         detail::quoted(block.name)));
        continue;
      }
      const auto [found, is_new] = by_name.insert({block.name, pieces_.size()});
      if (is_new) {
        pieces_.push_back(block);
        kept_size_.push_back(sizes_.contains(static_cast<std::ptrdiff_t>(b))
                                 ? sizes_[static_cast<std::ptrdiff_t>(b)]
                                 : "");
        continue;
      }
      const std::string size = sizes_[static_cast<std::ptrdiff_t>(b)];
      if (!sample_size_.empty() && size == sample_size_ && kept_size_[found->second] != size) {
        pieces_[found->second] = block;
        kept_size_[found->second] = size;
      }
      note(fmt::format("piece {} is there in several sizes; size {} is taken",
                       detail::quoted(block.name), detail::quoted(kept_size_[found->second])));
    }
    if (pieces_.empty()) take_loose_lines();
    if (pieces_.empty())
      refuse(
          "has no pieces: no block and no closed line; export the pieces as blocks by AAMA or "
          "ASTM, or as closed lines");
  }

  /// Without blocks, each closed line is a piece. Lines of layers without meaning count, too.
  void take_loose_lines() {
    if (!has_outline(loose_))
      for (detail::PieceLine& line : loose_.lines)
        if (line.layer == PieceLayer::other) line.layer = PieceLayer::boundary;
    loose_.name = "without blocks";
    const double gap = std::max(1e-9, 0.005 * 0.2 * detail::piece_extent(loose_));
    PieceLayer layer = PieceLayer::sew;
    auto loops = detail::closed_loops(loose_, layer, gap, import_.drawn.name, import_.notes);
    if (loops.empty())
      loops = detail::closed_loops(loose_, layer = PieceLayer::boundary, gap, import_.drawn.name,
                                   import_.notes);
    for (std::size_t i = 0; i < loops.size(); ++i) {
      PieceDrawing& piece = pieces_.emplace_back();
      piece.name = fmt::format("piece {}", i);
      piece.turns = loose_.turns;
      piece.notches = loose_.notches;
      piece.lines = {{layer, loops[i], true}};
      Vec2 low = loops[i][0], high = low;
      for (const Vec2& p : loops[i]) low = low.cwiseMin(p), high = high.cwiseMax(p);
      for (const detail::PieceText& text : loose_.texts)
        if ((text.at - low).minCoeff() >= 0.0 && (high - text.at).minCoeff() >= 0.0) {
          if (piece.texts.empty() && !text.words.starts_with("Seam ")) piece.name = text.words;
          piece.texts.push_back(text);
        }
      for (const detail::PieceLine& line : loose_.lines)
        if (line.layer == PieceLayer::grain && (line.points[0] - low).minCoeff() >= 0.0 &&
            (high - line.points[0]).minCoeff() >= 0.0)
          piece.lines.push_back(line);
    }
    if (!pieces_.empty())
      note(fmt::format("no blocks: {} closed lines are taken for pieces", pieces_.size()));
  }

  /// Metres per unit.
  double find_unit() {
    double largest = 0.0;
    for (const PieceDrawing& piece : pieces_)
      largest = std::max(largest, detail::piece_extent(piece));
    std::string unit = stated_unit_;
    std::transform(unit.begin(), unit.end(), unit.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    constexpr double tiny = 150.0;  // mm, of the largest piece: no garment
    if (unit == "METRIC") {
      if (largest >= tiny) return 0.001;
      note(
          fmt::format("Units: METRIC means millimetres, but the largest piece would be {:.0f} mm; "
                      "centimetres are taken",
                      largest));
      return 0.01;
    }
    if (unit == "ENGLISH") return 0.0254;
    const std::map<int, double> units = {{1, 0.0254}, {2, 0.3048}, {4, 0.001}, {5, 0.01}, {6, 1.0}};
    if (const auto found = units.find(header_unit_); found != units.end()) return found->second;
    const double guess = largest >= 300.0  ? 0.001
                         : largest >= 45.0 ? 0.01
                         : largest >= 4.0  ? 0.0254
                                           : 1.0;
    note(
        fmt::format("no units: {} are taken, because the largest piece measures {:.4g}; state "
                    "Units: METRIC for millimetres",
                    guess == 0.001    ? "millimetres"
                    : guess == 0.01   ? "centimetres"
                    : guess == 0.0254 ? "inches"
                                      : "metres",
                    largest));
    return guess;
  }

  const std::string& text_;
  PatternImport import_;
  std::vector<DxfGroup> groups_;
  std::vector<PieceDrawing> blocks_, pieces_;
  PieceDrawing loose_;
  std::map<std::ptrdiff_t, std::string> sizes_;  // of blocks
  std::vector<std::string> kept_size_;           // of pieces
  std::map<std::string, int> inserts_;
  std::string stated_unit_, sample_size_;
  int header_unit_ = 0;
  bool in_block_head_ = false, in_polyline_ = false;
  detail::PieceLine line_;
  std::vector<double> bulge_;
};

/// Groups of a DXF file.
class DxfWriter {
 public:
  void put(int code, const std::string& value) { text_ += fmt::format("{}\n{}\n", code, value); }
  void put(int code, double value) { put(code, fmt::format("{:.4f}", value)); }
  void entity(const char* kind, int layer) {
    put(0, kind);
    put(8, std::to_string(layer));
  }
  void place(const Vec2& p, int x = 10) {
    put(x, 1000.0 * p.x());
    put(x + 10, 1000.0 * p.y());
  }
  void words(int layer, const Vec2& at, const std::string& value) {
    entity("TEXT", layer);
    place(at);
    put(40, 5.0);
    put(1, value);
  }
  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

void write_piece(DxfWriter& out, const SewingPattern& pattern, std::size_t p,
                 const std::map<std::pair<std::size_t, std::int32_t>, std::size_t>& seams) {
  const PatternPanel& panel = pattern.panels[p];
  const auto n = static_cast<std::int32_t>(panel.edges.size());
  out.put(0, "BLOCK");
  out.put(8, "1");
  out.put(2, fmt::format("PIECE{}", p));
  out.put(70, "0");
  out.place(Vec2::Zero());
  Vec2 low = panel.vertices[0], high = low;
  std::vector<Vec2> points, curve;
  for (std::int32_t e = 0; e < n; ++e) {
    constexpr double chord_turn = 0.015;  // rad: a chord is shorter than its arc by 1e-5
    const double turning = edge_turning(panel, e);
    std::vector<Vec2> line =
        divide_edge(panel, e, 1 + static_cast<std::int32_t>(std::ceil(turning / chord_turn)));
    if (panel.edges[e].curve.kind == PatternCurve::Kind::polyline) {
      line = {line.front(), line.back()};
      line.insert(line.begin() + 1, panel.edges[e].curve.through.begin(),
                  panel.edges[e].curve.through.end());
    }
    points.insert(points.end(), line.begin(), line.end() - 1);
    curve.insert(curve.end(), line.begin() + 1, line.end() - 1);
  }
  for (const Vec2& q : points) low = low.cwiseMin(q), high = high.cwiseMax(q);
  const Vec2 middle = 0.5 * (low + high);
  out.words(1, middle, "Piece Name: " + panel.name);
  out.words(1, middle, "Quantity: 1");
  out.entity("POLYLINE", 1);
  out.put(66, "1");
  out.put(70, "1");
  out.place(Vec2::Zero());
  for (const Vec2& q : points) {
    out.entity("VERTEX", 1);
    out.place(q);
  }
  out.put(0, "SEQEND");
  for (std::int32_t e = 0; e < n; ++e) {
    out.entity("POINT", 2);
    out.place(panel.vertices[panel.edges[e].endpoints[0]]);
  }
  for (const Vec2& q : curve) {
    out.entity("POINT", 3);
    out.place(q);
  }
  out.entity("LINE", 7);
  out.place({middle.x(), low.y() + 0.25 * (high.y() - low.y())}, 10);
  out.place({middle.x(), low.y() + 0.75 * (high.y() - low.y())}, 11);
  for (std::int32_t e = 0; e < n; ++e)
    if (const auto seam = seams.find({p, e}); seam != seams.end())
      out.words(15, divide_edge(panel, e, 2)[1], fmt::format("Seam {}", seam->second));
  out.put(0, "ENDBLK");
}

}  // namespace

PatternImport parse_dxf_pattern(const std::string& text, const std::string& name) {
  return DxfReader(text, name).read();
}

std::string dxf_pattern_text(const SewingPattern& pattern) {
  std::map<std::pair<std::size_t, std::int32_t>, std::size_t> seams;
  for (std::size_t s = 0; s < pattern.stitches.size(); ++s)
    for (const PatternStitch::Side& side : {pattern.stitches[s].a, pattern.stitches[s].b})
      seams[{static_cast<std::size_t>(side.panel), side.edge}] = s + 1;
  DxfWriter out;
  out.put(0, "SECTION");
  out.put(2, "HEADER");
  out.put(9, "$ACADVER");
  out.put(1, "AC1009");
  out.put(0, "ENDSEC");
  out.put(0, "SECTION");
  out.put(2, "BLOCKS");
  for (std::size_t p = 0; p < pattern.panels.size(); ++p) write_piece(out, pattern, p, seams);
  out.put(0, "ENDSEC");
  out.put(0, "SECTION");
  out.put(2, "ENTITIES");
  const std::string style = std::filesystem::path(pattern.name).stem().string();
  out.words(1, Vec2::Zero(), "Style Name: " + style);
  out.words(1, Vec2::Zero(), "Units: METRIC");
  for (std::size_t p = 0; p < pattern.panels.size(); ++p) {
    out.entity("INSERT", 1);
    out.put(2, fmt::format("PIECE{}", p));
    out.place(Vec2::Zero());
  }
  out.put(0, "ENDSEC");
  out.put(0, "EOF");
  return std::move(out).text();
}

}  // namespace selvedge
