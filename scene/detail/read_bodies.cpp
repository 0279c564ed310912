// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/read_bodies.h>
#include <selvedge/scene/detail/read_values.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <system_error>

namespace selvedge::detail {
namespace {

/// Unit and up axis that the scene gives. Where it gives none, `stated` (the format of the file
/// states them) leaves them to the file; else the scene gets the ones that then count.
LoadConfig read_load(Json& j, bool stated) {
  LoadConfig load;
  if (j.contains("unit")) load.unit = j["unit"].get<double>();
  if (j.contains("up"))
    load.up = j["up"] == "x" ? UpAxis::x : j["up"] == "y" ? UpAxis::y : UpAxis::z;
  if (!stated && !load.unit) j["unit"] = 1.0;
  if (!stated && !load.up) j["up"] = "z";
  // Frames of a sequence are never welded: each could be welded differently.
  load.weld = j.contains("weld") && (j["weld"].is_number() || j["weld"].get<bool>());
  load.groups = j["groups"].get<std::vector<std::string>>();
  load.without = j["without_groups"].get<std::vector<std::string>>();
  return load;
}

double read_weld_distance(const Json& j) {
  return j.contains("weld") && j["weld"].is_number() ? j["weld"].get<double>() : 0.0;
}

BodyShape read_shape(const LocatedJson& document, const Json& j, const std::string& path) {
  const auto type = j["type"].get<std::string>();
  const auto number = [&](const char* key) { return j[key].get<double>(); };
  BodyShape shape;
  shape.resolution = j.value("resolution", shape.resolution);
  if (type == "plane") shape.shape = Plane{number("size")};
  if (type == "box") shape.shape = Box{read_vec3(j["size"])};
  if (type == "sphere") shape.shape = Sphere{number("radius")};
  if (type == "capsule") shape.shape = Capsule{number("radius"), number("length")};
  if (type == "cylinder") shape.shape = Cylinder{number("radius"), number("height")};
  if (type == "cone") shape.shape = Cone{number("radius"), number("height")};
  if (type == "torus") {
    if (number("tube") >= number("radius"))
      fail(document, join(path, "tube"), "must be less than radius, or the ring has no hole");
    shape.shape = Torus{number("radius"), number("tube")};
  }
  return shape;
}

/// A name with # for each digit of a number.
struct NumberedName {
  const std::string& pattern;
  std::size_t begin, end;  ///< of the #
};

/// The number in the name of a file that `name` describes; nullopt for other files.
std::optional<std::int64_t> number_in(const std::string& file, const NumberedName& name) {
  const std::size_t slash = name.pattern.rfind('/', name.begin);
  const std::size_t first = slash == std::string::npos ? 0 : slash + 1;
  const std::string before = name.pattern.substr(first, name.begin - first);
  const std::string after = name.pattern.substr(name.end);
  if (file.size() < before.size() + after.size() + (name.end - name.begin)) return std::nullopt;
  if (!file.starts_with(before) || !file.ends_with(after)) return std::nullopt;
  const char *at = file.data() + before.size(), *stop = file.data() + file.size() - after.size();
  std::int64_t number = 0;
  const auto [ptr, fault] = std::from_chars(at, stop, number);
  if (fault != std::errc() || ptr != stop || *at == '-') return std::nullopt;
  return number;
}

/// Refuses a sequence that ends before `missing` although the folder has files with higher numbers.
void refuse_gap(const LocatedJson& document, const NumberedName& name, std::int64_t missing,
                const std::string& path) {
  if (name.pattern.find('/', name.end) != std::string::npos) return;  // folders are numbered
  const auto folder = absolute_path(document, name.pattern).parent_path();
  std::string next;  // the file with the lowest of these numbers
  std::int64_t lowest = 0;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), last; !error && it != last;
       it.increment(error)) {
    const std::string file = it->path().filename().string();
    const auto number = number_in(file, name);
    if (!number || *number < missing || (!next.empty() && *number > lowest)) continue;
    next = file;
    lowest = *number;
  }
  if (!next.empty())
    fail(document, path,
         fmt::format("number {} is missing although {} exists; add the file, or list the files of "
                     "the sequence",
                     missing, next));
}

/// "walk_####.obj" into the files that exist from number `first` on.
Json expand(const LocatedJson& document, const std::string& pattern, std::int64_t first,
            const std::string& path) {
  const auto begin = pattern.find('#');
  if (begin == std::string::npos)
    fail(document, path, "needs a list of files, or a name with # for each digit of a number");
  const auto end = std::min(pattern.find_first_not_of('#', begin), pattern.size());
  Json files = Json::array();
  const auto name = [&](std::int64_t number) {
    return fmt::format("{}{:0{}}{}", pattern.substr(0, begin), number, end - begin,
                       pattern.substr(end));
  };
  std::error_code error;
  while (std::filesystem::exists(absolute_path(document, name(first)), error))
    files.push_back(name(first++));
  refuse_gap(document, {pattern, begin, end}, first, path);
  constexpr std::size_t fewest = 2;
  if (files.size() < fewest)
    fail(document, path,
         fmt::format("a sequence needs at least 2 files; there is no file {}",
                     absolute_path(document, name(first)).string()));
  return files;
}

BodySequence read_sequence(const LocatedJson& document, Json& j, const std::string& path) {
  Json& sequence = j["sequence"];
  BodySequence shape;
  shape.fps = sequence["fps"].get<double>();
  shape.start = sequence["start"].get<double>();
  Json& files = sequence["files"];
  const std::string place = join(path, "files");
  if (files.is_string())
    files = expand(document, files.get<std::string>(), sequence["first"], place);
  for (std::size_t i = 0; i < files.size(); ++i)
    shape.files.push_back(read_file(document, files[i], join(place, i)));
  shape.load = read_load(j, states_axes(shape.files.front()));
  return shape;
}

BodyFile read_body_file(const LocatedJson& document, Json& j, const std::string& path) {
  const std::filesystem::path file = read_file(document, j["mesh"], path);
  return {file, read_load(j, states_axes(file)), {}, read_weld_distance(j)};
}

}  // namespace

void read_bodies(LocatedJson& document, Scene& scene) {
  std::set<std::string> taken;
  Json& list = document.root["obstacles"];
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string path = join("obstacles", i);
    Json& j = list[i];
    BodySpec body;
    body.name = read_name(document, j, "obstacles", i, taken);
    if (j.contains("shape")) body.shape = read_shape(document, j["shape"], join(path, "shape"));
    if (j.contains("mesh") && j["mesh"].is_string())
      body.shape = read_body_file(document, j, join(path, "mesh"));
    if (j.contains("mesh") && j["mesh"].is_object())
      body.shape =
          BodyFile{{}, read_load(j, false), read_inline_mesh(j["mesh"]), read_weld_distance(j)};
    if (j.contains("sequence"))
      body.shape = read_sequence(document, j, join(path, "sequence"));
    else
      body.motion = read_motion(document, j["motion"], join(path, "motion"));
    body.placement = read_placement(document, j["transformation"], join(path, "transformation"));
    body.friction = j["friction"].get<double>();
    scene.bodies.push_back(std::move(body));
  }
}

}  // namespace selvedge::detail
