// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_elements.h>

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

/// A piece of cloth at rest: the surface that collides, masses, and the elements (springs, hinges,
/// …) that hold it together.
struct ClothMesh : ClothElements {
  TriangleMesh surface;      ///< initial shape
  std::vector<Edge> edges;   ///< unique_edges(surface.triangles)
  std::vector<double> mass;  ///< kg per vertex
  LawElements of_laws;       ///< elements of kinds that single laws define
};

/// Appends the elements of `from` to those of `to`. Vertex i of `from` is vertex `vertices[i]` of
/// `to`; several may be the same. -1 leaves a vertex out, and with it the elements that have it or
/// refer to such an element. The order of the elements stays. Throws std::invalid_argument unless
/// there is one index for each vertex of `from`.
void add_elements(ClothMesh& to, const ClothMesh& from, std::span<const std::int32_t> vertices);

/// A cloth of layers in parts, all with its vertices: the elements that carry, and those of the
/// dense layers with their ties.
struct LayerParts {
  ClothMesh carrying, local;
};
LayerParts split_layers(const ClothMesh& cloth);

/// Appends `piece` to `all` and returns the index of its first vertex.
std::int32_t append(ClothMesh& all, const ClothMesh& piece);

/// The part of `cloth` with the triangles `inside`, which are triangles of `cloth`, and their
/// vertices, whose order stays. A spring along a new border keeps half its stiffness. A spring that
/// is not a side of a triangle stays if both its ends do. Particles get the mass of their remaining
/// triangles.
ClothMesh cut(const ClothMesh& cloth, std::span<const Triangle> inside);

/// `cloth` with merged vertices: vertex i becomes vertex `number[i]`, of any number of others, and
/// vertex j of the result has the place of vertex `kept[j]`. Masses add up. Springs that come to
/// lie between the same two vertices become one, with the sum of their stiffnesses and the mean
/// rest length at which the two would balance, unless they follow different curves. Elements that
/// would name a vertex twice are left out, and no hinge is added, so that a seam folds freely, as
/// in make_from_pattern. Throws std::invalid_argument if a triangle would name a vertex twice.
ClothMesh merge_vertices(const ClothMesh& cloth, std::span<const std::int32_t> number,
                         std::span<const std::int32_t> kept);

/// The springs that follow `curves[curve]`; -1: those that follow Hooke's law.
std::vector<Spring> springs_of_curve(const ClothMesh& cloth, std::int32_t curve);

/// A rectangle in the xy-plane, centred at the origin, of cells_x × cells_y cells. Vertex (i,j) has
/// index j·(cells_x+1)+i.
struct GridConfig {
  double size_x = 1.0, size_y = 1.0;        ///< m, > 0
  std::int32_t cells_x = 50, cells_y = 50;  ///< >= 1
};

}  // namespace selvedge
