// SPDX-License-Identifier: MIT
#include <selvedge/apps/detail/exact_predicates.h>
#include <selvedge/apps/judge.h>
#include <selvedge/apps/judge_ccd.h>

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>

namespace selvedge {
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

std::size_t self_intersections(const TrianglePoints& s, const TrianglePoints& t) {
  return judge(two_triangles(s, t), {}, {}).self_intersections;
}

const TrianglePoints unit{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};

TriangleMesh cube(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back(i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1],
                               i & 4 ? high[2] : low[2]);
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
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

// A square sheet of cells × cells pairs of triangles in the unit square, height as given.
template <class Height>
TriangleMesh sheet(int cells, const Height& height) {
  TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double x = static_cast<double>(i) / cells, y = static_cast<double>(j) / cells;
      mesh.vertices.emplace_back(x, y, height(x, y));
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const std::int32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

TriangleMesh points_only(std::vector<Vec3> x) { return {std::move(x), {}}; }

void append(TriangleMesh& all, const TriangleMesh& piece) {
  const auto first = static_cast<std::int32_t>(all.vertices.size());
  all.vertices.insert(all.vertices.end(), piece.vertices.begin(), piece.vertices.end());
  for (const auto& [a, b, c] : piece.triangles)
    all.triangles.push_back({a + first, b + first, c + first});
}

TriangleMesh flipped(TriangleMesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// ---- Intersections of two triangles

TEST(Judge, CountsTwoTrianglesThatPierceEachOther) {
  EXPECT_EQ(self_intersections(unit, {Vec3(0.2, 0.2, -1), Vec3(0.3, 0.2, 1), Vec3(0.2, 0.3, 1)}),
            1u);
  EXPECT_EQ(self_intersections(unit, {Vec3(0.2, 0.2, 1), Vec3(0.3, 0.2, 2), Vec3(0.2, 0.3, 2)}),
            0u);
}

TEST(Judge, CountsATouchingVertexOnFaceEdgeAndCorner) {
  const Vec3 up0(0.2, 0.2, 1), up1(0.3, 0.2, 1);
  EXPECT_EQ(self_intersections(unit, {Vec3(0.25, 0.25, 0), up0, up1}), 1u);
  EXPECT_EQ(self_intersections(unit, {Vec3(0.5, 0.5, 0), up0, up1}), 1u);
  EXPECT_EQ(self_intersections(unit, {Vec3(1, 0, 0), up0, up1}), 1u);
}

TEST(Judge, SeparatesATouchFromAGapOfOneUnitInTheLastPlace) {
  const double above = std::numeric_limits<double>::denorm_min();
  const Vec3 up0(0.2, 0.2, 1), up1(0.3, 0.2, 1);
  EXPECT_EQ(self_intersections(unit, {Vec3(0.25, 0.25, above), up0, up1}), 0u);
  const double beyond = std::nextafter(0.5, 1.0);
  EXPECT_EQ(self_intersections(unit, {Vec3(beyond, 0.5, 0), up0, up1}), 0u);
  EXPECT_EQ(self_intersections(unit, {Vec3(beyond, std::nextafter(0.5, 0.0), 0), up0, up1}), 0u)
      << "the step beyond the edge is twice the step back";
}

TEST(Judge, CountsOverlapWithinAPlaneAndATriangleInsideAnother) {
  EXPECT_EQ(self_intersections(unit, {Vec3(0.4, 0.4, 0), Vec3(2, 0, 0), Vec3(2, 2, 0)}), 1u);
  EXPECT_EQ(self_intersections(unit, {Vec3(0.1, 0.1, 0), Vec3(0.2, 0.1, 0), Vec3(0.1, 0.2, 0)}),
            1u);
  EXPECT_EQ(self_intersections({Vec3(0.1, 0.1, 0), Vec3(0.2, 0.1, 0), Vec3(0.1, 0.2, 0)}, unit),
            1u);
  EXPECT_EQ(self_intersections(unit, {Vec3(1, 1, 0), Vec3(1, 0.5, 0), Vec3(0.6, 1, 0)}), 0u);
}

TEST(Judge, TakesDegenerateTrianglesForThePointsAndSegmentsTheyAre) {
  const Vec3 p(0.25, 0.25, 0), q(0.25, 0.25, 1), r(0.25, 0.25, 0.5);
  EXPECT_EQ(self_intersections(unit, {p, p, p}), 1u);
  EXPECT_EQ(self_intersections(unit, {q, q, q}), 0u);
  EXPECT_EQ(self_intersections(unit, {r, p, q}), 1u);
  EXPECT_EQ(self_intersections(unit, {q, r, q}), 0u);
  EXPECT_EQ(
      self_intersections({p, q, r}, {Vec3(0, 0, 0.5), Vec3(0.5, 0.5, 0.5), Vec3(0.1, 0.1, 0.5)}),
      1u);
  EXPECT_EQ(self_intersections({p, p, p}, {p, p, p}), 1u);
  EXPECT_EQ(self_intersections({p, r, r}, {q, q, r}), 1u);
}

TEST(Judge, LeavesOutTrianglesThatShareAVertexAndCountsEqualPositionsOfOtherIndices) {
  const TriangleMesh shared{
      {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(-1, 0, 0)},
      {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(judge(shared, {}, {}).self_intersections, 0u);
  EXPECT_EQ(self_intersections(unit, {unit[0], Vec3(-1, 0, 0), Vec3(0, -1, 0)}), 1u);
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
  EXPECT_EQ(verdict.self_intersections, self);
  EXPECT_EQ(verdict.body_intersections, with_body);
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

TEST(Judge, TakesVerticesAtEqualPositionsAsOneWhenItLooksForClosedParts) {
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

TEST(Judge, RefusesARestMeshOfOtherTopologyOrWithAnEdgeOfLengthZero) {
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

// ---- Paths

bool touch_both_ways(PathKind kind, const std::array<Vec3, 8>& points) {
  const bool unfiltered = paths_touch_unfiltered(kind, points);
  EXPECT_EQ(paths_touch(kind, points), unfiltered);
  EXPECT_EQ(first_touch(kind, points).has_value(), unfiltered);
  return unfiltered;
}

// A point that falls from height `start` to `end` on the unit triangle.
std::optional<TouchTime> falling_point_time(double start, double end) {
  return first_touch(PathKind::point_triangle,
                     std::array<Vec3, 8>{Vec3(0.25, 0.25, start), unit[0], unit[1], unit[2],
                                         Vec3(0.25, 0.25, end), unit[0], unit[1], unit[2]});
}

// A point that falls from (x,y,1) to (x,y,end) on the unit triangle.
bool falling_point_touches(double x, double y, double end) {
  return touch_both_ways(PathKind::point_triangle, {Vec3(x, y, 1), unit[0], unit[1], unit[2],
                                                    Vec3(x, y, end), unit[0], unit[1], unit[2]});
}

TEST(JudgePath, FindsAPointThatPassesThroughATriangle) {
  EXPECT_TRUE(falling_point_touches(0.25, 0.25, -1.0));
  EXPECT_FALSE(falling_point_touches(0.75, 0.75, -1.0));
}

TEST(JudgePath, CountsATouchAtTheLastInstantAndNotOneJustMissed) {
  EXPECT_TRUE(falling_point_touches(0.25, 0.25, 0.0));
  EXPECT_FALSE(falling_point_touches(0.25, 0.25, std::numeric_limits<double>::denorm_min()));
}

TEST(JudgePath, CountsTouchesOnEdgesAndCorners) {
  EXPECT_TRUE(falling_point_touches(0.5, 0.5, -1.0));
  EXPECT_TRUE(falling_point_touches(0.0, 0.0, -1.0));
  EXPECT_FALSE(falling_point_touches(0.5, std::nextafter(0.5, 1.0), -1.0));
  EXPECT_FALSE(falling_point_touches(-1e-320, 0.0, -1.0));
}

TEST(JudgePath, DecidesMotionWithinOnePlane) {
  const auto slide = [](const Vec3& from, const Vec3& to) {
    return touch_both_ways(PathKind::point_triangle,
                           {from, unit[0], unit[1], unit[2], to, unit[0], unit[1], unit[2]});
  };
  EXPECT_TRUE(slide(Vec3(-1, 0.5, 0), Vec3(2, 0.5, 0)));
  EXPECT_TRUE(slide(Vec3(-1, 1, 0), Vec3(2, 1, 0))) << "through the corner alone";
  EXPECT_FALSE(slide(Vec3(-1, std::nextafter(1.0, 2.0), 0), Vec3(2, std::nextafter(1.0, 2.0), 0)));
  EXPECT_TRUE(slide(Vec3(0.1, 0.1, 0), Vec3(0.1, 0.1, 0)));
  EXPECT_FALSE(slide(Vec3(1, 1, 0), Vec3(2, 1, 0)));
}

TEST(JudgePath, FindsEdgesThatCrossAndEdgesThatSlideAlongOneLine) {
  const auto fall = [](const Vec3& a0, const Vec3& a1, const Vec3& step) {
    const Vec3 b0(0, 0, 0), b1(1, 0, 0);
    return touch_both_ways(PathKind::edge_edge, {a0, a1, b0, b1, a0 + step, a1 + step, b0, b1});
  };
  EXPECT_TRUE(fall(Vec3(0.5, -1, 1), Vec3(0.5, 1, 1), Vec3(0, 0, -2)));
  EXPECT_FALSE(fall(Vec3(1.5, -1, 1), Vec3(1.5, 1, 1), Vec3(0, 0, -2)));
  EXPECT_TRUE(fall(Vec3(1.5, 0, 0), Vec3(2.5, 0, 0), Vec3(-0.5, 0, 0)));
  EXPECT_FALSE(fall(Vec3(1.5, 0, 0), Vec3(2.5, 0, 0), Vec3(-0.25, 0, 0)));
  EXPECT_TRUE(fall(Vec3(0.5, 0, 1), Vec3(0.7, 0, 1), Vec3(0, 0, -3)))
      << "parallel, onto each other";
  EXPECT_TRUE(fall(Vec3(0.5, 0, 1), Vec3(0.5, 0, 1), Vec3(0, 0, -1))) << "an edge of length 0";
}

TEST(JudgePath, DecidesTheSameForReversedTimeOtherOrderAndOtherUnits) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::size_t touching = 0;
  for (int i = 0; i < 400; ++i) {
    std::array<Vec3, 8> points;
    for (Vec3& x : points) x = Vec3(uniform(random), uniform(random), uniform(random));
    for (const PathKind kind : {PathKind::point_triangle, PathKind::edge_edge}) {
      const bool touches = touch_both_ways(kind, points);
      touching += touches;
      // Reversed time, other corners first, and an exact change of unit decide the same.
      std::array<Vec3, 8> other = points;
      std::swap_ranges(other.begin(), other.begin() + 4, other.begin() + 4);
      EXPECT_EQ(touch_both_ways(kind, other), touches);
      other = points;
      std::swap(other[2], other[3]);
      std::swap(other[6], other[7]);
      EXPECT_EQ(touch_both_ways(kind, other), touches);
      for (const double unit_size : {0x1p-1000, 0x1p1000}) {
        other = points;
        for (Vec3& x : other) x *= unit_size;
        EXPECT_EQ(touch_both_ways(kind, other), touches);
      }
    }
  }
  EXPECT_GT(touching, 20u);
}

TEST(JudgePath, FindsAGrazeAtATimeThatIsNoBinaryFraction) {
  // The coplanarity polynomial is u², u = 3t - 1: at t = 1/3 the point is at (0, y, 0), where the
  // triangle's edge from the origin to (0, 1, 0) is.
  const auto grazes = [](double y) {
    return touch_both_ways(PathKind::point_triangle,
                           {Vec3(0, y, -1), Vec3(0, 0, 0), Vec3(-1, 0, 1), Vec3(0, 1, 0),
                            Vec3(0, y, 2), Vec3(0, 0, 0), Vec3(2, 0, 1), Vec3(0, 1, 0)});
  };
  EXPECT_TRUE(grazes(0.25));
  EXPECT_TRUE(grazes(1.0));
  EXPECT_FALSE(grazes(std::nextafter(1.0, 2.0)));
}

TEST(JudgePath, EnclosesTheTimeByEqualOrNeighbouringDoubles) {
  const double tiny = std::numeric_limits<double>::denorm_min();
  struct Case {
    double start, end, lo, hi;
  };
  for (const Case& c : std::vector<Case>{{0, -1, 0, 0},
                                         {1, 0, 1, 1},
                                         {1, -1, 0.5, 0.5},
                                         {1, -2, 1.0 / 3.0, std::nextafter(1.0 / 3.0, 1.0)},
                                         {1, -4, std::nextafter(0.2, 0.0), 0.2},
                                         {1, -0x1p-54, std::nextafter(1.0, 0.0), 1},
                                         {1, -0x1p-1000, std::nextafter(1.0, 0.0), 1},
                                         {tiny, -1, 0, tiny},
                                         {2 * tiny, -1, tiny, 2 * tiny},
                                         {0x1p-1000, -1e300, 0, tiny}}) {
    const auto time = falling_point_time(c.start, c.end);
    ASSERT_TRUE(time.has_value());
    EXPECT_EQ(time->lo, c.lo) << c.start << " to " << c.end;
    EXPECT_EQ(time->hi, c.hi) << c.start << " to " << c.end;
  }
  EXPECT_FALSE(falling_point_time(1, tiny).has_value());
  EXPECT_FALSE(falling_point_time(-tiny, -1).has_value());
}

// In the plane z = 0 the point (2 t, 1) is on the line through the origin and (x, y t) when
// x = 2 y t²: at t = 1/2 for (4, 8 t), at the square root of 1/2 for (8, 8 t).
TEST(JudgePath, EnclosesTimesOfMotionInAPlane) {
  const auto time = [](double x, double y) {
    return first_touch(
        PathKind::edge_edge,
        std::array<Vec3, 8>{Vec3(0, 1, 0), Vec3(0, 9, 0), Vec3(0, 0, 0), Vec3(x, 0, 0),
                            Vec3(2, 1, 0), Vec3(2, 9, 0), Vec3(0, 0, 0), Vec3(x, y, 0)});
  };
  const auto half = time(4, 8), root = time(8, 8);
  ASSERT_TRUE(half && root);
  EXPECT_EQ(half->lo, 0.5);
  EXPECT_EQ(half->hi, 0.5);
  EXPECT_EQ(root->hi, std::nextafter(root->lo, 1.0));
  EXPECT_LT(root->lo, std::sqrt(0.5) + 1e-15);
  EXPECT_GT(root->hi, std::sqrt(0.5) - 1e-15);
}

// All four vertices but one come together at t = 1; the cubic has a double root there and a simple
// one less than an ulp before, in contact.
TEST(JudgePath, TellsARootNextToADoubleOneAtTheEnd) {
  const std::array<Vec3, 8> points{Vec3(-7, -4, 26),
                                   Vec3(0x1.4000000000001p+4, -19, 20),
                                   Vec3(11, -4, 0x1.1800000000001p+5),
                                   Vec3(5, -28, 14),
                                   Vec3(-20, 12, 0x1.8000000000001p+2),
                                   Vec3(-20, 12, 6),
                                   Vec3(-20, 12, 6),
                                   Vec3(-20, 12, 6)};
  const auto time = first_touch(PathKind::edge_edge, points);
  ASSERT_TRUE(time.has_value());
  EXPECT_EQ(time->lo, std::nextafter(1.0, 0.0));
  EXPECT_EQ(time->hi, 1.0);
}

// Counts by every pair of primitives, without boxes and filters.
class EveryPair {
 public:
  EveryPair(const TriangleMesh& mesh, std::span<const Vec3> end) : mesh_(mesh), end_(end) {
    for (const Triangle& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) {
        points_[{t[k]}] = true;
        edges_[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}] = true;
      }
  }

  std::size_t point_triangle(const EveryPair& other) const {
    std::size_t count = 0;
    for (const auto& [point, used] : points_)
      for (const Triangle& t : other.mesh_.triangles)
        count += touch(PathKind::point_triangle, point, other, t);
    return count;
  }
  std::size_t edge_edge(const EveryPair& other) const {
    std::size_t count = 0;
    for (const auto& [a, used_a] : edges_)
      for (const auto& [b, used_b] : other.edges_)
        if (this != &other || a < b) count += touch(PathKind::edge_edge, a, other, b);
    return count;
  }

 private:
  template <class A, class B>
  bool touch(PathKind kind, const A& a, const EveryPair& other, const B& b) const {
    std::vector<Vec3> start, end;
    for (const std::int32_t v : a) {
      if (this == &other && std::find(b.begin(), b.end(), v) != b.end()) return false;
      start.push_back(mesh_.vertices[v]);
      end.push_back(end_[v]);
    }
    for (const std::int32_t v : b) {
      start.push_back(other.mesh_.vertices[v]);
      end.push_back(other.end_[v]);
    }
    start.insert(start.end(), end.begin(), end.end());
    return paths_touch_unfiltered(kind, std::span<const Vec3, 8>(start.data(), 8));
  }

  const TriangleMesh& mesh_;
  std::span<const Vec3> end_;
  std::map<std::array<std::int32_t, 1>, bool> points_;
  std::map<Edge, bool> edges_;
};

TEST(JudgePath, CountsTheSameAsEveryPairOfPrimitives) {
  std::mt19937 random(17);
  const auto number = [&random] { return static_cast<int>(random() % 9) / 4.0; };
  for (int round = 0; round < 6; ++round) {
    TriangleMesh mesh = sheet(3, [](double, double) { return 1.0; });
    TriangleMesh body = cube(Vec3(0.2, 0.2, 0.0), Vec3(1.1, 1.1, 0.5));
    std::vector<Vec3> mesh_end = mesh.vertices, body_end = body.vertices;
    for (Vec3& x : mesh_end) x += 0.5 * Vec3(number() - 1.0, number() - 1.0, -number());
    for (Vec3& x : body_end) x += 0.25 * Vec3(number() - 1.0, number() - 1.0, number());
    const EveryPair a(mesh, mesh_end), b(body, body_end);
    const PathVerdict verdict = judge_path(mesh, mesh_end, body, body_end);
    EXPECT_EQ(verdict.self_collisions, a.point_triangle(a) + a.edge_edge(a)) << round;
    EXPECT_EQ(verdict.body_collisions, a.point_triangle(b) + b.point_triangle(a) + a.edge_edge(b))
        << round;
    EXPECT_GT(verdict.self_collisions, 0u);
    EXPECT_GT(verdict.body_collisions, 0u);
  }
}

TEST(JudgePath, CountsASheetThatFallsThroughAPlateAndNotOneThatStopsAbove) {
  const TriangleMesh plate = cube(Vec3(0.2, 0.2, -0.005), Vec3(0.7, 0.7, 0.0));
  const TriangleMesh cloth = sheet(8, [](double, double) { return 0.5; });
  const auto moved = [&cloth](double step) {
    std::vector<Vec3> x = cloth.vertices;
    for (Vec3& v : x) v[2] += step;
    return x;
  };
  const PathVerdict through = judge_path(cloth, moved(-1.0), plate, plate.vertices);
  EXPECT_GT(through.body_collisions, 0u);
  EXPECT_EQ(through.self_collisions, 0u);
  EXPECT_GT(judge_path(cloth, moved(-0.5), plate, plate.vertices).body_collisions, 0u);
  const PathVerdict above = judge_path(cloth, moved(-0.499), plate, plate.vertices);
  EXPECT_EQ(above.body_collisions, 0u);
  EXPECT_GT(above.pairs, 0u);
  EXPECT_EQ(judge_path(cloth, moved(-1.0), {}, {}).body_collisions, 0u);
}

TEST(JudgePath, CountsTheCollisionsOfTwoLayersThatSwap) {
  TriangleMesh mesh;
  append(mesh, {{Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)}, {{0, 1, 2}}});
  append(mesh, {{Vec3(0.5, 0.5, 1), Vec3(1, 0.5, 1), Vec3(0.5, 1, 1)}, {{0, 1, 2}}});
  std::vector<Vec3> end = mesh.vertices;
  for (int i = 3; i < 6; ++i) end[i][2] = -1;
  // Three points of the small one meet the large one; no edges cross.
  EXPECT_EQ(judge_path(mesh, end, {}, {}).self_collisions, 3u);
}

TEST(JudgePath, RefusesStatesOfDifferentSize) {
  const TriangleMesh mesh{{unit[0], unit[1], unit[2]}, {{0, 1, 2}}};
  EXPECT_THROW(judge_path(mesh, std::vector<Vec3>(2, Vec3::Zero()), {}, {}), std::invalid_argument);
  EXPECT_THROW(judge_path(mesh, mesh.vertices, mesh, {}), std::invalid_argument);
  EXPECT_THROW(judge_path(mesh, std::vector<Vec3>(3, Vec3(0, INFINITY, 0)), {}, {}),
               std::invalid_argument);
}

// ---- The query collection with ground truth

std::filesystem::path shared_directory() {
  const char* given = std::getenv("SELVEDGE_SHARED");
  return given != nullptr ? std::filesystem::path(given)
                          : std::filesystem::path(SELVEDGE_SOURCE_DIR) / ".." / "shared";
}

struct Query {
  std::array<Vec3, 8> points;
  bool truth;
  std::optional<TouchTime> time{};
};

// Beside X.csv lies X.toi.csv: index,truth,toi_lo,toi_hi, the times empty without a contact.
void read_times(std::filesystem::path file, std::vector<Query>& queries) {
  std::ifstream in(file.replace_extension(".toi.csv"));
  for (std::string line; std::getline(in, line);) {
    std::stringstream fields(line);
    std::array<std::string, 4> field;
    for (std::string& f : field) std::getline(fields, f, ',');
    if (field[2].empty() || field[0] == "index") continue;
    queries.at(std::stoul(field[0])).time = {std::stod(field[2]), std::stod(field[3])};
  }
}

// x_num,x_den,y_num,y_den,z_num,z_den,truth; both parts are doubles, denominators powers of two.
std::vector<Query> read_queries(const std::filesystem::path& file) {
  std::vector<Query> queries;
  std::ifstream in(file);
  std::size_t row = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (row % 8 == 0) queries.emplace_back();
    std::array<double, 7> value{};
    std::stringstream fields(line);
    std::string field;
    for (double& v : value)
      if (std::getline(fields, field, ',')) v = std::strtod(field.c_str(), nullptr);
    queries.back().points[row++ % 8] =
        Vec3(value[0] / value[1], value[2] / value[3], value[4] / value[5]);
    queries.back().truth = value[6] != 0.0;
  }
  read_times(file, queries);
  return queries;
}

TEST(JudgePath, DecidesEveryQueryOfTheCollectionAsItsTruthSaysAndEnclosesItsTime) {
  const std::filesystem::path directory = shared_directory() / "data" / "ccd";
  if (!std::filesystem::is_directory(directory))
    GTEST_SKIP() << "the query collection is not at " << directory << "; set SELVEDGE_SHARED";
  std::size_t queries = 0, positives = 0, wrong = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory)) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() != ".csv" || file.stem().extension() == ".toi") continue;
    const PathKind kind = file.string().find("edge-edge") != std::string::npos
                              ? PathKind::edge_edge
                              : PathKind::point_triangle;
    for (const Query& query : read_queries(file)) {
      ++queries;
      positives += query.truth;
      const bool right = paths_touch(kind, query.points) == query.truth &&
                         paths_touch_unfiltered(kind, query.points) == query.truth;
      const auto time = first_touch(kind, query.points);
      const bool same_time = time.has_value() == query.time.has_value() &&
                             (!time || (time->lo == query.time->lo && time->hi == query.time->hi));
      wrong += !right || !same_time;
      EXPECT_TRUE(right && same_time) << file << ", query " << queries;
    }
  }
  EXPECT_EQ(queries, 9702u);
  EXPECT_EQ(positives, 1652u);
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace selvedge
