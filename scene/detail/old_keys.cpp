// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/old_keys.h>

#include <algorithm>
#include <array>
#include <functional>
#include <vector>

namespace selvedge {
namespace detail {
namespace {

/// A key of an older version. A star stands for any index or name.
struct OldKey {
  const char* old;
  const char* now = "";   ///< its present path, to which its value is moved; empty: it is gone
  const char* gone = "";  ///< what to write instead, or why it has no successor
  /// The value that does what now always happens, as JSON; it is dropped. A star: any value.
  const char* dropped = "";
  /// Instead of `true`, this stands in the list of output formats.
  const char* format = "";
  bool is_option = false;  ///< stood beside the name of its method
};

constexpr const char* kPoints = "a curve is the list of its points, such as [[0, 0], [0.02, 9.5]]";
constexpr const char* kInPrograms = "its default serves every scene; a program can set it in C++";

// clang-format off
/// Keys that were renamed, moved or removed. They are answered until version 1.0.
constexpr OldKey kOldKeys[] = {
    {.old = "contact.thickness", .now = "contact.rest_gap"},
    {.old = "contact.pairs.*.thickness", .now = "contact.pairs.*.rest_gap"},
    {.old = "geometry.*.layers.*", .now = "geometry.*.pattern.*"},
    {.old = "seams.*.a", .now = "seams.*.sides.0"},
    {.old = "seams.*.b", .now = "seams.*.sides.1"},
    {.old = "*.*.select.edge", .now = "*.*.select"},
    {.old = "*.*.select.corners", .now = "*.*.select"},
    {.old = "*.*.select.vertices", .now = "*.*.select"},
    {.old = "seams.*.sides.*.select.edge", .now = "seams.*.sides.*.select"},
    {.old = "seams.*.sides.*.select.corners", .now = "seams.*.sides.*.select"},
    {.old = "seams.*.sides.*.select.vertices", .now = "seams.*.sides.*.select"},
    {.old = "water.sources.*.select.edge", .now = "water.sources.*.select"},
    {.old = "water.sources.*.select.corners", .now = "water.sources.*.select"},
    {.old = "water.sources.*.select.vertices", .now = "water.sources.*.select"},
    {.old = "geometry.*.transformation.scale", .now = "geometry.*.scale"},
    {.old = "geometry.*.panels.*.translation", .now = "geometry.*.panels.*"},
    {.old = "geometry.*.plate.poisson", .now = "geometry.*.plate"},
    {.old = "geometry.*.rest", .now = "geometry.*.rest_mesh", .dropped = "\"mesh\""},
    {.old = "obstacles.*.shape.length", .now = "obstacles.*.shape.height"},
    {.old = "closed_form.body", .gone = "the slope is the only obstacle", .dropped = "*"},
    {.old = "closed_form.motion", .now = "closed_form"},
    {.old = "plan.proofs", .now = "plan"},

    {.old = "obstacles.*.transformation.scale", .gone = "give the sizes of the shape, or the \"unit\" of the mesh", .dropped = "1"},
    {.old = "obstacles.*.sequence.first", .gone = "a name with # begins with the lowest number; list the files to begin elsewhere", .dropped = "0"},
    {.old = "obstacles.*.sequence.start", .gone = "list the first mesh as often as it waits", .dropped = "0"},
    {.old = "materials.*.fabric_source", .gone = "write it into \"description\"", .dropped = "*"},
    {.old = "obstacles.*.without_groups", .gone = "name the groups that belong to the body in \"groups\"", .dropped = "[]"},
    {.old = "geometry.*.sewing.tolerance", .gone = kInPrograms, .dropped = "0.005"},
    {.old = "geometry.*.sewing.damping", .gone = kInPrograms, .dropped = "0.05"},
    {.old = "geometry.*.sewing.acceleration", .gone = "take a larger \"pull\"", .dropped = "0"},
    {.old = "materials.*.tension_curve.strain", .gone = kPoints},
    {.old = "materials.*.tension_curve_weft.strain", .gone = kPoints},
    {.old = "materials.*.shear_curve.angle", .gone = kPoints},
    {.old = "materials.*.bending_curve.curvature", .gone = kPoints},
    {.old = "materials.*.bending_curve_weft.curvature", .gone = kPoints},
    {.old = "geometry.*.pattern.half_border", .gone = "springs on the border of a net are whole; pattern \"rectangular\" has halved ones"},
    {.old = "geometry.*.pattern.alternating", .gone = "in pattern \"checkerboard\" the diagonals alternate"},
    {.old = "geometry.*.pattern.yarn_density", .gone = kInPrograms},
    {.old = "geometry.*.pattern.crimp_share", .gone = kInPrograms, .dropped = "0.5"},
    {.old = "geometry.*.pattern.twist", .gone = kInPrograms, .dropped = "5"},
    {.old = "solver.integrator.error_rate", .gone = kInPrograms},
    {.old = "solver.strain_limiter.growth", .gone = kInPrograms},
    {.old = "output.vtk", .gone = "write \"output\": {\"formats\": [\"vtk\"]}", .dropped = "false", .format = "vtk"},
    {.old = "output.pc2", .gone = "write \"output\": {\"formats\": [\"pc2\"]}", .dropped = "false", .format = "pc2"},
    {.old = "output.picture_every", .gone = "`selvedge render --frames` draws any frames of the result", .dropped = "0"},
    {.old = "output.camera.width", .gone = "`selvedge render --size` draws larger and smaller pictures", .dropped = "*"},
    {.old = "output.camera.height", .gone = "`selvedge render --size` draws larger and smaller pictures", .dropped = "*"},
    {.old = "contact.broad_phase.arity", .gone = kInPrograms},
    {.old = "contact.broad_phase.column", .gone = kInPrograms},
    {.old = "contact.broad_phase.find_limbs", .gone = kInPrograms},
    {.old = "contact.broad_phase.leaf_size", .gone = kInPrograms},
    {.old = "contact.broad_phase.rebuild_quality_loss", .gone = kInPrograms},
    {.old = "contact.broad_phase.margin", .gone = "it is chosen by the measured cost"},
    {.old = "contact.broad_phase.loops", .gone = kInPrograms},
    {.old = "contact.broad_phase.recut_volume", .gone = kInPrograms},
    {.old = "contact.broad_phase.wide_vectors", .gone = kInPrograms},
    {.old = "contact.narrow_phase.breadth_first", .gone = kInPrograms},
    {.old = "contact.narrow_phase.max_boxes", .gone = kInPrograms},
    {.old = "contact.narrow_phase.max_steps", .gone = kInPrograms},
    {.old = "contact.fail_safe.impulse_passes", .gone = kInPrograms},
    {.old = "contact.fail_safe.plane_rounds", .gone = kInPrograms},
    {.old = "contact.fail_safe.projection_rounds", .gone = kInPrograms},
    {.old = "seams.*.name", .gone = "nothing refers to it", .dropped = "*"},
    {.old = "weights.*.name", .gone = "nothing refers to it", .dropped = "*"},
    {.old = "solver.unstable_step", .gone = "a step that is too long is divided", .dropped = "\"substep\""},
    {.old = "solver.max_iterations", .gone = "a solve is given up after 2000 iterations; set \"tolerance\"", .dropped = "2000"},
    {.old = "solver.max_newton", .gone = kInPrograms, .dropped = "20"},
    {.old = "solver.integrator.max_newton", .gone = kInPrograms},
    {.old = "solver.integrator.max_inner_steps", .gone = kInPrograms},

    {.old = "contact.stiffness", .now = "contact.response.stiffness", .is_option = true},
    {.old = "contact.damping", .now = "contact.response.damping", .is_option = true},
    {.old = "contact.restitution", .now = "contact.response.restitution", .is_option = true},
    {.old = "contact.retention", .now = "contact.response.retention", .is_option = true},
    {.old = "contact.slip_speed", .now = "contact.response.slip_speed", .is_option = true},
    {.old = "contact.sticking", .now = "contact.response.sticking", .is_option = true},
    {.old = "solver.error", .now = "solver.integrator.error", .is_option = true},
    {.old = "solver.drag", .now = "solver.integrator.drag", .is_option = true}};
// clang-format on

using Parts = std::vector<std::string>;

/// `pattern` with its stars replaced by the parts of `path` at the stars of `like`.
Parts filled(const std::string& pattern, const std::string& like, const Parts& path) {
  Parts parts = split_path(pattern), from = split_path(like);
  std::size_t at = 0;
  for (std::string& part : parts) {
    if (part != "*") continue;
    while (from[at] != "*") ++at;
    part = path[at++];
  }
  return parts;
}

std::string dotted(const Parts& parts) {
  std::string path;
  for (const std::string& part : parts) path = join(path, part);
  return path;
}

const OldKey* find_old(const std::string& path) {
  const auto* found =
      std::find_if(std::begin(kOldKeys), std::end(kOldKeys),
                   [&](const OldKey& key) { return is_instance_of(path, key.old); });
  return found == std::end(kOldKeys) ? nullptr : found;
}

std::string present_path(const OldKey& key, const std::string& path) {
  return *key.now == 0 ? path : dotted(filled(key.now, key.old, split_path(path)));
}

bool is_index(const std::string& part) {
  return part.find_first_not_of("0123456789") == std::string::npos;
}

/// The member or element of `value`; null if there is none.
Json* part_of(Json& value, const std::string& part) {
  if (value.is_object() && value.contains(part)) return &value[part];
  if (!value.is_array() || !is_index(part)) return nullptr;
  const std::size_t index = std::stoul(part);
  return index < value.size() ? &value[index] : nullptr;
}

/// The place of a value in messages: as in LocatedJson::origin, with elements in brackets.
std::string place_of(Json& root, const Parts& parts) {
  std::string path;
  Json* value = &root;
  for (const std::string& part : parts) {
    const bool element = value != nullptr && value->is_array();
    path = element ? join(path, std::stoul(part)) : join(path, part);
    value = value == nullptr ? nullptr : part_of(*value, part);
  }
  return path;
}

/// Calls visit(parts) for each path in the document that fits the pattern.
void for_each_instance(Json& value, const Parts& pattern, Parts& path,
                       const std::function<void(const Parts&)>& visit) {
  if (path.size() == pattern.size()) return visit(path);
  const std::string& part = pattern[path.size()];
  Parts found;
  if (part != "*") found.push_back(part);
  if (part == "*" && value.is_object())
    for (const auto& [name, member] : value.items()) found.push_back(name);
  if (part == "*" && value.is_array())
    for (std::size_t i = 0; i < value.size(); ++i) found.push_back(std::to_string(i));
  for (const std::string& one : found) {
    Json* next = part_of(value, one);
    if (next == nullptr) continue;
    path.push_back(one);
    for_each_instance(*next, pattern, path, visit);
    path.pop_back();
  }
}

/// The value that encloses the one at `path`.
Json& enclosing(Json& root, const Parts& path) {
  Json* value = &root;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) value = part_of(*value, path[i]);
  return *value;
}

/// Moves the value of a group into the place of the group, unless there are more in it.
void replace_group(LocatedJson& document, const Parts& from) {
  Json& group = enclosing(document.root, from);
  if (group.size() == 1) group = Json(std::move(group[from.back()]));
}

/// Moves one value. A method that is given by its name becomes an object with the name. A value
/// whose new place cannot be, such as a list for a method, is dropped: the check refuses the place.
void move_value(LocatedJson& document, const Parts& from, const Parts& to) {
  if (to.size() < from.size() && std::equal(to.begin(), to.end(), from.begin()))
    return replace_group(document, from);
  Json* target = &document.root;
  for (std::size_t i = 0; i + 1 < to.size(); ++i) {
    Json* next = part_of(*target, to[i]);
    target = next != nullptr ? next : &(*target)[to[i]];
  }
  Json& source = enclosing(document.root, from);
  if (target->is_string()) *target = Json{{"type", *target}};
  const std::string old_place = place_of(document.root, from);
  if (part_of(*target, to.back()) != nullptr)
    fail(document, old_place,
         fmt::format("is the old name of \"{0}\", which is there, too; keep \"{0}\"",
                     from.back() == to.back() || is_index(to.back()) ? dotted(to) : to.back()));
  if (is_index(to.back()) && (target->is_null() || target->is_array()))
    target->push_back(std::move(source[from.back()]));
  else if (target->is_object() || target->is_null())
    (*target)[to.back()] = std::move(source[from.back()]);
  const bool moved = part_of(*target, to.back()) != nullptr;
  source.erase(from.back());
  if (!moved) return;
  if (auto origin = document.origin.extract(old_place)) {
    origin.key() = place_of(document.root, to);
    document.origin.insert(std::move(origin));
  }
}

/// Whether the value does what now always happens.
bool is_dropped(const OldKey& key, const Json& value) {
  if (*key.dropped == 0) return false;
  return key.dropped == std::string("*") || value == Json::parse(key.dropped);
}

void update_value(LocatedJson& document, const OldKey& key, const Parts& found) {
  Json& group = enclosing(document.root, found);
  if (*key.format != 0 && group[found.back()] == true) {
    Json& formats = group["formats"];
    if (formats.is_null() || formats.is_array()) formats.push_back(key.format);
    group.erase(found.back());
  } else if (is_dropped(key, group[found.back()]))
    group.erase(found.back());
  else if (*key.now != 0)
    move_value(document, found, filled(key.now, key.old, found));
}

void update_values(LocatedJson& document, bool options) {
  for (const OldKey& key : kOldKeys) {
    if (key.is_option != options) continue;
    std::vector<Parts> instances;
    Parts path;
    for_each_instance(document.root, split_path(key.old), path,
                      [&](const Parts& found) { instances.push_back(found); });
    for (const Parts& found : instances) update_value(document, key, found);
  }
}

/// Measured curves were two lists of equal length, now a list of points.
void join_curves(Json& root) {
  using Names = std::array<const char*, 3>;
  for (const Names& names :
       {Names{"tension_curve", "strain", "force"}, Names{"tension_curve_weft", "strain", "force"},
        Names{"shear_curve", "angle", "force"}, Names{"bending_curve", "curvature", "moment"},
        Names{"bending_curve_weft", "curvature", "moment"}}) {
    const char *across = names[1], *up = names[2];
    const auto join_one = [&](const Parts& found) {
      Json& value = enclosing(root, found)[found.back()];
      if (!value.is_object() || value.size() != 2) return;
      if (!value.contains(across) || !value.contains(up)) return;
      const Json x = value[across], y = value[up];
      if (!x.is_array() || !y.is_array() || x.size() != y.size()) return;
      value = Json::array();
      for (std::size_t i = 0; i < x.size(); ++i) value.push_back({x[i], y[i]});
    };
    Parts path;
    for_each_instance(root, {"materials", "*", names[0]}, path, join_one);
  }
}

/// Removes the groups "layers" whose members have moved.
void remove_empty_layers(Json& root) {
  if (!root.is_object() || !root.contains("geometry") || !root["geometry"].is_array()) return;
  for (Json& geometry : root["geometry"])
    if (geometry.is_object() && geometry.contains("layers") && geometry["layers"].is_object() &&
        geometry["layers"].empty())
      geometry.erase("layers");
}

/// Version 0.1 completed the scene.json of a result with the options of all responses and
/// integrators; those of other methods had no effect.
template <class Registry>
void drop_foreign_options(Json& root, const std::string& section, const std::string& method,
                          const Registry& registry) {
  Json* group = part_of(root, section);
  Json* named = group == nullptr ? nullptr : part_of(*group, method);
  if (named == nullptr || !named->is_string() || !registry.contains(*named)) return;
  Parts names;
  for (const OldKey& key : kOldKeys)
    if (key.is_option && std::string(key.old).starts_with(section + "."))
      names.push_back(split_path(key.old)[1]);
  if (!std::all_of(names.begin(), names.end(), [&](const auto& n) { return group->contains(n); }))
    return;
  const std::vector<MethodOption>& options = registry.at(*named).options();
  for (const std::string& name : names)
    if (std::none_of(options.begin(), options.end(), [&](const auto& o) { return o.name == name; }))
      group->erase(name);
}

}  // namespace

void rename_old_keys(LocatedJson& document) {
  join_curves(document.root);
  update_values(document, false);
  remove_empty_layers(document.root);
}

void move_old_options(LocatedJson& document, const Methods& methods) {
  drop_foreign_options(document.root, "contact", "response", methods.responses);
  drop_foreign_options(document.root, "solver", "integrator", methods.integrators);
  update_values(document, true);
}

std::string renamed_path(const std::string& path) {
  const OldKey* key = find_old(path);
  return key == nullptr || key->is_option || *key->dropped != 0 ? path : present_path(*key, path);
}

std::string answer_to_old_key(const std::string& path) {
  const OldKey* key = find_old(path);
  if (key == nullptr) return "";
  if (*key->gone != 0) return fmt::format("this key is gone: {}", key->gone);
  return fmt::format("is the old name of \"{}\"", present_path(*key, path));
}

}  // namespace detail

std::string present_key(const std::string& path) {
  const detail::OldKey* key = detail::find_old(path);
  return key == nullptr ? path : detail::present_path(*key, path);
}

}  // namespace selvedge
