// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/detail/old_keys.h>
#include <selvedge/scene/detail/read_bodies.h>
#include <selvedge/scene/detail/read_extras.h>
#include <selvedge/scene/detail/read_fields.h>
#include <selvedge/scene/detail/read_garment.h>
#include <selvedge/scene/detail/read_values.h>
#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/detail/select_vertices.h>
#include <selvedge/scene/internal/scene_text.h>
#include <selvedge/scene/scene.h>

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
    fields_.read(root_, "", scene_);
    read_materials();
    read_force_laws();
    read_geometry();
    detail::check_motions(document_);
    detail::read_bodies(document_, fields_, scene_);
    read_handles();
    read_weights();
    detail::read_seams(document_, selector_, scene_);
    scene_.seams.insert(scene_.seams.end(), garment_seams_.begin(), garment_seams_.end());
    detail::read_water(document_, selector_, scene_);
    refuse_jets_without_direction();
    check_pairs();
    const LimiterTraits limiter = methods_.strain_limiters.at(scene_.solver.limiter).traits();
    scene_.solver.strain_limiter = limiter.kind != LimiterKind::none;
    if (scene_.output.camera.eye == scene_.output.camera.target)
      fail(document_, "output.camera.target", "must differ from the camera's eye");
    check_closed_form();
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

  // -- cloth --------------------------------------------------------------------------------------

  void read_materials() {
    scene_.materials["default"] = Material{};
    for (const auto& item : root_["materials"].items()) {
      const std::string path = join("materials", item.key());
      MaterialKeys keys;
      fields_.read(item.value(), path, keys);
      set_slopes(item.value(), path, keys.material);
      scene_.materials[item.key()] = std::move(keys.material);
    }
  }

  /// The stiffness at rest is the slope of the measured curve; scene.json gets it, so that another
  /// one beside a curve can be refused.
  void set_slopes(Json& j, const std::string& path, Material& m) const {
    const Material usual;
    const auto set = [&](auto& stiffness, const char* key, const MonotoneCurve& curve,
                         const char* name, std::optional<double> common) {
      constexpr double rounding = 1e-12;
      if (curve.empty()) return;
      const double at_rest = curve.slope_at_rest();
      const double given = j.value(key, at_rest);
      if (given != common && std::abs(given - at_rest) > rounding * at_rest)
        fail(document_, join(path, key),
             fmt::format("is the slope at rest of {}, {:g}; leave it out", name, at_rest));
      j[key] = at_rest;
      stiffness = at_rest;
    };
    set(m.stretch_stiffness, "stretch_stiffness", m.tension_curve, "tension_curve",
        usual.stretch_stiffness);
    set(m.stretch_weft, "stretch_weft", m.tension_weft, "tension_curve_weft", {});
    set(m.shear_stiffness, "shear_stiffness", m.shear_curve, "shear_curve", usual.shear_stiffness);
    set(m.bending_stiffness, "bending_stiffness", m.bending_curve, "bending_curve",
        usual.bending_stiffness);
    set(m.bending_weft, "bending_weft", m.bending_curve_weft, "bending_curve_weft", {});
  }

  void read_force_laws() {
    if (!root_.contains(kForceLawKey)) return;
    for (const auto& [name, given] : root_[kForceLawKey].items()) {
      const std::string path = join(kForceLawKey, name);
      if (const std::string fault = methods_.force_laws.fault(name); !fault.empty())
        fail(document_, path, fault);
      for (const auto& [key, value] : given.items())
        detail::read_option(document_, value, join(path, key), key, name,
                            methods_.force_laws.at(name).options(), scene_.force_laws[name]);
    }
  }

  void read_geometry() {
    std::set<std::string> taken;
    std::vector<std::string> materials;
    for (const auto& [name, material] : scene_.materials) materials.push_back(name);
    Json& list = root_["geometry"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = join("geometry", i);
      const std::string name = read_name(document_, list[i], "geometry", i, taken);
      ClothSpec cloth = list[i].contains("sewing_pattern") ? read_garment(list[i], path, name)
                        : list[i].contains("mesh")         ? read_cloth_file(list[i], path)
                                                           : read_cloth_grid(list[i], path);
      cloth.name = name;
      require_known(document_, cloth.material, materials, join(path, "material"), "material");
      scene_.cloths.push_back(std::move(cloth));
    }
  }

  ClothSpec read_garment(Json& j, const std::string& path, const std::string& name) {
    PieceOf<GarmentKeys> piece;
    fields_.read(j, path, piece);
    piece.cloth.name = name;
    detail::read_garment(document_, path, piece, garment_seams_);
    return std::move(piece.cloth);
  }

  ClothSpec read_cloth_file(Json& j, const std::string& path) const {
    PieceOf<ClothFile> piece;
    fields_.read(j, path, piece);
    ClothFile& shape = piece.shape;
    if (j["mesh"].is_string())
      shape.file = detail::read_file(document_, j["mesh"], join(path, "mesh"));
    else
      fields_.read(j["mesh"], join(path, "mesh"), shape.mesh);
    const std::string place = join(path, "rest_mesh");
    if (j["rest_mesh"] == "texture") {
      if (shape.file.empty()) fail(document_, place, "\"texture\" needs an OBJ file as mesh");
      shape.texture_unit = j["texture_unit"].get<double>();
    } else if (j["rest_mesh"] != "") {
      shape.rest_file = detail::read_file(document_, j["rest_mesh"], place);
    }
    piece.cloth.shape = std::move(shape);
    return std::move(piece.cloth);
  }

  ClothSpec read_cloth_grid(Json& j, const std::string& path) const {
    PieceOf<ClothGrid> piece;
    fields_.read(j, path, piece);
    piece.cloth.shape = std::move(piece.shape);
    return std::move(piece.cloth);
  }

  // -- handles ------------------------------------------------------------------------------------

  void read_handles() {
    std::set<std::string> taken;
    Json& list = root_["handles"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = join("handles", i);
      Json& j = list[i];
      HandleSpec& handle = scene_.handles[i];
      handle.name = read_name(document_, j, "handles", i, taken);
      const ClothSpec& cloth = detail::piece_of(document_, j, path, scene_);
      handle.geometry = cloth.name;
      handle.vertices = selector_.select(j["select"], cloth, join(path, "select"));
      handle.motion = detail::read_motion(document_, j["motion"], join(path, "motion"));
      check_starts_at_rest(handle, join(path, "motion"));
      refuse_shared_vertices(handle, path);
    }
  }

  void read_weights() {
    Json& list = root_["weights"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string path = join("weights", i);
      WeightSpec& weight = scene_.weights[i];
      weight.name = join("weights", i);
      const ClothSpec& cloth = detail::piece_of(document_, list[i], path, scene_);
      weight.geometry = cloth.name;
      weight.vertices = selector_.select(list[i]["select"], cloth, join(path, "select"));
    }
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

  // -- rules between keys -------------------------------------------------------------------------

  void refuse_jets_without_direction() const {
    for (std::size_t i = 0; i < scene_.air.jets.size(); ++i)
      if (scene_.air.jets[i].direction.isZero(0.0))
        fail(document_, join(join("air.jets", i), "direction"),
             "has no length; give the direction in which the jet blows");
  }

  void check_pairs() const {
    for (std::size_t i = 0; i < scene_.contact.pairs.size(); ++i) {
      const std::string path = join("contact.pairs", i);
      if (const PairFault fault = fault_of(scene_.contact.pairs[i], scene_);
          !fault.sentence.empty())
        fail(document_, fault.key.empty() ? path : join(path, fault.key), fault.sentence);
    }
  }

  void check_closed_form() const {
    if (scene_.closed_form == ClosedForm::incline && scene_.bodies.size() != 1)
      fail(document_, "closed_form",
           fmt::format("an incline needs one obstacle, the slope, and there are {}",
                       scene_.bodies.size()));
  }

  LocatedJson& document_;
  const Methods& methods_;
  Json& root_;
  Scene scene_;
  detail::FieldReader fields_{document_, methods_};
  detail::VertexSelector selector_{document_, scene_.materials, methods_.patterns};
  std::vector<SeamSpec> garment_seams_;                               // of sewing patterns
  std::map<std::pair<std::string, std::int32_t>, std::string> held_;  // vertex to handle
};

}  // namespace

std::vector<std::string> OutputSpec::all_formats() const {
  std::vector<std::string> all = formats;
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

namespace {

Scene read_document(LocatedJson document, const std::vector<Override>& overrides,
                    const Methods& methods) {
  detail::rename_old_keys(document);
  for (const Override& set : overrides)
    detail::apply(document, {detail::renamed_path(set.path), set.value});
  detail::rename_old_keys(document);
  detail::move_old_options(document, methods);
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
