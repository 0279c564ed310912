// SPDX-License-Identifier: MIT
//
// Cloth that surfaces of bodies hold between them, where they leave it no room.
#include <selvedge/simulation/detail/untangle.h>

#include <algorithm>
#include <limits>

namespace selvedge::detail {
namespace {

void unite_sorted(std::vector<std::int32_t>& all, std::vector<std::int32_t> more) {
  all.insert(all.end(), more.begin(), more.end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
}

bool holds(std::span<const Pinch> pinches, std::int32_t vertex) {
  const auto at = std::lower_bound(pinches.begin(), pinches.end(), vertex,
                                   [](const Pinch& p, std::int32_t v) { return p.vertex < v; });
  return at != pinches.end() && at->vertex == vertex;
}

}  // namespace

// All triangles of connected parts of the bodies.
std::vector<std::int32_t> Untangler::triangles_of_parts(std::vector<std::int32_t> parts) const {
  std::sort(parts.begin(), parts.end());
  std::vector<std::int32_t> triangles;
  if (parts.empty()) return triangles;
  for (std::size_t t = surface_.cloth_triangles(); t < surface_.triangles().size(); ++t)
    if (std::binary_search(parts.begin(), parts.end(), surface_.part(surface_.triangles()[t][0])))
      triangles.push_back(static_cast<std::int32_t>(t));
  return triangles;
}

// The triangles around the pinched vertices, and the whole parts of the bodies that hold them.
void Untangler::add_pinches(Tangle& tangle) const {
  std::vector<std::int32_t> cloth, parts;
  const auto first = static_cast<std::int32_t>(surface_.cloth_triangles());
  for (const Pinch& pinch : pinches_) {
    for (const std::int32_t t : surface_.triangles_of_vertex(pinch.vertex)) cloth.push_back(t);
    for (const std::int32_t t : pinch.triangle)
      parts.push_back(surface_.part(surface_.triangles()[first + t][0]));
  }
  unite_sorted(tangle.side[0], std::move(cloth));
  unite_sorted(tangle.side[1], triangles_of_parts(std::move(parts)));
}

// The triangles that cross at a contour, and all those of the parts of bodies among them: a
// crossing of cloth that is free again must be able to slide until it comes out.
Tangle Untangler::crossing(std::size_t contour) const {
  const Contour& c = contours_[contour];
  Tangle tangle;
  std::vector<std::int32_t> parts;
  const auto take = [&](int side, std::int32_t t) {
    const std::int32_t v = surface_.triangles()[t][0];
    if (surface_.is_cloth(v))
      tangle.side[side].push_back(t);
    else
      parts.push_back(surface_.part(v));
  };
  int of_body = 1;
  for (std::size_t i = 0; i < c.nodes.size(); ++i) {
    for (const std::int32_t t : surface_.triangles_of_edge(c.nodes[i].edge)) take(c.side[i], t);
    take(1 - c.side[i], c.nodes[i].triangle);
    if (!surface_.is_cloth(surface_.edges()[c.nodes[i].edge][0]))
      of_body = c.side[i];
    else if (!surface_.is_cloth(surface_.triangles()[c.nodes[i].triangle][0]))
      of_body = 1 - c.side[i];
  }
  unite_sorted(tangle.side[1 - of_body], {});
  unite_sorted(tangle.side[of_body], triangles_of_parts(std::move(parts)));
  return tangle;
}

void Untangler::set_pinches(std::span<const Pinch> pinches) {
  const bool same = std::equal(pinches.begin(), pinches.end(), pinches_.begin(), pinches_.end(),
                               [](const Pinch& a, const Pinch& b) {
                                 return a.vertex == b.vertex && a.triangle == b.triangle;
                               });
  pinches_.assign(pinches.begin(), pinches.end());
  if (same || !carries_pinches()) return;
  for (Tangle& tangle : tangles_.list)
    if (tangle.pinch) {
      tangle.side = crossing_;
      add_pinches(tangle);
    }
  exclude_tangles();
}

bool Untangler::carries_pinches() const {
  return std::any_of(tangles_.list.begin(), tangles_.list.end(),
                     [](const Tangle& tangle) { return tangle.pinch; });
}

bool Untangler::carry_pinches(std::span<const ContactPoint> hits, std::span<const Pinch> pinches) {
  const bool pinched = std::any_of(hits.begin(), hits.end(), [&](const ContactPoint& hit) {
    return std::any_of(hit.vertex.begin(), hit.vertex.end(),
                       [&](std::int32_t v) { return holds(pinches, v); });
  });
  if (!pinched || carries_pinches()) return false;
  pinches_.assign(pinches.begin(), pinches.end());
  Tangle jam;
  jam.jam = jam.pinch = true;
  jam.best = std::numeric_limits<int>::max();
  add_pinches(jam);
  crossing_ = {};
  std::erase_if(tangles_.list, [](const Tangle& tangle) { return tangle.is_over(); });
  tangles_.list.push_back(std::move(jam));
  exclude_tangles();
  report_.until_s = -1.0;
  ++report_.jams;
  return true;
}

// Whether an edge or a triangle of the contour has a pinched vertex.
bool Untangler::is_pinched(const Contour& contour) const {
  if (pinches_.empty()) return false;
  return std::any_of(contour.nodes.begin(), contour.nodes.end(), [&](const EdgeCrossing& node) {
    const Edge& e = surface_.edges()[node.edge];
    const Triangle& t = surface_.triangles()[node.triangle];
    return std::any_of(e.begin(), e.end(), [&](auto v) { return holds(pinches_, v); }) ||
           std::any_of(t.begin(), t.end(), [&](auto v) { return holds(pinches_, v); });
  });
}

}  // namespace selvedge::detail
