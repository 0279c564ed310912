// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/base/internal/json_value.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/garment/detail/pattern_names.h>
#include <selvedge/garment/internal/drawn_pattern.h>
#include <selvedge/garment/sewing_pattern.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <stdexcept>

namespace selvedge {

std::string detail::quoted(const std::string& name) {
  constexpr std::size_t most = 60;
  std::string text = name.size() > most ? name.substr(0, most) + "..." : name;
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return "\"" + text + "\"";
}

std::string detail::edge_name(const SewingPattern& pattern, const PatternStitch::Side& side) {
  const PatternPanel& panel = pattern.panels[side.panel];
  const bool is_line = panel.is_line(side.edge);
  return fmt::format("{} {} of panel {}", is_line ? "line" : "edge",
                     side.edge - (is_line ? static_cast<std::int32_t>(panel.edges.size()) : 0),
                     quoted(panel.name));
}

namespace {

using Json = nlohmann::json;
using detail::quoted;
using Kind = PatternCurve::Kind;

/// Deeper nesting than any pattern has.
constexpr int kDeepest = 32;
constexpr std::int32_t kMostButtons = 1000;  // of a stitch

class PatternReader {
 public:
  PatternReader(const Json& j, std::string name, const PatternLimits& limits)
      : j_(j), limits_(limits) {
    pattern_.name = std::move(name);
  }

  SewingPattern read() {
    const Json& inner = object(member(j_, "pattern", ""), "\"pattern\"");
    read_properties();
    const Json& panels = object(member(inner, "panels", "\"pattern\""), "\"panels\"");
    for (const auto& [name, panel] : panels.items()) read_panel(name, panel);
    read_stitches(inner);
    if (!is_drawn_) return std::move(pattern_);
    drawn_.name = pattern_.name;
    return as_sewn(drawn_);
  }

 private:
  [[noreturn]] void refuse(const std::string& place, const std::string& fault) const {
    throw std::invalid_argument(
        fmt::format("{}: {}{}{}", pattern_.name, place, place.empty() ? "" : " ", fault));
  }

  const Json& object(const Json& j, const std::string& place) const {
    if (!j.is_object()) refuse(place, "must be a JSON object with names in quotes");
    return j;
  }

  const Json& member(const Json& j, const char* key, const std::string& place) const {
    object(j, place.empty() ? "the file" : place);
    const auto found = j.find(key);
    if (found == j.end())
      refuse(place, fmt::format("has no \"{}\"; add it as in the files of GarmentCode{}", key,
                                key == std::string("translation")
                                    ? ", or place the panels with `selvedge arrange`"
                                    : ""));
    return *found;
  }

  const Json& list(const Json& j, const std::string& place) const {
    if (!j.is_array()) refuse(place, "must be a list in brackets");
    return j;
  }

  double number(const Json& j, const std::string& place) const {
    if (!j.is_number()) refuse(place, "must be a number");
    const auto value = j.get<double>();
    if (!std::isfinite(value)) refuse(place, "must be a finite number");
    return value;
  }

  std::int32_t index(const Json& j, const std::string& place) const {
    const double value = number(j, place);
    if (value != std::floor(value) || value < 0.0 || value > 1e9)
      refuse(place, fmt::format("must be a whole number from 0, not {:g}", value));
    return static_cast<std::int32_t>(value);
  }

  std::string text(const Json& j, const std::string& place) const {
    if (!j.is_string()) refuse(place, "must be a text in quotes");
    return j.get<std::string>();
  }

  template <int N>
  Eigen::Matrix<double, N, 1> vector(const Json& j, const std::string& place) const {
    if (!j.is_array() || j.size() != N)
      refuse(place, fmt::format("must be a list of {} numbers", N));
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v[i] = number(j[i], place);
    return v;
  }

  void read_properties() {
    const std::string place = "\"properties\"";
    const Json& properties = object(member(j_, "properties", ""), place);
    units_ = number(member(properties, "units_in_meter", place), "\"units_in_meter\"");
    if (!(units_ >= 1e-6) || units_ > 1e9)
      refuse("",
             fmt::format("\"units_in_meter\" must be the number of length units in a metre, such "
                         "as 100 for centimetres, not {:g}",
                         units_));
    if (const auto found = properties.find("curvature_coords"); found != properties.end()) {
      const std::string coords = text(*found, "\"curvature_coords\"");
      if (coords != "relative" && coords != "absolute")
        refuse("\"curvature_coords\"",
               fmt::format("must be \"relative\" or \"absolute\", not {}", quoted(coords)));
      relative_ = coords == "relative";
    }
  }

  void read_panel(const std::string& name, const Json& j) {
    const std::string place = fmt::format("panel {}", quoted(name));
    object(j, place);
    PatternPanel panel;
    panel.name = name;
    const Json& vertices = list(member(j, "vertices", place), place + ": \"vertices\"");
    for (std::size_t i = 0; i < vertices.size(); ++i)
      panel.vertices.push_back(vector<2>(vertices[i], fmt::format("{}: vertex {}", place, i)) /
                               units_);
    const Json& edges = list(member(j, "edges", place), place + ": \"edges\"");
    for (std::size_t i = 0; i < edges.size(); ++i)
      panel.edges.push_back(read_edge(panel, edges[i], fmt::format("{}: edge {}", place, i)));
    if (j.contains("lines")) {
      const Json& lines = list(j["lines"], place + ": \"lines\"");
      for (std::size_t i = 0; i < lines.size(); ++i)
        panel.lines.push_back(read_line(panel, lines[i], fmt::format("{}: line {}", place, i)));
    }
    if (j.contains("fabric")) panel.fabric = text(j["fabric"], place + ": \"fabric\"");
    read_place(panel, j, place);
    if (j.contains("label")) newer_ = true, panel.label = label(j, place);
    drawn_.panels.push_back(read_drawn(panel, j, place));
    pattern_.panels.push_back(std::move(panel));
  }

  /// What a person draws beside the outline: fold, pair, grain and notches.
  DrawnPanel read_drawn(const PatternPanel& panel, const Json& j, const std::string& place) {
    DrawnPanel drawn;
    drawn.panel = panel;
    if (j.contains("fold")) drawn.fold = index(j["fold"], place + ": \"fold\"");
    if (j.contains("pair")) {
      const std::string side = text(j["pair"], place + ": \"pair\"");
      if (side != "left" && side != "right")
        refuse(place, "\"pair\" must be \"left\" or \"right\", the side for which it is drawn");
      drawn.is_pair = true;
      drawn.is_right = side == "right";
    }
    if (drawn.fold >= 0 && drawn.is_pair)
      refuse(place, "has a fold and is one of a pair; give one of both");
    if (j.contains("grain")) {
      drawn.grain = vector<2>(j["grain"], place + ": \"grain\"");
      if (!(drawn.grain.norm() > 0.0))
        refuse(place, "has a grain without length; give a direction");
    }
    if (j.contains("notches")) {
      const Json& notches = list(j["notches"], place + ": \"notches\"");
      for (std::size_t i = 0; i < notches.size(); ++i) {
        const std::string where = fmt::format("{}: notch {}", place, i);
        PatternNotch& notch = drawn.notches.emplace_back();
        notch.edge = index(member(notches[i], "edge", where), where + ": its \"edge\"");
        notch.at = number(member(notches[i], "at", where), where + ": its \"at\"");
        if (notches[i].contains("name"))
          notch.name = text(notches[i]["name"], where + ": its \"name\"");
      }
    }
    if (j.contains("pleats")) {
      const Json& pleats = list(j["pleats"], place + ": \"pleats\"");
      for (std::size_t i = 0; i < pleats.size(); ++i)
        drawn.pleats.push_back(read_pleat(pleats[i], fmt::format("{}: pleat {}", place, i)));
    }
    for (const char* key : {"fold", "pair", "grain", "notches", "pleats"})
      is_drawn_ = is_drawn_ || j.contains(key);
    return drawn;
  }

  DrawnPleat read_pleat(const Json& j, const std::string& where) const {
    object(j, where);
    DrawnPleat pleat;
    pleat.edge = index(member(j, "edge", where), where + ": its \"edge\"");
    pleat.at = number(member(j, "at", where), where + ": its \"at\"");
    pleat.depth = number(member(j, "depth", where), where + ": its \"depth\"") / units_;
    pleat.length = number(member(j, "length", where), where + ": its \"length\"") / units_;
    if (!j.contains("toward")) return pleat;
    const std::string toward = text(j["toward"], where + ": its \"toward\"");
    if (toward != "start" && toward != "end")
      refuse(where,
             "lies \"toward\" the \"start\" or the \"end\" of its edge, not " + quoted(toward));
    pleat.to_end = toward == "end";
    return pleat;
  }

  void read_place(PatternPanel& panel, const Json& j, const std::string& place) const {
    if (limits_.places || j.contains("translation"))
      panel.translation =
          vector<3>(member(j, "translation", place), place + ": \"translation\"") / units_;
    if (limits_.places || j.contains("rotation"))
      panel.rotation = rotation(vector<3>(member(j, "rotation", place), place + ": \"rotation\""));
    if (!j.contains("bend")) return;
    const std::string where = place + ": \"bend\"";
    const Json& bend = object(j["bend"], where);
    panel.bend.radius = number(member(bend, "radius", where), where + ": \"radius\"") / units_;
    panel.bend.at = vector<2>(member(bend, "at", where), where + ": \"at\"") / units_;
    const Vec2 axis = vector<2>(member(bend, "axis", where), where + ": \"axis\"");
    if (!(axis.norm() > 0.0)) refuse(where, "has an axis without length; give a direction");
    panel.bend.axis = axis.normalized();
  }

  /// About a coordinate axis, rad.
  static Mat3 rotation_about(int axis, double angle) {
    const auto [sine, cosine] = elementary::sin_cos(angle);
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    Mat3 turn = Mat3::Identity();
    turn(u, u) = turn(v, v) = cosine;
    turn(u, v) = -sine;
    turn(v, u) = sine;
    return turn;
  }

  /// Degrees about the fixed axes x, y and z in turn.
  static Mat3 rotation(const Vec3& degrees) {
    const Vec3 a = degrees * (std::numbers::pi / 180.0);
    return rotation_about(2, a.z()) * rotation_about(1, a.y()) * rotation_about(0, a.x());
  }

  std::string label(const Json& j, const std::string& place) const {
    const Json& value = j["label"];
    return value.is_null() ? std::string() : text(value, place + ": \"label\"");
  }

  std::array<std::int32_t, 2> read_endpoints(const PatternPanel& panel, const Json& j,
                                             const std::string& place) const {
    const Json& ends = list(member(j, "endpoints", place), place + ": \"endpoints\"");
    if (ends.size() != 2) refuse(place, "must have two endpoints");
    std::array<std::int32_t, 2> endpoints = {0, 0};
    for (std::size_t i = 0; i < 2; ++i) {
      endpoints[i] = index(ends[i], place + ": an endpoint");
      if (endpoints[i] >= static_cast<std::int32_t>(panel.vertices.size()))
        refuse(place, fmt::format("names vertex {}, but the panel has {} vertices; correct its "
                                  "endpoints",
                                  endpoints[i], panel.vertices.size()));
    }
    return endpoints;
  }

  /// A number is the ratio.
  PatternElastic read_elastic(const Json& j, const std::string& place) const {
    PatternElastic elastic;
    const std::string where = place + ": \"elastic\"";
    if (j.is_object()) {
      elastic.ratio = number(member(j, "ratio", where), where + ": \"ratio\"");
      if (j.contains("stiffness"))
        elastic.stiffness = number(j["stiffness"], where + ": \"stiffness\"");
    } else {
      elastic.ratio = number(j, where);
    }
    if (elastic.ratio == 0.0) refuse(where, "has no length; give a ratio above 0");
    return elastic;
  }

  PatternLine read_line(const PatternPanel& panel, const Json& j, const std::string& place) const {
    object(j, place);
    PatternLine line;
    line.endpoints = read_endpoints(panel, j, place);
    if (j.contains("angle"))
      line.angle = number(j["angle"], place + ": \"angle\"") * std::numbers::pi / 180.0;
    if (j.contains("stiffness")) line.stiffness = number(j["stiffness"], place + ": \"stiffness\"");
    if (j.contains("elastic")) line.elastic = read_elastic(j["elastic"], place);
    return line;
  }

  PatternEdge read_edge(const PatternPanel& panel, const Json& j, const std::string& place) {
    object(j, place);
    PatternEdge edge;
    edge.endpoints = read_endpoints(panel, j, place);
    if (j.contains("elastic")) edge.elastic = read_elastic(j["elastic"], place);
    if (j.contains("label")) edge.label = label(j, place);
    if (j.contains("curvature") && !j["curvature"].is_null()) {
      from_ = panel.vertices[edge.endpoints[0]];
      along_ = panel.vertices[edge.endpoints[1]] - from_;
      edge.curve = read_curve(j["curvature"], place);
    }
    return edge;
  }

  PatternCurve read_curve(const Json& j, const std::string& place) {
    PatternCurve curve;
    if (j.is_array()) {
      curve.kind = Kind::quadratic;
      curve.control[0] = control(j, place);
      return curve;
    }
    newer_ = true;
    const std::string type =
        text(member(j, "type", place + ": \"curvature\""), place + ": the type of its curvature");
    const Json& params =
        list(member(j, "params", place + ": \"curvature\""), place + ": \"params\"");
    if (type == "circle") return read_arc(params, place);
    if (type == "polyline") {
      curve.kind = Kind::polyline;
      for (const Json& p : params) curve.through.push_back(control(p, place));
      return curve;
    }
    const std::map<std::string, Kind> kinds = {{"quadratic", Kind::quadratic},
                                               {"cubic", Kind::cubic}};
    const auto kind = kinds.find(type);
    if (kind == kinds.end())
      refuse(place,
             fmt::format("has a curvature of type {}; give quadratic, cubic, circle or polyline",
                         quoted(type)));
    curve.kind = kind->second;
    const std::size_t points = curve.kind == Kind::cubic ? 2 : 1;
    if (params.size() != points)
      refuse(place,
             fmt::format("has {} control points; a {} curve has {}", params.size(), type, points));
    for (std::size_t i = 0; i < points; ++i) curve.control[i] = control(params[i], place);
    return curve;
  }

  Vec2 control(const Json& j, const std::string& place) const {
    const Vec2 p = vector<2>(j, place + ": a control point");
    if (!relative_) return p / units_;
    return from_ + p.x() * along_ + p.y() * Vec2(-along_.y(), along_.x());
  }

  PatternCurve read_arc(const Json& params, const std::string& place) const {
    if (params.size() != 3)
      refuse(place, "is a circle, whose \"params\" must be radius, large_arc and right");
    const auto flag = [&](const Json& j, const char* name) {
      if (j.is_boolean()) return j.get<bool>();
      const double value = number(j, fmt::format("{}: {}", place, name));
      if (value != 0.0 && value != 1.0)
        refuse(place, fmt::format("has {} = {:g}; it must be 0 or 1", name, value));
      return value == 1.0;
    };
    PatternCurve curve;
    curve.kind = Kind::arc;
    curve.radius = number(params[0], place + ": its radius") / units_;
    curve.large_arc = flag(params[1], "large_arc");
    curve.clockwise = flag(params[2], "right");
    return curve;
  }

  void read_stitches(const Json& inner) {
    if (!inner.contains("stitches")) {
      if (pattern_.panels.size() > 1)
        refuse("\"pattern\"",
               "has no \"stitches\"; list the pairs of edges that are sewn together");
      return;
    }
    const Json& stitches = list(inner["stitches"], "\"stitches\"");
    for (std::size_t s = 0; s < stitches.size(); ++s)
      read_stitch(stitches[s], fmt::format("stitch {}:", s));
    for (PatternStitch& stitch : pattern_.stitches)
      if (newer_ && stitch.direction == PatternStitch::Direction::unknown &&
          !pattern_.is_on_a_line(stitch))
        stitch.direction = PatternStitch::Direction::end_to_start;
  }

  void read_stitch(const Json& j, const std::string& place) {
    list(j, place);
    if (j.size() < 2) refuse(place, fmt::format("must have two sides, not {}", j.size()));
    PatternStitch stitch;
    DrawnStitch drawn;
    stitch.a = read_side(j[0], drawn.a, place);
    stitch.b = read_side(j[1], drawn.b, place);
    for (std::size_t i = 2; i < j.size(); ++i) read_word(j[i], stitch, place);
    drawn.start_to_start = stitch.direction == PatternStitch::Direction::start_to_start;
    drawn.closure = stitch.closure;
    drawn.buttons = stitch.buttons;
    pattern_.stitches.push_back(stitch);
    drawn_.stitches.push_back(std::move(drawn));
  }

  /// What follows the two sides: "right_wrong", "zip", or buttons by their number or places.
  void read_word(const Json& j, PatternStitch& stitch, const std::string& place) {
    if (j.is_object()) {
      const Json& buttons = member(j, "buttons", place);
      stitch.closure = PatternStitch::Closure::buttons;
      if (!buttons.is_array()) {
        const std::int32_t count = index(buttons, place + " its \"buttons\"");
        if (count < 1 || count > kMostButtons)
          refuse(place, fmt::format("has {} buttons; give 1 to {}", count, kMostButtons));
        for (std::int32_t i = 0; i < count; ++i) stitch.buttons.push_back((i + 0.5) / count);
        return;
      }
      for (const Json& at : buttons)
        stitch.buttons.push_back(number(at, place + " one of its \"buttons\""));
      return;
    }
    const std::string word = text(j, place + " what follows its two sides");
    if (word == "zip") {
      stitch.closure = PatternStitch::Closure::zip;
    } else if (word == "right_wrong") {
      newer_ = true;
      stitch.direction = PatternStitch::Direction::start_to_start;
    } else {
      refuse(place, fmt::format("ends with {}; only \"right_wrong\", \"zip\" or {{\"buttons\": 5}} "
                                "may follow the two sides",
                                quoted(word)));
    }
  }

  /// A side is an edge, edges in a row, perhaps those of a mirror image, or a list of such.
  PatternStitch::Side read_side(const Json& j, DrawnChain& chain, const std::string& place) {
    if (!j.is_array()) return read_link(j, chain, place);
    is_drawn_ = true;
    for (const Json& link : j) read_link(link, chain, place);
    if (chain.empty()) refuse(place, "has a side without edges");
    return {chain.front().panel, chain.front().edges.front()};
  }

  PatternStitch::Side read_link(const Json& j, DrawnChain& chain, const std::string& place) {
    object(j, place + " a side");
    const std::string name = text(member(j, "panel", place), place + " its \"panel\"");
    DrawnLink link;
    if (j.contains("edges")) {
      is_drawn_ = true;
      for (const Json& edge : list(j["edges"], place + " its \"edges\""))
        link.edges.push_back(index(edge, place + " one of its \"edges\""));
      if (link.edges.empty()) refuse(place, "has a side without edges");
    } else if (!j.contains("line")) {
      link.edges = {index(member(j, "edge", place), place + " its \"edge\"")};
    }
    if (j.contains("mirror")) {
      is_drawn_ = true;
      if (!j["mirror"].is_boolean()) refuse(place, "\"mirror\" must be true or false");
      link.is_mirrored = j["mirror"].get<bool>();
    }
    for (const PatternPanel& panel : pattern_.panels) {
      if (panel.name == name) {
        if (link.edges.empty()) {  // the lines are numbered after the edges
          const std::int32_t line = index(j["line"], place + " its \"line\"");
          if (line >= static_cast<std::int32_t>(panel.lines.size()))
            refuse(place, fmt::format("names line {} of panel {}, which has {}", line, quoted(name),
                                      counted(panel.lines.size(), "line")));
          link.edges = {static_cast<std::int32_t>(panel.edges.size()) + line};
        }
        chain.push_back(link);
        return {link.panel, link.edges.front()};
      }
      ++link.panel;
    }
    refuse(place, fmt::format("names panel {}, which the pattern does not have", quoted(name)));
  }

  const Json& j_;
  const PatternLimits& limits_;
  SewingPattern pattern_;
  DrawnPattern drawn_;     // the same with what only a drawing has
  bool is_drawn_ = false;  // the file has any of it
  double units_ = 100.0;
  bool relative_ = true;
  bool newer_ = false;  // the file has a mark of the format that fixes the direction of stitches
  Vec2 from_ = Vec2::Zero(), along_ = Vec2::Zero();
};

/// Refuses names that appear twice in one object, of which the parser would keep the last.
Json parse_unique(const std::string& text, const std::string& name) {
  std::vector<std::set<std::string>> keys;
  const auto check = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (depth > kDeepest)
      throw std::invalid_argument(name + ": is nested too deeply for a sewing pattern");
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second)
      throw std::invalid_argument(
          fmt::format("{}: has {} twice in one object; rename or remove one", name,
                      quoted(parsed.get<std::string>())));
    return true;
  };
  try {
    return Json::parse(text, check);
  } catch (const Json::exception& error) {
    throw std::invalid_argument(
        fmt::format("{}: is not JSON: {}", name, json_message(error.what())));
  }
}

}  // namespace

SewingPattern parse_sewing_pattern(const std::string& json, const std::string& name,
                                   const PatternLimits& limits) {
  const Json j = parse_unique(json, name);
  SewingPattern pattern = PatternReader(j, name, limits).read();
  check_sewing_pattern(pattern, limits);
  return pattern;
}

SewingPattern read_sewing_pattern(const std::filesystem::path& file, const PatternLimits& limits) {
  const std::string text = read_whole_file(file, {.what = "sewing pattern", .pipes = true});
  return parse_sewing_pattern(text, file.string(), limits);
}

}  // namespace selvedge
