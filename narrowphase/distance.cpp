// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/float_paths.h>
#include <selvedge/narrowphase/distance.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

/// Unit roundoff of double.
constexpr double kHalfUlp = 0x1p-53;
/// Edges whose directions differ by less than this angle (radian) count as parallel: the cross
/// product of two directions has a rounding error of about 4 units, and below four times that, the
/// closest point of their lines is noise.
constexpr double kParallelAngle = 16.0 * kHalfUlp;
/// Square of the sine of the angle between two directions. Above it, a common perpendicular is
/// accurate to 2^-43 of the lengths, and a foot point inside both primitives needs no further
/// check.
constexpr double kWellConditioned = 0x1p-20;
/// A distance below this multiple of the largest coordinate is rounding error of the differences
/// and gives no direction: 3 differences of 1 unit, summed, times a reserve of 4.
constexpr double kNoDirection = 12.0 * kHalfUlp;
/// Number of pairs per task.
constexpr std::size_t kGrain = 2048;

/// Parameter in [0, 1] of the point of the segment origin + s d that is nearest to the point p,
/// with op = p - origin. A zero-length segment gives 0.
double nearest_on_segment(const Vec3& op, const Vec3& d) {
  const double dd = d.squaredNorm();
  return dd > 0.0 ? std::clamp(op.dot(d) / dd, 0.0, 1.0) : 0.0;
}

ClosestPoints make(const std::array<double, 4>& weight, const Vec3& separation) {
  return {weight, separation, separation.norm()};
}

/// The nearest candidate so far: two parameters and the vector between the points.
struct Nearest {
  double u = 0.0, v = 0.0;
  Vec3 separation = Vec3::Zero();
  double square = std::numeric_limits<double>::infinity();

  void offer(double new_u, double new_v, const Vec3& between) {
    const double d = between.squaredNorm();
    if (d < square) u = new_u, v = new_v, separation = between, square = d;
  }
};

/// The middle of the overlap of two parallel edges, if they overlap.
bool middle_of_overlap(const Vec3& ab0, const Vec3& ab1, const Vec3& u, const Vec3& v,
                       ClosestPoints& out) {
  const double uu = u.squaredNorm();
  const double s0 = ab0.dot(u) / uu, s1 = ab1.dot(u) / uu;
  const double lo = std::max(0.0, std::min(s0, s1)), hi = std::min(1.0, std::max(s0, s1));
  if (!(lo <= hi)) return false;
  const double s = 0.5 * (lo + hi);
  const double t = nearest_on_segment(s * u - ab0, v);
  out = make({1.0 - s, s, -(1.0 - t), -t}, s * u - ab0 - t * v);
  return true;
}

}  // namespace

/// The closest point lies inside the triangle or on one of its edges: takes the best of these four
/// candidates. Each is a point of the triangle, so even where a sliver's normal is all rounding
/// error the result is never below the true distance, and the edges keep it close.
ClosestPoints point_triangle_closest(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ap = p - a, ab = b - a, ac = c - a;
  const Vec3 n = ab.cross(ac);
  const double nn = n.squaredNorm();
  Nearest best;
  if (nn > 0.0) {
    const double v = n.dot(ap.cross(ac)) / nn;
    const double w = n.dot(ab.cross(ap)) / nn;
    if (v > 0.0 && w > 0.0 && v + w < 1.0) {
      best.offer(v, w, ap - v * ab - w * ac);
      if (nn > kWellConditioned * ab.squaredNorm() * ac.squaredNorm())
        return make({1.0, -(1.0 - v - w), -v, -w}, best.separation);
    }
  }
  const double s = nearest_on_segment(ap, ab);
  best.offer(s, 0.0, ap - s * ab);
  const double r = nearest_on_segment(ap, ac);
  best.offer(0.0, r, ap - r * ac);
  const Vec3 bp = p - b, bc = c - b;
  const double t = nearest_on_segment(bp, bc);
  const double before = best.square;
  best.offer(1.0 - t, t, bp - t * bc);
  // On the edge (b, c) the weight of a is 0, whatever 1 - (1 - t) - t rounds to.
  const double rest = best.square < before ? 0.0 : 1.0 - best.u - best.v;
  return make({1.0, -rest, -best.u, -best.v}, best.separation);
}

/// Takes the best of five candidates: the closest points of the two lines, if they lie on both
/// edges, and the four end points against the other edge.
ClosestPoints edge_edge_closest(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const Vec3 u = a1 - a0, v = b1 - b0, ab0 = b0 - a0;
  const double uu = u.squaredNorm(), vv = v.squaredNorm();
  const Vec3 n = u.cross(v);
  const double nn = n.squaredNorm();
  Nearest best;
  const auto result = [&] {
    return make({1.0 - best.u, best.u, -(1.0 - best.v), -best.v}, best.separation);
  };
  const bool parallel = nn <= kParallelAngle * kParallelAngle * uu * vv;
  if (!parallel) {
    const double s = n.dot(ab0.cross(v)) / nn;
    const double t = n.dot(ab0.cross(u)) / nn;
    if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) {
      best.offer(s, t, s * u - ab0 - t * v);
      if (nn > kWellConditioned * uu * vv) return result();
    }
  }
  const Vec3 ab1 = b1 - a0;
  ClosestPoints middle;
  if (parallel && uu > 0.0 && vv > 0.0 && middle_of_overlap(ab0, ab1, u, v, middle)) return middle;
  const double t0 = nearest_on_segment(-ab0, v);
  best.offer(0.0, t0, -ab0 - t0 * v);
  const Vec3 b0a1 = a1 - b0;
  const double t1 = nearest_on_segment(b0a1, v);
  best.offer(1.0, t1, b0a1 - t1 * v);
  const double s0 = nearest_on_segment(ab0, u);
  best.offer(s0, 0.0, s0 * u - ab0);
  const double s1 = nearest_on_segment(ab1, u);
  best.offer(s1, 1.0, s1 * u - ab1);
  return result();
}

namespace detail {

ClosestPoints closest_points(ContactKind kind, const std::array<Vec3, 4>& x) {
  return kind == ContactKind::edge_edge ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                        : point_triangle_closest(x[0], x[1], x[2], x[3]);
}

double extent(const std::array<Vec3, 4>& x) {
  double e = 0.0;
  for (int k = 1; k < 4; ++k) e = std::max(e, (x[k] - x[0]).cwiseAbs().maxCoeff());
  return e;
}

namespace {

/// v times the power of two that brings its largest coordinate to [1/2, 1); 0 stays 0.
Vec3 of_size_one(const Vec3& v) {
  int exponent = 0;
  std::frexp(v.cwiseAbs().maxCoeff(), &exponent);
  return Vec3(std::ldexp(v.x(), -exponent), std::ldexp(v.y(), -exponent),
              std::ldexp(v.z(), -exponent));
}

}  // namespace

Vec3 common_normal(ContactKind kind, const std::array<Vec3, 4>& x) {
  const bool edges = kind == ContactKind::edge_edge;
  Vec3 u = edges ? x[1] - x[0] : x[2] - x[1];
  Vec3 v = edges ? x[3] - x[2] : x[3] - x[1];
  const double scale = std::max(u.cwiseAbs().maxCoeff(), v.cwiseAbs().maxCoeff());
  if (!(scale > 0.0)) return Vec3::UnitZ();
  u /= scale, v /= scale;
  // Scales both directions to size 1 by powers of two: if one were far shorter, products would
  // underflow.
  const Vec3 du = of_size_one(u), dv = of_size_one(v), n = du.cross(dv);
  if (n.norm() > kParallelAngle * du.norm() * dv.norm()) return n.normalized();
  const Vec3 longest = u.squaredNorm() >= v.squaredNorm() ? u : v;
  int axis = 0;
  longest.cwiseAbs().minCoeff(&axis);
  return longest.cross(Vec3::Unit(axis)).normalized();
}

Vec3 weighted_difference(const std::array<double, 4>& weight, const std::array<Vec3, 4>& x) {
  return weight[1] * (x[1] - x[0]) + weight[2] * (x[2] - x[0]) + weight[3] * (x[3] - x[0]);
}

Query scaled_query(const Query& query, int& exponent) {
  double largest = 0.0;
  for (const auto* x : {&query.x_t0, &query.x_t1})
    for (const Vec3& v : *x) largest = std::max(largest, v.cwiseAbs().maxCoeff());
  Query q = query;
  std::frexp(largest, &exponent);
  const auto scale = [](double c, int e) { return std::ldexp(c, -e); };
  Vec3 origin;
  for (int i = 0; i < 3; ++i) origin[i] = scale(query.x_t0[0][i], exponent);
  double size = 0.0;
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    for (Vec3& v : *x) {
      for (int i = 0; i < 3; ++i) v[i] = scale(v[i], exponent) - origin[i];
      size = std::max(size, v.cwiseAbs().maxCoeff());
    }
  }
  int second = 0;
  std::frexp(size, &second);
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x)
      for (int i = 0; i < 3; ++i) v[i] = scale(v[i], second);
  exponent += second;
  return q;
}

namespace {

Vec3 at(const Query& q, int k, double t) { return q.x_t0[k] + t * (q.x_t1[k] - q.x_t0[k]); }

}  // namespace

void fill_contact(const Query& query, double toi, Contact& contact) {
  /// Fraction of the vector between the contact points at t = 0 that must lie along the common
  /// normal for it to count as the direction of approach. Below it, the angle to the normal exceeds
  /// 89.99994 degrees.
  constexpr double kAcross = 1e-6;
  int exponent = 0;
  const Query q = scaled_query(query, exponent);
  const std::array<Vec3, 4> x{at(q, 0, toi), at(q, 1, toi), at(q, 2, toi), at(q, 3, toi)};
  contact.toi = toi;
  contact.weight = closest_points(q.kind, x).weight;
  const ClosestPoints start = closest_points(q.kind, q.x_t0);
  contact.gap = std::ldexp(start.distance, exponent);

  const Vec3 way = weighted_difference(contact.weight, q.x_t0);
  Vec3 n = common_normal(q.kind, x);
  const bool apart = start.distance > kNoDirection;
  if (apart && std::abs(way.dot(n)) <= kAcross * way.norm()) n = start.separation / start.distance;
  double side = way.dot(n);
  if (!apart) {
    const Vec3 end = weighted_difference(contact.weight, q.x_t1);
    const double motion = (end - way).dot(n);
    if (motion != 0.0) side = -motion;
  }
  contact.normal = side < 0.0 ? Vec3(-n) : n;
}

void require_finite(const SurfaceView& view, const char* name) {
  for (const std::span<const Vec3> x : {view.x_t0, view.x_t1}) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      // x - x is 0 for finite x and NaN otherwise.
      const Vec3 d = x[i] - x[i];
      if (d.x() + d.y() + d.z() == 0.0) continue;
      throw std::invalid_argument("surface " + std::string(name) + ": vertex " + std::to_string(i) +
                                  " has a coordinate that is not a finite number");
    }
  }
}

void require_finite(const Query& query) {
  for (int k = 0; k < 4; ++k)
    if (!query.x_t0[k].allFinite() || !query.x_t1[k].allFinite())
      throw std::invalid_argument("query: vertex " + std::to_string(k) +
                                  " has a coordinate that is not a finite number");
}

}  // namespace detail

namespace {

using detail::PairVertices;

void append_proximity(const Query& q, const PairVertices& pair, double reach, double reach_at_start,
                      std::vector<Contact>& out) {
  const ClosestPoints near = detail::closest_points(q.kind, q.x_t0);
  if (near.distance >= reach_at_start) return;
  const Vec3 move = detail::weighted_difference(near.weight, q.x_t1) -
                    detail::weighted_difference(near.weight, q.x_t0);
  // No direction brings them closer than the whole displacement does.
  if (near.distance > (reach + move.norm()) * (1.0 + 32.0 * kHalfUlp)) return;
  double largest = 0.0;
  for (const Vec3& v : q.x_t0) largest = std::max(largest, v.cwiseAbs().maxCoeff());
  Vec3 n;
  if (near.distance > kNoDirection * largest) {
    n = near.separation / near.distance;
  } else {
    n = detail::common_normal(q.kind, q.x_t0);
    const double along = near.separation.dot(n);
    if (along < 0.0 || (along == 0.0 && move.dot(n) > 0.0)) n = -n;
  }
  if (!(near.distance + std::min(0.0, move.dot(n)) < reach)) return;
  out.push_back({pair.kind, pair.vertex, near.weight, n, 0.0, near.distance});
}

}  // namespace

void find_proximities(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                      const ProximityReach& reach, std::vector<Contact>& out) {
  std::vector<float> rooms;
  find_proximities(a, b, pairs, reach, out, rooms);
}

void find_proximities(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                      const ProximityReach& reach, std::vector<Contact>& out,
                      std::vector<float>& rooms) {
  const detail::SurfacePairs in{a, b, pairs};
  const detail::FloatPaths paths(a, b);
  const std::size_t n = pairs.size();
  rooms.resize(n);
  std::vector<std::vector<Contact>> found((n + kGrain - 1) / kGrain);
  parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Contact>& mine = found[begin / kGrain];
    detail::PairBlock block;
    std::array<float, detail::kScreenBlock> room;
    for (std::size_t i = begin; i < end; i += block.size) {
      paths.take_block(in, i, end, block);
      const double at_start = block.pairs[0].kind == ContactKind::point_triangle
                                  ? reach.primary_at_start
                                  : reach.secondary_at_start;
      const std::uint32_t far = paths.compare(block, paths.limits(reach.reach, at_start), room);
      std::copy_n(room.begin(), block.size, rooms.begin() + static_cast<std::ptrdiff_t>(i));
      for (std::size_t j = 0; j < block.size; ++j)
        if ((far >> j & 1U) == 0)
          append_proximity(detail::query_of(a, b, block.pairs[j]), block.pairs[j], reach.reach,
                           at_start, mine);
    }
  });
  out.clear();
  for (const std::vector<Contact>& part : found) out.insert(out.end(), part.begin(), part.end());
}

/// Differences round by one unit; products and sums of them with a unit vector that is itself off
/// by two units, by fewer than eight units of the largest.
double slab_width(ContactKind kind, const std::array<Vec3, 4>& x, const Vec3& normal) {
  constexpr double kReserve = 16.0 * kHalfUlp;
  double low = std::numeric_limits<double>::infinity(), high = -low, largest = 0.0;
  for (int k = 0; k < 4; ++k) {
    const Vec3 d = x[k] - x[0];
    const double height = normal.dot(d);
    if (k < detail::first_count(kind))
      low = std::min(low, height);
    else
      high = std::max(high, height);
    largest = std::max(largest, d.norm());
  }
  return std::max(0.0, (low - high) * (1.0 - kReserve) - kReserve * largest);
}

SeparatingSlab separating_slab(ContactKind kind, const std::array<Vec3, 4>& x) {
  SeparatingSlab best{Vec3::UnitZ(), 0.0};
  const auto offer = [&](const Vec3& n) {
    const double width = slab_width(kind, x, n);
    if (width > best.width) best = {n, width};
  };
  const ClosestPoints near = detail::closest_points(kind, x);
  if (near.distance > 0.0) offer(near.separation / near.distance);
  if (best.width > 0.5 * near.distance) return best;
  const Vec3 across = detail::common_normal(kind, x);
  if (best.width == 0.0) best.normal = near.separation.dot(across) < 0.0 ? Vec3(-across) : across;
  offer(across);
  offer(-across);
  return best;
}

void find_separations(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                      std::vector<Contact>& out) {
  out.resize(pairs.size());
  parallel_for(out.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const PairVertices pair = detail::pair_at(a, b, pairs, i);
      const Query q = detail::query_of(a, b, pair);
      const SeparatingSlab slab = separating_slab(q.kind, q.x_t0);
      const ClosestPoints near = detail::closest_points(q.kind, q.x_t0);
      out[i] = {pair.kind, pair.vertex, near.weight, slab.normal, 0.0, slab.width};
    }
  });
}

}  // namespace selvedge
