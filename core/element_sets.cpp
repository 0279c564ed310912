// SPDX-License-Identifier: MIT
//
// The elements of a cloth in another one: all that append, cut and sewing have in common.
#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/detail/renumbering.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace selvedge {
namespace {

template <class... Set>
constexpr std::size_t size_of(std::type_identity<std::tuple<Set&...>>) {
  return (sizeof(Set) + ...);
}
static_assert(
    size_of(std::type_identity<decltype(element_sets(std::declval<ClothElements&>()))>{}) ==
        sizeof(ClothElements),
    "tie_sets returns every member of ClothElements");

/// Index of `element` in `set`, to which it is appended unless a cloth has it only once.
template <class Element>
std::int32_t put(ElementSet<Element>& set, Element element) {
  if constexpr (requires { Element::kUnique; }) {
    const auto known = std::find(set.begin(), set.end(), element);
    if (known != set.end()) return static_cast<std::int32_t>(known - set.begin());
  }
  set.push_back(std::move(element));
  return static_cast<std::int32_t>(set.size()) - 1;
}

template <class Element>
void add_set(ClothMesh&, ElementSet<Element>& to, const ElementSet<Element>& from,
             detail::Renumbering& renumbering) {
  std::vector<std::int32_t>& indices = renumbering.indices<Element>();
  indices.reserve(from.size());
  for (Element element : from)
    indices.push_back(element.remap(renumbering) ? put(to, std::move(element)) : -1);
}

template <class Kind>
void add_set(ClothMesh& all, ElementColumn<Kind>& to, const ElementColumn<Kind>& from,
             detail::Renumbering& renumbering) {
  if (to.empty() && from.empty()) return;
  using Element = typename Kind::Element;
  const std::vector<std::int32_t>& indices = renumbering.indices<Element>();
  const auto added = std::count_if(indices.begin(), indices.end(), [](auto i) { return i >= 0; });
  const auto& elements = std::get<ElementSet<Element>&>(element_sets(all));
  to.resize(elements.size() - static_cast<std::size_t>(added), Kind::kDefault);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] < 0) continue;
    typename Kind::Value value = i < from.size() ? from[i] : Kind::kDefault;
    Kind::remap(value, renumbering);
    to.push_back(value);
  }
}

std::map<Edge, int> triangles_of_edges(std::span<const Triangle> triangles) {
  std::map<Edge, int> count;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      ++count[{std::min(a, b), std::max(a, b)}];
    }
  return count;
}

/// New indices of the vertices that `triangles` use, in their order; -1 for the others.
std::vector<std::int32_t> used_vertices(std::size_t n, std::span<const Triangle> triangles) {
  std::vector<std::int32_t> number(n, -1);
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) number[v] = 0;
  std::int32_t count = 0;
  for (std::int32_t& i : number)
    if (i == 0) i = count++;
  return number;
}

/// The elements of `cloth` with the springs that are left if only the triangles `inside` are there.
/// A spring that loses all its triangles, and an element of a triangle that is lost, get the vertex
/// -1, which leaves them out.
ClothMesh thinned(const ClothMesh& cloth, std::span<const Triangle> inside) {
  const auto before = triangles_of_edges(cloth.surface.triangles);
  const auto now = triangles_of_edges(inside);
  ClothMesh thin = cloth;
  for (Spring& spring : thin.springs) {
    const Edge edge{std::min(spring.a, spring.b), std::max(spring.a, spring.b)};
    const auto was = before.find(edge);
    if (was == before.end()) continue;
    const auto is = now.find(edge);
    if (is == now.end())
      spring.a = -1;
    else
      spring.stiffness *= double(is->second) / was->second;
  }
  std::set<Triangle> lost(cloth.surface.triangles.begin(), cloth.surface.triangles.end());
  for (const Triangle& t : inside) lost.erase(t);
  for (MembraneTriangle& triangle : thin.membranes)
    if (lost.contains(triangle.v)) triangle.v[0] = -1;
  for (YarnTriangle& triangle : thin.yarns)
    if (lost.contains(triangle.v)) triangle.v[0] = -1;
  return thin;
}

}  // namespace

void add_elements(ClothMesh& to, const ClothMesh& from, std::span<const std::int32_t> vertices) {
  if (vertices.size() != from.surface.vertices.size())
    throw std::invalid_argument("elements: " + std::to_string(vertices.size()) +
                                " indices for a cloth of " +
                                std::to_string(from.surface.vertices.size()) + " vertices");
  detail::Renumbering renumbering(vertices);
  std::apply(
      [&](auto&... target) {
        std::apply([&](auto&... source) { (add_set(to, target, source, renumbering), ...); },
                   element_sets(from));
      },
      element_sets(to));
}

std::int32_t append(ClothMesh& all, const ClothMesh& piece) {
  const auto first = static_cast<std::int32_t>(all.surface.vertices.size());
  std::vector<std::int32_t> vertices(piece.surface.vertices.size());
  std::iota(vertices.begin(), vertices.end(), first);
  add_elements(all, piece, vertices);
  const auto& x = piece.surface.vertices;
  all.surface.vertices.insert(all.surface.vertices.end(), x.begin(), x.end());
  all.mass.insert(all.mass.end(), piece.mass.begin(), piece.mass.end());
  for (const Triangle& t : piece.surface.triangles)
    all.surface.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  for (const Edge& e : piece.edges) all.edges.push_back({e[0] + first, e[1] + first});
  return first;
}

ClothMesh cut(const ClothMesh& cloth, std::span<const Triangle> inside) {
  const std::vector<Vec3>& x = cloth.surface.vertices;
  const std::vector<std::int32_t> number = used_vertices(x.size(), inside);
  const std::vector<double> before = vertex_areas(x, cloth.surface.triangles);
  const std::vector<double> now = vertex_areas(x, inside);
  ClothMesh part;
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] >= 0) {
      part.surface.vertices.push_back(x[v]);
      part.mass.push_back(before[v] > 0.0 ? cloth.mass[v] * (now[v] / before[v]) : cloth.mass[v]);
    }
  for (const Triangle& t : inside)
    part.surface.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  part.edges = unique_edges(part.surface.triangles);
  add_elements(part, thinned(cloth, inside), number);
  return part;
}

std::vector<Spring> springs_of_curve(const ClothMesh& cloth, std::int32_t curve) {
  if (cloth.curve_of_spring.empty()) return curve < 0 ? cloth.springs : std::vector<Spring>{};
  std::vector<Spring> springs;
  for (std::size_t s = 0; s < cloth.springs.size(); ++s)
    if (cloth.curve_of_spring[s] == curve) springs.push_back(cloth.springs[s]);
  return springs;
}

}  // namespace selvedge
