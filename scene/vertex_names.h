// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>
#include <selvedge/response/contact_point.h>
#include <selvedge/scene/scene.h>

#include <cstdint>
#include <string>
#include <vector>

namespace selvedge {

/// What a person calls a vertex of the joint index space of ContactPoint (cloth particles first,
/// then the vertices of all bodies): its place within the piece of cloth or the body of the scene.
class VertexNames {
 public:
  VertexNames() = default;
  VertexNames(const Scene& scene, const BuiltScene& built);

  bool is_cloth(std::int32_t vertex) const { return vertex < owner_begin_[pieces_]; }
  /// Number of the owner: pieces of cloth first, then bodies.
  std::size_t owner_index(std::int32_t vertex) const;
  /// `cloth "skirt"`, `body "table"`; one without a name goes by its number: `cloth 0`.
  const std::string& owner_name(std::size_t owner) const { return owner_[owner]; }
  const std::string& owner(std::int32_t vertex) const { return owner_[owner_index(vertex)]; }
  /// Its first vertex.
  std::int32_t first(std::size_t owner) const { return owner_begin_[owner]; }
  std::size_t owners() const { return owner_.size(); }
  std::size_t pieces() const { return pieces_; }
  /// Its number within its owner, as in the files of that mesh.
  std::int32_t local(std::int32_t vertex) const;
  /// `vertex 24 of cloth "skirt"`.
  std::string vertex(std::int32_t vertex) const;
  /// `vertex 24 of cloth "skirt" and triangle (3, 7, 9) of body "table"`.
  std::string pair(const ContactPoint& contact) const;

 private:
  std::string primitive(const std::int32_t* vertices, int count) const;

  std::vector<std::string> owner_;
  std::vector<std::int32_t> owner_begin_;  // first vertex of each owner, plus the total
  std::size_t pieces_ = 0;
};

}  // namespace selvedge
