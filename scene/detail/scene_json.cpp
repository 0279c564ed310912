// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/json_value.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/scene/detail/old_keys.h>
#include <selvedge/scene/detail/scene_json.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace selvedge::detail {

namespace {

/// Bytes. Scenes are written by hand or by small programs, so a larger file is something else.
constexpr std::uintmax_t largest_file = std::uintmax_t{64} << 20;
/// Scenes need 8 levels; the bound keeps recursion and paths short.
constexpr std::size_t deepest_level = 64;

/// Counts lines while the parser reads characters, so that every value has a place.
struct LineCount {
  std::size_t now = 1, before_last = 1;  ///< before_last: without the last character read
};

class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, LineCount* lines) : at_(at), lines_(lines) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    lines_->before_last = lines_->now;
    lines_->now += *at_ == '\n';
    ++at_;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator old = *this;
    ++*this;
    return old;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }

 private:
  const char* at_;
  LineCount* lines_;
};

/// Builds the document from the parser's events.
class Builder : public nlohmann::json_sax<Json> {
 public:
  Builder(LocatedJson& document, const LineCount& lines) : document_(document), lines_(lines) {}

  bool null() override { return add(nullptr, lines_.now) != nullptr; }
  bool boolean(bool value) override { return add(value, lines_.now) != nullptr; }
  // The parser reads one character beyond a number to find its end.
  bool number_integer(std::int64_t value) override {
    return add(value, lines_.before_last) != nullptr;
  }
  bool number_unsigned(std::uint64_t value) override {
    return add(value, lines_.before_last) != nullptr;
  }
  bool number_float(double value, const std::string&) override {
    return add(value, lines_.before_last) != nullptr;
  }
  bool string(std::string& value) override { return add(value, lines_.now) != nullptr; }
  bool binary(Json::binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(std::string& name) override {
    if (has_control_character(name))
      throw std::invalid_argument(
          fmt::format("{}, line {}: the key \"{}\" has a control character; remove it",
                      document_.file.string(), lines_.now, printable(name)));
    const std::string path = join(open_.back().path, name);
    if (open_.back().value->contains(name)) {
      const auto first = document_.origin.find(path);
      throw std::invalid_argument(
          fmt::format("{}, line {}, {}: the key is there twice, first in {}; keep one of them",
                      document_.file.string(), lines_.now, path, first->second));
    }
    key_ = name;
    return true;
  }

  bool parse_error(std::size_t, const std::string&, const Json::exception& error) override {
    throw std::invalid_argument(fmt::format("{}, line {}: not valid JSON: {}",
                                            document_.file.string(), lines_.now,
                                            json_message(error.what())));
  }

 private:
  struct Level {
    Json* value;
    std::string path;
  };

  Json* add(Json value, std::size_t line) {
    Json* place = &document_.root;
    std::string path;
    if (!open_.empty()) {
      Level& parent = open_.back();
      if (parent.value->is_array()) {
        path = join(parent.path, parent.value->size());
        place = &parent.value->emplace_back();
      } else {
        path = join(parent.path, key_);
        place = &(*parent.value)[key_];
      }
    }
    *place = std::move(value);
    document_.origin[path] = fmt::format("line {}", line);
    path_ = std::move(path);
    return place;
  }

  bool open(Json value) {
    if (open_.size() == deepest_level)
      throw std::invalid_argument(fmt::format("{}, line {}: more than {} levels of brackets",
                                              document_.file.string(), lines_.now, deepest_level));
    Json* place = add(std::move(value), lines_.now);
    open_.push_back({place, path_});
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  LocatedJson& document_;
  const LineCount& lines_;
  std::vector<Level> open_;
  std::string key_, path_;
};

std::string read_text(const std::filesystem::path& file, const char* what) {
  std::string text =
      read_whole_file(file, {.what = what, .most_bytes = largest_file, .pipes = true});
  if (std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isspace(c); }))
    throw std::invalid_argument(file.string() + ": the file is empty; a " + what +
                                " has at least a JSON object, such as {\"geometry\": [{}]}");
  return text;
}

[[noreturn]] void fail_override(const LocatedJson& document, const Override& set,
                                const std::string& fault) {
  throw std::invalid_argument(
      fmt::format("{}, --set {}={}: {}", document.file.string(), set.path, set.value, fault));
}

/// An element by number or by its "name".
std::size_t find_element(const LocatedJson& document, const Override& set, const Json& array,
                         const std::string& part) {
  for (std::size_t i = 0; i < array.size(); ++i)
    if (array[i].is_object() && array[i].contains("name") && array[i]["name"] == part) return i;
  const bool digits =
      !part.empty() && part.size() < 10 &&
      std::all_of(part.begin(), part.end(), [](unsigned char c) { return std::isdigit(c); });
  const std::size_t index = digits ? std::stoul(part) : array.size();
  if (index >= array.size())
    fail_override(
        document, set,
        fmt::format("there is no element \"{}\" in a list of {}; count from 0 or give a name", part,
                    array.size()));
  return index;
}

bool names_method(const std::string& path) {
  return std::any_of(kMethodKeys.begin(), kMethodKeys.end(),
                     [&](const char* key) { return is_instance_of(path, key); });
}

std::string quoted_list(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "\"" : ", \"") + word + "\"";
  return list;
}

/// The user's value, shortened to fit a sentence.
std::string shown(const Json& value) {
  constexpr std::size_t longest = 60;
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > longest) text = text.substr(0, longest - 3) + "...";
  return text;
}

/// A text with control characters, in quotes and shortened; JSON would write them in another way.
std::string in_short_quotes(const std::string& text) {
  constexpr std::size_t longest = 60;
  const std::string all = printable(text);
  return "\"" + (all.size() > longest ? all.substr(0, longest - 3) + "..." : all) + "\"";
}

std::string type_in_words(const std::string& type) {
  if (type == "object") return "an object {...}";
  if (type == "array") return "a list [...]";
  if (type == "integer") return "a whole number";
  if (type == "boolean") return "true or false";
  return "a " + type;
}

bool has_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "number") return value.is_number();
  return value.is_number_integer() ||
         (value.is_number_float() && value.get<double>() == std::floor(value.get<double>()));
}

/// Traverses document and schema together.
class Checker {
 public:
  Checker(LocatedJson& document, const Json& schema) : document_(document), schema_(schema) {}

  void check(Json& value, const Json& given_schema, const std::string& path,
             const Json* alternatives = nullptr) {
    const Json& schema = resolve(given_schema);
    if (schema.contains("oneOf")) return check_one_of(value, schema["oneOf"], path);
    if (schema.contains("type")) {
      const auto type = schema["type"].get<std::string>();
      if (!has_type(value, type)) {
        refuse_old_members(value, path);
        fail(document_, path, fmt::format("must be {}, is {}", type_in_words(type), shown(value)));
      }
    }
    if (value.is_number()) check_number(value, schema, path);
    if (value.is_string()) check_string(value, schema, path);
    if (value.is_array()) check_array(value, schema, path);
    if (value.is_object()) check_object(value, schema, path, alternatives);
  }

 private:
  const Json& resolve(const Json& schema) const {
    const Json* s = &schema;
    while (s->contains("$ref"))
      s = &schema_.at(Json::json_pointer((*s)["$ref"].get<std::string>().substr(1)));
    return *s;
  }

  void check_number(const Json& value, const Json& schema, const std::string& path) const {
    const double x = value.get<double>();
    const auto limit = [&](const char* key) { return schema[key].get<double>(); };
    const auto refuse = [&](const char* relation, const char* key) {
      fail(document_, path,
           fmt::format("must be {} {}, is {}", relation, limit(key), shown(value)));
    };
    if (!std::isfinite(x)) fail(document_, path, "must be a finite number");
    if (schema.contains("minimum") && x < limit("minimum")) refuse("at least", "minimum");
    if (schema.contains("maximum") && x > limit("maximum")) refuse("at most", "maximum");
    if (schema.contains("exclusiveMinimum") && x <= limit("exclusiveMinimum"))
      refuse("greater than", "exclusiveMinimum");
  }

  void check_string(const Json& value, const Json& schema, const std::string& path) const {
    const auto text = value.get<std::string>();
    if (schema.contains("enum")) {
      const auto known = schema["enum"].get<std::vector<std::string>>();
      if (std::find(known.begin(), known.end(), text) == known.end())
        fail(document_, path,
             fmt::format("unknown value {}; nearest is \"{}\", known are {}", shown(value),
                         nearest_word(text, known), quoted_list(known)));
    }
    if (text.size() < schema.value("minLength", std::size_t{0}))
      fail(document_, path, "must not be empty");
    if (text.size() > schema.value("maxLength", std::numeric_limits<std::size_t>::max()))
      fail(document_, path,
           fmt::format("must have at most {} characters", schema["maxLength"].get<std::size_t>()));
    const bool is_prose = path == "description";
    if (is_prose ? text.find('\0') != std::string::npos : has_control_character(text))
      fail(document_, path,
           fmt::format("must not contain control characters, is {}", in_short_quotes(text)));
  }

  void check_array(Json& value, const Json& schema, const std::string& path) {
    const std::size_t low = schema.value("minItems", std::size_t{0});
    const std::size_t high = schema.value("maxItems", std::numeric_limits<std::size_t>::max());
    if (value.size() < low || value.size() > high) {
      const std::string wanted = low == high          ? fmt::format("exactly {}", low)
                                 : value.size() < low ? fmt::format("at least {}", low)
                                                      : fmt::format("at most {}", high);
      fail(document_, path,
           fmt::format("must have {} {}, has {}", wanted,
                       wanted.ends_with(" 1") ? "element" : "elements", value.size()));
    }
    for (std::size_t i = 0; i < value.size(); ++i) check(value[i], schema["items"], join(path, i));
  }

  void check_object(Json& value, const Json& schema, const std::string& path,
                    const Json* alternatives) {
    static const Json none = Json::object();
    const Json& properties = schema.contains("properties") ? schema["properties"] : none;
    for (auto& [key, member] : value.items()) {
      if (properties.contains(key)) continue;
      if (!schema.contains("additionalProperties") || !schema["additionalProperties"].is_object())
        refuse_key(key, value, properties, join(path, key), alternatives);
      check(member, schema["additionalProperties"], join(path, key));
    }
    if (schema.contains("required"))
      for (const Json& key : schema["required"])
        if (!value.contains(key.get<std::string>()))
          fail(document_, path, fmt::format("needs the key \"{}\"", key.get<std::string>()));
    for (const auto& [key, property] : properties.items()) {
      if (!value.contains(key) && property.contains("default")) value[key] = property["default"];
      if (value.contains(key)) check(value[key], property, join(path, key));
    }
  }

  /// An object in the place of a value that was one in older versions.
  void refuse_old_members(const Json& value, const std::string& path) const {
    if (!value.is_object()) return;
    for (const auto& [key, member] : value.items())
      if (const std::string answer = answer_to_old_key(join(path, key)); !answer.empty())
        fail(document_, join(path, key), answer);
  }

  [[noreturn]] void refuse_key(const std::string& key, const Json& value, const Json& properties,
                               const std::string& path, const Json* alternatives) const {
    if (const std::string answer = answer_to_old_key(path); !answer.empty())
      fail(document_, path, answer);
    std::vector<std::string> known;
    for (const auto& [name, property] : properties.items()) known.push_back(name);
    if (alternatives != nullptr)
      for (const Json& other : *alternatives) {
        const Json& schema = resolve(other);
        if (schema.contains("properties") && schema["properties"].contains(key))
          fail(document_, path,
               fmt::format("cannot be combined with the other keys here; known are {}",
                           quoted_list(known)));
      }
    // A key that the file has cannot be the intended one, unless --set was to replace it.
    const auto origin = document_.origin.find(path);
    const bool is_set = origin != document_.origin.end() && origin->second.starts_with("--set ");
    std::vector<std::string> free;
    for (const std::string& name : known)
      if (is_set || !value.contains(name)) free.push_back(name);
    fail(document_, path,
         fmt::format("unknown key; nearest is \"{}\", known are {}",
                     nearest_word(key, free.empty() ? known : free), quoted_list(known)));
  }

  /// Chooses the alternative of a value: by JSON type, by a constant such as "type", or by the key
  /// that only this alternative requires.
  void check_one_of(Json& value, const Json& alternatives, const std::string& path) {
    std::vector<const Json*> fitting;
    std::string types;
    for (const Json& alternative : alternatives) {
      const Json& schema = resolve(alternative);
      const auto type = schema["type"].get<std::string>();
      if (has_type(value, type)) fitting.push_back(&schema);
      if (types.find(type_in_words(type)) == std::string::npos)
        types += (types.empty() ? "" : " or ") + type_in_words(type);
    }
    if (fitting.empty())
      fail(document_, path, fmt::format("must be {}, is {}", types, shown(value)));
    if (!value.is_object()) return check(value, *fitting.front(), path);
    refuse_wrapped_text(value, alternatives, fitting, path);
    check(value, choose_object(value, fitting, path), path, &alternatives);
  }

  /// An object such as {"file": "box.obj"} where the text alone is wanted.
  void refuse_wrapped_text(const Json& value, const Json& alternatives,
                           const std::vector<const Json*>& fitting, const std::string& path) const {
    const bool or_text = std::any_of(
        alternatives.begin(), alternatives.end(),
        [&](const Json& alternative) { return resolve(alternative)["type"] == "string"; });
    if (!or_text || fitting.size() != 1 || !fitting.front()->contains("required")) return;
    std::vector<std::string> keys;
    for (const Json& key : (*fitting.front())["required"]) keys.push_back(key.get<std::string>());
    if (std::any_of(keys.begin(), keys.end(), [&](const auto& k) { return value.contains(k); }))
      return;
    std::string text = "\"...\"";
    for (const auto& [key, member] : value.items())
      if (member.is_string()) text = shown(member);
    const std::string key = path.substr(path.find_last_of('.') + 1);
    fail(document_, path,
         fmt::format("must be a string, such as \"{}\": {}, or an object with {}; is {}", key, text,
                     quoted_list(keys), shown(value)));
  }

  const Json& choose_object(const Json& value, const std::vector<const Json*>& fitting,
                            const std::string& path) const {
    if (is_tagged(*fitting.front())) return choose_tagged(value, fitting, path);
    std::vector<std::string> keys;
    for (const Json* schema : fitting) {
      const Json required = schema->value("required", Json::array());
      bool all = true;
      for (const Json& key : required) all = all && value.contains(key.get<std::string>());
      if (all) return *schema;
      keys.push_back(required.front().get<std::string>());
    }
    if (fitting.size() == 1) return *fitting.front();
    std::string there;
    for (const auto& [key, member] : value.items()) {
      const std::string near = nearest_word(key, keys);
      if (!near.empty() && near[0] == key[0])
        there = fmt::format("; is \"{}\" meant for \"{}\"?", key, near);
    }
    fail(document_, path, fmt::format("needs one of the keys {}{}", quoted_list(keys), there));
  }

  static bool is_tagged(const Json& schema) {
    return schema.contains("properties") && schema["properties"].contains("type") &&
           schema["properties"]["type"].contains("const");
  }

  const Json& choose_tagged(const Json& value, const std::vector<const Json*>& fitting,
                            const std::string& path) const {
    std::vector<std::string> known;
    for (const Json* schema : fitting) {
      known.push_back((*schema)["properties"]["type"]["const"].get<std::string>());
      if (value.contains("type") && value["type"] == known.back()) return *schema;
    }
    if (!value.contains("type"))
      fail(document_, path, fmt::format("needs the key \"type\", one of {}", quoted_list(known)));
    const std::string word = value["type"].is_string() ? value["type"].get<std::string>() : "";
    fail(document_, join(path, "type"),
         fmt::format("unknown value {}; nearest is \"{}\", known are {}", shown(value["type"]),
                     nearest_word(word, known), quoted_list(known)));
  }

  LocatedJson& document_;
  const Json& schema_;
};

}  // namespace

void fail(const LocatedJson& document, const std::string& path, const std::string& fault) {
  std::string where = path;
  while (!where.empty() && !document.origin.contains(where)) {
    const auto cut = where.find_last_of(".[");
    where.erase(cut == std::string::npos ? 0 : cut);
  }
  const auto origin = document.origin.find(where);
  std::string place = origin == document.origin.end() ? "" : ", " + origin->second;
  if (!path.empty()) place += ", " + path;
  throw std::invalid_argument(document.file.string() + place + ": " + fault);
}

std::string join(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

std::string join(const std::string& path, std::size_t index) {
  return fmt::format("{}[{}]", path, index);
}

std::vector<std::string> split_path(const std::string& path) {
  std::vector<std::string> parts(1);
  for (const char c : path) {
    if (c == ']') continue;
    if (c == '.' || c == '[')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

double option_value(const Json& j) {
  return j.is_boolean() ? (j.get<bool>() ? 1.0 : 0.0) : j.get<double>();
}

LocatedJson parse_json_file(const std::filesystem::path& file, const char* what) {
  return parse_json_text(read_text(file, what), file);
}

LocatedJson parse_json_text(const std::string& text, const std::filesystem::path& file) {
  LocatedJson document{file, {}, {}};
  LineCount lines;
  Builder builder(document, lines);
  constexpr bool strict = true, ignore_comments = true;
  Json::sax_parse(CountingIterator(text.data(), &lines),
                  CountingIterator(text.data() + text.size(), &lines), &builder,
                  nlohmann::detail::input_format_t::json, strict, ignore_comments);
  return document;
}

void apply(LocatedJson& document, const Override& set) {
  Json* place = &document.root;
  std::string path;
  for (const std::string& part : split_path(set.path)) {
    if (part.empty()) fail_override(document, set, "the path has an empty part");
    // The name of a method makes room for its options.
    if (place->is_string() && names_method(path)) *place = Json{{"type", *place}};
    if (place->is_array()) {
      const std::size_t index = find_element(document, set, *place, part);
      path = join(path, index);
      place = &(*place)[index];
    } else if (place->is_object() || place->is_null()) {
      path = join(path, part);
      place = &(*place)[part];
    } else {
      fail_override(document, set,
                    fmt::format("{} is {} and has no part \"{}\"", path, shown(*place), part));
    }
  }
  *place = Json::parse(set.value, nullptr, /*allow_exceptions=*/false);
  if (place->is_discarded()) *place = set.value;
  const std::string below = path + ".", element = path + "[";
  std::erase_if(document.origin, [&](const auto& entry) {
    return entry.first.starts_with(below) || entry.first.starts_with(element);
  });
  document.origin[path] = "--set " + set.path;
}

void check_and_complete(LocatedJson& document, const Json& schema) {
  Checker(document, schema).check(document.root, schema, "");
}

}  // namespace selvedge::detail
