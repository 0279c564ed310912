// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/base/internal/html.h>
#include <selvedge/garment/internal/pattern_svg.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>

namespace selvedge {
namespace {

// All lengths of the sheet are millimetres.
constexpr double kMargin = 25.0, kGap = 70.0, kNameSize = 15.0, kNumberSize = 9.5, kBadge = 8.0,
                 kInset = 12.0;
constexpr std::int32_t kPiecesOfCurve = 24;

struct Box {
  Vec2 low, high;
  double width() const { return high.x() - low.x(); }
  double height() const { return high.y() - low.y(); }
};

/// Hues by the golden angle, so that neighbouring numbers differ most.
std::string colour_of(std::int32_t stitch) {
  constexpr double golden = 137.50776405;
  return fmt::format("hsl({:.0f},70%,{}%)", std::fmod(15.0 + golden * stitch, 360.0),
                     stitch % 2 == 0 ? 38 : 48);
}

/// Millimetres, y downwards as SVG has it.
std::vector<Vec2> drawn_edge(const PatternPanel& panel, std::int32_t e) {
  const bool straight =
      panel.is_line(e) || panel.edges[e].curve.kind == PatternCurve::Kind::straight;
  std::vector<Vec2> points = divide_edge(panel, e, straight ? 2 : kPiecesOfCurve);
  for (Vec2& p : points) p = Vec2(1000.0 * p.x(), -1000.0 * p.y());
  return points;
}

Box box_of(const PatternPanel& panel) {
  Box box{Vec2::Constant(1e300), Vec2::Constant(-1e300)};
  for (std::int32_t e = 0; e < static_cast<std::int32_t>(panel.edges.size()); ++e)
    for (const Vec2& p : drawn_edge(panel, e)) {
      box.low = box.low.cwiseMin(p);
      box.high = box.high.cwiseMax(p);
    }
  return box;
}

class Sheet {
 public:
  explicit Sheet(const SewingPattern& pattern)
      : pattern_(pattern), directions_(seam_directions(pattern)) {
    for (const PatternPanel& panel : pattern.panels) {
      boxes_.push_back(box_of(panel));
      stitch_of_.emplace_back(panel.edges.size() + panel.lines.size(), -1);
    }
    for (std::size_t s = 0; s < pattern.stitches.size(); ++s)
      for (const PatternStitch::Side& side : {pattern.stitches[s].a, pattern.stitches[s].b})
        stitch_of_[side.panel][side.edge] = static_cast<std::int32_t>(s);
  }

  std::string text() {
    lay_out();
    for (std::size_t p = 0; p < boxes_.size(); ++p) draw_panel(p);
    draw_scale();
    const auto size = fmt::format("{:.0f}", width_), height = fmt::format("{:.0f}", height_);
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{1}mm\" viewBox=\"0 0 "
        "{0} "
        "{1}\" font-family=\"Helvetica, Arial, sans-serif\">\n<title>{2}</title>\n<rect "
        "width=\"{0}\" "
        "height=\"{1}\" fill=\"white\"/>\n{3}</svg>\n",
        size, height, html_escaped(pattern_.name), body_);
  }

 private:
  /// Rows from the left, the tallest panels first.
  void lay_out() {
    std::vector<std::size_t> order(boxes_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return boxes_[a].height() > boxes_[b].height();
    });
    double area = 0.0, widest = 0.0;
    for (const Box& box : boxes_) {
      area += (box.width() + kGap) * (box.height() + kGap);
      widest = std::max(widest, box.width());
    }
    const double row_width = std::max(widest + kGap, 1.25 * std::sqrt(1.6 * area));
    offsets_.resize(boxes_.size());
    double x = kGap / 2.0, y = top(), tallest = 0.0;
    for (const std::size_t p : order) {
      if (x > kGap && x + boxes_[p].width() > row_width) {
        x = kGap / 2.0;
        y += tallest + kGap;
        tallest = 0.0;
      }
      offsets_[p] = Vec2(x, y) - boxes_[p].low;
      x += boxes_[p].width() + kGap;
      tallest = std::max(tallest, boxes_[p].height());
      width_ = std::max(width_, x);
    }
    width_ = std::max(width_, 520.0);
    height_ = y + tallest + kGap / 2.0 + kMargin;
  }

  static double top() { return kMargin + 2.6 * kNameSize + kGap / 2.0; }

  void draw_panel(std::size_t p) {
    const PatternPanel& panel = pattern_.panels[p];
    const auto n = static_cast<std::int32_t>(panel.edges.size());
    const double outward = panel_area(panel) > 0.0 ? 1.0 : -1.0;  // y points downwards
    std::string path;
    Vec2 middle = Vec2::Zero();
    std::int64_t points = 0;
    for (std::int32_t e = 0; e < n; ++e)
      for (const Vec2& q : drawn_edge(panel, e)) {
        const Vec2 at = q + offsets_[p];
        fmt::format_to(std::back_inserter(path), "{}{:.2f} {:.2f}", path.empty() ? "M" : "L",
                       at.x(), at.y());
        middle += at;
        ++points;
      }
    body_ += fmt::format("<path d=\"{}Z\" fill=\"#f4f1ea\" stroke=\"none\"/>\n", path);
    for (std::int32_t e = 0; e < n; ++e) draw_edge(p, e, outward);
    for (std::int32_t l = 0; l < static_cast<std::int32_t>(panel.lines.size()); ++l)
      draw_line(p, l);
    middle = name_place(p, middle / static_cast<double>(points));
    // The middle of the long edges of a narrow panel has their numbers.
    if (boxes_[p].height() < 4.0 * kNameSize) middle.x() -= 0.22 * boxes_[p].width();
    put_text(middle, kNameSize, "#222", html_escaped(panel.name), true);
    if (boxes_[p].height() > 5.0 * kNameSize)
      put_text(
          middle + Vec2(0.0, 1.4 * kNameSize), kNumberSize, "#666",
          fmt::format("{:.1f} by {:.1f} cm", boxes_[p].width() / 10.0, boxes_[p].height() / 10.0),
          false);
  }

  /// The name stands at the middle of the width of the panel at the height of its middle.
  Vec2 name_place(std::size_t p, const Vec2& middle) const {
    const PatternPanel& panel = pattern_.panels[p];
    std::vector<double> crossings;
    for (std::int32_t e = 0; e < static_cast<std::int32_t>(panel.edges.size()); ++e) {
      const std::vector<Vec2> points = drawn_edge(panel, e);
      for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Vec2 a = points[i] + offsets_[p], b = points[i + 1] + offsets_[p];
        if ((a.y() > middle.y()) != (b.y() > middle.y()))
          crossings.push_back(a.x() + (middle.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
      }
    }
    std::sort(crossings.begin(), crossings.end());
    Vec2 place = middle;
    double widest = 0.0;
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
      if (crossings[i + 1] - crossings[i] > widest) {
        widest = crossings[i + 1] - crossings[i];
        place.x() = 0.5 * (crossings[i] + crossings[i + 1]);
      }
    return place;
  }

  void draw_edge(std::size_t p, std::int32_t e, double outward) {
    const PatternPanel& panel = pattern_.panels[p];
    std::vector<Vec2> points = drawn_edge(panel, e);
    for (Vec2& q : points) q += offsets_[p];
    const std::int32_t stitch = stitch_of_[p][e];
    const std::string colour = stitch < 0 ? "#777" : colour_of(stitch);
    std::string path;
    for (const Vec2& q : points)
      fmt::format_to(std::back_inserter(path), "{:.2f},{:.2f} ", q.x(), q.y());
    body_ += fmt::format(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{}/>\n", path,
        colour, stitch < 0 ? 1.2 : 2.6, stitch < 0 ? " stroke-dasharray=\"6 3\"" : "");
    const std::size_t half = points.size() / 2;
    const Vec2 along = (points[half + 1] - points[half - 1]).normalized();
    const Vec2 inward = -outward * Vec2(-along.y(), along.x()), middle = points[half];
    write_on_edge(p, e, middle, along, inward);
    if (stitch >= 0) draw_stitch(p, e, points, middle + kInset * inward);
  }

  /// A line inside a panel, with its stitch, and what it does beside its middle.
  void draw_line(std::size_t p, std::int32_t l) {
    const PatternPanel& panel = pattern_.panels[p];
    const std::int32_t e = static_cast<std::int32_t>(panel.edges.size()) + l;
    std::vector<Vec2> points = drawn_edge(panel, e);
    for (Vec2& q : points) q += offsets_[p];
    body_ += fmt::format(
        "<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" stroke=\"{}\" "
        "stroke-width=\"1.2\" stroke-dasharray=\"2 2\"/>\n",
        points[0].x(), points[0].y(), points[2].x(), points[2].y(),
        stitch_of_[p][e] < 0 ? "#777" : colour_of(stitch_of_[p][e]));
    const PatternLine& line = panel.lines[static_cast<std::size_t>(l)];
    std::string words = fmt::format("line {}", l);
    if (line.angle) words += fmt::format(", fold {:.0f}°", *line.angle * 180.0 / std::numbers::pi);
    if (line.elastic.ratio > 0.0) words += fmt::format(", elastic {:g}", line.elastic.ratio);
    const Vec2 along = (points[2] - points[0]).normalized();
    put_along(points[1] + kInset * Vec2(-along.y(), along.x()),
              along.x() < 0.0 ? Vec2(-along) : along, "middle", words);
    if (stitch_of_[p][e] >= 0) draw_stitch(p, e, points, points[1]);
  }

  /// Inside: number, stitch and length, as far as they fit; outside: the label.
  void write_on_edge(std::size_t p, std::int32_t e, const Vec2& middle, const Vec2& along,
                     const Vec2& inward) {
    const PatternPanel& panel = pattern_.panels[p];
    const bool sewn = stitch_of_[p][e] >= 0;
    const double length = 1000.0 * edge_length(panel, e);
    const Vec2 inside = middle + kInset * inward, right = along.x() < -1e-9 ? Vec2(-along) : along;
    const Vec2 number = !sewn           ? inside
                        : length > 40.0 ? Vec2(inside - 2.0 * kBadge * right)
                                        : Vec2(middle - kInset * inward);
    put_text(number, kNumberSize, "#222", std::to_string(e), false);
    if (length > 75.0)
      put_along(inside + (sewn ? 1.4 * kBadge : kBadge) * right, right, "start",
                fmt::format("{:.1f}", length / 10.0));
    std::string label = panel.edges[e].label;
    if (const double ratio = panel.edges[e].elastic.ratio; ratio > 0.0)
      label += fmt::format("{}elastic {:g}", label.empty() ? "" : ", ", ratio);
    if (0.6 * kNumberSize * static_cast<double>(label.size()) < length)
      put_along(middle - kInset * inward, right, "middle", label);
  }

  /// The number of the stitch, and a mark at the ends that meet.
  void draw_stitch(std::size_t p, std::int32_t e, const std::vector<Vec2>& points,
                   const Vec2& place) {
    const std::int32_t s = stitch_of_[p][e];
    const PatternStitch& stitch = pattern_.stitches[s];
    const std::string colour = colour_of(s);
    body_ += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\" fill=\"{}\"/>\n", place.x(),
                         place.y(), kBadge, colour);
    put_text(place, kNumberSize, "white", std::to_string(s), true);
    const bool first = stitch.a.panel == static_cast<std::int32_t>(p) && stitch.a.edge == e;
    const bool at_start = first || directions_[s].start_to_start;
    // A quarter of a badge inward from the end, so that marks of two edges at a corner differ.
    const std::size_t n = points.size();
    const Vec2 end = at_start ? points[0] : points[n - 1],
               next = at_start ? points[1] : points[n - 2];
    const double step = std::min(7.0, 0.4 * (next - end).norm());
    const Vec2 mark = end + step * (next - end).normalized();
    body_ += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"3.6\" fill=\"{}\"/>\n", mark.x(),
                         mark.y(), colour);
  }

  void put_text(const Vec2& at, double size, const char* colour, const std::string& words,
                bool bold) {
    body_ += fmt::format(
        "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{}\" fill=\"{}\" text-anchor=\"middle\"{}>{}"
        "</text>\n",
        at.x(), at.y() + 0.35 * size, size, colour, bold ? " font-weight=\"bold\"" : "", words);
  }

  void put_along(const Vec2& at, const Vec2& along, const char* anchor, const std::string& words) {
    if (words.empty()) return;
    body_ += fmt::format(
        "<text transform=\"translate({:.2f} {:.2f}) rotate({:.1f})\" y=\"3\" font-size=\"{}\" "
        "fill=\"#666\" text-anchor=\"{}\">{}</text>\n",
        at.x(), at.y(), elementary::atan2(along.y(), along.x()) * 180.0 / std::numbers::pi,
        kNumberSize, anchor, html_escaped(words));
  }

  void draw_scale() {
    const std::string name = pattern_.name.substr(pattern_.name.find_last_of('/') + 1);
    double area = 0.0;
    for (const PatternPanel& panel : pattern_.panels) area += std::abs(panel_area(panel));
    body_ += fmt::format(
        "<text x=\"{}\" y=\"{:.1f}\" font-size=\"{}\" font-weight=\"bold\" "
        "fill=\"#222\">{}</text>\n",
        kMargin, kMargin + 0.8 * kNameSize, 1.2 * kNameSize, html_escaped(name));
    body_ += fmt::format(
        "<text x=\"{}\" y=\"{:.1f}\" font-size=\"{}\" fill=\"#666\">{} panels, {} stitches, {:.2f} "
        "m\u00b2; "
        "black: edges; in colour: stitches, whose dots meet; grey: cm</text>\n",
        kMargin, kMargin + 2.2 * kNameSize, kNumberSize, pattern_.panels.size(),
        pattern_.stitches.size(), area);
    const double y = height_ - kMargin, right = width_ - kMargin;
    body_ += fmt::format(
        "<path d=\"M{0:.1f} {1:.1f}v-5h100v5\" fill=\"none\" stroke=\"#222\" "
        "stroke-width=\"1.5\"/>\n",
        right - 100.0, y);
    put_text({right - 50.0, y + kNumberSize}, kNumberSize, "#222", "10 cm", false);
  }

  const SewingPattern& pattern_;
  std::vector<SeamDirection> directions_;
  std::vector<Box> boxes_;
  std::vector<std::vector<std::int32_t>> stitch_of_;
  std::vector<Vec2> offsets_;
  std::string body_;
  double width_ = 0.0, height_ = 0.0;
};

}  // namespace

std::string pattern_svg(const SewingPattern& pattern) { return Sheet(pattern).text(); }

}  // namespace selvedge
