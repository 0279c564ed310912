// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/cloth_mesh.h>

namespace selvedge {

LawElements& LawElements::operator=(const LawElements& other) {
  if (this == &other) return *this;
  sets_.clear();
  for (const auto& [kind, set] : other.sets_) sets_.emplace_back(kind, set->copy());
  return *this;
}

std::size_t LawElements::size() const {
  std::size_t sum = 0;
  for (const auto& [kind, set] : sets_) sum += set->size();
  return sum;
}

void LawElements::add(const LawElements& from, const detail::Renumbering& to) {
  for (const auto& [kind, set] : from.sets_) {
    detail::AnyElements* own = find(kind);
    if (own == nullptr) own = insert(kind, set->none());
    own->add(*set, to);
  }
}

void LawElements::drop_repeated(std::span<const std::int32_t> number) {
  for (const auto& [kind, set] : sets_) set->drop_repeated(number);
}

detail::AnyElements* LawElements::find(std::type_index kind) const {
  for (const auto& [known, set] : sets_)
    if (known == kind) return set.get();
  return nullptr;
}

detail::AnyElements* LawElements::insert(std::type_index kind,
                                         std::unique_ptr<detail::AnyElements> set) {
  sets_.emplace_back(kind, std::move(set));
  return sets_.back().second.get();
}

}  // namespace selvedge
