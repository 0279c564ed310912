// SPDX-License-Identifier: MIT
//
// What the standard library of Emscripten 3.1.6 (libc++ 13) lacks of C++20 and the sources use.
// build.sh includes it before every source.
#pragma once

#include <version>
#if defined(_LIBCPP_VERSION) && _LIBCPP_VERSION < 14000

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <string>
#include <system_error>

namespace std {

template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  return __builtin_bit_cast(To, from);
}

namespace ranges {

template <class Range, class Predicate>
bool all_of(Range&& range, Predicate predicate) {
  return std::all_of(std::begin(range), std::end(range), predicate);
}
template <class Range, class Predicate>
bool any_of(Range&& range, Predicate predicate) {
  return std::any_of(std::begin(range), std::end(range), predicate);
}
template <class Range, class Predicate>
bool none_of(Range&& range, Predicate predicate) {
  return std::none_of(std::begin(range), std::end(range), predicate);
}
template <class Range, class Predicate>
auto count_if(Range&& range, Predicate predicate) {
  return std::count_if(std::begin(range), std::end(range), predicate);
}
template <class A, class B>
bool equal(A&& a, B&& b) {
  return std::equal(std::begin(a), std::end(a), std::begin(b), std::end(b));
}
template <class Range, class T>
auto find(Range&& range, const T& value) {
  return std::find(std::begin(range), std::end(range), value);
}
template <class Range, class T, class Less = std::less<>, class Key>
auto lower_bound(Range&& range, const T& value, Less less, Key key) {
  return std::lower_bound(std::begin(range), std::end(range), value,
                          [&](const auto& a, const T& b) { return less(std::invoke(key, a), b); });
}
template <class Range, class Less = std::less<>, class Key>
void sort(Range&& range, Less less, Key key) {
  std::sort(std::begin(range), std::end(range), [&](const auto& a, const auto& b) {
    return less(std::invoke(key, a), std::invoke(key, b));
  });
}

}  // namespace ranges

/// The end of the decimal number, or of "inf" or "nan", at `first`; `first` if there is none.
inline const char* end_of_number(const char* first, const char* last) {
  const auto digits = [&](const char* at) {
    while (at != last && std::isdigit(static_cast<unsigned char>(*at)) != 0) ++at;
    return at;
  };
  const char* start = first != last && *first == '-' ? first + 1 : first;
  std::string word(start, std::min(last, start + 3));
  for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (word == "inf" || word == "nan") return start + 3;
  const char* at = digits(start);
  auto count = at - start;
  if (at != last && *at == '.') {
    const char* end = digits(at + 1);
    count += end - at - 1;
    at = end;
  }
  if (count == 0) return first;
  if (at == last || (*at != 'e' && *at != 'E')) return at;
  const char* power = at + 1;
  if (power != last && (*power == '+' || *power == '-')) ++power;
  const char* end = digits(power);
  return end == power ? at : end;
}

/// Correctly rounded, as strtod of musl is.
inline from_chars_result from_chars(const char* first, const char* last, double& value) {
  const char* end = end_of_number(first, last);
  if (end == first) return {first, errc::invalid_argument};
  const std::string word(first, end);
  const double read = std::strtod(word.c_str(), nullptr);
  const auto mantissa_end = std::min(word.find_first_of("eE"), word.size());
  const bool named = word.find_first_of("nN") != std::string::npos;
  const bool zero = word.find_first_of("123456789") >= mantissa_end;
  if (!named && (std::isinf(read) || (read == 0.0 && !zero)))
    return {end, errc::result_out_of_range};
  value = read;
  return {end, errc()};
}

inline to_chars_result to_chars(char* first, char* last, double value, chars_format,
                                int precision) {
  char text[64];
  const int n = std::snprintf(text, sizeof text, "%.*g", precision, value);
  if (n > last - first) return {last, errc::value_too_large};
  return {std::copy_n(text, n, first), errc()};
}

}  // namespace std

#endif
