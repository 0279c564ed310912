// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace selvedge::detail {

using Json = nlohmann::json;

/// A JSON file and the place of each of its values.
struct LocatedJson {
  std::filesystem::path file;
  Json root;
  /// JSON path such as "geometry[0].cells" to "line 12" or "--set time.frames".
  std::map<std::string, std::string> origin;
};

/// Throws std::invalid_argument with the file, the place of the value at `path` (or of the value
/// that encloses it) and the fault.
[[noreturn]] void fail(const LocatedJson& document, const std::string& path,
                       const std::string& fault);

/// The path of a member or an element of the value at `path`.
std::string join(const std::string& path, const std::string& key);
std::string join(const std::string& path, std::size_t index);

/// Splits "a.0.b" and "a[0].b" alike into a, 0, b.
std::vector<std::string> split_path(const std::string& path);

/// The value of an option of a method: a number, or 1 for true and 0 for false.
double option_value(const Json& j);

/// Reads JSON with // and /* */ comments. Refuses duplicate keys, numbers beyond a double, and
/// more than 64 levels. `what` names the kind of the file in messages.
LocatedJson parse_json_file(const std::filesystem::path& file, const char* what = "scene file");
/// The same for a text; `file` names it in messages, and relative paths in it start at its folder.
LocatedJson parse_json_text(const std::string& text, const std::filesystem::path& file);

/// Applies one `--set`: a value that is not JSON is taken as a string.
void apply(LocatedJson& document, const Override& override_value);

/// Checks the document against the subset of JSON schema that scene.schema.json uses, and adds the
/// defaults of missing keys.
void check_and_complete(LocatedJson& document, const Json& schema);

/// The schema of scene files, made once from the fields of a scene (scene_fields.h).
const Json& scene_schema();

}  // namespace selvedge::detail
