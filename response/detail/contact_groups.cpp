// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/contact_groups.h>

#include <algorithm>
#include <numeric>

namespace selvedge::detail {

void ContactGroups::begin(const ContactMotion& motion) {
  motion_ = motion;
  parent_.resize(motion.particles);
  std::iota(parent_.begin(), parent_.end(), 0);
  in_group_.assign(motion.particles, 0);
  anchors_.clear();
  bound_.clear();
  stale_ = true;
  if (motion.followers == nullptr) return;
  bound_.assign(motion.particles, 0);
  for (const std::int32_t i : motion.followers->nodes())
    for (const Followers::Share& s : motion.followers->shares(i))
      if (const std::int32_t leader = motion.followers->leaders()[s.leader];
          motion.inv_mass[leader] > 0.0 && motion.inv_mass[i] > 0.0) {
        unite(i, leader);
        bound_[i] = bound_[leader] = 1;
      }
}

std::int32_t ContactGroups::root(std::int32_t i) const {
  while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
  return i;
}

// The smaller index becomes the root, so that the result does not depend on the order of contacts.
void ContactGroups::unite(std::int32_t i, std::int32_t j) {
  const std::int32_t a = root(i), b = root(j);
  parent_[std::max(a, b)] = std::min(a, b);
}

void ContactGroups::merge(std::span<const ContactPoint> contacts) {
  stale_ = true;
  for (const ContactPoint& c : contacts) {
    std::int32_t first = -1;
    for (const std::int32_t i : c.vertex) {
      if (motion_.inv_mass[i] <= 0.0) continue;
      in_group_[i] = 1;
      if (first < 0) first = i;
      unite(first, i);
    }
    if (first < 0) continue;
    for (const std::int32_t i : c.vertex)
      if (motion_.inv_mass[i] <= 0.0) anchors_.push_back({first, i});
  }
}

const std::vector<ContactGroup>& ContactGroups::groups() const {
  if (!stale_) return groups_;
  stale_ = false;
  groups_.clear();
  index_.assign(motion_.particles, -1);
  std::vector<char> is_met(bound_.size(), 0);  // by root
  for (std::size_t i = 0; i < bound_.size(); ++i)
    if (in_group_[i]) is_met[root(static_cast<std::int32_t>(i))] = 1;
  for (std::size_t i = 0; i < motion_.particles; ++i) {
    const std::int32_t r = root(static_cast<std::int32_t>(i));
    if (!in_group_[i] && (bound_.empty() || !bound_[i] || !is_met[r])) continue;
    if (index_[r] < 0) {
      index_[r] = static_cast<std::int32_t>(groups_.size());
      groups_.emplace_back();
    }
    groups_[index_[r]].particles.push_back(static_cast<std::int32_t>(i));
  }
  for (const auto& [particle, anchor] : anchors_)
    groups_[index_[root(particle)]].anchors.push_back(anchor);
  for (ContactGroup& group : groups_) {
    std::sort(group.anchors.begin(), group.anchors.end());
    group.anchors.erase(std::unique(group.anchors.begin(), group.anchors.end()),
                        group.anchors.end());
  }
  return groups_;
}

std::int32_t ContactGroups::group_of(const ContactPoint& c) const {
  groups();
  for (const std::int32_t i : c.vertex)
    if (motion_.inv_mass[i] > 0.0) return index_[root(i)];
  return -1;
}

bool ContactGroups::contains(std::int32_t i) const {
  groups();
  return index_[root(i)] >= 0;
}

std::size_t ContactGroups::members() const {
  return static_cast<std::size_t>(std::count(in_group_.begin(), in_group_.end(), 1));
}

}  // namespace selvedge::detail
