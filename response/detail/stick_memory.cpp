// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/stick_memory.h>

#include <cmath>
#include <stdexcept>

namespace selvedge {
namespace {

// Contacts of one point whose normals have at least this cosine are one contact. The simulation
// takes contacts of one point and body for two below 0.95.
constexpr double kSameDirection = 0.9;

constexpr std::size_t kNumbers = 12;  // of a contact, saved

}  // namespace

const StickMemory::Stuck* StickMemory::find(const ContactPoint& c, std::size_t particles) const {
  const auto first = static_cast<std::size_t>(c.vertex[0]);
  const auto on_body = [&](std::int32_t i) { return static_cast<std::size_t>(i) >= particles; };
  const Stuck* found = nullptr;
  double nearest = kSameDirection;
  for (std::int32_t k = first < first_.size() ? first_[first] : -1; k >= 0; k = next_[k]) {
    const Stuck& s = stuck_[k];
    const bool same = c.kind == ContactKind::point_triangle
                          ? on_body(s.vertex[1]) == on_body(c.vertex[1])
                          : s.vertex == c.vertex;
    const double cosine = s.normal.dot(c.normal);
    if (!same || cosine < nearest) continue;
    nearest = cosine;
    found = &s;
  }
  return found;
}

void StickMemory::clear() {
  for (const Stuck& s : stuck_) first_[s.vertex[0]] = -1;
  stuck_.clear();
  next_.clear();
}

void StickMemory::add(const Stuck& stuck) {
  const auto first = static_cast<std::size_t>(stuck.vertex[0]);
  if (first >= first_.size()) first_.resize(first + 1, -1);
  next_.push_back(first_[first]);
  first_[first] = static_cast<std::int32_t>(stuck_.size());
  stuck_.push_back(stuck);
}

void StickMemory::save(std::vector<double>& memory) const {
  for (const Stuck& s : stuck_) {
    for (const std::int32_t i : s.vertex) memory.push_back(i);
    for (const Vec3* u : {&s.normal, &s.friction})
      memory.insert(memory.end(), u->data(), u->data() + 3);
    memory.push_back(s.load);
    memory.push_back(s.rests ? 1.0 : 0.0);
  }
}

void StickMemory::restore(std::span<const double> memory, std::size_t vertices) {
  clear();
  const auto fail = [] {
    throw std::invalid_argument("the memory of the contacts belongs to another scene");
  };
  if (memory.size() % kNumbers != 0) fail();
  for (; !memory.empty(); memory = memory.subspan(kNumbers)) {
    Stuck s;
    for (int k = 0; k < 4; ++k) {
      if (!(memory[k] >= 0.0 && memory[k] < static_cast<double>(vertices))) fail();
      s.vertex[k] = static_cast<std::int32_t>(memory[k]);
    }
    std::size_t at = 4;
    for (Vec3* u : {&s.normal, &s.friction})
      for (int k = 0; k < 3; ++k) (*u)[k] = memory[at++];
    s.load = memory[at];
    s.rests = memory[at + 1] != 0.0;
    if (!(s.load >= 0.0) || !s.normal.allFinite() || !s.friction.allFinite()) fail();
    add(s);
  }
}

}  // namespace selvedge
