// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/animation_source.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace selvedge::detail {
namespace {

/// Splits a USD text into words, strings (with their quotes) and single marks.
class UsdTokens {
 public:
  explicit UsdTokens(const MeshSource& source) : source_(&source), text_(source.bytes) {}

  /// The next token; "" at the end of the text.
  std::string_view next() {
    skip_blank();
    if (at_ >= text_.size()) return {};
    const std::size_t begin = at_;
    const char c = text_[at_];
    if (c == '"' || c == '\'') return quoted(c, begin);
    if (is_mark(c)) return text_.substr(at_++, 1);
    while (at_ < text_.size() && !is_mark(text_[at_]) && !is_blank(text_[at_]) &&
           text_[at_] != '"' && text_[at_] != '#')
      ++at_;
    return text_.substr(begin, at_ - begin);
  }

  std::string_view peek() {
    const auto [at, line] = std::pair(at_, line_);
    const std::string_view token = next();
    at_ = at;
    line_ = line;
    return token;
  }

  [[noreturn]] void refuse_here(const std::string& fault) const {
    refuse_line(*source_, line_, fault);
  }

  double number(std::string_view token) const {
    double value = 0.0;
    if (!parse_double(token, value) || !std::isfinite(value))
      refuse_here(in_quotes(token) + " is not a number");
    return value;
  }

 private:
  static bool is_mark(char c) {
    return std::string_view("()[]{}=:,;<>").find(c) != std::string_view::npos;
  }
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  void skip_blank() {
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '#') at_ = std::min(text_.find('\n', at_), text_.size());
      if (at_ >= text_.size() || !is_blank(text_[at_])) return;
      if (text_[at_] == '\n') ++line_;
    }
  }

  std::string_view quoted(char quote, std::size_t begin) {
    const std::string three(3, quote);
    const bool is_long = text_.substr(at_, 3) == three;
    std::size_t end = at_ + (is_long ? 3 : 1);
    for (; end < text_.size(); ++end) {
      if (text_[end] == '\\')
        ++end;
      else if (is_long ? text_.substr(end, 3) == three : text_[end] == quote)
        break;
    }
    if (end >= text_.size()) refuse_here("a string has no end");
    at_ = end + (is_long ? 3 : 1);
    const std::string_view token = text_.substr(begin, at_ - begin);
    line_ += static_cast<std::size_t>(std::count(token.begin(), token.end(), '\n'));
    return token;
  }

  const MeshSource* source_;
  std::string_view text_;
  std::size_t at_ = 0, line_ = 1;
};

using Samples = std::map<double, std::vector<double>>;

/// One Mesh prim as the stage has it.
struct UsdPrim {
  std::string name;
  std::vector<double> counts{}, indices{};
  Samples points{};  ///< by time code; a single one at 0 without time samples
  bool left_handed = false;
};

/// Reads the parts of a stage that describe meshes. Everything else is skipped.
class UsdStage {
 public:
  explicit UsdStage(const MeshSource& source) : tokens_(source) {
    if (!source.bytes.starts_with("#usda"))
      refuse(source, "is no ASCII stage of USD; save it as .usda (usdcat IN.usdc -o OUT.usda)");
    if (tokens_.peek() == "(") read_metadata();
    read_prims();
  }

  const std::vector<UsdPrim>& prims() const { return prims_; }
  std::string up = "Y";  ///< as USD has it where a stage does not say
  double metres_per_unit = 0.01, codes_per_second = 24.0;

 private:
  void read_metadata() {
    tokens_.next();
    for (int depth = 1; depth > 0;) {
      const std::string_view token = token_or_end("the metadata");
      if (token == "(" || token == "{" || token == "[")
        ++depth;
      else if (token == ")" || token == "}" || token == "]")
        --depth;
      else if (depth == 1 && tokens_.peek() == "=")
        read_stage_value(token);
    }
  }

  void read_stage_value(std::string_view key) {
    const std::string name(key);
    if (name != "upAxis" && name != "metersPerUnit" && name != "timeCodesPerSecond") return;
    tokens_.next();
    const std::string_view value = tokens_.next();
    if (name == "upAxis") {
      up = std::string(value.substr(std::min<std::size_t>(1, value.size()), 1));
      if (up != "Y" && up != "Z") tokens_.refuse_here("the up axis is neither \"Y\" nor \"Z\"");
      return;
    }
    double& target = name == "metersPerUnit" ? metres_per_unit : codes_per_second;
    target = tokens_.number(value);
    if (!(target > 0.0)) tokens_.refuse_here(name + " must be positive");
  }

  /// Walks through all prims. `open` has, for each open brace, the mesh that it belongs to or -1.
  void read_prims() {
    std::vector<int> open;
    int next_mesh = -1;
    for (std::string_view token = tokens_.next(); !token.empty(); token = tokens_.next()) {
      const int mesh = open.empty() ? -1 : open.back();
      if (token == "def" || token == "over" || token == "class") {
        next_mesh = read_prim_head();
      } else if (token == "{") {
        open.push_back(std::exchange(next_mesh, -1));
      } else if (token == "}") {
        if (open.empty()) tokens_.refuse_here("a } without its {");
        open.pop_back();
      } else if (token == "(") {
        skip_to(")");
      } else if (tokens_.peek() == "=") {
        read_attribute(std::string(token), mesh);
      }
    }
    if (!open.empty()) tokens_.refuse_here("ends within a prim; the file is incomplete");
  }

  /// After "def": the type, which may be missing, and the name. Returns the index of a mesh or -1.
  int read_prim_head() {
    std::string type;
    std::string_view token = tokens_.next();
    if (!token.starts_with('"')) {
      type = token;
      token = tokens_.next();
    }
    if (type != "Mesh") return -1;
    prims_.push_back({.name = std::string(token)});
    return static_cast<int>(prims_.size()) - 1;
  }

  void read_attribute(const std::string& name, int mesh) {
    tokens_.next();  // =
    if (name == "xformOpOrder" && !list_is_empty())
      tokens_.refuse_here("a prim has a transformation; apply it to the points before the export");
    if (mesh < 0 ||
        (name != "points" && name != "points.timeSamples" && name != "faceVertexCounts" &&
         name != "faceVertexIndices" && name != "orientation"))
      return;  // its value is skipped as the tokens that follow
    UsdPrim& prim = prims_[static_cast<std::size_t>(mesh)];
    if (name == "orientation") prim.left_handed = tokens_.next() == "\"leftHanded\"";
    if (name == "faceVertexCounts") prim.counts = read_numbers();
    if (name == "faceVertexIndices") prim.indices = read_numbers();
    if (name == "points" && prim.points.empty()) prim.points[0.0] = read_numbers();
    if (name == "points.timeSamples") read_samples(prim);
  }

  bool list_is_empty() {
    if (tokens_.peek() != "[") return false;
    tokens_.next();
    return tokens_.peek() == "]";
  }

  void read_samples(UsdPrim& prim) {
    prim.points.clear();
    expect("{");
    while (tokens_.peek() != "}") {
      const double time = tokens_.number(token_or_end("the time samples"));
      expect(":");
      prim.points[time] = read_numbers();
      if (tokens_.peek() == ",") tokens_.next();
    }
    tokens_.next();
  }

  /// All numbers of a list, whose tuples are flattened.
  std::vector<double> read_numbers() {
    expect("[");
    std::vector<double> numbers;
    for (;;) {
      const std::string_view token = token_or_end("a list");
      if (token == "]") return numbers;
      if (token != "(" && token != ")" && token != ",") numbers.push_back(tokens_.number(token));
    }
  }

  void skip_to(std::string_view close) {
    for (int depth = 1; depth > 0;) {
      const std::string_view token = token_or_end("brackets");
      if (token == "(") ++depth;
      if (token == close) --depth;
    }
  }

  void expect(std::string_view mark) {
    if (tokens_.next() != mark) tokens_.refuse_here("here should be " + std::string(mark));
  }

  std::string_view token_or_end(const std::string& place) {
    const std::string_view token = tokens_.next();
    if (token.empty()) tokens_.refuse_here("ends within " + place + "; the file is incomplete");
    return token;
  }

  UsdTokens tokens_;
  std::vector<UsdPrim> prims_;
};

/// Appends the faces of a prim as fans; `first` is the index of its first vertex.
void append_faces(const MeshSource& source, const UsdPrim& prim, std::size_t vertices,
                  std::size_t first, std::vector<Triangle>& triangles) {
  std::size_t at = 0;
  for (const double count : prim.counts) {
    const auto corners = static_cast<std::size_t>(std::max(count, 0.0));
    if (corners < 3 || corners > prim.indices.size() - at)
      refuse(source, "the faces of " + prim.name + " do not fit its list of indices");
    std::vector<std::int32_t> polygon;
    for (std::size_t k = 0; k < corners; ++k) {
      const double index = prim.indices[at++];
      if (!(index >= 0.0 && index < static_cast<double>(vertices)) || index != std::floor(index))
        refuse(source, "a face of " + prim.name + " names a vertex that it does not have");
      polygon.push_back(static_cast<std::int32_t>(static_cast<double>(first) + index));
    }
    if (prim.left_handed) std::reverse(polygon.begin(), polygon.end());
    append_fan(polygon, triangles);
  }
}

/// The points of a prim at a time code: linear between its samples, held outside.
std::vector<double> points_at(const UsdPrim& prim, double time) {
  const auto after = prim.points.lower_bound(time);
  if (after == prim.points.end()) return prim.points.rbegin()->second;
  if (after->first == time || after == prim.points.begin()) return after->second;
  const auto before = std::prev(after);
  const double t = (time - before->first) / (after->first - before->first);
  std::vector<double> points = before->second;
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = (1.0 - t) * points[i] + t * after->second[i];
  return points;
}

std::size_t vertex_count(const MeshSource& source, const UsdPrim& prim) {
  if (prim.points.empty()) refuse(source, prim.name + " has no points");
  const std::size_t numbers = prim.points.begin()->second.size();
  for (const auto& [time, points] : prim.points)
    if (points.size() != numbers || numbers % 3 != 0)
      refuse(source, prim.name + " has another number of points at time " + std::to_string(time));
  return numbers / 3;
}

}  // namespace

MeshAnimation read_usda(const MeshSource& source, StatedAxes& stated) {
  const UsdStage stage(source);
  stated = {stage.metres_per_unit, stage.up == "Y" ? 2.0 : 3.0};
  if (stage.prims().empty()) refuse(source, "has no prim of type Mesh");
  MeshAnimation animation;
  std::set<double> times;
  std::size_t first = 0;
  for (const UsdPrim& prim : stage.prims()) {
    const std::size_t vertices = vertex_count(source, prim);
    append_faces(source, prim, vertices, first, animation.triangles);
    first += vertices;
    if (prim.points.size() > 1)
      for (const auto& [time, points] : prim.points) times.insert(time);
  }
  if (times.empty()) times.insert(0.0);
  if (times.size() > 1) {
    const double step = (*times.rbegin() - *times.begin()) / static_cast<double>(times.size() - 1);
    double wanted = *times.begin();
    for (const double time : times) {
      constexpr double share = 1e-3;
      if (std::abs(time - wanted) > share * step)
        refuse(source, "the time samples are not evenly spaced at time code " +
                           std::to_string(time) + "; bake the animation to every frame");
      wanted += step;
    }
    animation.fps = stage.codes_per_second / step;
  }
  for (const double time : times) {
    std::vector<Vec3>& x = animation.frames.emplace_back();
    for (const UsdPrim& prim : stage.prims()) {
      const std::vector<double> points = points_at(prim, time);
      for (std::size_t i = 0; i < points.size(); i += 3)
        x.emplace_back(points[i], points[i + 1], points[i + 2]);
    }
  }
  return animation;
}

}  // namespace selvedge::detail
