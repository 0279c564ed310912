// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/dyadic.h>
#include <selvedge/judge/detail/exact_predicates.h>
#include <selvedge/judge/detail/integer_polynomial.h>
#include <selvedge/judge/judge.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace selvedge {
namespace {

using judging::operator+, judging::operator-, judging::operator*;
using judging::Polynomial;
using judging::Root;
using Path = std::array<Polynomial, 3>;  // a vector whose components are polynomials in time

Path operator-(const Path& a, const Path& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Polynomial dot(const Path& a, const Path& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Path cross(const Path& a, const Path& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// A point lies on a closed segment at the times when `off_line` is zero and `beyond` is not
// positive.
struct OnSegment {
  Path off_line;
  Polynomial beyond;
};

OnSegment on_segment(const Path& p, const Path& a, const Path& b) {
  return {cross(b - a, p - a), dot(p - a, p - b)};
}

/// Motion of the four vertices relative to the first one, with the polynomials that decide whether
/// the primitives touch. At a time when `coplanar` is zero, the primitives meet
/// - if `normal` is not zero: where no polynomial of `inside` is negative;
/// - if `normal` is zero (a triangle without area, parallel or degenerate edges): where a vertex
///   lies on an edge of the other primitive.
class Motion {
 public:
  Motion(PathKind kind, std::span<const Vec3, 8> points);

  bool touches() const;
  std::optional<TouchTime> first_touch() const;

 private:
  void set_point_triangle();
  void set_edge_edge();
  std::vector<OnSegment> on_segments() const;
  bool touches_at(Root& root) const;
  std::optional<Root> first_root_in_contact() const;
  std::vector<Root> contacts_in_plane() const;

  PathKind kind_;
  std::array<Path, 4> x_;
  Polynomial coplanar_;
  Path normal_;
  std::vector<Polynomial> inside_;
};

Motion::Motion(PathKind kind, std::span<const Vec3, 8> points) : kind_(kind) {
  const auto integers = judging::to_integers(points);
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) {
      const mpz_class start = integers[i][k] - integers[0][k];
      const mpz_class end = integers[i + 4][k] - integers[4][k];
      x_[i][k] = Polynomial{start, end - start};
      while (!x_[i][k].empty() && x_[i][k].back() == 0) x_[i][k].pop_back();
    }
  kind == PathKind::point_triangle ? set_point_triangle() : set_edge_edge();
}

// The projection of p lies in the triangle where n · ((b-a) × (p-a)) >= 0 holds for all three
// edges, with n = (b-a) × (c-a).
void Motion::set_point_triangle() {
  const auto& [p, a, b, c] = x_;
  normal_ = cross(b - a, c - a);
  coplanar_ = dot(normal_, p - a);
  if (!coplanar_.empty() && judging::has_evidently_no_root(coplanar_)) return;
  for (const auto& [u, v] : {std::pair(&a, &b), std::pair(&b, &c), std::pair(&c, &a)})
    inside_.push_back(dot(normal_, cross(*v - *u, p - *u)));
}

// With n = (a1-a0) × (b1-b0), the lines meet at the fraction s = ((b0-a0) × (b1-b0)) · n / n² of
// the first edge and the fraction r = ((b0-a0) × (a1-a0)) · n / n² of the second.
void Motion::set_edge_edge() {
  const auto& [a0, a1, b0, b1] = x_;
  const Path a = a1 - a0, b = b1 - b0, gap = b0 - a0;
  normal_ = cross(a, b);
  coplanar_ = dot(normal_, gap);
  if (!coplanar_.empty() && judging::has_evidently_no_root(coplanar_)) return;
  const Polynomial squared = dot(normal_, normal_);
  const Polynomial s = dot(cross(gap, b), normal_), r = dot(cross(gap, a), normal_);
  inside_ = {s, squared - s, r, squared - r};
}

std::vector<OnSegment> Motion::on_segments() const {
  const auto& x = x_;
  if (kind_ == PathKind::point_triangle)
    return {on_segment(x[0], x[1], x[2]), on_segment(x[0], x[2], x[3]),
            on_segment(x[0], x[3], x[1])};
  return {on_segment(x[0], x[2], x[3]), on_segment(x[1], x[2], x[3]), on_segment(x[2], x[0], x[1]),
          on_segment(x[3], x[0], x[1])};
}

bool vanishes(const Path& path, Root& root) {
  return std::all_of(path.begin(), path.end(),
                     [&](const Polynomial& p) { return root.sign_of(p) == 0; });
}

bool is_on(const OnSegment& s, Root& root) {
  return vanishes(s.off_line, root) && root.sign_of(s.beyond) <= 0;
}

bool Motion::touches_at(Root& root) const {
  if (!vanishes(normal_, root))
    return std::all_of(inside_.begin(), inside_.end(),
                       [&](const Polynomial& p) { return root.sign_of(p) >= 0; });
  const std::vector<OnSegment> segments = on_segments();
  return std::any_of(segments.begin(), segments.end(),
                     [&](const OnSegment& s) { return is_on(s, root); });
}

std::optional<Root> Motion::first_root_in_contact() const {
  for (Root& root : judging::roots_in_unit_interval(coplanar_))
    if (touches_at(root)) return std::move(root);
  return std::nullopt;
}

// All four vertices are coplanar at all times. The set of contact times is closed, so it has a
// first element. If that time is not 0, a vertex lies on an edge of the other primitive then.
// Otherwise the point would be in the interior of a triangle with area, or two edges would cross in
// the interior of both, and they would already have been in contact just before. A vertex reaches
// an edge at a root of any component of `off_line` that is not identically zero, or at a root of
// `beyond` if it never leaves the line. Returns such contact times, among them the first one.
std::vector<Root> Motion::contacts_in_plane() const {
  Root start({0, 0});
  if (touches_at(start)) return {start};
  std::vector<Root> contacts;
  for (const OnSegment& s : on_segments()) {
    const auto moves = [](const Polynomial& p) { return !p.empty(); };
    const auto off_line = std::find_if(s.off_line.begin(), s.off_line.end(), moves);
    for (Root& root :
         judging::roots_in_unit_interval(off_line != s.off_line.end() ? *off_line : s.beyond))
      if (is_on(s, root)) contacts.push_back(std::move(root));
  }
  return contacts;
}

bool Motion::touches() const {
  return coplanar_.empty() ? !contacts_in_plane().empty() : first_root_in_contact().has_value();
}

std::optional<TouchTime> Motion::first_touch() const {
  std::vector<Root> contacts;
  if (coplanar_.empty()) {
    contacts = contacts_in_plane();
  } else if (auto root = first_root_in_contact()) {
    contacts.push_back(std::move(*root));
  }
  if (contacts.empty()) return std::nullopt;
  // Rounding to double, up or down, is monotone and keeps the order of times.
  TouchTime first{1.0, 1.0};
  for (Root& root : contacts) {
    const auto [lo, hi] = root.enclosure();
    first = {std::min(first.lo, lo), std::min(first.hi, hi)};
  }
  return first;
}

// Number of the four vertices that belong to the first primitive.
int first_size(PathKind kind) { return kind == PathKind::point_triangle ? 1 : 2; }

using Points4 = std::span<const Vec3, 4>;

// A direction that separates the hulls at both ends of the motion separates them at every time:
// along it, the signed distance of each pair of vertices is linear in time.
bool separated_all_the_time(const Vec3& direction, int split, std::span<const Vec3, 8> points) {
  const auto side = [&](std::span<const Vec3> at) {
    if (judging::separated_along(direction, at.first(split), at.subspan(split))) return 1;
    return judging::separated_along(direction, at.subspan(split), at.first(split)) ? -1 : 0;
  };
  const int at_start = side(points.first(4));
  return at_start != 0 && at_start == side(points.last(4));
}

Vec3 nearest_on_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length = ab.squaredNorm();
  return length > 0.0 ? Vec3(a + std::clamp((x - a).dot(ab) / length, 0.0, 1.0) * ab) : a;
}

// Approximate vector from the point to the nearest point of the triangle. An approximation is
// enough: the caller's test is safe for any vector.
Vec3 gap_of_point_triangle(Points4 x) {
  const Vec3 normal = (x[2] - x[1]).cross(x[3] - x[1]);
  bool over = true;
  Vec3 gap = x[1] - x[0];
  for (int i = 0; i < 3; ++i) {
    const Vec3 &a = x[1 + i], &b = x[1 + (i + 1) % 3];
    over = over && normal.dot((b - a).cross(x[0] - a)) > 0.0;
    const Vec3 candidate = nearest_on_segment(x[0], a, b) - x[0];
    if (candidate.squaredNorm() < gap.squaredNorm()) gap = candidate;
  }
  return over ? normal : gap;
}

// Approximate vector between the nearest points of two edges: perpendicular to both, or from an end
// of one edge to the other edge.
Vec3 gap_of_edge_edge(Points4 x) {
  const Vec3 a = x[1] - x[0], b = x[3] - x[2], between = x[2] - x[0];
  const Vec3 normal = a.cross(b);
  const double squared = normal.squaredNorm();
  const double s = between.cross(b).dot(normal), r = between.cross(a).dot(normal);
  if (s > 0.0 && s < squared && r > 0.0 && r < squared) return normal;
  std::array<Vec3, 4> gaps{
      nearest_on_segment(x[0], x[2], x[3]) - x[0], nearest_on_segment(x[1], x[2], x[3]) - x[1],
      x[2] - nearest_on_segment(x[2], x[0], x[1]), x[3] - nearest_on_segment(x[3], x[0], x[1])};
  return *std::min_element(gaps.begin(), gaps.end(), [](const Vec3& u, const Vec3& v) {
    return u.squaredNorm() < v.squaredNorm();
  });
}

Vec3 guess_direction(PathKind kind, std::span<const Vec3, 8> points, double t) {
  std::array<Vec3, 4> x;
  for (int i = 0; i < 4; ++i) x[i] = (1.0 - t) * points[i] + t * points[i + 4];
  return kind == PathKind::point_triangle ? gap_of_point_triangle(x) : gap_of_edge_edge(x);
}

bool evidently_apart(PathKind kind, std::span<const Vec3, 8> points) {
  for (const double t : {0.0, 1.0, 0.5})
    if (separated_all_the_time(guess_direction(kind, points, t), first_size(kind), points))
      return true;
  return false;
}

}  // namespace

bool paths_touch_unfiltered(PathKind kind, std::span<const Vec3, 8> points) {
  return Motion(kind, points).touches();
}

bool paths_touch(PathKind kind, std::span<const Vec3, 8> points) {
  return !evidently_apart(kind, points) && paths_touch_unfiltered(kind, points);
}

std::optional<TouchTime> first_touch_unfiltered(PathKind kind, std::span<const Vec3, 8> points) {
  return Motion(kind, points).first_touch();
}

std::optional<TouchTime> first_touch(PathKind kind, std::span<const Vec3, 8> points) {
  if (evidently_apart(kind, points)) return std::nullopt;
  return first_touch_unfiltered(kind, points);
}

}  // namespace selvedge
