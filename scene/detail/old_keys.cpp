// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/old_keys.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace selvedge {
namespace detail {
namespace {

struct OldKey {
  const char *old, *now;  ///< a star stands for any index or name
};

/// Keys that were renamed. They are read until version 1.0.
constexpr OldKey kRenamed[] = {{"contact.thickness", "contact.rest_gap"},
                               {"contact.pairs.*.thickness", "contact.pairs.*.rest_gap"},
                               {"geometry.*.layers.*", "geometry.*.pattern.*"}};

/// Options that stood beside the name of their method.
constexpr OldKey kMoved[] = {{"contact.stiffness", "contact.response.stiffness"},
                             {"contact.damping", "contact.response.damping"},
                             {"contact.restitution", "contact.response.restitution"},
                             {"contact.retention", "contact.response.retention"},
                             {"contact.slip_speed", "contact.response.slip_speed"},
                             {"contact.sticking", "contact.response.sticking"},
                             {"solver.error", "solver.integrator.error"},
                             {"solver.drag", "solver.integrator.drag"},
                             {"solver.max_newton", "solver.integrator.max_newton"}};

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

template <std::size_t n>
std::string present_path(const OldKey (&table)[n], const std::string& path) {
  for (const OldKey& key : table)
    if (is_instance_of(path, key.old)) return dotted(filled(key.now, key.old, split_path(path)));
  return path;
}

/// The member or element of `value`; null if there is none.
Json* part_of(Json& value, const std::string& part) {
  if (value.is_object() && value.contains(part)) return &value[part];
  if (!value.is_array() || part.find_first_not_of("0123456789") != std::string::npos)
    return nullptr;
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

/// Moves one value. A method that is given by its name becomes an object with the name.
void move_value(LocatedJson& document, const Parts& from, const Parts& to) {
  Json* source = &document.root;
  for (std::size_t i = 0; i + 1 < from.size(); ++i) source = part_of(*source, from[i]);
  Json* target = &document.root;
  for (std::size_t i = 0; i + 1 < to.size(); ++i) {
    Json* next = part_of(*target, to[i]);
    target = next != nullptr ? next : &(*target)[to[i]];
  }
  if (target->is_string()) *target = Json{{"type", *target}};
  if (!target->is_object() && !target->is_null()) return;
  const std::string old_place = place_of(document.root, from);
  if (target->contains(to.back()))
    fail(document, old_place,
         fmt::format("is the old name of \"{0}\", which is there, too; keep \"{0}\"",
                     from.back() == to.back() ? dotted(to) : to.back()));
  (*target)[to.back()] = std::move((*source)[from.back()]);
  source->erase(from.back());
  if (auto origin = document.origin.extract(old_place)) {
    origin.key() = place_of(document.root, to);
    document.origin.insert(std::move(origin));
  }
}

template <std::size_t n>
void move_values(LocatedJson& document, const OldKey (&table)[n]) {
  for (const OldKey& key : table) {
    std::vector<Parts> instances;
    Parts path;
    for_each_instance(document.root, split_path(key.old), path,
                      [&](const Parts& found) { instances.push_back(found); });
    for (const Parts& found : instances)
      move_value(document, found, filled(key.now, key.old, found));
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
  for (const OldKey& key : kMoved)
    if (std::string(key.old).starts_with(section + ".")) names.push_back(split_path(key.old)[1]);
  if (!std::all_of(names.begin(), names.end(), [&](const auto& n) { return group->contains(n); }))
    return;
  const std::vector<MethodOption>& options = registry.at(*named).options();
  for (const std::string& name : names)
    if (std::none_of(options.begin(), options.end(), [&](const auto& o) { return o.name == name; }))
      group->erase(name);
}

}  // namespace

void rename_old_keys(LocatedJson& document) {
  move_values(document, kRenamed);
  remove_empty_layers(document.root);
}

void move_old_options(LocatedJson& document, const Methods& methods) {
  drop_foreign_options(document.root, "contact", "response", methods.responses);
  drop_foreign_options(document.root, "solver", "integrator", methods.integrators);
  move_values(document, kMoved);
}

std::string renamed_path(const std::string& path) { return present_path(kRenamed, path); }

}  // namespace detail

std::string present_key(const std::string& path) {
  return detail::present_path(detail::kMoved, detail::renamed_path(path));
}

}  // namespace selvedge
