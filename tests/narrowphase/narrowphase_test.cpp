// SPDX-License-Identifier: MIT
#include "ccd_queries.h"

#include <gtest/gtest.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/cubic.h>
#include <selvedge/narrowphase/detail/pair_screen.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>
#include "owned_surface.h"

namespace selvedge::narrowphase_test {
namespace {

using Surface = OwnedSurface;

constexpr double kInf = std::numeric_limits<double>::infinity();

using ccd_queries::falling_point, ccd_queries::integer, ccd_queries::real, ccd_queries::uniform;
using ccd_queries::grid, ccd_queries::hex_text, ccd_queries::Random;

// ---------------------------------------------------------------------------------------------
// The cubic alone

/// Coefficients of scale * (t - a) (t - b) (t - c), exact for small dyadic roots.
std::array<double, 4> with_roots(double a, double b, double c, double scale) {
  return {-scale * a * b * c, scale * (a * b + b * c + c * a), -scale * (a + b + c), scale};
}

TEST(Cubic, SimpleDoubleAndTripleRootsAreCountedAndExact) {
  Random r(31);
  for (int i = 0; i < 2000; ++i) {
    std::array<double, 3> x;
    for (double& v : x) v = integer(r, -8, 24) / 16.0;
    std::sort(x.begin(), x.end());
    const CubicRoots found =
        cubic_roots(with_roots(x[0], x[1], x[2], std::ldexp(3.0, integer(r, -900, 900))));
    std::vector<CubicRoot> expected;
    for (const double v : x) {
      if (v < 0.0 || v > 1.0) continue;
      if (!expected.empty() && expected.back().lo == v) {
        ++expected.back().multiplicity;
      } else {
        expected.push_back({v, v, 1});
      }
    }
    ASSERT_EQ(found.roots.size(), expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) {
      EXPECT_EQ(found.roots[k].lo, expected[k].lo);
      EXPECT_EQ(found.roots[k].hi, expected[k].hi);
      EXPECT_EQ(found.roots[k].multiplicity, expected[k].multiplicity);
    }
  }
}

TEST(Cubic, IrrationalRootsAreEnclosedByNeighbouringDoubles) {
  const CubicRoots r = cubic_roots({-1.0, 0.0, 2.0, 0.0});
  ASSERT_EQ(r.roots.size(), 1u);
  EXPECT_EQ(r.roots[0].hi, std::nextafter(r.roots[0].lo, 2.0));
  EXPECT_LT(r.roots[0].lo * r.roots[0].lo, 0.5);
  EXPECT_GE(r.roots[0].hi * r.roots[0].hi, 0.5);
}

TEST(Cubic, RootsAnUlpApartAndNearMissesAreToldApart) {
  // (t - 1/2)^2 = e has two roots for e > 0, one for e = 0 and none for e < 0.
  const double e = 0x1p-54;
  EXPECT_EQ(cubic_roots({0.25 - e, -1.0, 1.0, 0.0}).roots.size(), 2u);
  ASSERT_EQ(cubic_roots({0.25, -1.0, 1.0, 0.0}).roots.size(), 1u);
  EXPECT_EQ(cubic_roots({0.25, -1.0, 1.0, 0.0}).roots[0].multiplicity, 2);
  EXPECT_EQ(cubic_roots({0.25 + 2 * e, -1.0, 1.0, 0.0}).roots.size(), 0u);
}

TEST(Cubic, ZeroIsSaidToBeZeroAndConstantsHaveNoRoots) {
  EXPECT_TRUE(cubic_roots({0.0, 0.0, 0.0, 0.0}).identically_zero);
  EXPECT_TRUE(cubic_roots({1e-320, 0.0, 0.0, 0.0}).roots.empty());
  EXPECT_THROW(cubic_roots({1.0, kInf, 0.0, 0.0}), std::invalid_argument);
}

TEST(Cubic, CoplanarityOfAFallingPointIsFoundWhereItFalls) {
  const CubicRoots r = coplanarity_roots(falling_point(3.0, -1.0));
  ASSERT_EQ(r.roots.size(), 1u);
  EXPECT_EQ(r.roots[0].lo, 0.75);
  EXPECT_EQ(r.roots[0].hi, 0.75);
  EXPECT_TRUE(coplanarity_roots(falling_point(0.0, 0.0)).identically_zero);
}

// ---------------------------------------------------------------------------------------------
// Batches

/// Random triangles with their edges.
Surface soup(Random& r, int triangles, double size, double motion) {
  Surface s;
  for (std::int32_t t = 0; t < triangles; ++t) {
    const Vec3 centre(real(r, -1, 1), real(r, -1, 1), real(r, -1, 1));
    const Vec3 move(real(r, -motion, motion), real(r, -motion, motion), real(r, -motion, motion));
    for (int k = 0; k < 3; ++k) {
      const Vec3 v(real(r, -size, size), real(r, -size, size), real(r, -size, size));
      s.x_t0.push_back(centre + v);
      s.x_t1.push_back(centre + v + move);
    }
    s.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    for (int k = 0; k < 3; ++k) s.edges.push_back({3 * t + k, 3 * t + (k + 1) % 3});
  }
  return s;
}

CandidatePairs all_pairs(const Surface& a, const Surface& b) {
  CandidatePairs pairs;
  const auto count = [](const auto& v) { return static_cast<std::int32_t>(v.size()); };
  for (std::int32_t p = 0; p < count(a.x_t0); ++p)
    for (std::int32_t t = 0; t < count(b.triangles); ++t) pairs.point_triangle.push_back({p, t});
  for (std::int32_t p = 0; p < count(b.x_t0); ++p)
    for (std::int32_t t = 0; t < count(a.triangles); ++t) pairs.triangle_point.push_back({p, t});
  for (std::int32_t e = 0; e < count(a.edges); ++e)
    for (std::int32_t f = 0; f < count(b.edges); ++f) pairs.edge_edge.push_back({e, f});
  return pairs;
}

Query query_of(const Surface& a, const Surface& b, const Contact& c) {
  const int firsts = c.kind == ContactKind::edge_edge ? 2 : 1;
  const bool swapped = c.kind == ContactKind::triangle_point;
  Query q;
  q.kind = c.kind == ContactKind::edge_edge ? c.kind : ContactKind::point_triangle;
  for (int k = 0; k < 4; ++k) {
    const Surface& s = (k < firsts) != swapped ? a : b;
    q.x_t0[k] = s.x_t0[c.vertex[k]], q.x_t1[k] = s.x_t1[c.vertex[k]];
  }
  return q;
}

Vec3 between(const Contact& c, const std::array<Vec3, 4>& x) {
  return c.weight[0] * x[0] + c.weight[1] * x[1] + c.weight[2] * x[2] + c.weight[3] * x[3];
}

std::array<Vec3, 4> at(const Query& q, double t) {
  std::array<Vec3, 4> x;
  for (int k = 0; k < 4; ++k) x[k] = q.x_t0[k] + t * (q.x_t1[k] - q.x_t0[k]);
  return x;
}

/// Contacts that single queries find, in the order of the lists.
std::vector<std::array<std::int32_t, 4>> one_by_one(const Surface& a, const Surface& b,
                                                    const CandidatePairs& pairs) {
  std::vector<std::array<std::int32_t, 4>> out;
  Contact c;
  const auto add = [&] {
    double toi = 0.0;
    if (make_ccd_exact()->collides(query_of(a, b, c), toi)) out.push_back(c.vertex);
  };
  c.kind = ContactKind::point_triangle;
  for (const auto& p : pairs.point_triangle) {
    const Triangle& t = b.triangles[p.triangle];
    c.vertex = {p.point, t[0], t[1], t[2]};
    add();
  }
  c.kind = ContactKind::triangle_point;
  for (const auto& p : pairs.triangle_point) {
    const Triangle& t = a.triangles[p.triangle];
    c.vertex = {p.point, t[0], t[1], t[2]};
    add();
  }
  c.kind = ContactKind::edge_edge;
  for (const auto& p : pairs.edge_edge) {
    const Edge& e = a.edges[p.edge_a];
    const Edge& f = b.edges[p.edge_b];
    c.vertex = {e[0], e[1], f[0], f[1]};
    add();
  }
  return out;
}

TEST(FindContacts, FindsWhatSingleQueriesFindInPairOrder) {
  Random r(11);
  const Surface a = soup(r, 23, 0.4, 1.0), b = soup(r, 29, 0.4, 1.0);
  const CandidatePairs pairs = all_pairs(a, b);
  std::vector<Contact> contacts(3);
  make_ccd_exact()->find_contacts(a.view(), b.view(), pairs, contacts);
  const auto expected = one_by_one(a, b, pairs);
  ASSERT_GT(expected.size(), 50u);
  ASSERT_EQ(contacts.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(contacts[i].vertex, expected[i]);
}

TEST(FindContacts, GivesTheSameBitsForAnyNumberOfThreads) {
  Random r(12);
  const Surface a = soup(r, 60, 0.4, 1.0), b = soup(r, 60, 0.4, 1.0);
  const CandidatePairs pairs = all_pairs(a, b);
  std::vector<Contact> one, many;
  {
    const ThreadLimit limit(1);
    make_ccd_exact()->find_contacts(a.view(), b.view(), pairs, one);
  }
  make_ccd_exact()->find_contacts(a.view(), b.view(), pairs, many);
  ASSERT_EQ(one.size(), many.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].vertex, many[i].vertex);
    EXPECT_EQ(one[i].toi, many[i].toi);
    EXPECT_EQ(one[i].weight, many[i].weight);
    EXPECT_EQ(one[i].normal, many[i].normal);
  }
}

/// A point in a triangle of the plane x + y = c, at rest. All coordinates and sums are exact, but
/// floats round the four points to different sides of the plane.
TEST(FindContacts, WhatFloatsTellApartByRoundingAloneTouches) {
  Random r(13);
  for (int i = 0; i < 4000; ++i) {
    const auto grid = [](double x) { return std::ldexp(std::round(std::ldexp(x, 48)), -48); };
    const double c = grid(real(r, 2.02, 2.021));
    const auto place = [&](double x, double z) { return Vec3(grid(x), c - grid(x), z); };
    Surface a, b;
    a.x_t0 = {place(real(r, 1.009, 1.011), 0.0)};
    b.x_t0 = {place(1.001, real(r, -0.4, -0.3)), place(1.019, real(r, -0.4, -0.3)),
              place(real(r, 1.005, 1.015), 0.4)};
    b.x_t1 = b.x_t0;
    // The ends are apart, so that the order at the start decides.
    a.x_t1 = {a.x_t0[0] + (i % 2 == 0 ? 1e-3 : -1e-3) * Vec3(1, 1, 0)};
    b.triangles = {{0, 1, 2}};
    CandidatePairs pairs;
    pairs.point_triangle = {{0, 0}};
    std::vector<Contact> contacts;
    make_ccd_exact()->find_contacts(a.view(), b.view(), pairs, contacts);
    ASSERT_EQ(contacts.size(), one_by_one(a, b, pairs).size()) << i;
    ASSERT_EQ(contacts.size(), 1u) << i;
  }
}

TEST(FindContacts, DescribesWhereThePrimitivesMeet) {
  Random r(13);
  const Surface a = soup(r, 30, 0.4, 1.0), b = soup(r, 30, 0.4, 1.0);
  std::vector<Contact> contacts;
  make_ccd_exact()->find_contacts(a.view(), b.view(), all_pairs(a, b), contacts);
  ASSERT_GT(contacts.size(), 50u);
  for (const Contact& c : contacts) {
    const Query q = query_of(a, b, c);
    const auto& w = c.weight;
    EXPECT_NEAR(w[0] + w[1] + w[2] + w[3], 0.0, 1e-15);
    const int firsts = c.kind == ContactKind::edge_edge ? 2 : 1;
    for (int k = 0; k < 4; ++k) EXPECT_GE(k < firsts ? w[k] : -w[k], 0.0);
    EXPECT_NEAR(c.normal.norm(), 1.0, 1e-14);
    // Near-tangential paths turn an ulp of time into more of a distance.
    EXPECT_LT(between(c, at(q, c.toi)).norm(), 1e-12);
    EXPECT_GT(between(c, q.x_t0).dot(c.normal), 0.0);
    EXPECT_GT(c.gap, 0.0);
    EXPECT_LE(c.gap, between(c, q.x_t0).norm() + 1e-15);
  }
}

Contact only_contact(const Query& q) {
  const bool edges = q.kind == ContactKind::edge_edge;
  Surface a, b;
  for (int k = 0; k < 4; ++k) {
    Surface& s = k < (edges ? 2 : 1) ? a : b;
    s.x_t0.push_back(q.x_t0[k]), s.x_t1.push_back(q.x_t1[k]);
  }
  CandidatePairs pairs;
  if (edges) {
    a.edges = b.edges = {{0, 1}};
    pairs.edge_edge = {{0, 0}};
  } else {
    b.triangles = {{0, 1, 2}};
    pairs.point_triangle = {{0, 0}};
  }
  std::vector<Contact> contacts;
  make_ccd_exact()->find_contacts(a.view(), b.view(), pairs, contacts);
  EXPECT_EQ(contacts.size(), 1u) << hex_text(q);
  return contacts.empty() ? Contact{} : contacts[0];
}

TEST(FindContacts, ParallelEdgesGetTheDirectionOfApproach) {
  Query q;
  q.kind = ContactKind::edge_edge;
  q.x_t0 = {Vec3(0, 0, 1), Vec3(4, 0, 1), Vec3(1, 0, 0), Vec3(6, 0, 0)};
  q.x_t1 = q.x_t0;
  q.x_t1[0].z() = q.x_t1[1].z() = -1;
  const Contact c = only_contact(q);
  EXPECT_EQ(c.toi, 0.5);
  EXPECT_NEAR((c.normal - Vec3(0, 0, 1)).norm(), 0.0, 1e-15);
  EXPECT_NEAR(c.gap, 1.0, 1e-15);
}

TEST(FindContacts, AnInPlaneHitGetsANormalInThePlane) {
  Query q = falling_point(0.0, 0.0);
  q.x_t0[0] = Vec3(0.25, -1.0, 0.0);
  const Contact c = only_contact(q);
  EXPECT_NEAR((c.normal - Vec3(0, -1, 0)).norm(), 0.0, 1e-15);
  EXPECT_NEAR(c.gap, 1.0, 1e-15);
}

TEST(FindContacts, AContactFromTheStartHasANormalAgainstTheMotion) {
  const Contact c = only_contact(falling_point(0.0, -1.0));
  EXPECT_EQ(c.toi, 0.0);
  EXPECT_EQ(c.gap, 0.0);
  EXPECT_NEAR((c.normal - Vec3(0, 0, 1)).norm(), 0.0, 1e-15);
}

TEST(FindContacts, CoincidentPointsStillHaveAUnitNormal) {
  Query q;
  for (const ContactKind kind : {ContactKind::point_triangle, ContactKind::edge_edge}) {
    q.kind = kind;
    for (int k = 0; k < 4; ++k) q.x_t0[k] = q.x_t1[k] = Vec3(1, 2, 3);
    EXPECT_NEAR(only_contact(q).normal.norm(), 1.0, 1e-15);
  }
}

TEST(FindContacts, HugeAndTinyScenesHaveFiniteContacts) {
  for (const double scale : {1e-300, 1e-150, 1e150, 1e300}) {
    Query q = falling_point(1.0, -1.0);
    for (auto* x : {&q.x_t0, &q.x_t1})
      for (Vec3& v : *x) v *= scale;
    const Contact c = only_contact(q);
    EXPECT_EQ(c.toi, 0.5);
    EXPECT_NEAR((c.normal - Vec3(0, 0, 1)).norm(), 0.0, 1e-15);
    EXPECT_NEAR(c.gap / scale, 1.0, 1e-12);
    EXPECT_NEAR(c.weight[2], -0.25, 1e-12);
  }
}

TEST(FindContacts, ASurfaceThatIsNotFiniteIsRefusedWithTheVertex) {
  Random r(14);
  Surface a = soup(r, 3, 0.4, 1.0);
  a.x_t1[7].z() = kInf;
  std::vector<Contact> contacts;
  try {
    make_ccd_exact()->find_contacts(a.view(), a.view(), {}, contacts);
    FAIL() << "accepted an infinite coordinate";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("vertex 7"), std::string::npos) << error.what();
  }
}

TEST(Registry, NamesTheExactMethod) {
  const auto registry = narrow_phases();
  ASSERT_TRUE(registry.contains("ccd_exact"));
  EXPECT_TRUE(registry.at("ccd_exact")({})->traits().misses_nothing);
  EXPECT_TRUE(registry.at("ccd_exact")({})->traits().no_false_alarm);
}

// ---------------------------------------------------------------------------------------------
// Distances

double segment_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  double best = kInf;
  for (int i = 0; i <= 2000; ++i) best = std::min(best, (p - a - (b - a) * (i / 2000.0)).norm());
  return best;
}

/// Distance by sampling: above the true one by at most `step` times the longest edge.
double sampled_distance(ContactKind kind, const std::array<Vec3, 4>& x, int n) {
  double best = kInf;
  for (int i = 0; i <= n; ++i) {
    const double s = static_cast<double>(i) / n;
    for (int j = 0; j <= n; ++j) {
      const double t = static_cast<double>(j) / n;
      if (kind == ContactKind::edge_edge) {
        best = std::min(best, (x[0] + s * (x[1] - x[0]) - x[2] - t * (x[3] - x[2])).norm());
      } else if (s + t <= 1.0) {
        best = std::min(best, (x[0] - x[1] - s * (x[2] - x[1]) - t * (x[3] - x[1])).norm());
      }
    }
  }
  return best;
}

ClosestPoints closest(ContactKind kind, const std::array<Vec3, 4>& x) {
  return kind == ContactKind::edge_edge ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                        : point_triangle_closest(x[0], x[1], x[2], x[3]);
}

TEST(Distance, IsThatOfSamplingAtAnyScaleAndPlace) {
  Random r(21);
  constexpr int kSamples = 60;
  for (int i = 0; i < 400; ++i) {
    const ContactKind kind = i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge;
    const Query q = i % 4 < 2
                        ? uniform(r, kind, 1.0)
                        : ccd_queries::families()[i % ccd_queries::kIntegerFamilies].make(r, kind);
    const double size = 1.0 + closest(kind, q.x_t0).distance + (q.x_t0[1] - q.x_t0[0]).norm() +
                        (q.x_t0[3] - q.x_t0[2]).norm() + (q.x_t0[2] - q.x_t0[1]).norm();
    const double sampled = sampled_distance(kind, q.x_t0, kSamples);
    for (const double scale : {1e-6, 1.0, 1e6}) {
      for (const double offset : {0.0, 1e6}) {
        std::array<Vec3, 4> x = q.x_t0;
        for (Vec3& v : x) v = v * scale + Vec3(offset, -offset, offset);
        const ClosestPoints c = closest(kind, x);
        // Coordinates at the offset are rounded, to 2^-34 there.
        const double rounding = 8 * size * scale * 1e-16 + (offset + size * scale) * 4e-16;
        EXPECT_LE(c.distance, sampled * scale + 4 * rounding) << hex_text(q);
        EXPECT_GE(c.distance, (sampled - 3.0 * size / kSamples) * scale - 4 * rounding)
            << hex_text(q);
        EXPECT_NEAR((c.separation).norm(), c.distance, 1e-12 * (c.distance + rounding));
        double sum = 0.0;
        for (int k = 0; k < 4; ++k) {
          sum += c.weight[k];
          const bool first = k < (kind == ContactKind::edge_edge ? 2 : 1);
          EXPECT_GE(first ? c.weight[k] : -c.weight[k], 0.0);
        }
        EXPECT_NEAR(sum, 0.0, 1e-15);
      }
    }
  }
}

TEST(Distance, SeparationIsPerpendicularWhereTheClosestPointsAreInside) {
  Random r(22);
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    const ContactKind kind = i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge;
    const std::array<Vec3, 4> x = uniform(r, kind, 1.0).x_t0;
    const ClosestPoints c = closest(kind, x);
    const auto& w = c.weight;
    if (w[1] == 0.0 || w[2] == 0.0 || w[3] == 0.0 || w[0] == 0.0) continue;
    ++inside;
    const Vec3 u = kind == ContactKind::edge_edge ? x[1] - x[0] : x[2] - x[1];
    const Vec3 v = kind == ContactKind::edge_edge ? x[3] - x[2] : x[3] - x[1];
    const double thin = u.cross(v).norm() / (u.norm() * v.norm());
    EXPECT_NEAR(c.separation.dot(u), 0.0, 1e-14 / thin);
    EXPECT_NEAR(c.separation.dot(v), 0.0, 1e-14 / thin);
  }
  EXPECT_GT(inside, 100);
}

TEST(Distance, OfParallelEdgesMeetsInTheMiddleOfTheOverlap) {
  const ClosestPoints c =
      edge_edge_closest(Vec3(0, 0, 1), Vec3(4, 0, 1), Vec3(6, 0, 0), Vec3(2, 0, 0));
  EXPECT_EQ(c.distance, 1.0);
  EXPECT_EQ(c.weight, (std::array<double, 4>{0.25, 0.75, -0.25, -0.75}));
}

TEST(Distance, OfDegenerateTrianglesIsThatOfTheirEdges) {
  Random r(23);
  for (int i = 0; i < 100; ++i) {
    std::array<Vec3, 4> x = grid(r, ContactKind::point_triangle, 3).x_t0;
    x[3] = i % 3 == 0 ? x[1] : (i % 3 == 1 ? x[2] : Vec3(2.0 * x[2] - x[1]));
    const double expected =
        std::min(segment_distance(x[0], x[1], x[2]), segment_distance(x[0], x[2], x[3]));
    const double d = point_triangle_closest(x[0], x[1], x[2], x[3]).distance;
    EXPECT_LE(d, expected + 1e-12);
    EXPECT_GE(d, expected - 0.01);
  }
}

TEST(FindProximities, FindsExactlyThePairsThatAreOrComeNear) {
  Random r(24);
  const Surface a = soup(r, 25, 0.3, 0.3), b = soup(r, 25, 0.3, 0.3);
  const CandidatePairs pairs = all_pairs(a, b);
  constexpr double kReach = 0.1;
  std::vector<Contact> contacts;
  find_proximities(a.view(), b.view(), pairs, {.reach = kReach}, contacts);
  std::size_t next = 0;
  const auto expect = [&](ContactKind kind, const std::array<std::int32_t, 4>& vertex) {
    Contact c;
    c.kind = kind, c.vertex = vertex;
    const Query q = query_of(a, b, c);
    const ClosestPoints near = closest(q.kind, q.x_t0);
    c.weight = near.weight;
    const Vec3 n = near.separation / near.distance;
    const double approach = -n.dot(between(c, q.x_t1) - between(c, q.x_t0));
    if (near.distance - std::max(0.0, approach) >= kReach) return;
    ASSERT_LT(next, contacts.size());
    const Contact& found = contacts[next++];
    EXPECT_EQ(found.kind, kind);
    EXPECT_EQ(found.vertex, vertex);
    EXPECT_EQ(found.toi, 0.0);
    EXPECT_NEAR(found.gap, near.distance, 1e-14);
    EXPECT_NEAR((found.normal - n).norm(), 0.0, 1e-9);
    EXPECT_NEAR(between(found, q.x_t0).dot(found.normal), found.gap, 1e-12);
  };
  for (const auto& p : pairs.point_triangle) {
    const Triangle& t = b.triangles[p.triangle];
    expect(ContactKind::point_triangle, {p.point, t[0], t[1], t[2]});
  }
  for (const auto& p : pairs.triangle_point) {
    const Triangle& t = a.triangles[p.triangle];
    expect(ContactKind::triangle_point, {p.point, t[0], t[1], t[2]});
  }
  for (const auto& p : pairs.edge_edge) {
    const Edge& e = a.edges[p.edge_a];
    const Edge& f = b.edges[p.edge_b];
    expect(ContactKind::edge_edge, {e[0], e[1], f[0], f[1]});
  }
  EXPECT_EQ(next, contacts.size());
  EXPECT_GT(next, 100u);
}

/// A point above a triangle, and two crossing edges: `above` at the start and `below` that at the
/// end. Gives the number of pairs found.
std::size_t near_at(const Vec3& place, double above, double below, double reach, double secondary) {
  Surface a, b;
  a.x_t0 = {place, place - Vec3(0.1, 0, 0), place + Vec3(0.2, 0, 0)};
  for (const Vec3& x : a.x_t0) a.x_t1.push_back(x - Vec3(0, 0, below));
  a.edges = {{1, 2}};
  const Vec3 low = place - Vec3(0, 0, above);
  b.x_t0 = {low - Vec3(0.1, 0.1, 0), low + Vec3(0.3, -0.1, 0), low + Vec3(0, 0.4, 0),
            low + Vec3(0, 0.2, 0), low - Vec3(0, 0.1, 0)};
  b.x_t1 = b.x_t0;
  b.triangles = {{0, 1, 2}};
  b.edges = {{3, 4}};
  CandidatePairs pairs;
  pairs.point_triangle = {{0, 0}};
  pairs.edge_edge = {{0, 0}};
  std::vector<Contact> contacts;
  find_proximities(a.view(), b.view(), pairs, {.reach = reach, .secondary_at_start = secondary},
                   contacts);
  return contacts.size();
}

TEST(FindProximities, FloatsLoseNoPairAtTheEdgeOfItsReach) {
  Random r(25);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 place(real(r, 1, 2), real(r, 1, 2), real(r, 1, 2));
    const double reach = real(r, 1e-3, 2e-3), move = real(r, 5e-3, 6e-3), inside = 1e-12;
    EXPECT_EQ(near_at(place, reach - inside, 0.0, reach, reach), 2u) << i;
    EXPECT_EQ(near_at(place, reach + inside, 0.0, reach, reach), 0u) << i;
    EXPECT_EQ(near_at(place, reach + move - inside, move, reach, reach), 1u)
        << i << ": the point comes near, but edges count at the start only";
    EXPECT_EQ(near_at(place, reach + move - inside, move, reach, kInf), 2u) << i;
    EXPECT_EQ(near_at(place, reach + move + inside, move, reach, kInf), 0u) << i;
  }
}

TEST(FindProximities, TinyAndHugePairsAreNear) {
  for (const double scale : {1e-300, 1e-160, 1e-100, 1e-80, 1e-20, 1e20, 1e100}) {
    Surface a, b;
    a.x_t0 = {Vec3(-1, 0, 0.01) * scale, Vec3(2, 0, 0.01) * scale};
    b.x_t0 = {Vec3(0, -1, 0) * scale, Vec3(0, 3, 0) * scale};
    a.x_t1 = a.x_t0, b.x_t1 = b.x_t0;
    a.edges = b.edges = {{0, 1}};
    CandidatePairs pairs;
    pairs.edge_edge = {{0, 0}};
    std::vector<Contact> contacts;
    const double reach = std::max(1e-3, scale);
    find_proximities(a.view(), b.view(), pairs, {.reach = reach, .secondary_at_start = reach},
                     contacts);
    EXPECT_EQ(contacts.size(), 1u) << scale;
  }
}

TEST(FindProximities, EdgesCountToTheLastBitAsTheirDistanceSays) {
  Random r(26);
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    Surface a, b;
    const auto direction = [&] { return Vec3(real(r, -1, 1), real(r, -1, 1), real(r, -1, 1)); };
    const Vec3 u = direction(), v = direction(), n = u.cross(v).normalized();
    a.x_t0 = {Vec3(-0.5 * u), u};
    b.x_t0 = {1e-3 * n - v, 1e-3 * n + 0.3 * v};
    a.x_t1 = a.x_t0, b.x_t1 = b.x_t0;
    a.edges = b.edges = {{0, 1}};
    CandidatePairs pairs;
    pairs.edge_edge = {{0, 0}};
    const double distance = edge_edge_closest(a.x_t0[0], a.x_t0[1], b.x_t0[0], b.x_t0[1]).distance;
    for (const double reach : {1e-3, distance, std::nextafter(distance, 1.0)}) {
      std::vector<Contact> contacts;
      find_proximities(a.view(), b.view(), pairs, {.reach = 1.0, .secondary_at_start = reach},
                       contacts);
      EXPECT_EQ(contacts.size(), distance < reach ? 1u : 0u) << i;
      inside += distance < reach ? 1 : 0;
    }
  }
  EXPECT_GT(inside, 2000);
}

/// How many of 8 ends of a pair collide whose primitives go towards each other, each by half of
/// `length` per coordinate.
int colliding_ends(const Query& query, double length) {
  int colliding = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 way(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    Query q = query;
    for (int k = 0; k < 4; ++k) {
      const bool first = k < (q.kind == ContactKind::edge_edge ? 2 : 1);
      q.x_t1[k] += (first ? 0.5 : -0.5) * length * way;
    }
    double toi = 0.0;
    colliding += make_ccd_exact()->collides(q, toi);
  }
  return colliding;
}

TEST(FindProximities, NoPairCollidesWhileItsEndsChangeByLessThanItsRoom) {
  Random r(27);
  const Surface a = soup(r, 25, 0.3, 0.3), b = soup(r, 25, 0.3, 0.3);
  const CandidatePairs pairs = all_pairs(a, b);
  std::vector<Contact> all;
  std::vector<float> rooms;
  find_proximities(a.view(), b.view(), pairs, {.reach = 1e3}, all, rooms);
  ASSERT_EQ(all.size(), pairs.size());
  ASSERT_EQ(rooms.size(), pairs.size());
  int with_room = 0, beyond = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (rooms[i] < 0.0F) continue;
    ++with_room;
    const Query q = query_of(a, b, all[i]);
    EXPECT_EQ(colliding_ends(q, 0.999 * rooms[i]), 0) << i;
    beyond += colliding_ends(q, 1.5 * rooms[i]);
  }
  EXPECT_GT(with_room, 1000);
  EXPECT_GT(beyond, 100);
}

TEST(Screens, OfEveryWidthProveTheSame) {
  using detail::kScreenBlock;
  const std::span<const detail::Screen> screens = detail::screens();
  if (screens.size() == 1) GTEST_SKIP() << "no AVX2";
  const detail::Screen &narrow = screens.front(), &wide = screens.back();
  const detail::ScreenLimits limits{
      .slack = 1e-6F, .at_start = 0.4F, .with_motion = 0.2F, .lines = 0.2F, .offset = 1e-6F};
  Random r(28);
  std::uint32_t some = 0, all = 0xff;
  for (int i = 0; i < 200; ++i) {
    std::array<std::array<std::array<float, 8>, kScreenBlock>, 4> paths;
    detail::PathBlock block;
    for (std::size_t k = 0; k < 4; ++k)
      for (std::size_t j = 0; j < kScreenBlock; ++j) {
        for (float& x : paths[k][j]) x = static_cast<float>(real(r, -0.5, 0.5));
        block[k][j] = paths[k][j].data();
      }
    for (const bool edges : {false, true}) {
      std::array<float, kScreenBlock> room, wide_room;
      const std::uint32_t far = narrow.compare(block, edges, limits, room);
      EXPECT_EQ(wide.compare(block, edges, limits, wide_room), far);
      EXPECT_EQ(wide_room, room);
      EXPECT_EQ(wide.never_meet(block, edges, limits.slack),
                narrow.never_meet(block, edges, limits.slack));
      some |= far;
      all &= far;
    }
  }
  EXPECT_EQ(some, 0xffU);
  EXPECT_EQ(all, 0U);
}

TEST(FindProximities, TouchingPairsGetTheTrianglesNormalOnTheirSide) {
  Query q = falling_point(0.0, -1.0);
  Surface a, b;
  a.x_t0 = {q.x_t0[0]}, a.x_t1 = {q.x_t1[0]};
  b.x_t0.assign(q.x_t0.begin() + 1, q.x_t0.end()), b.x_t1 = b.x_t0;
  b.triangles = {{0, 1, 2}};
  CandidatePairs pairs;
  pairs.point_triangle = {{0, 0}};
  std::vector<Contact> contacts;
  find_proximities(a.view(), b.view(), pairs, {.reach = 0.01}, contacts);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR((contacts[0].normal - Vec3(0, 0, 1)).norm(), 0.0, 1e-15);
  EXPECT_EQ(contacts[0].gap, 0.0);
}

}  // namespace
}  // namespace selvedge::narrowphase_test
