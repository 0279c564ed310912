// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>
#include <selvedge/detection/detail/surface_checks.h>
#include <selvedge/detection/rotation.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/distance.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace selvedge {
namespace {

// Positions on arcs are wrong by at most this share of the largest coordinate, times one plus the
// angle: below 20 roundings of unit 2^-53 per radian, in three coordinates.
constexpr double kArcRounding = 0x1p-46;

// The tolerance is at least this many roundings, so that halving pieces can reach it.
constexpr double kLeastTolerance = 16.0;

// The narrow phase may add this share of the largest relative coordinate to the separation.
constexpr double kStopping = 0x1p-40;

// Separations are no smaller than this share of the tolerance: smaller ones only take longer.
constexpr double kLeastSeparation = 1.0 / 16.0;

// Pieces of the search for candidates deviate by at most this share of the mean edge length.
// Shorter ones give fewer candidates in more searches.
constexpr double kSearchDeviation = 0.5;
constexpr int kMostSearches = 4096;

// Times of impact in pieces are mapped to the step with this reserve for rounding.
constexpr double kTimeRounding = 0x1p-50;

constexpr std::size_t kPairGrain = 64;  // pairs per task

bool is_finite(const RotatingMotion& m) {
  return m.pivot.allFinite() && m.turn.allFinite() && m.translation.allFinite();
}

// A surface whose vertices follow arcs or straight lines.
class Paths {
 public:
  Paths(const RotatingSurface& s, const std::string& name)
      : x_t0_(s.x_t0), triangles_(s.triangles), motion_(s.motion), angle_(s.motion.turn.norm()) {
    if (!is_finite(motion_))
      throw std::invalid_argument(name + ": the motion has a number that is not finite");
    detail::check_vertices(x_t0_, name, "x_t0");
    detail::check_triangles(triangles_, x_t0_.size(), name);
    const Vec3 axis = angle_ > 0.0 ? Vec3(motion_.turn / angle_) : Vec3(Vec3::Zero());
    radius_.reserve(x_t0_.size());
    for (const Vec3& x : x_t0_) radius_.push_back((x - motion_.pivot).cross(axis).norm());
    note_size(x_t0_);
    size_ += motion_.pivot.norm() + motion_.translation.norm();
  }
  Paths(const MovingSurface& s, const std::string& name)
      : x_t0_(s.x_t0), x_t1_(s.x_t1), triangles_(s.triangles), radius_(s.x_t0.size(), 0.0) {
    if (x_t0_.size() != x_t1_.size())
      throw std::invalid_argument(name + ": x_t0 has " + std::to_string(x_t0_.size()) +
                                  " vertices, x_t1 has " + std::to_string(x_t1_.size()));
    detail::check_vertices(x_t0_, name, "x_t0");
    detail::check_vertices(x_t1_, name, "x_t1");
    detail::check_triangles(triangles_, x_t0_.size(), name);
    note_size(x_t0_);
    note_size(x_t1_);
  }

  std::span<const Triangle> triangles() const { return triangles_; }
  std::size_t count() const { return x_t0_.size(); }
  double angle() const { return angle_; }

  Vec3 at(std::int32_t i, double t) const {
    if (x_t1_.empty()) return position_at(motion_, x_t0_[i], t);
    return (1.0 - t) * x_t0_[i] + t * x_t1_[i];
  }
  void at(double t, std::vector<Vec3>& x) const {
    x.resize(count());
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = at(static_cast<std::int32_t>(i), t);
  }
  // m, largest radius of the vertices
  double radius(std::span<const std::int32_t> vertices) const {
    double r = 0.0;
    for (const std::int32_t i : vertices) r = std::max(r, radius_[i]);
    return r;
  }
  double largest_radius() const {
    return radius_.empty() ? 0.0 : *std::max_element(radius_.begin(), radius_.end());
  }
  // m, bound of the rounding of a position
  double rounding() const { return kArcRounding * (1.0 + angle_) * size_; }
  double size() const { return size_; }

 private:
  void note_size(std::span<const Vec3> x) {
    for (const Vec3& p : x) size_ = std::max(size_, p.norm());
  }

  std::span<const Vec3> x_t0_, x_t1_;  // x_t1_ is empty for arcs
  std::span<const Triangle> triangles_;
  RotatingMotion motion_;
  double angle_ = 0.0;  // rad
  double size_ = 0.0;   // m
  std::vector<double> radius_;
};

// A piece of the step, in [0,1].
struct Piece {
  double begin, end;
  double length() const { return end - begin; }
};

// One pair of primitives, as the narrow phase orders its vertices.
struct Pair {
  ContactKind kind;
  std::int32_t primitive_a, primitive_b;
  std::array<std::int32_t, 4> vertex;

  // Vertices of the first primitive; the others are those of the second.
  std::size_t split() const { return kind == ContactKind::edge_edge ? 2 : 1; }
  // Whether the first primitive belongs to a.
  bool first_is_a() const { return kind != ContactKind::triangle_point; }
};

// Whether the swept boxes of the two primitives are farther apart than `distance`.
bool boxes_apart(const Query& query, std::size_t split, double distance) {
  std::array<Eigen::AlignedBox3d, 2> box;
  for (std::size_t k = 0; k < 4; ++k)
    box[k < split ? 0 : 1].extend(query.x_t0[k]).extend(query.x_t1[k]);
  for (int axis = 0; axis < 3; ++axis)
    if (box[0].min()[axis] - box[1].max()[axis] > distance ||
        box[1].min()[axis] - box[0].max()[axis] > distance)
      return true;
  return false;
}

// Narrow phases with the separations 2^k, made when first needed. The one with the exponent of d
// covers d and is at most twice as large.
class Separations {
 public:
  Separations(double least, double most) {
    for (int k = exponent(least); k <= exponent(std::max(least, most)); ++k)
      narrow_.emplace(k, make_ccd_separation(std::ldexp(1.0, k)));
  }
  static int exponent(double d) {
    int k = 0;
    const double mantissa = std::frexp(d, &k);  // d = mantissa 2^k, mantissa in [1/2, 1)
    return mantissa == 0.5 ? k - 1 : k;
  }
  static double covering(double d) { return std::ldexp(1.0, exponent(d)); }
  const NarrowPhase& at(double d) const { return *narrow_.at(exponent(d)); }

 private:
  std::map<int, std::unique_ptr<NarrowPhase>> narrow_;
};

// The search of one pair of surfaces.
class RotationSearch {
 public:
  RotationSearch(const Paths& a, const Paths& b, const RotationConfig& config)
      : a_(a),
        b_(b),
        tolerance_(config.tolerance),
        rounding_(a.rounding() + b.rounding() + 2.0 * kStopping * (a.size() + b.size())) {
    const auto methods = broad_phases();
    if (const std::string fault = methods.fault(config.broad_phase); !fault.empty())
      throw std::invalid_argument("broad_phase: " + fault);
    broad_ = methods.at(config.broad_phase)({});
    const BroadPhaseTraits traits = broad_->traits();
    if (traits.guarantee != Guarantee::conservative || !traits.deforming || traits.closed_body_only)
      throw std::invalid_argument("broad_phase: " + config.broad_phase +
                                  " does not find all pairs of two moving surfaces");
    if (!(tolerance_ > 0.0) || !std::isfinite(tolerance_))
      throw std::invalid_argument("tolerance is " + std::to_string(tolerance_) +
                                  " m; it must be finite and positive");
    if (!(tolerance_ >= kLeastTolerance * rounding_))
      throw std::invalid_argument(
          "tolerance: coordinates of this size and turns of this angle are rounded by up to " +
          std::to_string(rounding_) + " m; the tolerance must be at least 16 times as large");
  }

  std::vector<Collision> run() {
    edges_a_ = unique_edges(a_.triangles());
    edges_b_ = unique_edges(b_.triangles());
    const int searches = search_count();
    const double widest = deviation(a_.largest_radius(), b_.largest_radius(), 1.0 / searches);
    separations_ = std::make_unique<Separations>(kLeastSeparation * tolerance_, widest);
    std::vector<Collision> out;
    for (int k = 0; k < searches; ++k) search({time(k, searches), time(k + 1, searches)}, out);
    keep_earliest(out);
    return out;
  }

 private:
  static double time(int k, int searches) { return static_cast<double>(k) / searches; }

  // m, how far the pair's distance may be from that of its chords on a piece of this length
  double deviation(double radius_a, double radius_b, double length) const {
    return chord_deviation(radius_a, a_.angle() * length) +
           chord_deviation(radius_b, b_.angle() * length) + rounding_;
  }

  // The deviation at which a pair counts as colliding: with a separation of at most twice the
  // deviation, which the narrow phase exceeds by up to 1/64, and the deviation itself, the
  // distance along the arcs is at most 3.1 times as large.
  bool is_narrow(double deviation) const { return 3.1 * deviation <= tolerance_; }

  int search_count() const {
    double total = 0.0;
    std::size_t count = 0;
    for (const auto& [paths, edges] : {std::pair{&a_, &edges_a_}, std::pair{&b_, &edges_b_}})
      for (const Edge& e : *edges) {
        total += (paths->at(e[1], 0.0) - paths->at(e[0], 0.0)).norm();
        ++count;
      }
    const double wanted =
        std::max(tolerance_, count > 0 ? kSearchDeviation * total / static_cast<double>(count) : 0);
    const double whole = deviation(a_.largest_radius(), b_.largest_radius(), 1.0);
    return static_cast<int>(
        std::clamp(std::ceil(std::sqrt(whole / wanted)), 1.0, static_cast<double>(kMostSearches)));
  }

  void search(const Piece& piece, std::vector<Collision>& out) {
    a_.at(piece.begin, a_t0_);
    a_.at(piece.end, a_t1_);
    b_.at(piece.begin, b_t0_);
    b_.at(piece.end, b_t1_);
    const CandidatePairs found =
        find_candidates(*broad_, MovingSurface{a_t0_, a_t1_, a_.triangles()},
                        MovingSurface{b_t0_, b_t1_, b_.triangles()},
                        deviation(a_.largest_radius(), b_.largest_radius(), piece.length()));
    const std::vector<Pair> pairs = listed(found);
    std::vector<double> toi(pairs.size(), kNoCollision);
    parallel_for(pairs.size(), kPairGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) toi[i] = first_time(pairs[i], piece);
    });
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (toi[i] != kNoCollision) out.push_back(collision(pairs[i], toi[i]));
  }

  std::vector<Pair> listed(const CandidatePairs& found) const {
    std::vector<Pair> pairs;
    pairs.reserve(found.size());
    for (const auto& [point, triangle] : found.point_triangle) {
      const Triangle& t = b_.triangles()[triangle];
      pairs.push_back({ContactKind::point_triangle, point, triangle, {point, t[0], t[1], t[2]}});
    }
    for (const auto& [point, triangle] : found.triangle_point) {
      const Triangle& t = a_.triangles()[triangle];
      pairs.push_back({ContactKind::triangle_point, triangle, point, {point, t[0], t[1], t[2]}});
    }
    for (const auto& [edge_a, edge_b] : found.edge_edge) {
      const Edge &e = edges_a_[edge_a], &f = edges_b_[edge_b];
      pairs.push_back({ContactKind::edge_edge, edge_a, edge_b, {e[0], e[1], f[0], f[1]}});
    }
    return pairs;
  }

  const Paths& owner(const Pair& pair, std::size_t k) const {
    return (k < pair.split()) == pair.first_is_a() ? a_ : b_;
  }

  std::array<Vec3, 4> positions(const Pair& pair, double t) const {
    std::array<Vec3, 4> x;
    for (std::size_t k = 0; k < 4; ++k) x[k] = owner(pair, k).at(pair.vertex[k], t);
    return x;
  }

  // First time at which the pair may share a point, or kNoCollision. The earlier half of a piece
  // comes first, so the first piece that is narrow enough decides.
  double first_time(const Pair& pair, const Piece& whole) const {
    const std::span vertices(pair.vertex);
    const auto first = vertices.first(pair.split()), second = vertices.subspan(pair.split());
    const double radius_a = a_.radius(pair.first_is_a() ? first : second);
    const double radius_b = b_.radius(pair.first_is_a() ? second : first);
    std::vector<Piece> open{whole};
    while (!open.empty()) {
      const Piece piece = open.back();
      open.pop_back();
      const double off = deviation(radius_a, radius_b, piece.length());
      const double toi = chord_time(pair, piece, off);
      if (toi == kNoCollision) continue;
      if (is_narrow(off))
        return std::max(piece.begin, piece.begin + toi * piece.length() - kTimeRounding);
      const double middle = 0.5 * (piece.begin + piece.end);
      open.push_back({middle, piece.end});
      open.push_back({piece.begin, middle});
    }
    return kNoCollision;
  }

  double chord_time(const Pair& pair, const Piece& piece, double off) const {
    const ContactKind kind =
        pair.kind == ContactKind::edge_edge ? ContactKind::edge_edge : ContactKind::point_triangle;
    const Query query{kind, positions(pair, piece.begin), positions(pair, piece.end)};
    const double separation = std::max(off, kLeastSeparation * tolerance_);
    if (boxes_apart(query, pair.split(), Separations::covering(separation))) return kNoCollision;
    double toi = kNoCollision;
    separations_->at(separation).find_times({&query, 1}, {&toi, 1});
    return toi;
  }

  Collision collision(const Pair& pair, double toi) const {
    const std::array<Vec3, 4> x = positions(pair, toi);
    const ClosestPoints closest = pair.kind == ContactKind::edge_edge
                                      ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                      : point_triangle_closest(x[0], x[1], x[2], x[3]);
    Collision c;
    static_cast<PrimitivePair&>(c) = {pair.kind,        pair.primitive_a,
                                      pair.primitive_b, pair.vertex,
                                      closest.weight,   separating_slab(pair.kind, x).normal};
    c.toi = toi;
    return c;
  }

  // A pair that collides in several pieces is reported once. The order is total.
  static void keep_earliest(std::vector<Collision>& found) {
    const auto indices = [](const Collision& c) {
      return std::tuple(c.kind, c.primitive_a, c.primitive_b);
    };
    std::sort(found.begin(), found.end(), [&](const Collision& c, const Collision& d) {
      return std::tuple(indices(c), c.toi) < std::tuple(indices(d), d.toi);
    });
    found.erase(std::unique(found.begin(), found.end(),
                            [&](const Collision& c, const Collision& d) {
                              return indices(c) == indices(d);
                            }),
                found.end());
    std::sort(found.begin(), found.end(), [&](const Collision& c, const Collision& d) {
      return std::tuple(c.toi, indices(c)) < std::tuple(d.toi, indices(d));
    });
  }

  const Paths &a_, &b_;
  double tolerance_, rounding_;  // m
  std::unique_ptr<BroadPhase> broad_;
  std::unique_ptr<Separations> separations_;
  std::vector<Edge> edges_a_, edges_b_;
  std::vector<Vec3> a_t0_, a_t1_, b_t0_, b_t1_;
};

}  // namespace

// x(t) = p + t d + R(t·turn) (x - p), with R by Rodrigues' formula.
Vec3 position_at(const RotatingMotion& motion, const Vec3& x_t0, double t) {
  const Vec3 arm = x_t0 - motion.pivot;
  const double angle = motion.turn.norm();
  if (!(angle > 0.0)) return x_t0 + t * motion.translation;
  const Vec3 axis = motion.turn / angle;
  const double c = elementary::cos(t * angle), s = elementary::sin(t * angle);
  return motion.pivot + t * motion.translation + c * arm + s * axis.cross(arm) +
         ((1.0 - c) * axis.dot(arm)) * axis;
}

RotatingMotion motion_between(const Pose& t0, const Pose& t1) {
  const Eigen::Quaterniond q(Mat3(t1.rotation * t0.rotation.transpose()));
  const double sine = q.vec().norm();  // of half the angle
  const double angle = 2.0 * elementary::atan2(sine, std::abs(q.w()));
  Vec3 turn = Vec3::Zero();
  if (sine > 0.0) turn = (std::copysign(angle, q.w()) / sine) * q.vec();
  return {t0.translation, turn, t1.translation - t0.translation};
}

double chord_deviation(double radius, double angle) { return 0.125 * radius * angle * angle; }

std::vector<Collision> find_rotating_collisions(const RotatingSurface& a, const RotatingSurface& b,
                                                const RotationConfig& config) {
  const Paths paths_a(a, "a"), paths_b(b, "b");
  return RotationSearch(paths_a, paths_b, config).run();
}

std::vector<Collision> find_rotating_collisions(const RotatingSurface& a, const MovingSurface& b,
                                                const RotationConfig& config) {
  const Paths paths_a(a, "a"), paths_b(b, "b");
  return RotationSearch(paths_a, paths_b, config).run();
}

}  // namespace selvedge
