// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/scene/detail/read_values.h>

#include <Eigen/Geometry>
#include <algorithm>
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
