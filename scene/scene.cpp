// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/detail/old_keys.h>
#include <selvedge/scene/detail/read_bodies.h>
#include <selvedge/scene/detail/read_extras.h>
#include <selvedge/scene/detail/read_garment.h>
#include <selvedge/scene/detail/read_geometry.h>
#include <selvedge/scene/detail/read_values.h>
#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/detail/select_vertices.h>
#include <selvedge/scene/scene.h>
#include <selvedge/scene/scene_text.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace selvedge {

namespace {

using detail::fail;
using detail::in_quotes;
using detail::join;
using detail::Json;
using detail::LocatedJson;
using detail::read_name;
using detail::read_placement;
using detail::read_vec3;
using detail::require_known;

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
    refuse_bad_name();
    scene_.gravity = read_vec3(root_["gravity"]);
    read_materials();
    read_force_laws();
    read_geometry();
    detail::check_motions(document_);
    read_handles();
    read_weights();
    detail::read_seams(document_, selector_, scene_);
    scene_.seams.insert(scene_.seams.end(), garment_seams_.begin(), garment_seams_.end());
    detail::read_water(document_, selector_, scene_);
    detail::read_bodies(document_, scene_);
    read_air();
    read_perturbation();
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

  /// The name of the scene names folders.
  void refuse_bad_name() const {
    const std::string& name = scene_.name;
    if (name == "." || name == ".." || name.find('/') != std::string::npos)
      fail(document_, "name",
           in_quotes(name) + " cannot be the name of a folder; leave out \"/\" and \"..\"");
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

  /// Options that stand beside the method's name, as in older scene files. Version 0.1 completed
  /// the scene.json of a result with the options of all methods; those of other methods had no
  /// effect and are dropped.
  template <class Entry>
  void read_flat_options(Json& section, const std::string& stem, const Entry& entry,
                         std::initializer_list<const char*> keys, MethodOptions& options) const {
    const bool completed = std::all_of(keys.begin(), keys.end(),
                                       [&](const char* key) { return section.contains(key); });
    for (const std::string key : keys) {
      if (!section.contains(key)) continue;
      if (completed && std::none_of(entry.options().begin(), entry.options().end(),
                                    [&](const auto& option) { return option.name == key; })) {
        section.erase(key);
        continue;
      }
      if (options.contains(key))
        fail(document_, join(stem, key), "is given twice; keep the one beside \"type\"");
      read_option(section[key], entry, join(stem, key), key, options);
    }
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
      if (j.contains("poisson")) m.poisson = j["poisson"].get<double>();
      m.spring_damping = j["spring_damping"].get<double>();
      m.bending_damping = j["bending_damping"].get<double>();
      m.strain_limit = j["strain_limit"].get<double>();
      m.friction = j["friction"].get<double>();
      read_laws(j, m);
      read_curves(root_["materials"][name], join("materials", name), m);
    }
  }

  /// The measured curves. The stiffness at rest is the slope of the curve; scene.json gets it, so
  /// that another one beside a curve can be refused.
  void read_curves(Json& j, const std::string& path, Material& m) const {
    const Material usual;
    const auto stiffness = [&](const char* key, const char* curve, double at_rest, double common) {
      constexpr double rounding = 1e-12;
      if (j.contains(key)) {
        const auto given = j[key].get<double>();
        if (given != common && std::abs(given - at_rest) > rounding * at_rest)
          fail(document_, join(path, key),
               fmt::format("is the slope at rest of {}, {:g}; leave it out", curve, at_rest));
      }
      j[key] = at_rest;
      return at_rest;
    };
    m.tension_curve = read_curve(j, "tension_curve", "strain", "force", path);
    m.tension_weft = read_curve(j, "tension_curve_weft", "strain", "force", path);
    m.shear_curve = read_curve(j, "shear_curve", "angle", "force", path);
    m.bending_curve = read_curve(j, "bending_curve", "curvature", "moment", path);
    m.bending_curve_weft = read_curve(j, "bending_curve_weft", "curvature", "moment", path);
    const auto slope = [](const MonotoneCurve& curve) { return curve.slope_at_rest(); };
    if (!m.tension_curve.empty())
      m.stretch_stiffness = stiffness("stretch_stiffness", "tension_curve", slope(m.tension_curve),
                                      usual.stretch_stiffness);
    if (!m.tension_weft.empty())
      m.stretch_weft = stiffness("stretch_weft", "tension_curve_weft", slope(m.tension_weft),
                                 slope(m.tension_weft));
    if (!m.shear_curve.empty())
      m.shear_stiffness =
          stiffness("shear_stiffness", "shear_curve", slope(m.shear_curve), usual.shear_stiffness);
    if (!m.bending_curve.empty())
      m.bending_stiffness = stiffness("bending_stiffness", "bending_curve", slope(m.bending_curve),
                                      usual.bending_stiffness);
    if (!m.bending_curve_weft.empty())
      m.bending_weft = stiffness("bending_weft", "bending_curve_weft", slope(m.bending_curve_weft),
                                 slope(m.bending_curve_weft));
  }

  MonotoneCurve read_curve(const Json& j, const char* key, const char* x, const char* y,
                           const std::string& path) const {
    if (!j.contains(key)) return {};
    try {
      return {j[key][x].get<std::vector<double>>(), j[key][y].get<std::vector<double>>()};
    } catch (const std::invalid_argument& error) {
      fail(document_, join(path, key), error.what());
    }
  }

  static void read_laws(const Json& j, Material& m) {
    m.stretch_law = j["stretch_law"].get<std::string>();
    m.shear_law = j["shear_law"].get<std::string>();
    m.bending_law = j["bending_law"].get<std::string>();
    m.biphasic_strain = j["biphasic_strain"].get<double>();
    m.biphasic_growth = j["biphasic_growth"].get<double>();
    m.kawabata_lt = j["kawabata_lt"].get<double>();
    m.kawabata_strain = j["kawabata_strain"].get<double>();
    m.kawabata_rt = j["kawabata_rt"].get<double>();
    m.shear_friction = j["shear_friction"].get<double>();
    m.bending_friction = j["bending_friction"].get<double>();
  }

  void read_force_laws() {
    if (!root_.contains(kForceLawKey)) return;
    for (const auto& [name, given] : root_[kForceLawKey].items()) {
      const std::string path = join(kForceLawKey, name);
      if (const std::string fault = methods_.force_laws.fault(name); !fault.empty())
        fail(document_, path, fault);
      for (const auto& [key, value] : given.items())
        read_option(value, methods_.force_laws.at(name), join(path, key), key,
                    scene_.force_laws[name]);
    }
  }

  void read_geometry() {
    std::set<std::string> taken;
    Json& list = root_["geometry"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = join("geometry", i);
      Json& j = list[i];
      ClothSpec cloth;
      cloth.name = read_name(document_, j, "geometry", i, taken);
      if (j.contains("sewing_pattern"))
        detail::read_garment(document_, j, path, cloth, garment_seams_);
      else if (j.contains("mesh"))
        cloth.shape = read_cloth_file(j, path);
      else
        cloth.shape = read_cloth_grid(j, path);
      cloth.placement =
          read_placement(document_, j["transformation"], join(path, "transformation"));
      cloth.velocity = read_vec3(j["velocity"]);
      cloth.material = j["material"].get<std::string>();
      cloth.virtual_springs = detail::read_virtual_springs(j);
      std::vector<std::string> known;
      for (const auto& [name, material] : scene_.materials) known.push_back(name);
      require_known(document_, cloth.material, known, join(path, "material"), "material");
      scene_.cloths.push_back(std::move(cloth));
    }
  }

  ClothFile read_cloth_file(Json& j, const std::string& path) {
    ClothFile shape;
    if (j["mesh"].is_string())
      shape.file = detail::read_file(document_, j["mesh"], join(path, "mesh"));
    else
      shape.mesh = detail::read_inline_mesh(j["mesh"]);
    if (j["rest_mesh"] != "")
      shape.rest_file = detail::read_file(document_, j["rest_mesh"], join(path, "rest_mesh"));
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

  // -- handles ------------------------------------------------------------------------------------

  void read_handles() {
    std::set<std::string> taken;
    Json& list = root_["handles"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = join("handles", i);
      Json& j = list[i];
      HandleSpec handle;
      handle.name = read_name(document_, j, "handles", i, taken);
      handle.geometry = read_geometry_name(j, path);
      handle.vertices = select(j["select"], handle.geometry, join(path, "select"));
      handle.motion = detail::read_motion(document_, j["motion"], join(path, "motion"));
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
      weight.name = read_name(document_, list[i], "weights", i, taken);
      weight.geometry = read_geometry_name(list[i], path);
      weight.vertices = select(list[i]["select"], weight.geometry, join(path, "select"));
      weight.mass = list[i]["mass"].get<double>();
      scene_.weights.push_back(std::move(weight));
    }
  }

  std::vector<std::int32_t> select(const Json& j, const std::string& geometry,
                                   const std::string& path) {
    const auto cloth = std::find_if(scene_.cloths.begin(), scene_.cloths.end(),
                                    [&](const ClothSpec& c) { return c.name == geometry; });
    return selector_.select(j, *cloth, path);
  }

  std::string read_geometry_name(Json& j, const std::string& path) const {
    if (!j.contains("geometry")) {
      if (scene_.cloths.size() > 1)
        fail(document_, path, "needs the key \"geometry\", because there are several pieces");
      j["geometry"] = scene_.cloths.front().name;
    }
    std::vector<std::string> known;
    for (const ClothSpec& cloth : scene_.cloths) known.push_back(cloth.name);
    require_known(document_, j["geometry"].get<std::string>(), known, join(path, "geometry"),
                  "geometry");
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

  // -- numbers ------------------------------------------------------------------------------------

  void read_air() {
    const Json& j = root_["air"];
    scene_.air.wind = read_vec3(j["wind"]);
    const Json& gusts = j["gusts"];
    scene_.air.gusts = {gusts["speed"].get<double>(), gusts["length"].get<double>(),
                        gusts["seed"].get<std::uint64_t>()};
    for (const Json& jet : j["jets"]) {
      scene_.air.jets.push_back({read_vec3(jet["position"]), read_vec3(jet["direction"]),
                                 jet["speed"].get<double>(), jet["diameter"].get<double>()});
      if (scene_.air.jets.back().direction.isZero(0.0))
        fail(document_, fmt::format("air.jets.{}.direction", scene_.air.jets.size() - 1),
             "has no length; give the direction in which the jet blows");
    }
    scene_.air.normal_drag = j["normal_drag"].get<double>();
    scene_.air.viscous_drag = j["viscous_drag"].get<double>();
  }

  void read_perturbation() {
    const Json& j = root_["perturbation"];
    scene_.perturbation = {j["speed"].get<double>(), j["seed"].get<std::uint64_t>()};
  }

  void read_time() {
    const Json& j = root_["time"];
    scene_.time.frames = j["frames"].get<int>();
    scene_.time.fps = j["fps"].get<double>();
    scene_.time.steps_per_frame = j["steps_per_frame"].get<int>();
    scene_.time.step_error = j["step_error"].get<double>();
    scene_.time.sleep_speed = j["sleep_speed"].get<double>();
    scene_.time.max_halvings = j["max_halvings"].get<int>();
    scene_.time.energy_guard = j["energy_guard"].get<bool>();
  }

  void read_contact() {
    Json& j = root_["contact"];
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
      PairSpec pair{j["a"].get<std::string>(), j["b"].get<std::string>(), {}, {}, {}};
      if (j.contains("friction")) pair.friction = j["friction"].get<double>();
      if (j.contains("rest_gap")) pair.rest_gap = j["rest_gap"].get<double>();
      if (j.contains("collide")) pair.collide = j["collide"].get<bool>();
      const std::string path = join("contact.pairs", i);
      if (const PairFault fault = fault_of(pair, scene_); !fault.sentence.empty())
        fail(document_, fault.key.empty() ? path : join(path, fault.key), fault.sentence);
      scene_.contact.pairs.push_back(std::move(pair));
    }
  }

  void read_solver() {
    Json& j = root_["solver"];
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
    require_known(document_, scene_.closed_form.body, known, "closed_form.body", "obstacle");
  }

  LocatedJson& document_;
  const Methods& methods_;
  Json& root_;
  Scene scene_;
  detail::VertexSelector selector_{document_, scene_.materials, methods_.patterns};
  std::vector<SeamSpec> garment_seams_;                               // of sewing patterns
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

namespace {

Scene read_document(LocatedJson document, const std::vector<Override>& overrides,
                    const Methods& methods) {
  detail::rename_old_keys(document);
  for (const Override& set : overrides) detail::apply(document, {present_key(set.path), set.value});
  detail::rename_old_keys(document);
  detail::expand_fabrics(document);
  detail::check_and_complete(document, detail::scene_schema());
  return SceneReader(document, methods).read();
}

}  // namespace

Scene read_scene(const std::filesystem::path& file, const std::vector<Override>& overrides,
                 const Methods& methods) {
  return read_document(detail::parse_json_file(file), overrides, methods);
}

Scene read_scene_text(const std::string& text, const std::filesystem::path& file,
                      const std::vector<Override>& overrides, const Methods& methods) {
  return read_document(detail::parse_json_text(text, file), overrides, methods);
}

}  // namespace selvedge
