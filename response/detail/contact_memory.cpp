// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/contact_memory.h>

#include <cmath>
#include <stdexcept>

namespace selvedge::detail {
namespace {

// Contacts of one point whose normals have at least this cosine are one contact. The simulation
// takes contacts of one point and body for two below 0.95.
constexpr double kSameDirection = 0.9;

constexpr std::size_t kNumbers = 13;  // of a contact, saved

}  // namespace

const ContactMemory::Past* ContactMemory::find(const ContactPoint& c, std::size_t particles) const {
  const auto first = static_cast<std::size_t>(c.vertex[0]);
  const auto on_body = [&](std::int32_t i) { return static_cast<std::size_t>(i) >= particles; };
  const Past* found = nullptr;
  double nearest = kSameDirection;
  for (std::int32_t k = first < first_.size() ? first_[first] : -1; k >= 0; k = next_[k]) {
    const Past& s = past_[k];
    const bool same = c.kind == ContactKind::point_triangle
                          ? on_body(s.vertex[1]) == on_body(c.vertex[1])
                          : s.vertex == c.vertex;
    const double cosine = s.normal.dot(c.normal);
    if (s.kind != c.kind || !same || cosine < nearest) continue;
    nearest = cosine;
    found = &s;
  }
  return found;
}

void ContactMemory::clear() {
  for (const Past& s : past_) first_[s.vertex[0]] = -1;
  past_.clear();
  next_.clear();
}

void ContactMemory::add(const Past& past) {
  const auto first = static_cast<std::size_t>(past.vertex[0]);
  if (first >= first_.size()) first_.resize(first + 1, -1);
  next_.push_back(first_[first]);
  first_[first] = static_cast<std::int32_t>(past_.size());
  past_.push_back(past);
}

void ContactMemory::save(std::vector<double>& memory) const {
  for (const Past& s : past_) {
    for (const std::int32_t i : s.vertex) memory.push_back(i);
    for (const Vec3* u : {&s.normal, &s.friction})
      memory.insert(memory.end(), u->data(), u->data() + 3);
    memory.push_back(s.load);
    memory.push_back(s.rested ? 1.0 : 0.0);
    memory.push_back(static_cast<double>(s.kind));
  }
}

void ContactMemory::restore(std::span<const double> memory, std::size_t vertices) {
  clear();
  const auto fail = [] {
    throw std::invalid_argument("the memory of the contacts belongs to another scene");
  };
  if (memory.size() % kNumbers != 0) fail();
  for (; !memory.empty(); memory = memory.subspan(kNumbers)) {
    Past s;
    for (int k = 0; k < 4; ++k) {
      if (!(memory[k] >= 0.0 && memory[k] < static_cast<double>(vertices))) fail();
      s.vertex[k] = static_cast<std::int32_t>(memory[k]);
    }
    std::size_t at = 4;
    for (Vec3* u : {&s.normal, &s.friction})
      for (int k = 0; k < 3; ++k) (*u)[k] = memory[at++];
    s.load = memory[at];
    s.rested = memory[at + 1] != 0.0;
    const double kind = memory[at + 2];
    if (kind != 0.0 && kind != 1.0 && kind != 2.0) fail();
    s.kind = static_cast<ContactKind>(kind);
    if (!(s.load >= 0.0) || !s.normal.allFinite() || !s.friction.allFinite()) fail();
    add(s);
  }
}

}  // namespace selvedge::detail
