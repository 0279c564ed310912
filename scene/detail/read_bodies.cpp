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

/// Where the scene gives no unit or up axis and the format of the file does not state them, the
/// scene gets the ones that then count.
void complete_axes(const LoadConfig& load, bool stated, Json& j) {
  if (!stated && !load.unit) j["unit"] = 1.0;
  if (!stated && !load.up) j["up"] = "z";
}

void read_weld(const Json& j, BodyFile& shape) {
  const Json& weld = j["weld"];
  shape.load.weld = weld.is_number() || weld.get<bool>();
  if (weld.is_number()) shape.weld_distance = weld.get<double>();
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

/// The file of a sequence with the lowest number from `least` on.
struct NumberedFile {
  std::int64_t number = 0;
  std::string file;  ///< empty: there is none
};
NumberedFile lowest_file(const LocatedJson& document, const NumberedName& name,
                         std::int64_t least) {
  NumberedFile lowest;
  if (name.pattern.find('/', name.end) != std::string::npos) return lowest;  // numbered folders
  const auto folder = absolute_path(document, name.pattern).parent_path();
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), last; !error && it != last;
       it.increment(error)) {
    const std::string file = it->path().filename().string();
    const auto number = number_in(file, name);
    if (!number || *number < least || (!lowest.file.empty() && *number > lowest.number)) continue;
    lowest = {*number, file};
  }
  return lowest;
}

/// "walk_####.obj" into the files that exist from the lowest number on. Refuses a sequence with a
/// gap.
Json expand(const LocatedJson& document, const std::string& pattern, const std::string& path) {
  const auto begin = pattern.find('#');
  if (begin == std::string::npos)
    fail(document, path, "needs a list of files, or a name with # for each digit of a number");
  const auto end = std::min(pattern.find_first_not_of('#', begin), pattern.size());
  Json files = Json::array();
  const NumberedName numbered{pattern, begin, end};
  const auto name = [&](std::int64_t number) {
    return fmt::format("{}{:0{}}{}", pattern.substr(0, begin), number, end - begin,
                       pattern.substr(end));
  };
  std::int64_t next = lowest_file(document, numbered, 0).number;
  std::error_code error;
  while (std::filesystem::exists(absolute_path(document, name(next)), error))
    files.push_back(name(next++));
  if (const NumberedFile later = lowest_file(document, numbered, next); !later.file.empty())
    fail(document, path,
         fmt::format("number {} is missing although {} exists; add the file, or list the files of "
                     "the sequence",
                     next, later.file));
  constexpr std::size_t fewest = 2;
  if (files.size() < fewest)
    fail(document, path,
         fmt::format("a sequence needs at least 2 files; there is no file {}",
                     absolute_path(document, name(next)).string()));
  return files;
}

/// An obstacle with the keys of one shape.
class BodyReader {
 public:
  BodyReader(const LocatedJson& document, const FieldReader& fields, Json& j,
             const std::string& path)
      : document_(document), fields_(fields), j_(j), path_(path) {}

  /// Adds it to the bodies of the scene or, if it has a mass, to the pieces.
  void read_into(Scene& scene, const std::string& name) const {
    if (j_.contains("shape"))
      read<BodyShape>(scene, name);
    else if (j_.contains("mesh"))
      read<BodyFile>(scene, name);
    else
      read<BodySequence>(scene, name);
  }

 private:
  template <class Shape>
  void read(Scene& scene, const std::string& name) const {
    BodyOf<Shape> body;
    fields_.read(j_, path_, body);
    complete(body.shape);
    if constexpr (!std::is_same_v<Shape, BodySequence>)
      if (body.solid.mass > 0.0) return add_solid(body, name, scene);
    for (const char* key : {"slide", "hinge", "limits", "damping", "force"})
      if (j_.contains(key)) fail(document_, join(path_, key), "needs a \"mass\" above 0 beside it");
    body.body.shape = std::move(body.shape);
    if constexpr (!std::is_same_v<Shape, BodySequence>)
      body.body.motion = read_motion(document_, j_["motion"], join(path_, "motion"));
    body.body.name = name;
    scene.bodies.push_back(std::move(body.body));
  }

  template <class Shape>
  void add_solid(BodyOf<Shape>& body, const std::string& name, Scene& scene) const {
    if (!read_motion(document_, j_["motion"], join(path_, "motion")).empty())
      fail(document_, join(path_, "motion"), "a body with \"mass\" moves by forces; leave one out");
    for (const ClothSpec& piece : scene.cloths)
      if (piece.name == name)
        fail(document_, path_, "a body with \"mass\" needs a name that no piece has");
    body.solid.friction = body.body.friction;
    ClothSpec& piece = scene.cloths.emplace_back();
    ClothFile file;
    if constexpr (std::is_same_v<Shape, BodyShape>) {
      file.mesh = tessellate(body.shape.shape, body.shape.resolution);
    } else {
      if (!body.shape.load.groups.empty() || body.shape.load.up.value_or(UpAxis::z) != UpAxis::z)
        fail(document_, path_,
             "a body with \"mass\" has no \"up\" or \"groups\"; write such a mesh");
      file.file = body.shape.file;
      file.mesh = body.shape.mesh;
      piece.scale = body.shape.load.unit.value_or(1.0);
    }
    file.solid = body.solid;
    piece.name = name;
    piece.shape = std::move(file);
    piece.placement = body.body.placement;
    piece.material = scene.cloths.front().material;
  }

  void complete(BodyShape& shape) const {
    shape.resolution = j_["shape"].value("resolution", shape.resolution);
    const auto* torus = std::get_if<Torus>(&shape.shape);
    if (torus != nullptr && torus->tube >= torus->radius)
      fail(document_, join(path_, "shape.tube"),
           "must be less than radius, or the ring has no hole");
  }

  void complete(BodyFile& shape) const {
    const std::string place = join(path_, "mesh");
    if (j_["mesh"].is_string())
      shape.file = read_file(document_, j_["mesh"], place);
    else
      fields_.read(j_["mesh"], place, shape.mesh);
    complete_axes(shape.load, j_["mesh"].is_string() && states_axes(shape.file), j_);
    read_weld(j_, shape);
  }

  void complete(BodySequence& shape) const {
    const std::string path = join(path_, "sequence"), place = join(path, "files");
    SequenceKeys keys;
    fields_.read(j_["sequence"], path, keys);
    shape.fps = keys.fps;
    Json& files = j_["sequence"]["files"];
    if (files.is_string()) files = expand(document_, files.get<std::string>(), place);
    for (std::size_t i = 0; i < files.size(); ++i)
      shape.files.push_back(read_file(document_, files[i], join(place, i)));
    complete_axes(shape.load, states_axes(shape.files.front()), j_);
    // Frames of a sequence are never welded: each could be welded differently.
    shape.load.weld = false;
  }

  const LocatedJson& document_;
  const FieldReader& fields_;
  Json& j_;
  const std::string& path_;
};

}  // namespace

void read_bodies(LocatedJson& document, const FieldReader& fields, Scene& scene) {
  std::set<std::string> taken;
  Json& list = document.root["obstacles"];
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string path = join("obstacles", i);
    const std::string name = read_name(document, list[i], "obstacles", i, taken);
    BodyReader(document, fields, list[i], path).read_into(scene, name);
  }
}

}  // namespace selvedge::detail
