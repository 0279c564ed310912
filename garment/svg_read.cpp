// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/garment/detail/pattern_names.h>
#include <selvedge/garment/detail/piece_outline.h>

#include <Eigen/LU>
#include <algorithm>
#include <cctype>
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

/// A tag of an SVG file with its attributes.
struct SvgTag {
  std::string name;
  std::map<std::string, std::string> attributes;
  bool is_end = false, is_empty = false;
  std::size_t line = 1;
  std::string text_after;

  std::string get(const char* key) const {
    const auto found = attributes.find(key);
    return found == attributes.end() ? "" : found->second;
  }
};

std::string svg_words(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::pair<const char*, char> entities[] = {
        {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
    bool is_entity = false;
    for (const auto& [name, letter] : entities)
      if (text.substr(i).starts_with(name)) {
        out += letter;
        i += std::string_view(name).size() - 1;
        is_entity = true;
        break;
      }
    if (!is_entity) out += text[i];
  }
  const auto first = out.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return "";
  return out.substr(first, out.find_last_not_of(" \t\r\n") - first + 1);
}

/// Numbers of a text, between blanks and commas.
class SvgNumbers {
 public:
  explicit SvgNumbers(std::string_view text) : text_(text) {}
  void skip() {
    while (at_ < text_.size() &&
           (std::isspace(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == ','))
      ++at_;
  }
  bool is_done() {
    skip();
    return at_ >= text_.size();
  }
  /// A letter, if one is next.
  std::optional<char> letter() {
    skip();
    if (at_ < text_.size() && std::isalpha(static_cast<unsigned char>(text_[at_])) != 0)
      return text_[at_++];
    return std::nullopt;
  }
  std::optional<double> number() {
    skip();
    double value = 0.0;
    const std::size_t from = at_ < text_.size() && text_[at_] == '+' ? at_ + 1 : at_;
    const auto [end, fault] =
        std::from_chars(text_.data() + from, text_.data() + text_.size(), value);
    if (fault != std::errc() || !std::isfinite(value) || std::abs(value) > 1e7) return std::nullopt;
    at_ = static_cast<std::size_t>(end - text_.data());
    return value;
  }
  /// A flag of an arc: one digit, perhaps without a blank behind it.
  std::optional<bool> flag() {
    skip();
    if (at_ < text_.size() && (text_[at_] == '0' || text_[at_] == '1')) return text_[at_++] == '1';
    return std::nullopt;
  }
  std::size_t place() const { return at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

struct SvgFrame {
  Eigen::Matrix2d m = Eigen::Matrix2d::Identity();
  Vec2 t = Vec2::Zero();
  Vec2 of(const Vec2& p) const { return m * p + t; }
  SvgFrame then(const SvgFrame& inner) const { return {m * inner.m, m * inner.t + t}; }
};

/// The points of path data, curves as chords.
class SvgPath {
 public:
  SvgPath(const std::string& data, const std::string& place) : in_(data), place_(place) {}

  std::vector<detail::PieceLine> read() {
    char command = 0;
    while (!in_.is_done()) {
      if (const auto letter = in_.letter())
        command = *letter;
      else if (command == 0)
        refuse("does not begin with M");
      else if (command == 'M' || command == 'm')
        command = command == 'M' ? 'L' : 'l';
      run(command);
      last_ = static_cast<char>(std::toupper(static_cast<unsigned char>(command)));
    }
    finish(false);
    return std::move(lines_);
  }

 private:
  [[noreturn]] void refuse(const std::string& fault) const {
    throw std::invalid_argument(fmt::format("{}: its path {} (at character {}); export it again",
                                            place_, fault, in_.place()));
  }
  double number() {
    const auto value = in_.number();
    if (!value) refuse("has no number where one belongs");
    return *value;
  }
  Vec2 point(bool is_relative) {
    const double x = number(), y = number();
    return is_relative ? Vec2(at_ + Vec2(x, y)) : Vec2(x, y);
  }
  void to(const Vec2& p) {
    line_.push_back(p);
    at_ = p;
  }
  void finish(bool is_closed) {
    if (line_.size() > 1) lines_.push_back({PieceLayer::boundary, line_, is_closed});
    line_.clear();
  }

  void run(char command) {
    const bool relative = std::islower(static_cast<unsigned char>(command)) != 0;
    const char kind = static_cast<char>(std::toupper(static_cast<unsigned char>(command)));
    if (kind != 'M' && kind != 'Z' && line_.empty()) line_.push_back(at_ = start_);
    if (kind == 'M') {
      finish(false);
      start_ = point(relative);
      to(start_);
    } else if (kind == 'Z') {
      finish(true);
      at_ = start_;
    } else if (kind == 'L') {
      to(point(relative));
    } else if (kind == 'H') {
      to({number() + (relative ? at_.x() : 0.0), at_.y()});
    } else if (kind == 'V') {
      to({at_.x(), number() + (relative ? at_.y() : 0.0)});
    } else if (kind == 'C' || kind == 'S') {
      const Vec2 c = kind == 'C'                    ? point(relative)
                     : last_ == 'C' || last_ == 'S' ? Vec2(2.0 * at_ - control_)
                                                    : at_;
      const Vec2 d = point(relative), end = point(relative);
      control_ = d;
      curve(c, d, end);
    } else if (kind == 'Q' || kind == 'T') {
      const Vec2 c = kind == 'Q'                    ? point(relative)
                     : last_ == 'Q' || last_ == 'T' ? Vec2(2.0 * at_ - control_)
                                                    : at_;
      const Vec2 end = point(relative), from = at_;
      control_ = c;
      curve(from + 2.0 / 3.0 * (c - from), end + 2.0 / 3.0 * (c - end), end);
    } else if (kind == 'A') {
      arc(relative);
    } else {
      refuse(fmt::format("has the command {}, which SVG does not know", command));
    }
  }

  void curve(const Vec2& c, const Vec2& d, const Vec2& end) {
    constexpr int chords = 64;
    const Vec2 from = at_;
    for (int k = 1; k <= chords; ++k) {
      const double t = static_cast<double>(k) / chords, s = 1.0 - t;
      to(s * s * s * from + 3.0 * s * s * t * c + 3.0 * s * t * t * d + t * t * t * end);
    }
  }

  /// SVG 1.1, appendix F.6.5.
  void arc(bool is_relative) {
    double rx = std::abs(number()), ry = std::abs(number());
    const double turn = number() * std::numbers::pi / 180.0;
    const auto large = in_.flag(), sweep = in_.flag();
    if (!large || !sweep) refuse("has an arc without its flags");
    const Vec2 end = point(is_relative), from = at_;
    if (rx == 0.0 || ry == 0.0 || (end - from).norm() == 0.0) {
      to(end);
      return;
    }
    const auto [sine, cosine] = elementary::sin_cos(turn);
    Eigen::Matrix2d axes;
    axes << cosine, sine, -sine, cosine;
    const Vec2 half = axes * (0.5 * (from - end));
    const double need = half.x() * half.x() / (rx * rx) + half.y() * half.y() / (ry * ry);
    if (need > 1.0) rx *= std::sqrt(need), ry *= std::sqrt(need);
    const double a = rx * rx * half.y() * half.y() + ry * ry * half.x() * half.x();
    const double root =
        std::sqrt(std::max(0.0, rx * rx * ry * ry / a - 1.0)) * (*large == *sweep ? -1.0 : 1.0);
    const Vec2 c(root * rx * half.y() / ry, -root * ry * half.x() / rx);
    const Vec2 centre = axes.transpose() * c + 0.5 * (from + end);
    const auto angle = [&](const Vec2& p) {
      return elementary::atan2((p.y() - c.y()) / ry, (p.x() - c.x()) / rx);
    };
    const double first = angle(half);
    double through = angle(-half) - first;
    if (*sweep && through < 0.0) through += 2.0 * std::numbers::pi;
    if (!*sweep && through > 0.0) through -= 2.0 * std::numbers::pi;
    const int pieces = 1 + static_cast<int>(std::abs(through) / 0.05);
    for (int k = 1; k < pieces; ++k) {
      const auto [s, co] = elementary::sin_cos(first + through * k / pieces);
      to(centre + axes.transpose() * Vec2(rx * co, ry * s));
    }
    to(end);
  }

  SvgNumbers in_;
  const std::string& place_;
  std::vector<detail::PieceLine> lines_;
  std::vector<Vec2> line_;
  Vec2 at_ = Vec2::Zero(), start_ = Vec2::Zero(), control_ = Vec2::Zero();
  char last_ = 0;
};

class SvgReader {
 public:
  SvgReader(const std::string& text, const std::string& name) : text_(text) {
    import_.drawn.name = name;
  }

  PatternImport read() {
    read_tags();
    walk();
    std::vector<detail::SeamMark> marks;
    gather();
    if (pieces_.empty()) refuse("has no closed path; draw one closed path for each piece");
    for (const PieceDrawing& piece : pieces_) detail::add_piece(piece, 1.0, import_, marks);
    detail::join_marks(marks, import_);
    return std::move(import_);
  }

 private:
  [[noreturn]] void refuse(const std::string& fault) const {
    throw std::invalid_argument(import_.drawn.name + ": " + fault);
  }

  void read_tags() {
    std::size_t at = 0, line = 1, counted = 0;
    while ((at = text_.find('<', at)) != std::string::npos) {
      for (; counted < at; ++counted) line += text_[counted] == '\n' ? 1 : 0;
      const auto skip_to = [&](const char* mark) {
        const std::size_t end = text_.find(mark, at);
        if (end == std::string::npos)
          refuse(fmt::format("line {}: a tag does not end; the file is cut off", line));
        at = end + std::string_view(mark).size();
      };
      if (text_.compare(at, 4, "<!--") == 0) {
        skip_to("-->");
      } else if (text_.compare(at, 2, "<?") == 0) {
        skip_to("?>");
      } else if (text_.compare(at, 2, "<!") == 0) {
        skip_to(">");
      } else {
        read_tag(at, line);
      }
    }
    if (tags_.empty() || tags_.front().name != "svg")
      refuse("is not SVG: its first tag is not svg");
  }

  void read_tag(std::size_t& at, std::size_t line) {
    SvgTag tag;
    tag.line = line;
    ++at;
    if (at < text_.size() && text_[at] == '/') tag.is_end = true, ++at;
    const auto is_blank = [&](std::size_t i) {
      return std::isspace(static_cast<unsigned char>(text_[i])) != 0;
    };
    const auto cut_off = [&]() {
      if (at >= text_.size())
        refuse(fmt::format("line {}: a tag does not end; the file is cut off", line));
    };
    while (at < text_.size() && !is_blank(at) && text_[at] != '>' && text_[at] != '/')
      tag.name += text_[at++];
    while (true) {
      while (at < text_.size() && is_blank(at)) ++at;
      cut_off();
      if (text_[at] == '>') break;
      if (text_[at] == '/') {
        tag.is_empty = true;
        ++at;
        continue;
      }
      std::string key;
      while (at < text_.size() && !is_blank(at) && text_[at] != '=' && text_[at] != '>' &&
             text_[at] != '/')
        key += text_[at++];
      while (at < text_.size() && (is_blank(at) || text_[at] == '=')) ++at;
      cut_off();
      const char quote = text_[at];
      if (quote != '"' && quote != '\'')
        refuse(fmt::format(
            "line {}: the attribute {} of {} has no value in quotes; the file is damaged", line,
            detail::quoted(key), detail::quoted(tag.name)));
      const std::size_t end = text_.find(quote, at + 1);
      if (end == std::string::npos)
        refuse(fmt::format("line {}: the attribute {} does not end; the file is cut off", line,
                           detail::quoted(key)));
      tag.attributes[key] = svg_words(std::string_view(text_).substr(at + 1, end - at - 1));
      at = end + 1;
    }
    ++at;
    const std::size_t next = std::min(text_.find('<', at), text_.size());
    tag.text_after = svg_words(std::string_view(text_).substr(at, next - at));
    const auto colon = tag.name.find(':');
    if (colon != std::string::npos) tag.name = tag.name.substr(colon + 1);
    tags_.push_back(std::move(tag));
  }

  /// Metres of a length such as 21cm; pixels without a unit.
  std::optional<double> metres(const std::string& text) const {
    SvgNumbers in(text);
    const auto value = in.number();
    if (!value) return std::nullopt;
    const std::string unit = svg_words(std::string_view(text).substr(in.place()));
    const std::map<std::string, double> units = {
        {"mm", 0.001},        {"cm", 0.01},          {"in", 0.0254},     {"pt", 0.0254 / 72.0},
        {"pc", 0.0254 / 6.0}, {"px", 0.0254 / 96.0}, {"", 0.0254 / 96.0}};
    const auto found = units.find(unit);
    if (found == units.end()) return std::nullopt;
    return *value * found->second;
  }

  /// The frame of the drawing: metres, y upwards.
  SvgFrame root(const SvgTag& svg) {
    double scale = 0.0254 / 96.0;
    SvgNumbers box(svg.get("viewBox"));
    const auto x = box.number(), y = box.number(), w = box.number(), h = box.number();
    const auto width = metres(svg.get("width")), height = metres(svg.get("height"));
    if (x && y && w && h && *w > 0.0 && *h > 0.0 && width && *width > 0.0)
      scale = *width / *w;
    else if (x && y && w && h && *h > 0.0 && height && *height > 0.0)
      scale = *height / *h;
    else
      import_.notes.push_back(
          "no width with a unit and viewBox: lengths are taken for pixels of 1/96 inch");
    if (!(scale > 0.0) || !std::isfinite(scale)) refuse("has a width or viewBox without size");
    SvgFrame frame;
    frame.m << scale, 0.0, 0.0, -scale;
    return frame;
  }

  SvgFrame transform(const SvgTag& tag) const {
    SvgFrame frame;
    const std::string text = tag.get("transform");
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t open = text.find('(', at), close = text.find(')', at);
      if (open == std::string::npos || close == std::string::npos || close < open) break;
      const std::string kind = svg_words(std::string_view(text).substr(at, open - at));
      std::vector<double> v;
      for (SvgNumbers in(std::string_view(text).substr(open + 1, close - open - 1));
           !in.is_done();) {
        const auto value = in.number();
        if (!value)
          refuse(fmt::format("line {}: a transform has no numbers; export it again", tag.line));
        v.push_back(*value);
      }
      SvgFrame step;
      const std::string name = kind.substr(kind.find_last_of(" ,") + 1);
      if (name == "translate" && !v.empty()) {
        step.t = {v[0], v.size() > 1 ? v[1] : 0.0};
      } else if (name == "scale" && !v.empty()) {
        step.m << v[0], 0.0, 0.0, v.size() > 1 ? v[1] : v[0];
      } else if (name == "rotate" && !v.empty()) {
        const auto [sine, cosine] = elementary::sin_cos(v[0] * std::numbers::pi / 180.0);
        step.m << cosine, -sine, sine, cosine;
        if (v.size() == 3) step.t = Vec2(v[1], v[2]) - step.m * Vec2(v[1], v[2]);
      } else if (name == "matrix" && v.size() == 6) {
        step.m << v[0], v[2], v[1], v[3];
        step.t = {v[4], v[5]};
      } else {
        refuse(fmt::format("line {}: the transform {} cannot be read; apply it before the export",
                           tag.line, detail::quoted(name)));
      }
      frame = frame.then(step);
      at = close + 1;
    }
    return frame;
  }

  struct Group {
    SvgFrame frame;
    PieceLayer layer = PieceLayer::boundary;
    std::string name;
    bool is_hidden = false;  // of definitions, which are not drawn
    std::size_t piece = 0;   // index + 1 of the line that a title would name
  };

  static std::string name_of(const SvgTag& tag) {
    for (const char* key : {"inkscape:label", "data-name", "id"})
      if (const std::string name = tag.get(key); !name.empty()) return name;
    return "";
  }

  void walk() {
    std::vector<Group> open(1);
    open.front().frame = root(tags_.front());
    std::vector<std::string> names = {"svg"};
    for (std::size_t i = 1; i < tags_.size(); ++i) {
      const SvgTag& tag = tags_[i];
      if (tag.is_end) {
        if (names.size() > 1 && names.back() == tag.name) names.pop_back(), open.pop_back();
        continue;
      }
      Group group = open.back();
      group.frame = group.frame.then(transform(tag));
      group.piece = 0;
      if (tag.name == "defs" || tag.name == "clipPath" || tag.name == "marker" ||
          tag.name == "symbol")
        group.is_hidden = true;
      if (tag.name == "g") {
        group.name = name_of(tag);
        const PieceLayer layer = detail::piece_layer(group.name);
        if (layer != PieceLayer::other) group.layer = layer;
      } else if (tag.name == "title") {
        const std::size_t piece = open.back().piece;
        if (piece > 0 && !tag.text_after.empty()) drawn_[piece - 1].name = tag.text_after;
      } else if (!group.is_hidden) {
        draw(tag, group);
        if (!drawn_.empty() && drawn_.back().tag == &tag) group.piece = drawn_.size();
      }
      if (!tag.is_empty) names.push_back(tag.name), open.push_back(group);
    }
    if (names.size() > 1)
      refuse(fmt::format("the tag {} does not end; the file is cut off",
                         detail::quoted(names.back())));
  }

  struct Drawn {
    const SvgTag* tag;
    std::string name;
    std::vector<detail::PieceLine> lines;
  };

  void draw(const SvgTag& tag, const Group& group) {
    const std::string place = fmt::format("{}: line {}", import_.drawn.name, tag.line);
    std::string data;
    if (tag.name == "path") data = tag.get("d");
    if (tag.name == "polygon") data = "M " + tag.get("points") + " Z";
    if (tag.name == "polyline") data = "M " + tag.get("points");
    const auto attribute = [&](const char* key) {
      const std::string text = tag.get(key);
      SvgNumbers in(text);
      return in.number().value_or(0.0);
    };
    if (tag.name == "rect")
      data = fmt::format("M {} {} h {} v {} h {} Z", attribute("x"), attribute("y"),
                         attribute("width"), attribute("height"), -attribute("width"));
    if (tag.name == "line")
      data = fmt::format("M {} {} L {} {}", attribute("x1"), attribute("y1"), attribute("x2"),
                         attribute("y2"));
    if (tag.name == "circle")
      data = fmt::format("M {} {} a {r} {r} 0 1 1 0.0001 0 Z", attribute("cx"),
                         attribute("cy") - attribute("r"), fmt::arg("r", attribute("r")));
    if (data.empty()) return;
    Drawn drawn{&tag, name_of(tag), SvgPath(data, place).read()};
    if (drawn.name.empty()) drawn.name = group.name;
    PieceLayer layer = group.layer;
    if (const PieceLayer own = detail::piece_layer(tag.get("class")); own != PieceLayer::other)
      layer = own;
    for (detail::PieceLine& line : drawn.lines) {
      line.layer = layer;
      for (Vec2& p : line.points) p = group.frame.of(p);
    }
    drawn_.push_back(std::move(drawn));
  }

  /// Pieces, and to each the lines inside it.
  void gather() {
    int open = 0;
    const auto is_outline = [](const detail::PieceLine& line) {
      return line.layer == PieceLayer::boundary || line.layer == PieceLayer::sew;
    };
    for (const Drawn& drawn : drawn_)
      for (const detail::PieceLine& line : drawn.lines) {
        if (!is_outline(line)) continue;
        if (!line.is_closed && (line.points.front() - line.points.back()).norm() > 0.003) {
          ++open;
          continue;
        }
        PieceDrawing piece;
        piece.name = drawn.name.empty() ? fmt::format("piece {}", pieces_.size()) : drawn.name;
        for (const PieceDrawing& other : pieces_)
          if (other.name == piece.name)
            piece.name = fmt::format("{} {}", drawn.name, pieces_.size());
        piece.lines.push_back(line);
        pieces_.push_back(std::move(piece));
      }
    if (open > 0)
      import_.notes.push_back(fmt::format("{} open paths are no pieces and are left out", open));
    for (const Drawn& drawn : drawn_)
      for (const detail::PieceLine& line : drawn.lines) {
        if (is_outline(line)) continue;
        const Vec2 middle = 0.5 * (line.points.front() + line.points.back());
        for (PieceDrawing& piece : pieces_) {
          Vec2 low = piece.lines[0].points[0], high = low;
          for (const Vec2& p : piece.lines[0].points)
            low = low.cwiseMin(p), high = high.cwiseMax(p);
          if ((middle - low).minCoeff() > -0.005 && (high - middle).minCoeff() > -0.005) {
            piece.lines.push_back(line);
            break;
          }
        }
      }
  }

  const std::string& text_;
  PatternImport import_;
  std::vector<SvgTag> tags_;
  std::vector<Drawn> drawn_;
  std::vector<PieceDrawing> pieces_;
};

}  // namespace

PatternImport parse_svg_pattern(const std::string& text, const std::string& name) {
  return SvgReader(text, name).read();
}

}  // namespace selvedge
