// SPDX-License-Identifier: MIT
#include <selvedge/scene/detail/scene_fields.h>
#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/scene.h>

#include <algorithm>
#include <map>
#include <set>

namespace selvedge {
namespace {

using detail::Json;

/// Collects paths and values; merges the alternatives of one key.
class KeyCollector {
 public:
  explicit KeyCollector(const Json& schema) : schema_(schema) {}

  void visit(const Json& given, const std::string& path) {
    const Json& schema = resolve(given);
    if (schema.contains("oneOf"))
      for (const Json& alternative : schema["oneOf"]) visit(alternative, path);
    add_words(schema, path);
    const std::string front = path.empty() ? "" : path + ".";
    if (schema.contains("properties"))
      for (const auto& [name, property] : schema["properties"].items()) {
        keys_[front + name];
        visit(property, front + name);
      }
    if (schema.contains("items")) visit(schema["items"], front + "*");
    // Beside named properties they are options of methods that a program registers itself.
    if (!schema.contains("properties") && schema.contains("additionalProperties") &&
        schema["additionalProperties"].is_object())
      visit(schema["additionalProperties"], front + "*");
  }

  std::vector<SceneKey> keys() const {
    std::vector<SceneKey> keys;
    for (const auto& [path, words] : keys_) keys.push_back({path, {words.begin(), words.end()}});
    return keys;
  }

 private:
  const Json& resolve(const Json& schema) const {
    const Json* s = &schema;
    while (s->contains("$ref"))
      s = &schema_.at(Json::json_pointer((*s)["$ref"].get<std::string>().substr(1)));
    return *s;
  }

  void add_words(const Json& schema, const std::string& path) {
    if (schema.contains("enum"))
      for (const Json& word : schema["enum"])
        if (word.is_string()) keys_[path].insert(word.get<std::string>());
    if (schema.value("type", "") == "boolean") keys_[path].insert({"false", "true"});
  }

  const Json& schema_;
  std::map<std::string, std::set<std::string>> keys_;
};

}  // namespace

namespace detail {

constexpr const char* kSelections =
    ": a side of a grid, x0, x1, y0 or y1, at its lowest or highest x or y before it is placed; a "
    "corner, such as x0y1; or a list of these and of numbers of vertices from 0, of a grid "
    "j·(cells_x+1)+i";

std::string_view selection_text() {
  static const std::string text = std::string("Which particles") + kSelections;
  return text;
}

std::string_view row_text() {
  static const std::string text =
      std::string(
          "Which particles, in the order of their numbers or, if only numbers are listed, of the "
          "list") +
      kSelections;
  return text;
}

}  // namespace detail

std::vector<SceneKey> scene_keys() {
  const Json& schema = detail::scene_schema();
  KeyCollector collector(schema);
  collector.visit(schema, "");
  return collector.keys();
}

bool is_instance_of(const std::string& path, const std::string& key) {
  const auto a = detail::split_path(path), b = detail::split_path(key);
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(),
      [](const auto& part, const auto& pattern) { return pattern == "*" || part == pattern; });
}

}  // namespace selvedge
