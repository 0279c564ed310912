// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/apps/judge_ccd.h>
#include <selvedge/core/parallel.h>
#include <selvedge/narrowphase/ccd_exact.h>
#include <selvedge/narrowphase/cubic.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
constexpr double kInf = std::numeric_limits<double>::infinity();

// ---------------------------------------------------------------------------------------------
// Public and generated queries with known truth

fs::path shared_folder() {
  if (const char* named = std::getenv("SELVEDGE_SHARED")) return named;
  return fs::path(SELVEDGE_SOURCE_DIR) / ".." / "shared";
}

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> out;
  std::stringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) out.push_back(field);
  return out;
}

struct KnownQuery {
  Query query;
  bool truth = false;
  double toi_lo = -1.0, toi_hi = -1.0;
};

std::vector<KnownQuery> read_queries(const fs::path& file, ContactKind kind) {
  std::vector<KnownQuery> queries;
  std::ifstream in(file);
  int row = 0;
  for (std::string line; std::getline(in, line); row = (row + 1) % 8) {
    if (row == 0) queries.emplace_back();
    KnownQuery& known = queries.back();
    known.query.kind = kind;
    const std::vector<std::string> f = fields(line);
    auto& x = row < 4 ? known.query.x_t0 : known.query.x_t1;
    // Both parts are doubles and the denominator is a power of two: no rounding.
    for (int i = 0; i < 3; ++i)
      x[row % 4][i] =
          std::strtod(f[2 * i].c_str(), nullptr) / std::strtod(f[2 * i + 1].c_str(), nullptr);
    known.truth = f[6] == "1";
  }
  fs::path times = file;
  std::ifstream toi(times.replace_extension(".toi.csv"));
  for (std::string line; std::getline(toi, line);) {
    const std::vector<std::string> f = fields(line);
    if (f.size() < 4 || f[2].empty() || f[0] == "index") continue;
    KnownQuery& known = queries[std::stoul(f[0])];
    known.toi_lo = std::stod(f[2]), known.toi_hi = std::stod(f[3]);
  }
  return queries;
}

TEST(CcdExact, HasNoMissNoFalseAlarmAndExactTimesOnAllPublicQueries) {
  const fs::path root = shared_folder() / "data" / "ccd";
  if (!fs::exists(root)) GTEST_SKIP() << "the query files are not there: " << root;
  const auto method = narrow_phases().at("ccd_exact")({});
  std::size_t queries = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const std::string name = entry.path().string();
    if (!name.ends_with(".csv") || name.ends_with(".toi.csv")) continue;
    const bool face = name.find("vertex-face") != std::string::npos;
    const auto known =
        read_queries(entry.path(), face ? ContactKind::point_triangle : ContactKind::edge_edge);
    for (std::size_t i = 0; i < known.size(); ++i) {
      double toi = -1.0;
      const bool hit = method->collides(known[i].query, toi);
      EXPECT_EQ(hit, known[i].truth) << name << " query " << i;
      if (hit && known[i].truth) {
        EXPECT_EQ(toi, known[i].toi_lo) << name << " query " << i;
      }
    }
    queries += known.size();
  }
  EXPECT_EQ(queries, 9702u);
}

// ---------------------------------------------------------------------------------------------
// Adversarial queries

using Random = std::mt19937_64;

int integer(Random& r, int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(r); }
double real(Random& r, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(r);
}

Query grid(Random& r, ContactKind kind, int size) {
  Query q;
  q.kind = kind;
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x)
      for (int i = 0; i < 3; ++i) v[i] = integer(r, -size, size);
  return q;
}

Query uniform(Random& r, ContactKind kind, double size) {
  Query q;
  q.kind = kind;
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x)
      for (int i = 0; i < 3; ++i) v[i] = real(r, -size, size);
  return q;
}

/// Makes the primitives touch in x: weights in eighths, so that integers stay exact when x are
/// multiples of 8.
void make_touch(Random& r, ContactKind kind, std::array<Vec3, 4>& x) {
  for (Vec3& v : x) v *= 64.0;
  if (kind == ContactKind::point_triangle) {
    const int a = integer(r, 0, 8), b = integer(r, 0, 8 - a);
    x[0] = (a * x[1] + b * x[2] + (8 - a - b) * x[3]) / 8.0;
  } else {
    const int s = integer(r, 0, 8), t = integer(r, 0, 8);
    const Vec3 place = ((8 - s) * x[0] + s * x[1]) / 8.0;
    const Vec3 v = x[3] - x[2];
    x[2] = place - t * v / 8.0;
    x[3] = x[2] + v;
  }
}

void nudge(Random& r, Query& q) {
  for (int n = integer(r, 1, 3); n-- > 0;) {
    auto& x = integer(r, 0, 1) != 0 ? q.x_t0 : q.x_t1;
    double& c = x[integer(r, 0, 3)][integer(r, 0, 2)];
    const double towards = integer(r, 0, 1) != 0 ? kInf : -kInf;
    c = c == 0.0 ? std::copysign(0x1p-60, towards) : std::nextafter(c, towards);
  }
}

/// All vertices in one plane that does not move, not parallel to an axis.
void flatten(Random& r, Query& q) {
  const int a = integer(r, -2, 2), b = integer(r, -2, 2);
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x) v.z() = a * v.x() + b * v.y();
}

void degenerate(Random& r, Query& q) {
  const bool edges = q.kind == ContactKind::edge_edge;
  const int from = edges ? 0 : integer(r, 1, 2);
  const int to = edges ? 1 : 3;
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    switch (edges ? 0 : integer(r, 0, 1)) {
      case 0:
        (*x)[to] = (*x)[from];
        break;
      default:
        (*x)[3] = 2.0 * (*x)[2] - (*x)[1];
    }
  }
}

constexpr int kCategories = 16;

Query adversarial(Random& r, int category, ContactKind kind) {
  Query q = grid(r, kind, integer(r, 1, 4));
  switch (category) {
    case 0:  // lots of exact touchings, double and triple roots
      return q;
    case 1:  // at rest
      q.x_t1 = q.x_t0;
      return q;
    case 2:  // touching at t = 0
      make_touch(r, kind, q.x_t0);
      for (Vec3& v : q.x_t1) v *= 64.0;
      return q;
    case 3:  // touching at t = 1
      make_touch(r, kind, q.x_t1);
      for (Vec3& v : q.x_t0) v *= 64.0;
      return q;
    case 4:    // touching in the middle of the step
    case 5: {  // the same, missed or hit by a rounding
      std::array<Vec3, 4> middle = q.x_t0;
      make_touch(r, kind, middle);
      const int left = integer(r, 1, 4), right = integer(r, 1, 4);
      for (int k = 0; k < 4; ++k) {
        const Vec3 v = q.x_t1[k] * integer(r, 0, 8);
        q.x_t0[k] = middle[k] - left * v, q.x_t1[k] = middle[k] + right * v;
      }
      if (category == 5) nudge(r, q);
      return q;
    }
    case 6:
      flatten(r, q);
      return q;
    case 7:
      degenerate(r, q);
      return q;
    case 8:  // degenerate and in a plane
      degenerate(r, q);
      flatten(r, q);
      return q;
    case 9:  // slivers
      for (auto* x : {&q.x_t0, &q.x_t1})
        for (Vec3& v : *x) v.z() = std::ldexp(v.z(), -integer(r, 20, 60));
      return q;
    case 10:  // far from the origin
      for (auto* x : {&q.x_t0, &q.x_t1})
        for (Vec3& v : *x) v = v * real(r, 0.001, 0.002) + Vec3(1e6, -1e6, 1e6 / 3);
      return q;
    case 11: {  // a common vertex
      const int shared = kind == ContactKind::point_triangle ? integer(r, 1, 3) : integer(r, 2, 3);
      if (integer(r, 0, 1) != 0) q = uniform(r, kind, 1.0);
      q.x_t0[shared] = q.x_t0[0], q.x_t1[shared] = q.x_t1[0];
      if (integer(r, 0, 1) != 0) nudge(r, q);
      return q;
    }
    case 12:  // moved as one
      for (int k = 0; k < 4; ++k) q.x_t1[k] = q.x_t0[k] + Vec3(3, 1, 2);
      return q;
    case 13:
      return uniform(r, kind, 1.0);
    case 14:  // tenths: inexact numbers that nearly touch
      for (auto* x : {&q.x_t0, &q.x_t1})
        for (Vec3& v : *x) v *= 0.1;
      return q;
    default:  // nearly in one plane
      flatten(r, q);
      nudge(r, q);
      return q;
  }
}

bool oracle(const Query& q) {
  std::array<Vec3, 8> points;
  for (int k = 0; k < 4; ++k) points[k] = q.x_t0[k], points[k + 4] = q.x_t1[k];
  return paths_touch(
      q.kind == ContactKind::edge_edge ? PathKind::edge_edge : PathKind::point_triangle, points);
}

std::string text(const Query& q) {
  std::ostringstream out;
  out << std::hexfloat << (q.kind == ContactKind::edge_edge ? "edge_edge" : "point_triangle");
  for (const auto* x : {&q.x_t0, &q.x_t1})
    for (const Vec3& v : *x) out << "\n" << v.x() << ", " << v.y() << ", " << v.z();
  return out.str();
}

bool collides(const Query& q, double& toi) { return make_ccd_exact()->collides(q, toi); }

bool collides(const Query& q) {
  double toi = 0.0;
  return collides(q, toi);
}

/// SELVEDGE_CCD_QUERIES enlarges the comparison with the oracle.
int queries_per_category() {
  const char* named = std::getenv("SELVEDGE_CCD_QUERIES");
  return named != nullptr ? std::atoi(named) : 2500;
}

class Adversarial : public testing::TestWithParam<int> {};

TEST_P(Adversarial, QueriesGetTheVerdictOfTheIndependentOracle) {
  const int category = GetParam();
  Random r(1000 + static_cast<unsigned>(category));
  int hits = 0, failures = 0;
  const int n = queries_per_category();
  for (int i = 0; i < 2 * n && failures < 5; ++i) {
    const ContactKind kind = i < n ? ContactKind::point_triangle : ContactKind::edge_edge;
    const Query q = adversarial(r, category, kind);
    const bool truth = oracle(q);
    hits += truth ? 1 : 0;
    if (collides(q) == truth) continue;
    ++failures;
    ADD_FAILURE() << "query " << i << ", truth " << truth << ": " << text(q);
  }
  // A generator without collisions would prove nothing.
  EXPECT_GT(hits, n / 200);
}

INSTANTIATE_TEST_SUITE_P(CcdExact, Adversarial, testing::Range(0, kCategories));

TEST(CcdExact, CoordinatesFromTinyToHugeGetTheVerdictOfTheOracle) {
  Random r(77);
  for (int i = 0; i < 400; ++i) {
    const ContactKind kind = i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge;
    Query q = adversarial(r, integer(r, 0, kCategories - 1), kind);
    const int lowest = i % 3 == 0 ? -990 : -60, highest = i % 3 == 0 ? 990 : 60;
    for (auto* x : {&q.x_t0, &q.x_t1})
      for (Vec3& v : *x)
        if (integer(r, 0, 3) == 0) v *= std::ldexp(1.0, integer(r, lowest, highest));
    EXPECT_EQ(collides(q), oracle(q)) << text(q);
  }
}

TEST(CcdExact, ScalingByAPowerOfTwoNeverChangesVerdictOrTime) {
  Random r(5);
  for (int i = 0; i < 4000; ++i) {
    Query q =
        adversarial(r, i % 9, i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge);
    double toi = 0.0, scaled_toi = 0.0;
    const bool hit = collides(q, toi);
    const double scale = std::ldexp(1.0, integer(r, -1000, 1000));
    for (auto* x : {&q.x_t0, &q.x_t1})
      for (Vec3& v : *x) v *= scale;
    ASSERT_EQ(collides(q, scaled_toi), hit) << text(q);
    if (hit) {
      ASSERT_EQ(scaled_toi, toi) << text(q);
    }
  }
}

TEST(CcdExact, RelabellingNeverChangesVerdictOrTime) {
  Random r(6);
  for (int i = 0; i < 16000; ++i) {
    const ContactKind kind = i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge;
    const Query q = adversarial(r, i % kCategories, kind);
    std::array<int, 4> order{0, 1, 2, 3};
    if (kind == ContactKind::point_triangle) {
      std::shuffle(order.begin() + 1, order.end(), r);
    } else {
      if (integer(r, 0, 1) != 0) std::swap(order[0], order[1]);
      if (integer(r, 0, 1) != 0) std::swap(order[2], order[3]);
      if (integer(r, 0, 1) != 0) order = {order[2], order[3], order[0], order[1]};
    }
    Query other = q;
    for (int k = 0; k < 4; ++k) other.x_t0[k] = q.x_t0[order[k]], other.x_t1[k] = q.x_t1[order[k]];
    double toi = 0.0, other_toi = 0.0;
    const bool hit = collides(q, toi);
    ASSERT_EQ(collides(other, other_toi), hit) << text(q);
    if (hit) {
      ASSERT_EQ(other_toi, toi) << text(q);
    }
  }
}

TEST(CcdExact, TimeReversalNeverChangesTheVerdict) {
  Random r(7);
  for (int i = 0; i < 16000; ++i) {
    Query q = adversarial(r, i % kCategories,
                          i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge);
    const bool hit = collides(q);
    std::swap(q.x_t0, q.x_t1);
    ASSERT_EQ(collides(q), hit) << text(q);
  }
}

TEST(CcdExact, TheTimeOfImpactIsNeverLateAndHalvesAtDoubleSpeed) {
  Random r(8);
  for (int i = 0; i < 8000; ++i) {
    Query q =
        adversarial(r, i % 9, i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge);
    double toi = 0.0, fast_toi = 0.0;
    if (!collides(q, toi)) continue;
    ASSERT_GE(toi, 0.0);
    ASSERT_LE(toi, 1.0);
    // Integers: the doubled motion is exact, and so is half a double.
    for (int k = 0; k < 4; ++k) q.x_t1[k] = 2.0 * q.x_t1[k] - q.x_t0[k];
    if (i % 9 == 5) continue;  // nudged: not integers
    ASSERT_TRUE(collides(q, fast_toi)) << text(q);
    ASSERT_EQ(fast_toi, 0.5 * toi) << text(q);
  }
}

Query falling_point(double from, double to) {
  Query q;
  q.kind = ContactKind::point_triangle;
  q.x_t0 = {Vec3(0.25, 0.25, from), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  q.x_t1 = q.x_t0;
  q.x_t1[0].z() = to;
  return q;
}

TEST(CcdExact, TouchingAtTheLastInstantCountsAsAHit) {
  double toi = 0.0;
  EXPECT_TRUE(collides(falling_point(1.0, 0.0), toi));
  EXPECT_EQ(toi, 1.0);
  EXPECT_FALSE(collides(falling_point(1.0, std::numeric_limits<double>::denorm_min())));
}

TEST(CcdExact, TouchingAtTheFirstInstantCountsAsAHit) {
  double toi = 1.0;
  EXPECT_TRUE(collides(falling_point(0.0, 5.0), toi));
  EXPECT_EQ(toi, 0.0);
}

TEST(CcdExact, ATimeThatIsNoDoubleIsRoundedDown) {
  double toi = 0.0;
  EXPECT_TRUE(collides(falling_point(1.0, -2.0), toi));
  EXPECT_EQ(toi, 1.0 / 3.0);  // the double below 1/3
  EXPECT_TRUE(collides(falling_point(1.0, -4.0), toi));
  EXPECT_EQ(toi, std::nextafter(0.2, 0.0));  // the double 0.2 is above 1/5
}

TEST(CcdExact, EveryStageIsUsedAndCounted) {
  Random r(9);
  CcdExactStages stages;
  std::vector<Query> queries;
  std::vector<double> toi(4000);
  for (int i = 0; i < 4000; ++i)
    queries.push_back(adversarial(r, i % kCategories, ContactKind::edge_edge));
  find_times_counting_stages(queries, toi, stages);
  EXPECT_GT(stages.separated, 0u);
  EXPECT_GT(stages.never_coplanar, 0u);
  EXPECT_GT(stages.isolated, 0u);
  EXPECT_GT(stages.exact, 0u);
  EXPECT_EQ(stages.separated + stages.never_coplanar + stages.isolated + stages.exact, 4000u);
}

TEST(CcdExact, AQueryThatIsNotFiniteIsRefusedWithTheVertex) {
  Query q = falling_point(1.0, 0.0);
  q.x_t1[2].y() = std::numeric_limits<double>::quiet_NaN();
  double toi = 0.0;
  try {
    collides(q, toi);
    FAIL() << "accepted a NaN";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("vertex 2"), std::string::npos) << error.what();
  }
}

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

TEST(Cubic, RootsAnUlpApartAreToldApartAndNearMissesAreNoRoots) {
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

struct Surface {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, 0.0, 0}; }
};

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
    if (collides(query_of(a, b, c))) out.push_back(c.vertex);
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
  EXPECT_EQ(contacts.size(), 1u) << text(q);
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

TEST(FindContacts, AContactFromTheFirstInstantHasAUnitNormalAgainstTheMotion) {
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
    const Query q = i % 4 < 2 ? uniform(r, kind, 1.0) : adversarial(r, i % 9, kind);
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
        EXPECT_LE(c.distance, sampled * scale + 4 * rounding) << text(q);
        EXPECT_GE(c.distance, (sampled - 3.0 * size / kSamples) * scale - 4 * rounding) << text(q);
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
  find_proximities(a.view(), b.view(), pairs, kReach, contacts);
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

TEST(FindProximities, TouchingPairsGetTheNormalOfTheTriangleFromTheSideTheyComeFrom) {
  Query q = falling_point(0.0, -1.0);
  Surface a, b;
  a.x_t0 = {q.x_t0[0]}, a.x_t1 = {q.x_t1[0]};
  b.x_t0.assign(q.x_t0.begin() + 1, q.x_t0.end()), b.x_t1 = b.x_t0;
  b.triangles = {{0, 1, 2}};
  CandidatePairs pairs;
  pairs.point_triangle = {{0, 0}};
  std::vector<Contact> contacts;
  find_proximities(a.view(), b.view(), pairs, 0.01, contacts);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR((contacts[0].normal - Vec3(0, 0, 1)).norm(), 0.0, 1e-15);
  EXPECT_EQ(contacts[0].gap, 0.0);
}

}  // namespace
}  // namespace selvedge
