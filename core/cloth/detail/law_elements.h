// SPDX-License-Identifier: MIT
//
// Kinds of elements that a single law knows: a struct in the source of the law, with a member
// `remap` as in cloth_elements.h. Its elements may refer to those of cloth_elements.h.
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/renumbering.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <typeindex>
#include <utility>
#include <vector>

namespace selvedge::detail {

/// Collects the new vertices of an element; its `remap` fails if one comes twice.
struct DistinctVertices {
  std::span<const std::int32_t> number;
  std::vector<std::int32_t>& seen;

  bool vertex(std::int32_t& i) const {
    for (const std::int32_t other : seen)
      if (other == number[i]) return false;
    seen.push_back(number[i]);
    return true;
  }
  template <class Element>
  bool element(std::int32_t&) const {
    return true;
  }
};

template <class Element>
class ElementsOf final : public AnyElements {
 public:
  std::unique_ptr<AnyElements> copy() const override { return std::make_unique<ElementsOf>(*this); }
  std::unique_ptr<AnyElements> none() const override { return std::make_unique<ElementsOf>(); }
  std::size_t size() const override { return elements.size(); }
  void add(const AnyElements& from, const Renumbering& to) override {
    for (Element element : static_cast<const ElementsOf&>(from).elements)
      if (element.remap(to)) elements.push_back(std::move(element));
  }
  void drop_repeated(std::span<const std::int32_t> number) override {
    std::erase_if(elements, [&](Element element) {
      std::vector<std::int32_t> seen;
      return !element.remap(DistinctVertices{number, seen});
    });
  }

  std::vector<Element> elements;
};

/// The elements of a kind in `cloth`.
template <class Element>
std::vector<Element>& elements_of_law(ClothMesh& cloth) {
  AnyElements* set = cloth.of_laws.find(typeid(Element));
  if (set == nullptr)
    set = cloth.of_laws.insert(typeid(Element), std::make_unique<ElementsOf<Element>>());
  return static_cast<ElementsOf<Element>*>(set)->elements;
}
template <class Element>
std::span<const Element> elements_of_law(const ClothMesh& cloth) {
  const AnyElements* set = cloth.of_laws.find(typeid(Element));
  if (set == nullptr) return {};
  return static_cast<const ElementsOf<Element>*>(set)->elements;
}

}  // namespace selvedge::detail
