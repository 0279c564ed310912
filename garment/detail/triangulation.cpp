// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>
#include <selvedge/garment/detail/triangulation.h>

#include <algorithm>
#include <deque>

namespace selvedge::detail {
namespace {

constexpr std::int64_t kExtent = std::int64_t(1) << 26;

constexpr int next_corner(int i) { return i == 2 ? 0 : i + 1; }
constexpr int last_corner(int i) { return i == 0 ? 2 : i - 1; }

}  // namespace

Triangulation::Triangulation(std::span<const GridPoint> points, std::int32_t sides,
                             std::span<const std::array<std::int32_t, 2>> lines) {
  // Differences of coordinates stay below 5·2^26 < 2^29.
  points_ = {{-2 * kExtent, -kExtent}, {3 * kExtent, -kExtent}, {kExtent / 2, 4 * kExtent}};
  cell_of_ = {0, 0, 0};
  cells_.push_back({.v = {0, 1, 2}, .across = {kNone, kNone, kNone}});
  cells_[0].inside = true;  // while the points are inserted
  std::int32_t at = 0;
  for (const GridPoint& p : points) {
    at = locate(p, at);
    const std::int32_t point = insert(p, at);
    SELVEDGE_ASSERT(point != kNone);
    at = cell_of_[point];
  }
  for (std::int32_t i = 0; i < sides; ++i) recover(kOuter + i, kOuter + (i + 1) % sides);
  for (const auto& [a, b] : lines) recover(kOuter + a, kOuter + b);
  restore();
  mark_inside();
}

int Triangulation::side_to(std::int32_t c, std::int32_t other) const {
  const auto& across = cells_[c].across;
  return across[0] == other ? 0 : across[1] == other ? 1 : 2;
}

int Triangulation::corner_of(std::int32_t c, std::int32_t point) const {
  const auto& v = cells_[c].v;
  return v[0] == point ? 0 : v[1] == point ? 1 : 2;
}

std::int32_t Triangulation::add_point(const GridPoint& p) {
  points_.push_back(p);
  cell_of_.push_back(kNone);
  return static_cast<std::int32_t>(points_.size()) - 1;
}

std::int32_t Triangulation::add_cell(const Cell& cell) {
  cells_.push_back(cell);
  return static_cast<std::int32_t>(cells_.size()) - 1;
}

void Triangulation::replace_across(std::int32_t cell, std::int32_t from, std::int32_t to) {
  if (cell != kNone) cells_[cell].across[side_to(cell, from)] = to;
}

// A walk towards p ends in a Delaunay triangulation; fixed sides could make it go round, so that
// the number of its steps is bounded.
std::int32_t Triangulation::locate(const GridPoint& p, std::int32_t start) const {
  std::int32_t c = start;
  for (std::size_t steps = 0; steps <= cells_.size(); ++steps) {
    int out = -1;
    for (int k = 0; k < 3 && out < 0; ++k) {
      const int i = static_cast<int>((steps + k) % 3);
      const Cell& cell = cells_[c];
      if (turn(points_[cell.v[next_corner(i)]], points_[cell.v[last_corner(i)]], p) < 0) out = i;
    }
    if (out < 0) return c;
    if (cells_[c].across[out] == kNone) return kNone;
    c = cells_[c].across[out];
  }
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(cells_.size()); ++i) {
    const auto& v = cells_[i].v;
    if (turn(points_[v[0]], points_[v[1]], p) >= 0 && turn(points_[v[1]], points_[v[2]], p) >= 0 &&
        turn(points_[v[2]], points_[v[0]], p) >= 0)
      return i;
  }
  return kNone;
}

std::int32_t Triangulation::insert(const GridPoint& p, std::int32_t c) {
  changed_.clear();
  if (c == kNone || !cells_[c].inside) return kNone;
  const Cell& cell = cells_[c];
  int on = -1;
  for (int i = 0; i < 3; ++i) {
    if (points_[cell.v[i]] == p) return kNone;
    if (turn(points_[cell.v[next_corner(i)]], points_[cell.v[last_corner(i)]], p) == 0) on = i;
  }
  if (on >= 0 && (cell.fixed[on] || cell.across[on] == kNone)) return kNone;
  const std::int32_t point = on < 0 ? split_cell(c, p) : split_side(c, on, p);
  legalize(point);
  return point;
}

std::int32_t Triangulation::split_cell(std::int32_t c, const GridPoint& p) {
  const std::int32_t point = add_point(p);
  const Cell old = cells_[c];
  const std::array<std::int32_t, 3> made = {c, add_cell(old), add_cell(old)};
  for (int i = 0; i < 3; ++i) {
    Cell& cell = cells_[made[i]];
    const int j = next_corner(i), k = last_corner(i);
    cell.v = {point, old.v[j], old.v[k]};
    cell.across = {old.across[i], made[j], made[k]};
    cell.fixed = {old.fixed[i], false, false};
    cell.inside = old.inside;
    if (made[i] != c) replace_across(old.across[i], c, made[i]);
    cell_of_[old.v[j]] = made[i];
    changed_.push_back(made[i]);
  }
  cell_of_[point] = c;
  return point;
}

// The side opposite corner i of c, from `from` to `to`, which is shared with the cell d.
std::int32_t Triangulation::split_side(std::int32_t c, int i, const GridPoint& p) {
  const std::int32_t d = cells_[c].across[i];
  const int j = side_to(d, c);
  const Cell first = cells_[c], second = cells_[d];
  const std::int32_t point = add_point(p);
  const std::int32_t from = first.v[next_corner(i)], to = first.v[last_corner(i)];
  const std::int32_t top = first.v[i], bottom = second.v[j];
  const std::int32_t c2 = add_cell(first), d2 = add_cell(second);
  // c: top, from, point; c2: top, point, to; d: bottom, point, from; d2: bottom, to, point.
  cells_[c] = {.v = {top, from, point},
               .across = {d, c2, first.across[last_corner(i)]},
               .fixed = {false, false, first.fixed[last_corner(i)]},
               .inside = first.inside};
  cells_[c2] = {.v = {top, point, to},
                .across = {d2, first.across[next_corner(i)], c},
                .fixed = {false, first.fixed[next_corner(i)], false},
                .inside = first.inside};
  cells_[d] = {.v = {bottom, point, from},
               .across = {c, second.across[next_corner(j)], d2},
               .fixed = {false, second.fixed[next_corner(j)], false},
               .inside = second.inside};
  cells_[d2] = {.v = {bottom, to, point},
                .across = {c2, d, second.across[last_corner(j)]},
                .fixed = {false, false, second.fixed[last_corner(j)]},
                .inside = second.inside};
  replace_across(first.across[next_corner(i)], c, c2);
  replace_across(second.across[last_corner(j)], d, d2);
  cell_of_[point] = c;
  cell_of_[from] = c;
  cell_of_[to] = c2;
  cell_of_[top] = c;
  cell_of_[bottom] = d;
  for (const std::int32_t cell : {c, c2, d, d2}) changed_.push_back(cell);
  return point;
}

bool Triangulation::is_illegal(std::int32_t c, int i) const {
  const Cell& cell = cells_[c];
  const std::int32_t d = cell.across[i];
  if (d == kNone || cell.fixed[i]) return false;
  const GridPoint& apex = points_[cells_[d].v[side_to(d, c)]];
  return in_circle(points_[cell.v[0]], points_[cell.v[1]], points_[cell.v[2]], apex) > 0;
}

// Every new cell has the point, and only the sides opposite it can be illegal.
void Triangulation::legalize(std::int32_t point) {
  stack_ = changed_;
  while (!stack_.empty()) {
    const std::int32_t c = stack_.back();
    stack_.pop_back();
    const int i = corner_of(c, point);
    if (!is_illegal(c, i)) continue;
    const std::int32_t d = cells_[c].across[i];
    flip(c, i);
    for (const std::int32_t cell : {c, d}) stack_.push_back(cell);
    changed_.push_back(d);
  }
}

bool Triangulation::can_flip(std::int32_t c, int i) const {
  const Cell& cell = cells_[c];
  const std::int32_t d = cell.across[i];
  if (d == kNone || cell.fixed[i]) return false;
  const GridPoint &top = points_[cell.v[i]], &bottom = points_[cells_[d].v[side_to(d, c)]];
  return turn(top, points_[cell.v[next_corner(i)]], bottom) > 0 &&
         turn(bottom, points_[cell.v[last_corner(i)]], top) > 0;
}

// Cell c keeps the corner `from` of the side, its neighbour the corner `to`.
void Triangulation::flip(std::int32_t c, int i) {
  const std::int32_t d = cells_[c].across[i];
  const int j = side_to(d, c);
  const Cell first = cells_[c], second = cells_[d];
  const std::int32_t from = first.v[next_corner(i)], to = first.v[last_corner(i)];
  const std::int32_t top = first.v[i], bottom = second.v[j];
  cells_[c] = {.v = {top, from, bottom},
               .across = {second.across[next_corner(j)], d, first.across[last_corner(i)]},
               .fixed = {second.fixed[next_corner(j)], false, first.fixed[last_corner(i)]},
               .inside = first.inside};
  cells_[d] = {.v = {bottom, to, top},
               .across = {first.across[next_corner(i)], c, second.across[last_corner(j)]},
               .fixed = {first.fixed[next_corner(i)], false, second.fixed[last_corner(j)]},
               .inside = second.inside};
  replace_across(second.across[next_corner(j)], d, c);
  replace_across(first.across[next_corner(i)], c, d);
  cell_of_[top] = cell_of_[from] = c;
  cell_of_[bottom] = cell_of_[to] = d;
}

void Triangulation::all_cells_at(std::int32_t point, std::vector<std::int32_t>& cells) const {
  cells.clear();
  const std::int32_t first = cell_of_[point];
  for (std::int32_t c = first; c != kNone;) {
    cells.push_back(c);
    c = cells_[c].across[next_corner(corner_of(c, point))];
    if (c == first) return;
  }
  // The corner of the outer triangle: the other way as well.
  for (std::int32_t c = cells_[first].across[last_corner(corner_of(first, point))]; c != kNone;
       c = cells_[c].across[last_corner(corner_of(c, point))])
    cells.push_back(c);
}

void Triangulation::star(std::int32_t point, std::vector<std::int32_t>& cells) const {
  all_cells_at(point, cells);
  std::erase_if(cells, [&](std::int32_t c) { return !cells_[c].inside; });
}

bool Triangulation::find_side(std::int32_t a, std::int32_t b, std::int32_t& c, int& i) const {
  std::vector<std::int32_t> cells;
  all_cells_at(a, cells);
  for (const std::int32_t at : cells) {
    const int k = corner_of(at, a);
    if (cells_[at].v[next_corner(k)] == b) return c = at, i = last_corner(k), true;
    if (cells_[at].v[last_corner(k)] == b) return c = at, i = next_corner(k), true;
  }
  return false;
}

// [Sloan1993]: sides that cross a-b are flipped until none does. No point lies on a-b.
void Triangulation::recover(std::int32_t a, std::int32_t b) {
  const GridPoint pa = points_[a], pb = points_[b];
  std::int32_t c = kNone;
  int i = 0;
  if (!find_side(a, b, c, i)) {
    std::deque<std::array<std::int32_t, 2>> crossing;
    std::vector<std::int32_t> cells;
    all_cells_at(a, cells);
    for (const std::int32_t at : cells) {
      const int k = corner_of(at, a);
      const std::int32_t right = cells_[at].v[next_corner(k)], left = cells_[at].v[last_corner(k)];
      if (turn(pa, pb, points_[right]) < 0 && turn(pa, pb, points_[left]) > 0 &&
          turn(points_[right], points_[left], pb) < 0)
        c = at, i = k;
    }
    SELVEDGE_ASSERT(c != kNone);
    while (true) {
      crossing.push_back({cells_[c].v[next_corner(i)], cells_[c].v[last_corner(i)]});
      const std::int32_t d = cells_[c].across[i];
      const int apex = side_to(d, c);
      const std::int32_t point = cells_[d].v[apex];
      if (point == b) break;
      const bool left = turn(pa, pb, points_[point]) > 0;
      // a-b leaves d through the side opposite the old corner on the same side as the apex.
      i = left ? next_corner(apex) : last_corner(apex);
      c = d;
    }
    while (!crossing.empty()) {
      const auto [from, to] = crossing.front();
      crossing.pop_front();
      if (!find_side(from, to, c, i)) continue;
      if (!can_flip(c, i)) {
        crossing.push_back({from, to});
        continue;
      }
      const std::int32_t d = cells_[c].across[i];
      const std::int32_t top = cells_[c].v[i], bottom = cells_[d].v[side_to(d, c)];
      flip(c, i);
      if (top == a || top == b || bottom == a || bottom == b) continue;
      if (turn(pa, pb, points_[top]) * turn(pa, pb, points_[bottom]) < 0)
        crossing.push_back({top, bottom});
    }
    find_side(a, b, c, i);
  }
  const std::int32_t d = cells_[c].across[i];
  cells_[c].fixed[i] = true;
  cells_[d].fixed[side_to(d, c)] = true;
}

void Triangulation::restore() {
  stack_.clear();
  for (std::int32_t c = static_cast<std::int32_t>(cells_.size()) - 1; c >= 0; --c)
    stack_.push_back(c);
  while (!stack_.empty()) {
    const std::int32_t c = stack_.back();
    stack_.pop_back();
    for (int i = 0; i < 3; ++i) {
      if (!is_illegal(c, i)) continue;
      const std::int32_t d = cells_[c].across[i];
      flip(c, i);
      for (const std::int32_t cell : {c, d}) stack_.push_back(cell);
      break;
    }
  }
}

void Triangulation::mark_inside() {
  for (Cell& cell : cells_) cell.inside = true;
  std::vector<std::int32_t> outside;
  all_cells_at(0, outside);
  for (const std::int32_t c : outside) cells_[c].inside = false;
  while (!outside.empty()) {
    const std::int32_t c = outside.back();
    outside.pop_back();
    for (int i = 0; i < 3; ++i) {
      const std::int32_t d = cells_[c].across[i];
      if (d == kNone || cells_[c].fixed[i] || !cells_[d].inside) continue;
      cells_[d].inside = false;
      outside.push_back(d);
    }
  }
}

std::int32_t Triangulation::divide(std::int32_t c, int i, const GridPoint& p) {
  const Cell& cell = cells_[c];
  const std::int32_t d = cell.across[i];
  if (d == kNone || cell.fixed[i]) return kNone;
  const GridPoint &from = points_[cell.v[next_corner(i)]], &to = points_[cell.v[last_corner(i)]];
  const GridPoint &top = points_[cell.v[i]], &bottom = points_[cells_[d].v[side_to(d, c)]];
  if (turn(top, from, p) <= 0 || turn(p, to, top) <= 0 || turn(bottom, p, from) <= 0 ||
      turn(bottom, to, p) <= 0)
    return kNone;
  changed_.clear();
  return split_side(c, i, p);
}

}  // namespace selvedge::detail
