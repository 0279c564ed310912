// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/read_bodies.h>
#include <selvedge/scene/detail/read_values.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

LoadConfig read_load(const Json& j) {
  LoadConfig load;
  load.unit = j["unit"].get<double>();
  load.up = j["up"] == "x" ? UpAxis::x : j["up"] == "y" ? UpAxis::y : UpAxis::z;
  // Frames of a sequence are never welded: each could be welded differently.
  load.weld = j.value("weld", false);
  return load;
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
  shape.load = read_load(j);
  shape.fps = sequence["fps"].get<double>();
  shape.start = sequence["start"].get<double>();
  Json& files = sequence["files"];
  const std::string place = join(path, "files");
  if (files.is_string())
    files = expand(document, files.get<std::string>(), sequence["first"], place);
  for (std::size_t i = 0; i < files.size(); ++i)
    shape.files.push_back(read_file(document, files[i], join(place, i)));
  return shape;
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
      body.shape = BodyFile{read_file(document, j["mesh"], join(path, "mesh")), read_load(j), {}};
    if (j.contains("mesh") && j["mesh"].is_object())
      body.shape = BodyFile{{}, read_load(j), read_inline_mesh(j["mesh"])};
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
