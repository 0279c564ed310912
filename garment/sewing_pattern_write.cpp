// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/garment/sewing_pattern.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace selvedge {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double kUnits = 100.0;  // per metre

/// Centimetres with 1e-9 of them, without -0.
double centimetres(double metres) { return std::round(metres * kUnits * 1e9) / 1e9 + 0.0; }

OrderedJson json_point(const Vec2& p) { return {centimetres(p.x()), centimetres(p.y())}; }

/// Degrees about the fixed axes x, y and z in turn: R = Rz Ry Rx.
Vec3 angles_of(const Mat3& r) {
  const double y = elementary::asin(std::clamp(-r(2, 0), -1.0, 1.0));
  Vec3 angles(0.0, y, 0.0);
  if (std::abs(r(2, 0)) < 1.0 - 1e-12) {
    angles.x() = elementary::atan2(r(2, 1), r(2, 2));
    angles.z() = elementary::atan2(r(1, 0), r(0, 0));
  } else {
    angles.z() = elementary::atan2(-r(0, 1), r(1, 1));
  }
  return angles * (180.0 / std::numbers::pi);
}

OrderedJson json_elastic(const PatternElastic& elastic) {
  return {{"ratio", elastic.ratio}, {"stiffness", elastic.stiffness}};
}

OrderedJson json_line(const PatternLine& line) {
  OrderedJson j = {{"endpoints", {line.endpoints[0], line.endpoints[1]}}};
  if (line.angle) j["angle"] = *line.angle * (180.0 / std::numbers::pi);
  if (line.angle) j["stiffness"] = line.stiffness;
  if (line.elastic.ratio > 0.0) j["elastic"] = json_elastic(line.elastic);
  return j;
}

OrderedJson json_edge(const PatternEdge& edge) {
  OrderedJson j = {{"endpoints", {edge.endpoints[0], edge.endpoints[1]}}};
  const PatternCurve& curve = edge.curve;
  using Kind = PatternCurve::Kind;
  if (curve.kind == Kind::quadratic)
    j["curvature"] = {{"type", "quadratic"}, {"params", {json_point(curve.control[0])}}};
  else if (curve.kind == Kind::cubic)
    j["curvature"] = {{"type", "cubic"},
                      {"params", {json_point(curve.control[0]), json_point(curve.control[1])}}};
  else if (curve.kind == Kind::arc)
    j["curvature"] = {
        {"type", "circle"},
        {"params", {curve.radius * kUnits, curve.large_arc ? 1 : 0, curve.clockwise ? 1 : 0}}};
  if (curve.kind == Kind::polyline) {
    OrderedJson points = OrderedJson::array();
    for (const Vec2& p : curve.through) points.push_back(json_point(p));
    j["curvature"] = {{"type", "polyline"}, {"params", points}};
  }
  if (!edge.label.empty()) j["label"] = edge.label;
  if (edge.elastic.ratio > 0.0) j["elastic"] = json_elastic(edge.elastic);
  return j;
}

OrderedJson json_panel(const PatternPanel& panel) {
  const Vec3 angles = angles_of(panel.rotation);
  OrderedJson j = {{"translation",
                    {centimetres(panel.translation.x()), centimetres(panel.translation.y()),
                     centimetres(panel.translation.z())}},
                   {"rotation", {angles.x() + 0.0, angles.y() + 0.0, angles.z() + 0.0}}};
  if (panel.bend.radius != 0.0)
    j["bend"] = {{"radius", centimetres(panel.bend.radius)},
                 {"at", json_point(panel.bend.at)},
                 {"axis", {panel.bend.axis.x(), panel.bend.axis.y()}}};
  j["vertices"] = OrderedJson::array();
  for (const Vec2& v : panel.vertices) j["vertices"].push_back(json_point(v));
  j["edges"] = OrderedJson::array();
  for (const PatternEdge& edge : panel.edges) j["edges"].push_back(json_edge(edge));
  for (const PatternLine& line : panel.lines) j["lines"].push_back(json_line(line));
  if (!panel.fabric.empty()) j["fabric"] = panel.fabric;
  // Its presence marks the newer format, in which the file fixes which ends of two edges meet.
  j["label"] = panel.label;
  return j;
}

}  // namespace

std::string sewing_pattern_text(const SewingPattern& pattern) {
  OrderedJson panels = OrderedJson::object(), stitches = OrderedJson::array();
  for (const PatternPanel& panel : pattern.panels) panels[panel.name] = json_panel(panel);
  const auto side = [&](const PatternStitch::Side& s) {
    const PatternPanel& panel = pattern.panels[s.panel];
    const std::int32_t line = s.edge - static_cast<std::int32_t>(panel.edges.size());
    return line < 0 ? OrderedJson{{"panel", panel.name}, {"edge", s.edge}}
                    : OrderedJson{{"panel", panel.name}, {"line", line}};
  };
  for (const PatternStitch& stitch : pattern.stitches) {
    OrderedJson& j = stitches.emplace_back(OrderedJson::array({side(stitch.a), side(stitch.b)}));
    if (stitch.direction == PatternStitch::Direction::start_to_start) j.push_back("right_wrong");
    if (stitch.closure == PatternStitch::Closure::zip) j.push_back("zip");
    if (stitch.closure == PatternStitch::Closure::buttons)
      j.push_back({{"buttons", stitch.buttons}});
  }
  const OrderedJson j = {{"pattern", {{"panels", panels}, {"stitches", stitches}}},
                         {"properties",
                          {{"curvature_coords", "absolute"},
                           {"normalize_panel_translation", false},
                           {"units_in_meter", kUnits}}}};
  return j.dump(1) + "\n";
}

}  // namespace selvedge
