// SPDX-License-Identifier: MIT
// The conservative methods (inclusion, additive, minimum separation) against the exact one and
// against distances sampled in long double; root parity against the count of contacts.
#include <gtest/gtest.h>
#include <selvedge/narrowphase/ccd_exact.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/cubic.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {
namespace {

using Random = std::mt19937_64;

int integer(Random& r, int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(r); }
double real(Random& r, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(r);
}

std::string text(const Query& q) {
  std::ostringstream out;
  out << std::hexfloat << (q.kind == ContactKind::edge_edge ? "edge_edge" : "point_triangle");
  for (const auto* x : {&q.x_t0, &q.x_t1})
    for (const Vec3& v : *x) out << "\n" << v.x() << ", " << v.y() << ", " << v.z();
  return out.str();
}

template <class Change>
void for_each_coordinate(Query& q, Change change) {
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x)
      for (int i = 0; i < 3; ++i) v[i] = change(v[i]);
}

// ---------------------------------------------------------------------------------------------
// Queries

ContactKind kind_of(int i) {
  return i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge;
}

Query integers(Random& r, ContactKind kind, int size) {
  Query q;
  q.kind = kind;
  for_each_coordinate(q, [&](double) { return integer(r, -size, size); });
  return q;
}

Query reals(Random& r, ContactKind kind) {
  Query q;
  q.kind = kind;
  for_each_coordinate(q, [&](double) { return real(r, -1.0, 1.0); });
  return q;
}

/// Moves the first primitive so that the primitives share a point, exactly: weights are eighths
/// and the coordinates multiples of 64.
void make_touch(Random& r, ContactKind kind, std::array<Vec3, 4>& x) {
  for (Vec3& v : x) v *= 64.0;
  const int a = integer(r, 0, 8);
  if (kind == ContactKind::point_triangle) {
    const int b = integer(r, 0, 8 - a);
    x[0] = (a * x[1] + b * x[2] + (8 - a - b) * x[3]) / 8.0;
    return;
  }
  const int b = integer(r, 0, 8);
  const Vec3 shift = ((8 - b) * x[2] + b * x[3]) / 8.0 - ((8 - a) * x[0] + a * x[1]) / 8.0;
  x[0] += shift, x[1] += shift;
}

void nudge(Random& r, Query& q) {
  auto& x = integer(r, 0, 1) != 0 ? q.x_t0 : q.x_t1;
  double& c = x[integer(r, 0, 3)][integer(r, 0, 2)];
  c = c == 0.0 ? 0x1p-60 : std::nextafter(c, integer(r, 0, 1) != 0 ? 1e300 : -1e300);
}

void flatten(Random& r, Query& q) {
  const int a = integer(r, -2, 2), b = integer(r, -2, 2);
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x) v.z() = a * v.x() + b * v.y();
}

/// Zero length, zero area, or a triangle that is a segment.
void degenerate(Random& r, Query& q) {
  const int how = integer(r, 0, 2);
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    if (how == 0) (*x)[3] = (*x)[2];
    if (how == 1 && q.kind == ContactKind::edge_edge) (*x)[1] = (*x)[0];
    if (how == 1) (*x)[3] = (*x)[2];
    if (how == 2) (*x)[3] = 2.0 * (*x)[2] - (*x)[1];
  }
}

/// Edges that stay parallel to one another; for a point and a triangle two parallel sides.
void parallel(Query& q) {
  for (auto* x : {&q.x_t0, &q.x_t1}) (*x)[3] = (*x)[2] + ((*x)[1] - (*x)[0]);
}

void touch_inside_step(Random& r, Query& q) {
  std::array<Vec3, 4> middle = q.x_t0;
  make_touch(r, q.kind, middle);
  const int before = integer(r, 1, 4), after = integer(r, 1, 4);
  for (int k = 0; k < 4; ++k) {
    const Vec3 v = q.x_t1[k] * integer(r, 0, 8);
    q.x_t0[k] = middle[k] - before * v, q.x_t1[k] = middle[k] + after * v;
  }
}

constexpr int kCategories = 14;

Query hard(Random& r, int category, ContactKind kind) {
  Query q = integers(r, kind, integer(r, 1, 4));
  switch (category) {
    case 0:
      return q;
    case 1:
      make_touch(r, kind, q.x_t0);
      for (Vec3& v : q.x_t1) v *= 64.0;
      return q;
    case 2:
      make_touch(r, kind, q.x_t1);
      for (Vec3& v : q.x_t0) v *= 64.0;
      return q;
    case 3:
      touch_inside_step(r, q);
      return q;
    case 4:
      touch_inside_step(r, q);
      nudge(r, q);
      return q;
    case 5:
      flatten(r, q);
      return q;
    case 6:
      degenerate(r, q);
      return q;
    case 7:
      degenerate(r, q);
      flatten(r, q);
      return q;
    case 8:  // slivers
      for (auto* x : {&q.x_t0, &q.x_t1})
        for (Vec3& v : *x) v.z() = std::ldexp(v.z(), -integer(r, 20, 60));
      return q;
    case 9:  // small and far from the origin
      for_each_coordinate(q, [&](double c) { return c * real(r, 0.001, 0.002) + 1e6; });
      return q;
    case 10:  // at rest, or moved as one
      for (int k = 0, far = integer(r, 0, 1); k < 4; ++k)
        q.x_t1[k] = q.x_t0[k] + far * Vec3(3, 1, 2);
      return q;
    case 11:
      parallel(q);
      return q;
    case 12:  // nearly in one plane
      flatten(r, q);
      nudge(r, q);
      return q;
    default:
      return reals(r, kind);
  }
}

/// The same at another scale, from 1e-100 to 1e100, and a power of two so that truth stays.
Query rescaled(Random& r, Query q) {
  const double factor = std::ldexp(1.0, integer(r, -332, 332));
  for_each_coordinate(q, [&](double c) { return c * factor; });
  return q;
}

double time_of(const NarrowPhase& method, const Query& q) {
  double toi = 0.0;
  return method.collides(q, toi) ? toi : kNoCollision;
}

// ---------------------------------------------------------------------------------------------
// Conservative methods against the exact one

struct Conservative {
  const char* name;
  unsigned seed;
  std::function<std::unique_ptr<NarrowPhase>()> make;
};

/// Small budgets: what runs out must be as safe as what is decided, and quicker to test.
const std::vector<Conservative> kMethods{
    {"inclusion_time_first", 17,
     [] { return make_ccd_inclusion(CcdInclusionConfig{.max_boxes = 200}); }},
    {"inclusion_breadth_first", 18,
     [] {
       return make_ccd_inclusion(
           CcdInclusionConfig{.max_boxes = 200, .order = CcdInclusionConfig::Order::breadth_first});
     }},
    {"inclusion_coarse", 19,
     [] { return make_ccd_inclusion(CcdInclusionConfig{.tolerance = 0x1p-6, .max_boxes = 200}); }},
    {"additive", 20, [] { return make_ccd_additive(CcdAdditiveConfig{.max_steps = 100}); }},
    {"additive_close", 21,
     [] { return make_ccd_additive(CcdAdditiveConfig{.gap = 1e-3, .max_steps = 100}); }},
    {"separation_zero", 22, [] { return make_ccd_separation(0.0); }},
    {"separation_tiny", 23, [] { return make_ccd_separation(1e-12); }},
};

void PrintTo(const Conservative& method, std::ostream* out) { *out << method.name; }

class ConservativeMethod : public testing::TestWithParam<Conservative> {};

TEST_P(ConservativeMethod, IsNeverLaterThanTheTrueTimeOnHardQueries) {
  const auto method = GetParam().make();
  const auto exact = make_ccd_exact();
  EXPECT_TRUE(method->traits().misses_nothing);
  constexpr int kQueries = 8400;  // of each of the seven: 58,800 in all
  Random r(GetParam().seed);
  int hits = 0, clear = 0, failures = 0;
  for (int i = 0; i < kQueries && failures < 5; ++i) {
    Query q = hard(r, i / 2 % kCategories, kind_of(i));
    if (i % 5 == 0) q = rescaled(r, q);
    const double truth = time_of(*exact, q), found = time_of(*method, q);
    hits += truth != kNoCollision ? 1 : 0;
    clear += found == kNoCollision ? 1 : 0;
    if (found <= truth && (found == kNoCollision || found >= 0.0)) continue;
    ++failures;
    ADD_FAILURE() << "query " << i << ": " << found << " instead of " << truth << ": " << text(q);
  }
  EXPECT_GT(hits, kQueries / 5);
  // A method that always says "at once" would pass too.
  EXPECT_GT(clear, kQueries / 5);
}

/// Primitives along the z axis whose traces in the x-y plane meet at t = 1/4 exactly, though none
/// of the differences of their coordinates is a double: 51 bits of different size, times -3 at t
/// = 1.
Query meeting_by_a_hair(Random& r, ContactKind kind) {
  const auto trace = [&] {
    return std::ldexp(std::floor(real(r, -1.0, 1.0) * 0x1p51), integer(r, -70, -51));
  };
  Query q;
  q.kind = kind;
  for (int k = 0, second = kind == ContactKind::edge_edge ? 2 : 1; k < 4; ++k) {
    if (k == 0 || k == second) q.x_t0[k] = Vec3(trace(), trace(), 0.0);
    if (k != 0 && k != second) q.x_t0[k] = q.x_t0[k - 1] + Vec3(0, 0, 1.0);
    q.x_t1[k] = Vec3(-3.0 * q.x_t0[k].x(), -3.0 * q.x_t0[k].y(), q.x_t0[k].z());
  }
  return q;
}

TEST_P(ConservativeMethod, FindsContactThatRoundingOfTheCoordinatesWouldLose) {
  const auto method = GetParam().make();
  const auto exact = make_ccd_exact();
  Random r(20);
  for (int i = 0; i < 1000; ++i) {
    const Query q = meeting_by_a_hair(r, kind_of(i));
    ASSERT_EQ(time_of(*exact, q), 0.25) << text(q);
    ASSERT_LE(time_of(*method, q), 0.25) << text(q);
  }
}

TEST_P(ConservativeMethod, DecidesNearlyAllQueriesInGeneralPosition) {
  const auto method = GetParam().make();
  const auto exact = make_ccd_exact();
  Random r(18);
  int alarms = 0, negatives = 0;
  for (int i = 0; i < 2000; ++i) {
    const Query q = reals(r, kind_of(i));
    if (time_of(*exact, q) != kNoCollision) continue;
    ++negatives;
    alarms += time_of(*method, q) != kNoCollision ? 1 : 0;
  }
  EXPECT_LT(alarms, negatives / 5) << negatives;
}

INSTANTIATE_TEST_SUITE_P(Methods, ConservativeMethod, testing::ValuesIn(kMethods),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(CcdInclusion, FindsTheTimeWithinItsToleranceInGeneralPosition) {
  const auto exact = make_ccd_exact();
  const auto time_first = make_ccd_inclusion(CcdInclusionConfig{});
  const auto breadth_first =
      make_ccd_inclusion(CcdInclusionConfig{.order = CcdInclusionConfig::Order::breadth_first});
  Random r(19);
  int hits = 0;
  for (int i = 0; i < 1000; ++i) {
    const Query q = reals(r, kind_of(i));
    const double truth = time_of(*exact, q);
    if (truth == kNoCollision) continue;
    ++hits;
    const double found = time_of(*time_first, q);
    EXPECT_EQ(found, time_of(*breadth_first, q)) << text(q);
    EXPECT_LE(found, truth);
    // The last box is about 2^-20 / speed long; grazing contact makes more of it.
    EXPECT_GT(found, truth - 1e-2) << text(q);
  }
  EXPECT_GT(hits, 30);
}

TEST(CcdInclusion, SaysCollidesAtTheEarliestOpenTimeWhenBoxesRunOut) {
  // Edges that slide past one another in their common line, 2^-30 apart.
  const Query q{ContactKind::edge_edge,
                {Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(0, 0, 0x1p-30), Vec3(1, 1, 1 + 0x1p-30)},
                {Vec3(1, 1, 1), Vec3(2, 2, 2), Vec3(0, 0, 0x1p-30), Vec3(1, 1, 1 + 0x1p-30)}};
  EXPECT_EQ(time_of(*make_ccd_exact(), q), kNoCollision);
  EXPECT_EQ(
      time_of(*make_ccd_inclusion(CcdInclusionConfig{.tolerance = 0x1p-40, .max_boxes = 50}), q),
      0.0);
}

TEST(CcdAdditive, StopsShortOfContactByItsPartOfTheFirstDistance) {
  // A point falls from 1 m to -1 m through a triangle.
  const Query q{ContactKind::point_triangle,
                {Vec3(0.25, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                {Vec3(0.25, 0.25, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  for (const double gap : {0.5, 0.1, 0.001}) {
    const double t = time_of(*make_ccd_additive(CcdAdditiveConfig{.gap = gap}), q);
    const double left = 1.0 - 2.0 * t;
    EXPECT_GT(left, 0.0);
    EXPECT_LE(left, gap);
  }
}

TEST(CcdAdditive, RaisesAFalseAlarmWhereThePrimitivesComeNear) {
  const Query q{ContactKind::point_triangle,
                {Vec3(0.05, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                {Vec3(0.65, 0.25, 0.05), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  EXPECT_NE(time_of(*make_ccd_additive(), q), kNoCollision);
  EXPECT_EQ(time_of(*make_ccd_additive(CcdAdditiveConfig{.gap = 0.01}), q), kNoCollision);
}

TEST(Config, IsRefusedWithASentenceWhereItMakesNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto registry = narrow_phases();
  for (const double d : {-1.0, nan, static_cast<double>(kNoCollision)}) {
    EXPECT_THROW(make_ccd_separation(d), std::invalid_argument);
    for (const char* name : {"ccd_exact", "ccd_inclusion", "ccd_additive", "ccd_root_parity"})
      EXPECT_THROW(registry.at(name)({.min_separation = d}), std::invalid_argument) << name;
  }
  EXPECT_THROW(registry.at("ccd_root_parity")({.min_separation = 1e-3}), std::invalid_argument);
  EXPECT_THROW(registry.at("ccd_inclusion")({.tolerance = 2.0}), std::invalid_argument);
  EXPECT_THROW(registry.at("ccd_inclusion")({.tolerance = 1e-15}), std::invalid_argument);
  EXPECT_THROW(make_ccd_inclusion(CcdInclusionConfig{.max_boxes = 0}), std::invalid_argument);
  EXPECT_THROW(registry.at("ccd_additive")({.tolerance = 1.0}), std::invalid_argument);
  EXPECT_THROW(make_ccd_additive(CcdAdditiveConfig{.max_steps = 0}), std::invalid_argument);
}

TEST(Config, NonFiniteVerticesAreRefusedByName) {
  Random r(1);
  for (const char* name : {"ccd_exact", "ccd_inclusion", "ccd_additive", "ccd_root_parity"}) {
    const double d = std::string(name) == "ccd_root_parity" ? 0.0 : 0.01;
    const auto method = narrow_phases().at(name)({.min_separation = d});
    Query q = reals(r, ContactKind::edge_edge);
    q.x_t1[2].y() = std::numeric_limits<double>::infinity();
    EXPECT_THROW(time_of(*method, q), std::invalid_argument) << name;
  }
}

// ---------------------------------------------------------------------------------------------
// Minimum separation against distances in long double

using Real = long double;
using Place = Eigen::Matrix<Real, 3, 1>;
using Places = std::array<Place, 4>;

Real square_to_segment(const Place& p, const Place& a, const Place& b) {
  const Place d = b - a;
  const Real dd = d.squaredNorm();
  const Real s = dd > 0 ? std::clamp<Real>((p - a).dot(d) / dd, 0, 1) : 0;
  return (p - a - s * d).squaredNorm();
}

/// Where the interior's candidate is outside it is not taken; each candidate is a distance between
/// points of the primitives.
Real point_triangle_square(const Places& x) {
  Real best = square_to_segment(x[0], x[1], x[2]);
  best = std::min(best, square_to_segment(x[0], x[2], x[3]));
  best = std::min(best, square_to_segment(x[0], x[3], x[1]));
  const Place a = x[2] - x[1], b = x[3] - x[1], p = x[0] - x[1], n = a.cross(b);
  const Real nn = n.squaredNorm();
  if (!(nn > 0)) return best;
  const Real u = p.cross(b).dot(n) / nn, v = a.cross(p).dot(n) / nn;
  if (u < 0 || v < 0 || u + v > 1) return best;
  return std::min(best, (p - u * a - v * b).squaredNorm());
}

Real edge_edge_square(const Places& x) {
  Real best = std::min(square_to_segment(x[0], x[2], x[3]), square_to_segment(x[1], x[2], x[3]));
  best = std::min(best, square_to_segment(x[2], x[0], x[1]));
  best = std::min(best, square_to_segment(x[3], x[0], x[1]));
  const Place a = x[1] - x[0], b = x[3] - x[2], w = x[2] - x[0], n = a.cross(b);
  const Real nn = n.squaredNorm();
  if (!(nn > 0)) return best;
  const Real s = w.cross(b).dot(n) / nn, t = w.cross(a).dot(n) / nn;
  if (s < 0 || s > 1 || t < 0 || t > 1) return best;
  return std::min(best, (s * a - w - t * b).squaredNorm());
}

Real distance_at(const Query& q, Real t) {
  Places x;
  const Place origin = q.x_t0[0].cast<Real>();
  for (int k = 0; k < 4; ++k)
    x[k] = (1 - t) * (q.x_t0[k].cast<Real>() - origin) + t * (q.x_t1[k].cast<Real>() - origin);
  const bool edges = q.kind == ContactKind::edge_edge;
  return std::sqrt(edges ? edge_edge_square(x) : point_triangle_square(x));
}

/// The smallest distance found in [0, end]: samples, and golden sections about the least of them.
Real least_distance(const Query& q, Real end) {
  constexpr int kSamples = 48;
  Real least = std::numeric_limits<Real>::infinity();
  int at = 0;
  for (int i = 0; i <= kSamples; ++i) {
    const Real d = distance_at(q, end * i / kSamples);
    if (d < least) least = d, at = i;
  }
  Real lo = end * std::max(at - 1, 0) / kSamples, hi = end * std::min(at + 1, kSamples) / kSamples;
  for (int i = 0; i < 40; ++i) {
    const Real a = lo + 0.382L * (hi - lo), b = lo + 0.618L * (hi - lo);
    const Real da = distance_at(q, a), db = distance_at(q, b);
    least = std::min({least, da, db});
    (da < db ? hi : lo) = da < db ? b : a;
  }
  return least;
}

/// The L of make_ccd_separation.
double size_of(const Query& q) {
  double size = 0.0;
  for (const auto* x : {&q.x_t0, &q.x_t1})
    for (const Vec3& v : *x) size = std::max(size, (v - (*x)[0]).cwiseAbs().maxCoeff());
  return size;
}

/// Error of distance_at, as a part of L: conditioning of near-parallel interiors.
constexpr Real kOracleError = 0x1p-46L;

/// Names what is wrong with the answer, or nothing.
std::string fault(const Query& q, double d, double toi) {
  const Real size = size_of(q), error = kOracleError * size;
  const bool hit = toi != kNoCollision;
  std::ostringstream out;
  out << std::hexfloat;
  // The first time counts as collision, so just before it the distance is still larger than d.
  const Real end = hit ? static_cast<Real>(toi) : 1.0L;
  if (end > 0 && least_distance(q, end) < d - error) out << "late: d " << d << " toi " << toi;
  if (hit && distance_at(q, toi) > d + d / 64 + 0x1p-40L * size + error)
    out << "early: d " << d << " toi " << toi << " distance " << distance_at(q, toi);
  return out.str();
}

class MinSeparation : public testing::TestWithParam<int> {};

TEST_P(MinSeparation, IsNeverLateAndEarlyByNoMoreThanItsBound) {
  Random r(100 + static_cast<unsigned>(GetParam()));
  constexpr int kQueries = 700;
  int hits = 0, clear = 0, failures = 0;
  for (int i = 0; i < kQueries && failures < 3; ++i) {
    const Query q = hard(r, GetParam(), kind_of(i));
    const double d = size_of(q) * std::ldexp(real(r, 0.5, 1.0), -integer(r, 0, 40));
    const double toi = time_of(*make_ccd_separation(d), q);
    (toi == kNoCollision ? clear : hits) += 1;
    const std::string wrong = fault(q, d, toi);
    if (wrong.empty()) continue;
    ++failures;
    ADD_FAILURE() << "query " << i << " " << wrong << ": " << text(q);
  }
  EXPECT_GT(hits, kQueries / 50);
  const bool made_to_touch = GetParam() >= 1 && GetParam() <= 4;
  EXPECT_GT(clear, made_to_touch ? -1 : kQueries / 50);
}

INSTANTIATE_TEST_SUITE_P(Hard, MinSeparation, testing::Range(0, kCategories));

/// Turning primitives that stay near: where plain advancement creeps.
Query pinwheel(Random& r, ContactKind kind, double d) {
  Query q = reals(r, kind);
  // The point (an end of the first edge) stays near a fixed place of the second primitive, which
  // turns about it.
  Vec3 weight(real(r, 0.0, 1.0), real(r, 0.0, 1.0), real(r, 0.0, 1.0));
  weight /= weight.sum();
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    auto& y = *x;
    if (kind == ContactKind::edge_edge) {
      const Vec3 n = (y[1] - y[0]).cross(y[3] - y[2]).normalized();
      const Vec3 shift = 0.5 * (y[0] + y[1]) - (0.25 * y[2] + 0.75 * y[3]) - d * n;
      y[2] += shift, y[3] += shift;
    } else {
      const Vec3 n = (y[2] - y[1]).cross(y[3] - y[1]).normalized();
      y[0] = weight[0] * y[1] + weight[1] * y[2] + weight[2] * y[3] + d * n;
    }
  }
  return q;
}

/// A point that stays beside a turning side of the triangle, outside.
Query beside_turning_side(Random& r, double d) {
  Query q = reals(r, ContactKind::point_triangle);
  const double along = real(r, 0.1, 0.9), angle = real(r, -1.6, 1.6);
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    auto& y = *x;
    const Vec3 side = y[2] - y[1], n = side.cross(y[3] - y[1]).normalized();
    const Vec3 outward = side.cross(n).normalized();
    y[0] = y[1] + along * side + d * (std::cos(angle) * outward + std::sin(angle) * n);
  }
  return q;
}

TEST(MinSeparation, APointBesideATurningSideGetsAnAnswerWithinTheBound) {
  Random r(40);
  int clear = 0;
  for (int i = 0; i < 300; ++i) {
    const double d = std::ldexp(1.0, -integer(r, 4, 24));
    const Query q = beside_turning_side(r, 1.3 * d);
    const double toi = time_of(*make_ccd_separation(d), q);
    clear += toi == kNoCollision ? 1 : 0;
    ASSERT_EQ(fault(q, d, toi), "") << text(q);
  }
  EXPECT_GT(clear, 30);
}

TEST(MinSeparation, TurningPrimitivesThatStayNearGetAnAnswerWithinTheBound) {
  Random r(41);
  int clear = 0;
  for (int i = 0; i < 600; ++i) {
    const double d = std::ldexp(1.0, -integer(r, 4, 30));
    const Query q = pinwheel(r, kind_of(i), 1.3 * d);
    const double toi = time_of(*make_ccd_separation(d), q);
    clear += toi == kNoCollision ? 1 : 0;
    ASSERT_EQ(fault(q, d, toi), "") << text(q);
  }
  EXPECT_GT(clear, 60);
}

TEST(MinSeparation, AFallingPointIsStoppedAtTheKnownTime) {
  for (const double d : {0.5, 0.1, 1e-3, 1e-6, 1e-9}) {
    const Query q{ContactKind::point_triangle,
                  {Vec3(0.25, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                  {Vec3(0.25, 0.25, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
    const double toi = time_of(*make_ccd_separation(d), q);
    const Real truth = (1.0L - d) / 2.0L;
    EXPECT_LE(toi, truth);
    EXPECT_GT(toi, truth - d / 128 - 0x1p-40);
  }
}

TEST(MinSeparation, WhatRestsWithinTheSeparationCollidesAtOnce) {
  Random r(43);
  for (int i = 0; i < 2000; ++i) {
    Query q = hard(r, i % kCategories, kind_of(i));
    if (i % 3 == 0) q.x_t1 = q.x_t0;
    const double at_start = static_cast<double>(distance_at(q, 0));
    ASSERT_EQ(time_of(*make_ccd_separation(at_start), q), 0.0) << text(q);
  }
}

TEST(MinSeparation, WhatRestsOutsideTheBoundNeverCollides) {
  Random r(44);
  for (int i = 0; i < 2000; ++i) {
    Query q = hard(r, i % kCategories, kind_of(i));
    q.x_t1 = q.x_t0;
    const double size = size_of(q), distance = static_cast<double>(distance_at(q, 0));
    const double d = (distance - 0x1p-39 * size) / (1.0 + 1.0 / 64);
    if (!(d > 0.0)) continue;
    ASSERT_EQ(time_of(*make_ccd_separation(d), q), kNoCollision) << distance << text(q);
  }
}

TEST(MinSeparation, ScalingByAPowerOfTwoNeverChangesTheAnswer) {
  Random r(45);
  for (int i = 0; i < 4000; ++i) {
    Query q = hard(r, i % kCategories, kind_of(i));
    const double d = size_of(q) * std::ldexp(real(r, 0.5, 1.0), -integer(r, 1, 30));
    const double toi = time_of(*make_ccd_separation(d), q);
    const double factor = std::ldexp(1.0, integer(r, -900, 900));
    for_each_coordinate(q, [&](double c) { return c * factor; });
    ASSERT_EQ(time_of(*make_ccd_separation(factor * d), q), toi) << text(q);
  }
}

TEST(MinSeparation, MotionSharedByAllVerticesChangesNothing) {
  Random r(46);
  for (int i = 0; i < 2000; ++i) {
    Query q = hard(r, i % 4, kind_of(i));
    const double d = size_of(q) * std::ldexp(real(r, 0.5, 1.0), -integer(r, 1, 20));
    const double toi = time_of(*make_ccd_separation(d), q);
    for (Vec3& v : q.x_t0) v += Vec3(512, -256, 128);
    for (Vec3& v : q.x_t1) v -= Vec3(1024, 16384, 4096);
    ASSERT_EQ(time_of(*make_ccd_separation(d), q), toi) << text(q);
  }
}

TEST(MinSeparation, ALargerOneIsNeverAnsweredLater) {
  Random r(47);
  for (int i = 0; i < 3000; ++i) {
    const Query q = hard(r, i % kCategories, kind_of(i));
    const double d = size_of(q) * std::ldexp(1.0, -integer(r, 1, 20));
    // By more than the early bound of the smaller one.
    const double near = time_of(*make_ccd_separation(d), q);
    const double far = time_of(*make_ccd_separation(1.1 * d), q);
    ASSERT_LE(far, near) << text(q);
  }
}

TEST(MinSeparation, TheNormalOfAContactIsTheDirectionBetweenTheClosestPoints) {
  // A point nears the side x = 0 of a triangle from outside, almost in its plane.
  constexpr double d = 0.125;
  const std::vector<Vec3> point_t0{Vec3(-1, 0, 0.01)}, point_t1{Vec3(1, 0, 0.01)};
  const std::vector<Vec3> corners{Vec3(0, -1, 0), Vec3(0, 1, 0), Vec3(1, 0, 0)};
  const std::vector<Triangle> triangles{Triangle{0, 1, 2}};
  const SurfaceView point{point_t0, point_t1, {}, {}};
  const SurfaceView triangle{corners, corners, {}, triangles};
  for (const bool swapped : {false, true}) {
    CandidatePairs pairs;
    (swapped ? pairs.triangle_point : pairs.point_triangle).push_back({0, 0});
    std::vector<Contact> contacts;
    make_ccd_separation(d)->find_contacts(swapped ? triangle : point, swapped ? point : triangle,
                                          pairs, contacts);
    ASSERT_EQ(contacts.size(), 1u);
    const Contact& c = contacts[0];
    const Vec3 way = Vec3(2.0 * c.toi - 1.0, 0, 0.01);
    EXPECT_NEAR((c.normal - way.normalized()).norm(), 0.0, 1e-12);
    EXPECT_NEAR(way.norm(), d, d / 64);
    EXPECT_NEAR(c.gap, Vec3(-1, 0, 0.01).norm(), 1e-12);
  }
}

TEST(MinSeparation, CoordinatesAtTheEndsOfTheRangeGetAnAnswer) {
  for (const double size : {0x1p-1074, 0x1p-1030, 1e-300, 1.0, 1e300, 0x1.8p1023}) {
    const Query q{
        ContactKind::edge_edge,
        {Vec3(-size, 0, size), Vec3(size, 0, size), Vec3(0, -size, 0), Vec3(0, size, 0)},
        {Vec3(-size, 0, -size), Vec3(size, 0, -size), Vec3(0, -size, 0), Vec3(0, size, 0)}};
    const double toi = time_of(*make_ccd_separation(0.0), q);
    EXPECT_LE(toi, 0.5) << size;
    EXPECT_GT(toi, 0.499) << size;
  }
}

// ---------------------------------------------------------------------------------------------
// Root parity

/// Contacts of a query in general position, counted at the roots of the coplanarity cubic; -1 if a
/// root is too near a boundary for doubles.
int count_contacts(const Query& q) {
  constexpr double kUnclear = 1e-7;
  int count = 0;
  for (const CubicRoot& root : coplanarity_roots(q).roots) {
    const double d = static_cast<double>(distance_at(q, root.lo));
    if (root.lo < kUnclear || root.lo > 1.0 - kUnclear) return -1;
    if (d > 1e-13 && d < kUnclear) return -1;
    count += d <= 1e-13 ? 1 : 0;
  }
  return count;
}

TEST(RootParity, IsTheParityOfTheNumberOfContactsInGeneralPosition) {
  const auto method = make_ccd_root_parity();
  EXPECT_FALSE(method->traits().gives_time);
  EXPECT_FALSE(method->traits().misses_nothing);
  Random r(51);
  std::array<int, 4> seen{};
  for (int i = 0; i < 20000; ++i) {
    const Query q = reals(r, kind_of(i));
    const int contacts = count_contacts(q);
    if (contacts < 0) continue;
    ++seen[contacts];
    const double t = time_of(*method, q);
    ASSERT_EQ(t, contacts % 2 == 1 ? 0.0 : kNoCollision) << contacts << ": " << text(q);
  }
  for (const int n : {0, 1, 2}) EXPECT_GT(seen[n], 20) << n << " contacts";
}

TEST(RootParity, ContactAtTheEndsOfTheStepIsAlwaysFound) {
  const auto method = make_ccd_root_parity();
  Random r(52);
  for (int i = 0; i < 8000; ++i) {
    const Query q = hard(r, 1 + i % 2, kind_of(i / 2));
    ASSERT_EQ(time_of(*method, q), 0.0) << i << ": " << text(q);
  }
}

TEST(RootParity, ContactInsideTheStepIsFoundUnlessEven) {
  const auto method = make_ccd_root_parity();
  const auto exact = make_ccd_exact();
  Random r(53);
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Query q = hard(r, i % kCategories, kind_of(i / kCategories));
    const bool truth = time_of(*exact, q) != kNoCollision;
    if (!truth || time_of(*method, q) == 0.0) {
      hits += truth ? 1 : 0;
      continue;
    }
    // A miss must have at least two roots, with multiplicity.
    int roots = 0;
    for (const CubicRoot& root : coplanarity_roots(q).roots) roots += root.multiplicity;
    ASSERT_GE(roots, 2) << text(q);
  }
  EXPECT_GT(hits, 4000);
}

TEST(RootParity, MissesAPointThatPassesTheTriangleAndReturns) {
  // The point rises and the plane turns so that they meet at t = 1/4 and t = 3/4.
  const auto height = [](double t) { return (t - 0.25) * (t - 0.75); };
  // z of the point is t - 1/4; the triangle's plane tilts: z = x (1 - t) there, x = 2 t - ...
  Query q{ContactKind::point_triangle,
          {Vec3(0, 0, 0.1875), Vec3(-8, -8, 0), Vec3(8, -8, 0), Vec3(0, 8, 0)},
          {Vec3(1, 0, 0.1875), Vec3(-8, -8, -8), Vec3(8, -8, 8), Vec3(0, 8, 0)}};
  // On the path x = t the plane is at z = t * t, the point at z = 0.1875 + c t: with c = 1 - 1 = 0
  // the difference is 0.1875 - t * t; a slope of the point of 1 makes it -(t^2 - t + 3/16).
  q.x_t0[0].z() = -0.1875, q.x_t1[0].z() = 1.0 - 0.1875;
  EXPECT_EQ(height(0.0), 0.1875);
  EXPECT_EQ(time_of(*make_ccd_exact(), q), 0.25);
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), kNoCollision);
}

TEST(RootParity, CoordinatesTooUnlikeForExpansionsCountAsHit) {
  Query q{ContactKind::point_triangle,
          {Vec3(0.25, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
          {Vec3(0.25, 0.25, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), 0.0);
  q.x_t0[0] = Vec3(4, 4, 1), q.x_t1[0] = Vec3(4, 4, -1);
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), kNoCollision);
  q.x_t0[1].x() = 1e-200;
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), kNoCollision);  // apart along an axis
  q.x_t0[0] = q.x_t1[0] = Vec3(0.9, 0.9, 0.5), q.x_t1[0].z() = -0.5;
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), 0.0);
}

}  // namespace
}  // namespace selvedge
