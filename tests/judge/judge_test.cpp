// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/exact_predicates.h>
#include <selvedge/judge/judge.h>

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <stdexcept>

#include "judge_shapes.h"

namespace selvedge::judge_test {
namespace {

using judging::TrianglePoints;

// ---- An oracle of another kind: clip one triangle by the other's half-spaces, all rational.

using RationalPoint = std::array<mpq_class, 3>;

RationalPoint rational(const Vec3& x) {
  return {mpq_class(x[0]), mpq_class(x[1]), mpq_class(x[2])};
}

RationalPoint minus(const RationalPoint& a, const RationalPoint& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

mpq_class dot(const RationalPoint& a, const RationalPoint& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

RationalPoint cross(const RationalPoint& a, const RationalPoint& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

bool is_zero(const RationalPoint& a) { return a[0] == 0 && a[1] == 0 && a[2] == 0; }

using Polygon = std::vector<RationalPoint>;

// Keeps what lies at normal · (x - at) <= 0.
Polygon clip(const Polygon& polygon, const RationalPoint& normal, const RationalPoint& at) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const RationalPoint &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const mpq_class at_a = dot(normal, minus(a, at)), at_b = dot(normal, minus(b, at));
    if (at_a <= 0) kept.push_back(a);
    if ((at_a < 0 && at_b > 0) || (at_a > 0 && at_b < 0)) {
      const mpq_class s = at_a / (at_a - at_b);
      const RationalPoint ab = minus(b, a);
      kept.push_back({a[0] + s * ab[0], a[1] + s * ab[1], a[2] + s * ab[2]});
    }
  }
  return kept;
}

Polygon clip_to_plane(Polygon polygon, const RationalPoint& normal, const RationalPoint& at) {
  polygon = clip(polygon, normal, at);
  return clip(polygon, {-normal[0], -normal[1], -normal[2]}, at);
}

Polygon clip_to_segment(Polygon polygon, const RationalPoint& a, const RationalPoint& b) {
  const RationalPoint d = minus(b, a);
  for (int k = 0; k < 3; ++k) {
    RationalPoint axis{0, 0, 0};
    axis[k] = 1;
    // A point has d = 0: then the axes themselves tie it down.
    polygon = clip_to_plane(polygon, is_zero(d) ? axis : cross(axis, d), a);
  }
  polygon = clip(polygon, d, b);
  return clip(polygon, {-d[0], -d[1], -d[2]}, a);
}

Polygon clip_to_degenerate(const Polygon& polygon, const Polygon& t) {
  // Of three points on a line, the two farthest apart are the ends.
  std::size_t from = 0, to = 0;
  mpq_class longest = -1;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i + 1; j < 3; ++j)
      if (const mpq_class l = dot(minus(t[i], t[j]), minus(t[i], t[j])); l > longest) {
        longest = l;
        from = i;
        to = j;
      }
  return clip_to_segment(polygon, t[from], t[to]);
}

bool meet_by_clipping(const TrianglePoints& s, const TrianglePoints& t) {
  Polygon polygon, other;
  for (int i = 0; i < 3; ++i) {
    polygon.push_back(rational(s[i]));
    other.push_back(rational(t[i]));
  }
  const RationalPoint normal = cross(minus(other[1], other[0]), minus(other[2], other[0]));
  if (is_zero(normal)) return !clip_to_degenerate(polygon, other).empty();
  polygon = clip_to_plane(polygon, normal, other[0]);
  for (int i = 0; i < 3; ++i)
    polygon = clip(polygon, cross(minus(other[(i + 1) % 3], other[i]), normal), other[i]);
  return !polygon.empty();
}

// ---- Shapes

TriangleMesh two_triangles(const TrianglePoints& s, const TrianglePoints& t) {
  return {{s[0], s[1], s[2], t[0], t[1], t[2]}, {{0, 1, 2}, {3, 4, 5}}};
}

std::size_t meetings(const TrianglePoints& s, const TrianglePoints& t) {
  const Verdict verdict = judge(two_triangles(s, t), {}, {});
  return verdict.self_intersections + verdict.self_touches;
}

// An octahedron, each face halved `levels` times and pushed out to the sphere.
TriangleMesh sphere(double radius, int levels) {
  TriangleMesh mesh{
      {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)},
      {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int level = 0; level < levels; ++level) {
    std::map<Edge, std::int32_t> middles;
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      const auto [at, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)},
                                                    static_cast<int>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return at->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = finer;
  }
  for (Vec3& x : mesh.vertices) x *= radius;
  return mesh;
}

// ---- Intersections of two triangles

TEST(Judge, CountsTwoTrianglesThatPierceEachOther) {
  EXPECT_EQ(meetings(unit, {Vec3(0.2, 0.2, -1), Vec3(0.3, 0.2, 1), Vec3(0.2, 0.3, 1)}), 1u);
  EXPECT_EQ(meetings(unit, {Vec3(0.2, 0.2, 1), Vec3(0.3, 0.2, 2), Vec3(0.2, 0.3, 2)}), 0u);
}

TEST(Judge, CountsATouchingVertexOnFaceEdgeAndCorner) {
  const Vec3 up0(0.2, 0.2, 1), up1(0.3, 0.2, 1);
  EXPECT_EQ(meetings(unit, {Vec3(0.25, 0.25, 0), up0, up1}), 1u);
  EXPECT_EQ(meetings(unit, {Vec3(0.5, 0.5, 0), up0, up1}), 1u);
  EXPECT_EQ(meetings(unit, {Vec3(1, 0, 0), up0, up1}), 1u);
}

TEST(Judge, SeparatesATouchFromAGapOfOneUlp) {
  const double above = std::numeric_limits<double>::denorm_min();
  const Vec3 up0(0.2, 0.2, 1), up1(0.3, 0.2, 1);
  EXPECT_EQ(meetings(unit, {Vec3(0.25, 0.25, above), up0, up1}), 0u);
  const double beyond = std::nextafter(0.5, 1.0);
  EXPECT_EQ(meetings(unit, {Vec3(beyond, 0.5, 0), up0, up1}), 0u);
  EXPECT_EQ(meetings(unit, {Vec3(beyond, std::nextafter(0.5, 0.0), 0), up0, up1}), 0u)
      << "the step beyond the edge is twice the step back";
}

TEST(Judge, CountsOverlapWithinAPlaneAndATriangleInsideAnother) {
  EXPECT_EQ(meetings(unit, {Vec3(0.4, 0.4, 0), Vec3(2, 0, 0), Vec3(2, 2, 0)}), 1u);
  EXPECT_EQ(meetings(unit, {Vec3(0.1, 0.1, 0), Vec3(0.2, 0.1, 0), Vec3(0.1, 0.2, 0)}), 1u);
  EXPECT_EQ(meetings({Vec3(0.1, 0.1, 0), Vec3(0.2, 0.1, 0), Vec3(0.1, 0.2, 0)}, unit), 1u);
  EXPECT_EQ(meetings(unit, {Vec3(1, 1, 0), Vec3(1, 0.5, 0), Vec3(0.6, 1, 0)}), 0u);
}

TEST(Judge, TakesDegenerateTrianglesForThePointsAndSegmentsTheyAre) {
  const Vec3 p(0.25, 0.25, 0), q(0.25, 0.25, 1), r(0.25, 0.25, 0.5);
  EXPECT_EQ(meetings(unit, {p, p, p}), 1u);
  EXPECT_EQ(meetings(unit, {q, q, q}), 0u);
  EXPECT_EQ(meetings(unit, {r, p, q}), 1u);
  EXPECT_EQ(meetings(unit, {q, r, q}), 0u);
  EXPECT_EQ(meetings({p, q, r}, {Vec3(0, 0, 0.5), Vec3(0.5, 0.5, 0.5), Vec3(0.1, 0.1, 0.5)}), 1u);
  EXPECT_EQ(meetings({p, p, p}, {p, p, p}), 1u);
  EXPECT_EQ(meetings({p, r, r}, {q, q, r}), 1u);
}

TEST(Judge, TakesVerticesAsCommonByIndexNotByPosition) {
  const TriangleMesh shared{
      {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(-1, 0, 0)},
      {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(judge(shared, {}, {}).self_intersections, 1u) << "they overlap in area";
  const Verdict verdict =
      judge(two_triangles(unit, {unit[0], Vec3(-1, 0, 0), Vec3(0, -1, 0)}), {}, {});
  EXPECT_EQ(verdict.self_touches, 1u);
  EXPECT_EQ(verdict.self_intersections, 0u);
}

TEST(Judge, NamesTheFirstPairsInOrder) {
  TriangleMesh mesh;
  for (int i = 0; i < 6; ++i) append(mesh, {{unit[0], unit[1], unit[2]}, {{0, 1, 2}}});
  const Verdict verdict = judge(mesh, {}, {});
  EXPECT_EQ(verdict.self_intersections, 15u);
  ASSERT_EQ(verdict.first_self.size(), 10u);
  EXPECT_TRUE(std::is_sorted(verdict.first_self.begin(), verdict.first_self.end()));
  EXPECT_EQ(verdict.first_self.front(), std::pair(0, 1));
  EXPECT_EQ(verdict.first_self.back(), std::pair(2, 3));
}

TEST(Judge, CountsTrianglesOfTheMeshAgainstTrianglesOfTheBody) {
  const TriangleMesh body = cube(Vec3(0, 0, 0), Vec3(1, 1, 1));
  const TriangleMesh piercing{{Vec3(0.3, 0.2, 0.5), Vec3(0.3, 0.2, 2), Vec3(0.35, 0.2, 2)},
                              {{0, 1, 2}}};
  const Verdict verdict = judge(piercing, body, {});
  EXPECT_EQ(verdict.body_intersections, 1u);
  ASSERT_EQ(verdict.first_body.size(), 1u);
  EXPECT_EQ(verdict.first_body[0].first, 0);
  EXPECT_EQ(verdict.first_body[0].second, 2);
  EXPECT_EQ(verdict.inside_vertices, 1u);
}

TEST(Judge, RefusesWhatIsNotFiniteAndIndicesOutOfRange) {
  TriangleMesh mesh{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, NAN, 0)}, {{0, 1, 2}}};
  EXPECT_THROW(judge(mesh, {}, {}), std::invalid_argument);
  mesh.vertices[2] = Vec3(0, 1, 0);
  EXPECT_NO_THROW(judge(mesh, {}, {}));
  mesh.triangles[0][1] = 3;
  EXPECT_THROW(judge(mesh, {}, {}), std::invalid_argument);
  mesh.triangles[0][1] = -1;
  EXPECT_THROW(judge(mesh, {}, {}), std::invalid_argument);
}

/// Random triangles of every awkward sort: few distinct coordinates, so that touching, coplanar and
/// degenerate cases are common; some moved by `step` units in the last place.
class RandomTriangles {
 public:
  explicit RandomTriangles(unsigned seed) : random_(seed) {}

  TrianglePoints next(int values, double scale, const Vec3& offset) {
    TrianglePoints t;
    for (Vec3& x : t)
      for (int k = 0; k < 3; ++k) x[k] = offset[k] + scale * pick(values);
    return t;
  }
  int pick(int values) { return static_cast<int>(random_() % static_cast<unsigned>(values)); }
  void nudge(TrianglePoints& t) {
    for (Vec3& x : t)
      for (int k = 0; k < 3; ++k)
        if (pick(6) == 0) x[k] = std::nextafter(x[k], pick(2) == 0 ? -INFINITY : INFINITY);
  }

 private:
  std::mt19937 random_;
};

struct RandomCase {
  double scale;
  Vec3 offset;
  bool nudged;
};

TEST(Judge, AgreesWithRationalClippingOnRandomTriangles) {
  const std::vector<RandomCase> cases{
      {1.0, Vec3::Zero(), false},           {1.0 / 3.0, Vec3(0.1, 0.2, 0.3), false},
      {1e-3, Vec3::Constant(1e6), true},    {1.0 / 3.0, Vec3(0.1, 0.2, 0.3), true},
      {1e-300, Vec3::Zero(), false},        {1e-308, Vec3::Zero(), true},
      {1e300, Vec3::Zero(), false},         {3e-9, Vec3::Constant(1.0), true},
      {1e307, Vec3::Constant(-1e308), true}};
  RandomTriangles random(20240607);
  std::size_t meeting = 0;
  for (const RandomCase& c : cases)
    for (int i = 0; i < 1500; ++i) {
      const int values = 2 + random.pick(5);
      TrianglePoints s = random.next(values, c.scale, c.offset);
      TrianglePoints t = random.next(values, c.scale, c.offset);
      if (c.nudged) random.nudge(s);
      const bool expected = meet_by_clipping(s, t);
      ASSERT_EQ(judging::triangles_meet(s, t), expected) << "scale " << c.scale << ", case " << i;
      ASSERT_EQ(judging::triangles_meet(t, s), expected) << "scale " << c.scale << ", case " << i;
      meeting += expected;
    }
  EXPECT_GT(meeting, 2000u);
  EXPECT_LT(meeting, 12000u);
}

TEST(Judge, AgreesWithRationalClippingOnTrianglesInATiltedPlane) {
  RandomTriangles random(7);
  for (int i = 0; i < 2000; ++i) {
    TrianglePoints s = random.next(8, 0.1, Vec3::Constant(0.7));
    TrianglePoints t = random.next(8, 0.1, Vec3::Constant(0.7));
    for (TrianglePoints* triangle : {&s, &t})
      for (Vec3& x : *triangle) x[2] = 0.3 * x[0] + 0.7 * x[1];
    ASSERT_EQ(judging::triangles_meet(s, t), meet_by_clipping(s, t)) << "case " << i;
  }
}

TEST(Judge, CountsTheSameAsEveryPairByClipping) {
  RandomTriangles random(99);
  TriangleMesh mesh, body;
  for (int i = 0; i < 150; ++i) {
    const Vec3 at(0.3 * random.pick(6), 0.3 * random.pick(6), 0.3 * random.pick(6));
    const TrianglePoints s = random.next(4, 0.1, at), t = random.next(4, 0.1, at);
    append(mesh, {{s[0], s[1], s[2]}, {{0, 1, 2}}});
    append(body, {{t[0], t[1], t[2]}, {{0, 1, 2}}});
  }
  std::size_t self = 0, with_body = 0;
  const auto corners = [](const TriangleMesh& m, std::size_t i) {
    return TrianglePoints{m.vertices[3 * i], m.vertices[3 * i + 1], m.vertices[3 * i + 2]};
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::size_t j = 0; j < mesh.triangles.size(); ++j) {
      self += i < j && meet_by_clipping(corners(mesh, i), corners(mesh, j));
      with_body += meet_by_clipping(corners(mesh, i), corners(body, j));
    }
  const Verdict verdict = judge(mesh, body, {});
  EXPECT_EQ(verdict.self_intersections + verdict.self_touches, self);
  EXPECT_EQ(verdict.body_intersections + verdict.body_touches, with_body);
  EXPECT_GT(self, 20u);
}

// ---- The predicates, where products leave the range of double or cancel

constexpr std::array awkward_units{1e-300, 1e-200, 1e-160, 1e-108, 1.0, 1e108, 1e160, 1e300};

/// Four points near a plane or a line, each axis in a unit of its own.
std::array<Vec3, 4> nearly_dependent_points(RandomTriangles& random) {
  std::array<Vec3, 4> x;
  for (Vec3& v : x) v = Vec3(random.pick(7) / 7.0, random.pick(5) / 3.0, random.pick(9) / 9.0);
  const double s = random.pick(11) / 10.0, t = random.pick(11) / 10.0;
  x[3] = x[0] + s * (x[1] - x[0]) + t * (x[2] - x[0]);
  if (random.pick(2) == 0) x[2] = x[0] + t * (x[1] - x[0]);
  const Vec3 unit_size(awkward_units[random.pick(awkward_units.size())],
                       awkward_units[random.pick(awkward_units.size())],
                       awkward_units[random.pick(awkward_units.size())]);
  for (Vec3& v : x) {
    v = v.cwiseProduct(unit_size);
    for (int k = 0; k < 3; ++k)
      if (random.pick(4) == 0) v[k] = std::nextafter(v[k], INFINITY);
  }
  return x;
}

TEST(Judge, DecidesOrientationsAsRationalDeterminantsDo) {
  RandomTriangles random(31);
  for (int i = 0; i < 20000; ++i) {
    const std::array<Vec3, 4> x = nearly_dependent_points(random);
    std::array<RationalPoint, 4> r;
    for (int k = 0; k < 4; ++k) r[k] = rational(x[k]);
    const mpq_class volume = dot(minus(r[0], r[3]), cross(minus(r[1], r[3]), minus(r[2], r[3])));
    ASSERT_EQ(judging::orient3d(x[0], x[1], x[2], x[3]), sgn(volume)) << "case " << i;
    const RationalPoint area = cross(minus(r[0], r[2]), minus(r[1], r[2]));
    for (int k = 0; k < 3; ++k)
      ASSERT_EQ(judging::orient2d(x[0], x[1], x[2], k), sgn(area[k])) << "case " << i;
  }
}

TEST(Judge, NeverTakesTouchingPointsForSeparated) {
  RandomTriangles random(32);
  std::size_t separated = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::array<Vec3, 4> x = nearly_dependent_points(random),
                              y = nearly_dependent_points(random);
    const Vec3 direction = (y[1] - y[0]).cross(x[1] - x[0]);
    if (!direction.allFinite() || !judging::separated_along(direction, {&x[0], 2}, {&x[2], 2}))
      continue;
    ++separated;
    for (int a = 0; a < 2; ++a)
      for (int b = 2; b < 4; ++b)
        ASSERT_EQ(sgn(dot(rational(direction), minus(rational(x[b]), rational(x[a])))), 1)
            << "case " << i;
  }
  EXPECT_GT(separated, 500u);
}

TEST(Judge, FindsAFlatAFoldedAndATiltedSheetFreeOfIntersections) {
  EXPECT_EQ(judge(sheet(30, [](double, double) { return 0.0; }), {}, {}).self_intersections, 0u);
  EXPECT_EQ(judge(sheet(30, [](double x, double y) { return 0.3 * x + 0.7 * y; }), {}, {})
                .self_intersections,
            0u);
  EXPECT_EQ(
      judge(sheet(30, [](double x, double y) { return std::sin(9 * x) * std::cos(7 * y); }), {}, {})
          .self_intersections,
      0u);
}

// ---- Inside and penetration

TEST(Judge, CountsOnlyVerticesStrictlyInsideACube) {
  const TriangleMesh body = cube(Vec3(0, 0, 0), Vec3(1, 1, 1));
  std::vector<Vec3> x;
  std::size_t inside = 0;
  for (int i = -1; i <= 5; ++i)
    for (int j = -1; j <= 5; ++j)
      for (int k = -1; k <= 5; ++k) {
        x.emplace_back(0.25 * i, 0.25 * j, 0.25 * k);
        inside += x.back().minCoeff() > 0.0 && x.back().maxCoeff() < 1.0;
      }
  const Verdict verdict = judge(points_only(x), body, {});
  EXPECT_EQ(verdict.inside_vertices, inside);
  EXPECT_EQ(inside, 27u);
  EXPECT_EQ(verdict.max_penetration_m, 0.5);
  EXPECT_EQ(verdict.closed_parts, 1u);
  EXPECT_EQ(verdict.open_parts, 0u);
  EXPECT_EQ(judge(points_only(x), flipped(body), {}).inside_vertices, inside);
}

TEST(Judge, IsNotFooledByRaysThroughVerticesAndEdgesOfASphere) {
  const TriangleMesh body = sphere(1.0, 4);
  std::vector<Vec3> inner, outer;
  for (const Vec3& x : body.vertices) {
    for (const double s : {0.25, 0.5, 0.75}) inner.push_back(s * x);
    inner.emplace_back(x[0] * 0.99, x[1] * 0.99, 0.0);
    outer.push_back(2.0 * x);
    outer.emplace_back(x[0], x[1], -1.5);
    outer.emplace_back(x[0], x[1], 1.5);
    outer.push_back(x);  // on the surface
  }
  EXPECT_EQ(judge(points_only(inner), body, {}).inside_vertices, inner.size());
  EXPECT_EQ(judge(points_only(outer), body, {}).inside_vertices, 0u);
}

TEST(Judge, MeasuresTheDepthBelowASphere) {
  const TriangleMesh body = sphere(0.5, 5);
  const Verdict verdict =
      judge(points_only({Vec3(0.1, 0, 0), Vec3(0, 0, 0.45), Vec3(2, 0, 0)}), body, {});
  EXPECT_EQ(verdict.inside_vertices, 2u);
  // A facet's circumcircle, of radius <= longest edge / √3 as no angle is obtuse, bounds its sag.
  double longest = 0.0;
  for (const auto& [a, b, c] : body.triangles)
    longest = std::max(longest, (body.vertices[a] - body.vertices[b]).norm());
  EXPECT_LE(verdict.max_penetration_m, 0.4);
  EXPECT_GE(verdict.max_penetration_m, std::sqrt(0.25 - longest * longest / 3.0) - 0.1);
}

TEST(Judge, SkipsOpenPartsAndKeepsClosedOnes) {
  TriangleMesh body = cube(Vec3(0, 0, 0), Vec3(1, 1, 1));
  body.triangles.pop_back();
  EXPECT_EQ(judge(points_only({Vec3(0.5, 0.5, 0.5)}), body, {}).inside_vertices, 0u);
  EXPECT_EQ(judge(points_only({Vec3(0.5, 0.5, 0.5)}), body, {}).open_parts, 1u);
  append(body, cube(Vec3(0.25, 0.25, 0.25), Vec3(0.75, 0.75, 0.75)));
  const Verdict verdict = judge(points_only({Vec3(0.5, 0.5, 0.5), Vec3(0.1, 0.1, 0.1)}), body, {});
  EXPECT_EQ(verdict.inside_vertices, 1u);
  EXPECT_EQ(verdict.max_penetration_m, 0.25);
  EXPECT_EQ(verdict.closed_parts, 1u);
}

TEST(Judge, TakesEqualPositionsAsOneInSearchesForClosedParts) {
  const TriangleMesh welded = cube(Vec3(0, 0, 0), Vec3(1, 1, 1));
  TriangleMesh soup;
  for (const auto& [a, b, c] : welded.triangles)
    append(soup, {{welded.vertices[a], welded.vertices[b], welded.vertices[c]}, {{0, 1, 2}}});
  soup.vertices[0] = -soup.vertices[0].cwiseAbs();  // -0 is where 0 is
  EXPECT_EQ(judge(points_only({Vec3(0.5, 0.5, 0.5)}), soup, {}).inside_vertices, 1u);
}

TEST(Judge, LeavesTheCavityOfAShellOutsideAndOverlappingPartsInside) {
  TriangleMesh shell = cube(Vec3(0, 0, 0), Vec3(1, 1, 1));
  append(shell, flipped(cube(Vec3(0.2, 0.2, 0.2), Vec3(0.8, 0.8, 0.8))));
  EXPECT_EQ(judge(points_only({Vec3(0.5, 0.5, 0.5)}), shell, {}).inside_vertices, 0u);
  EXPECT_EQ(judge(points_only({Vec3(0.1, 0.5, 0.5)}), shell, {}).inside_vertices, 1u);
  TriangleMesh both = cube(Vec3(0, 0, 0), Vec3(1, 1, 1));
  append(both, cube(Vec3(0.5, 0.5, 0.5), Vec3(2, 2, 2)));
  EXPECT_EQ(judge(points_only({Vec3(0.75, 0.75, 0.75)}), both, {}).inside_vertices, 1u);
}

TEST(Judge, FindsTheInsideOfAClosedPartWithMixedOrientation) {
  TriangleMesh body = cube(Vec3(0, 0, 0), Vec3(1, 1, 1));
  std::swap(body.triangles[2][0], body.triangles[2][1]);
  std::swap(body.triangles[3][0], body.triangles[3][1]);
  EXPECT_EQ(
      judge(points_only({Vec3(0.5, 0.5, 0.5), Vec3(0.25, 0.5, 0.5), Vec3(0.5, 0.5, -1)}), body, {})
          .inside_vertices,
      2u);
}

TEST(Judge, DecidesInsideAtTinyAndHugeSizes) {
  for (const double size : {1e-300, 1e-9, 1e9, 1e300}) {
    const TriangleMesh body = cube(Vec3::Zero(), Vec3::Constant(size));
    const std::vector<Vec3> x{Vec3(0.5, 0.5, 0.5) * size, Vec3(0.5, 0.5, 1.0) * size,
                              Vec3(1.0, 0.3, 0.4) * size, Vec3(0.5, 0.5, -0.5) * size};
    EXPECT_EQ(judge(points_only(x), body, {}).inside_vertices, 1u) << size;
  }
}

// ---- Strain

TEST(Judge, MeasuresStretchAndCompressionAgainstTheRestMesh) {
  const TriangleMesh rest{{unit[0], unit[1], unit[2]}, {{0, 1, 2}}};
  TriangleMesh mesh = rest;
  mesh.vertices[1] = Vec3(1.25, 0, 0);
  mesh.vertices[2] = Vec3(0, 0.5, 0);
  const Verdict verdict = judge(mesh, {}, rest);
  EXPECT_DOUBLE_EQ(verdict.max_stretch, 0.25);
  EXPECT_DOUBLE_EQ(verdict.max_compression, 0.5);
  EXPECT_EQ(judge(rest, {}, rest).max_stretch, 0.0);
  EXPECT_EQ(judge(mesh, {}, {}).max_stretch, 0.0);
}

TEST(Judge, RefusesARestMeshOfOtherTopologyOrWithoutLength) {
  const TriangleMesh mesh{{unit[0], unit[1], unit[2]}, {{0, 1, 2}}};
  TriangleMesh rest = mesh;
  rest.triangles[0] = {0, 2, 1};
  EXPECT_THROW(judge(mesh, {}, rest), std::invalid_argument);
  rest = mesh;
  rest.vertices.emplace_back(0, 0, 0);
  EXPECT_THROW(judge(mesh, {}, rest), std::invalid_argument);
  rest = mesh;
  rest.vertices[1] = rest.vertices[0];
  EXPECT_THROW(judge(mesh, {}, rest), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::judge_test
