// SPDX-License-Identifier: MIT
//
// Unpicking: a fold of cloth may lie between the two sides of a seam that is closed on both sides
// of the fold, and then never comes out. Pairs around the open ones are separated again, as a
// tailor unpicks a seam, by a small way towards the panel of each side, which is searched for
// collisions.
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/dressing.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace selvedge::detail {
namespace {

constexpr double kApart = 0.25;  // rest gaps, by which a side moves at first
constexpr int kHalvings = 8;     // of this way

class Unpicking {
 public:
  Unpicking(const Garment& garment, const TriangleMesh& body, int around)
      : garment_(garment), body_(body), around_(around) {}

  bool run(double way, Garment& out) {
    choose();
    if (unpicked_.empty()) return false;
    split();
    for (int k = 0; k < kHalvings; ++k, way *= 0.5) {
      move_apart(way);
      if (!is_free()) continue;
      out = std::move(split_);
      return true;
    }
    return false;
  }

 private:
  /// The merged pairs near open ones of their stitch.
  void choose() {
    for (const Stitching& stitch : garment_.stitches) {
      const auto n = static_cast<std::ptrdiff_t>(stitch.a.size());
      const auto is_open = [&](std::ptrdiff_t i) {
        return garment_.corner[stitch.a[i]] != garment_.corner[stitch.b[i]];
      };
      for (std::ptrdiff_t i = 0; i < n; ++i) {
        bool is_near = false;
        for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, i - around_);
             k <= std::min(n - 1, i + around_); ++k)
          is_near = is_near || is_open(k);
        if (is_open(i)) continue;
        if (is_near)
          unpicked_.push_back({stitch.a[i], stitch.b[i]});
        else
          kept_.push_back({stitch.a[i], stitch.b[i]});
      }
    }
  }

  /// The garment with a vertex for each group of vertices of the flat pattern that kept pairs join.
  void split() {
    std::vector<std::int32_t> root(garment_.corner.size());
    std::iota(root.begin(), root.end(), 0);
    const auto root_of = [&](std::int32_t v) {
      while (root[v] != v) v = root[v] = root[root[v]];
      return v;
    };
    for (const Edge& pair : kept_) {
      const std::int32_t a = root_of(pair[0]), b = root_of(pair[1]);
      root[std::max(a, b)] = std::min(a, b);
    }
    split_ = garment_;
    split_.surface.vertices.clear();
    split_.velocity.clear();
    std::map<std::int32_t, std::int32_t> number;  // by root
    for (std::size_t f = 0; f < root.size(); ++f) {
      const auto [at, is_new] = number.try_emplace(root_of(static_cast<std::int32_t>(f)),
                                                   static_cast<std::int32_t>(before_.size()));
      split_.corner[f] = at->second;
      if (!is_new) continue;
      before_.push_back(garment_.corner[f]);
      split_.surface.vertices.push_back(garment_.surface.vertices[garment_.corner[f]]);
      split_.velocity.push_back(garment_.velocity[garment_.corner[f]]);
    }
    for (std::size_t i = 0; i < split_.flat.triangles.size(); ++i)
      for (int k = 0; k < 3; ++k)
        split_.surface.triangles[i][k] = split_.corner[split_.flat.triangles[i][k]];
    start_ = split_.surface.vertices;
  }

  /// Moves each vertex that has been separated towards the vertices around it.
  void move_apart(double way) {
    std::vector<int> parts(garment_.surface.vertices.size(), 0);
    for (const std::int32_t v : before_) ++parts[v];
    std::vector<Vec3> sum(start_.size(), Vec3::Zero());
    std::vector<double> count(start_.size(), 0.0);
    for (const Triangle& t : split_.surface.triangles)
      for (int k = 0; k < 3; ++k) {
        sum[t[k]] += start_[t[(k + 1) % 3]] + start_[t[(k + 2) % 3]];
        count[t[k]] += 2.0;
      }
    split_.surface.vertices = start_;
    for (std::size_t v = 0; v < start_.size(); ++v)
      if (parts[before_[v]] > 1 && count[v] > 0.0)
        split_.surface.vertices[v] += way * (sum[v] / count[v] - start_[v]).normalized();
  }

  /// Whether nothing meets afterwards, and nothing but the former neighbours on the way.
  bool is_free() const {
    const std::vector<Vec3>& x = split_.surface.vertices;
    const std::vector<Triangle>& triangles = split_.surface.triangles;
    if (!find_meetings(x, triangles).empty()) return false;
    if (!find_collisions(MovingSurface{start_, x, triangles},
                         {body_.vertices, body_.vertices, body_.triangles})
             .empty())
      return false;
    for (const Collision& c : find_collisions(start_, x, triangles)) {
      const std::size_t first =
          c.kind == ContactKind::edge_edge ? 2 : 1;  // of the second primitive
      bool were_neighbours = false;
      for (std::size_t i = 0; i < first; ++i)
        for (std::size_t k = first; k < c.vertex.size(); ++k)
          were_neighbours = were_neighbours || before_[c.vertex[i]] == before_[c.vertex[k]];
      if (!were_neighbours) return false;
    }
    return true;
  }

  const Garment& garment_;
  const TriangleMesh& body_;
  std::ptrdiff_t around_;
  std::vector<Edge> unpicked_, kept_;  // pairs, as vertices of the flat pattern
  Garment split_;
  std::vector<std::int32_t> before_;  // of each of its vertices, that of the garment
  std::vector<Vec3> start_;           // m
};

}  // namespace

bool unpick(Garment& garment, const Dressing& dressing, int around) {
  return Unpicking(garment, dressing.body, around).run(kApart * dressing.config.rest_gap, garment);
}

}  // namespace selvedge::detail
