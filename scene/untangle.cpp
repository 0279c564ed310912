// SPDX-License-Identifier: MIT
#include <selvedge/scene/untangle.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

namespace selvedge {
namespace {

// Ways to move a tangle, tried one after another: each point of the contour for itself or all
// alike, across both sheets or along the normal of one.
constexpr int kWays = 4;
bool moves_as_one(int way) { return way % 2 == 1; }
bool along_normals(int way) { return way % kWays >= 2; }

// A vector this short, of a sum or product of unit vectors, has no direction.
constexpr double kNoDirection = 1e-6;

Vec3 unit(const Vec3& u) {
  const double length = u.norm();
  return length > kNoDirection ? Vec3(u / length) : Vec3(Vec3::Zero());
}

Vec3 normal_of(const Triangle& t, std::span<const Vec3> x) {
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).stableNormalized();
}

bool share_vertex(const Triangle& a, const Triangle& b) {
  return std::any_of(a.begin(), a.end(),
                     [&](auto v) { return std::find(b.begin(), b.end(), v) != b.end(); });
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
}

bool overlap(const Tangle& a, const Tangle& b, bool flipped) {
  return !common(a.side[0], b.side[flipped ? 1 : 0]).empty() &&
         !common(a.side[1], b.side[flipped ? 0 : 1]).empty();
}

bool contains(const std::vector<std::int32_t>& sorted, std::int32_t value) {
  return std::binary_search(sorted.begin(), sorted.end(), value);
}

}  // namespace

// Sums of directions by joint vertex.
struct Untangler::Motion {
  std::vector<Vec3> sum;
  std::vector<int> count;
  std::vector<std::int32_t> contour;

  explicit Motion(std::size_t n) : sum(n, Vec3::Zero()), count(n, 0), contour(n, -1) {}
  void add(std::int32_t v, const Vec3& u, std::size_t of) {
    sum[v] += u;
    ++count[v];
    if (contour[v] < 0) contour[v] = static_cast<std::int32_t>(of);
  }
  Vec3 mean(std::int32_t v) const { return sum[v] / count[v]; }
};

Untangler::Untangler(JointSurface surface, const UntangleConfig& config)
    : surface_(std::move(surface)), config_(config) {}

void Untangler::start(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings) {
  set_reach(x, crossings);
  tangles_.kept.assign(surface_.parts(), CutRegions::kUnknown);
  contours_ = trace_contours(surface_, crossings);
  const CutRegions regions(surface_, contours_, x, tangles_.kept);
  std::vector<Tangle> found;
  for (std::size_t c = 0; c < contours_.size(); ++c)
    if (crosses(contours_[c])) found.push_back(around(c, regions, x));
  merge(std::move(found));
  excluded_ = ExcludedPairs(surface_, tangles_.list);
  report_.until_s = -1.0;
  report_.start_pairs = report_.pairs = count_pairs(crossings, report_.elsewhere);
  for (Tangle& tangle : tangles_.list) tangle.best = static_cast<int>(crossings.size()) + 1;
  find_motion(regions, x);
}

void Untangler::resume(Tangles tangles, std::span<const Vec3> x,
                       std::span<const EdgeCrossing> crossings) {
  tangles_ = std::move(tangles);
  excluded_ = ExcludedPairs(surface_, tangles_.list);
  report_.pairs = count_pairs(crossings, report_.elsewhere);
  report_.until_s = active() ? -1.0 : 0.0;
  report_.given_up = !tangles_.list.empty() && ways_are_exhausted();
  contours_ = trace_contours(surface_, crossings);
  find_motion(CutRegions(surface_, contours_, x, tangles_.kept), x);
}

void Untangler::update(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings,
                       double time) {
  int elsewhere = 0;
  report_.pairs = count_pairs(crossings, elsewhere);
  report_.elsewhere = std::max(report_.elsewhere, elsewhere);
  contours_ = trace_contours(surface_, crossings);
  const CutRegions regions(surface_, contours_, x, tangles_.kept);
  shrink(regions, x);
  excluded_ = ExcludedPairs(surface_, tangles_.list);
  if (!active()) report_.until_s = time;
  find_motion(regions, x);
}

std::int32_t Untangler::enclosed(std::span<const Vec3> x,
                                 std::span<const EdgeCrossing> crossings) const {
  std::vector<char> seen(surface_.parts(), 0);
  for (const EdgeCrossing& c : crossings) {
    const std::int32_t a = surface_.edges()[c.edge][0], b = surface_.triangles()[c.triangle][0];
    if (surface_.is_cloth(a) != surface_.is_cloth(b))
      seen[surface_.part(surface_.is_cloth(a) ? a : b)] = 1;
  }
  const std::vector<Triangle> closed = closed_bodies(surface_);
  for (std::size_t i = 0; i < surface_.cloth_vertices(); ++i) {
    const auto v = static_cast<std::int32_t>(i);
    if (std::exchange(seen[surface_.part(v)], 1)) continue;
    if (is_inside(x, closed, x[v])) return v;
  }
  return -1;
}

bool Untangler::ways_are_exhausted() const {
  return std::any_of(tangles_.list.begin(), tangles_.list.end(), [&](const Tangle& tangle) {
    return !tangle.is_over() && tangle.way >= kWays * config_.rounds;
  });
}

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
  edge_length_ = count > 0 ? sum / count : 0.0;
  reach_ = config_.reach * edge_length_;
}

// The regions of one contour, and what lies within reach of them.
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

// Contours whose regions overlap on both sides may run into one another: they are one tangle.
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

// Whether it is more than neighbours folded onto one another.
bool Untangler::crosses(const Contour& contour) const {
  return std::any_of(contour.nodes.begin(), contour.nodes.end(), [&](const EdgeCrossing& node) {
    const auto around = surface_.triangles_of_edge(node.edge);
    return std::any_of(around.begin(), around.end(), [&](std::int32_t t) {
      return !share_vertex(surface_.triangles()[t], surface_.triangles()[node.triangle]);
    });
  });
}

// Which tangle a contour belongs to, and whether its sides are the other way round; -1: none.
int Untangler::tangle_of(const Contour& contour, bool& flipped) const {
  for (std::size_t i = 0; i < contour.nodes.size(); ++i)
    for (const std::int32_t t : surface_.triangles_of_edge(contour.nodes[i].edge)) {
      const std::int32_t other = contour.nodes[i].triangle;
      if (share_vertex(surface_.triangles()[t], surface_.triangles()[other])) continue;
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

// Regions are cut with what is around the contours that are left.
void Untangler::shrink(const CutRegions& regions, std::span<const Vec3> x) {
  std::vector<Tangle> left(tangles_.list.size());
  std::vector<int> crossings(tangles_.list.size(), 0);
  for (std::size_t c = 0; c < contours_.size(); ++c) {
    bool flipped = false;
    const int k = tangle_of(contours_[c], flipped);
    if (k < 0) continue;
    unite(left[k], around(c, regions, x), flipped);
    crossings[k] += static_cast<int>(contours_[c].nodes.size());
  }
  for (std::size_t k = 0; k < tangles_.list.size(); ++k) {
    Tangle& tangle = tangles_.list[k];
    for (int s = 0; s < 2; ++s) tangle.side[s] = common(tangle.side[s], left[k].side[s]);
    if (tangle.is_over()) {
      tangle = Tangle{};
    } else if (crossings[k] < tangle.best) {
      tangle.best = crossings[k];
      tangle.since = 0;
    } else if (++tangle.since >= config_.patience) {
      tangle.since = 0;
      if (++tangle.way % kWays == 0) turn_around(static_cast<int>(k));
    }
  }
  report_.given_up = report_.given_up || ways_are_exhausted();
}

// What a tangle was to be brought back to, another region takes its place from the next step on.
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
      if (!share_vertex(surface_.triangles()[t], surface_.triangles()[c.triangle]))
        pairs.push_back(std::minmax(t, c.triangle));
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  elsewhere = static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const auto& p) {
    return !excluded_.excludes_triangles(p.first, p.second);
  }));
  return static_cast<int>(pairs.size());
}

void Untangler::find_motion(const CutRegions& regions, std::span<const Vec3> x) {
  driven_.clear();
  if (report_.given_up) return;
  Motion motion(surface_.vertices());
  for (std::size_t c = 0; c < contours_.size(); ++c) {
    bool flipped = false;
    const int k = tangle_of(contours_[c], flipped);
    if (k >= 0) move_contour(c, regions, x, tangles_.list[k].way, motion);
  }
  for (std::size_t c = 0; c < contours_.size(); ++c) fill_regions(c, regions, motion);
  for (std::size_t i = 0; i < surface_.cloth_vertices(); ++i) {
    const auto v = static_cast<std::int32_t>(i);
    if (motion.count[i] > 0) driven_.push_back({v, motion.mean(v), motion.contour[i]});
  }
}

namespace {

// On which side of a plane with this normal a sheet is cut off: the sign for the first vertices
// that are against the others, 0 if all are alike.
template <class IsCutOff>
double cut_off_side(std::span<const std::int32_t> vertices, const Vec3& normal,
                    std::span<const Vec3> x, IsCutOff is_cut_off) {
  Vec3 in = Vec3::Zero(), out = Vec3::Zero();
  int ins = 0, outs = 0;
  for (const std::int32_t v : vertices) {
    const bool off = is_cut_off(v);
    (off ? in : out) += x[v];
    ++(off ? ins : outs);
  }
  if (ins == 0 || outs == 0) return 0.0;
  const double d = normal.dot(in / ins - out / outs);
  return d > 0.0 ? 1.0 : d < 0.0 ? -1.0 : 0.0;
}

// Into which direction the sheet of an edge is moved against the sheet of a triangle that it meets.
// side_a, side_b: where the region of each lies, against the normal of the other; 0: unknown.
Vec3 parting(const Vec3& normal_a, const Vec3& normal_b, double side_a, double side_b,
             bool along_normals) {
  const Vec3 by_normals = unit(side_b * normal_a - side_a * normal_b);
  const Vec3 t = unit(normal_a.cross(normal_b));
  if (along_normals || side_a == 0.0 || side_b == 0.0 || t.isZero(0.0)) return by_normals;
  Vec3 c_a = normal_a.cross(t), c_b = normal_b.cross(t);
  if (c_a.dot(normal_b) * side_a < 0.0) c_a = -c_a;
  if (c_b.dot(normal_a) * side_b < 0.0) c_b = -c_b;
  const Vec3 u = unit(c_b - c_a);
  return u.isZero(0.0) ? by_normals : u;
}

}  // namespace

// From the border of one sheet to that of the other, for a contour that cuts off nothing.
Vec3 Untangler::along(const Contour& contour, std::span<const Vec3> x) const {
  std::array<Vec3, 2> end{Vec3::Zero(), Vec3::Zero()};
  std::array<int, 2> count{};
  for (std::size_t i = 0; i < contour.nodes.size(); ++i) {
    if (surface_.triangles_of_edge(contour.nodes[i].edge).size() != 1) continue;
    const Edge& e = surface_.edges()[contour.nodes[i].edge];
    end[contour.side[i]] += 0.5 * (x[e[0]] + x[e[1]]);
    ++count[contour.side[i]];
  }
  if (count[0] == 0 || count[1] == 0) return Vec3::Zero();
  return unit(end[1] / count[1] - end[0] / count[0]);  // of side 0 against side 1
}

void Untangler::move_contour(std::size_t c, const CutRegions& regions, std::span<const Vec3> x,
                             int way, Motion& motion) const {
  const Contour& contour = contours_[c];
  const bool open = !regions.divides(c, 0) && !regions.divides(c, 1);
  const Vec3 lengthwise = open ? along(contour, x) : Vec3(Vec3::Zero());
  std::vector<Vec3> u(contour.nodes.size());  // of side 0 against side 1
  Vec3 whole = Vec3::Zero();
  for (std::size_t i = 0; i < contour.nodes.size(); ++i) {
    u[i] = open ? lengthwise : node_direction(c, i, regions, x, along_normals(way));
    whole += u[i];
  }
  if (moves_as_one(way)) std::fill(u.begin(), u.end(), unit(whole));
  for (std::size_t i = 0; i < contour.nodes.size(); ++i) {
    if (u[i].isZero(0.0)) continue;
    const Edge& e = surface_.edges()[contour.nodes[i].edge];
    const Triangle& t = surface_.triangles()[contour.nodes[i].triangle];
    const bool both = surface_.is_cloth(e[0]) && surface_.is_cloth(t[0]);
    const double share = both ? 0.5 : 1.0, sign = contour.side[i] == 0 ? share : -share;
    for (const std::int32_t v : e) motion.add(v, sign * u[i], c);
    for (const std::int32_t v : t) motion.add(v, -sign * u[i], c);
  }
}

Vec3 Untangler::node_direction(std::size_t c, std::size_t i, const CutRegions& regions,
                               std::span<const Vec3> x, bool along_normals) const {
  const EdgeCrossing& node = contours_[c].nodes[i];
  const int side = contours_[c].side[i];
  const Edge& e = surface_.edges()[node.edge];
  const Triangle& t = surface_.triangles()[node.triangle];
  const Vec3 normal_b = normal_of(t, x);
  Vec3 normal_a = Vec3::Zero();
  for (const std::int32_t a : surface_.triangles_of_edge(node.edge))
    normal_a += normal_of(surface_.triangles()[a], x);
  normal_a = unit(normal_a);
  const double side_a =
      cut_off_side(e, normal_b, x, [&](std::int32_t v) { return regions.is_cut_off(c, side, v); });
  const double side_b = cut_off_side(
      t, normal_a, x, [&](std::int32_t v) { return regions.is_cut_off(c, 1 - side, v); });
  const Vec3 u = parting(normal_a, normal_b, side_a, side_b, along_normals);
  return side == 0 ? u : Vec3(-u);
}

// What a contour cuts off goes with it, ring by ring the mean of the one before.
void Untangler::fill_regions(std::size_t c, const CutRegions& regions, Motion& motion) const {
  for (int s = 0; s < 2; ++s) {
    std::vector<std::int32_t> ring;
    for (const std::int32_t v : regions.region(c, s))
      if (surface_.is_cloth(v) && motion.count[v] > 0) ring.push_back(v);
    while (!ring.empty()) {
      std::vector<std::pair<std::int32_t, Vec3>> next;
      for (const std::int32_t v : ring)
        for (const std::int32_t e : surface_.edges_of_vertex(v)) {
          const std::int32_t w = surface_.other_end(e, v);
          if (motion.count[w] == 0 && regions.is_cut_off(c, s, w))
            next.emplace_back(w, motion.mean(v));
        }
      ring.clear();
      for (const auto& [w, u] : next) {
        if (motion.count[w] == 0) ring.push_back(w);
        motion.add(w, u, c);
      }
    }
  }
}

void Untangler::begin(std::span<const Vec3> v, std::span<const Vec3> body_step, double h) {
  speed_ = std::min(config_.speed, config_.edge_share * edge_length_ / h);
  base_.assign(contours_.size(), Vec3::Zero());
  for (std::size_t c = 0; c < contours_.size(); ++c) {
    Vec3 cloth = Vec3::Zero(), body = Vec3::Zero();
    int cloths = 0, bodies = 0;
    const auto take = [&](std::int32_t i) {
      const bool of_cloth = surface_.is_cloth(i);
      if (of_cloth)
        cloth += v[i];
      else
        body += body_step[static_cast<std::size_t>(i) - surface_.cloth_vertices()] / h;
      ++(of_cloth ? cloths : bodies);
    };
    for (const EdgeCrossing& node : contours_[c].nodes) {
      for (const std::int32_t i : surface_.edges()[node.edge]) take(i);
      for (const std::int32_t i : surface_.triangles()[node.triangle]) take(i);
    }
    if (bodies > 0)
      base_[c] = body / bodies;
    else if (cloths > 0)
      base_[c] = cloth / cloths;
  }
}

Vec3 Untangler::velocity(const Driven& d) const { return base_[d.contour] + speed_ * d.direction; }

std::span<const ImplicitTerm> Untangler::with_drive(std::span<const ImplicitTerm> terms,
                                                    std::span<const double> mass) {
  terms_.assign(terms.begin(), terms.end());
  for (const Driven& d : driven_) {
    const double weight = config_.drive_ratio * mass[d.particle];
    ImplicitTerm term;
    term.particle = {d.particle, -1, -1, -1};
    term.weight = {1.0, 0.0, 0.0, 0.0};
    term.matrix = weight * Mat3::Identity();
    term.rhs = weight * velocity(d);
    terms_.push_back(term);
  }
  return terms_;
}

void Untangler::set_velocities(std::span<const double> inv_mass, std::span<Vec3> v) const {
  for (const Driven& d : driven_)
    if (inv_mass[d.particle] > 0.0) v[d.particle] = velocity(d);
}

void Untangler::finish(std::span<Vec3> v) {
  for (const Vec3& u : v) report_.max_speed = std::max(report_.max_speed, u.norm());
  for (const Driven& d : driven_) {
    const double length = d.direction.norm();
    if (length < kNoDirection) continue;
    const Vec3 n = d.direction / length;
    const double along = n.dot(v[d.particle] - base_[d.contour]);
    if (along > 0.0) v[d.particle] -= std::min(along, speed_ * length) * n;
  }
}

}  // namespace selvedge
