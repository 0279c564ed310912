// SPDX-License-Identifier: MIT
//
// Unpicking: a fold of cloth may lie between the two sides of a seam that is closed on both sides
// of the fold, and then never comes out. Pairs around the open ones are separated again, as a
// tailor unpicks a seam, by a small way towards the panel of each side, which is searched for
// collisions. Where three panels meet, as front, back and hood at the neck, the fold may be of the
// third one, whose corner holds it there.
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/dressing.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <set>
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
    while (!unpicked_.empty()) {
      split();
      std::set<std::int32_t> blocked;
      for (int k = 0; k < kHalvings; ++k) {
        move_apart(std::ldexp(way, -k));
        blocked = blocked_vertices();
        if (!blocked.empty()) continue;
        out = std::move(split_);
        return true;
      }
      if (!keep(blocked)) return false;
    }
    return false;
  }

 private:
  using SewnPair = std::pair<std::size_t, std::size_t>;  // a stitch and its pair

  std::vector<SewnPair> all_pairs() const {
    std::vector<SewnPair> all;
    for (std::size_t s = 0; s < garment_.stitches.size(); ++s)
      for (std::size_t i = 0; i < garment_.stitches[s].a.size(); ++i) all.push_back({s, i});
    return all;
  }

  Edge ends(const SewnPair& pair) const {
    const Stitching& stitch = garment_.stitches[pair.first];
    return {garment_.corner[stitch.a[pair.second]], garment_.corner[stitch.b[pair.second]]};
  }

  bool is_open(const SewnPair& pair) const {
    const Edge vertices = ends(pair);
    const std::vector<Edge> open = garment_.open_pairs(pair.first);
    return std::find(open.begin(), open.end(), vertices) != open.end();
  }

  /// The merged pairs within `around_` steps of an open one, along its seam and round the corners
  /// where its ends meet other seams: the panel between those may lie in the open one.
  void choose() {
    std::map<std::int32_t, std::vector<SewnPair>> at;  // by vertex of the surface
    for (const SewnPair& pair : all_pairs())
      for (const std::int32_t v : ends(pair)) at[v].push_back(pair);
    std::map<SewnPair, int> steps;
    std::deque<SewnPair> queue;
    const auto reach = [&](const SewnPair& pair, int taken) {
      if (taken <= around_ && steps.try_emplace(pair, taken).second) queue.push_back(pair);
    };
    for (const SewnPair& pair : all_pairs())
      if (is_open(pair)) reach(pair, 0);
    for (; !queue.empty(); queue.pop_front()) {
      const SewnPair pair = queue.front();
      const auto& [s, i] = pair;
      const int taken = steps[pair] + 1;
      if (i > 0) reach({s, i - 1}, taken);
      if (i + 1 < garment_.stitches[s].a.size()) reach({s, i + 1}, taken);
      for (const std::int32_t v : ends(pair))
        for (const SewnPair& other : at[v]) reach(other, taken);
    }
    for (const SewnPair& pair : all_pairs()) {
      const auto& [s, i] = pair;
      const Edge vertices{garment_.stitches[s].a[i], garment_.stitches[s].b[i]};
      if (garment_.corner[vertices[0]] == garment_.corner[vertices[1]])
        (steps.contains(pair) ? unpicked_ : kept_).push_back(vertices);
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
    before_.clear();
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

  /// Leaves the pairs with one of these vertices as they are, crumpled as the cloth may be there.
  /// Returns whether there were any.
  bool keep(const std::set<std::int32_t>& vertices) {
    const auto kept =
        std::stable_partition(unpicked_.begin(), unpicked_.end(), [&](const Edge& pair) {
          return !vertices.contains(split_.corner[pair[0]]) &&
                 !vertices.contains(split_.corner[pair[1]]);
        });
    const bool any = kept != unpicked_.end();
    kept_.insert(kept_.end(), kept, unpicked_.end());
    unpicked_.erase(kept, unpicked_.end());
    return any;
  }

  /// The vertices that meet anything afterwards, or anything but former neighbours on the way.
  std::set<std::int32_t> blocked_vertices() const {
    const std::vector<Vec3>& x = split_.surface.vertices;
    const std::vector<Triangle>& triangles = split_.surface.triangles;
    std::set<std::int32_t> found;
    for (const TrianglePair& pair : find_meetings(x, triangles).all())
      for (const std::int32_t t : {pair.triangle_a, pair.triangle_b})
        found.insert(triangles[t].begin(), triangles[t].end());
    const auto add = [&](const Collision& c, std::size_t begin, std::size_t end) {
      found.insert(c.vertex.begin() + static_cast<std::ptrdiff_t>(begin),
                   c.vertex.begin() + static_cast<std::ptrdiff_t>(end));
    };
    const auto first_of = [](const Collision& c) {  // the end of the first primitive
      return std::size_t{c.kind == ContactKind::edge_edge ? 2u : 1u};
    };
    for (const Collision& c : find_collisions(MovingSurface{start_, x, triangles},
                                              {body_.vertices, body_.vertices, body_.triangles})) {
      const bool is_body_first = c.kind == ContactKind::triangle_point;
      add(c, is_body_first ? first_of(c) : 0, is_body_first ? c.vertex.size() : first_of(c));
    }
    for (const Collision& c : find_collisions(start_, x, triangles)) {
      const std::size_t first = first_of(c);
      bool were_neighbours = false;
      for (std::size_t i = 0; i < first; ++i)
        for (std::size_t k = first; k < c.vertex.size(); ++k)
          were_neighbours = were_neighbours || before_[c.vertex[i]] == before_[c.vertex[k]];
      if (!were_neighbours) add(c, 0, c.vertex.size());
    }
    return found;
  }

  const Garment& garment_;
  const TriangleMesh& body_;
  int around_;
  std::vector<Edge> unpicked_, kept_;  // pairs, as vertices of the flat pattern
  Garment split_;
  std::vector<std::int32_t> before_;  // of each of its vertices, that of the garment
  std::vector<Vec3> start_;           // m
};

}  // namespace

bool has_layer_between(const Garment& garment, std::span<const Edge> pairs) {
  std::vector<Triangle> ways;
  for (const Edge& pair : pairs) ways.push_back({pair[0], pair[1], pair[1]});
  const std::vector<Vec3>& x = garment.surface.vertices;
  return !find_crossings({x, ways}, {x, garment.surface.triangles}).empty();
}

bool unpick(Garment& garment, const Dressing& dressing, int around) {
  return Unpicking(garment, dressing.body, around).run(kApart * dressing.config.rest_gap, garment);
}

}  // namespace selvedge::detail
