// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/detail/old_keys.h>
#include <selvedge/scene/detail/read_extras.h>
#include <selvedge/scene/detail/read_geometry.h>
#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/detail/select_vertices.h>
#include <selvedge/scene/scene.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace selvedge {

namespace {

using detail::fail;
using detail::join;
using detail::Json;
using detail::LocatedJson;

Vec3 read_vec3(const Json& j) {
  return {j[0].get<double>(), j[1].get<double>(), j[2].get<double>()};
}

std::string in_quotes(const std::string& word) { return "\"" + word + "\""; }

/// Reads a document that the schema has checked and completed: every key with a default is present,
/// with the right type and range. The reader checks references and files.
class SceneReader {
 public:
  SceneReader(LocatedJson& document, const Methods& methods)
      : document_(document), methods_(methods), root_(document.root) {}

  Scene read() {
    scene_.file = document_.file;
    if (!root_.contains("name")) root_["name"] = document_.file.stem().string();
    scene_.name = root_["name"].get<std::string>();
    scene_.gravity = read_vec3(root_["gravity"]);
    read_materials();
    read_geometry();
    read_motions();
    read_handles();
    read_weights();
    detail::read_seams(document_, methods_.patterns, scene_);
    detail::read_water(document_, methods_.patterns, scene_);
    read_obstacles();
    read_air();
    read_time();
    read_contact();
    read_solver();
    scene_.plan.proofs = root_["plan"]["proofs"].get<bool>();
    read_output();
    read_closed_form();
    scene_.json = root_.dump(2);
    return std::move(scene_);
  }

 private:
  // -- names ------------------------------------------------------------------------------------

  /// The name of an element, unique in its list; made from the index if the element has none.
  std::string read_name(Json& element, const std::string& stem, std::size_t index,
                        std::set<std::string>& taken) {
    const std::string path = join(stem, index);
    if (!element.contains("name")) element["name"] = fmt::format("{}_{}", stem, index);
    auto name = element["name"].get<std::string>();
    if (!taken.insert(name).second)
      fail(document_, join(path, "name"),
           in_quotes(name) + " is taken; give each element its own name");
    return name;
  }

  template <class Known>
  void require_known(const std::string& word, const Known& known, const std::string& path,
                     const std::string& kind) const {
    if (std::find(known.begin(), known.end(), word) != known.end()) return;
    const std::vector<std::string> words(known.begin(), known.end());
    const std::string hint =
        words.empty() ? "none is defined" : "nearest is " + in_quotes(nearest_word(word, words));
    fail(document_, path, fmt::format("there is no {} {}; {}", kind, in_quotes(word), hint));
  }

  /// The value of a word that the schema allows.
  template <class Enum>
  static Enum word_of(const Json& j, const std::map<std::string, Enum>& words) {
    return words.at(j.get<std::string>());
  }

  /// A method by its name, or an object with its name ("type") and its options. Returns the name.
  template <class Registry>
  std::string read_method(const Json& j, const Registry& registry, const std::string& path,
                          MethodOptions& options) const {
    const bool named = j.is_string();
    const auto name = (named ? j : j["type"]).template get<std::string>();
    if (const std::string fault = registry.fault(name); !fault.empty())
      fail(document_, named ? path : join(path, "type"), fault);
    if (named) return name;
    for (const auto& [key, value] : j.items())
      if (key != "type") read_option(value, registry.at(name), join(path, key), key, options);
    return name;
  }

  /// One option of the method `entry`.
  template <class Entry>
  void read_option(const Json& j, const Entry& entry, const std::string& path,
                   const std::string& key, MethodOptions& options) const {
    const double value = detail::option_value(j);
    if (const std::string fault = option_fault(entry.options(), key, value); !fault.empty())
      fail(document_, path, entry.name() + " " + fault);
    const auto option = std::find_if(entry.options().begin(), entry.options().end(),
                                     [&](const MethodOption& o) { return o.name == key; });
    if (j.is_boolean() != (option->kind == OptionKind::boolean))
      fail(document_, path, j.is_boolean() ? "must be a number" : "must be true or false");
    options.set(key, value);
  }

  /// Options that stand beside the method's name, as in older scene files.
  template <class Entry>
  void read_flat_options(const Json& section, const std::string& stem, const Entry& entry,
                         std::initializer_list<const char*> keys, MethodOptions& options) const {
    for (const std::string key : keys) {
      if (!section.contains(key)) continue;
      if (options.contains(key))
        fail(document_, join(stem, key), "is given twice; keep the one beside \"type\"");
      read_option(section[key], entry, join(stem, key), key, options);
    }
  }

  // -- files ------------------------------------------------------------------------------------

  /// Absolute path of a file that exists; also stored in the document.
  std::filesystem::path read_file(Json& j, const std::string& path) {
    const auto file = absolute(j.get<std::string>());
    std::error_code error;
    if (!std::filesystem::exists(file, error)) {
      const bool fetched = file.parent_path().filename() == "fetched";
      fail(document_, path,
           fmt::format("there is no file {}; {}", file.string(),
                       fetched ? "fetch it with scripts/fetch_bodies.sh"
                               : "paths are relative to the scene file"));
    }
    if (std::filesystem::is_directory(file, error))
      fail(document_, path, file.string() + " is a folder; name a mesh file in it");
    j = file.string();
    return file;
  }

  std::filesystem::path absolute(const std::string& name) const {
    const auto folder = std::filesystem::absolute(document_.file).parent_path();
    return (folder / name).lexically_normal();
  }

  // -- placement and motion -----------------------------------------------------------------------

  Eigen::Quaterniond read_axis_angle(const Json& j, const std::string& path) const {
    const Vec3 axis = read_vec3(j["axis"]);
    if (axis.norm() == 0.0) fail(document_, join(path, "axis"), "must not be the zero vector");
    const double angle = j["angle_deg"].get<double>() * std::numbers::pi / 180.0;
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
  }

  Eigen::Quaterniond read_rotation(const Json& j, const std::string& path) const {
    if (j.is_object()) return read_axis_angle(j, path);
    Eigen::Quaterniond all = Eigen::Quaterniond::Identity();
    for (std::size_t i = 0; i < j.size(); ++i) all = read_axis_angle(j[i], join(path, i)) * all;
    return all.normalized();
  }

  Placement read_placement(const Json& j, const std::string& path) const {
    return {read_vec3(j["translation"]), read_rotation(j["rotation"], join(path, "rotation")),
            j["scale"].get<double>()};
  }

  std::vector<Keyframe> read_keyframes(const Json& j, const std::string& path) const {
    std::vector<Keyframe> keys;
    for (std::size_t i = 0; i < j.size(); ++i) {
      const std::string place = join(path, i);
      keys.push_back({j[i]["time"].get<double>(), read_vec3(j[i]["translation"]),
                      read_rotation(j[i]["rotation"], join(place, "rotation"))});
      if (i > 0 && keys[i].time <= keys[i - 1].time)
        fail(document_, join(place, "time"),
             fmt::format("must be later than the one before ({} s), is {}", keys[i - 1].time,
                         keys[i].time));
    }
    return keys;
  }

  void read_motions() {
    for (const auto& [name, keys] : root_["motions"].items())
      motions_[name] = read_keyframes(keys, join("motions", name));
  }

  std::vector<Keyframe> read_motion(const Json& j, const std::string& path) const {
    if (!j.is_string()) return read_keyframes(j, path);
    std::vector<std::string> known;
    for (const auto& [name, keys] : motions_) known.push_back(name);
    require_known(j.get<std::string>(), known, path, "motion");
    return motions_.at(j.get<std::string>());
  }

  // -- cloth --------------------------------------------------------------------------------------

  void read_materials() {
    scene_.materials["default"] = Material{};
    for (const auto& [name, j] : root_["materials"].items()) {
      Material& m = scene_.materials[name];
      m.density = j["density"].get<double>();
      m.stretch_stiffness = j["stretch_stiffness"].get<double>();
      m.shear_stiffness = j["shear_stiffness"].get<double>();
      m.bending_stiffness = j["bending_stiffness"].get<double>();
      if (j.contains("stretch_weft")) m.stretch_weft = j["stretch_weft"].get<double>();
      if (j.contains("bending_weft")) m.bending_weft = j["bending_weft"].get<double>();
      m.spring_damping = j["spring_damping"].get<double>();
      m.bending_damping = j["bending_damping"].get<double>();
      m.strain_limit = j["strain_limit"].get<double>();
      m.friction = j["friction"].get<double>();
      read_laws(j, m);
    }
  }

  static void read_laws(const Json& j, Material& m) {
    m.stretch_law =
        word_of<StretchLaw>(j["stretch_law"], {{"hooke", StretchLaw::hooke},
                                               {"tension_only", StretchLaw::tension_only},
                                               {"biphasic", StretchLaw::biphasic},
                                               {"kawabata", StretchLaw::kawabata}});
    m.shear_law = word_of<ShearLaw>(
        j["shear_law"], {{"springs", ShearLaw::springs}, {"twisting", ShearLaw::twisting}});
    m.bending_law =
        word_of<BendingLaw>(j["bending_law"], {{"hinge", BendingLaw::hinge},
                                               {"bridson", BendingLaw::bridson},
                                               {"buckling", BendingLaw::buckling},
                                               {"twisting", BendingLaw::twisting},
                                               {"shape_operator", BendingLaw::shape_operator}});
    m.biphasic_strain = j["biphasic_strain"].get<double>();
    m.biphasic_growth = j["biphasic_growth"].get<double>();
    m.kawabata_lt = j["kawabata_lt"].get<double>();
    m.kawabata_strain = j["kawabata_strain"].get<double>();
    m.kawabata_rt = j["kawabata_rt"].get<double>();
    m.shear_friction = j["shear_friction"].get<double>();
    m.bending_friction = j["bending_friction"].get<double>();
  }

  void read_geometry() {
    std::set<std::string> taken;
    Json& list = root_["geometry"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = join("geometry", i);
      Json& j = list[i];
      ClothSpec cloth;
      cloth.name = read_name(j, "geometry", i, taken);
      if (j.contains("mesh"))
        cloth.shape = read_cloth_file(j, path);
      else
        cloth.shape = read_cloth_grid(j, path);
      cloth.placement = read_placement(j["transformation"], join(path, "transformation"));
      cloth.velocity = read_vec3(j["velocity"]);
      cloth.material = j["material"].get<std::string>();
      cloth.virtual_springs = detail::read_virtual_springs(j);
      std::vector<std::string> known;
      for (const auto& [name, material] : scene_.materials) known.push_back(name);
      require_known(cloth.material, known, join(path, "material"), "material");
      scene_.cloths.push_back(std::move(cloth));
    }
  }

  ClothFile read_cloth_file(Json& j, const std::string& path) {
    ClothFile shape;
    if (j["mesh"].is_string())
      shape.file = read_file(j["mesh"], join(path, "mesh"));
    else
      shape.mesh = read_inline_mesh(j["mesh"]);
    if (j["rest_mesh"] != "") shape.rest_file = read_file(j["rest_mesh"], join(path, "rest_mesh"));
    detail::read_mesh_options(j, shape);
    if (j["rest"] != "texture") return shape;
    if (shape.file.empty() || !shape.rest_file.empty())
      fail(document_, join(path, "rest"),
           "\"texture\" needs an OBJ file as mesh and no rest_mesh beside it");
    shape.texture_unit = j["texture_unit"].get<double>();
    return shape;
  }

  ClothGrid read_cloth_grid(const Json& j, const std::string& path) const {
    ClothGrid shape;
    shape.pattern =
        read_method(j["pattern"], methods_.patterns, join(path, "pattern"), shape.pattern_options);
    shape.grid.size_x = j["size"][0].get<double>();
    shape.grid.size_y = j["size"][1].get<double>();
    shape.grid.cells_x = j["cells"][0].get<std::int32_t>();
    shape.grid.cells_y = j["cells"][1].get<std::int32_t>();
    detail::read_grid_options(j, shape);
    if (!j.contains("path")) return shape;
    for (const Json& point : j["path"]["points"]) shape.path.points.push_back(read_vec3(point));
    shape.path.side = read_vec3(j["path"]["side"]);
    return shape;
  }

  static TriangleMesh read_inline_mesh(const Json& j) {
    TriangleMesh mesh;
    for (const Json& x : j["vertices"]) mesh.vertices.push_back(read_vec3(x));
    for (const Json& t : j["triangles"])
      mesh.triangles.push_back(
          {t[0].get<std::int32_t>(), t[1].get<std::int32_t>(), t[2].get<std::int32_t>()});
    return mesh;
  }

  // -- handles ------------------------------------------------------------------------------------

  void read_handles() {
    std::set<std::string> taken;
    Json& list = root_["handles"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = join("handles", i);
      Json& j = list[i];
      HandleSpec handle;
      handle.name = read_name(j, "handles", i, taken);
      handle.geometry = read_geometry_name(j, path);
      handle.vertices = select(j["select"], handle.geometry, join(path, "select"));
      handle.motion = read_motion(j["motion"], join(path, "motion"));
      check_starts_at_rest(handle, join(path, "motion"));
      if (j.contains("release")) handle.release = j["release"].get<double>();
      refuse_shared_vertices(handle, path);
      scene_.handles.push_back(std::move(handle));
    }
  }

  void read_weights() {
    std::set<std::string> taken;
    Json& list = root_["weights"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = join("weights", i);
      WeightSpec weight;
      weight.name = read_name(list[i], "weights", i, taken);
      weight.geometry = read_geometry_name(list[i], path);
      weight.vertices = select(list[i]["select"], weight.geometry, join(path, "select"));
      weight.mass = list[i]["mass"].get<double>();
      scene_.weights.push_back(std::move(weight));
    }
  }

  std::vector<std::int32_t> select(const Json& j, const std::string& geometry,
                                   const std::string& path) const {
    const auto cloth = std::find_if(scene_.cloths.begin(), scene_.cloths.end(),
                                    [&](const ClothSpec& c) { return c.name == geometry; });
    return detail::select_vertices(document_, j, *cloth, scene_.materials.at(cloth->material),
                                   methods_.patterns, path);
  }

  std::string read_geometry_name(Json& j, const std::string& path) const {
    if (!j.contains("geometry")) {
      if (scene_.cloths.size() > 1)
        fail(document_, path, "needs the key \"geometry\", because there are several pieces");
      j["geometry"] = scene_.cloths.front().name;
    }
    std::vector<std::string> known;
    for (const ClothSpec& cloth : scene_.cloths) known.push_back(cloth.name);
    require_known(j["geometry"].get<std::string>(), known, join(path, "geometry"), "geometry");
    return j["geometry"].get<std::string>();
  }

  /// The motion of a handle is relative to its start. A first keyframe that moves it would tear the
  /// cloth in the first step.
  void check_starts_at_rest(const HandleSpec& handle, const std::string& path) const {
    if (handle.motion.empty()) return;
    const Keyframe& first = handle.motion.front();
    const Eigen::Quaterniond identity = Eigen::Quaterniond::Identity();
    if (first.translation != Vec3::Zero() || first.rotation.coeffs() != identity.coeffs())
      fail(document_, path,
           "the first keyframe of a handle is its start and must not translate or rotate");
  }

  void refuse_shared_vertices(const HandleSpec& handle, const std::string& path) {
    for (const std::int32_t vertex : handle.vertices) {
      const auto [other, is_new] = held_.try_emplace({handle.geometry, vertex}, handle.name);
      if (!is_new)
        fail(document_, path,
             fmt::format("vertex {} of {} is held by {} already", vertex,
                         in_quotes(handle.geometry), in_quotes(other->second)));
    }
  }

  // -- obstacles ----------------------------------------------------------------------------------

  void read_obstacles() {
    std::set<std::string> taken;
    Json& list = root_["obstacles"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = join("obstacles", i);
      Json& j = list[i];
      BodySpec body;
      body.name = read_name(j, "obstacles", i, taken);
      if (j.contains("shape")) body.shape = read_shape(j["shape"], join(path, "shape"));
      if (j.contains("mesh") && j["mesh"].is_string())
        body.shape = BodyFile{read_file(j["mesh"], join(path, "mesh")), read_load(j), {}};
      if (j.contains("mesh") && j["mesh"].is_object())
        body.shape = BodyFile{{}, read_load(j), read_inline_mesh(j["mesh"])};
      if (j.contains("sequence"))
        body.shape = read_sequence(j, join(path, "sequence"));
      else
        body.motion = read_motion(j["motion"], join(path, "motion"));
      body.placement = read_placement(j["transformation"], join(path, "transformation"));
      body.friction = j["friction"].get<double>();
      scene_.bodies.push_back(std::move(body));
    }
  }

  static LoadConfig read_load(const Json& j) {
    LoadConfig load;
    load.unit = j["unit"].get<double>();
    load.up = j["up"] == "x" ? UpAxis::x : j["up"] == "y" ? UpAxis::y : UpAxis::z;
    // Frames of a sequence are never welded: each could be welded differently.
    load.weld = j.value("weld", false);
    return load;
  }

  BodyShape read_shape(const Json& j, const std::string& path) const {
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
        fail(document_, join(path, "tube"), "must be less than radius, or the ring has no hole");
      shape.shape = Torus{number("radius"), number("tube")};
    }
    return shape;
  }

  BodySequence read_sequence(Json& j, const std::string& path) {
    Json& sequence = j["sequence"];
    BodySequence shape;
    shape.load = read_load(j);
    shape.fps = sequence["fps"].get<double>();
    shape.start = sequence["start"].get<double>();
    Json& files = sequence["files"];
    const std::string place = join(path, "files");
    if (files.is_string()) files = expand(files.get<std::string>(), sequence["first"], place);
    for (std::size_t i = 0; i < files.size(); ++i)
      shape.files.push_back(read_file(files[i], join(place, i)));
    return shape;
  }

  /// "walk_####.obj" into the files that exist from number `first` on.
  Json expand(const std::string& pattern, std::int64_t first, const std::string& path) const {
    const auto begin = pattern.find('#');
    if (begin == std::string::npos)
      fail(document_, path, "needs a list of files, or a name with # for each digit of a number");
    const auto end = std::min(pattern.find_first_not_of('#', begin), pattern.size());
    Json files = Json::array();
    const auto name = [&](std::int64_t number) {
      return fmt::format("{}{:0{}}{}", pattern.substr(0, begin), number, end - begin,
                         pattern.substr(end));
    };
    std::error_code error;
    while (std::filesystem::exists(absolute(name(first)), error)) files.push_back(name(first++));
    constexpr std::size_t fewest = 2;
    if (files.size() < fewest)
      fail(document_, path,
           fmt::format("a sequence needs at least 2 files; there is no file {}",
                       absolute(name(first)).string()));
    return files;
  }

  // -- numbers ------------------------------------------------------------------------------------

  void read_air() {
    const Json& j = root_["air"];
    scene_.air.wind = read_vec3(j["wind"]);
    scene_.air.normal_drag = j["normal_drag"].get<double>();
    scene_.air.viscous_drag = j["viscous_drag"].get<double>();
  }

  void read_time() {
    const Json& j = root_["time"];
    scene_.time.frames = j["frames"].get<int>();
    scene_.time.fps = j["fps"].get<double>();
    scene_.time.steps_per_frame = j["steps_per_frame"].get<int>();
    scene_.time.max_halvings = j["max_halvings"].get<int>();
  }

  void read_contact() {
    const Json& j = root_["contact"];
    scene_.contact.rest_gap = j["rest_gap"].get<double>();
    scene_.contact.self = j["self"].get<bool>();
    scene_.contact.untangle_start = j["start"] == "untangle";
    scene_.contact.carry_tangled = j["still_tangled"] == "carry";
    ContactSpec& contact = scene_.contact;
    contact.broad_phase = read_method(j["broad_phase"], methods_.broad_phases,
                                      "contact.broad_phase", contact.broad_phase_options);
    contact.narrow_phase = read_method(j["narrow_phase"], methods_.narrow_phases,
                                       "contact.narrow_phase", contact.narrow_phase_options);
    contact.response = read_method(j["response"], methods_.responses, "contact.response",
                                   contact.response_options);
    read_flat_options(
        j, "contact", methods_.responses.at(contact.response),
        {"stiffness", "damping", "restitution", "retention", "slip_speed", "sticking"},
        contact.response_options);
    contact.fail_safe = read_method(j["fail_safe"], methods_.fail_safes, "contact.fail_safe",
                                    contact.fail_safe_options);
    read_pairs(j["pairs"]);
  }

  void read_pairs(const Json& list) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Json& j = list[i];
      PairSpec pair{j["a"].get<std::string>(), j["b"].get<std::string>(), {}, {}};
      if (j.contains("friction")) pair.friction = j["friction"].get<double>();
      if (j.contains("rest_gap")) pair.rest_gap = j["rest_gap"].get<double>();
      const std::string path = join("contact.pairs", i);
      if (const PairFault fault = fault_of(pair, scene_); !fault.sentence.empty())
        fail(document_, fault.key.empty() ? path : join(path, fault.key), fault.sentence);
      scene_.contact.pairs.push_back(std::move(pair));
    }
  }

  void read_solver() {
    const Json& j = root_["solver"];
    SolverSpec& solver = scene_.solver;
    solver.integrator = read_method(j["integrator"], methods_.integrators, "solver.integrator",
                                    solver.integrator_options);
    read_flat_options(j, "solver", methods_.integrators.at(solver.integrator),
                      {"error", "drag", "max_newton"}, solver.integrator_options);
    read_strain_limiter(j["strain_limiter"]);
    solver.refuse_unstable_step = j["unstable_step"] == "refuse";
    scene_.solver.tolerance = j["tolerance"].get<double>();
    scene_.solver.max_iterations = j["max_iterations"].get<int>();
  }

  /// A method as in read_method, or as in older scenes whether there is one.
  void read_strain_limiter(const Json& j) {
    SolverSpec& solver = scene_.solver;
    if (j.is_boolean()) {
      if (!j.get<bool>()) solver.limiter = "none";
    } else {
      solver.limiter =
          read_method(j, methods_.strain_limiters, "solver.strain_limiter", solver.limiter_options);
    }
    solver.strain_limiter =
        methods_.strain_limiters.at(solver.limiter).traits().kind != LimiterKind::none;
  }

  void read_output() {
    const Json& j = root_["output"];
    detail::read_formats(j["formats"], scene_.output);
    scene_.output.vtk = j["vtk"].get<bool>();
    scene_.output.pc2 = j["pc2"].get<bool>();
    scene_.output.picture_every = j["picture_every"].get<int>();
    CameraSpec& camera = scene_.output.camera;
    camera.eye = read_vec3(j["camera"]["eye"]);
    camera.target = read_vec3(j["camera"]["target"]);
    camera.field_of_view = j["camera"]["field_of_view"].get<double>();
    camera.width = j["camera"]["width"].get<int>();
    camera.height = j["camera"]["height"].get<int>();
    if (camera.eye == camera.target)
      fail(document_, "output.camera.target", "must differ from the camera's eye");
  }

  void read_closed_form() {
    if (!root_.contains("closed_form")) return;
    const Json& j = root_["closed_form"];
    scene_.closed_form.motion = word_of<ClosedForm>(
        j["motion"], {{"free_fall", ClosedForm::free_fall}, {"incline", ClosedForm::incline}});
    if (scene_.closed_form.motion != ClosedForm::incline) return;
    if (!j.contains("body"))
      fail(document_, "closed_form", "needs the key \"body\" for an incline");
    scene_.closed_form.body = j["body"].get<std::string>();
    std::vector<std::string> known;
    for (const BodySpec& body : scene_.bodies) known.push_back(body.name);
    require_known(scene_.closed_form.body, known, "closed_form.body", "obstacle");
  }

  LocatedJson& document_;
  const Methods& methods_;
  Json& root_;
  Scene scene_;
  std::map<std::string, std::vector<Keyframe>> motions_;
  std::map<std::pair<std::string, std::int32_t>, std::string> held_;  // vertex to handle
};

}  // namespace

std::vector<std::string> OutputSpec::all_formats() const {
  std::vector<std::string> all = formats;
  if (vtk) all.emplace_back("vtk");
  if (pc2) all.emplace_back("pc2");
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

Scene read_scene(const std::filesystem::path& file, const std::vector<Override>& overrides,
                 const Methods& methods) {
  LocatedJson document = detail::parse_json_file(file);
  detail::rename_old_keys(document);
  for (const Override& set : overrides) detail::apply(document, {present_key(set.path), set.value});
  detail::rename_old_keys(document);
  detail::expand_fabrics(document);
  detail::check_and_complete(document, Json::parse(detail::scene_schema_text()));
  return SceneReader(document, methods).read();
}

}  // namespace selvedge
