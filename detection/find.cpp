// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/registry.h>
#include <selvedge/core/base/types.h>
#include <selvedge/detection/detail/surface_checks.h>
#include <selvedge/detection/find.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

namespace selvedge {
namespace {

using detail::check_triangles;
using detail::check_vertices;

// Boxes grow by this share of the largest coordinate, far more than the rounding of a box, so that
// a pair at exactly the separation is a candidate of every detector. The narrow phase decides.
constexpr double kBoxReserve = 0x1p-40;

double largest_coordinate(std::span<const Vec3> x) {
  double largest = 0.0;
  for (const Vec3& p : x) largest = std::max(largest, p.lpNorm<Eigen::Infinity>());
  return largest;
}

// A checked surface with its edges, and the vertices that no triangle uses.
class PreparedSurface {
 public:
  PreparedSurface(const MovingSurface& surface, const std::string& name) : surface_(surface) {
    if (surface.x_t0.size() != surface.x_t1.size())
      throw std::invalid_argument(name + ": x_t0 has " + std::to_string(surface.x_t0.size()) +
                                  " vertices, x_t1 has " + std::to_string(surface.x_t1.size()));
    check_vertices(surface.x_t0, name, "x_t0");
    check_vertices(surface.x_t1, name, "x_t1");
    prepare(name);
  }
  PreparedSurface(const SurfaceState& state, const std::string& name)
      : surface_{state.x, state.x, state.triangles} {
    check_vertices(state.x, name, "x");
    prepare(name);
  }

  SurfaceView view(double thickness = 0.0) const {
    return {surface_.x_t0, surface_.x_t1, edges_, surface_.triangles, thickness};
  }
  std::span<const Edge> edges() const { return edges_; }
  std::span<const Triangle> triangles() const { return surface_.triangles; }
  bool is_used(std::int32_t vertex) const { return used_[vertex] != 0; }
  double largest() const {
    return std::max(largest_coordinate(surface_.x_t0), largest_coordinate(surface_.x_t1));
  }

 private:
  void prepare(const std::string& name) {
    check_triangles(surface_.triangles, surface_.x_t0.size(), name);
    edges_ = unique_edges(surface_.triangles);
    used_.assign(surface_.x_t0.size(), 0);
    for (const Triangle& t : surface_.triangles)
      for (const std::int32_t v : t) used_[v] = 1;
  }

  MovingSurface surface_;
  std::vector<Edge> edges_;
  std::vector<char> used_;
};

double inflation(double distance, const PreparedSurface& a, const PreparedSurface& b) {
  return 0.5 * distance + kBoxReserve * std::max(a.largest(), b.largest());
}

// `b` is `a` itself for one surface.
CandidatePairs candidates(BroadPhase& broad, const PreparedSurface& a, const PreparedSurface& b,
                          double distance) {
  CandidatePairs pairs;
  const double thickness = inflation(distance, a, b);
  if (&a == &b)
    broad.find_self_pairs(a.view(thickness), pairs);
  else
    broad.find_pairs(a.view(thickness), b.view(thickness), pairs);
  // Some detectors report vertices of no triangle, others do not.
  std::erase_if(pairs.point_triangle, [&](const auto& pair) { return !a.is_used(pair.point); });
  std::erase_if(pairs.triangle_point, [&](const auto& pair) { return !b.is_used(pair.point); });
  return pairs;
}

// Adds the indices of the primitives to contacts, which name vertices alone: contacts are in the
// order of the pairs.
template <class Found, class Complete>
std::vector<Found> with_primitives(const PreparedSurface& a, const PreparedSurface& b,
                                   const CandidatePairs& pairs,
                                   const std::vector<Contact>& contacts, Complete complete) {
  std::vector<Found> out;
  auto next = contacts.begin();
  const auto offer = [&](ContactKind kind, std::int32_t primitive_a, std::int32_t primitive_b,
                         const std::array<std::int32_t, 4>& vertex) {
    if (next == contacts.end() || next->kind != kind || next->vertex != vertex) return;
    Found& found = out.emplace_back();
    static_cast<PrimitivePair&>(found) = {kind,   primitive_a,  primitive_b,
                                          vertex, next->weight, next->normal};
    complete(*next, found);
    ++next;
  };
  for (const auto& [point, triangle] : pairs.point_triangle) {
    const Triangle& t = b.triangles()[triangle];
    offer(ContactKind::point_triangle, point, triangle, {point, t[0], t[1], t[2]});
  }
  for (const auto& [point, triangle] : pairs.triangle_point) {
    const Triangle& t = a.triangles()[triangle];
    offer(ContactKind::triangle_point, triangle, point, {point, t[0], t[1], t[2]});
  }
  for (const auto& [edge_a, edge_b] : pairs.edge_edge) {
    const Edge &e = a.edges()[edge_a], &f = b.edges()[edge_b];
    offer(ContactKind::edge_edge, edge_a, edge_b, {e[0], e[1], f[0], f[1]});
  }
  if (next != contacts.end())
    throw std::logic_error("the narrow phase did not report contacts in the order of the pairs");
  return out;
}

auto indices(const PrimitivePair& pair) {
  return std::tuple(pair.kind, pair.primitive_a, pair.primitive_b);
}

// The method `name` of a registry; faults begin with the field of DetectionConfig.
template <class Registry>
auto make_named(const Registry& registry, const std::string& name, const char* field,
                const MethodOptions& options = {}) {
  if (const std::string fault = registry.fault(name); !fault.empty())
    throw std::invalid_argument(std::string(field) + ": " + fault);
  return registry.at(name)(options);
}

void refuse_bad_distance(double distance, const char* name) {
  if (!(distance >= 0.0) || !std::isfinite(distance))
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(distance) +
                                " m; it must be finite and not negative");
}

CandidatePairs checked_candidates(BroadPhase& broad, const PreparedSurface& a,
                                  const PreparedSurface& b, double distance, const char* name) {
  refuse_bad_distance(distance, name);
  if (&a == &b && !broad.traits().self)
    throw std::invalid_argument("this broad phase cannot search one surface for pairs with itself");
  return candidates(broad, a, b, distance);
}

std::vector<Collision> collisions(const PreparedSurface& a, const PreparedSurface& b,
                                  const DetectionMethods& methods) {
  const CandidatePairs pairs =
      checked_candidates(methods.broad_phase, a, b, methods.min_separation, "min_separation");
  const SurfaceView view_a = a.view(), view_b = b.view();
  std::vector<Contact> contacts;
  methods.narrow_phase.find_contacts(view_a, &a == &b ? view_a : view_b, pairs, contacts);
  auto out = with_primitives<Collision>(
      a, b, pairs, contacts, [](const Contact& contact, Collision& c) { c.toi = contact.toi; });
  std::sort(out.begin(), out.end(), [](const Collision& c, const Collision& d) {
    return std::tuple(c.toi, indices(c)) < std::tuple(d.toi, indices(d));
  });
  return out;
}

std::vector<Collision> collisions(const PreparedSurface& a, const PreparedSurface& b,
                                  const DetectionConfig& config) {
  refuse_bad_distance(config.min_separation, "min_separation");
  const auto broad = make_named(broad_phases(), config.broad_phase, "broad_phase");
  MethodOptions options;
  if (config.min_separation > 0.0) options.set("min_separation", config.min_separation);
  const auto narrow = make_named(narrow_phases(), config.narrow_phase, "narrow_phase", options);
  if (&a == &b && !broad->traits().self)
    throw std::invalid_argument("broad_phase: " + config.broad_phase +
                                " cannot search one surface for pairs with itself");
  return collisions(a, b, {*broad, *narrow, config.min_separation});
}

std::vector<Proximity> contacts_within(const PreparedSurface& a, const PreparedSurface& b,
                                       double distance) {
  if (!(distance > 0.0) || !std::isfinite(distance))
    throw std::invalid_argument("distance is " + std::to_string(distance) +
                                " m; it must be finite and positive");
  const CandidatePairs pairs = candidates(*make_bvh_aabb(), a, b, distance);
  const SurfaceView view_a = a.view(), view_b = b.view();
  std::vector<Contact> contacts;
  find_proximities(view_a, &a == &b ? view_a : view_b, pairs, {.reach = distance}, contacts);
  auto out = with_primitives<Proximity>(
      a, b, pairs, contacts, [](const Contact& contact, Proximity& p) { p.gap = contact.gap; });
  std::sort(out.begin(), out.end(), [](const Proximity& p, const Proximity& q) {
    return std::tuple(p.gap, indices(p)) < std::tuple(q.gap, indices(q));
  });
  return out;
}

}  // namespace

std::vector<Collision> find_collisions(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1,
                                       std::span<const Triangle> triangles,
                                       const DetectionConfig& config) {
  const PreparedSurface surface(MovingSurface{x_t0, x_t1, triangles}, "surface");
  return collisions(surface, surface, config);
}

std::vector<Collision> find_collisions(const MovingSurface& a, const MovingSurface& b,
                                       const DetectionConfig& config) {
  const PreparedSurface prepared_a(a, "a"), prepared_b(b, "b");
  return collisions(prepared_a, prepared_b, config);
}

std::vector<Collision> find_collisions(const DetectionMethods& methods,
                                       const MovingSurface& surface) {
  const PreparedSurface prepared(surface, "surface");
  return collisions(prepared, prepared, methods);
}

std::vector<Collision> find_collisions(const DetectionMethods& methods, const MovingSurface& a,
                                       const MovingSurface& b) {
  const PreparedSurface prepared_a(a, "a"), prepared_b(b, "b");
  return collisions(prepared_a, prepared_b, methods);
}

CandidatePairs find_candidates(BroadPhase& broad_phase, const MovingSurface& surface,
                               double distance) {
  const PreparedSurface prepared(surface, "surface");
  return checked_candidates(broad_phase, prepared, prepared, distance, "distance");
}

CandidatePairs find_candidates(BroadPhase& broad_phase, const MovingSurface& a,
                               const MovingSurface& b, double distance) {
  const PreparedSurface prepared_a(a, "a"), prepared_b(b, "b");
  return checked_candidates(broad_phase, prepared_a, prepared_b, distance, "distance");
}

TriangleMeetings find_meetings(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  const PreparedSurface surface(SurfaceState{x, triangles}, "surface");
  TriangleMeetings found;
  TriangleTest().find_self(surface.view(), found);
  return found;
}

TriangleMeetings find_meetings(const SurfaceState& a, const SurfaceState& b) {
  const PreparedSurface prepared_a(a, "a"), prepared_b(b, "b");
  TriangleMeetings found;
  TriangleTest().find(prepared_a.view(), prepared_b.view(), found);
  return found;
}

std::vector<TrianglePair> find_crossings(std::span<const Vec3> x,
                                         std::span<const Triangle> triangles) {
  return find_meetings(x, triangles).crossings;
}

std::vector<TrianglePair> find_crossings(const SurfaceState& a, const SurfaceState& b) {
  return find_meetings(a, b).crossings;
}

std::vector<Proximity> find_contacts(std::span<const Vec3> x, std::span<const Triangle> triangles,
                                     double distance) {
  const PreparedSurface surface(SurfaceState{x, triangles}, "surface");
  return contacts_within(surface, surface, distance);
}

std::vector<Proximity> find_contacts(const SurfaceState& a, const SurfaceState& b,
                                     double distance) {
  const PreparedSurface prepared_a(a, "a"), prepared_b(b, "b");
  return contacts_within(prepared_a, prepared_b, distance);
}

}  // namespace selvedge
