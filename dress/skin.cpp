// SPDX-License-Identifier: MIT
//
// The skin that made room comes out again. Between two parts of the body that cloth parts, it stays
// back by what the layers of cloth need; elsewhere it returns to the body of the user. The cloth
// moves with it, and every path is searched for collisions.
#include <selvedge/bodies/driven_body.h>
#include <selvedge/bodies/internal/triangle_tree.h>
#include <selvedge/dress/detail/body_room.h>
#include <selvedge/dress/detail/dressing.h>
#include <selvedge/simulation/run_result.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <span>

namespace selvedge::detail {
namespace {

constexpr double kLayerGap = 1.3;    // rest gaps that a layer of cloth needs on each side
constexpr double kReturnTime = 0.4;  // s, in which the skin comes out
constexpr double kBack = 1e-4;       // m, from which a vertex counts as held back
constexpr double kAhead = 1e-5;      // m, from where a ray looks

/// Distances along a ray at which it meets triangles, m, ascending.
std::vector<double> meetings(const TriangleTree& tree, std::span<const Vec3> x, const Vec3& from,
                             const Vec3& way, double reach) {
  std::vector<double> found;
  const Vec3 to = from + reach * way;
  tree.for_each_in_box(from.cwiseMin(to), from.cwiseMax(to), [&](std::int32_t k) {
    const Triangle& t = tree.triangles()[static_cast<std::size_t>(k)];
    const Vec3 u = x[t[1]] - x[t[0]], v = x[t[2]] - x[t[0]], n = u.cross(v), p = from - x[t[0]];
    const double across = n.dot(way);
    if (across == 0.0) return;
    const double distance = -n.dot(p) / across;
    if (distance < kAhead || distance > reach) return;
    const Vec3 hit = p + distance * way;
    const double a = hit.cross(v).dot(n), b = u.cross(hit).dot(n), whole = n.squaredNorm();
    if (a >= 0.0 && b >= 0.0 && a + b <= whole) found.push_back(distance);
  });
  std::sort(found.begin(), found.end());
  return found;
}

class ReturningSkin {
 public:
  ReturningSkin(Garment& garment, const Dressing& dressing, const TriangleMesh& body,
                TriangleMesh& worn, DressResult& result)
      : garment_(garment), dressing_(dressing), body_(body), worn_(worn), result_(result) {}

  void run() {
    const std::vector<Vec3> from = worn_.vertices, to = target();
    PhaseSettings settings{.gravity = Vec3(0.0, 0.0, -kGravity),
                           .drag = dressing_.config.settle_drag,
                           .friction = dressing_.config.body_friction,
                           .pull = dressing_.config.largest_pull};
    DressScene scene = make_dress_scene(garment_, worn_, dressing_.config, settings);
    DrivenBody& driven = drive_body(scene.built, 0);
    const auto simulation = start_simulation(scene, dressing_);
    const int frames =
        std::max(1, static_cast<int>(std::lround(kReturnTime * dressing_.config.fps)));
    std::vector<Vec3> x(from.size());
    try {
      for (int frame = 1; frame <= frames; ++frame) {
        const double share = static_cast<double>(frame) / frames;
        for (std::size_t v = 0; v < x.size(); ++v) x[v] = from[v] + share * (to[v] - from[v]);
        if (frame == frames) x = to;
        simulation->move_body(driven, x);
        simulation->advance_to_frame(frame, [&](double) {
          if (dressing_.observer.accepted)
            dressing_.observer.accepted(*simulation, DressPhase::settle);
        });
        if (dressing_.observer.frame)
          dressing_.observer.frame(*simulation, DressPhase::settle,
                                   result_.sew_time + result_.settle_time + simulation->time());
      }
    } catch (const SimulationFailed&) {
      // The cloth leaves no more room: the skin stays where it is in the last state.
    }
    take_state(*simulation, garment_);
    add_run(*simulation, "skin", result_);
    result_.settle_time += simulation->time();
    const std::vector<Vec3>& reached = simulation->body_positions();
    std::copy_n(reached.begin(), worn_.vertices.size(), worn_.vertices.begin());
  }

 private:
  /// The skin with room for the layers of cloth that are between its parts.
  std::vector<Vec3> target() const {
    std::vector<TriangleTree> cloth;
    std::vector<std::span<const Vec3>> x;
    const auto add = [&](std::span<const Vec3> vertices, const std::vector<Triangle>& triangles) {
      x.push_back(vertices);
      cloth.emplace_back(triangles).fit(vertices);
    };
    add(garment_.surface.vertices, garment_.surface.triangles);
    for (const UnderLayer& layer : garment_.under) add(layer.x, layer.worn->surface.triangles);
    TriangleTree skin(worn_.triangles);
    skin.fit(worn_.vertices);
    const double room = dressing_.config.body_room;
    std::vector<double> needed(body_.vertices.size(), 0.0);
    for (std::size_t v = 0; v < needed.size(); ++v) {
      const Vec3 back = body_.vertices[v] - worn_.vertices[v];
      if (back.isZero(0.0)) continue;
      const Vec3 way = back.normalized();
      const std::vector<double> other =
          meetings(skin, worn_.vertices, worn_.vertices[v], way, 2.0 * room);
      const double reach = other.empty() ? 2.0 * room : other.front();
      std::size_t layers = 0;
      for (std::size_t k = 0; k < cloth.size(); ++k)
        layers += meetings(cloth[k], x[k], worn_.vertices[v], way, reach).size();
      if (layers > 0)
        needed[v] =
            std::min(room, static_cast<double>(layers + 1) * kLayerGap * dressing_.config.rest_gap);
    }
    widen(needed);
    return with_room(body_, needed);
  }

  /// What a vertex needs, its neighbours need as well: cloth may lie between them.
  void widen(std::vector<double>& needed) const {
    const std::vector<double> own = needed;
    for (const Triangle& t : body_.triangles)
      for (const std::int32_t v : t)
        for (const std::int32_t w : t) needed[v] = std::max(needed[v], own[w]);
  }

  Garment& garment_;
  const Dressing& dressing_;
  const TriangleMesh& body_;
  TriangleMesh& worn_;
  DressResult& result_;
};

}  // namespace

void return_skin(Garment& garment, const Dressing& dressing, const TriangleMesh& body,
                 TriangleMesh& worn, DressResult& result) {
  ReturningSkin(garment, dressing, body, worn, result).run();
}

void report_skin(const TriangleMesh& body, DressResult& result) {
  const std::vector<Vec3>& worn = result.body.vertices;
  std::vector<std::int32_t> part(worn.size(), -1);
  const auto back = [&](std::size_t v) { return (body.vertices[v] - worn[v]).norm(); };
  const auto root = [&](std::int32_t v) {
    while (part[v] != v) v = part[v] = part[part[v]];
    return v;
  };
  result.body_moved = 0;
  result.body_moved_by = 0.0;
  for (std::size_t v = 0; v < worn.size(); ++v) {
    if (back(v) < kBack) continue;
    part[v] = static_cast<std::int32_t>(v);
    ++result.body_moved;
    result.body_moved_by = std::max(result.body_moved_by, back(v));
  }
  for (const Triangle& t : body.triangles)
    for (const std::int32_t v : t)
      if (part[v] >= 0 && part[t[0]] >= 0) {
        const std::int32_t a = root(t[0]), b = root(v);
        part[std::max(a, b)] = std::min(a, b);
      }
  std::vector<SkinPlace> places(worn.size());
  for (std::size_t v = 0; v < worn.size(); ++v) {
    if (part[v] < 0) continue;
    SkinPlace& place = places[static_cast<std::size_t>(root(static_cast<std::int32_t>(v)))];
    ++place.vertices;
    if (back(v) <= place.by) continue;
    place.by = back(v);
    place.at = worn[v];
  }
  std::erase_if(places, [](const SkinPlace& place) { return place.vertices == 0; });
  std::stable_sort(places.begin(), places.end(),
                   [](const SkinPlace& a, const SkinPlace& b) { return a.by > b.by; });
  result.skin = std::move(places);
}

}  // namespace selvedge::detail
