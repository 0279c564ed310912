// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <selvedge/scene/detail/field_json.h>
#include <selvedge/scene/internal/scene_text.h>
#include <selvedge/scene/methods.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace selvedge::detail {

namespace {

using Schema = nlohmann::ordered_json;

Schema number(double value) {
  constexpr double largest_whole = 1e15;
  if (value == std::floor(value) && std::abs(value) < largest_whole)
    return static_cast<std::int64_t>(value);
  return value;
}

void add_range(Schema& schema, const ValueRange& range) {
  if (std::isfinite(range.least))
    schema[range.above_least ? "exclusiveMinimum" : "minimum"] = number(range.least);
  if (std::isfinite(range.most)) schema["maximum"] = number(range.most);
}

template <class T>
constexpr const char* text_of() {
  if constexpr (requires { Fields<T>::kText; })
    return Fields<T>::kText;
  else
    return nullptr;
}

std::string sentence(const Key& key) {
  const auto& [x, y] = key.axes;
  if (!x.name.empty()) {
    return fmt::format("{}. Points [{} [{}], {} [{}]], which rise from [0, 0]", key.text, x.name,
                       x.unit, y.name, y.unit) +
           ", with a monotone piecewise cubic in between.";
  }
  return key.unit.empty() ? fmt::format("{}.", key.text)
                          : fmt::format("{} [{}].", key.text, key.unit);
}

/// The schema of an object with exactly the keys that are added.
class ObjectSchema {
 public:
  explicit ObjectSchema(const char* text) {
    if (text != nullptr) schema_["description"] = text;
  }

  /// The key that tells the alternatives of a variant apart.
  void add_type(const char* type) {
    required_.push_back("type");
    properties_["type"] = {{"const", type}, {"type", "string"}};
  }
  /// `initial`: the default; null: it has none.
  void add(const char* name, const Key& key, Schema value, const Json& initial) {
    if (key.required) required_.push_back(name);
    if (!initial.is_null()) value["default"] = Schema::parse(initial.dump());
    value["description"] = sentence(key);
    properties_[name] = std::move(value);
  }
  Schema schema() {
    if (!required_.empty()) schema_["required"] = std::move(required_);
    schema_["properties"] = std::move(properties_);
    return std::move(schema_);
  }

 private:
  Schema schema_{{"type", "object"}, {"additionalProperties", false}};
  Schema required_ = Schema::array(), properties_ = Schema::object();
};

Schema list_of(Schema item, std::size_t shortest, std::size_t longest) {
  Schema schema{{"type", "array"}};
  if (shortest > 0) schema["minItems"] = shortest;
  if (longest < Key{}.longest) schema["maxItems"] = longest;
  schema["items"] = std::move(item);
  return schema;
}

Schema map_of(Schema element) {
  return {{"type", "object"}, {"additionalProperties", std::move(element)}};
}

Schema of_number(const char* type, const ValueRange& range) {
  Schema schema{{"type", type}};
  add_range(schema, range);
  return schema;
}

/// The options of all methods of one family; one with several methods has the widest range.
class FamilyOptions {
 public:
  void add(const std::string& method, const MethodOption& option) {
    const auto [place, is_new] = options_.try_emplace(option.name, option);
    MethodOption& all = place->second;
    if (is_new) {
      order_.push_back(option.name);
    } else {
      all.least = std::min(all.least, option.least);
      all.most = std::max(all.most, option.most);
      all.above_least = all.above_least && option.above_least;
      if (all.kind != option.kind) all.kind = OptionKind::number;
    }
    texts_[option.name][option.meaning].push_back(method);
  }

  Schema properties(const std::string& initial_method) const {
    Schema properties{{"type",
                       {{"type", "string"},
                        {"minLength", 1},
                        {"default", initial_method},
                        {"description", "Name of the method."}}}};
    for (const std::string& name : order_) properties[name] = schema_of(options_.at(name));
    return properties;
  }

 private:
  Schema schema_of(const MethodOption& option) const {
    Schema schema;
    schema["type"] = option.kind == OptionKind::boolean ? "boolean"
                     : option.kind == OptionKind::whole ? "integer"
                                                        : "number";
    if (option.kind != OptionKind::boolean)
      add_range(schema, {option.least, option.most, option.above_least});
    std::string text;
    for (const auto& [meaning, methods] : texts_.at(option.name))
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", some_of(methods), meaning);
    schema["description"] = text + (option.unit.empty() ? "" : " [" + option.unit + "]") + ".";
    return schema;
  }

  static std::string some_of(const std::vector<std::string>& methods) {
    constexpr std::size_t most = 4;
    if (methods.size() <= most) return fmt::format("{}", fmt::join(methods, ", "));
    return fmt::format("{} and {} others", methods.front(), methods.size() - 1);
  }

  std::map<std::string, MethodOption> options_;
  std::vector<std::string> order_;
  std::map<std::string, std::map<std::string, std::vector<std::string>>> texts_;
};

template <class T>
inline constexpr bool kIsGroupList = false;
template <class T>
inline constexpr bool kIsGroupList<std::vector<T>> = HasFields<T> || kIsVariant<T>;

const Schema any_options{
    {"type", "object"},
    {"additionalProperties", {{"oneOf", {{{"type", "number"}}, {{"type", "boolean"}}}}}},
    {"properties", Schema::object()}};

class SchemaBuilder {
 public:
  /// The schema of a struct, or a reference to its definition if it has a name.
  template <HasFields T>
  Schema of_struct() {
    if constexpr (requires { Fields<T>::kName; }) {
      if (is_new(Fields<T>::kName)) define(Fields<T>::kName, object_of<T>());
      return reference_to(Fields<T>::kName);
    } else {
      return object_of<T>();
    }
  }

  template <HasFields T>
  Schema object_of() {
    ObjectSchema object(text_of<T>());
    if constexpr (requires { Fields<T>::kType; }) object.add_type(Fields<T>::kType);
    T usual{};
    Fields<T>::visit([&](const char* name, const auto& member, const Key& key) {
      add_property(object, name, usual, member, key);
    });
    return object.schema();
  }

  const Schema& definitions() const { return definitions_; }

 private:
  /// If it is, keeps its place.
  bool is_new(const char* name) {
    if (definitions_.contains(name)) return false;
    definitions_[name] = nullptr;
    return true;
  }
  void define(const char* name, Schema schema) { definitions_[name] = std::move(schema); }
  static Schema reference_to(const std::string& name) { return {{"$ref", "#/$defs/" + name}}; }
  static Schema any_object() { return {{"type", "object"}}; }

  /// The default of a key; null: it has none. Groups and lists of them are empty.
  template <class T>
  static Json initial_of(const T& value, const Key& key) {
    if constexpr (HasFields<T> || kIsMap<T>)
      return Json::object();
    else if constexpr (kIsOptional<T>)
      return {};
    else if constexpr (kIsGroupList<T>)
      return Json::array();
    else
      return json_of(value, key);
  }

  template <class T, class Member>
  void add_property(ObjectSchema& object, const char* name, T& usual, const Member& member,
                    const Key& key) {
    if constexpr (std::is_invocable_v<Member, T&>)
      add_stored(object, name, std::invoke(member, usual), key);
    else
      object.add(name, key, of_value<typename Member::Value>(key, {}),
                 member.initial ? initial_of(*member.initial, key) : Json());
  }
  template <class T>
  void add_stored(ObjectSchema& object, const char* name, const T& usual, const Key& key) {
    object.add(name, key, of_value<T>(key, usual),
               key.completed && !key.required ? initial_of(usual, key) : Json());
  }

  template <class T>
  Schema of_value(const Key& key, const T& usual) {
    if constexpr (std::is_same_v<T, bool> || std::is_enum_v<T>) {
      return of_words(key);
    } else if constexpr (std::is_arithmetic_v<T>) {
      return of_number(std::is_integral_v<T> ? "integer" : "number", key.range);
    } else if constexpr (std::is_same_v<T, std::string> ||
                         std::is_same_v<T, std::filesystem::path>) {
      return of_text(key);
    } else if constexpr (std::is_same_v<T, Vec3>) {
      return of_vector(key);
    } else if constexpr (std::is_same_v<T, Eigen::Quaterniond>) {
      return of_rotation();
    } else if constexpr (kIsMethodView<T>) {
      return of_method(usual.family, usual.name, usual.or_switch);
    } else if constexpr (kIsFormatsView<T>) {
      return of_formats(key);
    } else if constexpr (std::is_same_v<T, MethodOptions>) {
      return any_options;
    } else if constexpr (kIsOptional<T>) {
      return of_value<typename T::value_type>(key, {});
    } else if constexpr (kIsMap<T>) {
      return map_of(of_element<typename T::mapped_type>(key));
    } else if constexpr (kIsVariant<T>) {
      return of_variant(key, static_cast<const T*>(nullptr));
    } else if constexpr (kIsPairView<T>) {
      return of_list<std::remove_cvref_t<decltype(usual.a)>>(key, 2, 2);
    } else if constexpr (kIsArray<T>) {
      return of_list<typename T::value_type>(key, usual.size(), usual.size());
    } else if constexpr (kIsVector<T>) {
      return of_list<typename T::value_type>(key, key.shortest, key.longest);
    } else if constexpr (std::is_same_v<T, MonotoneCurve>) {
      return of_curve();
    } else if constexpr (std::is_same_v<T, FabricSheet>) {
      return any_object();
    } else {
      return of_struct<T>();
    }
  }

  static Schema of_words(const Key& key) {
    if (key.words.empty()) return {{"type", "boolean"}};
    Schema words = Schema::array();
    for (const std::string_view word : key.words)
      if (!word.empty()) words.push_back(word);
    return {{"type", "string"}, {"enum", words}};
  }

  static Schema of_text(const Key& key) {
    if (!key.words.empty()) return of_words(key);
    Schema schema{{"type", "string"}};
    if (key.shortest > 0) schema["minLength"] = key.shortest;
    if (key.longest < Key{}.longest) schema["maxLength"] = key.longest;
    return schema;
  }

  /// An element of a list has the range and the words of its key; texts are not empty.
  template <class T>
  Schema of_element(const Key& key) {
    Key element{.range = key.range, .words = key.words};
    if constexpr (std::is_same_v<T, std::string>) element.shortest = 1;
    if constexpr (kIsVector<T>) element.longest = key.longest;
    return of_value<T>(element, {});
  }

  template <class T>
  Schema of_list(const Key& key, std::size_t shortest, std::size_t longest) {
    return list_of(of_element<T>(key), shortest, longest);
  }

  Schema of_vector(const Key& key) {
    const bool usual = !std::isfinite(key.range.least);
    Schema schema = of_list<double>({.range = usual ? kCoordinate : key.range}, 3, 3);
    if (!usual) return schema;
    define("vec3", std::move(schema));
    return reference_to("vec3");
  }

  Schema of_rotation() {
    definitions_["rotation"] = {
        {"description", "One rotation, or a list of them applied one after the other."},
        {"oneOf",
         {of_struct<AxisAngle>(),
          {{"type", "array"}, {"maxItems", 10}, {"items", of_struct<AxisAngle>()}}}}};
    return reference_to("rotation");
  }

  Schema of_curve() {
    Schema point = of_list<double>({.range = {0}}, 2, 2);
    return {{"type", "array"}, {"minItems", 2}, {"maxItems", 100000}, {"items", point}};
  }

  template <class... T>
  Schema of_variant(const Key& key, const std::variant<T...>*) {
    Schema alternatives = Schema::array();
    (add_alternative<T>(alternatives, key), ...);
    return {{"oneOf", alternatives}};
  }
  template <class T>
  void add_alternative(Schema& alternatives, const Key& key) {
    if constexpr (std::is_same_v<T, std::string>)
      alternatives.push_back(of_name(key));
    else
      alternatives.push_back(of_value<T>(key, {}));
  }
  static Schema of_name(const Key& key) {
    return key.words.empty() ? Schema{{"type", "string"}, {"minLength", 1}} : of_words(key);
  }

  static Schema of_method(std::size_t family, const std::string& initial, bool or_switch) {
    FamilyOptions options;
    static const Methods methods;
    for_each_family(methods, [&](const std::string& key, const auto& registry) {
      if (key != kMethodKeys[family]) return;
      for (const auto& [name, entry] : registry)
        for (const MethodOption& option : entry.options()) options.add(name, option);
    });
    Schema object = any_options;
    object["description"] =
        "The method and its options; `selvedge list` gives the options of each method, with "
        "defaults and ranges.";
    object["properties"] = options.properties(initial);
    Schema alternatives = Schema::array({{{"type", "string"}, {"minLength", 1}}});
    if (or_switch) alternatives.push_back({{"type", "boolean"}});
    alternatives.push_back(std::move(object));
    return {{"oneOf", alternatives}};
  }

  static Schema of_formats(const Key& key) {
    Schema object = any_options;
    object["required"] = {"type"};
    object["description"] = "The format and its options.";
    object["properties"]["type"] = {
        {"type", "string"}, {"minLength", 1}, {"description", "Name of the format."}};
    return {{"type", "array"},
            {"maxItems", key.longest},
            {"items", {{"oneOf", {{{"type", "string"}, {"minLength", 1}}, object}}}}};
  }

  Schema definitions_ = Schema::object();
};

Schema make_schema() {
  SchemaBuilder builder;
  const Schema scene = builder.object_of<Scene>();
  Schema schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                {"$id", "https://selvedge.invalid/scene.schema.json"},
                {"title", "selvedge scene"},
                {"description",
                 "A cloth, what it falls on, and how it is simulated. Lengths in metres, z up. "
                 "Written by `selvedge list --scene schema`."}};
  schema.update(scene);
  schema["$defs"] = builder.definitions();
  return schema;
}

// -- text ----------------------------------------------------------------------------------------

/// Whether something within `schema` is described, so that it needs a line of its own.
bool has_described_part(const Schema& schema) {
  return std::any_of(schema.begin(), schema.end(), [](const Schema& part) {
    return part.is_structured() &&
           ((part.is_object() && part.contains("description")) || has_described_part(part));
  });
}

void write(const Schema& schema, const std::string& indent, std::string& text) {
  if (!schema.is_structured() || schema.empty()) {
    text += schema.dump();
    return;
  }
  const bool wide = has_described_part(schema), object = schema.is_object();
  const std::string inner = indent + "  ";
  text += object ? "{" : "[";
  for (auto part = schema.begin(); part != schema.end(); ++part) {
    if (part != schema.begin()) text += wide ? "," : ", ";
    if (wide) text += "\n" + inner;
    if (object) text += Schema(part.key()).dump() + ": ";
    write(*part, inner, text);
  }
  if (wide) text += "\n" + indent;
  text += object ? "}" : "]";
}

// -- table ---------------------------------------------------------------------------------------

/// Adds the names of the keys within a part of a scene, each once.
void add_names(const Schema& schema, const Schema& given, std::vector<std::string>& names) {
  if (given.contains("$ref"))
    return add_names(
        schema, schema.at(Schema::json_pointer(given["$ref"].get<std::string>().substr(1))), names);
  for (const Schema& alternative : given.value("oneOf", Schema::array()))
    add_names(schema, alternative, names);
  for (const char* inner : {"items", "additionalProperties"})
    if (given.contains(inner) && given[inner].is_object()) add_names(schema, given[inner], names);
  const Schema properties = given.value("properties", Schema::object());
  for (const auto& [name, property] : properties.items())
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

const Json& scene_schema() {
  static const Json schema = Json::parse(make_schema().dump());
  return schema;
}

}  // namespace selvedge::detail

namespace selvedge {

std::string scene_schema_text() {
  std::string text;
  detail::write(detail::make_schema(), "", text);
  return text + "\n";
}

std::string scene_table_text() {
  const auto schema = detail::make_schema();
  std::string text = "| part | content | keys |\n| --- | --- | --- |\n";
  for (const auto& [name, part] : schema["properties"].items()) {
    std::vector<std::string> names;
    detail::add_names(schema, part, names);
    for (std::string& key : names) key = "`" + key + "`";
    text += fmt::format("| `{}` | {} | {} |\n", name, part["description"].get<std::string>(),
                        fmt::join(names, ", "));
  }
  return text;
}

}  // namespace selvedge
