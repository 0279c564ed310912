// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/html.h>
#include <selvedge/dress/detail/skin_distance.h>
#include <selvedge/dress/internal/arrange.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace selvedge {
namespace {

constexpr double kDrawnScale = 400.0;  // mm of the drawing for a metre
constexpr double kDrawnMargin = 30.0;  // mm
constexpr double kStrip = 0.008;       // m, height of the strips that show the body
constexpr std::int32_t kDrawnPieces = 16;

/// One view: `right` of the drawing, and `toward` the viewer.
class View {
 public:
  View(const Arrangement& arrangement, const TriangleMesh& body, const BodyLandmarks& marks,
       const Vec3& right, const Vec3& toward)
      : arrangement_(arrangement), body_(body), marks_(marks), right_(right), toward_(toward) {
    for (const Vec3& x : body.vertices) include(x);
    for (const PatternPanel& panel : arrangement.pattern.panels)
      for (const Vec3& x : outline_of(panel)) include(x);
  }

  double width() const { return kDrawnScale * (high_.x() - low_.x()); }
  double height() const { return kDrawnScale * (high_.y() - low_.y()); }

  std::string draw(double x, double y, const std::string& title) {
    origin_ = {x, y};
    out_ = fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"14\" fill=\"#222\">{}</text>\n",
                       x, y - 8.0, title);
    std::vector<std::size_t> order(arrangement_.pattern.panels.size());
    std::iota(order.begin(), order.end(), 0);
    std::vector<double> depth;
    for (const PatternPanel& panel : arrangement_.pattern.panels) depth.push_back(depth_of(panel));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return depth[a] < depth[b]; });
    const double middle = toward_.dot(marks_.waist.middle);
    for (const std::size_t p : order)
      if (depth[p] <= middle) draw_panel(p);
    draw_body();
    for (const std::size_t p : order)
      if (depth[p] > middle) draw_panel(p);
    draw_marks();
    return out_;
  }

 private:
  void include(const Vec3& x) {
    const Eigen::Vector2d p(right_.dot(x), marks_.up.dot(x));
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }

  Eigen::Vector2d at(const Vec3& x) const {
    return origin_ +
           kDrawnScale * Eigen::Vector2d(right_.dot(x) - low_.x(), high_.y() - marks_.up.dot(x));
  }

  static std::vector<Vec3> outline_of(const PatternPanel& panel) {
    std::vector<Vec3> points;
    for (std::int32_t e = 0; e < static_cast<std::int32_t>(panel.edges.size()); ++e)
      for (const Vec2& x : divide_edge(panel, e, kDrawnPieces))
        points.push_back(place_point(panel, x));
    return points;
  }

  double depth_of(const PatternPanel& panel) const {
    double sum = 0.0;
    const std::vector<Vec3> points = outline_of(panel);
    for (const Vec3& x : points) sum += toward_.dot(x);
    return sum / static_cast<double>(points.size());
  }

  void draw_panel(std::size_t p) {
    const PatternPanel& panel = arrangement_.pattern.panels[p];
    constexpr double golden = 137.50776405;
    const double hue = std::fmod(15.0 + golden * static_cast<double>(p), 360.0);
    std::string path;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    const std::vector<Vec3> points = outline_of(panel);
    for (const Vec3& x : points) {
      const Eigen::Vector2d q = at(x);
      fmt::format_to(std::back_inserter(path), "{}{:.1f} {:.1f}", path.empty() ? "M" : "L", q.x(),
                     q.y());
      middle += q / static_cast<double>(points.size());
    }
    out_ += fmt::format(
        "<path d=\"{}Z\" fill=\"hsl({:.0f},60%,60%)\" fill-opacity=\"0.45\" "
        "stroke=\"hsl({:.0f},70%,35%)\"/>\n",
        path, hue, hue);
    out_ += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"9\" text-anchor=\"middle\" "
        "fill=\"#222\">{}</text>\n",
        middle.x(), middle.y(), html_escaped(panel.name));
  }

  /// Strips as wide as the sections of the body at their heights.
  void draw_body() {
    std::vector<double> heights;
    for (const Vec3& x : body_.vertices) heights.push_back(marks_.up.dot(x));
    const auto [least, most] = std::minmax_element(heights.begin(), heights.end());
    std::string path;
    for (double h = *least + 0.5 * kStrip; h < *most; h += kStrip)
      for (const detail::SkinLoop& loop : detail::level_loops(body_, heights, h)) {
        double first = 1e300, last = -1e300;
        for (const Vec3& x : loop.points) {
          first = std::min(first, right_.dot(x));
          last = std::max(last, right_.dot(x));
        }
        fmt::format_to(std::back_inserter(path), "M{:.1f} {:.1f}h{:.1f}v{:.1f}h{:.1f}Z",
                       origin_.x() + kDrawnScale * (first - low_.x()),
                       origin_.y() + kDrawnScale * (high_.y() - h - 0.5 * kStrip),
                       kDrawnScale * (last - first), kDrawnScale * kStrip + 0.3,
                       -kDrawnScale * (last - first));
      }
    out_ += fmt::format("<path d=\"{}\" fill=\"#b9b4ab\"/>\n", path);
  }

  void draw_marks() {
    const auto dot = [&](const Vec3& x, const char* name) {
      const Eigen::Vector2d p = at(x);
      out_ += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.5\" "
          "fill=\"#b00\"><title>{}</title></circle>\n",
          p.x(), p.y(), name);
    };
    dot(marks_.top, "top of head");
    dot(marks_.crotch, "crotch");
    for (const auto& [ring, name] :
         {std::pair(&marks_.neck, "neck"), std::pair(&marks_.bust, "bust"),
          std::pair(&marks_.waist, "waist"), std::pair(&marks_.hips, "hips")})
      dot(ring->middle, name);
    for (int k = 0; k < 2; ++k) {
      dot(marks_.neck_side[k], "neck");
      dot(marks_.shoulder[k], "shoulder");
      dot(marks_.armpit[k], "armpit");
      for (const BodyLimb* limb : {&marks_.arms[k], &marks_.legs[k]}) {
        dot(limb->tip, "tip");
        dot(limb->lower.middle, "wrist or ankle");
      }
    }
  }

  const Arrangement& arrangement_;
  const TriangleMesh& body_;
  const BodyLandmarks& marks_;
  Vec3 right_, toward_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(1e300), high_ = -low_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  std::string out_;
};

}  // namespace

std::string arrangement_svg(const Arrangement& arrangement, const TriangleMesh& body,
                            const BodyLandmarks& landmarks) {
  View front(arrangement, body, landmarks, landmarks.left, landmarks.forward);
  View side(arrangement, body, landmarks, -landmarks.forward, landmarks.left);
  const double second = 2.0 * kDrawnMargin + front.width(), top = 2.0 * kDrawnMargin;
  const std::string drawing =
      front.draw(kDrawnMargin, top, "front") + side.draw(second, top, "left side");
  const double width = second + side.width() + kDrawnMargin;
  const double height = top + std::max(front.height(), side.height()) + kDrawnMargin;
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}mm\" height=\"{1:.0f}mm\" "
      "viewBox=\"0 0 {0:.0f} {1:.0f}\" font-family=\"Helvetica, Arial, sans-serif\">\n"
      "<title>{2}</title>\n<rect width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "fill=\"white\"/>\n{3}</svg>\n",
      width, height, html_escaped(arrangement.pattern.name), drawing);
}

}  // namespace selvedge
