// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/detail/scene_json.h>

#include <algorithm>
#include <stdexcept>

namespace selvedge {
namespace {

// The surfaces of a name: a piece, all pieces of a material, or a body.
struct Named {
  std::vector<std::size_t> surfaces;  // pieces first, then bodies
  int meanings = 0;
  bool body = false;
};

Named surfaces_of(const std::string& name, const Scene& scene) {
  Named named;
  const bool material = scene.materials.count(name) > 0;
  named.meanings = material ? 1 : 0;
  for (std::size_t p = 0; p < scene.cloths.size(); ++p) {
    if (scene.cloths[p].name == name) ++named.meanings;
    if (scene.cloths[p].name == name || (material && scene.cloths[p].material == name))
      named.surfaces.push_back(p);
  }
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].name != name) continue;
    ++named.meanings;
    named.body = true;
    named.surfaces.push_back(scene.cloths.size() + b);
  }
  return named;
}

std::string fault_of_name(const std::string& name, const Scene& scene) {
  const int meanings = surfaces_of(name, scene).meanings;
  if (meanings == 1) return "";
  if (meanings > 1)
    return fmt::format(
        "\"{}\" names more than one of pieces, materials and obstacles; give them different names",
        name);
  std::vector<std::string> known;
  for (const ClothSpec& cloth : scene.cloths) known.push_back(cloth.name);
  for (const auto& [material, numbers] : scene.materials) known.push_back(material);
  for (const BodySpec& body : scene.bodies) known.push_back(body.name);
  return fmt::format("there is no piece, material or obstacle \"{}\"; nearest is \"{}\"", name,
                     nearest_word(name, known));
}

}  // namespace

PairFault fault_of(const PairSpec& pair, const Scene& scene) {
  const std::string a = fault_of_name(pair.a, scene), b = fault_of_name(pair.b, scene);
  if (!a.empty()) return {"a", a};
  if (!b.empty()) return {"b", b};
  if (surfaces_of(pair.a, scene).body && surfaces_of(pair.b, scene).body)
    return {"b", fmt::format("\"{}\" and \"{}\" are two obstacles, which do not collide with each "
                             "other; name a piece of cloth or a material",
                             pair.a, pair.b)};
  if (!pair.friction && !pair.rest_gap && !pair.collide)
    return {"", "has no value for its pair; give it \"friction\", \"rest_gap\" or \"collide\""};
  return {};
}

ContactPairs::ContactPairs(const Scene& scene)
    : surfaces_(scene.cloths.size() + scene.bodies.size()), largest_(scene.contact.rest_gap) {
  const std::size_t pieces = scene.cloths.size();
  const auto fabric = [&](std::size_t p) {
    return scene.materials.at(scene.cloths[p].material).friction;
  };
  // Of a body: its own, whatever touches it. Of two of them: the greater one.
  const auto friction = [&](std::size_t p, std::size_t s) {
    const SolidSpec* own = solid_of(scene.cloths[p]);
    const SolidSpec* solid = s < pieces ? solid_of(scene.cloths[s]) : nullptr;
    if (own == nullptr && s >= pieces) return scene.bodies[s - pieces].friction;
    if (own == nullptr && solid == nullptr) return std::max(fabric(p), fabric(s));
    if (s >= pieces) return std::max(own->friction, scene.bodies[s - pieces].friction);
    return std::max(own ? own->friction : 0.0, solid ? solid->friction : 0.0);
  };
  for (std::size_t p = 0; p < pieces; ++p)
    for (std::size_t s = 0; s < surfaces_; ++s)
      table_.push_back(
          {friction(p, s), scene.contact.rest_gap, p != s || solid_of(scene.cloths[p]) == nullptr});
  for (std::size_t i = 0; i < scene.contact.pairs.size(); ++i) {
    const PairSpec& pair = scene.contact.pairs[i];
    if (const PairFault fault = fault_of(pair, scene); !fault.sentence.empty())
      throw std::invalid_argument(fmt::format("contact.pairs[{}]: {}", i, fault.sentence));
    const auto set = [&](std::size_t piece, std::size_t surface) {
      if (piece >= pieces) return;
      Entry& entry = table_[piece * surfaces_ + surface];
      entry.friction = pair.friction.value_or(entry.friction);
      entry.rest_gap = pair.rest_gap.value_or(entry.rest_gap);
      entry.collide = pair.collide.value_or(entry.collide);
    };
    const Named b = surfaces_of(pair.b, scene);
    for (const std::size_t one : surfaces_of(pair.a, scene).surfaces)
      for (const std::size_t other : b.surfaces) {
        set(one, other);
        set(other, one);
      }
  }
  for (const Entry& entry : table_) {
    largest_ = std::max(largest_, entry.rest_gap);
    collide_all_ = collide_all_ && entry.collide;
  }
  // The table has pairs of different pieces twice.
  for (std::size_t p = 0; p < pieces; ++p)
    for (std::size_t s = p; s < surfaces_; ++s) {
      if (s == p && solid_of(scene.cloths[p]) != nullptr) continue;
      ++count_;
      if (!table_[p * surfaces_ + s].collide) excluded_.emplace_back(p, s);
    }
}

}  // namespace selvedge
