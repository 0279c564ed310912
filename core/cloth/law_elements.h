// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <typeindex>
#include <utility>
#include <vector>

namespace selvedge {
namespace detail {

class Renumbering;

/// A set of elements of any kind.
class AnyElements {
 public:
  virtual ~AnyElements() = default;
  virtual std::unique_ptr<AnyElements> copy() const = 0;
  virtual std::unique_ptr<AnyElements> none() const = 0;  ///< an empty set of this kind
  virtual std::size_t size() const = 0;
  /// Appends the elements of `from`, of the same kind, that survive their `remap`.
  virtual void add(const AnyElements& from, const Renumbering& to) = 0;
  /// Drops the elements that would name a vertex twice if vertex i became vertex number[i].
  virtual void drop_repeated(std::span<const std::int32_t> number) = 0;
};

}  // namespace detail

/// Sets of the kinds of elements that single laws define (detail/law_elements.h). Append, cut and
/// sewing carry them.
class LawElements {
 public:
  LawElements() = default;
  LawElements(const LawElements& other) { *this = other; }
  LawElements(LawElements&&) = default;
  LawElements& operator=(const LawElements& other);
  LawElements& operator=(LawElements&&) = default;

  /// The set of a kind; null: there is none.
  detail::AnyElements* find(std::type_index kind) const;
  detail::AnyElements* insert(std::type_index kind, std::unique_ptr<detail::AnyElements> set);
  std::size_t size() const;  ///< of all sets together

  void add(const LawElements& from, const detail::Renumbering& to);
  void drop_repeated(std::span<const std::int32_t> number);

 private:
  std::vector<std::pair<std::type_index, std::unique_ptr<detail::AnyElements>>> sets_;
};

}  // namespace selvedge
