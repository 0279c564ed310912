// SPDX-License-Identifier: MIT
//
// Values of fields as JSON, and back. The lists of fields are in scene_fields.h.
#pragma once

#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/scene/detail/scene_fields.h>
#include <selvedge/scene/detail/scene_json.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <functional>
#include <numbers>
#include <type_traits>

namespace selvedge::detail {

// -- to JSON -------------------------------------------------------------------------------------

template <class T>
Json json_of(const T& value, const Key& key = {});

inline Json json_of_rotation(const Eigen::Quaterniond& rotation) {
  const double sine = rotation.vec().norm();  // of half the angle
  if (!(sine > 0.0)) return Json::array();
  const Vec3 axis = rotation.vec() / sine;
  const double angle = 2.0 * elementary::atan2(sine, rotation.w());
  return {{"axis", {axis.x(), axis.y(), axis.z()}},
          {"angle_deg", angle * 180.0 / std::numbers::pi}};
}

inline Json json_of_method(const std::string& name, const MethodOptions& options) {
  if (options.empty()) return name;
  Json json{{"type", name}};
  for (const auto& [option, value] : options) json[option] = value;
  return json;
}

/// A list of formats, or of other values.
template <class List>
Json json_of_list(const List& list, const Key& key = {}) {
  Json json = Json::array();
  for (const auto& element : list) json.push_back(json_of(element, key));
  return json;
}

inline Json json_of_curve(const MonotoneCurve& curve) {
  if (curve.empty()) return {};
  Json points = Json::array();
  for (std::size_t i = 0; i < curve.x().size(); ++i) points.push_back({curve.x()[i], curve.y()[i]});
  return points;
}

template <HasFields T>
Json json_of_fields(const T& record) {
  Json json = Json::object();
  Fields<T>::visit([&](const char* name, auto member, const Key& key) {
    if constexpr (std::is_invocable_v<decltype(member), const T&>)
      if (Json value = json_of(std::invoke(member, record), key); !value.is_null())
        json[name] = std::move(value);
  });
  return json;
}

template <class T>
inline constexpr bool kIsPairView = false;
template <class V>
inline constexpr bool kIsPairView<PairView<V>> = true;
template <class T>
inline constexpr bool kIsMethodView = false;
template <class N, class O>
inline constexpr bool kIsMethodView<MethodView<N, O>> = true;
template <class T>
inline constexpr bool kIsFormatsView = false;
template <class N, class O>
inline constexpr bool kIsFormatsView<FormatsView<N, O>> = true;
template <class T>
inline constexpr bool kIsArray = false;
template <class T, std::size_t n>
inline constexpr bool kIsArray<std::array<T, n>> = true;
template <class T>
inline constexpr bool kIsMap = false;
template <class T>
inline constexpr bool kIsMap<std::map<std::string, T>> = true;
template <class T>
inline constexpr bool kIsVariant = false;
template <class... T>
inline constexpr bool kIsVariant<std::variant<T...>> = true;

template <class T>
Json json_of(const T& value, const Key& key) {
  if constexpr (std::is_enum_v<T> || std::is_same_v<T, bool>) {
    if (key.words.empty()) return static_cast<int>(value) != 0;
    return key.words[static_cast<std::size_t>(value)];
  } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
    return value;
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    return value.string();
  } else if constexpr (std::is_same_v<T, Vec3>) {
    return {value.x(), value.y(), value.z()};
  } else if constexpr (std::is_same_v<T, Eigen::Quaterniond>) {
    return json_of_rotation(value);
  } else if constexpr (std::is_same_v<T, MonotoneCurve>) {
    return json_of_curve(value);
  } else if constexpr (kIsPairView<T>) {
    return {value.a, value.b};
  } else if constexpr (kIsMethodView<T>) {
    return json_of_method(value.name, value.options);
  } else if constexpr (kIsFormatsView<T>) {
    return json_of_list(value.names);
  } else if constexpr (kIsOptional<T>) {
    return value ? json_of(*value, key) : Json();
  } else if constexpr (kIsMap<T>) {
    Json json = Json::object();
    for (const auto& [name, element] : value) json[name] = json_of(element);
    return json;
  } else if constexpr (kIsVariant<T>) {
    return std::visit([&](const auto& one) { return json_of(one, key); }, value);
  } else if constexpr (HasFields<T>) {
    return json_of_fields(value);
  } else if constexpr (std::is_empty_v<T>) {
    return Json::object();
  } else {
    return json_of_list(value, key);
  }
}

}  // namespace selvedge::detail
