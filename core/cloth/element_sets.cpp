// SPDX-License-Identifier: MIT
//
// The elements of a cloth in another one: all that append, cut and sewing have in common.
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/renumbering.h>

#include <algorithm>
#include <array>
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
  if (to.empty()) to.reserve(from.size());
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

bool have_same_ends(const Spring& a, const Spring& b) {
  return std::minmax(a.a, a.b) == std::minmax(b.a, b.b);
}

/// Two parallel springs as one: k1 (L - L1) + k2 (L - L2) = (k1 + k2) (L - mean of L1 and L2).
void join(Spring& spring, const Spring& other) {
  const double sum = spring.stiffness + other.stiffness, share = other.stiffness / sum;
  spring.rest_length += share * (other.rest_length - spring.rest_length);
  spring.damping += share * (other.damping - spring.damping);
  spring.stiffness = sum;
}

/// The elements of `cloth` that survive a merge. Those that do not get the vertex -1.
ClothMesh joined(const ClothMesh& cloth, std::span<const std::int32_t> number) {
  ClothMesh all = cloth;
  const auto repeats = [&](const auto& v) {
    for (std::size_t k = 1; k < v.size(); ++k)
      for (std::size_t j = 0; j < k; ++j)
        if (number[v[k]] == number[v[j]]) return true;
    return false;
  };
  for_each_element_set(all, [&](auto& set) {
    for (auto& element : set) {
      if constexpr (requires { element.v; }) {
        if (repeats(element.v)) element.v[0] = -1;
      } else if constexpr (requires { element.rest_length; }) {
        if (number[element.a] == number[element.b]) element.a = -1;
      }
    }
  });
  all.of_laws.drop_repeated(number);
  std::map<std::array<std::int32_t, 3>, std::size_t> known;  // ends and curve
  for (std::size_t s = 0; s < all.springs.size(); ++s) {
    if (all.springs[s].a < 0) continue;
    const auto [a, b] = std::minmax(number[all.springs[s].a], number[all.springs[s].b]);
    const std::int32_t curve = cloth.curve_of_spring.empty() ? -1 : cloth.curve_of_spring[s];
    const auto [place, is_new] = known.try_emplace({a, b, curve}, s);
    const std::size_t first = place->second;
    if (is_new || have_same_ends(cloth.springs[first], cloth.springs[s])) continue;
    join(all.springs[first], all.springs[s]);
    if (!all.strain_limit.empty())
      all.strain_limit[first] = std::min(all.strain_limit[first], all.strain_limit[s]);
    all.springs[s].a = -1;
  }
  return all;
}

}  // namespace

ClothMesh merge_vertices(const ClothMesh& cloth, std::span<const std::int32_t> number,
                         std::span<const std::int32_t> kept) {
  ClothMesh merged;
  for (const std::int32_t v : kept) merged.surface.vertices.push_back(cloth.surface.vertices[v]);
  merged.mass.assign(kept.size(), 0.0);
  for (std::size_t v = 0; v < number.size(); ++v) merged.mass[number[v]] += cloth.mass[v];
  for (const Triangle& t : cloth.surface.triangles) {
    const Triangle now = {number[t[0]], number[t[1]], number[t[2]]};
    if (now[0] == now[1] || now[1] == now[2] || now[2] == now[0])
      throw std::invalid_argument("merge: a triangle would name vertex " + std::to_string(t[0]) +
                                  ", " + std::to_string(t[1]) + " or " + std::to_string(t[2]) +
                                  " twice");
    merged.surface.triangles.push_back(now);
  }
  merged.edges = unique_edges(merged.surface.triangles);
  add_elements(merged, joined(cloth, number), number);
  return merged;
}

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
  to.of_laws.add(from.of_laws, renumbering);
}

std::int32_t append(ClothMesh& all, const ClothMesh& piece) {
  const auto first = static_cast<std::int32_t>(all.surface.vertices.size());
  std::vector<std::int32_t> vertices(piece.surface.vertices.size());
  std::iota(vertices.begin(), vertices.end(), first);
  add_elements(all, piece, vertices);
  const auto& x = piece.surface.vertices;
  if (all.edges.empty()) {
    all.surface.triangles.reserve(piece.surface.triangles.size());
    all.edges.reserve(piece.edges.size());
  }
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
