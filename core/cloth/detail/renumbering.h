// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/cloth/cloth_elements.h>

#include <tuple>
#include <type_traits>
#include <utility>

namespace selvedge::detail {

/// Where the members of a set went: the new index of each, -1 for those that are left out.
template <class Set>
struct NewIndices {
  std::vector<std::int32_t> of;
};

template <class... Set>
std::tuple<NewIndices<std::remove_cvref_t<Set>>...> new_indices(const std::tuple<Set&...>&);

/// New indices of the vertices and elements of a cloth: the `to` of the elements' `remap`.
class Renumbering {
 public:
  explicit Renumbering(std::span<const std::int32_t> vertices) : vertices_(vertices) {}

  bool vertex(std::int32_t& i) const { return replace(vertices_, i); }
  /// Only for sets that were renumbered before.
  template <class Element>
  bool element(std::int32_t& i) const {
    return replace(indices<Element>(), i);
  }

  template <class Element>
  std::vector<std::int32_t>& indices() {
    return std::get<NewIndices<ElementSet<Element>>>(sets_).of;
  }
  template <class Element>
  const std::vector<std::int32_t>& indices() const {
    return std::get<NewIndices<ElementSet<Element>>>(sets_).of;
  }

 private:
  static bool replace(std::span<const std::int32_t> indices, std::int32_t& i) {
    if (i < 0) return false;
    SELVEDGE_ASSERT(static_cast<std::size_t>(i) < indices.size());
    i = indices[i];
    return i >= 0;
  }

  std::span<const std::int32_t> vertices_;
  decltype(new_indices(element_sets(std::declval<ClothElements&>()))) sets_;
};

}  // namespace selvedge::detail
