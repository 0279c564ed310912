// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/base/internal/whole_number.h>

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace selvedge {

/// A value of a document that has another type or range than its reader needs. The message begins
/// with the place of the value; the reader adds the file before it and the remedy behind it.
struct JsonFault : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// A value of a JSON document and its place in it, such as "result.flags[2]". Each function throws
/// JsonFault if the value has another type or range. Json is one of nlohmann::basic_json, whose
/// own functions throw errors without a place.
template <class Json>
class JsonValue {
 public:
  explicit JsonValue(const Json& json, std::string place = "")
      : json_(&json), place_(std::move(place)) {}

  const Json& json() const { return *json_; }
  const std::string& place() const { return place_; }

  /// The member of an object, which must be there.
  JsonValue operator[](const std::string& key) const {
    if (!json_->is_object()) refuse("an object {...}");
    const auto found = json_->find(key);
    if (found == json_->end()) throw JsonFault(place_of(key) + ": is missing");
    return JsonValue(*found, place_of(key));
  }

  bool has(const std::string& key) const {
    if (!json_->is_object()) refuse("an object {...}");
    return json_->contains(key);
  }

  /// The element of a list, which must be there.
  JsonValue operator[](std::size_t index) const {
    if (!json_->is_array()) refuse("a list [...]");
    if (index >= json_->size())
      throw JsonFault(place_ + ": has " + std::to_string(json_->size()) + " elements, not " +
                      std::to_string(index + 1) + " or more");
    return JsonValue((*json_)[index], place_ + "[" + std::to_string(index) + "]");
  }

  std::vector<JsonValue> list() const {
    if (!json_->is_array()) refuse("a list [...]");
    std::vector<JsonValue> values;
    for (std::size_t i = 0; i < json_->size(); ++i) values.push_back((*this)[i]);
    return values;
  }

  std::vector<std::pair<std::string, JsonValue>> members() const {
    if (!json_->is_object()) refuse("an object {...}");
    std::vector<std::pair<std::string, JsonValue>> values;
    for (const auto& [key, value] : json_->items())
      values.emplace_back(key, JsonValue(value, place_of(key)));
    return values;
  }

  std::string text() const {
    if (!json_->is_string()) refuse("a string");
    return json_->template get<std::string>();
  }
  std::string text_or(const std::string& key, const std::string& otherwise) const {
    return has(key) ? (*this)[key].text() : otherwise;
  }

  bool flag() const {
    if (!json_->is_boolean()) refuse("true or false");
    return json_->template get<bool>();
  }
  bool flag_or(const std::string& key, bool otherwise) const {
    return has(key) ? (*this)[key].flag() : otherwise;
  }

  /// A finite number.
  double number() const {
    if (!json_->is_number() || !std::isfinite(json_->template get<double>()))
      refuse("a finite number");
    return json_->template get<double>();
  }
  double number_or(const std::string& key, double otherwise) const {
    return has(key) ? (*this)[key].number() : otherwise;
  }

  std::vector<double> numbers() const {
    std::vector<double> all;
    for (const JsonValue& value : list()) all.push_back(value.number());
    return all;
  }

  template <std::integral T>
  T whole(T low = std::numeric_limits<T>::min(), T high = std::numeric_limits<T>::max()) const {
    if (const auto number = whole_number<T>(*json_, low, high)) return *number;
    refuse("a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  }

  template <std::integral T>
  std::vector<T> wholes() const {
    std::vector<T> all;
    for (const JsonValue& value : list()) all.push_back(value.template whole<T>());
    return all;
  }

  /// "PLACE: must be WANTED, is VALUE"
  [[noreturn]] void refuse(const std::string& wanted) const {
    constexpr std::size_t longest = 60;
    std::string shown = printable(json_->dump(-1, ' ', true, Json::error_handler_t::replace));
    if (shown.size() > longest) shown = shown.substr(0, longest - 3) + "...";
    throw JsonFault((place_.empty() ? std::string("the document") : place_) + ": must be " +
                    wanted + ", is " + shown);
  }

 private:
  std::string place_of(const std::string& key) const {
    return place_.empty() ? printable(key) : place_ + "." + printable(key);
  }

  const Json* json_;
  std::string place_;
};

/// The message of an error of the JSON library without its code, such as
/// "[json.exception.parse_error.101] ".
inline std::string json_message(std::string_view what) {
  if (what.starts_with("[json."))
    if (const auto end = what.find("] "); end != std::string_view::npos)
      what.remove_prefix(end + 2);
  return std::string(what);
}

}  // namespace selvedge
