// SPDX-License-Identifier: MIT
// What the changed sources of mutants.py call. mutants_lib.sh puts `selvedge_mutant`, the number of
// the change that is made, before it. An operator with an alternative keeps its precedence: `a < b`
// becomes `a < SelvedgeInfix<7>() < b`.
#include <algorithm>
#include <atomic>
#include <concepts>
#include <initializer_list>
#include <type_traits>

inline constexpr int kSelvedgeMutants = 10000;
inline std::atomic<bool> selvedge_reached[kSelvedgeMutants];

/// Whether this change is made; notes that a test has come here.
inline bool selvedge_mutant_reached(int number) noexcept {
  std::atomic<bool>& flag = selvedge_reached[number];
  if (!flag.load(std::memory_order_relaxed)) flag.store(true, std::memory_order_relaxed);
  return selvedge_mutant == number;
}

template <int N>
struct SelvedgeInfix {};

template <class A, int N>
struct SelvedgeLeft {
  const A& a;
};

#define SELVEDGE_COMPARE(is, other)                                   \
  template <class A, int N>                                           \
  SelvedgeLeft<A, N> operator is(const A& a, SelvedgeInfix<N>) {      \
    return {a};                                                       \
  }                                                                   \
  template <class A, int N, class B>                                  \
  requires requires(const A& a, const B& b) {                         \
    { a is b } -> std::same_as<bool>;                                 \
    { a other b } -> std::same_as<bool>;                              \
  }                                                                   \
  bool operator is(SelvedgeLeft<A, N> left, const B& b) {             \
    return selvedge_mutant_reached(N) ? left.a other b : left.a is b; \
  }
SELVEDGE_COMPARE(<, <=)
SELVEDGE_COMPARE(<=, <)
SELVEDGE_COMPARE(>, >=)
SELVEDGE_COMPARE(>=, >)
SELVEDGE_COMPARE(==, !=)
SELVEDGE_COMPARE(!=, ==)
#undef SELVEDGE_COMPARE

/// The value of an expression of Eigen, whose sums and differences have different types.
template <class T>
auto selvedge_value(const T& t) {
  if constexpr (requires { typename T::PlainObject; })
    return typename T::PlainObject(t);
  else
    return t;
}

#define SELVEDGE_SIGN(is, other)                                                                  \
  template <class A, int N>                                                                       \
  SelvedgeLeft<A, N> operator is(const A& a, SelvedgeInfix<N>) {                                  \
    return {a};                                                                                   \
  }                                                                                               \
  template <class A, int N, class B>                                                              \
  requires requires(const A& a, const B& b) {                                                     \
    a is b;                                                                                       \
    a other b;                                                                                    \
    requires std::same_as<decltype(selvedge_value(a is b)), decltype(selvedge_value(a other b))>; \
  }                                                                                               \
  auto operator is(SelvedgeLeft<A, N> left, const B& b) {                                         \
    if (selvedge_mutant_reached(N)) return selvedge_value(left.a other b);                        \
    return selvedge_value(left.a is b);                                                           \
  }
SELVEDGE_SIGN(+, -)
SELVEDGE_SIGN(-, +)
#undef SELVEDGE_SIGN

template <int N>
struct SelvedgeExtreme {
  template <class T>
  static T min(const T& a, const T& b) {
    return selvedge_mutant_reached(N) ? std::max(a, b) : std::min(a, b);
  }
  template <class T>
  static T max(const T& a, const T& b) {
    return selvedge_mutant_reached(N) ? std::min(a, b) : std::max(a, b);
  }
  template <class T>
  static T min(std::initializer_list<T> all) {
    return selvedge_mutant_reached(N) ? std::max(all) : std::min(all);
  }
  template <class T>
  static T max(std::initializer_list<T> all) {
    return selvedge_mutant_reached(N) ? std::min(all) : std::max(all);
  }
};
