// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/field_json.h>
#include <selvedge/scene/detail/read_methods.h>
#include <selvedge/scene/detail/read_values.h>

#include <algorithm>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>

namespace selvedge::detail {

/// Reads the fields of structs from a document that the schema has checked and completed. Unstored
/// keys are left to the caller. Throws std::invalid_argument through `fail` for a file that does
/// not exist, a rotation about no axis, or a method or option that does not exist.
class FieldReader {
 public:
  /// Refers to its arguments.
  FieldReader(const LocatedJson& document, const Methods& methods)
      : document_(document), methods_(methods) {}

  template <HasFields T>
  void read(Json& j, const std::string& path, T& record) const {
    Fields<T>::visit([&](const char* name, auto member, const Key& key) {
      if constexpr (std::is_invocable_v<decltype(member), T&>)
        if (const auto found = j.find(name); found != j.end())
          read_value(*found, join(path, name), key, std::invoke(member, record));
    });
  }

 private:
  /// `value` is a reference to the field, or a view of it.
  template <class Value>
  void read_value(Json& j, const std::string& path, const Key& key, Value&& value) const {
    using T = std::remove_cvref_t<Value>;
    if constexpr (std::is_enum_v<T> || std::is_same_v<T, bool>)
      value = read_word<T>(j, key);
    else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>)
      value = j.get<T>();
    else if constexpr (std::is_same_v<T, std::filesystem::path>)
      value = j == "" ? std::filesystem::path() : read_file(document_, j, path);
    else if constexpr (std::is_same_v<T, Vec3>)
      value = read_vec3(j);
    else if constexpr (std::is_same_v<T, Eigen::Quaterniond>)
      value = read_rotation(document_, j, path);
    else if constexpr (std::is_same_v<T, MonotoneCurve>)
      value = read_curve(j, path, key.axes);
    else if constexpr (kIsPairView<T>)
      j[0].get_to(value.a), j[1].get_to(value.b);
    else if constexpr (kIsMethodView<T>)
      read_method_or_switch(j, path, value);
    else if constexpr (kIsFormatsView<T>)
      read_formats(j, value);
    else if constexpr (kIsOptional<T>)
      read_value(j, path, key, value.emplace());
    else if constexpr (kIsMap<T>)
      for (const auto& item : j.items())
        read_value(item.value(), join(path, item.key()), key, value[item.key()]);
    else if constexpr (kIsVariant<T>)
      read_tagged(j, path, value);
    else if constexpr (HasFields<T>)
      read(j, path, value);
    else
      read_list(j, path, key, value);
  }

  template <class T>
  static T read_word(const Json& j, const Key& key) {
    if constexpr (std::is_same_v<T, bool>)
      if (j.is_boolean()) return j.get<bool>();
    const auto found = std::find(key.words.begin(), key.words.end(), j.get<std::string>());
    return static_cast<T>(found - key.words.begin());
  }

  MonotoneCurve read_curve(const Json& j, const std::string& path,
                           const std::array<CurveAxis, 2>& axes) const {
    std::vector<double> values[2];
    for (std::size_t i = 0; i < j.size(); ++i)
      for (std::size_t k = 0; k < 2; ++k) {
        values[k].push_back(j[i][k].get<double>());
        const std::string fault = range_fault({0, axes[k].most}, values[k].back());
        if (!fault.empty())
          fail(document_, join(join(path, i), k), std::string(axes[k].name) + " " + fault);
      }
    try {
      return {values[0], values[1]};
    } catch (const std::invalid_argument& error) {
      fail(document_, path, error.what());
    }
  }

  template <class List>
  void read_list(Json& j, const std::string& path, const Key& key, List& list) const {
    if constexpr (!kIsArray<List>) list.resize(j.size());
    for (std::size_t i = 0; i < j.size(); ++i) read_value(j[i], join(path, i), key, list[i]);
  }

  template <class View>
  void read_method_or_switch(const Json& j, const std::string& path, View& method) const {
    if (!j.is_boolean())
      method.name = read_method(document_, j, path, methods_, method.family, method.options);
    else if (!j.get<bool>())
      method.name = "none";
  }

  /// The formats themselves check names and options when a run starts.
  template <class View>
  static void read_formats(const Json& j, View& formats) {
    for (const Json& format : j) {
      formats.names.push_back((format.is_string() ? format : format["type"]).get<std::string>());
      if (format.is_string()) continue;
      MethodOptions& options = formats.options[formats.names.back()];
      for (const auto& [key, value] : format.items())
        if (key != "type") options.set(key, option_value(value));
    }
  }

  /// The alternative whose kType is "type".
  template <class... T>
  void read_tagged(Json& j, const std::string& path, std::variant<T...>& value) const {
    const auto read_if = [&]<class One>(One one) {
      if (j["type"] != Fields<One>::kType) return;
      read(j, path, one);
      value = one;
    };
    (read_if(T{}), ...);
  }

  const LocatedJson& document_;
  const Methods& methods_;
};

}  // namespace selvedge::detail
