// SPDX-License-Identifier: MIT
#include <selvedge/scene/detail/old_keys.h>

namespace selvedge::detail {
namespace {

void move_origin(LocatedJson& document, const std::string& from, const std::string& to) {
  if (auto origin = document.origin.extract(from)) {
    origin.key() = to;
    document.origin.insert(std::move(origin));
  }
}

void rename_thickness(LocatedJson& document, Json& object, const std::string& path) {
  if (!object.is_object() || !object.contains("thickness")) return;
  const std::string old_path = join(path, "thickness");
  if (object.contains("rest_gap"))
    fail(document, old_path,
         "is the old name of \"rest_gap\", which is there, too; keep \"rest_gap\"");
  object["rest_gap"] = std::move(object["thickness"]);
  object.erase("thickness");
  move_origin(document, old_path, join(path, "rest_gap"));
}

void rename_layers(LocatedJson& document, Json& geometry, const std::string& path) {
  if (!geometry.is_object() || !geometry.contains("layers")) return;
  Json& layers = geometry["layers"];
  Json& pattern = geometry["pattern"];  // null if it is left out
  if (pattern.is_string()) pattern = Json{{"type", pattern}};
  if (!layers.is_object() || !(pattern.is_object() || pattern.is_null())) return;
  for (auto& [key, value] : layers.items()) {
    const std::string old_path = join(join(path, "layers"), key);
    if (pattern.contains(key))
      fail(document, old_path,
           "is the old place of an option that \"pattern\" has, too; keep that of \"pattern\"");
    pattern[key] = std::move(value);
    move_origin(document, old_path, join(join(path, "pattern"), key));
  }
  geometry.erase("layers");
}

}  // namespace

void rename_old_keys(LocatedJson& document) {
  if (!document.root.is_object()) return;
  if (Json& root = document.root; root.contains("geometry") && root["geometry"].is_array())
    for (std::size_t i = 0; i < root["geometry"].size(); ++i)
      rename_layers(document, root["geometry"][i], join("geometry", i));
  if (!document.root.contains("contact")) return;
  Json& contact = document.root["contact"];
  rename_thickness(document, contact, "contact");
  if (!contact.is_object() || !contact.contains("pairs") || !contact["pairs"].is_array()) return;
  for (std::size_t i = 0; i < contact["pairs"].size(); ++i)
    rename_thickness(document, contact["pairs"][i], join(join("contact", "pairs"), i));
}

}  // namespace selvedge::detail
