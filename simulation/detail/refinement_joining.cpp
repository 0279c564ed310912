// SPDX-License-Identifier: MIT
//
// Which quarters of cells are joined again: those of cloth that has become flat, if the way to the
// surface of the whole cell is free.
#include <selvedge/simulation/detail/refinement.h>
#include <selvedge/simulation/detail/way_collisions.h>

#include <algorithm>
#include <span>

namespace selvedge::detail {

/// Where the straight way to the surface of these cells ends, m, of all cloth vertices.
std::vector<Vec3> Refinement::way_end(std::span<const Vec3> x,
                                      const std::vector<SplitEvent>& joins) const {
  std::vector<Vec3> x_t1(x.begin(), x.end());
  for (const SplitEvent& event : joins) {
    const std::size_t number = static_cast<std::size_t>(event.piece), first = begin(number);
    const std::vector<Vec3> places =
        piece(event.piece).cells.flattened(event.cells, x.subspan(first, sizes_[number]));
    std::copy(places.begin(), places.end(), x_t1.begin() + static_cast<std::ptrdiff_t>(first));
  }
  return x_t1;
}

Refinement::Joins Refinement::joins_due(const Simulation& simulation) const {
  Joins joins;
  for (const Piece& p : pieces_) {
    if (p.spec.when != RefineSpec::When::curved || !(p.spec.join_deg > 0.0)) continue;
    const auto x = simulation.positions().subspan(begin(p.number), sizes_[p.number]);
    std::vector<GridCell> cells = p.cells.flat(x, p.spec.join(), p.spec.angle());
    if (!cells.empty())
      joins.events.push_back(
          {static_cast<std::int32_t>(p.number), simulation.time(), std::move(cells), true});
  }
  while (!joins.events.empty()) {
    joins.way_end = way_end(simulation.positions(), joins.events);
    const std::set<std::int32_t> found = colliding_on_way({simulation, *scene_, joins.way_end});
    if (found.empty()) break;
    std::size_t removed = 0, all = 0;
    for (SplitEvent& event : joins.events) {
      const auto first = static_cast<std::int32_t>(begin(static_cast<std::size_t>(event.piece)));
      const AdaptiveCloth& cloth = piece(event.piece).cells;
      removed += std::erase_if(event.cells, [&](const GridCell& cell) {
        const std::vector<std::int32_t> nodes = cloth.nodes(cell);
        return std::any_of(nodes.begin(), nodes.end(),
                           [&](std::int32_t v) { return found.contains(first + v); });
      });
      all += event.cells.size();
    }
    joins.postponed += removed;
    std::erase_if(joins.events, [](const SplitEvent& event) { return event.cells.empty(); });
    if (removed > 0) continue;
    joins.postponed += all;  // colliding vertices hang on a cell without being its nodes
    joins.events.clear();
  }
  return joins;
}

}  // namespace selvedge::detail
