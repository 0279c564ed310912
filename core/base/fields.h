// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace selvedge {

/// The list of the fields of a struct, from which readers, writers, checks and tables are made.
/// Fields<T>::visit(visitor) calls visitor(name, member, rule) for every field in the order of the
/// list. `member` is a pointer to member, or another callable from T to a reference to the value or
/// to a view of it; or it is Unstored.
/// `rule` says what the users of the list need: a Key for the keys of scene files, a FieldRule for
/// results (simulation/run_result.h).
template <class T>
struct Fields;

template <class T>
concept HasFields = requires {
  sizeof(Fields<T>);
};

/// The numbers that a field accepts.
struct ValueRange {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above_least = false;  ///< `least` itself is excluded
  /// Programs may not exceed `most` either. Else it only guards against slips in files.
  bool firm = false;
};

/// One axis of a measured curve in a file.
struct CurveAxis {
  std::string_view name{}, unit{};
  double most = 0.0;  ///< values are from 0 to this
};

/// Refers to words: those of a braced list until the end of the expression that it stands in.
struct Words {
  constexpr Words() = default;
  constexpr Words(std::initializer_list<std::string_view> list) : list_(list.begin(), list.end()) {}
  constexpr explicit Words(std::span<const std::string_view> list) : list_(list) {}

  constexpr bool empty() const { return list_.empty(); }
  constexpr auto begin() const { return list_.begin(); }
  constexpr auto end() const { return list_.end(); }
  constexpr std::string_view operator[](std::size_t i) const { return list_[i]; }

 private:
  std::span<const std::string_view> list_;
};

/// A key of scene files. Its default is the value in a default-constructed struct. It owns nothing,
/// so that a list of keys compiles to constants.
struct Key {
  std::string_view unit{};  ///< "m", "1/s"; "1": dimensionless; empty: no number
  ValueRange range{};       ///< of a number, or of each number in a list
  std::string_view text{};  ///< one sentence without full stop and unit
  /// The words for the values of an enum, in its order, or for false and true. An empty word: files
  /// cannot give this value.
  Words words{};
  /// Smallest and largest number of characters or elements.
  std::size_t shortest = 0, longest = std::numeric_limits<std::size_t>::max();
  std::array<CurveAxis, 2> axes{};  ///< of a measured curve: x and y; else without names
  bool required = false;
  bool completed = true;  ///< a key that is left out gets the default
};

/// In the place of a member: a key that the struct does not store as it is. Its reader is written
/// by hand; T gives its type, and `initial` its default.
template <class T>
struct Unstored {
  using Value = T;
  std::optional<T> initial{};
};

/// The field `inner` of the field `outer`.
template <class Outer, class Inner>
struct FieldWithin {
  Outer outer;
  Inner inner;
  decltype(auto) operator()(auto& record) const {
    return std::invoke(inner, std::invoke(outer, record));
  }
};

/// Visits the fields of the struct at `outer` as if they were fields of the struct around it.
template <HasFields T, class Outer, class Visitor>
void visit_within(Outer outer, Visitor&& visitor) {
  Fields<T>::visit([&](const char* name, auto member, const auto& rule) {
    if constexpr (std::is_invocable_v<decltype(member), T&>)
      visitor(name, FieldWithin<Outer, decltype(member)>{outer, member}, rule);
    else
      visitor(name, member, rule);
  });
}

/// Why `range` does not accept the value, such as "must be at least 0, is -1"; empty if it does.
std::string range_fault(const ValueRange& range, double value);

namespace detail {

void check_field(double value, const Key& key, const std::string& place);

template <class T>
void check_value(const T& value, const Key& key, const std::string& place);

template <class T>
void check_elements(const std::vector<T>& values, const Key& key, const std::string& place) {
  for (std::size_t i = 0; i < values.size(); ++i)
    check_value(values[i], key, place + "[" + std::to_string(i) + "]");
}

}  // namespace detail

/// Checks the numbers of a struct that a program has filled; readers check those of files. Throws
/// std::invalid_argument with the place of the number, the fault and the value.
template <HasFields T>
void check_fields(const T& record, const std::string& place) {
  Fields<T>::visit([&](const char* name, auto member, const Key& key) {
    if constexpr (std::is_invocable_v<decltype(member), const T&>)
      detail::check_value(std::invoke(member, record), key,
                          place.empty() ? name : place + "." + name);
  });
}

namespace detail {

template <class T>
inline constexpr bool kIsVector = false;
template <class T>
inline constexpr bool kIsVector<std::vector<T>> = true;
template <class T>
inline constexpr bool kIsOptional = false;
template <class T>
inline constexpr bool kIsOptional<std::optional<T>> = true;

template <class T>
void check_value(const T& value, const Key& key, const std::string& place) {
  if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>)
    check_field(static_cast<double>(value), key, place);
  else if constexpr (std::is_same_v<T, Vec3>)
    for (int axis = 0; axis < 3; ++axis) check_field(value[axis], key, place);
  else if constexpr (HasFields<T>)
    check_fields(value, place);
  else if constexpr (kIsVector<T>)
    check_elements(value, key, place);
  else if constexpr (kIsOptional<T>) {
    if (value) check_value(*value, key, place);
  }
}

}  // namespace detail
}  // namespace selvedge
