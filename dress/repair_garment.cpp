// SPDX-License-Identifier: MIT
//
// Repair of a finished garment: vertices inside the body go to the nearest point of its surface and
// a little out of it; triangles that still cross it are pushed along its normals; where that makes
// layers of the garment cross, the moved vertices become a smooth continuation of those around
// them. All tests are exact. What does not take part keeps its bits.
#include <fmt/format.h>
#include <selvedge/bodies/internal/triangle_tree.h>
#include <selvedge/core/base/internal/check.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/winding_number.h>
#include <selvedge/dress/internal/repair_garment.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>

namespace selvedge {
namespace {

constexpr double kPush = 2.5e-4;      // m, of a triangle that crosses the body, at a time
constexpr int kPushes = 24;           // at most, before the layers of the garment are tested
constexpr int kPatience = 8;          // pushes without fewer crossings, after which they end
constexpr int kRoundPatience = 3;     // the same for rounds
constexpr int kSmoothings = 30;       // sweeps over the vertices that are smoothed
constexpr double kFirstReach = 0.02;  // m, in which the surface of the body is looked for
constexpr std::size_t kMostPlaces = 8;

/// The point of a triangle that is nearest to p [Ericson, "Real-time collision detection", 2005,
/// 5.1.5].
Vec3 nearest_on(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  if (d3 >= 0.0 && d4 <= d3) return b;
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double whole = va + vb + vc;
  return whole > 0.0 ? Vec3(a + vb / whole * ab + vc / whole * ac) : a;
}

/// The garment with vertices at one position as one vertex.
struct Welded {
  std::vector<std::int32_t> vertex;  // of the garment's vertices
  TriangleMesh mesh;
};
Welded weld(const TriangleMesh& garment) {
  Welded welded;
  std::map<std::array<double, 3>, std::int32_t> at;
  for (const Vec3& x : garment.vertices) {
    const auto [place, is_new] = at.try_emplace(
        {x.x(), x.y(), x.z()}, static_cast<std::int32_t>(welded.mesh.vertices.size()));
    if (is_new) welded.mesh.vertices.push_back(x);
    welded.vertex.push_back(place->second);
  }
  for (const Triangle& t : garment.triangles) {
    const Triangle w = {welded.vertex[t[0]], welded.vertex[t[1]], welded.vertex[t[2]]};
    if (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]) welded.mesh.triangles.push_back(w);
  }
  return welded;
}

class Repair {
 public:
  Repair(const TriangleMesh& garment, const TriangleMesh& body, const RepairConfig& config)
      : welded_(weld(garment)),
        start_(welded_.mesh.vertices),
        x_(welded_.mesh.vertices),
        triangles_(welded_.mesh.triangles),
        body_(body),
        config_(config),
        winding_(body),
        skin_(body.triangles),
        normals_(vertex_normals(body.vertices, body.triangles)),
        is_active_(x_.size(), 0),
        beside_(x_.size()) {
    skin_.fit(body.vertices);
    for (const auto& [a, b] : unique_edges(triangles_)) {
      beside_[a].push_back(b);
      beside_[b].push_back(a);
    }
  }

  RepairResult run() {
    RepairResult result;
    std::vector<TrianglePair> with_body = body_pairs(triangles_), own = own_pairs();
    result.body_before = static_cast<std::int64_t>(with_body.size());
    result.self_before = static_cast<std::int64_t>(own.size());
    std::vector<std::int32_t> inside = inside_vertices(with_body);
    const std::vector<std::int32_t> inside_at_start = inside;
    result.inside = static_cast<std::int64_t>(inside.size());
    for (const std::int32_t v : inside) put_outside(v);
    for (const TrianglePair& pair : with_body) activate(triangles_[pair.triangle_a]);
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (int round = 0, since = 0; round < config_.rounds && since < kRoundPatience;
         ++round, ++since) {
      push_out();
      own = own_pairs();
      std::erase_if(own, [&](const TrianglePair& p) { return !takes_part(p); });
      if (own.empty()) break;
      if (own.size() < fewest) since = 0;
      fewest = std::min(fewest, own.size());
      smooth(own);
    }
    finish(inside_at_start, result);
    return result;
  }

 private:
  std::vector<TrianglePair> body_pairs(std::span<const Triangle> triangles) const {
    return find_meetings({x_, triangles}, {body_.vertices, body_.triangles}).all();
  }
  std::vector<TrianglePair> own_pairs() const { return find_meetings(x_, triangles_).all(); }

  bool is_inside(std::int32_t v) const { return winding_.at(x_[v]) > 0.5; }

  /// Those in the parts of the garment that the crossings with the body cut off.
  std::vector<std::int32_t> inside_vertices(const std::vector<TrianglePair>& pairs) const {
    std::vector<std::int32_t> open, found;
    std::vector<char> seen(x_.size(), 0);
    for (const TrianglePair& pair : pairs)
      for (const std::int32_t v : triangles_[pair.triangle_a]) open.push_back(v);
    while (!open.empty()) {
      const std::int32_t v = open.back();
      open.pop_back();
      if (seen[v]) continue;
      seen[v] = 1;
      if (!is_inside(v)) continue;
      found.push_back(v);
      open.insert(open.end(), beside_[v].begin(), beside_[v].end());
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  /// To the nearest point of the surface and out of it.
  void put_outside(std::int32_t v) {
    is_active_[v] = 1;
    double least = std::numeric_limits<double>::infinity();
    Vec3 nearest = x_[v], normal = Vec3::Zero();
    for (double reach = kFirstReach; least > reach && reach < 10.0; reach *= 2.0)
      skin_.for_each_near(x_[v], reach, [&](std::int32_t k) {
        const Triangle& t = body_.triangles[static_cast<std::size_t>(k)];
        const Vec3 &a = body_.vertices[t[0]], &b = body_.vertices[t[1]], &c = body_.vertices[t[2]];
        const Vec3 p = nearest_on(a, b, c, x_[v]);
        const double distance = (p - x_[v]).norm();
        if (distance >= least) return;
        least = distance;
        nearest = p;
        normal = (b - a).cross(c - a).normalized();
      });
    const Vec3 way = nearest - x_[v];
    const Vec3 out = way.norm() > 1e-6 ? Vec3(way.normalized()) : normal;
    x_[v] = nearest + config_.clearance * out;
  }

  void activate(const Triangle& t) {
    for (const std::int32_t v : t) is_active_[v] = 1;
  }
  bool takes_part(const TrianglePair& pair) const {
    const auto has_active = [&](std::int32_t t) {
      const Triangle& v = triangles_[t];
      return is_active_[v[0]] || is_active_[v[1]] || is_active_[v[2]];
    };
    return has_active(pair.triangle_a) || has_active(pair.triangle_b);
  }

  /// Pushes triangles that cross the body along the mean of its normals there.
  void push_out() {
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (int k = 0, since = 0; k < kPushes && since < kPatience; ++k, ++since) {
      std::vector<Triangle> near;
      for (const Triangle& t : triangles_)
        if (is_active_[t[0]] || is_active_[t[1]] || is_active_[t[2]]) near.push_back(t);
      if (near.empty()) return;
      const std::vector<TrianglePair> pairs = body_pairs(near);
      if (pairs.empty()) return;
      if (pairs.size() < fewest) since = 0;
      fewest = std::min(fewest, pairs.size());
      std::map<std::int32_t, Vec3> way;
      for (const TrianglePair& pair : pairs) {
        Vec3 normal = Vec3::Zero();
        for (const std::int32_t v : body_.triangles[static_cast<std::size_t>(pair.triangle_b)])
          normal += normals_[v];
        for (const std::int32_t v : near[static_cast<std::size_t>(pair.triangle_a)])
          way.try_emplace(v, Vec3::Zero()).first->second += normal;
      }
      for (const auto& [v, sum] : way) {
        is_active_[v] = 1;
        if (sum.norm() > 0.0) x_[v] += kPush * sum.normalized();
      }
    }
  }

  /// Lets the moved vertices of layers that cross follow those around them.
  void smooth(const std::vector<TrianglePair>& pairs) {
    std::vector<std::int32_t> list;
    for (const TrianglePair& pair : pairs)
      for (const std::int32_t t : {pair.triangle_a, pair.triangle_b})
        for (const std::int32_t v : triangles_[t]) {
          // From the second time on, also the vertices that did not move.
          if (is_active_[v]) list.push_back(v);
          is_active_[v] = 1;
        }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    for (int sweep = 0; sweep < kSmoothings; ++sweep)
      for (const std::int32_t v : list) {
        if (beside_[v].empty()) continue;
        Vec3 sum = Vec3::Zero();
        for (const std::int32_t w : beside_[v]) sum += x_[w];
        x_[v] = sum / static_cast<double>(beside_[v].size());
      }
    for (const std::int32_t v : list)
      if (is_inside(v)) put_outside(v);
  }

  void finish(const std::vector<std::int32_t>& inside, RepairResult& result) const {
    const std::vector<TrianglePair> with_body = body_pairs(triangles_), own = own_pairs();
    result.body_after = static_cast<std::int64_t>(with_body.size());
    result.self_after = static_cast<std::int64_t>(own.size());
    std::vector<double> motion;
    std::vector<char> was_inside(x_.size(), 0);
    for (const std::int32_t v : inside) was_inside[v] = 1;
    for (std::size_t v = 0; v < x_.size(); ++v) {
      const double by = (x_[v] - start_[v]).norm();
      if (by > 0.0) ++result.moved;
      result.largest_motion = std::max(result.largest_motion, by);
      if (!was_inside[v]) motion.push_back(by);
    }
    if (!motion.empty()) {
      const auto middle = motion.begin() + static_cast<std::ptrdiff_t>(motion.size() / 2);
      std::nth_element(motion.begin(), middle, motion.end());
      result.median_motion = *middle;
    }
    std::vector<char> crosses(x_.size(), 0);
    for (const TrianglePair& pair : with_body)
      for (const std::int32_t v : triangles_[pair.triangle_a]) crosses[v] = 1;
    for (const TrianglePair& pair : own)
      for (const std::int32_t t : {pair.triangle_a, pair.triangle_b})
        for (const std::int32_t v : triangles_[t]) crosses[v] = 1;
    name_places(crosses, result);
    for (const std::int32_t v : welded_.vertex) result.x.push_back(x_[v]);
  }

  /// The connected parts of marked vertices.
  void name_places(std::vector<char>& marked, RepairResult& result) const {
    for (std::size_t first = 0; first < marked.size(); ++first) {
      if (!marked[first]) continue;
      RepairPlace place{.at = x_[first], .vertices = 0};
      std::vector<std::int32_t> open = {static_cast<std::int32_t>(first)};
      marked[first] = 0;
      while (!open.empty()) {
        const std::int32_t v = open.back();
        open.pop_back();
        ++place.vertices;
        for (const std::int32_t w : beside_[v])
          if (marked[w]) {
            marked[w] = 0;
            open.push_back(w);
          }
      }
      result.left.push_back(place);
    }
    std::stable_sort(
        result.left.begin(), result.left.end(),
        [](const RepairPlace& a, const RepairPlace& b) { return a.vertices > b.vertices; });
    if (result.left.size() > kMostPlaces) result.left.resize(kMostPlaces);
  }

  Welded welded_;
  const std::vector<Vec3> start_;
  std::vector<Vec3> x_;
  const std::vector<Triangle>& triangles_;
  const TriangleMesh& body_;
  const RepairConfig& config_;
  detail::WindingNumber winding_;
  TriangleTree skin_;
  std::vector<Vec3> normals_;
  std::vector<char> is_active_;                    // moved, or beside a crossing
  std::vector<std::vector<std::int32_t>> beside_;  // the vertices at the edges of each
};

}  // namespace

RepairResult repair_garment(const TriangleMesh& garment, const TriangleMesh& body,
                            const RepairConfig& config) {
  require(config.clearance > 0.0 && std::isfinite(config.clearance), "clearance", config.clearance,
          "positive and finite");
  require(config.rounds >= 1, "rounds", config.rounds, "at least 1");
  if (garment.triangles.empty()) throw std::invalid_argument("the garment has no triangles");
  if (body.triangles.empty()) throw std::invalid_argument("the body has no triangles");
  return Repair(garment, body, config).run();
}

}  // namespace selvedge
