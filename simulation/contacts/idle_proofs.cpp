// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/simulation/contacts/detail/idle_proofs.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

namespace selvedge::detail {
namespace {

/// A piece is flat if it deviates from a plane by less than this share of its size, and convex if
/// its area deviates by less from that of its convex hull: rounding of a rotated grid.
constexpr double kRounding = 1e-9;

/// Pairs up to so many times the nearest are near ones; the squares are twice as wide.
constexpr double kFarOverNear = 8.0;

/// The spare part is used up to this share; the rest is for rounding.
constexpr double kOfSpare = 0.99;

/// Triangles per range of a parallel loop.
constexpr std::size_t kGrain = 4096;

/// The wait after failures in a row doubles up to this.
constexpr int kLongestWait = 64;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                           const Eigen::Vector2d& b) {
  const Eigen::Vector2d d = b - a;
  const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (p - a - t * d).norm();
}

/// Convex hull, counter-clockwise, by Andrew's monotone chain.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::vector<Eigen::Vector2d> hull;
  const auto chain = [&](auto begin, auto end) {
    const std::size_t first = hull.size();
    for (auto p = begin; p != end; ++p) {
      while (hull.size() >= first + 2 &&
             cross(hull.back() - hull[hull.size() - 2], *p - hull.back()) <= 0.0)
        hull.pop_back();
      hull.push_back(*p);
    }
    hull.pop_back();
  };
  chain(points.begin(), points.end());
  chain(points.rbegin(), points.rend());
  return hull;
}

/// Length of the edges that belong to one triangle alone.
double border_length(std::span<const Triangle> triangles,
                     const std::vector<Eigen::Vector2d>& flat) {
  std::map<Edge, int> count;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      ++count[{std::min(a, b), std::max(a, b)}];
    }
  double length = 0.0;
  for (const auto& [edge, triangles_there] : count)
    if (triangles_there == 1) length += (flat[edge[1]] - flat[edge[0]]).norm();
  return length;
}

/// The least eigenvalue of the symmetric part.
double least_eigenvalue(const Eigen::Matrix2d& m) {
  const double mean = 0.5 * (m(0, 0) + m(1, 1)), half = 0.5 * (m(0, 0) - m(1, 1));
  const double off = 0.5 * (m(0, 1) + m(1, 0));
  return mean - std::sqrt(half * half + off * off);
}

/// The nearest matrix with orthonormal columns to A, by A (AᵀA)^(-1/2); zero where A is flat.
Eigen::Matrix<double, 3, 2> orthonormal(const Eigen::Matrix<double, 3, 2>& a) {
  const Eigen::Matrix2d s = a.transpose() * a;
  const double root = std::sqrt(std::max(0.0, s.determinant()));
  const double trace = std::sqrt(std::max(0.0, s.trace() + 2.0 * root));
  if (!(root > 0.0) || !(trace > 0.0)) return Eigen::Matrix<double, 3, 2>::Zero();
  const Eigen::Matrix2d sqrt_s = (s + root * Eigen::Matrix2d::Identity()) / trace;
  return a * sqrt_s.inverse();
}

}  // namespace

SheetProof::SheetProof(std::span<const Vec3> x, std::span<const Triangle> triangles)
    : triangles_(triangles.begin(), triangles.end()), all_(triangles.size()) {
  std::iota(all_.begin(), all_.end(), 0);
  if (triangles.empty()) return;
  flatten(x);
  if (flat_.empty() || !is_convex()) return;
  nearest_ = nearest_link();
  far_ = kFarOverNear * nearest_;
  inverse_.reserve(triangles_.size());
  start_.resize(triangles_.size());
  change_.resize(triangles_.size());
  for (const Triangle& t : triangles_) {
    Eigen::Matrix2d edges;
    edges << flat_[t[1]] - flat_[t[0]], flat_[t[2]] - flat_[t[0]];
    inverse_.push_back(edges.inverse());
    steepest_ = std::max(steepest_, inverse_.back().norm());
  }
  make_patches();
}

/// Coordinates in the plane of the first triangle; empty if the piece is not flat.
void SheetProof::flatten(std::span<const Vec3> x) {
  const Triangle& t = triangles_.front();
  const Vec3 u = (x[t[1]] - x[t[0]]).normalized();
  const Vec3 normal = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
  const Vec3 v = normal.cross(u);
  double size = 0.0, off = 0.0;
  for (const Vec3& p : x) {
    const Vec3 d = p - x[t[0]];
    size = std::max(size, d.norm());
    off = std::max(off, std::abs(d.dot(normal)));
    flat_.emplace_back(d.dot(u), d.dot(v));
  }
  if (!(off <= kRounding * size)) flat_.clear();
}

/// Triangles of one orientation whose areas add up to that of the convex hull tile it. They meet
/// edge to edge, without a vertex in the middle of an edge, if their only border is that of the
/// hull.
bool SheetProof::is_convex() const {
  double area = 0.0;
  for (const Triangle& t : triangles_) {
    const double twice = cross(flat_[t[1]] - flat_[t[0]], flat_[t[2]] - flat_[t[0]]);
    if (!(twice > 0.0)) return false;
    area += 0.5 * twice;
  }
  const std::vector<Eigen::Vector2d> hull = convex_hull(flat_);
  double hull_area = 0.0, perimeter = 0.0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d& next = hull[(i + 1) % hull.size()];
    hull_area += 0.5 * cross(hull[i], next);
    perimeter += (next - hull[i]).norm();
  }
  return std::abs(area - hull_area) <= kRounding * hull_area &&
         std::abs(border_length(triangles_, flat_) - perimeter) <= kRounding * perimeter;
}

/// A primitive that does not contain a vertex lies beyond the edges opposite to it.
double SheetProof::nearest_link() const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Triangle& t : triangles_)
    for (int k = 0; k < 3; ++k)
      nearest = std::min(
          nearest, distance_to_segment(flat_[t[k]], flat_[t[(k + 1) % 3]], flat_[t[(k + 2) % 3]]));
  return nearest;
}

/// Squares twice `far_` wide, one every `far_`: two points not farther apart share one.
void SheetProof::make_patches() {
  std::map<std::pair<std::int64_t, std::int64_t>, Patch> squares;
  const auto slot = [&](double value) {
    return static_cast<std::int64_t>(std::floor(value / far_));
  };
  for (const std::int32_t t : all_) {
    Eigen::Vector2d low = flat_[triangles_[t][0]], high = low;
    for (const std::int32_t v : triangles_[t]) {
      low = low.cwiseMin(flat_[v]);
      high = high.cwiseMax(flat_[v]);
    }
    for (auto i = slot(low.x()) - 1; i <= slot(high.x()); ++i)
      for (auto j = slot(low.y()) - 1; j <= slot(high.y()); ++j)
        squares[{i, j}].triangles.push_back(t);
  }
  for (auto& [place, patch] : squares) patches_.push_back(std::move(patch));
}

void SheetProof::find_gradients(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1) {
  parallel_for(triangles_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Triangle& t = triangles_[i];
      Gradient e0, e1;
      e0 << x_t0[t[1]] - x_t0[t[0]], x_t0[t[2]] - x_t0[t[0]];
      e1 << x_t1[t[1]] - x_t1[t[0]], x_t1[t[2]] - x_t1[t[0]];
      start_[i] = e0 * inverse_[i];
      change_[i] = (e1 - e0) * inverse_[i];
    }
  });
}

/// c less the largest change of a gradient in these triangles; at most `enough` if c is.
double SheetProof::room(std::span<const std::int32_t> some, double enough) const {
  Gradient sum = Gradient::Zero();
  for (const std::int32_t t : some) sum += 2.0 * start_[t] + change_[t];
  const Gradient b = orthonormal(sum);
  double least = std::numeric_limits<double>::infinity(), fastest = 0.0;
  for (const std::int32_t t : some) {
    const Eigen::Matrix2d g = b.transpose() * start_[t];
    const Eigen::Matrix2d d = b.transpose() * change_[t];
    least = std::min({least, least_eigenvalue(g), least_eigenvalue(g + d)});
    fastest = std::max(fastest, change_[t].squaredNorm());
    if (!(least > enough)) return enough;
  }
  return least - std::sqrt(fastest);
}

/// The spare part of the worst square, beyond the part that `distance` needs; at most 0: no proof.
double SheetProof::spare_room(double distance) const {
  const double for_far = distance / far_, for_near = distance / nearest_;
  const double all = room(all_, for_far);
  if (!(all > for_far) || all > for_near) return all > for_near ? all - for_near : 0.0;
  double spare = all - for_far;
  for (const Patch& patch : patches_) {
    spare = std::min(spare, room(patch.triangles, for_near) - for_near);
    if (!(spare > 0.0)) return 0.0;
  }
  return spare;
}

/// The eigenvalue decreased by at most √2 |D| ‖E⁻¹‖, and the change during the step, of two
/// displacements, is at most twice that.
bool SheetProof::moved_little(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1) const {
  if (proved_.size() != x_t0.size()) return false;
  const double infinite = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Constant(infinite), high = -low;
  for (std::size_t i = 0; i < proved_.size(); ++i) {
    const Vec3 d0 = x_t0[i] - proved_[i], d1 = x_t1[i] - proved_[i];
    low = low.cwiseMin(d0).cwiseMin(d1);
    high = high.cwiseMax(d0).cwiseMax(d1);
  }
  return 3.0 * std::numbers::sqrt2 * (high - low).norm() * steepest_ <= kOfSpare * spare_;
}

bool SheetProof::keeps_apart(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1,
                             double distance) {
  if (!applies()) return false;
  const bool was_enough = !proved_.empty() && distance <= proved_distance_;
  if (was_enough && moved_little(x_t0, x_t1)) return true;
  find_gradients(x_t0, x_t1);
  const double spare = spare_room(distance);
  if (!(spare > 0.0)) return false;
  if (was_enough || distance >= proved_distance_) {
    proved_.assign(x_t0.begin(), x_t0.end());
    proved_distance_ = distance;
    spare_ = spare;
  }
  return true;
}

double IdleCount::saved_s() const {
  const std::int64_t busy = asked - idle;
  return busy == 0 ? 0.0 : busy_s / static_cast<double>(busy) * static_cast<double>(idle);
}

bool ProofBackoff::is_due() {
  if (wait_ == 0) return true;
  --wait_;
  return false;
}

void ProofBackoff::note(bool proved) {
  if (proved) {
    failures_ = 0;
    return;
  }
  wait_ = std::min(kLongestWait, 1 << std::min(failures_, 6)) - 1;
  ++failures_;
}

SweptBox swept_box(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1) {
  const double infinite = std::numeric_limits<double>::infinity();
  SweptBox box{Vec3::Constant(infinite), Vec3::Constant(-infinite)};
  for (std::size_t i = 0; i < x_t0.size(); ++i) {
    box.low = box.low.cwiseMin(x_t0[i]).cwiseMin(x_t1[i]);
    box.high = box.high.cwiseMax(x_t0[i]).cwiseMax(x_t1[i]);
  }
  return box;
}

bool keep_apart(const SweptBox& a, const SweptBox& b, double distance) {
  return ((a.low - b.high).array() > distance).any() || ((b.low - a.high).array() > distance).any();
}

}  // namespace selvedge::detail
