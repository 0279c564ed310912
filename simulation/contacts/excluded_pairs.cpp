// SPDX-License-Identifier: MIT
#include <selvedge/simulation/contacts/detail/excluded_pairs.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::uint8_t kBothSides = 3;

std::uint8_t in_all(std::span<const std::int32_t> triangles,
                    const std::vector<std::uint8_t>& mask) {
  if (triangles.empty()) return 0;
  std::uint8_t bits = kBothSides;
  for (const std::int32_t t : triangles) bits &= mask[t];
  return bits;
}

bool opposite(std::uint8_t a, std::uint8_t b) {
  return ((a & 1) != 0 && (b & 2) != 0) || ((a & 2) != 0 && (b & 1) != 0);
}

}  // namespace

ExcludedPairs::ExcludedPairs(const JointSurface& surface)
    : cloth_vertices_(surface.cloth_vertices()),
      cloth_edges_(surface.cloth_edges()),
      cloth_triangles_(surface.cloth_triangles()) {}

void ExcludedPairs::add(const JointSurface& surface,
                        const std::array<std::vector<std::int32_t>, 2>& side) {
  if (side[0].empty() || side[1].empty()) return;
  Masks& masks = masks_.emplace_back();
  masks.triangle.assign(surface.triangles().size(), 0);
  for (int s = 0; s < 2; ++s)
    for (const std::int32_t t : side[s]) masks.triangle[t] |= static_cast<std::uint8_t>(1 << s);
  masks.edge.resize(surface.edges().size());
  for (std::size_t e = 0; e < masks.edge.size(); ++e)
    masks.edge[e] = in_all(surface.triangles_of_edge(static_cast<std::int32_t>(e)), masks.triangle);
  masks.vertex.resize(surface.vertices());
  for (std::size_t v = 0; v < masks.vertex.size(); ++v)
    masks.vertex[v] =
        in_all(surface.triangles_of_vertex(static_cast<std::int32_t>(v)), masks.triangle);
}

template <class Member>
bool ExcludedPairs::excluded(Member a_kind, std::size_t a, Member b_kind, std::size_t b) const {
  return std::any_of(masks_.begin(), masks_.end(),
                     [&](const Masks& m) { return opposite((m.*a_kind)[a], (m.*b_kind)[b]); });
}

bool ExcludedPairs::excludes_triangles(std::int32_t a, std::int32_t b) const {
  return excluded(&Masks::triangle, static_cast<std::size_t>(a), &Masks::triangle,
                  static_cast<std::size_t>(b));
}

void ExcludedPairs::drop(CandidatePairs& pairs, std::size_t vertices, std::size_t edges,
                         std::size_t triangles) const {
  const auto index = [](std::int32_t i) { return static_cast<std::size_t>(i); };
  std::erase_if(pairs.point_triangle, [&](const PointTrianglePair& p) {
    return excluded(&Masks::vertex, index(p.point), &Masks::triangle,
                    index(p.triangle) + triangles);
  });
  std::erase_if(pairs.triangle_point, [&](const PointTrianglePair& p) {
    return excluded(&Masks::vertex, index(p.point) + vertices, &Masks::triangle, index(p.triangle));
  });
  std::erase_if(pairs.edge_edge, [&](const EdgeEdgePair& p) {
    return excluded(&Masks::edge, index(p.edge_a), &Masks::edge, index(p.edge_b) + edges);
  });
}

std::vector<char> ExcludedPairs::triangles_of_side(int side) const {
  std::vector<char> in(masks_.empty() ? 0 : masks_.front().triangle.size(), 0);
  for (const Masks& m : masks_)
    for (std::size_t t = 0; t < in.size(); ++t)
      if ((m.triangle[t] >> side & 1) != 0) in[t] = 1;
  return in;
}

}  // namespace selvedge::detail
