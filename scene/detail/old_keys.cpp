// SPDX-License-Identifier: MIT
#include <selvedge/scene/detail/old_keys.h>

namespace selvedge::detail {
namespace {

void rename_thickness(LocatedJson& document, Json& object, const std::string& path) {
  if (!object.is_object() || !object.contains("thickness")) return;
  const std::string old_path = join(path, "thickness");
  if (object.contains("rest_gap"))
    fail(document, old_path,
         "is the old name of \"rest_gap\", which is there, too; keep \"rest_gap\"");
  object["rest_gap"] = std::move(object["thickness"]);
  object.erase("thickness");
  if (auto origin = document.origin.extract(old_path)) {
    origin.key() = join(path, "rest_gap");
    document.origin.insert(std::move(origin));
  }
}

}  // namespace

void rename_old_keys(LocatedJson& document) {
  if (!document.root.is_object() || !document.root.contains("contact")) return;
  Json& contact = document.root["contact"];
  rename_thickness(document, contact, "contact");
  if (!contact.is_object() || !contact.contains("pairs") || !contact["pairs"].is_array()) return;
  for (std::size_t i = 0; i < contact["pairs"].size(); ++i)
    rename_thickness(document, contact["pairs"][i], join(join("contact", "pairs"), i));
}

}  // namespace selvedge::detail
