// SPDX-License-Identifier: MIT
#include <selvedge/core/base/types.h>
#include <selvedge/dress/detail/dressing.h>

#include <algorithm>
#include <map>
#include <utility>

namespace selvedge::detail {
namespace {

/// The vertex in the middle of each edge of a mesh.
class Middles {
 public:
  explicit Middles(std::size_t vertices) : next_(static_cast<std::int32_t>(vertices)) {}

  std::int32_t of(std::int32_t a, std::int32_t b) {
    const auto [place, is_new] = middle_.try_emplace({std::min(a, b), std::max(a, b)}, next_);
    if (is_new) {
      ++next_;
      ends_.push_back(place->first);
    }
    return place->second;
  }
  const std::vector<Edge>& ends() const { return ends_; }  ///< of the new vertices, in order

 private:
  std::map<Edge, std::int32_t> middle_;
  std::vector<Edge> ends_;
  std::int32_t next_;
};

Middles split_triangles(std::vector<Triangle>& triangles, std::size_t vertices) {
  Middles middles(vertices);
  std::vector<Triangle> fine;
  fine.reserve(4 * triangles.size());
  for (const auto& [a, b, c] : triangles) {
    const std::int32_t ab = middles.of(a, b), bc = middles.of(b, c), ca = middles.of(c, a);
    for (const Triangle& t : {Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
      fine.push_back(t);
  }
  triangles = std::move(fine);
  return middles;
}

void add_means(std::vector<Vec3>& values, const std::vector<Edge>& ends) {
  for (const auto& [a, b] : ends) values.push_back(0.5 * (values[a] + values[b]));
}

std::vector<std::int32_t> divided(const std::vector<std::int32_t>& row, Middles& middles) {
  std::vector<std::int32_t> fine;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i > 0) fine.push_back(middles.of(row[i - 1], row[i]));
    fine.push_back(row[i]);
  }
  return fine;
}

/// Puts every second vertex of a curved edge onto its curve. The plane of the pattern and that of
/// the flat panel differ by a shift and perhaps a mirror, which follow from vertices of the edge.
void bend(const SewingPattern& pattern, const DividedEdge& border, bool mirrored,
          std::vector<Vec3>& flat) {
  const PatternPanel& panel = pattern.panels[static_cast<std::size_t>(border.panel)];
  const auto pieces = static_cast<std::int32_t>(border.vertices.size()) - 1;
  if (pieces == 0) return;  // joined with its neighbours
  const std::vector<Vec2> curve = divide_edge(panel, border.edge, pieces);
  const double sign = mirrored ? -1.0 : 1.0;
  const auto laid = [&](std::size_t i) { return Vec3(sign * curve[i].x(), curve[i].y(), 0.0); };
  // The shifts of both ends differ where a joined edge begins or ends.
  const Vec3 first = flat[border.vertices.front()] - laid(0),
             last = flat[border.vertices.back()] - laid(curve.size() - 1);
  for (std::size_t i = 1; i < border.vertices.size(); i += 2)
    flat[border.vertices[i]] = laid(i) + first + static_cast<double>(i) / pieces * (last - first);
}

}  // namespace

void split_garment(const SewingPattern& pattern, Garment& garment) {
  Middles flat_middles = split_triangles(garment.flat.triangles, garment.flat.vertices.size());
  Middles middles = split_triangles(garment.surface.triangles, garment.surface.vertices.size());
  add_means(garment.flat.vertices, flat_middles.ends());
  add_means(garment.surface.vertices, middles.ends());
  add_means(garment.velocity, middles.ends());
  std::vector<std::int32_t> corner = garment.corner;
  for (const auto& [a, b] : flat_middles.ends())
    corner.push_back(middles.of(garment.corner[a], garment.corner[b]));
  garment.corner = std::move(corner);
  garment.image.clear();
  std::vector<std::int32_t> panels;
  for (const std::int32_t panel : garment.panel_of_triangle) panels.insert(panels.end(), 4, panel);
  garment.panel_of_triangle = std::move(panels);
  for (Stitching& stitch : garment.stitches) {
    stitch.a = divided(stitch.a, flat_middles);
    stitch.b = divided(stitch.b, flat_middles);
    stitch.spacing *= 0.5;
    std::vector<char> joined;  // no button is between two old pairs
    for (std::size_t i = 0; i < stitch.is_joined.size(); ++i) {
      if (i > 0) joined.push_back(0);
      joined.push_back(stitch.is_joined[i]);
    }
    stitch.is_joined = std::move(joined);
  }
  for (DividedFold& fold : garment.folds) fold.vertices = divided(fold.vertices, flat_middles);
  for (DividedElastic& elastic : garment.elastics)
    elastic.vertices = divided(elastic.vertices, flat_middles);
  for (DividedEdge& border : garment.borders) {
    border.vertices = divided(border.vertices, flat_middles);
    bend(pattern, border, garment.mirrored[static_cast<std::size_t>(border.panel)] != 0,
         garment.flat.vertices);
  }
}

}  // namespace selvedge::detail
