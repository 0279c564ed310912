// SPDX-License-Identifier: MIT
//
// The motion that undoes a tangle.
#include <selvedge/simulation/detail/untangle.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge::detail {
namespace {

// The ways: each point of the contour for itself or all alike, across both sheets or along the
// normal of one.
bool moves_as_one(int way) { return way % 2 == 1; }
bool along_normals(int way) { return way % kUntangleWays >= 2; }

// In a jam, the first ways lead cloth out of closed bodies; the others are for those that have two
// surfaces.
bool leads_out(const Tangle& tangle) { return tangle.jam && !along_normals(tangle.way); }

// A vector this short, of a sum or product of unit vectors, has no direction.
constexpr double kNoDirection = 1e-6;

Vec3 unit(const Vec3& u) {
  const double length = u.norm();
  return length > kNoDirection ? Vec3(u / length) : Vec3(Vec3::Zero());
}

Vec3 normal_of(const Triangle& t, std::span<const Vec3> x) {
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).stableNormalized();
}

// Of the triangles of a part, times 6, m³.
double signed_volume(const JointSurface& surface, std::int32_t part, std::span<const Vec3> x) {
  double sum = 0.0;
  for (const Triangle& t : surface.triangles())
    if (surface.part(t[0]) == part) sum += x[t[0]].dot(x[t[1]].cross(x[t[2]]));
  return sum;
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

void Untangler::find_motion(const CutRegions& regions, std::span<const Vec3> x) {
  driven_.clear();
  if (report_.given_up) return;
  Motion motion(surface_.vertices());
  std::vector<char> outwards(contours_.size(), 0);
  for (std::size_t c = 0; c < contours_.size(); ++c) {
    bool flipped = false;
    const int k = tangle_of(contours_[c], flipped);
    if (k < 0 || is_pinched(contours_[c])) continue;
    outwards[c] = leads_out(tangles_.list[k]) && !cuts_off_inside(c, regions, x) &&
                  move_out(c, x, tangles_.list[k].way, motion);
    if (!outwards[c]) move_contour(c, regions, x, tangles_.list[k].way, motion);
  }
  for (std::size_t c = 0; c < contours_.size(); ++c)
    if (!outwards[c]) fill_regions(c, regions, motion);
  for (std::size_t i = 0; i < surface_.cloth_vertices(); ++i) {
    const auto v = static_cast<std::int32_t>(i);
    if (motion.count[i] == 0) continue;
    const double ratio = outwards[motion.contour[i]] ? config_.out_ratio : config_.drive_ratio;
    driven_.push_back({v, motion.mean(v), motion.contour[i], ratio});
  }
}

namespace {

// The side of a plane with this normal on which a sheet is cut off: the sign of the vertices that
// are cut off relative to the others; 0 if all are alike.
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

// The direction in which the sheet of an edge moves against the sheet of a triangle that it
// crosses. side_a, side_b: side of each region relative to the normal of the other sheet; 0:
// unknown.
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

// For a contour from a common corner of two triangles to the border of one: the edge leaves the
// triangle on the side on which most of it already lies.
Vec3 Untangler::out_of_triangle(const EdgeCrossing& node, int side, std::span<const Vec3> x) const {
  const Edge& e = surface_.edges()[node.edge];
  const Triangle& t = surface_.triangles()[node.triangle];
  const Vec3 normal = normal_of(t, x);
  const double height = normal.dot(x[e[0]] - x[t[0]]) + normal.dot(x[e[1]] - x[t[0]]);
  return (height < 0.0) == (side == 0) ? Vec3(-normal) : normal;
}

void Untangler::move_contour(std::size_t c, const CutRegions& regions, std::span<const Vec3> x,
                             int way, Motion& motion) const {
  const Contour& contour = contours_[c];
  const bool open = !regions.divides(c, 0) && !regions.divides(c, 1);
  const Vec3 lengthwise = open ? along(contour, x) : Vec3(Vec3::Zero());
  const bool at_corner = open && lengthwise.isZero(0.0);
  std::vector<Vec3> u(contour.nodes.size());  // of side 0 against side 1
  Vec3 whole = Vec3::Zero();
  for (std::size_t i = 0; i < contour.nodes.size(); ++i) {
    u[i] = at_corner ? out_of_triangle(contour.nodes[i], contour.side[i], x)
           : open    ? lengthwise
                     : node_direction(c, i, regions, x, along_normals(way));
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

// The normal of a closed body at a crossing of the cloth with it, outwards; 0 at other crossings.
Vec3 Untangler::outward(const EdgeCrossing& node, std::span<const Vec3> x) const {
  const Triangle& t = surface_.triangles()[node.triangle];
  const std::int32_t end = surface_.edges()[node.edge][0];
  const bool edge_of_cloth = surface_.is_cloth(end);
  if (edge_of_cloth == surface_.is_cloth(t[0])) return Vec3::Zero();
  const std::int32_t part = surface_.part(edge_of_cloth ? t[0] : end);
  if (!surface_.is_closed(part)) return Vec3::Zero();
  Vec3 normal = Vec3::Zero();
  if (edge_of_cloth)
    normal = normal_of(t, x);
  else
    for (const std::int32_t of_body : surface_.triangles_of_edge(node.edge))
      normal += normal_of(surface_.triangles()[of_body], x);
  return signed_volume(surface_, part, x) < 0.0 ? Vec3(-unit(normal)) : unit(normal);
}

// Moves the cloth at a contour out of the closed body that it crosses. Returns false if it crosses
// no closed body.
bool Untangler::move_out(std::size_t c, std::span<const Vec3> x, int way, Motion& motion) const {
  const Contour& contour = contours_[c];
  std::vector<Vec3> u(contour.nodes.size());
  Vec3 whole = Vec3::Zero();
  for (std::size_t i = 0; i < u.size(); ++i) {
    u[i] = outward(contour.nodes[i], x);
    if (u[i].isZero(0.0)) return false;
    whole += u[i];
  }
  if (moves_as_one(way)) std::fill(u.begin(), u.end(), unit(whole));
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Edge& e = surface_.edges()[contour.nodes[i].edge];
    const Triangle& t = surface_.triangles()[contour.nodes[i].triangle];
    if (surface_.is_cloth(e[0]))
      for (const std::int32_t v : e) motion.add(v, u[i], c);
    else
      for (const std::int32_t v : t) motion.add(v, u[i], c);
  }
  return true;
}

// Whether the cloth that a contour cuts off lies inside the body that it crosses. It does not where
// cloth is drawn around a rim: the part inside is narrow and has no vertex.
bool Untangler::cuts_off_inside(std::size_t c, const CutRegions& regions,
                                std::span<const Vec3> x) const {
  int inside = 0;
  for (std::size_t i = 0; i < contours_[c].nodes.size(); ++i) {
    const EdgeCrossing& node = contours_[c].nodes[i];
    const Edge& e = surface_.edges()[node.edge];
    if (!surface_.is_cloth(e[0])) continue;
    const Vec3 out = outward(node, x), on = x[surface_.triangles()[node.triangle][0]];
    for (const std::int32_t v : e)
      if (regions.is_cut_off(c, contours_[c].side[i], v))
        inside += out.dot(x[v] - on) < 0.0 ? 1 : -1;
  }
  return inside > 0;
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

// A region that is cut off follows its contour: each ring takes the mean of the ring before.
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
    const double weight = d.ratio * mass[d.particle];
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

}  // namespace selvedge::detail
