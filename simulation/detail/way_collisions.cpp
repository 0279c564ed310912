// SPDX-License-Identifier: MIT
#include <selvedge/detection/find.h>
#include <selvedge/simulation/contacts/detail/excluded_surfaces.h>
#include <selvedge/simulation/detail/way_collisions.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace selvedge::detail {
namespace {

/// The vertices of the two primitives of a collision.
struct Sides {
  std::span<const std::int32_t> a, b;
};

Sides sides_of(const Collision& c) {
  const std::size_t first = c.kind == ContactKind::edge_edge ? 2 : 1;
  return {std::span(c.vertex).first(first), std::span(c.vertex).subspan(first)};
}

class WaySearch {
 public:
  explicit WaySearch(const ClothWay& way)
      : way_(way), pairs_(way.scene), excludes_(!pairs_.collide_all()) {}

  std::set<std::int32_t> run() {
    if (searches_self(way_.scene)) search_self();
    if (!way_.simulation.body_positions().empty()) search_bodies();
    return std::move(found_);
  }

 private:
  MovingSurface cloth() const {
    return {way_.simulation.positions(), way_.x_t1, way_.simulation.cloth_triangles()};
  }

  void search_self() {
    const MovingSurface surface = cloth();
    for (const Collision& c : find_collisions(surface.x_t0, surface.x_t1, surface.triangles)) {
      const Sides sides = sides_of(c);
      if (meet_afterwards(sides) || excluded(sides)) continue;
      add(sides.a);
      add(sides.b);
    }
  }

  void search_bodies() {
    const Simulation& simulation = way_.simulation;
    const std::vector<Vec3>& bodies = simulation.body_positions();
    const auto offset = static_cast<std::int32_t>(simulation.positions().size());
    for (Collision& c : find_collisions(cloth(), {bodies, bodies, simulation.body_triangles()})) {
      const bool body_first = c.kind == ContactKind::triangle_point;
      const int first = c.kind == ContactKind::edge_edge ? 2 : 1;
      for (int k = 0; k < 4; ++k)
        if ((k < first) == body_first) c.vertex[k] += offset;
      Sides sides = sides_of(c);
      if (body_first) std::swap(sides.a, sides.b);
      if (!excluded(sides)) add(sides.a);
    }
  }

  void add(std::span<const std::int32_t> vertices) {
    for (const std::int32_t v : vertices) found_.insert(number(v));
  }

  std::int32_t number(std::int32_t v) const { return way_.after.empty() ? v : way_.after[v]; }

  bool meet_afterwards(const Sides& sides) const {
    return std::any_of(sides.a.begin(), sides.a.end(), [&](std::int32_t i) {
      return std::any_of(sides.b.begin(), sides.b.end(),
                         [&](std::int32_t j) { return number(i) == number(j); });
    });
  }

  /// As ExcludedSurfaces::drop; side a is of cloth.
  bool excluded(const Sides& sides) const {
    if (!excludes_) return false;
    const auto surface = [&](std::int32_t v) {
      return static_cast<std::int32_t>(way_.simulation.names().owner_index(v));
    };
    return std::all_of(sides.a.begin(), sides.a.end(), [&](std::int32_t i) {
      return std::all_of(sides.b.begin(), sides.b.end(),
                         [&](std::int32_t j) { return !pairs_.collide(surface(i), surface(j)); });
    });
  }

  const ClothWay& way_;
  const ContactPairs pairs_;
  const bool excludes_;
  std::set<std::int32_t> found_;
};

}  // namespace

std::set<std::int32_t> colliding_on_way(const ClothWay& way) { return WaySearch(way).run(); }

}  // namespace selvedge::detail
