// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/scene/detail/check_scene.h>
#include <selvedge/scene/detail/read_values.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace selvedge::detail {
namespace {

Eigen::Quaterniond read_axis_angle(const LocatedJson& document, const Json& j,
                                   const std::string& path) {
  const Vec3 axis = read_vec3(j["axis"]);
  if (axis.norm() == 0.0) fail(document, join(path, "axis"), "must not be the zero vector");
  const double angle = j["angle_deg"].get<double>() * std::numbers::pi / 180.0;
  const auto [sine, cosine] = elementary::sin_cos(0.5 * angle);
  const Vec3 v = sine * axis.normalized();
  return {cosine, v.x(), v.y(), v.z()};
}

std::vector<Keyframe> read_keyframes(const LocatedJson& document, const Json& j,
                                     const std::string& path) {
  std::vector<Keyframe> keys;
  for (std::size_t i = 0; i < j.size(); ++i) {
    const std::string place = join(path, i);
    keys.push_back({j[i]["time"].get<double>(), read_vec3(j[i]["translation"]),
                    read_rotation(document, j[i]["rotation"], join(place, "rotation"))});
    if (i > 0 && keys[i].time <= keys[i - 1].time)
      fail(document, join(place, "time"),
           fmt::format("must be later than the one before ({} s), is {}", keys[i - 1].time,
                       keys[i].time));
  }
  return keys;
}

/// The angle between two stated rotations, degrees. Angles about one axis count in full; between
/// rotations about several axes it is at most 360.
double stated_turn(const LocatedJson& document, const Json& from, const Json& to) {
  constexpr double rounding = 1e-12;
  Vec3 axis = Vec3::Zero();
  double turn = 0.0;
  bool one_axis = true;
  const auto add = [&](const Json& rotation, double sign) {
    const Vec3 direction = read_vec3(rotation["axis"]).normalized();
    const auto angle = rotation["angle_deg"].get<double>();
    if (angle == 0.0) return;
    if (axis.isZero(0.0)) axis = direction;
    const double along = direction.dot(axis);
    one_axis = one_axis && std::abs(along) > 1.0 - rounding;
    turn += sign * std::copysign(1.0, along) * angle;
  };
  const auto add_all = [&](const Json& rotations, double sign) {
    if (rotations.is_object()) return add(rotations, sign);
    for (const Json& rotation : rotations) add(rotation, sign);
  };
  add_all(from, -1.0);
  add_all(to, 1.0);
  if (one_axis) return std::abs(turn);
  const double cosine = read_rotation(document, from, "").dot(read_rotation(document, to, ""));
  return 360.0 / std::numbers::pi * elementary::acos(std::clamp(cosine, -1.0, 1.0));
}

void add_turn_warnings(const LocatedJson& document, const Json& keys, const std::string& path,
                       std::vector<std::string>& warnings) {
  constexpr double half = 180.0, rounding = 1e-9;  // degrees
  for (std::size_t i = 1; keys.is_array() && i < keys.size(); ++i) {
    const double turn = stated_turn(document, keys[i - 1]["rotation"], keys[i]["rotation"]);
    if (turn > half + rounding)
      warnings.push_back(fmt::format(
          "{}: turns by {:g} degrees from the keyframe before, but a rotation between two "
          "keyframes takes the shorter direction, here by {:g} degrees; add keyframes in between, "
          "less than 180 degrees apart",
          join(join(path, i), "rotation"), turn, std::abs(std::remainder(turn, 2.0 * half))));
  }
}

}  // namespace

Eigen::Quaterniond read_rotation(const LocatedJson& document, const Json& j,
                                 const std::string& path) {
  if (j.is_object()) return read_axis_angle(document, j, path);
  Eigen::Quaterniond all = Eigen::Quaterniond::Identity();
  for (std::size_t i = 0; i < j.size(); ++i)
    all = read_axis_angle(document, j[i], join(path, i)) * all;
  return all.normalized();
}

Vec3 read_vec3(const Json& j) {
  return {j[0].get<double>(), j[1].get<double>(), j[2].get<double>()};
}

std::string in_quotes(const std::string& word) { return "\"" + word + "\""; }

std::string read_name(const LocatedJson& document, Json& element, const std::string& stem,
                      std::size_t index, std::set<std::string>& taken) {
  const std::string path = join(stem, index);
  if (!element.contains("name")) element["name"] = fmt::format("{}_{}", stem, index);
  auto name = element["name"].get<std::string>();
  if (!taken.insert(name).second)
    fail(document, join(path, "name"),
         in_quotes(name) + " is taken; give each element its own name");
  return name;
}

void require_known(const LocatedJson& document, const std::string& word,
                   const std::vector<std::string>& known, const std::string& path,
                   const std::string& kind) {
  if (std::find(known.begin(), known.end(), word) != known.end()) return;
  const std::string hint =
      known.empty() ? "none is defined" : "nearest is " + in_quotes(nearest_word(word, known));
  fail(document, path, fmt::format("there is no {} {}; {}", kind, in_quotes(word), hint));
}

std::filesystem::path absolute_path(const LocatedJson& document, const std::string& name) {
  const auto folder = std::filesystem::absolute(document.file).parent_path();
  return (folder / name).lexically_normal();
}

std::filesystem::path read_file(const LocatedJson& document, Json& j, const std::string& path) {
  const auto file = absolute_path(document, j.get<std::string>());
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    const bool fetched = file.parent_path().filename() == "fetched";
    fail(document, path,
         fmt::format("there is no file {}; {}", file.string(),
                     fetched ? "fetch it with scripts/fetch_bodies.sh"
                             : "paths are relative to the scene file"));
  }
  if (std::filesystem::is_directory(file, error))
    fail(document, path, file.string() + " is a folder; name a mesh file in it");
  j = file.string();
  return file;
}

void check_motions(const LocatedJson& document) {
  for (const auto& [name, keys] : document.root["motions"].items())
    read_keyframes(document, keys, join("motions", name));
}

std::vector<std::string> turn_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  const auto turns = [](const auto& moved) { return moved.motion.size() > 1; };
  if (scene.json.empty() || (std::none_of(scene.handles.begin(), scene.handles.end(), turns) &&
                             std::none_of(scene.bodies.begin(), scene.bodies.end(), turns)))
    return warnings;
  const LocatedJson document{scene.file, Json::parse(scene.json), {}};
  for (const auto& [name, keys] : document.root["motions"].items())
    add_turn_warnings(document, keys, join("motions", name), warnings);
  for (const char* list : {"handles", "obstacles"})
    for (std::size_t i = 0; i < document.root[list].size(); ++i)
      if (const Json& element = document.root[list][i]; element.contains("motion"))
        add_turn_warnings(document, element["motion"], join(join(list, i), "motion"), warnings);
  return warnings;
}

std::vector<Keyframe> read_motion(const LocatedJson& document, const Json& j,
                                  const std::string& path) {
  if (!j.is_string()) return read_keyframes(document, j, path);
  const Json& motions = document.root["motions"];
  std::vector<std::string> known;
  for (const auto& [name, keys] : motions.items()) known.push_back(name);
  const auto name = j.get<std::string>();
  require_known(document, name, known, path, "motion");
  return read_keyframes(document, motions[name], join("motions", name));
}

}  // namespace selvedge::detail
