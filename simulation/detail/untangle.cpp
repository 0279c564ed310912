// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/untangle.h>

#include <algorithm>
#include <limits>
#include <queue>
#include <utility>

namespace selvedge::detail {
namespace {

// Such triangles meet beyond their edge only if one is folded onto the other, which no motion of
// a contour undoes.
bool share_edge(const Triangle& a, const Triangle& b) {
  return std::count_if(a.begin(), a.end(),
                       [&](auto v) { return std::find(b.begin(), b.end(), v) != b.end(); }) >= 2;
}

std::vector<std::int32_t> common(const std::vector<std::int32_t>& a,
                                 const std::vector<std::int32_t>& b) {
  std::vector<std::int32_t> both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

std::vector<std::int32_t> united(const std::vector<std::int32_t>& a,
                                 const std::vector<std::int32_t>& b) {
  std::vector<std::int32_t> all;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all));
  return all;
}

void sort_unique(std::vector<std::int32_t>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

void unite(Tangle& tangle, const Tangle& other, bool flipped) {
  for (int s = 0; s < 2; ++s)
    tangle.side[s] = united(tangle.side[s], other.side[flipped ? 1 - s : s]);
  tangle.jam = tangle.jam || other.jam;
}

bool overlap(const Tangle& a, const Tangle& b, bool flipped) {
  return !common(a.side[0], b.side[flipped ? 1 : 0]).empty() &&
         !common(a.side[1], b.side[flipped ? 0 : 1]).empty();
}

bool contains(const std::vector<std::int32_t>& sorted, std::int32_t value) {
  return std::binary_search(sorted.begin(), sorted.end(), value);
}

}  // namespace

Untangler::Untangler(JointSurface surface, const UntangleConfig& config)
    : surface_(std::move(surface)), config_(config) {}

void Untangler::exclude_tangles() {
  excluded_ = ExcludedPairs(surface_);
  for (const Tangle& tangle : tangles_.list) excluded_.add(surface_, tangle.side);
}

void Untangler::start(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings) {
  set_reach(x, crossings);
  tangles_.kept.assign(surface_.parts(), CutRegions::kUnknown);
  contours_ = trace_contours(surface_, crossings);
  const CutRegions regions(surface_, contours_, x, tangles_.kept);
  std::vector<Tangle> found;
  for (std::size_t c = 0; c < contours_.size(); ++c)
    if (crosses(contours_[c])) found.push_back(around(c, regions, x));
  merge(std::move(found));
  exclude_tangles();
  report_.until_s = active() ? -1.0 : 0.0;
  report_.start_pairs = report_.pairs = count_pairs(crossings, report_.elsewhere);
  for (Tangle& tangle : tangles_.list) tangle.best = static_cast<int>(crossings.size()) + 1;
  find_motion(regions, x);
}

void Untangler::resume(Tangles tangles, std::span<const Vec3> x,
                       std::span<const EdgeCrossing> crossings) {
  tangles_ = std::move(tangles);
  exclude_tangles();
  report_.pairs = count_pairs(crossings, report_.elsewhere);
  report_.until_s = active() ? -1.0 : 0.0;
  report_.given_up = !tangles_.list.empty() && ways_are_exhausted();
  contours_ = trace_contours(surface_, crossings);
  const CutRegions regions(surface_, contours_, x, tangles_.kept);
  std::vector<int> counts;
  const std::vector<Tangle> left = surroundings(regions, x, counts);
  for (std::size_t k = 0; k < left.size(); ++k)
    if (tangles_.list[k].pinch)
      for (int s = 0; s < 2; ++s) crossing_[s] = common(tangles_.list[k].side[s], left[k].side[s]);
  find_motion(regions, x);
}

bool Untangler::carry_jam(std::span<const ContactPoint> hits, std::span<const Vec3> x) {
  const auto is_cloth = [&](std::int32_t v) { return surface_.is_cloth(v); };
  std::int32_t part = -1;
  std::array<std::vector<std::int32_t>, 2> seeds;  // of the cloth and of the body
  for (const ContactPoint& hit : hits) {
    const auto body = std::find_if_not(hit.vertex.begin(), hit.vertex.end(), is_cloth);
    if (body == hit.vertex.end()) continue;
    if (part < 0) part = surface_.part(*body);
    if (surface_.part(*body) != part) continue;
    for (const std::int32_t v : hit.vertex) seeds[is_cloth(v) ? 0 : 1].push_back(v);
  }
  if (part < 0) return false;
  Tangle jam;
  jam.jam = true;
  jam.best = std::numeric_limits<int>::max();
  for (int s = 0; s < 2; ++s) jam.side[s] = grow(std::move(seeds[s]), x);
  std::vector<Tangle> all = std::move(tangles_.list);
  std::erase_if(all, [](const Tangle& tangle) { return tangle.is_over(); });
  all.push_back(std::move(jam));
  merge(std::move(all));
  exclude_tangles();
  report_.until_s = -1.0;
  ++report_.jams;
  return true;
}

void Untangler::update(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings,
                       double time) {
  int elsewhere = 0;
  report_.pairs = count_pairs(crossings, elsewhere);
  report_.elsewhere = std::max(report_.elsewhere, elsewhere);
  contours_ = trace_contours(surface_, crossings);
  const CutRegions regions(surface_, contours_, x, tangles_.kept);
  shrink(regions, x);
  exclude_tangles();
  if (!active()) report_.until_s = time;
  find_motion(regions, x);
}

bool Untangler::ways_are_exhausted() const {
  return std::any_of(tangles_.list.begin(), tangles_.list.end(), [&](const Tangle& tangle) {
    return !tangle.is_over() && tangle.way >= kUntangleWays * config_.rounds;
  });
}

// From the mean length of the cloth edges at the crossings, or of all if nothing crosses. It is set
// at the start alone, so that a resumed run has the same.
void Untangler::set_reach(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings) {
  double sum = 0.0;
  int count = 0;
  const auto take = [&](std::int32_t e) {
    const Edge& edge = surface_.edges()[e];
    if (!surface_.is_cloth(edge[0])) return;
    sum += (x[edge[1]] - x[edge[0]]).norm();
    ++count;
  };
  for (const EdgeCrossing& crossing : crossings) {
    take(crossing.edge);
    const Triangle& t = surface_.triangles()[crossing.triangle];
    for (const std::int32_t e : surface_.edges_of_vertex(t[0])) take(e);
  }
  if (crossings.empty())
    for (std::size_t e = 0; e < surface_.cloth_edges(); ++e) take(static_cast<std::int32_t>(e));
  edge_length_ = count > 0 ? sum / count : 0.0;
  reach_ = config_.reach * edge_length_;
}

// The regions of one contour, and all triangles within reach of them.
Tangle Untangler::around(std::size_t contour, const CutRegions& regions,
                         std::span<const Vec3> x) const {
  std::array<std::vector<std::int32_t>, 2> seeds;
  const Contour& c = contours_[contour];
  for (std::size_t i = 0; i < c.nodes.size(); ++i) {
    for (const std::int32_t t : surface_.triangles_of_edge(c.nodes[i].edge))
      for (const std::int32_t v : surface_.triangles()[t]) seeds[c.side[i]].push_back(v);
    for (const std::int32_t v : surface_.triangles()[c.nodes[i].triangle])
      seeds[1 - c.side[i]].push_back(v);
  }
  Tangle tangle;
  for (int s = 0; s < 2; ++s) {
    const auto region = regions.region(contour, s);
    seeds[s].insert(seeds[s].end(), region.begin(), region.end());
    tangle.side[s] = grow(std::move(seeds[s]), x);
  }
  return tangle;
}

// Triangles with a vertex within reach of the seeds, along edges.
std::vector<std::int32_t> Untangler::grow(std::vector<std::int32_t> seeds,
                                          std::span<const Vec3> x) const {
  using Entry = std::pair<double, std::int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<char> done(surface_.vertices(), 0);
  sort_unique(seeds);
  for (const std::int32_t v : seeds) queue.emplace(0.0, v);
  std::vector<std::int32_t> triangles;
  while (!queue.empty()) {
    const auto [distance, v] = queue.top();
    queue.pop();
    if (done[v]) continue;
    done[v] = 1;
    for (const std::int32_t t : surface_.triangles_of_vertex(v)) triangles.push_back(t);
    for (const std::int32_t e : surface_.edges_of_vertex(v)) {
      const std::int32_t w = surface_.other_end(e, v);
      const double there = distance + (x[w] - x[v]).norm();
      if (!done[w] && there <= reach_) queue.emplace(there, w);
    }
  }
  sort_unique(triangles);
  return triangles;
}

// Contours whose regions overlap on both sides may meet: they are one tangle.
void Untangler::merge(std::vector<Tangle> found) {
  tangles_.list.clear();
  for (Tangle& next : found) {
    for (bool grows = true; grows;) {
      grows = false;
      for (std::size_t k = 0; k < tangles_.list.size() && !grows; ++k)
        for (const bool flipped : {false, true}) {
          if (grows || !overlap(next, tangles_.list[k], flipped)) continue;
          unite(next, tangles_.list[k], flipped);
          tangles_.list.erase(tangles_.list.begin() + static_cast<std::ptrdiff_t>(k));
          grows = true;
        }
    }
    tangles_.list.push_back(std::move(next));
  }
}

// Whether the contour is more than neighbouring triangles folded onto each other.
bool Untangler::crosses(const Contour& contour) const {
  return std::any_of(contour.nodes.begin(), contour.nodes.end(), [&](const EdgeCrossing& node) {
    const auto around = surface_.triangles_of_edge(node.edge);
    return std::any_of(around.begin(), around.end(), [&](std::int32_t t) {
      return !share_edge(surface_.triangles()[t], surface_.triangles()[node.triangle]);
    });
  });
}

// The tangle of a contour, and whether its sides are swapped; -1: no tangle.
int Untangler::tangle_of(const Contour& contour, bool& flipped) const {
  for (std::size_t i = 0; i < contour.nodes.size(); ++i)
    for (const std::int32_t t : surface_.triangles_of_edge(contour.nodes[i].edge)) {
      const std::int32_t other = contour.nodes[i].triangle;
      if (share_edge(surface_.triangles()[t], surface_.triangles()[other])) continue;
      for (std::size_t k = 0; k < tangles_.list.size(); ++k)
        for (const int s : {0, 1})
          if (contains(tangles_.list[k].side[s], t) &&
              contains(tangles_.list[k].side[1 - s], other)) {
            flipped = s != contour.side[i];
            return static_cast<int>(k);
          }
    }
  return -1;
}

// The surroundings of the remaining contours, for each tangle, and its crossings.
std::vector<Tangle> Untangler::surroundings(const CutRegions& regions, std::span<const Vec3> x,
                                            std::vector<int>& crossings) const {
  std::vector<Tangle> left(tangles_.list.size());
  crossings.assign(tangles_.list.size(), 0);
  for (std::size_t c = 0; c < contours_.size(); ++c) {
    bool flipped = false;
    const int k = tangle_of(contours_[c], flipped);
    if (k < 0) continue;
    unite(left[k], tangles_.list[k].pinch ? crossing(c) : around(c, regions, x), flipped);
    crossings[k] += static_cast<int>(contours_[c].nodes.size());
  }
  return left;
}

// Intersects the regions with the surroundings of the remaining contours.
void Untangler::shrink(const CutRegions& regions, std::span<const Vec3> x) {
  std::vector<int> crossings;
  const std::vector<Tangle> left = surroundings(regions, x, crossings);
  for (std::size_t k = 0; k < tangles_.list.size(); ++k) {
    Tangle& tangle = tangles_.list[k];
    for (int s = 0; s < 2; ++s) tangle.side[s] = common(tangle.side[s], left[k].side[s]);
    if (tangle.pinch) {
      crossing_ = tangle.side;
      add_pinches(tangle);
      if (!pinches_.empty()) {  // nothing can be untangled before the bodies part
        tangle.best = std::numeric_limits<int>::max();
        tangle.way = 0;
      }
    }
    if (tangle.is_over()) {
      tangle = Tangle{};
    } else if (crossings[k] < tangle.best) {
      tangle.best = crossings[k];
      tangle.since = 0;
    } else if (++tangle.since >= config_.patience) {
      tangle.since = 0;
      if (++tangle.way % kUntangleWays != 0) continue;
      if (tangle.jam)
        tangle.way = 0;
      else
        turn_around(static_cast<int>(k));
    }
  }
  report_.given_up = report_.given_up || ways_are_exhausted();
}

// From the next step on, the tangle is brought back to another region.
void Untangler::turn_around(int tangle) {
  for (const Contour& contour : contours_) {
    bool flipped = false;
    if (tangle_of(contour, flipped) != tangle) continue;
    for (const EdgeCrossing& node : contour.nodes) {
      std::int32_t& kept = tangles_.kept[surface_.part(surface_.edges()[node.edge][0])];
      if (kept >= 0) kept = CutRegions::not_that_of(kept);
    }
  }
}

int Untangler::count_pairs(std::span<const EdgeCrossing> crossings, int& elsewhere) const {
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  for (const EdgeCrossing& c : crossings)
    for (const std::int32_t t : surface_.triangles_of_edge(c.edge))
      if (!share_edge(surface_.triangles()[t], surface_.triangles()[c.triangle]))
        pairs.push_back(std::minmax(t, c.triangle));
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  elsewhere = static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const auto& p) {
    return !excluded_.excludes_triangles(p.first, p.second);
  }));
  return static_cast<int>(pairs.size());
}

}  // namespace selvedge::detail
