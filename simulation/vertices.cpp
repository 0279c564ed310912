// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/simulation/run_result.h>

#include <algorithm>

namespace selvedge {
namespace {

std::string named(const char* kind, const std::string& name, std::size_t index) {
  return name.empty() ? fmt::format("{} {}", kind, index) : fmt::format("{} \"{}\"", kind, name);
}

}  // namespace

VertexNames::VertexNames(const Scene& scene, const BuiltScene& built)
    : owner_begin_(built.piece_begin), pieces_(scene.cloths.size()) {
  for (std::size_t p = 0; p < scene.cloths.size(); ++p)
    owner_.push_back(named(solid_of(scene.cloths[p]) ? "body" : "cloth", scene.cloths[p].name, p));
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    owner_.push_back(named("body", scene.bodies[b].name, b));
    owner_begin_.push_back(owner_begin_.back() +
                           static_cast<std::int32_t>(built.bodies[b]->vertex_count()));
  }
}

std::size_t VertexNames::owner_index(std::int32_t vertex) const {
  const auto after = std::upper_bound(owner_begin_.begin(), owner_begin_.end(), vertex);
  return static_cast<std::size_t>(after - owner_begin_.begin()) - 1;
}

std::int32_t VertexNames::local(std::int32_t vertex) const {
  return vertex - owner_begin_[owner_index(vertex)];
}

std::string VertexNames::vertex(std::int32_t vertex) const { return primitive(&vertex, 1); }

std::string VertexNames::primitive(const std::int32_t* vertices, int count) const {
  constexpr const char* words[] = {"", "vertex", "edge", "triangle"};
  std::string numbers;
  for (int k = 0; k < count; ++k)
    numbers += (k == 0 ? "" : ", ") + std::to_string(local(vertices[k]));
  if (count > 1) numbers = "(" + numbers + ")";
  return fmt::format("{} {} of {}", words[count], numbers, owner(vertices[0]));
}

std::string VertexNames::pair(const ContactPoint& contact) const {
  const int first = contact.kind == ContactKind::edge_edge ? 2 : 1;
  return primitive(contact.vertex.data(), first) + " and " +
         primitive(contact.vertex.data() + first, 4 - first);
}

const char* flag_name(int bit) {
  constexpr std::array<const char*, kVertexFlags> names{"tangled", "pinched", "over_strain",
                                                        "given_up"};
  return names.at(static_cast<std::size_t>(bit));
}

void count_flags(std::span<const std::uint8_t> flags, FlagCounts& counts) {
  counts.end.fill(0);
  for (const std::uint8_t flag : flags)
    for (std::size_t bit = 0; bit < kVertexFlags; ++bit) counts.end[bit] += flag >> bit & 1;
  for (std::size_t bit = 0; bit < kVertexFlags; ++bit)
    counts.worst[bit] = std::max(counts.worst[bit], counts.end[bit]);
}

}  // namespace selvedge
