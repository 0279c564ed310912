// SPDX-License-Identifier: MIT
//
// How two triangles meet, beyond the vertices that they have in common: the judge and find_meetings
// against an oracle that intersects convex hulls in rational numbers.
//
// SELVEDGE_PAIRS=1000000 detectors_tests --gtest_filter='CommonVertices.*' tries as many pairs.
#include <gmpxx.h>
#include <gtest/gtest.h>
#include <selvedge/detection/find.h>
#include <selvedge/judge/judge.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "broad_phase_trial.h"

namespace selvedge::common_vertices_test {
namespace {

// ---- The oracle

using Point = std::array<mpq_class, 3>;
using Points = std::vector<Point>;

Point difference(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
mpq_class dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
bool is_zero(const Point& a) { return a[0] == 0 && a[1] == 0 && a[2] == 0; }
Point negative(const Point& a) { return {-a[0], -a[1], -a[2]}; }

/// The points x with normal · (x - at) <= 0.
struct HalfSpace {
  Point normal, at;
  mpq_class height(const Point& x) const { return dot(normal, difference(x, at)); }
};

/// The convex hull of at most three points: half-spaces that bound it within its plane or line, and
/// pairs of half-spaces that are that plane or line.
struct Hull {
  std::vector<HalfSpace> flat, sides;
  Points ends;  // its corners without those between others: 3 with area, 2 of a segment, or 1

  explicit Hull(const Points& points) : ends(points) {
    drop_corners_between();
    if (ends.size() == 3) {
      const Point normal = cross(difference(ends[1], ends[0]), difference(ends[2], ends[0]));
      add_flat(normal);
      for (int i = 0; i < 3; ++i)
        sides.push_back({cross(difference(ends[(i + 1) % 3], ends[i]), normal), ends[i]});
      return;
    }
    const Point along = difference(ends.back(), ends.front());
    for (int k = 0; k < 3; ++k) {
      Point axis{0, 0, 0};
      axis[k] = 1;
      add_flat(ends.size() == 1 ? axis : cross(axis, along));
    }
    if (ends.size() == 1) return;
    sides.push_back({along, ends[1]});
    sides.push_back({negative(along), ends[0]});
  }

  bool contains_inside(const Point& x) const {
    return std::all_of(flat.begin(), flat.end(), [&](const auto& h) { return h.height(x) <= 0; }) &&
           std::all_of(sides.begin(), sides.end(), [&](const auto& h) { return h.height(x) < 0; });
  }

 private:
  void add_flat(const Point& normal) {
    flat.push_back({normal, ends[0]});
    flat.push_back({negative(normal), ends[0]});
  }

  // Of points on a line, the two that are farthest apart stay; of equal points one.
  void drop_corners_between() {
    if (ends.size() == 3 &&
        !is_zero(cross(difference(ends[1], ends[0]), difference(ends[2], ends[0]))))
      return;
    Points kept{ends[0]};
    mpq_class longest = 0;
    for (const Point& a : ends)
      for (const Point& b : ends)
        if (const mpq_class l = dot(difference(a, b), difference(a, b)); l > longest) {
          longest = l;
          kept = {a, b};
        }
    ends = kept;
  }
};

Points clipped(const Points& polygon, const HalfSpace& half) {
  Points kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const mpq_class ha = half.height(a), hb = half.height(b);
    if (ha <= 0) kept.push_back(a);
    if (sgn(ha) * sgn(hb) >= 0) continue;
    const mpq_class s = ha / (ha - hb);
    Point p;
    for (int k = 0; k < 3; ++k) p[k] = a[k] + s * (b[k] - a[k]);
    kept.push_back(p);
  }
  return kept;
}

/// Corners of what two hulls have in common.
Points common_part(const Hull& a, const Hull& b) {
  Points polygon = a.ends;
  for (const auto* halves : {&b.flat, &b.sides})
    for (const HalfSpace& half : *halves) polygon = clipped(polygon, half);
  return polygon;
}

bool meet(const Points& a, const Points& b) { return !common_part(Hull(a), Hull(b)).empty(); }

/// Two insides meet if and only if they contain the mean of the corners of the common part.
bool insides_cross(const Points& a, const Points& b) {
  const Hull of_a(a), of_b(b);
  if (of_a.ends.size() < 3 && of_b.ends.size() < 3) return false;
  if (of_a.ends.size() < 2 || of_b.ends.size() < 2) return false;
  for (const auto& [segment, other] : {std::pair(&of_a, &of_b), std::pair(&of_b, &of_a)})
    if (segment->ends.size() == 2 && other->flat[0].height(segment->ends[0]) == 0 &&
        other->flat[0].height(segment->ends[1]) == 0)
      return false;  // it lies in the plane of the triangle
  const Points part = common_part(of_a, of_b);
  if (part.empty()) return false;
  Point mean{0, 0, 0};
  for (const Point& p : part)
    for (int k = 0; k < 3; ++k) mean[k] += p[k] / mpq_class(static_cast<long>(part.size()));
  return of_a.contains_inside(mean) && of_b.contains_inside(mean);
}

enum class How { apart, touch, cross };

std::vector<std::vector<std::int32_t>> primitives_of(const Triangle& t) {
  return {{t[0]}, {t[1]}, {t[2]}, {t[0], t[1]}, {t[1], t[2]}, {t[2], t[0]}, {t[0], t[1], t[2]}};
}

bool have_common(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
  return std::any_of(a.begin(), a.end(),
                     [&](std::int32_t v) { return std::find(b.begin(), b.end(), v) != b.end(); });
}

/// Comparisons of doubles are exact, and hulls with disjoint boxes do not meet.
bool boxes_meet(const TriangleMesh& mesh, const std::vector<std::int32_t>& a,
                const std::vector<std::int32_t>& b) {
  for (int k = 0; k < 3; ++k) {
    const auto less = [&](std::int32_t v, std::int32_t w) {
      return mesh.vertices[v][k] < mesh.vertices[w][k];
    };
    const auto [low_a, high_a] = std::minmax_element(a.begin(), a.end(), less);
    const auto [low_b, high_b] = std::minmax_element(b.begin(), b.end(), less);
    if (less(*high_a, *low_b) || less(*high_b, *low_a)) return false;
  }
  return true;
}

/// By the definition: corners and edges against triangles, and edges against edges, without those
/// that have a vertex in common.
How how_they_meet(const TriangleMesh& mesh) {
  const auto points = [&](const std::vector<std::int32_t>& vertices) {
    Points list;
    for (const std::int32_t v : vertices) {
      const Vec3& x = mesh.vertices[v];
      list.push_back({mpq_class(x[0]), mpq_class(x[1]), mpq_class(x[2])});
    }
    return list;
  };
  const auto of_s = primitives_of(mesh.triangles[0]), of_t = primitives_of(mesh.triangles[1]);
  if (insides_cross(points(of_s.back()), points(of_t.back()))) return How::cross;
  for (const auto& p : of_s)
    for (const auto& q : of_t)
      if (p.size() + q.size() >= 4 && !have_common(p, q) && boxes_meet(mesh, p, q) &&
          meet(points(p), points(q)))
        return How::touch;
  return How::apart;
}

// ---- The two methods

How judged(const TriangleMesh& mesh) {
  const Verdict verdict = judge(mesh, {}, {});
  EXPECT_LE(verdict.self_intersections + verdict.self_touches, 1u);
  return verdict.self_intersections > 0 ? How::cross
         : verdict.self_touches > 0     ? How::touch
                                        : How::apart;
}

How found(const TriangleMesh& mesh) {
  const TriangleMeetings meetings = find_meetings(mesh.vertices, mesh.triangles);
  EXPECT_LE(meetings.all().size(), 1u);
  return !meetings.crossings.empty() ? How::cross
         : !meetings.touches.empty() ? How::touch
                                     : How::apart;
}

// ---- Random pairs

Vec3 random_point(Random& random, int kind) {
  switch (kind) {
    case 0:
      return Vec3(random.integer(0, 2), random.integer(0, 2), random.integer(0, 2));
    case 1:
      return Vec3(random.integer(0, 4), random.integer(0, 4), 0.0) / 3.0;
    case 2: {  // nearly in a tilted plane
      const double x = 0.1 * random.integer(0, 7), y = 0.1 * random.integer(0, 7);
      return {x, y, 0.3 * x + 0.7 * y};
    }
    case 3:  // a small triangle far out, as in a body in millimetres
      return Vec3(97.1358, -291.711, 132.143) +
             1e-3 * Vec3(random.integer(-8, 8), random.integer(-8, 8), random.integer(0, 3));
    default:
      return random.vector(1.0);
  }
}

void nudge(Random& random, Vec3& x) {
  for (double& value : x)
    if (random.integer(0, 5) == 0)
      value = std::nextafter(value, random.integer(0, 1) == 0 ? -INFINITY : INFINITY);
}

/// Two triangles with `common` vertices: anywhere, on a lattice, nearly in a plane, and with
/// corners near an edge or the inside of the other one.
TriangleMesh random_pair(Random& random, int common) {
  const int kind = random.integer(0, 4), vertices = 6 - common;
  TriangleMesh mesh;
  for (int i = 0; i < vertices; ++i) mesh.vertices.push_back(random_point(random, kind));
  const auto any = [&]() -> Vec3& { return mesh.vertices[random.below(mesh.vertices.size())]; };
  for (int i = random.integer(0, 2); i > 0; --i) {
    const double s = 0.25 * random.integer(-2, 6), t = 0.25 * random.integer(0, 2);
    const Vec3 a = any(), b = any(), c = any();
    any() = a + s * (b - a) + t * (c - a);
  }
  if (random.integer(0, 2) == 0)
    for (Vec3& x : mesh.vertices) nudge(random, x);
  Triangle s{0, 1, 2}, t{0, 1, 2};
  for (int i = common; i < 3; ++i) t[i] = 3 + i - common;
  if (random.integer(0, 30) == 0) t[2] = t[1];
  std::rotate(t.begin(), t.begin() + random.integer(0, 2), t.end());
  if (random.integer(0, 1) == 0) std::swap(s[0], s[1]);
  mesh.triangles = {s, t};
  return mesh;
}

std::string text(const TriangleMesh& mesh) {
  std::ostringstream out;
  out.precision(17);
  for (const Vec3& x : mesh.vertices) out << "v " << x.transpose() << "\n";
  for (const Triangle& t : mesh.triangles)
    out << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
  return out.str();
}

int count_of_pairs() {
  const char* asked = std::getenv("SELVEDGE_PAIRS");
  return asked != nullptr ? std::max(1, std::atoi(asked)) : 2000;
}

TEST(CommonVertices, JudgeAndDetectionAgreeWithRationalHullsOnRandomPairs) {
  constexpr unsigned kSeed = 20261128;
  const int pairs = count_of_pairs();
  Random random(kSeed);
  std::array<std::array<int, 3>, 4> seen{};
  for (int i = 0; i < pairs; ++i) {
    constexpr std::array<int, 8> kCommon{1, 2, 1, 2, 1, 0, 1, 3};
    const int common = kCommon[static_cast<std::size_t>(i) % kCommon.size()];
    const TriangleMesh mesh = random_pair(random, common);
    const How expected = how_they_meet(mesh);
    ++seen[static_cast<std::size_t>(common)][static_cast<std::size_t>(expected)];
    ASSERT_EQ(judged(mesh), expected) << "judge, pair " << i << ", seed " << kSeed << "\n"
                                      << text(mesh);
    ASSERT_EQ(found(mesh), expected) << "detection, pair " << i << ", seed " << kSeed << "\n"
                                     << text(mesh);
  }
  for (const int common : {0, 1, 2})
    for (const int how : {0, 1, 2})
      EXPECT_GT(seen[common][how], pairs / 1000) << common << " common vertices, " << how;
  std::cout << pairs << " pairs of seed " << kSeed << " agree; apart, touch, cross with 0 to 3 "
            << "common vertices:";
  for (const auto& row : seen) std::cout << "  " << row[0] << " " << row[1] << " " << row[2];
  std::cout << "\n";
}

/// The same triangles, each with vertices of its own.
TriangleMesh unwelded(const TriangleMesh& mesh) {
  TriangleMesh result;
  for (const Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::int32_t>(result.vertices.size());
    for (const std::int32_t v : t) result.vertices.push_back(mesh.vertices[v]);
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

TEST(CommonVertices, TrianglesWithEqualPositionsCrossAsWeldedOnesElseTouch) {
  constexpr unsigned kSeed = 20261129;
  Random random(kSeed);
  std::array<int, 3> seen{};
  for (int i = 0; i < count_of_pairs(); ++i) {
    const TriangleMesh mesh = random_pair(random, 1 + i % 3);
    const How expected = how_they_meet(mesh) == How::cross ? How::cross : How::touch;
    ++seen[static_cast<std::size_t>(expected)];
    ASSERT_EQ(judged(unwelded(mesh)), expected) << "pair " << i << ", seed " << kSeed << "\n"
                                                << text(mesh);
    ASSERT_EQ(found(unwelded(mesh)), expected) << "detection, pair " << i << "\n" << text(mesh);
  }
  for (const int how : {1, 2}) EXPECT_GT(seen[how], count_of_pairs() / 10) << how;
}

// ---- Pairs by hand

How both(const TriangleMesh& mesh) {
  EXPECT_EQ(judged(mesh), found(mesh)) << text(mesh);
  EXPECT_EQ(judged(mesh), how_they_meet(mesh)) << text(mesh);
  return judged(mesh);
}

const Vec3 kA(0, 0, 0), kB(1, 0, 0), kC(0, 1, 0);

TEST(CommonVertices, AnEdgeThroughTheInsideOfATriangleAtItsCornerCrosses) {
  EXPECT_EQ(both({{kA, kB, kC, {.25, .25, .5}, {.25, .25, -.5}}, {{0, 1, 2}, {0, 3, 4}}}),
            How::cross);
  EXPECT_EQ(both({{kA, kB, kC, {.75, .75, .5}, {.75, .75, -.5}}, {{0, 1, 2}, {0, 3, 4}}}),
            How::cross)
      << "an edge of the first through the inside of the second";
  EXPECT_EQ(both({{kA, kB, kC, {.5, .5, .5}, {.5, .5, -.5}}, {{0, 1, 2}, {0, 3, 4}}}), How::cross)
      << "the edges opposite the corner meet";
}

TEST(CommonVertices, ACornerOnATriangleTouchesIt) {
  EXPECT_EQ(both({{kA, kB, kC, {.25, .25, 0}, {.25, .25, .5}}, {{0, 1, 2}, {0, 3, 4}}}),
            How::touch);
  EXPECT_EQ(both({{kA, kB, kC, {.5, 0, 0}, {.5, -.5, 0}}, {{0, 1, 2}, {0, 3, 4}}}), How::touch)
      << "a hanging vertex on the edge";
  EXPECT_EQ(both({{kA, kB, kC, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}}), How::apart);
}

TEST(CommonVertices, OverlapInAreaCrosses) {
  EXPECT_EQ(both({{kA, kB, kC, {2, 0, 0}, {0, 2, 0}}, {{0, 1, 2}, {0, 3, 4}}}), How::cross);
  EXPECT_EQ(both({{kA, kB, kC}, {{0, 1, 2}, {0, 2, 1}}}), How::cross) << "doubled";
  EXPECT_EQ(both({{kA, kB, kC, {.9, .9, 0}}, {{0, 1, 2}, {1, 0, 3}}}), How::cross)
      << "a folded leaf";
  EXPECT_EQ(both({{kA, kB, kC, {.9, -.9, 0}}, {{0, 1, 2}, {1, 0, 3}}}), How::apart);
  EXPECT_EQ(both({{kA, kB, kC, {0, 1, std::numeric_limits<double>::denorm_min()}},
                  {{0, 1, 2}, {1, 0, 3}}}),
            How::apart);
}

TEST(CommonVertices, EqualPositionsOfDifferentIndicesTouch) {
  EXPECT_EQ(both({{kA, kB, kC, kA, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {3, 4, 5}}}), How::touch);
  EXPECT_EQ(both({{kA, kB, kC, kB, kC, {1, 1, 0}}, {{0, 1, 2}, {3, 5, 4}}}), How::touch);
  EXPECT_EQ(both({{kA, kB, kC, kA, kB, kC}, {{0, 1, 2}, {3, 4, 5}}}), How::cross);
}

TEST(CommonVertices, ADegenerateTriangleIsASegment) {
  EXPECT_EQ(both({{kA, kB, kC, {.2, .2, -1}, {.2, .2, 0}, {.2, .2, 1}}, {{0, 1, 2}, {3, 4, 5}}}),
            How::cross);
  EXPECT_EQ(both({{kA, kB, kC, {.2, .2, 0}, {.4, .4, 0}}, {{0, 1, 2}, {0, 3, 4}}}), How::touch);
  EXPECT_EQ(both({{kA, kB, kC, {.5, 0, 0}}, {{0, 1, 2}, {0, 1, 3}}}), How::touch)
      << "its corner lies on the common edge";
  EXPECT_EQ(both({{kA, kB, kC, {2, 0, 0}}, {{0, 1, 2}, {0, 1, 3}}}), How::touch)
      << "one of its edges passes over a corner";
  EXPECT_EQ(both({{kA, kB, kC, {-1, 0, 0}, {-2, 0, 0}}, {{0, 1, 2}, {0, 3, 4}}}), How::apart);
}

TEST(CommonVertices, FiveNearlyCoplanarPointsCrossInThreeOfFifteenWays) {
  const std::vector<Vec3> x{{97.1358, -291.711, 132.143},
                            {97.14, -291.719, 132.147},
                            {97.1361, -291.711, 132.144},
                            {97.1298, -291.719, 132.145},
                            {97.1289, -291.709, 132.148}};
  std::vector<std::array<std::int32_t, 5>> crossing;
  for (std::int32_t v = 0; v < 5; ++v) {
    std::array<std::int32_t, 4> rest{};
    for (std::int32_t i = 0, k = 0; i < 5; ++i)
      if (i != v) rest[k++] = i;
    for (int partner = 1; partner < 4; ++partner) {
      const std::int32_t a = rest[0], b = rest[partner];
      const std::int32_t c = rest[partner == 1 ? 2 : 1], d = rest[partner == 3 ? 2 : 3];
      const TriangleMesh mesh{x, {{v, a, b}, {v, c, d}}};
      if (both(mesh) == How::cross) crossing.push_back({v + 1, a + 1, b + 1, c + 1, d + 1});
    }
  }
  const std::vector<std::array<std::int32_t, 5>> expected{
      {1, 2, 5, 3, 4}, {2, 1, 5, 3, 4}, {5, 1, 2, 3, 4}};
  EXPECT_EQ(crossing, expected);
}

// ---- Surfaces that pass through a triangle along an edge

How both_with_a_leaf(const Vec3& other_apex) {
  // Two triangles with the edge 3-4, which lies on the first triangle.
  const TriangleMesh mesh{
      {{-1, -1, 0}, {4, -1, 0}, {-1, 4, 0}, {0, 0, 0}, {1, 0, 0}, {.5, 0, 1}, other_apex},
      {{0, 1, 2}, {3, 4, 5}, {4, 3, 6}}};
  const Verdict verdict = judge(mesh, {}, {});
  const TriangleMeetings found_pairs = find_meetings(mesh.vertices, mesh.triangles);
  EXPECT_EQ(verdict.self_intersections, found_pairs.crossings.size());
  EXPECT_EQ(verdict.self_touches, found_pairs.touches.size());
  EXPECT_EQ(verdict.self_intersections + verdict.self_touches, 2u);
  return verdict.self_intersections == 2 ? How::cross
         : verdict.self_touches == 2     ? How::touch
                                         : How::apart;
}

TEST(CommonVertices, ASurfaceThatPassesThroughATriangleAlongAnEdgeCrossesIt) {
  EXPECT_EQ(both_with_a_leaf({.5, 0, -1}), How::cross);
  EXPECT_EQ(both_with_a_leaf({.5, .2, 1}), How::touch) << "a fold that rests on it";
}

TEST(CommonVertices, ASheetThroughAnotherAlongItsEdgesCrosses) {
  // Two lattices of unit squares at right angles; the edges of the one lie inside faces of the
  // other.
  TriangleMesh sheet;
  for (int j = 0; j <= 4; ++j)
    for (int i = 0; i <= 4; ++i) sheet.vertices.emplace_back(i, j, 0);
  for (std::int32_t j = 0; j < 4; ++j)
    for (std::int32_t i = 0; i < 4; ++i) {
      const std::int32_t k = 5 * j + i;
      sheet.triangles.push_back({k, k + 1, k + 6});
      sheet.triangles.push_back({k, k + 6, k + 5});
    }
  TriangleMesh wall = sheet;
  for (Vec3& x : wall.vertices) x = Vec3(2.25, x.x() - 0.125, x.y() - 2.0);
  const TriangleMeetings found_pairs =
      find_meetings({wall.vertices, wall.triangles}, {sheet.vertices, sheet.triangles});
  const Verdict verdict = judge(wall, sheet, {});
  EXPECT_GT(verdict.body_intersections, 0u);
  EXPECT_EQ(verdict.body_intersections, found_pairs.crossings.size());
  EXPECT_EQ(verdict.body_touches, found_pairs.touches.size());
}

// ---- Motion: what the continuous test proves of triangles with common vertices

/// On a lattice of eighths, positions at sixteenths of the step are exact.
TEST(CommonVertices, AStepWithoutCollisionKeepsNeighboursApart) {
  Random random(7);
  int free = 0;
  const auto point = [&] {
    return Vec3(random.integer(0, 4), random.integer(0, 4), random.integer(0, 3));
  };
  for (int i = 0; i < 2000; ++i) {
    const int common = random.integer(1, 2);
    TriangleMesh start;
    std::vector<Vec3> end;
    for (int v = 0; v < 6 - common; ++v) {
      start.vertices.push_back(point());
      end.push_back(random.integer(0, 2) == 0 ? start.vertices.back() : point());
    }
    start.triangles = {{0, 1, 2}, common == 1 ? Triangle{0, 3, 4} : Triangle{1, 0, 3}};
    const bool collides = !find_collisions(start.vertices, end, start.triangles).empty();
    if (collides || !find_meetings(start.vertices, start.triangles).empty()) continue;
    ++free;
    for (int k = 1; k <= 16; ++k) {
      TriangleMesh now = start;
      for (std::size_t v = 0; v < end.size(); ++v)
        now.vertices[v] += k / 16.0 * (end[v] - start.vertices[v]);
      ASSERT_TRUE(find_meetings(now.vertices, now.triangles).empty())
          << "step " << i << " at " << k << "/16\n"
          << text(now);
    }
  }
  EXPECT_GT(free, 200);
}

}  // namespace
}  // namespace selvedge::common_vertices_test
